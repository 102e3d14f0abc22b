"""What comes of the attempts to place photos: a result with its warnings, or a failure that names the cause."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.photos import FEWEST_PHOTOS, Photo
from .causes import MIRRORED_MATCHES, Cause, sentence
from .checks import AROUND, GUESSED, OVERLAP_MATCHES, believable_focal_length, figures_of
from .result import SfmResult
from .trial import ZOOM, Trial


def result_of(
    photos: Sequence[Photo],
    arrays: dict[str, NDArray[Any]],
    trials: Sequence[Trial],
    chosen: Trial,
    mirrored: Sequence[Sequence[int]],
) -> SfmResult:
    """The chosen one of the trials, with what the user should know of it.

    Parameters
    ----------
    photos : sequence of Photo
    arrays : dict
        Every match, as the worker wrote them.
    trials : sequence of Trial
        All that was tried.
    chosen : Trial
        One that serves.
    mirrored : sequence of (int, int, int)
        Of pairs of photos, how many features agree once one of them is mirrored.
    """
    assert chosen.useful is not None
    dropped = {
        photo.name: _why_dropped(index, arrays, mirrored)
        for index, photo in enumerate(photos)
        if index not in chosen.placed
    }
    warnings = [f"{name} is left out: {why}." for name, why in dropped.items()]
    low, high = chosen.zoom_range()
    if high > ZOOM * low:
        lenses = "each photo has" if chosen is not trials[0] else "photos of each focal length in the EXIF data have"
        warnings.append(
            f"The zoom differs between the photos (focal lengths from {low:.2f} to {high:.2f} of the long side): "
            f"{lenses} a lens of its own; the same zoom for all is more accurate."
        )
    guessed = chosen.way == GUESSED and any(believable_focal_length(photo) is None for photo in photos)
    if guessed:
        warnings.append(
            "The camera's focal length could not be found and is guessed, which can bend the page and change its "
            f"proportions: give photos as the camera wrote them, with their EXIF data, or {AROUND}."
        )
    figures = figures_of(chosen.useful, dropped) | {"focal_length_guessed": guessed}
    if len(trials) > 1:
        figures["tried"] = [trial.figures() for trial in trials]
    return SfmResult(chosen.useful, tuple(warnings), figures)


def failure(photos: Sequence[Photo], trial: Trial, causes: Sequence[Cause]) -> str:
    """What is said when no attempt serves: what is missing, the likely cause with its evidence, what to do.

    Parameters
    ----------
    photos : sequence of Photo
    trial : Trial
        The first one, with one lens for all photos of a camera.
    causes : sequence of Cause
        The likeliest first.
    """
    count = len(trial.placed)
    missing = [photo.name for index, photo in enumerate(photos) if index not in trial.placed]
    if (trial.useful is not None and trial.excess <= 1) or count < FEWEST_PHOTOS:
        these = f"; these do not: {', '.join(missing)}" if count >= FEWEST_PHOTOS else ""
        some = f"Only {count}" if count else "None"
        return f"{some} of {len(photos)} photos fit together{these}. {sentence(causes)}"
    if trial.excess > 1:
        return f"The photos contradict each other. {sentence(causes)}"
    return sentence(causes) if causes[0].explains_few_points else f"{trial.weakness} {sentence(causes)}"


def _why_dropped(index: int, arrays: dict[str, NDArray[Any]], mirrored: Sequence[Sequence[int]]) -> str:
    pairs = arrays["match_pair"][arrays["match_verified"]]
    mine = np.count_nonzero((pairs == index).any(1))
    if any(index in pair and count >= MIRRORED_MATCHES for *pair, count in mirrored):
        return "it is mirrored, left and right exchanged; give it as the back camera took it"
    if mine < OVERLAP_MATCHES:
        return f"it has hardly anything in common with the other photos ({mine} matches)"
    return f"its {mine} matches with the other photos do not fit their model"
