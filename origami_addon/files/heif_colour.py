"""The colours of a HEIC or AVIF photo without a colour profile: code points of ITU-T H.273."""

from __future__ import annotations

from dataclasses import dataclass

from .icc import display_p3_profile

UNSPECIFIED = 2
# Transfers whose values are brightness as on a bright screen, not shares of the paper's white.
HDR_TRANSFERS = {16: "PQ", 18: "HLG"}
_DISPLAY_P3 = 12


@dataclass(frozen=True)
class Colour:
    """The content of a file's `nclx` property.

    Attributes
    ----------
    primaries, transfer, matrix : int
    full_range : bool
    """

    primaries: int
    transfer: int
    matrix: int
    full_range: bool


def profile_of(colour: Colour) -> bytes:
    """The colour profile of pixels with these code points; empty for sRGB and for rare ones, which are taken for it."""
    return display_p3_profile() if colour.primaries == _DISPLAY_P3 else b""
