"""Colour profiles of ICC version 2: those of sRGB and Display P3, and of grey with the tones of another.

Display P3 has the primaries of SMPTE EG 432-1; both have the tone curve of sRGB (IEC 61966-2-1).
"""

from __future__ import annotations

import struct
from functools import cache

import numpy as np

from ...core.arrays import Array

_Xyz = tuple[float, float, float]

# Primaries and white of both adapted to the profile connection space's D50 (Bradford), as CIE XYZ.
_D50 = (0.96420, 1.00000, 0.82491)
_RED, _GREEN, _BLUE = (0.43607, 0.22249, 0.01392), (0.38515, 0.71687, 0.09708), (0.14307, 0.06061, 0.71410)
_P3_RED, _P3_GREEN, _P3_BLUE = (0.51512, 0.24120, -0.00105), (0.29198, 0.69225, 0.04189), (0.15710, 0.06657, 0.78407)
_CURVE_ENTRIES = 1024
_COPYRIGHT = b"text" + bytes(4) + b"No copyright, use freely\0"
_PARAMETERS = (1, 3, 4, 5, 7)  # of each kind of ICC's parametric curves


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
    curve = _curve(_srgb_tones())
    return _profile(
        b"RGB ",
        [
            (b"desc", _description(title)),
            (b"cprt", _COPYRIGHT),
            (b"wtpt", _xyz(_D50)),
            (b"rXYZ", _xyz(red)),
            (b"gXYZ", _xyz(green)),
            (b"bXYZ", _xyz(blue)),
            *((name, curve) for name in (b"rTRC", b"gTRC", b"bTRC")),
        ],
    )


@cache
def grey_profile(rgb: bytes | None = None) -> bytes:
    """An ICC profile of grey pixels, whose levels mean the same tones as equal levels of an RGB profile.

    Without a profile that has tone curves, the tones are those of sRGB.
    """
    tones = _tones_of(_tag(rgb, b"gTRC"))
    tags = [
        (b"desc", _description("Grey with the tones of sRGB" if tones is None else "Grey with the photo's tones")),
        (b"cprt", _COPYRIGHT),
        (b"wtpt", _xyz(_D50)),
        (b"kTRC", _curve(_srgb_tones() if tones is None else tones)),
    ]
    return _profile(b"GRAY", tags)


def luminance_shares(rgb: bytes | None) -> tuple[float, float, float]:
    """The shares of red, green and blue light in luminance, by an RGB profile's primaries; without them, by sRGB's."""
    primaries = [_tag(rgb, name) for name in (b"rXYZ", b"gXYZ", b"bXYZ")]
    red, green, blue = (struct.unpack_from(">i", each, 12)[0] if len(each) >= 20 else 0 for each in primaries)
    if min(red, green, blue) <= 0:
        red, green, blue = _RED[1], _GREEN[1], _BLUE[1]
    whole = red + green + blue
    return red / whole, green / whole, blue / whole


def _tag(profile: bytes | None, name: bytes) -> bytes:
    """The content of a tag of an RGB profile; empty if it has none."""
    if profile is None or not is_rgb_profile(profile):
        return b""
    for place in range(132, min(132 + 12 * struct.unpack_from(">I", profile, 128)[0], len(profile) - 11), 12):
        found, start, size = struct.unpack_from(">4sII", profile, place)
        if found == name:
            return profile[start : start + size]
    return b""


def _tones_of(tag: bytes) -> Array | None:
    """Linear light, 0 to 1, of evenly spaced levels by a tag's tone curve; None if it has none."""
    level = np.linspace(0, 1, _CURVE_ENTRIES)
    try:
        if tag[:4] == b"curv":
            (count,) = struct.unpack_from(">I", tag, 8)
            if count == 0:
                return level
            entries = np.array(struct.unpack_from(f">{count}H", tag, 12), float)
            if count == 1:
                return np.asarray(level ** (entries[0] / 256))
            return np.interp(level, np.linspace(0, 1, count), entries / 65535)
        if tag[:4] == b"para":
            kind = struct.unpack_from(">H", tag, 8)[0]
            given = np.array(struct.unpack_from(f">{_PARAMETERS[kind]}i", tag, 12)) / 65536
            return _parametric(kind, given, level)
    except (struct.error, IndexError):  # cut off, or of a kind of another standard
        pass
    return None


def _parametric(kind: int, given: Array, level: Array) -> Array:
    """ICC's parametric curves: ``(a x + b)^g + e`` from ``d`` on, below it ``c x + f``."""
    g, a, b, c, d, e, f = 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if kind < 3:
        g, a, b, e = given.tolist() + [1.0, 0.0, 0.0][len(given) - 1 :]
        d, f = (-b / a if a else 0.0), e
    else:
        g, a, b, c, d, e, f = given.tolist() + [0.0, 0.0][len(given) - 5 :]
    power = np.maximum(a * level + b, 0) ** g + e
    return np.asarray(np.clip(np.where(level >= d, power, c * level + f), 0, 1))


def _profile(space: bytes, tags: list[tuple[bytes, bytes]]) -> bytes:
    """A profile of a colour space; tags of the same content share it."""
    body, table = b"", b""
    places: dict[bytes, int] = {}
    start = 128 + 4 + 12 * len(tags)
    for name, data in tags:
        if data not in places:
            places[data] = start + len(body)
            body += data + bytes(-len(data) % 4)
        table += struct.pack(">4sII", name, places[data], len(data))
    header = struct.pack(
        ">I4sI4s4s4s6H4s4sI4s4sQI12s4s44x",
        start + len(body),
        bytes(4),
        0x02100000,
        b"mntr",
        space,
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
    return header + struct.pack(">I", len(tags)) + table + body


def _fixed(values: tuple[float, ...]) -> bytes:
    """Numbers as ICC's s15Fixed16."""
    return struct.pack(f">{len(values)}i", *(round(value * 65536) for value in values))


def _xyz(values: tuple[float, ...]) -> bytes:
    return b"XYZ " + bytes(4) + _fixed(values)


def _description(text: str) -> bytes:
    """The textDescriptionType of ICC version 2: ASCII, then empty Unicode and ScriptCode parts."""
    ascii_text = text.encode("ascii") + b"\0"
    return b"desc" + bytes(4) + struct.pack(">I", len(ascii_text)) + ascii_text + bytes(4 + 4 + 2 + 1 + 67)


def _srgb_tones() -> Array:
    """Linear light of evenly spaced levels of sRGB."""
    encoded = np.linspace(0, 1, _CURVE_ENTRIES)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _curve(tones: Array) -> bytes:
    entries = np.rint(tones * 65535).astype(">u2").tobytes()
    return b"curv" + bytes(4) + struct.pack(">I", len(tones)) + entries
