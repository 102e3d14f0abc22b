"""The photos as the client hands them over: their names, pixels and orientation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np


def name_of(index: int) -> str:
    return f"{index:04d}"


def picture_of(index: int) -> str:
    return f"{name_of(index)}.ppm"


def read_picture(path: Path) -> np.ndarray:
    """The pixels (h, w, 3) of a PPM from the client: three lines of text, then the bytes."""
    with path.open("rb") as file:
        _, size, _ = (file.readline() for _ in range(3))
        width, height = map(int, size.split())
        return np.fromfile(file, np.uint8).reshape(height, width, 3)


def turn(pixels: np.ndarray, photo: dict[str, Any]) -> np.ndarray:
    """Pixels of a photo as they would be in its group's orientation: a quarter turn to the left, or unchanged."""
    return np.stack([pixels[:, 1], photo["width"] - pixels[:, 0]], 1) if photo["turned"] else pixels


def turn_back(pixels: np.ndarray, photo: dict[str, Any]) -> np.ndarray:
    return np.stack([photo["width"] - pixels[:, 1], pixels[:, 0]], 1) if photo["turned"] else pixels
