"""Photo sets on disk: photos of a sheet with its flat original."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2

from .metrics import Image


@dataclass(frozen=True)
class PhotoSet:
    """A folder with ``photos/``, the flat original ``gt.png`` and, if rendered, the exact truth."""

    folder: Path

    @property
    def name(self) -> str:
        return self.folder.name

    @property
    def photos(self) -> Path:
        return self.folder / "photos"

    @property
    def is_rendered(self) -> bool:
        return (self.folder / "gt_mesh.npz").is_file()

    @cached_property
    def original(self) -> Image:
        return read_image(self.folder / "gt.png")


def find_sets(data: Path) -> list[PhotoSet]:
    """All photo sets below a folder, the real ones first."""
    found = [PhotoSet(path.parent) for path in sorted(data.rglob("gt.png")) if (path.parent / "photos").is_dir()]
    return sorted(found, key=lambda photo_set: (photo_set.is_rendered, photo_set.name))


def read_image(path: Path) -> Image:
    image = cv2.imread(str(path))
    if image is None:
        raise OSError(f"{path} cannot be read as an image")
    return image
