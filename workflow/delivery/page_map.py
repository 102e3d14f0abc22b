"""Places on the page and in the photos, from a run's ``map.npz``."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ...core.arrays import Array
from ...core.errors import UsageError

# How far from the cells that show the sheet a place still counts as shown, in cells: the paper's edge crosses cells
# that are otherwise beside it.
_BESIDE = 1.0
# On the example, three steps leave less than a millionth of a pixel; where the place changes cells at a crease, five.
_STEPS = 8


@dataclass(frozen=True)
class Places:
    """Places of the page in one photo.

    Attributes
    ----------
    pixels : (N, 2) array
        x, y in the photo as stored, with the centre of the first pixel at (0.5, 0.5).
    shown : (N,) bool array
        Whether the photo shows the place: it lies in the frame, the printed side faces the camera, and no other part
        of the sheet is in front. What else may lie in front is not known.
    """

    pixels: Array
    shown: NDArray[np.bool_]


@dataclass(frozen=True)
class PageMap:
    """The content of ``map.npz``.

    Attributes
    ----------
    photo_names : list of str
    photo : (H, W) int array
        Index of the photo that each page pixel comes from, -1 if none.
    position : (H, W, 2) array
        x, y of the page pixel in that photo.
    page_size : (2,) array
        Width and height of the page in its unit.
    to_page : (K, h, w, 2) array
        u, v of the place that photo k shows in the middle of each square of `step` pixels, NaN beside the sheet.
    step : int
        Pixels.
    """

    photo_names: list[str]
    photo: NDArray[np.integer]
    position: Array
    page_size: Array
    to_page: NDArray[np.float32]
    step: int

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the page in pixels."""
        return self.photo.shape[1], self.photo.shape[0]

    def places(self, photo: int, page_pixels: Array, photo_size: tuple[int, int]) -> Places:
        """The places of the page in a photo, by inverting what the map says about the photo.

        Between the photo's entries it is bilinear, as straight as the sheet is; a crease that crosses a square of
        `step` pixels is off by up to 2 pixels in the photo, and 0.1 elsewhere (measured on the example, where the map
        has the exact position).

        Parameters
        ----------
        photo : int
            Index into `photo_names`.
        page_pixels : (N, 2) array
            x, y on the page, with the centre of the first pixel at (0.5, 0.5).
        photo_size : (width, height)
            Of the photo in pixels.
        """
        wanted = np.asarray(page_pixels, float) * self.page_size / self.size_px
        grid = self.to_page[photo].astype(float)
        known = np.isfinite(grid[..., 0])
        whole = known[:-1, :-1] & known[:-1, 1:] & known[1:, :-1] & known[1:, 1:]
        cells = np.argwhere(whole)[:, ::-1]
        if not len(cells):
            return Places(np.full((len(wanted), 2), np.nan), np.zeros(len(wanted), bool))
        middles = (grid[:-1, :-1] + grid[1:, 1:])[whole] / 2
        cell = cells[cKDTree(middles).query(wanted)[1]]
        at = cell + 0.5
        for _ in range(_STEPS):
            here, along_x, along_y = _bilinear(grid, cell, at - cell)
            area = along_x[:, 0] * along_y[:, 1] - along_x[:, 1] * along_y[:, 0]
            missing = wanted - here
            with np.errstate(divide="ignore", invalid="ignore"):
                step_x = (missing[:, 0] * along_y[:, 1] - missing[:, 1] * along_y[:, 0]) / area
                step_y = (along_x[:, 0] * missing[:, 1] - along_x[:, 1] * missing[:, 0]) / area
            at = at + np.nan_to_num(np.stack([step_x, step_y], axis=1), posinf=0, neginf=0)
            inside = np.clip(np.floor(at), 0, np.array(whole.shape[::-1]) - 1).astype(int)
            cell = np.where(whole[inside[:, 1], inside[:, 0]][:, None], inside, cell)
        beside = np.maximum(cell - at, at - cell - 1).max(axis=1)
        pixels = (at + 0.5) * self.step
        in_frame = ((pixels >= 0) & (pixels <= photo_size)).all(axis=1)
        return Places(pixels, in_frame & (beside <= _BESIDE) & (area > 0))


def _bilinear(grid: Array, cell: NDArray[np.integer], at: Array) -> tuple[Array, Array, Array]:
    """The value of a grid inside cells, and its derivatives along x and y."""
    x, y = at[:, :1], at[:, 1:]
    column, row = cell.T
    a, b, c, d = (grid[row + below, column + right] for below in (0, 1) for right in (0, 1))
    along_x = (b - a) * (1 - y) + (d - c) * y
    along_y = (c - a) * (1 - x) + (d - b) * x
    return a + (b - a) * x + (c - a) * y + (a - b - c + d) * x * y, along_x, along_y


def read_page_map(path: Path) -> PageMap:
    """Read a run's ``map.npz``.

    Raises
    ------
    UsageError
        If it is damaged, or something else.
    """
    try:
        with np.load(path) as stored:
            # The differences wrap around in 16 bits, and so does their sum.
            position = np.cumsum(stored["position_delta"], axis=1, dtype=np.uint16) / stored["position_scale"]
            return PageMap(
                [str(name) for name in stored["photo_names"]],
                stored["photo"],
                position,
                stored["page_size"],
                stored["to_page"],
                int(stored["photo_step"]),
            )
    except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zipfile.error) as error:
        raise UsageError(
            f"{path} cannot be read ({error}); make it again with rectify.py -o {path.parent} --resume."
        ) from None
