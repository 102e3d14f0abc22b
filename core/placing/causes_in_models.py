"""Causes that the sparse models show: another zoom, a sheet that moved."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from .cause import MOST_LIKELY, Cause
from .trial import ZOOM, Trial

# A lens for each photo explains something if the excess of its error falls below this share; an excess below the second
# value counts as that much. Choices.
_EXPLAINED, _LEAST_EXCESS = 0.5, 0.1


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
        min(shared.excess / max(own.excess, _LEAST_EXCESS), 1.0 if own.useful is None else MOST_LIKELY),
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
