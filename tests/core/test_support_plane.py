from __future__ import annotations

import numpy as np
import pytest
from flat_scene import sparse_model
from origami.core.support_plane import height_above_desk

NOISE = 0.001


def _scene(sheet_height=0.3, desk=1.2, sheet=300, ground=400, seed=0):
    """A curved sheet of 1 x 1 raised over a desk of which a ring around it is seen; heights of the points (N,)."""
    random = np.random.default_rng(seed)
    on_sheet = random.uniform(-0.5, 0.5, (sheet, 2))
    on_desk = random.uniform(-desk, desk, (4 * ground, 2))
    on_desk = on_desk[np.abs(on_desk).max(axis=1) > 0.55][:ground]
    height = np.concatenate([sheet_height * (1 + on_sheet[:, 0] ** 2), random.normal(scale=NOISE, size=len(on_desk))])
    plane = np.concatenate([on_sheet, on_desk])
    centres = [[0.1 * i, 0.0, 0.0] for i in range(4)]
    model = sparse_model(np.column_stack([plane, 3 - height]), centres, 600.0, (700, 700))
    return model, np.where(np.arange(len(plane)) < sheet, 1.0, 0.4), height, plane


def test_height_is_measured_in_noise_of_the_desk_upwards():
    model, prominence, true, _ = _scene()
    height = height_above_desk(model, prominence)
    assert height.shape == true.shape
    assert np.allclose(height[:300] / true[:300], 1 / NOISE, rtol=0.15)
    assert 0.8 < height[300:].std() < 1.25
    assert abs(height[300:].mean()) < 0.2


def test_points_left_out_of_the_search_are_measured_too():
    model, prominence, true, _ = _scene()
    prominence[::10] = 0
    height = height_above_desk(model, prominence)
    assert np.allclose(height[:300:10] / true[:300:10], 1 / NOISE, rtol=0.15)


@pytest.mark.parametrize(
    "missing",
    [
        lambda plane, on_desk: np.zeros(len(plane), bool),
        lambda plane, on_desk: on_desk,
        lambda plane, on_desk: on_desk & (plane[:, 0] < 0.5),
        lambda plane, on_desk: np.arange(len(plane)) % 20 > 0,
    ],
    ids=["flat sheet", "bare desk", "desk on one side", "few points"],
)
def test_no_desk_where_it_cannot_be_told(missing, request):
    flat = "flat sheet" in request.node.callspec.id
    model, prominence, _, plane = _scene(sheet_height=0.0 if flat else 0.3)
    prominence[missing(plane, np.arange(len(plane)) >= 300)] = 0
    assert height_above_desk(model, prominence) is None
