"""Whether a model found by structure from motion can be believed, and a sentence where it cannot."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.camera import Array
from ...core.errors import UnusablePhotos
from ...core.rigidity import contradicting_area
from ...core.sparse_model import SparseModel
from ..files.photos import FEWEST_PHOTOS, Photo
from .result import SfmResult

# Over the photo's long side; the worker's own bounds, which it cannot import.
SANE_FOCAL_LENGTHS = (0.4, 3.0)
# What the worker calls its last attempt, which keeps a typical focal length where EXIF tells none.
GUESSED = "fixed focal length"

# Points in at least three photos; the smallest usable set of three small photos has several hundred.
_FEWEST_POINTS = 100
# Degrees between the directions a point is seen from, median over the points: 20 and more in usual photos.
_SMALLEST_ANGLE = 2.0
# Agreeing matches that a pair of overlapping photos has.
_OVERLAP_MATCHES = 60
# Of the photos: when more than these cannot be placed, they are taken for photos of something else.
_MOST_DROPPED = 1 / 3

# Share of the area common to two photos where matches contradict the model together (core/rigidity.py), over all pairs:
# of the matches that a pair's own geometry verified, and of all. Measured: nine good sets at most 0.0023 and 0.0092;
# half of the photos with another bend (a fold of 38 or 30 instead of 42 degrees, a curl a quarter flatter) 0.068 to
# 0.16 and 0.029 to 0.14; with the sheet moved on a printed desk 0.17 to 0.21 and 0.27 to 0.40. A curl 7 % flatter stays
# below both (0.0037, 0.0039): bundle adjustment spreads it over the cameras.
_MOST_CONTRADICTING_VERIFIED = 0.0125
_MOST_CONTRADICTING = 0.05

_AROUND = "photograph the sheet from 5 to 10 places around it, each photo overlapping the next by more than half"


def judge(
    photos: Sequence[Photo], result: dict[str, Any], arrays: dict[str, NDArray[Any]], model: SparseModel | None
) -> SfmResult:
    """What structure from motion found, where it can be believed.

    Parameters
    ----------
    photos : sequence of Photo
    result, arrays : dict
        As the worker wrote them.
    model : SparseModel or None
        The arrays as a model, all its points.

    Raises
    ------
    UnusablePhotos
        If the photos do not show one rigid sheet from several places.
    """
    if model is None or len(model.cameras) < FEWEST_PHOTOS:
        raise UnusablePhotos(_why_no_model(photos, arrays, 0 if model is None else len(model.cameras)))
    placed = set(arrays["photo"].tolist())
    dropped = {photo.name: _why_dropped(index, arrays) for index, photo in enumerate(photos) if index not in placed}
    if len(dropped) > _MOST_DROPPED * len(photos):
        raise UnusablePhotos(
            f"Only {len(placed)} of {len(photos)} photos fit together; these do not: {', '.join(dropped)}. They may "
            f"show something else, or lie too far apart: give each document a folder of its own, and {_AROUND}."
        )
    useful = useful_points(model)
    _check_rigid(photos, arrays, model)
    warnings = [f"{name} is left out: {why}." for name, why in dropped.items()]
    guessed = result["way"] == GUESSED and any(believable_focal_length(photo) is None for photo in photos)
    if guessed:
        warnings.append(
            "The camera's focal length could not be found and is guessed, which can bend the page and change its "
            f"proportions: give photos as the camera wrote them, with their EXIF data, or {_AROUND}."
        )
    return SfmResult(useful, tuple(warnings), figures_of(useful, dropped) | {"focal_length_guessed": guessed})


def believable_focal_length(photo: Photo) -> float | None:
    """The focal length in pixels that EXIF tells, None where it tells none that a camera could have."""
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
    if (views >= 2).any() and np.median(viewing_angles(model.select(views >= 2))) < _SMALLEST_ANGLE:
        raise UnusablePhotos(_one_place())
    useful = model.select(views >= 3)
    if len(useful.points) < _FEWEST_POINTS:
        raise UnusablePhotos(
            f"Only {len(useful.points)} points are seen in three photos, and the sheet's shape needs at least "
            f"{_FEWEST_POINTS}: {_AROUND}, sharp and evenly lit."
        )
    return useful


def figures_of(model: SparseModel, dropped: Collection[str]) -> dict[str, Any]:
    """What the report tells of a model and of the photos that are not in it."""
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
    """For each point the largest angle between two directions it is seen from, in degrees, shape (N,)."""
    seen = np.zeros((len(model.cameras), len(model.points)), bool)
    seen[model.observed_camera, model.observed_point] = True
    rays = model.points - np.array([camera.center for camera in model.cameras])[:, None]
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    smallest_cosine = np.ones(len(model.points))
    for first in range(len(rays)):
        cosines = np.where(seen[first] & seen[first + 1 :], (rays[first] * rays[first + 1 :]).sum(-1), 1.0)
        smallest_cosine = np.minimum(smallest_cosine, cosines.min(0, initial=1.0))
    return np.degrees(np.arccos(smallest_cosine.clip(-1, 1)))


def _check_rigid(photos: Sequence[Photo], arrays: dict[str, NDArray[Any]], model: SparseModel) -> None:
    """A sheet that moved or bent between photos: structure from motion succeeds there, on neither state."""
    camera_of_photo = np.full(len(photos), -1)
    camera_of_photo[arrays["photo"]] = np.arange(len(model.cameras))
    pairs = camera_of_photo[arrays["match_pair"]]
    placed = (pairs >= 0).all(1)
    for kind, limit in (("match_verified", _MOST_CONTRADICTING_VERIFIED), (None, _MOST_CONTRADICTING)):
        used = placed & arrays[kind] if kind else placed
        contradicting, common = contradicting_area(model, pairs[used], arrays["match_pixel"][used])
        if contradicting.sum() > limit * common.sum():
            others = _odd_ones([camera.name for camera in model.cameras], contradicting / np.maximum(common, 1))
            named = f" ({', '.join(others)} show it otherwise than the rest)" if others else ""
            raise UnusablePhotos(
                f"The sheet seems to have moved or bent between the photos{named}: photograph it again without "
                "touching it, or give only photos between which it lay still."
            )


def _odd_ones(names: Sequence[str], contradiction: Array) -> list[str]:
    """The smaller of two groups of photos between which, and hardly within which, there is contradiction."""
    side = np.linalg.eigh(contradiction)[1][:, 0] > 0
    across = side[:, None] != side
    within = ~across & ~np.eye(len(side), dtype=bool)
    if not across.any() or (within.any() and contradiction[across].mean() < 3 * contradiction[within].mean()):
        return []
    fewer = side if 2 * np.count_nonzero(side) <= len(side) else ~side
    return [name for name, odd in zip(names, fewer) if odd]


def _agreeing_matches(arrays: dict[str, NDArray[Any]], count: int) -> NDArray[np.int64]:
    """For each two photos how many matches the pair's own geometry agreed with, shape (count, count)."""
    pairs = arrays["match_pair"][arrays["match_verified"]]
    table = np.zeros((count, count), np.int64)
    np.add.at(table, (pairs[:, 0], pairs[:, 1]), 1)
    return table + table.T


def _why_no_model(photos: Sequence[Photo], arrays: dict[str, NDArray[Any]], placed: int) -> str:
    overlaps = (_agreeing_matches(arrays, len(photos)) >= _OVERLAP_MATCHES).sum(1)
    if np.count_nonzero(overlaps >= 2) >= FEWEST_PHOTOS:
        return _one_place()
    alone = [photo.name for photo, others in zip(photos, overlaps) if others == 0]
    some = f" ({', '.join(alone)} with none of the others)" if 0 < len(alone) < len(photos) else ""
    return (
        f"Only {placed} of {len(photos)} photos fit together{some}: they may show different things, lie too far "
        f"apart, or be blurred; {_AROUND}."
    )


def _one_place() -> str:
    return f"All photos seem to be taken from one place, which does not show the sheet's shape: {_AROUND}."


def _why_dropped(index: int, arrays: dict[str, NDArray[Any]]) -> str:
    pairs = arrays["match_pair"][arrays["match_verified"]]
    mine = np.count_nonzero((pairs == index).any(1))
    if mine < _OVERLAP_MATCHES:
        return f"it has hardly anything in common with the other photos ({mine} matches)"
    return f"its {mine} matches with the other photos do not fit their model"
