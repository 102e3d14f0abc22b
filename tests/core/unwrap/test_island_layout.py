"""Islands turned to the axes and packed."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.triangles import closed_loops
from origami.core.sheet import Sheet
from origami.core.unwrap.island_layout import pack, turn_to_axes
from scipy.spatial import Delaunay


def _sheet(flat: np.ndarray, space: np.ndarray) -> Sheet:
    """A plane sheet through points, its triangles turning from u to v."""
    triangles = Delaunay(flat).simplices.astype(np.int64)
    a, b = (flat[triangles[:, k]] - flat[triangles[:, 0]] for k in (1, 2))
    turned = a[:, 0] * b[:, 1] < a[:, 1] * b[:, 0]
    triangles[turned] = triangles[turned, ::-1]
    return Sheet(space, triangles, (), closed_loops(triangles)[0])


def _turned(flat: np.ndarray, degrees: float) -> np.ndarray:
    angle = np.radians(degrees)
    return flat @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("degrees", [0, 17, 100, -61, 185])
@pytest.mark.parametrize("upright", [False, True])
def test_a_rectangle_is_turned_back_upright(degrees, upright):
    flat = np.stack(np.meshgrid(np.linspace(0, 3, 16), np.linspace(0, 1, 6)), -1).reshape(-1, 2)
    height = np.zeros(len(flat))
    space = np.column_stack([flat[:, 0], height, flat[:, 1]] if upright else [flat, height])
    back = turn_to_axes(_sheet(flat, space), _turned(flat, degrees))
    np.testing.assert_allclose(back - back.mean(0), flat - flat.mean(0), atol=1e-9)


def test_an_oval_lies_along_its_longer_extent():
    angle = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    flat = np.stack([2 * np.cos(angle), 1.4 * np.sin(angle)], -1)
    back = turn_to_axes(_sheet(flat, np.column_stack([flat, 0 * angle])), _turned(flat, 33))
    np.testing.assert_allclose(back, flat, atol=0.05)


def test_boxes_are_packed_without_overlap():
    extents = 0.05 + np.random.default_rng(0).random((40, 2))
    corner = pack(extents, 0.02)
    assert corner.min() >= 0
    for index in range(40):
        after = corner[index] >= corner + extents + 0.02 - 1e-12
        before = corner >= corner[index] + extents[index] + 0.02 - 1e-12
        assert np.delete((after | before).any(1), index).all()
    side = (corner + extents).max()
    assert extents.prod(1).sum() > 0.6 * side**2
