"""The exact error of every pixel of a rendered scene's page: what the reader sees, blank paper included.

For a page pixel, the run says from which place of which photo it comes, and the true cameras and surface say what lies
there on the flat original. The distance of a mesh to the true surface hides what this shows: a bump seen at a slant
moves the print along the surface, and hardly away from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..core.camera import Camera
from ..core.flat.distortion import apply_affine, fit_affine, fit_similarity
from ..core.page.raster import page_lookup
from ..core.page.warp import photo_positions
from ..core.sheet import FlatMap, Sheet
from .truth import Array, Truth
from .waves import Waves, waves

# One page pixel of this many, along rows and columns, is looked up.
STEP = 4
# This many of these at the page's rim do not count: a hair beyond the paper they show the desk.
_RIM = 2
# Page pixels that show the desk or another fold do not decide where the page lies: those that are farther off than
# both this many medians and this share of the page's height.
_FAR_MEDIANS, _FAR_HEIGHTS = 5.0, 0.01
_FITS = 3
# The largest error is this percentile.
_WORST = 99.5


@dataclass(frozen=True)
class PageSource:
    """Where page pixels come from.

    Attributes
    ----------
    photo : (H, W) int array
        Index of the photo that a pixel comes from, -1 if it comes from none.
    position : (H, W, 2) array
        Place in that photo, distorted pixels.
    names : sequence of str
        The photos' names.
    place : (H, W, 2) array
        Where the pixels' centres lie on the page, in its unit.
    """

    photo: NDArray[np.integer]
    position: Array
    names: Sequence[str]
    place: Array


def read_source(path: Path) -> PageSource:
    """One of every `STEP` pixels, along rows and columns, of a run's ``map.npz``."""
    with np.load(path) as stored:
        photo = stored["photo"]
        position = np.cumsum(stored["position_delta"], axis=1, dtype=np.uint16) / stored["position_scale"]
        names, width, height = [str(name) for name in stored["photo_names"]], *stored["page_size"]
    some = (slice(STEP // 2, None, STEP),) * 2
    return PageSource(photo[some], position[some], names, _centres(photo.shape, width, height)[some])


def source_in_reference(sheet: Sheet, flat: FlatMap, reference: Camera, size_px: tuple[int, int]) -> PageSource:
    """Of a page of this many pixels (width, height) that comes from one photo alone."""
    position = photo_positions(sheet, page_lookup(sheet, flat, size_px), reference).astype(float)
    photo = np.where(np.isfinite(position[..., 0]), 0, -1)
    return PageSource(photo, position, [reference.name], _centres(photo.shape, flat.width, flat.height))


def _centres(shape: tuple[int, int], width: float, height: float) -> Array:
    """Centres (H, W, 2) of the pixels of a page of this width and height."""
    rows, columns = shape
    u, v = (np.arange(columns) + 0.5) / columns * width, (np.arange(rows) + 0.5) / rows * height
    return np.stack(np.meshgrid(u, v), axis=-1)


@dataclass(frozen=True)
class PageError:
    """How far what a page shows is from its place, once the page is laid on the original by a similarity.

    Attributes
    ----------
    vectors : (H, W, 2) array
        Page minus truth, u right and v down, % of the page's height; NaN where it is not known.
    aspect_percent : float
        How much too wide the page is.
    """

    vectors: Array
    aspect_percent: float

    @cached_property
    def length(self) -> Array:
        return np.linalg.norm(self.vectors, axis=2)

    @property
    def rows(self) -> Waves:
        """Of horizontal lines, which rules and text follow, % of the page's height."""
        return waves(self.vectors[..., 1])

    @property
    def columns(self) -> Waves:
        """Of vertical lines, % of the page's height."""
        return waves(self.vectors[..., 0].T)

    def figures(self) -> dict[str, float]:
        """Mean, 95th and highest percentile of the error, waves, aspect, and the share of the page that is known."""
        rows, columns = self.rows, self.columns
        known = self.length[np.isfinite(self.length)]
        return {
            "page_mean": float(known.mean()),
            "page_p95": float(np.percentile(known, 95)),
            "page_worst": float(np.percentile(known, _WORST)),
            "rows_rms": rows.rms,
            "rows_worst": rows.worst,
            "columns_rms": columns.rms,
            "columns_worst": columns.worst,
            "aspect_percent": self.aspect_percent,
            "page_known": len(known) / self.length.size,
        }


def measure(truth: Truth, source: PageSource) -> PageError:
    """The error of a rendered scene's page.

    Raises
    ------
    ValueError
        If nothing of the page can be looked up.
    """
    true = _look_up(truth, source)
    known = np.isfinite(true[..., 0]) & ndimage.binary_erosion(source.photo >= 0, iterations=_RIM)
    if not known.any():
        raise ValueError("no pixel of the page shows the sheet")
    here, there = source.place[known], true[known]
    for _ in range(_FITS):
        off = np.linalg.norm(apply_affine(fit_similarity(here, there), here) - there, axis=1)
        near = off < max(_FAR_MEDIANS * np.median(off), _FAR_HEIGHTS * truth.height)
        here, there = here[near], there[near]
    vectors = np.full(true.shape, np.nan)
    vectors[known] = apply_affine(fit_similarity(here, there), source.place[known]) - true[known]
    across, down = np.linalg.norm(np.linalg.inv(fit_affine(here, there)[:, :2]), axis=0)
    return PageError(100 / truth.height * vectors, float(100 * (across / down - 1)))


def _look_up(truth: Truth, source: PageSource) -> Array:
    """True flat position (H, W, 2), mm, of what page pixels show; NaN where that is not the sheet."""
    true = np.full((*source.photo.shape, 2), np.nan)
    for index in np.unique(source.photo[source.photo >= 0]):
        here = source.photo == index
        row, column = source.position[here][:, ::-1].T - 0.5
        shown = truth.flat_in_photo(Path(source.names[index]).name)
        true[here] = np.stack(
            [ndimage.map_coordinates(part, [row, column], order=1, cval=np.nan) for part in np.moveaxis(shown, -1, 0)],
            axis=-1,
        )
    return true
