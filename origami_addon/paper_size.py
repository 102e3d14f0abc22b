"""Parses paper sizes, and recognises those that the user probably meant in another unit."""

from __future__ import annotations

import re

from ..core.errors import UsageError
from ..core.page.resolution import MILLIMETRES_PER_INCH

PaperSize = tuple[float, float | None]

PAPER_SIZES_MM: dict[str, PaperSize] = {
    "A3": (297.0, 420.0),
    "A4": (210.0, 297.0),
    "A5": (148.0, 210.0),
    "A6": (105.0, 148.0),
    "Letter": (215.9, 279.4),
    "Legal": (215.9, 355.6),
}
HOW_WRITTEN = (
    f"{', '.join(PAPER_SIZES_MM)}, WIDTHxHEIGHT in mm or with a unit (8.5x11in, 21x29.7cm), just a width (80, for a "
    "receipt), or none"
)
_UNITS_MM = {"mm": 1.0, "cm": 10.0, "in": MILLIMETRES_PER_INCH, "inch": MILLIMETRES_PER_INCH, '"': MILLIMETRES_PER_INCH}
# Sizes usually given in inches or centimetres, the shorter side first: those above, Tabloid, Executive, Half Letter,
# A7, index cards and photo prints.
_SPOKEN_OF_MM = (
    *((width, height) for width, height in PAPER_SIZES_MM.values() if height is not None),
    *((279.4, 431.8), (184.2, 266.7), (139.7, 215.9), (74.0, 105.0), (76.2, 127.0)),
    *((101.6, 152.4), (127.0, 177.8), (203.2, 254.0), (90.0, 130.0), (100.0, 150.0), (130.0, 180.0)),
)
# Rolls of receipts, which are named after their width.
_ROLLS_MM = (57.15, 58.0, 76.2, 79.4, 80.0, 112.0)
# Sheets with a longer side, and strips with a width, above these limits are accepted as written: labels and stamps of
# 50 x 30 mm and strips of 38 mm exist. A3 in centimetres and Tabloid in inches are below the limits.
_LIKELY_SIDE_MM, _LIKELY_WIDTH_MM = 45.0, 25.0
# How far a side may be rounded: people also write A4 as 21 x 30.
_ROUNDING = 0.015


def paper_size(text: str) -> PaperSize | None:
    """The size in millimetres from a text.

    Parameters
    ----------
    text : str
        ``A4`` and the like, ``210x297`` in mm, ``21x29.7cm``, ``8.5x11in``, ``8.5x11"``, a width alone (``80``,
        ``8cm``), or ``none``.

    Raises
    ------
    UsageError
        If the text is not a size, or has no unit and is only plausible in a unit other than millimetres.
    """
    if text.strip().lower() == "none":
        return None
    by_name = {name.lower(): size for name, size in PAPER_SIZES_MM.items()}
    if text.strip().lower() in by_name:
        return by_name[text.strip().lower()]
    side = r'(\d+(?:\.\d+)?|\.\d+)\s*(mm|cm|inch|in|")?'
    match = re.fullmatch(rf"\s*{side}(?:\s*[x×]\s*{side})?\s*", text.replace("″", '"'), re.IGNORECASE)
    if not match:
        raise UsageError(f"Origami does not understand the paper size {text!r}; use {HOW_WRITTEN}.")
    width, unit_of_width, height, unit_of_height = match.groups()
    units = [unit_of_width or unit_of_height, unit_of_height or unit_of_width]
    sides = [
        None if number is None else round(float(number) * _UNITS_MM[(unit or "mm").lower()], 6)
        for number, unit in zip((width, height), units)
    ]
    assert sides[0] is not None
    size = sides[0], sides[1]
    if units[0] is None:
        check_unit(size)
    return size


def check_unit(size: PaperSize | None) -> None:
    """Refuse a size in millimetres that is implausibly small but usual in inches or centimetres.

    Raises
    ------
    UsageError
    """
    if size is None or max(side for side in size if side is not None) > (
        _LIKELY_WIDTH_MM if size[1] is None else _LIKELY_SIDE_MM
    ):
        return
    written = "x".join(f"{side:g}" for side in size if side is not None)
    for unit in ("cm", "in"):
        meant = [side * _UNITS_MM[unit] for side in size if side is not None]
        for usual in _SPOKEN_OF_MM if len(meant) == 2 else [(width,) for width in (*_ROLLS_MM, *_widths())]:
            if all(abs(is_ / is_meant - 1) < _ROUNDING for is_, is_meant in zip(sorted(meant), usual)):
                names = [name for name, known in PAPER_SIZES_MM.items() if known == usual]
                in_millimetres = "x".join(f"{side:g}" for side in usual)
                raise UsageError(
                    f"The paper size {written} is in millimetres, and hardly any sheet is that small; did you mean "
                    f"{' or '.join([*names, written + unit])}? Write that, or {in_millimetres}; for paper that really "
                    f"is that small, write --paper {written}mm."
                )


def _widths() -> list[float]:
    return [width for width, _ in _SPOKEN_OF_MM]
