"""Places photos in any light over a sheet whose page is known, each on its own, from its matches with the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.placing.checks import believable_focal_length
from ...core.placing.result import SfmSettings
from ...core.watch import SILENT, Watch
from ..files.decoded_photo import Image
from ..files.photos import Photo, read_pixels
from .client import write_picture
from .colmap_cameras import to_camera
from .worker_process import result_of_worker

# Share of the time for decoding the photos.
_STAGED = 0.2


@dataclass(frozen=True)
class OnPage:
    """How a photo matches the page.

    Attributes
    ----------
    camera : Camera or None
        None if too few matches agree on one.
    world : (N, 3) array
        Where on the sheet its matches are.
    pixel : (N, 2) array
        Where in the photo, distorted pixels.
    agree : (N,) bool array
        Which of them agree with the camera.
    contrary : int
        How many of the others agree with one other camera.
    """

    camera: Camera | None
    world: Array
    pixel: Array
    agree: NDArray[np.bool_]
    contrary: int

    @property
    def error(self) -> float:
        """Median distance of the agreeing matches from their places on the sheet, pixels of the photo."""
        assert self.camera is not None
        return float(np.median(self.off(self.camera)))

    def off(self, camera: Camera) -> Array:
        """Distances of the agreeing matches from where a camera sees their places on the sheet, pixels of the photo."""
        return np.asarray(np.linalg.norm(camera.project(self.world[self.agree]) - self.pixel[self.agree], axis=1))


def place_on_page(
    photos: Sequence[Photo],
    page: Image,
    points: NDArray[np.float32],
    known: Sequence[Camera],
    folder: Path,
    settings: SfmSettings,
    watch: Watch = SILENT,
) -> list[OnPage]:
    """Where photos of a sheet that is known were taken.

    Parameters
    ----------
    photos : sequence of Photo
    page : (H, W, 3) array
        The sheet's page.
    points : (h, w, 3) float32 array
        The sheet's world point under each pixel of the page at the size at which photos are matched; NaN beside the
        sheet.
    known : sequence of Camera
        Those of the photos that the page is from: one of them may have taken these photos too.
    folder : Path
        For the worker's files.
    settings : SfmSettings
    watch : Watch

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos
    """
    folder.mkdir(parents=True, exist_ok=True)
    for index, photo in enumerate(photos):
        watch.step(_STAGED * index / len(photos), f"Reading {photo.name}")
        write_picture(folder / f"{index + 1:04d}.ppm", read_pixels(photo), settings.max_image_size)
    write_picture(folder / "0000.ppm", page, settings.max_image_size)
    np.save(folder / "page_points.npy", points)
    asked: list[dict[str, Any]] = [
        {"width": photo.width, "height": photo.height, "focal_lengths": _focal_lengths(photo, known)}
        for photo in photos
    ]
    request = {"do": "place_on_page", "photos": asked, "settings": asdict(settings)}
    _, arrays = result_of_worker(request, folder, watch.part(_STAGED, 1))
    found = []
    for index, photo in enumerate(photos):
        pose, lens, mine = arrays["poses"][index], arrays["lens"][index], arrays["photo"] == index
        placed = bool(np.isfinite(pose).all())
        size = photo.width, photo.height
        camera = to_camera(photo.name, "SIMPLE_RADIAL", size, lens, pose) if placed else None
        matches = arrays["world"][mine], arrays["pixel"][mine], arrays["inlier"][mine]
        found.append(OnPage(camera, *matches, int(arrays["contrary"][index])))
    return found


def _focal_lengths(photo: Photo, known: Sequence[Camera]) -> list[float]:
    """Focal lengths in pixels that a photo probably has: EXIF's, and that of the photos that are known."""
    own = believable_focal_length(photo)
    usual = float(np.median([camera.focal_length / max(camera.width, camera.height) for camera in known]))
    return [*([] if own is None else [own]), usual * max(photo.width, photo.height)]
