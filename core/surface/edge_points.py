"""Points of the paper's edge, as measured over the reference view."""

from __future__ import annotations

from dataclasses import dataclass

from ..arrays import Array


@dataclass(frozen=True)
class EdgePoints:
    """Points on the paper's edge whose depth several photos show.

    Attributes
    ----------
    plane : (M, 2) array
        Plane coordinates in the frame of the surface.
    inverse_depth : (M,) array
        Scaled as the surface's.
    deviation : (M,) array
        Their standard deviation, in the same unit.
    """

    plane: Array
    inverse_depth: Array
    deviation: Array

    def __len__(self) -> int:
        return len(self.plane)
