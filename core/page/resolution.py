"""How many pixels a page has."""

from __future__ import annotations

from dataclasses import dataclass

from ..sheet import FlatMap

MILLIMETRES_PER_INCH = 25.4
# Dots per inch that the files state if the true resolution is unknown because the paper's size is. A choice: usual for
# scans of text.
_ASSUMED_DPI = 300.0


@dataclass(frozen=True)
class Resolution:
    """The size of a page image.

    Attributes
    ----------
    size_px : (width, height)
    dpi : float
        Dots per inch, a nominal number if the paper's size is unknown.
    known : bool
        Whether the paper's size is known.
    """

    size_px: tuple[int, int]
    dpi: float
    known: bool


def resolution_of(flat: FlatMap, native: float, dpi: float | None = None) -> Resolution:
    """The size of a page.

    Parameters
    ----------
    flat : FlatMap
    native : float
        Pixels per page unit that the photos have, see `warp.native_size`.
    dpi : float, optional
        Dots per inch, for a page whose size is known. By default as many as the photos have, as a whole number, which
        all kinds of files can state: JPEG has no others.
    """
    known, per_unit = flat.unit == "mm", native
    if known:
        dpi = dpi or max(round(per_unit * MILLIMETRES_PER_INCH), 1)
        per_unit = dpi / MILLIMETRES_PER_INCH
    size = max(round(flat.width * per_unit), 1), max(round(flat.height * per_unit), 1)
    return Resolution(size, dpi or _ASSUMED_DPI, known)
