"""Causes that the matches between photos show: where they were taken from, what they show, mirrored ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..checks.pair_geometry import common_homography, least_baseline
from .cause import MOST_LIKELY, Cause
from .checks import AROUND, OVERLAP_MATCHES, SMALLEST_ANGLE
from .photo import Photo

# Share of a pair's matches that one homography must explain, within this share of the long side, for the photos to
# count as taken from one place.
_ALL = 0.85
_HOMOGRAPHY_TOLERANCE = 0.004
# Matches of a sample of 600, and their ratio to the matches of the unmirrored photos: symmetric print matches both
# ways. Measured with every other photo mirrored: 348 to 452 against 23, otherwise at most 31 against 170.
_MIRRORED = 60
_MIRRORED_RATIO = 3.0
# A smaller angle, in degrees, counts as this one; a choice.
_LEAST_DEGREES = 1e-6


def too_near(photos: Sequence[Photo], arrays: Mapping[str, NDArray[Any]]) -> Cause | None:
    """All photos are from one place, or from places so near each other that they show no depth."""
    pairs = arrays["match_pair"]
    shares, angles = [], []
    for first, second in np.unique(pairs, axis=0):
        mine = (pairs == (first, second)).all(1) & arrays["match_verified"]
        if np.count_nonzero(mine) < OVERLAP_MATCHES:
            continue
        width, height = photos[first].width, photos[first].height
        homography, share = common_homography(arrays["match_pixel"][mine], _HOMOGRAPHY_TOLERANCE * max(width, height))
        shares.append(share)
        angles.append(np.degrees(least_baseline(homography, width, height)))
    if len(shares) < 2 or np.median(shares) < _ALL or np.median(angles) >= SMALLEST_ANGLE:
        return None
    angle = float(np.median(angles))
    return Cause(
        f"All photos seem to be taken from one place, or from places too near each other (about {angle:.1f} degrees "
        "apart as seen from the sheet), so they do not show its shape",
        "walk around the sheet, and move the camera by a hand's breadth or more between two photos",
        min(SMALLEST_ANGLE / max(angle, _LEAST_DEGREES), MOST_LIKELY),
        {"homography_share": float(np.median(shares)), "baseline_degrees": angle},
        explains_few_points=True,
    )


def too_far(agreeing: NDArray[np.int64]) -> Cause | None:
    """Photos that have too little in common; also the cause if there is no evidence for another."""
    pairs = agreeing[np.triu_indices(len(agreeing), 1)]
    overlapping = int(np.count_nonzero(pairs >= OVERLAP_MATCHES))
    return Cause(
        f"The photos seem to lie too far apart (of {len(pairs)} pairs of photos {overlapping} have enough in common)",
        AROUND,
        1 - overlapping / len(pairs),
        {"pairs_overlapping": overlapping, "pairs": len(pairs)},
    )


def different_things(photos: Sequence[Photo], agreeing: NDArray[np.int64]) -> Cause | None:
    """Groups of photos that match only among themselves."""
    count, group = sparse.csgraph.connected_components(agreeing >= OVERLAP_MATCHES, directed=False)
    if count == 1:
        return None
    groups = sorted((np.flatnonzero(group == each) for each in range(count)), key=len, reverse=True)
    named = [", ".join(photos[index].name for index in members) for members in groups if len(members) > 1]
    if len(named) > 1:
        claim = f"The photos show different things, which match only among themselves ({'; '.join(named)})"
        likelihood = 3.0
    elif named:
        others = ", ".join(photos[int(members[0])].name for members in groups[1:])
        claim, likelihood = f"Some photos seem to show different things ({others} match none of the others)", 1.0
    else:
        claim, likelihood = "The photos seem to show different things: no two of them have enough in common", 1.0
    return Cause(claim, "put the photos of each document into a folder of their own", likelihood, {"groups": count})


def mirrored(photos: Sequence[Photo], agreeing: NDArray[np.int64], found: Sequence[Sequence[int]]) -> Cause | None:
    """Photos that match the others once they are mirrored, as a selfie camera's are."""
    names = [photos[index].name for index in mirrored_photos(agreeing, found)]
    if not names:
        return None
    return Cause(
        f"Some photos seem to be mirrored ({', '.join(names)} and the others match only with left and right exchanged)",
        "leave these out, or use the photos of the back camera instead of those of a selfie camera",
        MOST_LIKELY,
        {"mirrored": names},
    )


def unconnected(placed: Collection[int], agreeing: NDArray[np.int64]) -> bool:
    """Whether some placed photos have only a few matches, which may be wrong, with the rest.

    Mirrored photos of a nearly flat sheet are placed like that, on their own mirrored sheet.
    """
    among = agreeing[np.ix_(sorted(placed), sorted(placed))] >= OVERLAP_MATCHES
    return len(placed) > 0 and int(sparse.csgraph.connected_components(among, directed=False)[0]) > 1


def mirrored_photos(agreeing: NDArray[np.int64], found: Sequence[Sequence[int]]) -> list[int]:
    """The photos that match the majority of the others only when mirrored.

    Parameters
    ----------
    agreeing : (N, N) int array
        Matches of each two photos as they are.
    found : sequence of (int, int, int, int)
        Two photos, how many features agree if one of them is mirrored, and how many agree as they are.
    """
    linked = np.zeros(agreeing.shape, bool)
    for first, second, mirrored_count, plain_count in found:
        linked[first, second] = mirrored_count >= max(_MIRRORED, _MIRRORED_RATIO * plain_count)
    linked |= linked.T
    # The photos fall into two groups: they match mirrored between the groups and unmirrored within each.
    _, side = sparse.csgraph.connected_components(agreeing >= OVERLAP_MATCHES, directed=False)
    return np.flatnonzero((side != np.bincount(side).argmax()) & linked.any(1)).tolist()
