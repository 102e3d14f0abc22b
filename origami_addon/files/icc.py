"""Colour profiles: those of sRGB and Display P3, built from their definitions as ICC version 2 profiles.

The latter has the primaries of SMPTE EG 432-1 and the tone curve of sRGB (IEC 61966-2-1).
"""

from __future__ import annotations

import struct
from functools import cache

import numpy as np

_Xyz = tuple[float, float, float]

# Primaries and white of both adapted to the profile connection space's D50 (Bradford), as CIE XYZ.
_D50 = (0.96420, 1.00000, 0.82491)
_RED, _GREEN, _BLUE = (0.43607, 0.22249, 0.01392), (0.38515, 0.71687, 0.09708), (0.14307, 0.06061, 0.71410)
_P3_RED, _P3_GREEN, _P3_BLUE = (0.51512, 0.24120, -0.00105), (0.29198, 0.69225, 0.04189), (0.15710, 0.06657, 0.78407)
_CURVE_ENTRIES = 1024


def is_rgb_profile(profile: bytes | None) -> bool:
    """Whether the bytes are an ICC profile that describes RGB pixels."""
    return profile is not None and len(profile) > 128 and profile[36:40] == b"acsp" and profile[16:20] == b"RGB "


@cache
def srgb_profile() -> bytes:
    """An ICC profile of sRGB, about 3 kB."""
    return _rgb_profile("sRGB IEC61966-2.1", _RED, _GREEN, _BLUE)


@cache
def display_p3_profile() -> bytes:
    """An ICC profile of Display P3, about 3 kB."""
    return _rgb_profile("Display P3", _P3_RED, _P3_GREEN, _P3_BLUE)


def _rgb_profile(title: str, red: _Xyz, green: _Xyz, blue: _Xyz) -> bytes:
    tags = [
        (b"desc", _description(title)),
        (b"cprt", b"text" + bytes(4) + b"No copyright, use freely\0"),
        (b"wtpt", _xyz(_D50)),
        (b"rXYZ", _xyz(red)),
        (b"gXYZ", _xyz(green)),
        (b"bXYZ", _xyz(blue)),
    ]
    curve = _tone_curve()
    body, table = b"", b""
    start = 128 + 4 + 12 * (len(tags) + 3)
    for name, data in tags:
        table += struct.pack(">4sII", name, start + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    for name in (b"rTRC", b"gTRC", b"bTRC"):  # the three channels share one curve
        table += struct.pack(">4sII", name, start + len(body), len(curve))
    body += curve + bytes(-len(curve) % 4)
    header = struct.pack(
        ">I4sI4s4s4s6H4s4sI4s4sQI12s4s44x",
        start + len(body),
        bytes(4),
        0x02100000,
        b"mntr",
        b"RGB ",
        b"XYZ ",
        *(2026, 1, 1, 0, 0, 0),
        b"acsp",
        bytes(4),
        0,
        bytes(4),
        bytes(4),
        0,
        0,
        _fixed(_D50),
        bytes(4),
    )
    return header + struct.pack(">I", len(tags) + 3) + table + body


def _fixed(values: tuple[float, ...]) -> bytes:
    """Numbers as ICC's s15Fixed16."""
    return struct.pack(f">{len(values)}i", *(round(value * 65536) for value in values))


def _xyz(values: tuple[float, ...]) -> bytes:
    return b"XYZ " + bytes(4) + _fixed(values)


def _description(text: str) -> bytes:
    """The textDescriptionType of ICC version 2: ASCII, then empty Unicode and ScriptCode parts."""
    ascii_text = text.encode("ascii") + b"\0"
    return b"desc" + bytes(4) + struct.pack(">I", len(ascii_text)) + ascii_text + bytes(4 + 4 + 2 + 1 + 67)


def _tone_curve() -> bytes:
    encoded = np.linspace(0, 1, _CURVE_ENTRIES)
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    entries = np.rint(linear * 65535).astype(">u2").tobytes()
    return b"curv" + bytes(4) + struct.pack(">I", _CURVE_ENTRIES) + entries
