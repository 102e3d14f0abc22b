"""OpenEXR files of measured values, which have no colour: one channel of floating-point numbers."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .atomic import replacing

_MAGIC, _VERSION = 20000630, 2
_FLOAT, _ZIP, _INCREASING_Y = 2, 3, 0
_LINES = 16  # of the picture in one block, as ZIP has it


def write_exr(path: Path, values: NDArray[np.float32], comments: str) -> None:
    """Write a picture of one channel in 32-bit floating point, losslessly compressed.

    Parameters
    ----------
    path : Path
    values : (H, W) float32 array
    comments : str
        What the values mean, for the file's attribute of that name.

    Raises
    ------
    StepFailed
        If the file could not be written.
    """
    height, width = values.shape
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<2i", _MAGIC, _VERSION) + b"".join(
        name + b"\0" + kind + b"\0" + struct.pack("<i", len(content)) + content
        for name, kind, content in (
            (b"channels", b"chlist", b"Y\0" + struct.pack("<iB3x2i", _FLOAT, 0, 1, 1) + b"\0"),
            (b"comments", b"string", comments.encode()),
            (b"compression", b"compression", bytes([_ZIP])),
            (b"dataWindow", b"box2i", window),
            (b"displayWindow", b"box2i", window),
            (b"lineOrder", b"lineOrder", bytes([_INCREASING_Y])),
            (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
            (b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
            (b"screenWindowWidth", b"float", struct.pack("<f", 1)),
        )
    )
    header += b"\0"
    tops = range(0, height, _LINES)
    blocks = [_packed(values[top : top + _LINES]) for top in tops]
    begins = np.cumsum([len(header) + 8 * len(blocks), *(8 + len(block) for block in blocks[:-1])])
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(header)
        file.write(begins.astype("<u8").tobytes())
        for top, block in zip(tops, blocks, strict=True):
            file.write(struct.pack("<2i", top, len(block)) + block)


def _packed(lines: NDArray[np.float32]) -> bytes:
    """Some lines as ZIP has them: every other byte, then the others, each as its difference from the one before."""
    plain = np.frombuffer(lines.astype("<f4").tobytes(), np.uint8)
    sorted_bytes = np.concatenate([plain[::2], plain[1::2]])
    sorted_bytes[1:] = np.diff(sorted_bytes) + np.uint8(128)
    packed = zlib.compress(sorted_bytes.data)
    return packed if len(packed) < len(plain) else plain.tobytes()
