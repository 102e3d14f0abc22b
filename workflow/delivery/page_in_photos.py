"""Where each pixel of a page is in each of its photos, from a run's ``map.npz`` and ``sheet.npz``."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.errors import UsageError
from ...core.page.page_cells import visible_cells
from ...core.page.raster import PageLookup, page_lookup
from ...core.page.warp import photo_positions
from ...core.sheet import FlatMap, Sheet, sheet_from_arrays
from .finished_run import FinishedRun

# Of the longer side of the page on which is decided what a photo shows: a cell is then a few pixels of a page.
_CELLS = 1200
# What `sheet.npz` has of each camera, in the order of `Camera`.
_CAMERA = ("size", "focal_length", "principal_point", "distortion", "rotation", "translation")

Pixels = NDArray[np.integer]


@dataclass(frozen=True)
class Places:
    """Pixels of the page in one photo.

    Attributes
    ----------
    pixels : (N, 2) array
        x, y in the photo as stored, with the centre of the first pixel at (0.5, 0.5); NaN where there is no sheet, or
        outside the frame.
    shown : (N,) bool array
        Whether the photo shows the place: it lies in the frame, the printed side faces the camera, and no other part
        of the sheet is in front. What else may lie in front is not known.
    """

    pixels: Array
    shown: NDArray[np.bool_]


@dataclass(frozen=True)
class PageInPhotos:
    """The sheet, its cameras, and the map between the page and the photos.

    Attributes
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : list of Camera
        One for each photo of the map, in its order.
    photo : (H, W) int array
        Index of the photo that each page pixel comes from, -1 if none.
    position : (H, W, 2) array
        x, y of the page pixel in that photo.
    to_page : (K, h, w, 2) array
        u, v of the place that photo k shows in the middle of each square of `step` pixels, NaN beside the sheet.
    step : int
        Pixels.
    """

    sheet: Sheet
    flat: FlatMap
    cameras: list[Camera]
    photo: Pixels
    position: Array
    to_page: NDArray[np.float32]
    step: int

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the page in pixels."""
        return self.photo.shape[1], self.photo.shape[0]

    def view(self, index: int) -> PhotoOfPage:
        """The page in one photo, by its index."""
        camera = self.cameras[index]
        shown = visible_cells(self.sheet, self._cells, camera, photo_positions(self.sheet, self._cells, camera))
        return PhotoOfPage(self, index, camera, shown)

    @cached_property
    def lookup(self) -> PageLookup:
        """The triangle of the sheet under each page pixel."""
        return page_lookup(self.sheet, self.flat, self.size_px)

    @cached_property
    def _cells(self) -> PageLookup:
        scale = min(1.0, _CELLS / max(self.size_px))
        width, height = (max(1, round(length * scale)) for length in self.size_px)
        return page_lookup(self.sheet, self.flat, (width, height))


@dataclass(frozen=True)
class PhotoOfPage:
    """The page in one photo.

    Attributes
    ----------
    page : PageInPhotos
    index : int
        Of the photo.
    camera : Camera
    cells_shown : (h, w) bool array
        Which coarse cells of the page the photo shows.
    """

    page: PageInPhotos
    index: int
    camera: Camera
    cells_shown: NDArray[np.bool_]

    def places(self, columns: Pixels, rows: Pixels) -> Places:
        """Where pixels (N,) of the page are in the photo: as the map says, or else as the camera sees the sheet.

        The map differs from the camera by what aligned the photos on the page: on the example by 0.05 pixels in the
        median, and at most 0.7.
        """
        page = self.page
        needed = PageLookup(page.lookup.triangle[rows, columns][None], page.lookup.barycentric[rows, columns][None])
        pixels = photo_positions(page.sheet, needed, self.camera)[0].astype(float)
        own = page.photo[rows, columns] == self.index
        pixels[own] = page.position[rows, columns][own]
        down, across = (
            at * count // length for at, count, length in zip((rows, columns), self.cells_shown.shape, page.photo.shape)
        )
        return Places(pixels, (self.cells_shown[down, across] | own) & np.isfinite(pixels[:, 0]))

    def stated(self) -> tuple[Array, Array]:
        """All places (N, 2) of which the map itself says where they are: on the page and in the photo, pixels.

        These are the page's pixels that come from this photo, and the entries of the way back.
        """
        page = self.page
        rows, columns = np.nonzero(page.photo == self.index)
        entries = page.to_page[self.index].astype(float)
        down, across = np.nonzero(np.isfinite(entries[..., 0]))
        scale = np.array(page.size_px) / (page.flat.width, page.flat.height)
        on_page = np.concatenate([np.stack([columns, rows], axis=1) + 0.5, entries[down, across] * scale])
        middles = (np.stack([across, down], axis=1) + 0.5) * page.step
        return on_page, np.concatenate([page.position[rows, columns], middles])


def page_in_photos(run: FinishedRun) -> PageInPhotos:
    """Read the two files of a run.

    Raises
    ------
    UsageError
        If one is missing, damaged, or of another version or run.
    """
    sheet, stored = _arrays(run, "sheet.npz"), _arrays(run, "map.npz")
    names = [str(name) for name in stored["photo_names"]]
    if [str(name) for name in sheet["cam_names"]] != names or set(names) - run.photos.keys():
        raise UsageError(
            f"map.npz, sheet.npz and report.json in {run.folder} are of different runs; run rectify.py again with "
            f"-o {run.folder} --resume."
        )
    cameras = [
        Camera(name, int(width), int(height), float(focal_length), center, distortion, rotation, translation)
        for name, (width, height), focal_length, center, distortion, rotation, translation in zip(
            names, *(sheet[f"cam_{attribute}s"] for attribute in _CAMERA)
        )
    ]
    width, height = sheet["page_size"]
    return PageInPhotos(
        sheet_from_arrays({**sheet, "vertices": sheet["xyz"]}),
        FlatMap(sheet["uv"], float(width), float(height), str(sheet["unit"]), None),
        cameras,
        stored["photo"],
        # The differences wrap around in 16 bits, and so does their sum.
        np.cumsum(stored["position_delta"], axis=1, dtype=np.uint16) / stored["position_scale"],
        stored["to_page"],
        int(stored["photo_step"]),
    )


class _Named(dict[str, NDArray[Any]]):
    """Arrays by name; a missing one is a failure that says so."""

    def __init__(self, path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
        super().__init__(arrays)
        self.path = path

    def __missing__(self, name: str) -> NDArray[Any]:
        raise UsageError(
            f"{self.path} has no {name}: an earlier version of Origami wrote it; run rectify.py again with "
            f"-o {self.path.parent} --resume."
        )


def _arrays(run: FinishedRun, name: str) -> _Named:
    path = run.file(name)
    try:
        with np.load(path) as stored:
            return _Named(path, dict(stored))
    except (ValueError, TypeError, EOFError, KeyError, zipfile.BadZipFile, zipfile.error) as error:
        raise UsageError(
            f"{path} cannot be read ({error}); make it again with rectify.py -o {run.folder} --resume."
        ) from None
