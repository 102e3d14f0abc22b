"""What a usable model must contain, and the figures that describe it."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import UnusablePhotos
from ..sparse_model import FEWEST_VIEWS, SparseModel
from .photo import Photo

# Relative to the photo's long side; the same bounds as in the worker, which cannot import them.
SANE_FOCAL_LENGTHS = (0.4, 3.0)
# The worker's name for its last attempt, which keeps a typical focal length if EXIF has none.
GUESSED = "fixed focal length"

# Points in at least three photos; the smallest usable set of three small photos has several hundred.
_FEWEST_POINTS = 100
# Degrees between the directions from which a point is seen, median over the points: 20 and more in usual photos.
SMALLEST_ANGLE = 2.0
# Agreeing matches that a pair of overlapping photos has at least.
OVERLAP_MATCHES = 60

AROUND = "photograph the sheet from 5 to 10 places around it, each photo overlapping the next by more than half"


def believable_focal_length(photo: Photo) -> float | None:
    """The focal length in pixels from EXIF, None if there is none or no camera could have it."""
    focal = photo.focal_length_pixels
    low, high = SANE_FOCAL_LENGTHS
    return focal if focal is not None and low < focal / max(photo.width, photo.height) < high else None


def useful_points(model: SparseModel) -> SparseModel:
    """The model with only the points seen in at least three photos.

    Raises
    ------
    UnusablePhotos
        If there are too few, or all are seen from one place.
    """
    views = model.views_per_point()
    angle = float(np.median(viewing_angles(model.select(views >= 2)))) if (views >= 2).any() else np.inf
    if angle < SMALLEST_ANGLE:
        raise UnusablePhotos(
            "All photos seem to be taken from one place (the directions from which a point is seen differ by "
            f"{angle:.1f} degrees), so they do not show the sheet's shape: {AROUND}."
        )
    useful = model.select(views >= FEWEST_VIEWS)
    if len(useful.points) < _FEWEST_POINTS:
        raise UnusablePhotos(
            f"Only {len(useful.points)} points are seen in three photos, but the sheet's shape needs at least "
            f"{_FEWEST_POINTS}: {AROUND}, sharp and evenly lit."
        )
    return useful


def figures_of(model: SparseModel, dropped: Collection[str]) -> dict[str, Any]:
    """The report's figures for a model and for the photos that are not in it."""
    errors = model.reprojection_errors()
    focal_lengths = [camera.focal_length / max(camera.width, camera.height) for camera in model.cameras]
    return {
        "photos": len(model.cameras) + len(dropped),
        "photos_placed": len(model.cameras),
        "photos_left_out": list(dropped),
        "points": len(model.points),
        "views_per_point_mean": float(model.views_per_point().mean()),
        "reprojection_error_mean_px": float(errors.mean()),
        "reprojection_error_95th_percentile_px": float(np.percentile(errors, 95)),
        "focal_length_over_long_side": float(np.median(focal_lengths)),
        "viewing_angle_median_degrees": float(np.median(viewing_angles(model))),
    }


def viewing_angles(model: SparseModel) -> Array:
    """For each point the largest angle between two directions from which it is seen, in degrees, shape (N,)."""
    seen = np.zeros((len(model.cameras), len(model.points)), bool)
    seen[model.observed_camera, model.observed_point] = True
    rays = model.points - np.array([camera.center for camera in model.cameras])[:, None]
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    smallest_cosine = np.ones(len(model.points))
    for first in range(len(rays)):
        cosines = np.where(seen[first] & seen[first + 1 :], (rays[first] * rays[first + 1 :]).sum(-1), 1.0)
        smallest_cosine = np.minimum(smallest_cosine, cosines.min(0, initial=1.0))
    return np.degrees(np.arccos(smallest_cosine.clip(-1, 1)))
