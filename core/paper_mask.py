"""Which pixels of a reduced photo are paper: colours, edges and seeds, joined in a minimal cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.csgraph import breadth_first_order, maximum_flow
from scipy.spatial import cKDTree

from .camera import Array
from .image import gradient_magnitude

Mask = NDArray[np.bool_]

_CELL = 7
_ALIKE = 1.5
_FLOW_UNIT = 100
# the least part of the strip along the frame that tells what surrounds the sheet
_LEAST_UNLIKE = 0.05


@dataclass(frozen=True)
class _Regions:
    """Small areas of like colour, whose borders follow the edges of the photo."""

    label: NDArray[np.int64]
    area: Array
    feature: Array
    contact: sparse.coo_matrix

    def within(self, mask: Mask) -> Mask:
        """Which regions lie mostly in a mask of the photo."""
        return np.asarray(np.bincount(self.label[mask], minlength=len(self.area)) > 0.5 * self.area)


def paper_mask(lab: NDArray[np.float32], seeds: Array, others: Array, rounds: int = 6) -> Mask:
    """The sheet that the seeds lie on, as a connected mask without holes.

    Parameters
    ----------
    lab : (h, w, 3) float32 array
        Perceptual colours of the reduced photo.
    seeds : (N, 2) array
        Pixels of the reduced photo that most likely show the sheet.
    others : (K, 2) array
        Pixels that show another page beside it; those outside the photo stand for its border there.

    Returns
    -------
    (h, w) bool array
        All of the photo where nothing in it differs from the sheet.
    """
    regions = _regions(lab)
    shape = (lab.shape[0], lab.shape[1])
    reach = round(0.03 * max(shape))
    columns, rows = _indices(seeds, shape)
    seeded, other = _drawn(seeds, shape), _drawn(others, shape)
    mask = _closed(seeded, reach)
    sure = regions.within(ndimage.binary_erosion(mask, iterations=max(reach // 4, 1)))
    elsewhere = regions.within(_closed(other, reach) | ndimage.binary_dilation(other, iterations=_CELL)) & ~sure
    strip = ~mask & _near_frame(shape, reach)
    ground = _surroundings(regions, regions.within(strip), sure)[regions.label] | _closed(other, reach)
    if other.any():
        # the page beside it looks like the sheet
        to_other, to_seeded = (ndimage.distance_transform_edt(~drawn) for drawn in (other, seeded))
        ground |= strip & (to_other < to_seeded)
    if not ground.any():
        return np.ones(shape, bool)
    nearer = _nearer(seeded, other, reach, regions)
    for _ in range(rounds):
        labels = _cut(regions, _evidence(regions, mask, ground, sure, elsewhere) + nearer)
        changed = _largest(labels[regions.label], rows, columns)
        if (changed == mask).all() or changed.all():
            return changed
        mask, ground = changed, ~changed
    return mask


def _surroundings(regions: _Regions, around: NDArray[np.bool_], sure: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which regions ``around`` the frame show something else than the sheet; none if hardly any does.

    Those that look like the sheet are not counted in, for it or one like it may leave the photo there.
    """
    if not sure.any():
        return around
    unlike = around & (_distance(regions.feature, sure) >= _ALIKE)
    enough = regions.area[unlike].sum() >= _LEAST_UNLIKE * regions.area[around].sum()
    return unlike if enough else np.zeros_like(around)


def _indices(pixels: Array, shape: tuple[int, int]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    index = np.floor(pixels).astype(np.int64)
    return np.clip(index[:, 0], 0, shape[1] - 1), np.clip(index[:, 1], 0, shape[0] - 1)


def _drawn(pixels: Array, shape: tuple[int, int]) -> Mask:
    columns, rows = _indices(pixels, shape)
    mask = np.zeros(shape, bool)
    mask[rows, columns] = True
    return mask


def _near_frame(shape: tuple[int, int], reach: int) -> Mask:
    strip = np.ones(shape, bool)
    strip[reach:-reach, reach:-reach] = False
    return strip


def _closed(mask: Mask, reach: int) -> Mask:
    """Fill gaps narrower than twice ``reach``, those between the mask and the frame left open."""
    if not mask.any():
        return mask
    margin = 2 * reach + 2
    far = ndimage.distance_transform_edt(~np.pad(mask, margin)) > reach
    inner = slice(margin, -margin)
    return np.asarray((ndimage.distance_transform_edt(~far) > reach)[inner, inner])


def _largest(mask: Mask, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Mask:
    """The connected part with the most seeds, its holes and notches filled and its spurs cut off.

    Spurs come from leaks along a joint of the desk. The opening that takes them off rounds the corners a little, which
    the search for the edge along the contour undoes.
    """
    radius = max(2, round(0.009 * max(mask.shape)))
    core = ndimage.distance_transform_edt(mask) > radius
    opened = ndimage.distance_transform_edt(~core) <= radius
    parts, count = ndimage.label(opened)
    if count == 0:
        return mask
    votes = np.bincount(parts[rows, columns], minlength=count + 1)
    votes[0] = 0
    return np.asarray(ndimage.binary_fill_holes(_closed(parts == votes.argmax(), radius)))


def _regions(lab: NDArray[np.float32]) -> _Regions:
    gradient = gradient_magnitude(lab, 1.0)
    height, width = gradient.shape
    rows, columns = -(-height // _CELL), -(-width // _CELL)
    padded = np.full((rows * _CELL, columns * _CELL), np.inf, np.float32)
    padded[:height, :width] = gradient
    cells = padded.reshape(rows, _CELL, columns, _CELL).transpose(0, 2, 1, 3).reshape(rows * columns, -1)
    lowest = cells.argmin(axis=1)
    cell = np.arange(rows * columns)
    markers = np.zeros(gradient.shape, np.int32)
    marker_y, marker_x = (cell // columns) * _CELL + lowest // _CELL, (cell % columns) * _CELL + lowest % _CELL
    markers[marker_y, marker_x] = cell + 1
    levels = np.minimum(gradient * 8, 65000).astype(np.uint16)
    label = ndimage.watershed_ift(levels, markers).astype(np.int64)
    # now and then the watershed leaves single pixels without a label
    if (label <= 0).any():
        nearest = ndimage.distance_transform_edt(label <= 0, return_distances=False, return_indices=True)
        label = label[tuple(nearest)]
    label -= 1
    # regions that run along an edge for long would lead out of the sheet: what is far from the marker is cut to pieces
    y, x = np.mgrid[:height, :width]
    far = np.maximum(np.abs(y - marker_y[label]), np.abs(x - marker_x[label])) > 1.5 * _CELL
    block = np.where(far, (y // _CELL) * columns + x // _CELL + 1, 0)
    _, label = np.unique(label * (block.max() + 1) + block, return_inverse=True)
    label = label.reshape(height, width)
    count = int(label.max()) + 1
    flat = label.ravel()
    area = np.bincount(flat, minlength=count).astype(float)
    channels = [lab[..., 0], lab[..., 1], lab[..., 2], x, y, lab[..., 0] ** 2]
    mean = np.stack([np.bincount(flat, c.ravel(), count) / area for c in channels], axis=1)
    texture = np.sqrt(np.maximum(mean[:, 5] - mean[:, 0] ** 2, 0))
    feature = np.column_stack(
        [mean[:, 0], 3.0 * mean[:, 1:3], 0.5 * texture, mean[:, 3:5] * (3.0 / max(height, width))]
    )
    return _Regions(label, area, feature, _contact(label, gradient, count))


def _contact(label: NDArray[np.int64], gradient: NDArray[np.float32], count: int) -> sparse.coo_matrix:
    """How strongly two neighbouring regions hold together: the length of their common border where it is no edge."""
    first, second, weight = [], [], []
    for here, there, edge in (
        (label[:, :-1], label[:, 1:], np.maximum(gradient[:, :-1], gradient[:, 1:])),
        (label[:-1], label[1:], np.maximum(gradient[:-1], gradient[1:])),
    ):
        differ = here != there
        first += [here[differ], there[differ]]
        second += [there[differ], here[differ]]
        weight += [np.exp(-edge[differ]) + 0.02] * 2
    pairs = (np.concatenate(first), np.concatenate(second))
    return sparse.coo_matrix((np.concatenate(weight), pairs), shape=(count, count)).tocsr().tocoo()


def _nearer(seeded: Mask, other: Mask, reach: int, regions: _Regions) -> Array:
    """Evidence from lying nearer to the sheet's print than to that of another page, or the other way, near the latter.

    Two pages of a book look alike, so that colour decides nothing there.
    """
    if not other.any():
        return np.zeros(len(regions.area))
    to_other = ndimage.distance_transform_edt(~other)
    lead = np.clip((to_other - ndimage.distance_transform_edt(~seeded)) / reach, -1, 1)
    weight = 0.7 * lead * np.exp(-to_other / (3 * reach))
    return np.asarray(np.bincount(regions.label.ravel(), weight.ravel(), len(regions.area)), dtype=np.float64)


def _evidence(regions: _Regions, mask: Mask, ground: Mask, sure: Mask, elsewhere: Mask) -> Array:
    """For each region how much more it looks like paper than like the surroundings, times its area."""
    is_paper, is_ground = regions.within(mask), regions.within(ground)
    to_paper = _distance(regions.feature, is_paper)
    to_ground = _distance(regions.feature, is_ground)
    score = np.clip(2 * np.log((to_ground + 0.7) / (to_paper + 0.7)), -1.5, 1.5).astype(np.float64)
    score[sure] += 3.0
    score[elsewhere] -= 4.0
    return np.asarray(score * regions.area)


def _distance(feature: Array, which: NDArray[np.bool_]) -> Array:
    """Distance of every region's look from the nearest few of those chosen, itself not counted."""
    known = feature[which]
    k = min(6, len(known))
    distance, _ = cKDTree(known).query(feature, k=k)
    distance = distance.reshape(len(feature), k)
    # a chosen region finds itself first
    return np.asarray(np.where(which, distance[:, 1:].mean(axis=1), distance[:, :-1].mean(axis=1)))


def _cut(regions: _Regions, evidence: Array) -> NDArray[np.bool_]:
    """The labelling of least cost: evidence against, and length of the border where it follows no edge."""
    count = len(evidence)
    source, sink = count, count + 1
    nodes = np.arange(count)
    first = np.concatenate([regions.contact.row, np.full(count, source), nodes])
    second = np.concatenate([regions.contact.col, nodes, np.full(count, sink)])
    weight = np.concatenate([12.0 * regions.contact.data, np.maximum(evidence, 0), np.maximum(-evidence, 0)])
    capacity = sparse.csr_matrix(
        ((weight * _FLOW_UNIT).astype(np.int32), (first, second)), shape=(count + 2, count + 2)
    )
    residual = capacity - maximum_flow(capacity, source, sink).flow
    residual.data = np.maximum(residual.data, 0)
    residual.eliminate_zeros()
    paper = np.zeros(count + 2, bool)
    paper[breadth_first_order(residual, source, return_predecessors=False)] = True
    return paper[:count]
