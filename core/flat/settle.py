"""The loop that ARAP and the geodesic map share: a local and a global step in turn, until nothing moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..watch import Watch

# Of the page's size.
_TOLERANCE = 1e-6


def settle(
    start: Array, step: Callable[[Array], Array], iterations: int, watch: Watch, *, centred: bool = True
) -> Array:
    """Repeat ``step`` on a flat map (V, 2) of about unit area until no vertex moves.

    ``centred`` keeps the centre of the map in place, for steps that do not fix its position.
    """
    flat = start
    for iteration in range(iterations):
        watch.step(iteration / iterations, "Flattening")
        update = step(flat)
        if centred:
            update = update - update.mean(0) + flat.mean(0)
        change = float(np.abs(update - flat).max())
        flat = update
        if change < _TOLERANCE:
            break
    return flat
