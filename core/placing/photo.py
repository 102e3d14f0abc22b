"""What is known of a photo before it is placed."""

from __future__ import annotations

from typing import Protocol

from ..sparse_model import FEWEST_VIEWS

# A point counts if this many photos show it.
FEWEST_PHOTOS = FEWEST_VIEWS


class Photo(Protocol):
    """A photo.

    Attributes
    ----------
    name : str
    width, height : int
        Pixels.
    focal_length_pixels : float or None
        As the file says; None if it does not.
    """

    @property
    def name(self) -> str: ...

    @property
    def width(self) -> int: ...

    @property
    def height(self) -> int: ...

    @property
    def focal_length_pixels(self) -> float | None: ...
