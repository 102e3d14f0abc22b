"""Thin bursts: of many photos that a camera took from one place, one is enough."""

from __future__ import annotations

from collections.abc import Sequence

from .view import View, likeness

# Up to this many photos all are used, alike or not.
ENOUGH = 12
# Photos more alike than this are of one view. The most alike pair of distinct views in seventeen sets of photos, real
# and rendered, reaches 0.92; of the same photos with the camera turned by a degree and moved by a hundredth of its
# distance, seven in eight are above it (median 0.97).
_SAME_VIEW = 0.94


def near_duplicates(views: Sequence[View], enough: int = ENOUGH) -> dict[int, int]:
    """The photos that can be left out because a sharper one shows nearly the same view.

    Parameters
    ----------
    views : sequence of View
        Of the photos.
    enough : int
        At least this many photos stay.

    Returns
    -------
    dict
        For each such photo the one that stays in its place.
    """
    kept: list[int] = []
    replaced: dict[int, int] = {}
    for photo in sorted(range(len(views)), key=lambda each: -views[each].sharpness):
        same = next((each for each in kept if likeness(views[photo], views[each]) > _SAME_VIEW), None)
        if same is None:
            kept.append(photo)
        else:
            replaced[photo] = same
    # The sharpest of the near duplicates come back where too few photos would be left.
    for photo in list(replaced)[: max(0, enough - len(kept))]:
        del replaced[photo]
    return replaced
