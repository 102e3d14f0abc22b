"""Decoded photos kept on disk while the program runs: HEIC and AVIF take seconds to decode, and each step reads all."""

from __future__ import annotations

import tempfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8] | NDArray[np.uint16]

# Bytes of disk: a hundred photos of 12 megapixels. What comes later is decoded again each time.
_MOST = 4 << 30


class KeptPixels:
    """Pictures by a digest of their files, in temporary files without a name, which vanish with the process."""

    def __init__(self) -> None:
        self._pictures: dict[str, NDArray[Any]] = {}
        self._size = 0

    def get(self, digest: str) -> Pixels | None:
        """A copy of a kept picture."""
        kept = self._pictures.get(digest)
        return None if kept is None else np.array(kept)

    def keep(self, digest: str, pixels: Pixels) -> None:
        """Keep a picture, unless the disk is too full."""
        if digest in self._pictures or self._size + pixels.nbytes > _MOST:
            return
        try:
            with tempfile.TemporaryFile(prefix="origami-pixels-") as file:
                pixels.tofile(file)
                file.flush()
                self._pictures[digest] = np.memmap(file, pixels.dtype, "r", shape=pixels.shape)
        except OSError:
            return
        self._size += pixels.nbytes
