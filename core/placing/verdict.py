"""The outcome of the attempts to place photos: a result with its warnings, or a failure that names the cause."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from .cause import Cause, sentence
from .checks import AROUND, GUESSED, OVERLAP_MATCHES, believable_focal_length, figures_of
from .photo import FEWEST_PHOTOS, Photo
from .result import SfmResult
from .trial import ZOOM, Trial


def result_of(
    photos: Sequence[Photo],
    agreeing: NDArray[np.int64],
    trials: Sequence[Trial],
    chosen: Trial,
    mirrored: Collection[int],
) -> SfmResult:
    """The chosen trial as a result, with warnings for the user.

    Parameters
    ----------
    photos : sequence of Photo
    agreeing : (N, N) int array
        Agreeing matches of each pair of photos.
    trials : sequence of Trial
        All trials.
    chosen : Trial
        One that serves.
    mirrored : collection of int
        Photos that are mirrored, none of them placed.
    """
    assert chosen.useful is not None
    dropped = {
        photo.name: _why_dropped(int(agreeing[index].sum()), index in mirrored)
        for index, photo in enumerate(photos)
        if index not in chosen.placed
    }
    warnings = [f"{name} is left out: {why}." for name, why in dropped.items()]
    low, high = chosen.zoom_range()
    if high > ZOOM * low:
        between = f"focal lengths from {low:.2f} to {high:.2f} of the long side"
        warnings.append(
            f"The camera or its zoom differs between the photos ({between}), according to their EXIF data and sizes: "
            "the same camera and zoom for all is more accurate."
            if chosen is trials[0]
            else f"The zoom differs between the photos ({between}), so each photo gets its own lens: the "
            "same zoom for all is more accurate."
        )
    guessed = chosen.way == GUESSED and any(believable_focal_length(photo) is None for photo in photos)
    if guessed:
        warnings.append(
            "The camera's focal length could not be found and is guessed, which can bend the page and change its "
            f"proportions: use the photos as the camera wrote them, with their EXIF data, or {AROUND}."
        )
    figures = figures_of(chosen.useful, dropped) | {"focal_length_guessed": guessed}
    if len(trials) > 1:
        figures["tried"] = [trial.figures() for trial in trials]
    return SfmResult(chosen.useful, tuple(warnings), figures)


def failure(photos: Sequence[Photo], trial: Trial, causes: Sequence[Cause]) -> str:
    """The failure if no attempt is usable: what is missing, the likely cause with its evidence, what to do.

    Parameters
    ----------
    photos : sequence of Photo
    trial : Trial
        The best one.
    causes : sequence of Cause
        The likeliest first.
    """
    count = len(trial.placed)
    missing = [photo.name for index, photo in enumerate(photos) if index not in trial.placed]
    if not trial.places_enough(len(photos)):
        these = f"; these do not: {', '.join(missing)}" if count >= FEWEST_PHOTOS else ""
        some = f"Only {count}" if count else "None"
        return f"{some} of {len(photos)} photos fit together{these}. {sentence(causes)}"
    if trial.excess > 1:
        return f"The photos contradict each other. {sentence(causes)}"
    if trial.weakness and causes[0].likelihood < 1:
        return trial.weakness
    if trial.weakness and not causes[0].explains_few_points:
        return f"{trial.weakness} {sentence(causes)}"
    return sentence(causes)


def _why_dropped(matches: int, mirrored: bool) -> str:
    if mirrored:
        return "it is mirrored, so use a photo of the back camera"
    if matches < OVERLAP_MATCHES:
        return f"it has hardly anything in common with the other photos ({matches} matches)"
    return f"its {matches} matches with the other photos do not fit their model"
