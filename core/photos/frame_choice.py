"""Choose the frames of a movie that serve as photos: sharp ones, from everywhere the camera went."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .view import View, likeness

# Twelve photos are the most that the advice for photographers asks for: more cost time and show little more.
FRAMES = 12


def choose_frames(views: Sequence[View], count: int = FRAMES) -> NDArray[np.int64]:
    """The sharpest frame of each stretch of a movie.

    A stretch is an equal share of time and of change: while the camera rests, time passes and nothing new is seen, and
    the change alone would count a passing hand as a journey. No stretch is dropped for being blurred, because its
    frames may be the only ones from that side.

    Parameters
    ----------
    views : sequence of View
        Of frames at equal distances in time.
    count : int
        Number of stretches.

    Returns
    -------
    (K,) int array
        Indices in order, at most ``count``; fewer if there are not so many frames, or one is far from the next.
    """
    frames = len(views)
    if frames <= count:
        return np.arange(frames)
    changes = [max(0.0, 1 - likeness(before, after)) for before, after in pairwise(views)]
    time, journey = np.linspace(0, 1, frames), np.cumsum([0.0, *changes])
    place = (time + journey / journey[-1]) / 2 if journey[-1] > 0 else time
    stretch = np.minimum((place * count).astype(int), count - 1)
    sharpness = np.array([view.sharpness for view in views])
    inside = [np.flatnonzero(stretch == each) for each in np.unique(stretch)]
    return np.array([frames[np.argmax(sharpness[frames])] for frames in inside])
