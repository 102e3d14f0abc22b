"""Checks that the sheet kept its shape and place from photo to photo, by matches that contradict the model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ..arrays import Array
from ..camera import Camera
from ..sparse_model import SparseModel

# The values are choices: what they give together is measured (`placing/trial.py` has the limits). A match contradicts
# the model if it is further than this from where the cameras allow it, but at least this many pixels. Lengths are
# relative to the photo's long side.
_OFF_LIMITS, _LEAST_OFF_LIMITS_PIXELS = 0.0015, 2.0
# Side of the cells that one match each represents, and a number larger than that of cells in a row.
_CELL, _ROW = 0.04, 1000
# A match is in company if, of this many nearest neighbours, one affine map takes this many to where they were found,
# this exactly. The map is that of two neighbours, in directions whose sine is at least the last value.
_NEIGHBOURS, _AGREEING_NEIGHBOURS, _IN_STEP, _LEAST_ANGLE = 12, 6, 0.008, 0.3


def contradicting_area(model: SparseModel, camera_pairs: NDArray[np.int64], pixels: Array) -> tuple[Array, Array]:
    """How much of the common area of two photos contradicts the model as a group.

    A match off its epipolar line is either a matching error, print mistaken for the same print elsewhere, or a part of
    the scene that moved between the photos. All matches of a moved part are off; where print repeats, most matches
    beside a wrong one are right. So the median match of each cell of a grid, by distance from the line, represents the
    cell; a single match in a cell does not count. A movement also takes a whole neighbourhood along, whereas a repeated
    word hardly fills a cell.

    Parameters
    ----------
    model : SparseModel
    camera_pairs : (M, 2) int array
        Indices into ``model.cameras``.
    pixels : (M, 4) array
        x, y in the first and x, y in the second photo of each match, distorted pixels.

    Returns
    -------
    contradicting, common : (C, C) arrays
        For each pair of cameras the number of cells in which matches contradict in company, and of cells with several
        matches.
    """
    count = len(model.cameras)
    contradicting, common = np.zeros((count, count)), np.zeros((count, count))
    for first, second in np.unique(camera_pairs, axis=0):
        mine = pixels[(camera_pairs == (first, second)).all(1)]
        cameras = model.cameras[first], model.cameras[second]
        side = max(cameras[0].width, cameras[0].height)
        distance = epipolar_distance(*cameras, mine)
        middle = _middle_of_each_cell(mine, distance, side)
        off = middle[np.abs(distance[middle]) > max(_LEAST_OFF_LIMITS_PIXELS, _OFF_LIMITS * side)]
        in_company = _in_company(mine[off], _IN_STEP * side)
        contradicting[first, second] = contradicting[second, first] = in_company
        common[first, second] = common[second, first] = len(middle)
    return contradicting, common


def _middle_of_each_cell(matches: Array, distance: Array, side: int) -> NDArray[np.int64]:
    """Index of the match with the median distance in each cell of the first photo that has several matches.

    Of two in the middle it is the one nearer to its line: more than half of the matches must be off.
    """
    column, row = (matches[:, :2] // (_CELL * side)).astype(np.int64).T
    cell = column * _ROW + row
    order = np.lexsort((distance, cell))
    _, start, count = np.unique(cell[order], return_index=True, return_counts=True)
    start, count = start[count > 1], count[count > 1]
    lower, upper = order[start + (count - 1) // 2], order[start + count // 2]
    return np.where(np.abs(distance[lower]) < np.abs(distance[upper]), lower, upper)


def epipolar_distance(first: Camera, second: Camera, pixels: Array) -> Array:
    """Signed Sampson distance of matches (M, 4) from the epipolar geometry of two cameras, in pixels, shape (M,)."""
    rotation = second.rotation @ first.rotation.T
    x, y, z = second.translation - rotation @ first.translation
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation
    one = np.ones((len(pixels), 1))
    seen_first = np.hstack([first.undistort(pixels[:, :2]), one])
    seen_second = np.hstack([second.undistort(pixels[:, 2:]), one])
    lines, back = seen_first @ essential.T, seen_second @ essential
    slope = (lines[:, :2] ** 2).sum(1) / second.focal_length**2 + (back[:, :2] ** 2).sum(1) / first.focal_length**2
    return (seen_second * lines).sum(1) / np.sqrt(np.maximum(slope, 1e-30))


def _in_company(matches: Array, tolerance: float) -> int:
    """The number of matches (M, 4) around which one affine map explains enough neighbours."""
    if len(matches) <= _NEIGHBOURS:
        return 0
    _, near = KDTree(matches[:, :2]).query(matches[:, :2], _NEIGHBOURS + 1)
    steps = matches[near[:, 1:]] - matches[:, None]
    before, after = steps[..., :2], steps[..., 2:]
    most = np.zeros(len(matches), np.int64)
    for i, j in zip(*np.triu_indices(_NEIGHBOURS, 1)):
        basis = before[:, [i, j]]
        usable = np.abs(np.linalg.det(basis)) > _LEAST_ANGLE * np.linalg.norm(basis, axis=2).prod(1)
        affine = np.linalg.solve(np.where(usable[:, None, None], basis, np.eye(2)), after[:, [i, j]])
        error = np.linalg.norm(before @ affine - after, axis=2)
        most = np.maximum(most, np.where(usable, (error < tolerance).sum(1), 0))
    return int((most >= _AGREEING_NEIGHBOURS).sum())
