"""Whether a model found by structure from motion can be believed, and a sentence where it cannot."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import UnusablePhotos
from ...core.sparse_model import SparseModel
from ..photos import FEWEST_PHOTOS, Photo

if TYPE_CHECKING:
    from .client import SfmResult

SANE_FOCAL_LENGTHS = (0.4, 3.0)
_ENOUGH_POINTS = 300


def judged(
    photos: Sequence[Photo], result: dict[str, Any], arrays: dict[str, NDArray[Any]], model: SparseModel | None
) -> SfmResult:
    """The result for photos placed by the worker.

    Raises
    ------
    UnusablePhotos
        If the model cannot serve.
    """
    from .client import SfmResult

    if model is None or len(model.cameras) < FEWEST_PHOTOS:
        placed = 0 if model is None else len(model.cameras)
        raise UnusablePhotos(
            f"Only {placed} of {len(photos)} photos fit together: they may show different things, or lie too far apart; "
            "photograph one sheet from 5 to 10 places around it, each photo overlapping the next by more than half."
        )
    placed_names = {camera.name for camera in model.cameras}
    dropped = {
        photo.name: "too little in common with the other photos" for photo in photos if photo.name not in placed_names
    }
    warnings = tuple(f"{name} could not be placed: {why}." for name, why in dropped.items())
    views = model.views_per_point()
    enough = (views >= 3).sum() >= _ENOUGH_POINTS
    model = model.select(views >= (3 if enough else 2))
    errors = model.reprojection_errors()
    figures = {
        "photos": float(len(photos)),
        "photos_placed": float(len(model.cameras)),
        "points": float(len(model.points)),
        "reprojection_error_mean_px": float(errors.mean()),
        "reprojection_error_95th_percentile_px": float(np.percentile(errors, 95)),
    }
    return SfmResult(model, dropped, warnings, figures)


def judged_loaded(
    photos: Sequence[Photo], names: Sequence[str], arrays: dict[str, NDArray[Any]], model_dir: Path
) -> SfmResult:
    raise NotImplementedError
