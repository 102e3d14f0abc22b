"""A generated scene whose photos are placed, for what is fitted on such scenes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.errors import OrigamiError
from ...core.sparse_model import SparseModel
from ...origami_addon import steps
from ...origami_addon.files.photo_pixels import PhotoPixels
from ...origami_addon.files.photos import gather
from ...origami_addon.report import Report
from .measure import settings_for
from .shapes import Array

# As in the commands that place the photos, see `fit_evidence.py` and `fit_judgement.py`.
_THREADS, _IMAGE_SIZE = 1, 1200


@dataclass(frozen=True)
class PlacedScene:
    """What is known of a scene.

    Attributes
    ----------
    work : Work
        For further steps.
    model : SparseModel
    pixels : PhotoPixels
        Of the model's cameras.
    outlines : list of (K, 2) arrays
        The sheet's true outline in the photo of each camera.
    """

    work: steps.Work
    model: SparseModel
    pixels: PhotoPixels
    outlines: list[Array]


def placed_scene(folder: Path, work: Path) -> PlacedScene | None:
    """The scene in a folder, whose placed photos are kept in ``work``; None if its photos cannot be placed."""
    photos, _ = gather([folder / "photos"])
    step = steps.Work(photos, work, settings_for(_THREADS, _IMAGE_SIZE), Report({}))
    try:
        model = steps.place_photos(step)
    except OrigamiError:
        return None
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    outlines = {photo["file"]: np.array(photo["outline"]) for photo in truth["photos"]}
    return PlacedScene(step, model, PhotoPixels(photos, model), [outlines[camera.name] for camera in model.cameras])
