"""The light on the page: what colour blank paper has at each place, from the sheet's normals and its blank paper.

Light on matt paper depends on the paper's direction and place alone. One model of both serves the whole sheet, so it is
right next to a fold, where the light changes within a pixel, and under print. What the model leaves, shadows and the
fall-off of near lamps, changes smoothly and is taken from the blank paper nearby; beside folds it is looked at closely.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import Image, gaussian_mean, perceptual
from ..page.page_cells import enlarge_rows
from ..page.raster import interpolate, rasterize
from ..sheet import FlatMap, Sheet
from .blank_paper import EvenCells, even_cells
from .fold_light import light_at_folds
from .normals import corner_normals

# Values without a figure are choices; no measurement of them is recorded.
_NORMAL = slice(1, 4)  # of the model's terms: the normal's components
# Weight of coefficients that are zero, share of the samples: for brightness, and for the two differences of channels.
# Light changes in brightness across a fold, and little in colour; print does both.
_RIDGE = (3e-2, 3e-1, 3e-1)
# Brightness, red less green, blue less green, from the logarithms of the three channels.
_TO_OPPONENT = np.array([[1 / 3, 1 / 3, 1 / 3], [1, -1, 0], [0, -1, 1]])
# Blank paper is the brightest of what is even nearby: cells within this difference (logarithm) of the mean, over
# surroundings of this standard deviation (cells), of those that are brighter than the mean, and so once more.
_BELOW, _AROUND, _BRIGHTER = 0.08, 8.0, 2
_DARKEST, _BRIGHTEST = 1.2, 0.9  # logarithm: paper in shadow, below this quantile of the page
# Scale of the robust loss, logarithm of light: blank paper of one sheet differs by a few per cent.
_SCALE = 0.04
_DARKER = 0.5  # of the scale: residuals below the paper are print, and count less
_ITERATIONS = 20  # of reweighting; a choice, as `_PASSES` and `_ROUNDS` are
_SAME = 1e-6  # a term that varies less over the page is a constant
_PASSES = 3  # of choosing the brightest cells in the model's light, and fitting the model to them
_MOST_REST = 0.3  # logarithm: what one round may take from the light at most
_SMOOTH = (24.0, 12.0, 6.0, 3.0)  # cells, standard deviations: the remainder from coarse to fine
_FEWEST = 0.03  # share of the surroundings that must be blank paper; with less, the remainder fades
_ROUNDS = 6  # of finding blank paper and the remainder by turns

# What is blank is paper if it takes this share of the page at least, if it is near (cells) more than the second share,
# if less than a share of the page is brighter by a factor, if it is less coloured than a limit, Oklab times 100, and if
# its colour changes less over the page, logarithm of the ratio of two channels between its ends.
# Nine pages have .12 to .77, .63 to 1, 0 to .002, and .2 to 3.3 (a scan of toned paper of the 19th century).
_LEAST_BLANK, _NEAR, _LEAST_NEAR = 0.03, 12, 0.4
_ENDS = (0.98, 0.02)  # quantiles that are the ends of the page
_MUCH_BRIGHTER, _MOST_BRIGHTER, _MOST_CHROMA, _MOST_CHANGE = 1.15, 0.02, 8.0, 0.5


@dataclass(frozen=True)
class Shading:
    """The colour of blank paper on the page.

    Attributes
    ----------
    corners : (3 F, 2) array
        Places of the triangles' corners on the page image, pixels.
    at_corners : (3 F, 3) array
        Logarithm of linear light by the model, at each triangle's corners.
    remainder : (h, w, 3) float32 array
        What is added on the cells.
    per_cell : float
        Pixels of the page image along a cell's side.
    paper : (3,) array
        Linear light of blank paper, median over the page.
    blank : (h, w) bool array
        Which of the page's cells are blank paper.
    """

    corners: Array
    at_corners: Array
    remainder: NDArray[np.float32]
    per_cell: float
    paper: Array
    blank: NDArray[np.bool_]

    def on_rows(self, width: int, rows: slice) -> NDArray[np.float32]:
        """Linear light (rows, W, 3) of blank paper on some rows of the page image of this width; NaN off the sheet."""
        triangles = np.arange(len(self.corners)).reshape(-1, 3)
        down = self.corners[triangles, 1]
        triangles = triangles[(down.max(axis=1) > rows.start) & (down.min(axis=1) < rows.stop)]
        lookup = rasterize(self.corners - [0, rows.start], triangles, (width, rows.stop - rows.start))
        light = interpolate(lookup, triangles, self.at_corners).astype(np.float32)
        return np.exp(light + enlarge_rows(self.remainder, self.per_cell, rows, width))


def find_shading(image: Image, covered: NDArray[np.bool_], sheet: Sheet, flat: FlatMap) -> Shading | None:
    """Find the light on the page.

    Parameters
    ----------
    image : (H, W, 3) uint8 or uint16 array
        The page in sRGB.
    covered : (H, W) bool array
        Where it is in a photo.
    sheet : Sheet
    flat : FlatMap

    Returns
    -------
    Shading or None
        None if the page has too little blank paper to know its light by, or if what is blank on it is not paper: print
        all over the sheet, or a dark sheet.
    """
    cells = even_cells(image, covered)
    if not cells.share.any():
        return None
    scale = np.array([image.shape[1] / flat.width, image.shape[0] / flat.height])
    corners = (flat.uv * scale)[sheet.triangles].reshape(-1, 2)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    terms = _terms(corner_normals(sheet), flat.uv[sheet.triangles] / max(flat.width, flat.height) - 0.5)
    rows, columns = cells.share.shape
    at_cells = interpolate(rasterize(corners / cells.per_cell, triangles, (columns, rows)), triangles, terms)
    known = (cells.share > 0) & np.isfinite(at_cells[..., 0])
    at_cells = np.nan_to_num(at_cells)
    if known.mean() < _LEAST_BLANK:
        return None
    model = np.zeros(cells.color.shape)
    for _ in range(_PASSES):
        blank = _brightest(cells, model, known)
        coefficients = _fit(at_cells[blank], cells.color[blank].astype(float), cells.share[blank].astype(float))
        model = at_cells @ coefficients
    remainder, blank = _remainder(cells, model, known)
    remainder += light_at_folds(cells.color - model - remainder, cells.share, known, blank, at_cells[..., _NORMAL])
    light = np.exp(model + remainder)
    if not _is_paper(cells, light, blank):
        return None
    paper = np.median(light[blank], axis=0)
    return Shading(corners, terms @ coefficients, remainder, cells.per_cell, paper, blank)


def _is_paper(cells: EvenCells, light: Array, blank: NDArray[np.bool_]) -> bool:
    """Whether what is blank is paper: near most of the page, hardly coloured, with nothing much brighter on it."""
    if blank.mean() < _LEAST_BLANK:
        return False
    near = ndimage.distance_transform_edt(~blank) < _NEAR
    brighter = cells.light > _MUCH_BRIGHTER * light.mean(axis=-1)
    color = perceptual(np.median(light[blank], axis=0)[None].astype(np.float32))[0]
    inside = cells.light > 0
    ratios = np.log(light[blank]) @ _TO_OPPONENT[1:].T
    return bool(
        near.mean() > _LEAST_NEAR
        and (brighter & inside).sum() < _MOST_BRIGHTER * inside.sum()
        and np.hypot(color[1], color[2]) < _MOST_CHROMA
        and np.subtract(*np.quantile(ratios, _ENDS, axis=0)).max() < _MOST_CHANGE
    )


def _terms(normals: Array, places: Array) -> Array:
    """The model's terms (3 F, 17) at each triangle's corners.

    Spherical harmonics of the normal up to the second degree, which hold 99 % of any distant light on a matt surface
    (Ramamoorthi and Hanrahan, 2001), and those of the first degree times the place, for lamps that are near.
    """
    normal, (x, y) = normals.reshape(-1, 3), places.reshape(-1, 2).T
    upward = normal.mean(axis=0) / np.linalg.norm(normal.mean(axis=0))
    right = np.cross(np.eye(3)[np.abs(upward).argmin()], upward)
    right /= np.linalg.norm(right)
    a, b, c = (normal @ np.stack([right, np.cross(upward, right), upward], axis=1)).T
    one = np.ones_like(a)
    first = [one, a, b, c]
    second = [a * b, a * c, b * c, a * a - b * b, 3 * c * c - 1]
    return np.stack([*first, *second, *(term * x for term in first), *(term * y for term in first)], axis=1)


def _fit(terms: Array, color: Array, share: Array) -> Array:
    """Coefficients (T, 3) of robust least squares."""
    mean, spread = terms.mean(axis=0), terms.std(axis=0)
    used = spread > _SAME
    scaled = np.column_stack([np.ones(len(terms)), (terms[:, used] - mean[used]) / spread[used]])
    penalty = share.sum() * np.diag([0.0, *np.ones(used.sum())])
    opponent = color @ _TO_OPPONENT.T
    weight = np.ones(len(terms))
    for _ in range(_ITERATIONS):
        weighted = (scaled * (share * weight)[:, None]).T
        normal = weighted @ scaled
        parts = [np.linalg.solve(normal + ridge * penalty, weighted @ opponent[:, k]) for k, ridge in enumerate(_RIDGE)]
        solution = np.linalg.solve(_TO_OPPONENT, np.stack(parts)).T
        weight = _agreement(color - scaled @ solution)
    coefficients = np.zeros((terms.shape[1], 3))
    coefficients[used] = solution[1:] / spread[used, None]
    coefficients[0] += solution[0] - mean @ coefficients
    return coefficients


def _brightest(cells: EvenCells, model: Array, known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the known cells are among the brightest nearby, but for the model's light, as blank paper is."""
    light = (cells.color - model).mean(axis=-1)
    above = cells.share * known
    for _ in range(1 + _BRIGHTER):
        mean, _ = gaussian_mean(light, above, _AROUND)
        above = np.where(light >= mean, above, 0)
    return known & (light > mean - _BELOW) & (light > np.quantile(light[known], _BRIGHTEST) - _DARKEST)


def _agreement(residual: Array) -> Array:
    """Weight of residuals (..., 3) by their least absolute values, the largest of the three channels."""
    allowed = np.where(residual < 0, _DARKER * _SCALE, _SCALE)
    return np.asarray(1 / np.maximum((np.abs(residual) / allowed).max(axis=-1), 1))


def _remainder(
    cells: EvenCells, model: Array, known: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """What the model leaves of the light on blank paper, smooth, and where blank paper is."""
    difference = np.where(known[..., None], cells.color - model, 0).astype(np.float32)
    remainder = np.zeros_like(difference)
    for _ in range(_ROUNDS):
        rest = difference - remainder
        # nothing on paper is brighter than the paper, so what is brighter than the model is paper
        blank = _brightest(cells, model + remainder, known) & (rest.min(axis=-1) > -_MOST_REST)
        weight = cells.share * _agreement(rest) * blank
        remainder = np.zeros_like(difference)
        for sigma in _SMOOTH:
            remainder += gaussian_mean(difference - remainder, weight.astype(np.float32), sigma, _FEWEST)[0]
    return remainder, blank
