"""Which pixels of a reduced photo are paper: colour models, edges and seeds, joined in a minimal cut."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from .camera import Array
from .image import gradient_magnitude

Mask = NDArray[np.bool_]

_CELL = 7
_BINS = (40, 40, 40)
_LOWEST = np.array([0.0, -40.0, -40.0])
_HIGHEST = np.array([100.0, 40.0, 40.0])
_CAPACITY = 1000


def paper_mask(lab: NDArray[np.float32], seeds: Array, rounds: int = 6) -> Mask:
    """The sheet that holds the seeds, as a mask without holes.

    Parameters
    ----------
    lab : (h, w, 3) float32 array
        Perceptual colours of the reduced photo.
    seeds : (N, 2) array
        Pixels of the reduced photo where a 3D point was seen. Not all need lie on the sheet.

    Returns
    -------
    (h, w) bool array
    """
    gradient = gradient_magnitude(lab, 1.0)
    regions, count = _regions(gradient)
    graph = _boundaries(regions, count, lab, gradient)
    area = np.bincount(regions.ravel(), minlength=count).astype(float)
    bins = _bin_index(lab)
    on_border = np.zeros(count)
    for edge in (regions[0], regions[-1], regions[:, 0], regions[:, -1]):
        on_border += np.bincount(edge, minlength=count)
    density = _seed_density(seeds, lab.shape[:2])
    mask = density > 0.5 * density.max()
    for _ in range(rounds):
        mask = _cut(mask, regions, count, area, graph, bins, on_border, seeds)
    return mask


def _regions(gradient: NDArray[np.float32]) -> tuple[NDArray[np.int64], int]:
    """Watershed regions about ``_CELL`` pixels wide whose borders follow the edges."""
    height, width = gradient.shape
    levels = np.minimum(gradient * 8, 65000).astype(np.uint16)
    markers = np.zeros(gradient.shape, np.int32)
    count = 0
    rows, columns = -(-height // _CELL), -(-width // _CELL)
    padded = np.full((rows * _CELL, columns * _CELL), np.inf, np.float32)
    padded[:height, :width] = gradient
    cells = padded.reshape(rows, _CELL, columns, _CELL).transpose(0, 2, 1, 3).reshape(rows * columns, -1)
    lowest = cells.argmin(axis=1)
    row = (np.arange(rows * columns) // columns) * _CELL + lowest // _CELL
    column = (np.arange(rows * columns) % columns) * _CELL + lowest % _CELL
    count = rows * columns
    markers[row, column] = np.arange(1, count + 1)
    return ndimage.watershed_ift(levels, markers).astype(np.int64) - 1, count


def _boundaries(regions, count, lab, gradient):
    pairs, weights = [], []
    sigma2 = 2 * 4.0**2
    for a, b, ga, gb in (
        (regions[:, :-1], regions[:, 1:], gradient[:, :-1], gradient[:, 1:]),
        (regions[:-1], regions[1:], gradient[:-1], gradient[1:]),
    ):
        differs = a != b
        pairs.append(np.stack([a[differs], b[differs]], 1))
        weights.append(np.exp(-(np.maximum(ga, gb)[differs] ** 2) / sigma2) + 0.02)
    pairs = np.concatenate(pairs)
    weights = np.concatenate(weights)
    graph = sparse.coo_matrix((weights, (pairs[:, 0], pairs[:, 1])), shape=(count, count)).tocsr()
    return graph + graph.T


def _bin_index(lab):
    scaled = (lab - _LOWEST) / (_HIGHEST - _LOWEST) * np.array(_BINS)
    index = np.clip(scaled.astype(np.int64), 0, np.array(_BINS) - 1)
    return np.ravel_multi_index(tuple(np.moveaxis(index, 2, 0)), _BINS)


def _seed_density(seeds, shape):
    grid = np.zeros(shape, np.float32)
    columns = np.clip(seeds[:, 0].astype(int), 0, shape[1] - 1)
    rows = np.clip(seeds[:, 1].astype(int), 0, shape[0] - 1)
    np.add.at(grid, (rows, columns), 1)
    height, width = shape
    y, x = np.mgrid[:height, :width]
    central = np.exp(-(((x - width / 2) / (0.35 * width)) ** 2 + ((y - height / 2) / (0.35 * height)) ** 2))
    return ndimage.gaussian_filter(np.minimum(grid, 1), 0.06 * max(shape)) * central


def _color_model(bins, mask):
    counts = np.bincount(bins[mask], minlength=int(np.prod(_BINS))).astype(float)
    smooth = ndimage.gaussian_filter(counts.reshape(_BINS), 1.0).ravel()
    return smooth / max(smooth.sum(), 1e-9)


def _cut(mask, regions, count, area, graph, bins, on_border, seeds):
    paper = _color_model(bins, mask)
    ground = _color_model(bins, ~mask)
    floor = 1e-5
    ratio = np.log((paper + floor) / (ground + floor))
    ratio = np.clip(ratio, -3, 3)
    unary = np.bincount(regions.ravel(), weights=ratio[bins].ravel(), minlength=count)
    # seeds inside
    rows = np.clip(seeds[:, 1].astype(int), 0, regions.shape[0] - 1)
    columns = np.clip(seeds[:, 0].astype(int), 0, regions.shape[1] - 1)
    inside = mask[rows, columns]
    seeded = np.bincount(regions[rows, columns][inside], minlength=count) > 0
    unary += 2.0 * area * seeded
    unary -= 3.0 * on_border * 3
    smooth = 8.0
    source, sink = count, count + 1
    to_source = np.maximum(unary, 0)
    to_sink = np.maximum(-unary, 0)
    nodes = np.arange(count)
    g = graph.tocoo()
    r = np.concatenate([g.row, np.full(count, source), nodes])
    c = np.concatenate([g.col, nodes, np.full(count, sink)])
    v = np.concatenate([g.data * smooth, to_source, to_sink]) * 100
    capacity = sparse.csr_matrix((np.minimum(v, 2e7).astype(np.int32), (r, c)), shape=(count + 2, count + 2))
    flow = maximum_flow(capacity, source, sink)
    residual = capacity - flow.flow
    residual.data = np.maximum(residual.data, 0)
    residual.eliminate_zeros()
    reached = breadth_first_order(residual, source, return_predecessors=False)
    label = np.zeros(count + 2, bool)
    label[reached] = True
    new = label[:count][regions]
    # the component with the most seeds
    parts, n = ndimage.label(new)
    if n == 0:
        return mask
    votes = np.bincount(parts[rows, columns], minlength=n + 1)
    votes[0] = 0
    return ndimage.binary_fill_holes(parts == votes.argmax())
