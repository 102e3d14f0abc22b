"""Why photos cannot be placed: each possible cause with its evidence, the likeliest first."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..arrays import Array
from ..checks.pair_geometry import common_homography, least_baseline
from .checks import AROUND, OVERLAP_MATCHES, SMALLEST_ANGLE
from .photo import Photo
from .trial import ZOOM, Trial, agreeing_matches

# Share of a pair's matches that one homography must explain, within this share of the long side, for the photos to
# count as taken from one place.
_ALL = 0.85
_HOMOGRAPHY_TOLERANCE = 0.004
# Limits above which a measurement points to its cause.
# Measured, share of twins: rendered print 0.0, a letter 0.10; dots in rows on a printed desk 0.42, on a clipboard
# before gravel 0.52, on a blank desk 0.98.
_REPEATED = 0.25
# Relative to the photo's long side, and at least in pixels, because small photos have no finer detail. Measured: sharp
# photos 0.0008 to 0.0026 (0.9 to 1.7 pixels), blurred by 6 pixels of 640 0.0076 (4.9).
_FINEST = 0.0045
_FINEST_PIXELS = 3.0
# A photo of blank paper has some tens of features, one of a printed page thousands.
_FEW_FEATURES = 300
# Matches of a sample of 600, and their ratio to the matches of the unmirrored photos: symmetric print matches both
# ways. Measured with every other photo mirrored: 348 to 452 against 23, otherwise at most 31 against 170.
_MIRRORED = 60
_MIRRORED_RATIO = 3.0
# A lens for each photo explains something if the excess of its error falls below this share; an excess below the second
# value, and an angle below the third (degrees), count as that much. Choices.
_EXPLAINED, _LEAST_EXCESS, _LEAST_DEGREES = 0.5, 0.1, 1e-6
# A second cause is named if its likelihood is at least this share of the first one's.
_NEAR = 0.5
# No measurement makes a cause likelier than this: they are of different kinds, and none is proof.
_MOST_LIKELY = 4.0


@dataclass(frozen=True)
class Cause:
    """A possible cause of photos that cannot be placed.

    Attributes
    ----------
    claim : str
        What is wrong and what was measured: the start of a sentence, without its full stop.
    remedy : str
        What to do about it, the rest of that sentence.
    likelihood : float
        The measurement relative to the limit above which it points to the cause.
    evidence : dict
        The figures, for the log.
    explains_few_points : bool
        Whether this cause alone explains why a model has no depth.
    """

    claim: str
    remedy: str
    likelihood: float
    evidence: dict[str, Any] = field(default_factory=dict)
    explains_few_points: bool = False


def ranked(causes: Sequence[Cause | None]) -> list[Cause]:
    """The causes that have evidence, the likeliest first."""
    found = (cause for cause in causes if cause is not None and cause.likelihood > 0)
    return sorted(found, key=lambda cause: -cause.likelihood)


def sentence(causes: Sequence[Cause]) -> str:
    """The first cause with its remedy, and the second if it is nearly as likely.

    Parameters
    ----------
    causes : sequence of Cause
        Ranked; at least one.
    """
    first, *others = causes
    text = f"{first.claim}: {first.remedy}."
    if others and others[0].likelihood >= _NEAR * first.likelihood:
        text += f" Or {others[0].claim[:1].lower()}{others[0].claim[1:]}: then {others[0].remedy}."
    return text


def possible_causes(
    photos: Sequence[Photo], arrays: Mapping[str, NDArray[Any]], shared: Trial, own: Trial | None, look: dict[str, Any]
) -> list[Cause]:
    """All causes that have evidence, the likeliest first; at least one.

    Parameters
    ----------
    photos : sequence of Photo
    arrays : dict
        Every match, as the worker wrote them.
    shared, own : Trial
        With one lens for all photos of a camera, and with one for each photo if that was tried.
    look : dict
        The result of the worker's closer look.
    """
    agreeing = agreeing_matches(dict(arrays), len(photos))
    causes = [
        too_near(photos, arrays),
        repeated_print(look["repeated"]),
        blurred(photos, look["finest_pixels"]),
        little_print(look["features"]),
        mirrored(photos, agreeing, look["mirrored"]),
        zoomed(shared, own),
        moved(shared, len(photos)),
    ]
    if len(shared.placed) < len(photos):
        causes += [different_things(photos, agreeing), too_far(agreeing)]
    found = ranked(causes)
    return found or [Cause("The photos fit together too poorly", AROUND, 0.0)]


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
        min(SMALLEST_ANGLE / max(angle, _LEAST_DEGREES), _MOST_LIKELY),
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


def repeated_print(repeated: Sequence[float]) -> Cause | None:
    """Features that look like others in the same photo, which matching cannot distinguish."""
    share = float(np.median(repeated))
    if share < _REPEATED:
        return None
    return Cause(
        f"The same print seems to repeat over the sheet ({100 * share:.0f} % of the places in a photo look the same "
        "as another place in it), so places are mistaken for each other",
        "lay the sheet on a newspaper or another print without repetition, leave it in view all around, and "
        "photograph the sheet again",
        min(share / _REPEATED, _MOST_LIKELY),
        {"repeated_share": share},
    )


def blurred(photos: Sequence[Photo], finest_pixels: Sequence[float]) -> Cause | None:
    """Photos whose finest details are large."""
    allowed = np.array([max(_FINEST * max(photo.width, photo.height), _FINEST_PIXELS) for photo in photos])
    excess = np.array(finest_pixels) / allowed
    median = float(np.median(excess))
    if median < 1:
        return None
    worst = [photos[index].name for index in np.argsort(-excess, kind="stable")[:3]]
    return Cause(
        f"The photos seem to be blurred or out of focus (their finest details are {np.median(finest_pixels):.0f} "
        f"pixels wide, most of all in {', '.join(worst)})",
        "take sharp photos in good light, with the camera held still",
        min(2 * median, _MOST_LIKELY),
        {"finest_over_allowed": median},
    )


def little_print(features: Sequence[int]) -> Cause | None:
    """Photos in which there is hardly anything to recognise."""
    median = int(np.median(features))
    if median >= _FEW_FEATURES:
        return None
    return Cause(
        f"There is too little print to go by (only {median} places in a photo are distinctive)",
        "lay the sheet on a newspaper or another printed surface, leave it in view all around, and "
        "photograph the sheet again",
        min(_FEW_FEATURES / max(median, 1), _MOST_LIKELY),
        {"features": median},
    )


def mirrored(photos: Sequence[Photo], agreeing: NDArray[np.int64], found: Sequence[Sequence[int]]) -> Cause | None:
    """Photos that match the others once they are mirrored, as a selfie camera's are."""
    names = [photos[index].name for index in mirrored_photos(agreeing, found)]
    if not names:
        return None
    return Cause(
        f"Some photos seem to be mirrored ({', '.join(names)} and the others match only with left and right exchanged)",
        "leave these out, or use the photos of the back camera instead of those of a selfie camera",
        _MOST_LIKELY,
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


def zoomed(shared: Trial, own: Trial | None) -> Cause | None:
    """A lens for each photo explains more, but not enough."""
    if own is None or own.model is None:
        return None
    low, high = own.zoom_range()
    more = len(own.placed) > len(shared.placed) or (shared.excess > 1 and own.excess < _EXPLAINED * shared.excess)
    if high < ZOOM * low or not more:
        return None
    return Cause(
        f"The zoom seems to differ between the photos (by a factor of {high / low:.2f}), and a lens for each photo "
        "does not explain everything",
        "photograph the sheet again with one zoom for all photos",
        min(shared.excess / max(own.excess, _LEAST_EXCESS), 1.0 if own.useful is None else _MOST_LIKELY),
        {"zoom": high / low},
    )


def moved(trial: Trial, photos: int) -> Cause | None:
    """A sheet that moved or bent between photos: structure from motion then succeeds, but on neither state."""
    if trial.excess <= 1 or trial.model is None:
        return None
    share = len(trial.placed) / photos
    others = odd_ones([camera.name for camera in trial.model.cameras], trial.contradiction)
    if others:
        claim = (
            f"The sheet seems to have moved or bent between the photos ({', '.join(others)} show it differently than "
            "the rest)"
        )
    else:
        claim = (
            "The sheet seems to have moved or bent between the photos, or these are frames of a video that the camera "
            "stabilised (most of the photos contradict each other)"
        )
    return Cause(
        claim,
        "photograph it again without touching it, or use only photos between which it did not move",
        min(trial.excess / 2, 2.0 if others else 1.0) * share,
        {"contradiction_over_limit": trial.excess, "odd_ones": others},
    )


def odd_ones(names: Sequence[str], contradiction: Array) -> list[str]:
    """The smaller of two groups of photos that contradict each other but hardly themselves."""
    side = np.linalg.eigh(contradiction)[1][:, 0] > 0
    across = side[:, None] != side
    within = ~across & ~np.eye(len(side), dtype=bool)
    if not across.any() or (within.any() and contradiction[across].mean() < 3 * contradiction[within].mean()):
        return []
    fewer = side if 2 * np.count_nonzero(side) <= len(side) else ~side
    return [name for name, odd in zip(names, fewer) if odd]
