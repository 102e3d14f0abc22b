"""What the matches of two photos alone reveal about the cameras: a common homography, and the baseline it implies."""

from __future__ import annotations

import numpy as np

from ..arrays import Array

# With four matches per draw and half of the matches wrong, 300 draws miss a good one once in 10**8.
_DRAWS = 300
_SEED = 0
# Possible focal lengths relative to the long side, in steps of a tenth: from the widest lens of a phone to a long one.
_FOCAL_LENGTHS = np.geomspace(0.4, 3.0, 22)
_SAMPLE = 4  # matches that determine a homography
# A number below this, in an expression of about 1, is rounding.
_ROUNDING = 1e-12


def common_homography(matches: Array, tolerance: float) -> tuple[Array, float]:
    """The homography that maps the most places of one photo to their places in the other.

    Photos from one place always have one that maps all places; so do photos of a plane.

    Parameters
    ----------
    matches : (M, 4) array
        x, y in the first and x, y in the second photo, pixels; M at least 4.
    tolerance : float
        Largest error of a mapped place, pixels.

    Returns
    -------
    homography : (3, 3) array
        With last entry 1 or, if that is 0, of norm 1.
    share : float
        The share of the matches within the tolerance.
    """
    random = np.random.default_rng(_SEED)
    drawn = np.array([random.choice(len(matches), _SAMPLE, replace=False) for _ in range(_DRAWS)])
    scale = np.abs(matches).max() or 1.0
    best = _fit(matches[None] / scale)[0]
    kept = _errors(best[None], matches / scale)[0] < tolerance / scale
    errors = _errors(_fit(matches[drawn] / scale), matches / scale)
    within = errors < tolerance / scale
    most = within[within.sum(1).argmax()]
    if most.sum() > kept.sum():
        best, kept = _fit(matches[None, most] / scale)[0], most
        again = _errors(best[None], matches / scale)[0] < tolerance / scale
        if again.sum() >= kept.sum():
            best, kept = _fit(matches[None, again] / scale)[0], again
    unscaled = np.diag([scale, scale, 1]) @ best @ np.diag([1 / scale, 1 / scale, 1])
    last = unscaled[2, 2]
    return unscaled / (last if abs(last) > _ROUNDING else np.linalg.norm(unscaled)), float(kept.mean())


def least_baseline(homography: Array, width: int, height: int) -> float:
    """The least distance between two cameras, relative to that to the plane, that can explain a homography.

    The homography of a camera that only turned is, through its lens, a rotation. Stretch that differs between
    directions comes from movement; the focal length is assumed to be the one that explains most of it as turning.

    Parameters
    ----------
    homography : (3, 3) array
        Between the pixels of two photos of one camera.
    width, height : int
        Of both photos.

    Returns
    -------
    float
        About the angle in radians between the directions from which a point is seen.
    """
    least = np.inf
    for focal in _FOCAL_LENGTHS * max(width, height):
        lens = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        sizes = np.linalg.svd(np.linalg.inv(lens) @ homography @ lens, compute_uv=False)
        if sizes[2] > 0:
            least = min(least, float(sizes[0] / sizes[2] - 1))
    return least


def _fit(matches: Array) -> Array:
    """Homographies (K, 3, 3) of K groups of matches, (K, M, 4), by least squares on the linear equations."""
    x, y, u, v = np.moveaxis(matches, 2, 0)
    one, none = np.ones_like(x), np.zeros_like(x)
    rows = np.concatenate(
        [
            np.stack([x, y, one, none, none, none, -u * x, -u * y, -u], 2),
            np.stack([none, none, none, x, y, one, -v * x, -v * y, -v], 2),
        ],
        1,
    )
    return np.linalg.eigh(np.swapaxes(rows, 1, 2) @ rows)[1][:, :, 0].reshape(-1, 3, 3)


def _errors(homographies: Array, matches: Array) -> Array:
    """The error of each match (M, 4) under each homography, (K, M); infinite if it crosses the horizon."""
    places = np.hstack([matches[:, :2], np.ones((len(matches), 1))])
    carried = np.einsum("kij,mj->kmi", homographies, places)
    depth = np.where(np.abs(carried[..., 2]) > _ROUNDING, carried[..., 2], np.nan)
    errors = np.hypot(carried[..., 0] / depth - matches[:, 2], carried[..., 1] / depth - matches[:, 3])
    return np.where(np.isfinite(errors), errors, np.inf)
