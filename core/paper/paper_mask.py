"""Which pixels of a reduced photo are paper: a minimal cut by colours and edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.csgraph import breadth_first_order, maximum_flow
from scipy.spatial import cKDTree

from ..arrays import Array
from ..numeric.morphology import Mask, bounds, dilated, eroded, fill_holes

# The values below are choices; no measurement of them is recorded. Lengths are pixels of the reduced photo, whose
# longer side has about 800; colours are Oklab times 100.
# Each square of this side starts one region. Parts of a region that are further than this many squares from its start
# are cut off it: along an edge, a region might lead out of the sheet.
_CELL, _FARTHEST = 7, 1.5
# The watershed takes whole numbers: its levels for each unit of the colour gradient, and their largest number.
_LEVELS, _HIGHEST_LEVEL = 8, 65000
# How much each part of a region's look counts: the opponent colours beside the lightness (a shadow changes lightness
# alone), the texture (standard deviation of lightness), and the place, in photo lengths.
_OPPONENT_WEIGHT, _TEXTURE_WEIGHT, _PLACE_WEIGHT = 3.0, 0.5, 3.0
# Looks are compared with this many of the most similar known regions.
_COMPARED = 6
# How the tree is built in which similar regions are searched: a search takes .55 of its time with scipy's defaults,
# leaves of 16 and splits at medians.
_TREE = {"leafsize": 32, "balanced_tree": False, "compact_nodes": False}
# Difference between looks above which a region shows something other than the paper.
_UNLIKE = 1.5
# Evidence for each pixel that a region is paper: twice the logarithm of the ratio of the differences from the table and
# from the paper, which are increased by this because colours vary that much within each, and limited.
_BY_LOOKS, _VARYING, _MOST_BY_LOOKS = 2, 0.7, 1.5
# Evidence for each pixel of what is known, stronger than all others, and of the expected place.
_SURELY_PAPER, _SURELY_NOT = 3.0, 4.0
_EXPECTED_WEIGHT = 0.8
# Cost of a pixel of border between paper and table where the colour does not change, in evidence for a pixel, and the
# share of it that remains along the strongest edge.
_BORDER_COST, _LEAST_COST = 12.0, 0.02
# The cut takes whole numbers: costs are counted in hundredths.
_FLOW_UNIT = 100
# Radius that closes notches and removes spurs, as a share of the photo's longer side, and its least, pixels.
_SPUR, _LEAST_SPUR = 0.009, 2


@dataclass(frozen=True)
class Regions:
    """Small areas of like colour, whose borders follow the edges of the photo.

    Attributes
    ----------
    label : (h, w) int array
        The region of each pixel.
    area : (R,) array
        Pixels.
    feature : (R, 6) array
        Colour, texture and place, scaled so that distances measure how different two regions look.
    contact : (R, R) sparse array
        How strongly neighbours hold together.
    """

    label: NDArray[np.int64]
    area: Array
    feature: Array
    contact: sparse.coo_matrix

    def within(self, mask: Mask) -> Mask:
        """Which regions lie mostly in a mask of the photo."""
        return np.asarray(np.bincount(self.label[mask], minlength=len(self.area)) > 0.5 * self.area)


def unlike_paper(regions: Regions, paper: Mask, where: Mask) -> Mask:
    """Which pixels of ``where`` do not look like anything in ``paper``."""
    known = regions.within(paper)
    if known.sum() < 2:
        return where
    asked = regions.within(where)
    unlike = ~asked
    unlike[asked] = _distance(regions.feature, known, asked) >= _UNLIKE
    return np.asarray(where & unlike[regions.label])


def paper_mask(regions: Regions, paper: Mask, ground: Mask, expected: Array, rounds: int = 6) -> Mask:
    """The sheet as a connected mask without holes, between what is surely paper and what is surely not.

    Parameters
    ----------
    regions : Regions
    paper, ground : (h, w) bool arrays
        What is known to be sheet, and what surroundings. The rest is decided here, by which of the two it resembles and
        where the photo has edges.
    expected : (h, w) array
        How far within the sheet each pixel is expected to be, -1 to 1. It decides where colours do not: at the gutter
        of a book, beside print that runs off the paper.
    rounds : int
        How often the colours of both are learnt again from the last result.
    """
    if not ground.any():
        return np.ones(paper.shape, bool)
    sure, elsewhere = regions.within(paper), regions.within(ground)
    lean = _EXPECTED_WEIGHT * np.bincount(regions.label.ravel(), expected.ravel(), len(regions.area))
    mask = paper
    for _ in range(rounds):
        labels = _cut(regions, _evidence(regions, mask, ground, sure, elsewhere) + lean)
        changed = _largest(labels[regions.label], paper)
        if (changed == mask).all() or changed.all() or not changed.any():
            return changed
        mask, ground = changed, ~changed
    return mask


def _largest(mask: Mask, paper: Mask) -> Mask:
    """The connected part with most of the paper, its holes and notches filled and its spurs removed.

    Spurs come from leaks along a joint of the table. Removing them rounds the corners a little; following the edge
    later restores them.
    """
    radius = max(_LEAST_SPUR, round(_SPUR * max(mask.shape)))
    if not mask.any():
        return mask
    # nothing beyond the mask's bounding box and one pixel around it makes a difference
    around = bounds(mask, 1)
    parts, count = ndimage.label(dilated(eroded(mask[around], radius), radius))
    if count == 0:
        return mask
    votes = np.bincount(parts[paper[around]], minlength=count + 1)
    votes[0] = 0
    # gaps between the mask and the frame are not notches
    padded = np.pad(parts == votes.argmax(), radius + 1)
    inner = slice(radius + 1, -radius - 1)
    result = np.zeros_like(mask)
    result[around] = fill_holes(eroded(dilated(padded, radius), radius)[inner, inner])
    return result


def regions_of(lab: NDArray[np.float32], gradient: NDArray[np.float32]) -> Regions:
    """Cut a reduced photo into small regions, by its perceptual colours (h, w, 3) and the length of their gradient."""
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
    levels = np.minimum(gradient * _LEVELS, _HIGHEST_LEVEL).astype(np.uint16)
    label = ndimage.watershed_ift(levels, markers).astype(np.int64)
    # the watershed sometimes leaves single pixels without a label
    if (label <= 0).any():
        nearest = ndimage.distance_transform_edt(label <= 0, return_distances=False, return_indices=True)
        label = label[tuple(nearest)]
    label -= 1
    y, x = np.mgrid[:height, :width]
    far = np.maximum(np.abs(y - marker_y[label]), np.abs(x - marker_x[label])) > _FARTHEST * _CELL
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
        [
            mean[:, 0],
            _OPPONENT_WEIGHT * mean[:, 1:3],
            _TEXTURE_WEIGHT * texture,
            mean[:, 3:5] * (_PLACE_WEIGHT / max(height, width)),
        ]
    )
    return Regions(label, area, feature, _contact(label, gradient, count))


def _contact(label: NDArray[np.int64], gradient: NDArray[np.float32], count: int) -> sparse.coo_matrix:
    """How strongly neighbouring regions hold together: the length of their common border, less where it is an edge."""
    first, second, weight = [], [], []
    for here, there, edge in (
        (label[:, :-1], label[:, 1:], np.maximum(gradient[:, :-1], gradient[:, 1:])),
        (label[:-1], label[1:], np.maximum(gradient[:-1], gradient[1:])),
    ):
        differ = here != there
        first += [here[differ], there[differ]]
        second += [there[differ], here[differ]]
        weight += [np.exp(-edge[differ]) + _LEAST_COST] * 2
    pairs = (np.concatenate(first), np.concatenate(second))
    return sparse.coo_matrix((np.concatenate(weight), pairs), shape=(count, count)).tocsr().tocoo()


def _evidence(regions: Regions, mask: Mask, ground: Mask, sure: Mask, elsewhere: Mask) -> Array:
    """How much more each region looks like the paper than like its surroundings, times its area."""
    is_paper, is_ground = regions.within(mask), regions.within(ground)
    score = np.where(sure, _SURELY_PAPER, 0.0) - np.where(elsewhere, _SURELY_NOT, 0.0)
    open_question = ~sure & ~elsewhere
    to_paper = _distance(regions.feature, is_paper, open_question)
    to_ground = _distance(regions.feature, is_ground, open_question)
    by_looks = _BY_LOOKS * np.log((to_ground + _VARYING) / (to_paper + _VARYING))
    score[open_question] = np.clip(by_looks, -_MOST_BY_LOOKS, _MOST_BY_LOOKS)
    return np.asarray(score * regions.area)


def _distance(feature: Array, which: NDArray[np.bool_], asked: NDArray[np.bool_]) -> Array:
    """Mean difference of each region ``asked`` from the most similar of the chosen ones, itself not counted."""
    known = feature[which]
    if len(known) < 2:
        return np.zeros(int(asked.sum()))
    k = min(_COMPARED, len(known))
    distance, _ = cKDTree(known, **_TREE).query(feature[asked], k=k)
    distance = distance.reshape(-1, k)
    # a chosen region finds itself first
    return np.asarray(np.where(which[asked], distance[:, 1:].mean(axis=1), distance[:, :-1].mean(axis=1)))


def _cut(regions: Regions, evidence: Array) -> NDArray[np.bool_]:
    """The labelling of least cost: of evidence against it, and of border that follows no edge."""
    count = len(evidence)
    source, sink = count, count + 1
    nodes = np.arange(count)
    first = np.concatenate([regions.contact.row, np.full(count, source), nodes])
    second = np.concatenate([regions.contact.col, nodes, np.full(count, sink)])
    weight = np.concatenate([_BORDER_COST * regions.contact.data, np.maximum(evidence, 0), np.maximum(-evidence, 0)])
    capacity = sparse.csr_matrix(
        ((weight * _FLOW_UNIT).astype(np.int32), (first, second)), shape=(count + 2, count + 2)
    )
    residual = capacity - maximum_flow(capacity, source, sink).flow
    residual.data = np.maximum(residual.data, 0)
    residual.eliminate_zeros()
    paper = np.zeros(count + 2, bool)
    paper[breadth_first_order(residual, source, return_predecessors=False)] = True
    return paper[:count]
