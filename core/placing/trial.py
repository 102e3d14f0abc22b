"""Measures one attempt to place the photos: what it placed, and the evidence against it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..checks.rigidity import contradicting_area
from ..errors import UnusablePhotos
from ..sparse_model import SparseModel
from .checks import OVERLAP_MATCHES, useful_points
from .photo import FEWEST_PHOTOS, Photo

# Share of the photos: if more cannot be placed, the others count as photos of something else.
_MOST_DROPPED = 1 / 3

# Share of the area common to two photos in which groups of matches contradict the model (core/checks/rigidity.py), over
# all pairs: of the matches verified by a pair's own geometry, and of all matches. Measured: six real and rendered sets
# at most 0.0 and 0.0094; 57 generated tables 0.0 and 0.0, whatever repeats in them (1200 pixels), but a receipt on wood
# at 1600 pixels 0.0074 and 0.0086. The sheet moved by 3 to 30 mm and 1 to 5 degrees (22 tables of
# `tabletops/generate.py --change moved`): if the cameras are wrong for the sheet (11) 0.011 to 0.51 and 0.024 to 0.53,
# in one 0.0 and 0.030; if they follow the sheet, which does not harm the page, from 0.0. Bent by 4 to 14 degrees: 11 of
# 22 at least 0.0188 or 0.024, the others at most 0.0045 and 0.0085, because bundle adjustment spreads the change over
# the cameras.
_MOST_CONTRADICTING = {"verified": 0.01, "all": 0.016}

# Mean reprojection error, relative to the photo's long side, above which a lens for each photo is tried. Measured: nine
# good sets at most 0.00044; a zoom of 1.12 in every other photo, which a shared lens turns into wrong poses, 0.00066.
_WORTH_A_TRY = 0.00055
# A lens for each photo is only kept if the focal lengths differ by this factor.
ZOOM = 1.05
# ... and, if a shared lens placed as many photos without contradiction, if the error falls to this share.
_BETTER = 0.7
# ... or, if matches contradict the shared lens, if the contradiction falls to this share. Measured: with zoom to 0.0,
# with a sheet that moved or bent to 0.8 and 1.0.
_LESS_CONTRADICTION = 0.5


@dataclass(frozen=True)
class Trial:
    """The result of one attempt to place the photos.

    Attributes
    ----------
    way : str
        The worker's name for it.
    model : SparseModel or None
        All its points.
    useful : SparseModel or None
        The points seen in at least three photos; None if the model has too few of them or no depth.
    placed : frozenset of int
        Indices of photos.
    weakness : str
        A sentence if the model's own points do not suffice, otherwise empty.
    contradiction : (C, C) array
        For each pair of cameras the share of their common area that contradicts the model, for whichever matches
        contradict more.
    excess : float
        The contradicting share over all pairs relative to the limit: at 1 or more the model is not credible.
    error : float
        Mean reprojection error relative to the photo's long side; infinite without a model.
    """

    way: str
    model: SparseModel | None
    useful: SparseModel | None
    placed: frozenset[int]
    weakness: str
    contradiction: Array
    excess: float
    error: float

    def places_enough(self, photos: int) -> bool:
        """Whether it places enough of ``count`` photos to leave out the others."""
        placed = len(self.placed)
        return placed >= FEWEST_PHOTOS and photos - placed <= _MOST_DROPPED * photos

    def serves(self, photos: int) -> bool:
        """Whether it is credible and places enough of ``count`` photos."""
        return self.useful is not None and self.excess <= 1 and self.places_enough(photos)

    def zoom_range(self) -> tuple[float, float]:
        """Smallest and largest focal length relative to the photo's long side, (0, 0) without a model."""
        if self.model is None:
            return 0.0, 0.0
        ratios = [camera.focal_length / max(camera.width, camera.height) for camera in self.model.cameras]
        return min(ratios), max(ratios)

    def figures(self) -> dict[str, Any]:
        """For the log and the report."""
        low, high = self.zoom_range()
        return {
            "way": self.way,
            "photos_placed": len(self.placed),
            "points": 0 if self.model is None else len(self.model.points),
            "contradiction_over_limit": round(self.excess, 3),
            "reprojection_error_over_long_side": self.error if np.isfinite(self.error) else None,
            "focal_lengths_over_long_side": [round(low, 4), round(high, 4)],
        }


def measure(way: str, model: SparseModel | None, arrays: dict[str, NDArray[Any]], placed: Sequence[int]) -> Trial:
    """Measure what the worker found.

    Parameters
    ----------
    way : str
    model : SparseModel or None
    arrays : dict
        With every match of the photos, as the worker wrote them.
    placed : sequence of int
        The photo of each camera.
    """
    if model is None or len(model.cameras) < FEWEST_PHOTOS:
        return Trial(way, model, None, frozenset(placed), "", np.zeros((len(placed),) * 2), 0.0, np.inf)
    useful, weakness = None, ""
    try:
        useful = useful_points(model)
    except UnusablePhotos as reason:
        weakness = str(reason)
    contradiction, excess = _contradiction(model, arrays, placed)
    sides = np.array([max(camera.width, camera.height) for camera in model.cameras])
    errors = model.reprojection_errors() / sides[model.observed_camera]
    error = float(errors.mean()) if len(errors) else np.inf
    return Trial(way, model, useful, frozenset(placed), weakness, contradiction, excess, error)


def _contradiction(model: SparseModel, arrays: dict[str, NDArray[Any]], placed: Sequence[int]) -> tuple[Array, float]:
    camera_of_photo = np.full(1 + max(*placed, int(arrays["match_pair"].max(initial=0))), -1)
    camera_of_photo[list(placed)] = np.arange(len(model.cameras))
    pairs = camera_of_photo[arrays["match_pair"]]
    found = []
    for kind, limit in _MOST_CONTRADICTING.items():
        used = (pairs >= 0).all(1) & (arrays["match_verified"] if kind == "verified" else True)
        contradicting, common = contradicting_area(model, pairs[used], arrays["match_pixel"][used])
        excess = float(contradicting.sum() / max(common.sum(), 1) / limit)
        found.append((contradicting / np.maximum(common, 1), excess))
    return max(found, key=lambda each: each[1])


def agreeing_matches(arrays: dict[str, NDArray[Any]], count: int) -> NDArray[np.int64]:
    """For each pair of photos the number of matches that agree with the pair's own geometry, shape (count, count)."""
    pairs = arrays["match_pair"][arrays["match_verified"]]
    table = np.zeros((count, count), np.int64)
    np.add.at(table, (pairs[:, 0], pairs[:, 1]), 1)
    return table + table.T


def lenses_may_differ(trial: Trial, photos: Sequence[Photo], arrays: dict[str, NDArray[Any]]) -> bool:
    """Whether a lens for each photo may explain what a shared lens does not.

    Parameters
    ----------
    trial : Trial
        With the lenses shared.
    photos : sequence of Photo
    arrays : dict
        Every match, as the worker wrote them.
    """
    overlaps = (agreeing_matches(arrays, len(photos)) >= OVERLAP_MATCHES).sum(1)
    missed = [index for index in range(len(photos)) if index not in trial.placed and overlaps[index]]
    return np.count_nonzero(overlaps) >= FEWEST_PHOTOS and (
        not trial.serves(len(photos)) or bool(missed) or trial.error > _WORTH_A_TRY
    )


def prefer_own_lenses(shared: Trial, own: Trial, photos: int) -> bool:
    """Whether a lens for each photo is the better explanation."""
    low, high = own.zoom_range()
    if not own.serves(photos) or high < ZOOM * low:
        return False
    if not shared.serves(photos):
        return shared.excess <= 1 or own.excess < _LESS_CONTRADICTION * shared.excess
    return len(own.placed) > len(shared.placed) or (
        len(own.placed) == len(shared.placed) and own.error < _BETTER * shared.error
    )
