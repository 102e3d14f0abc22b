"""The frame around a page as the user drags it: its handles, where they take it, and what it cuts off."""

from __future__ import annotations

import numpy as np

from ..arrays import Array

# The four corners, clockwise from top left, then the middles of the sides after each: top, right, bottom, left.
HANDLES = 8
_ACROSS = (1, 0, 1, 0)  # the axis along which each side moves: v, u, v, u


def handles_of(corners: Array) -> Array:
    """Where the handles of a frame (4, 2) are: its corners, then the middles of its sides, (8, 2)."""
    return np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])


def drag_handle(corners: Array, handle: int, place: Array) -> Array:
    """The frame (4, 2) once a handle is at a place (2,): a corner goes there, a side only moves across itself.

    Examples
    --------
    >>> page = np.array([[0, 0], [2, 0], [2, 3], [0, 3.0]])
    >>> drag_handle(page, 4, np.array([1.5, 0.5])).tolist()
    [[0.0, 0.5], [2.0, 0.5], [2.0, 3.0], [0.0, 3.0]]
    """
    moved = corners.copy()
    if handle < len(corners):
        moved[handle] = place
        return moved
    side = handle - len(corners)
    axis = _ACROSS[side]
    moved[[side, (side + 1) % len(corners)], axis] += place[axis] - handles_of(corners)[handle, axis]
    return moved


def cut_off(corners: Array, width: float, height: float) -> Array:
    """How much each side of a frame (4, 2) cuts off a page, negative where it adds: top, right, bottom, left, (4,).

    A side that is not parallel to the page's counts by its middle.

    Examples
    --------
    >>> cut_off(np.array([[1, 0], [10, 0], [10, 22], [1, 22.0]]), 10, 20).tolist()
    [0.0, 0.0, -2.0, 1.0]
    """
    top, right, bottom, left = handles_of(corners)[len(corners) :]
    return np.array([top[1], width - right[0], height - bottom[1], left[0]])
