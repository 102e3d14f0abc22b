"""Why photos cannot be placed: each possible cause with its evidence, the likeliest first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

from .cause import Cause, ranked
from .causes_in_matches import different_things, mirrored, too_far, too_near
from .causes_in_models import moved, zoomed
from .causes_in_photos import blurred, little_print, repeated_print
from .checks import AROUND
from .photo import Photo
from .trial import Trial, agreeing_matches


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
