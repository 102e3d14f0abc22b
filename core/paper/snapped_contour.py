"""A contour snapped to the edge in a photo, as one path of least cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import Image, perceptual, sample_bilinear
from ..numeric.peaks import peak_offset
from .contour import outward_normals

# Values without a figure are choices; no measurement of them is recorded.
# The snapped path: the normals are smoothed over this many points, and the profiles across it over this many points
# along it and pixels across it; samples beyond the reach that the blur needs.
_SMOOTH_NORMALS, _BLUR_ALONG, _BLUR_ACROSS, _MARGIN = 4.0, 1.0, 1.0, 6
# Pixels nearer than this to the photo's border have no complete neighbourhood. A contour that comes within this part of
# the reach to the border runs along it.
_INCOMPLETE, _AT_FRAME = 1.5, 0.2
# An edge counts fully from this percentile of the strongest edges of this many points around it; an edge at the end of
# the reach costs this more than one in the middle, in units of a full edge.
_FULL_EDGE, _AROUND, _FAR_COST = 60, 61, 0.3
# Largest shift between neighbours of the snapped path, samples, and the part of the loop by which its ends overlap.
_MOST_JUMP, _OVERLAP = 3, 8


@dataclass(frozen=True)
class Snapped:
    """The edge near a contour.

    Attributes
    ----------
    points : (M, 2) array
        Pixels.
    strength : (M,) array
        Colour step across the edge, 0 to about 100.
    at_frame : (M,) bool array
        Where the contour runs along the border of the photo, which is not an edge.
    normals : (M, 2) array
        Unit vectors outwards from the contour, along which its points moved.
    """

    points: Array
    strength: Array
    at_frame: NDArray[np.bool_]
    normals: Array


def snap(
    photo: NDArray[np.float32] | Image,
    points: Array,
    reach: float,
    step: float,
    stiffness: float,
    in_linear_light: bool,
) -> Snapped:
    """Move each point of a contour along its normal to the edge there, as one path of least cost.

    Parameters
    ----------
    photo : (h, w, 3) array
        A photo, or floating point in linear light.
    points : (M, 2) array
        Evenly spaced, clockwise, pixels.
    reach : float
        How far to look inwards and outwards, pixels.
    step : float
        Distance between samples along the normal, pixels.
    stiffness : float
        Cost of one pixel of difference between the shifts of neighbours, in units of a full edge.
    in_linear_light : bool
        Whether the steepest place is sought in linear light, in which a blurred edge has it exactly at the edge, or in
        perceptual colour, in which dim edges count like bright ones.
    """
    normals = outward_normals(points, _SMOOTH_NORMALS)
    half = int(np.ceil(reach / step))
    shifts = np.arange(-half, half + 1) * step
    margin = np.arange(-half - _MARGIN, half + _MARGIN + 1) * step
    positions = points[:, None] + margin[None, :, None] * normals[:, None]
    sampled = sample_bilinear(photo, positions)
    profile = 100 * sampled if in_linear_light else perceptual(sampled)
    profile = ndimage.gaussian_filter1d(profile, _BLUR_ALONG, axis=0, mode="wrap")
    slope = ndimage.gaussian_filter1d(profile, _BLUR_ACROSS / step, axis=1, order=1, mode="nearest")[
        :, _MARGIN:-_MARGIN
    ]
    strength = np.sqrt((slope**2).sum(axis=2))
    height, width = photo.shape[:2]
    at = positions[:, _MARGIN:-_MARGIN]
    beyond = (at < _INCOMPLETE).any(axis=2)
    beyond |= (at[..., 0] > width - _INCOMPLETE) | (at[..., 1] > height - _INCOMPLETE)
    strength[beyond] = 0
    border = _AT_FRAME * reach
    at_frame = ((points < border) | (points > np.array([width, height]) - border)).any(axis=1)
    strength[at_frame] = 0
    peak = ndimage.percentile_filter(strength.max(axis=1), _FULL_EDGE, size=_AROUND, mode="wrap")
    cost = -np.minimum(strength / np.maximum(peak, 1e-6)[:, None], 1.0)
    cost += _FAR_COST * (shifts / reach)[None, :] ** 2
    path = _cheapest_loop(cost, stiffness * step)
    rows = np.arange(len(points))
    inner = np.clip(path, 1, len(shifts) - 2)
    before, here, after = (strength[rows, inner + offset] for offset in (-1, 0, 1))
    shift = shifts[inner] + np.clip(peak_offset(before, here, after), -1, 1) * step
    # the step of a blurred edge: peak slope (per sample) times the width of the blur
    return Snapped(points + shift[:, None] * normals, here * (np.sqrt(2 * np.pi) / step), at_frame, normals)


def _cheapest_loop(cost: Array, stiffness: float) -> NDArray[np.int64]:
    """Column of each row of ``cost`` (M, K) on the closed path of least cost; neighbours differ by a few columns.

    The loop is cut open and extended at both ends by a part of itself, which is dropped afterwards.
    """
    rows, columns = cost.shape
    overlap = rows // _OVERLAP
    order = (np.arange(rows + 2 * overlap) - overlap) % rows
    jump_cost = stiffness * np.abs(np.arange(-_MOST_JUMP, _MOST_JUMP + 1))
    everywhere = np.arange(columns)
    # the totals that each column can be reached from are windows of one array, without copies
    padded = np.full(columns + 2 * _MOST_JUMP, np.inf)
    total = padded[_MOST_JUMP:-_MOST_JUMP]
    reached_from = sliding_window_view(padded, len(jump_cost))
    total[:] = cost[order[0]]
    back = np.zeros((len(order), columns), np.int64)
    for index in range(1, len(order)):
        candidates = reached_from + jump_cost
        back[index] = candidates.argmin(axis=1)
        total[:] = candidates[everywhere, back[index]] + cost[order[index]]
    path = np.empty(len(order), np.int64)
    path[-1] = total.argmin()
    for index in range(len(order) - 1, 0, -1):
        path[index - 1] = path[index] + back[index, path[index]] - _MOST_JUMP
    return path[overlap : overlap + rows]
