"""A sheet survives conversion to arrays and back."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.sheet import Sheet, sheet_arrays, sheet_from_arrays


@pytest.mark.parametrize("ridges", [(), ([0, 1],), ([0, 1, 3], [2, 0])])
def test_sheet_comes_back_from_its_arrays(ridges):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]])
    lines = tuple(np.array(ridge) for ridge in ridges)
    sheet = Sheet(vertices, np.array([[0, 1, 2], [1, 3, 2]]), lines, np.array([0, 1, 3, 2]))
    arrays = sheet_arrays(sheet)
    assert all(isinstance(array, np.ndarray) and array.dtype != object for array in arrays.values())
    read = sheet_from_arrays(arrays)
    for name in ("vertices", "triangles", "boundary"):
        np.testing.assert_array_equal(getattr(read, name), getattr(sheet, name))
    assert [ridge.tolist() for ridge in read.ridges] == list(ridges)


@pytest.mark.parametrize("bound", [None, np.array([0.1, 0.2, 0.3])])
def test_its_bound_comes_back_and_older_arrays_have_none(bound):
    sheet = Sheet(np.eye(3), np.array([[0, 1, 2]]), (), np.array([0, 1, 2]), bound)
    arrays = sheet_arrays(sheet)
    assert ("bound" in arrays) == (bound is not None)
    np.testing.assert_array_equal(sheet_from_arrays(arrays).bound, bound)
