"""Causes that a single photo shows: print that repeats, blur, too little print."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .cause import MOST_LIKELY, Cause
from .photo import Photo

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
        min(share / _REPEATED, MOST_LIKELY),
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
        min(2 * median, MOST_LIKELY),
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
        min(_FEW_FEATURES / max(median, 1), MOST_LIKELY),
        {"features": median},
    )
