from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.polygon import resample
from origami.core.paper.contour import outward_normals
from origami.core.paper.smooth_contour import raggedness
from origami.core.paper.snapped_contour import snap
from scipy import ndimage

BOX = np.array([[60.0, 50.0], [200.0, 50.0], [200.0, 170.0], [60.0, 170.0]])


def _picture(size=(220, 260), box=BOX, paper=0.8, desk=0.1):
    """A blurred bright box (h, w, 3) on dark ground, in linear light."""
    image = np.full(size, desk, np.float32)
    (left, top), (right, bottom) = box.min(axis=0).astype(int), box.max(axis=0).astype(int)
    image[max(top, 0) : bottom, max(left, 0) : right] = paper
    return np.repeat(ndimage.gaussian_filter(image, 1.0, mode="nearest")[..., None], 3, axis=2)


def _off_corners(points, box=BOX, margin=12.0):
    return (np.abs(points[:, None] - box).max(axis=2) > margin).all(axis=1)


def test_outward_normals_of_a_circle_and_a_square():
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert np.allclose(outward_normals(50 + 30 * circle, 4.0), circle, atol=1e-6)
    normals = outward_normals(resample(BOX, 1.0), 2.0)
    points = resample(BOX, 1.0)
    upper = (points[:, 1] == 50) & (points[:, 0] > 80) & (points[:, 0] < 180)
    assert np.allclose(normals[upper], [0, -1], atol=1e-9)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)


@pytest.mark.parametrize("in_linear_light", [True, False])
@pytest.mark.parametrize("off_by", [-3.0, 3.0])
def test_snap_finds_the_edge_from_inside_and_outside(off_by, in_linear_light):
    rough = BOX + off_by * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    start = resample(rough, 2.0)
    found = snap(_picture(), start, 6.0, 0.5, 0.05, in_linear_light=in_linear_light)
    along = _off_corners(start)
    x, y = found.points[along].T
    from_edge = np.minimum(np.minimum(abs(x - 60), abs(x - 200)), np.minimum(abs(y - 50), abs(y - 170)))
    # perceptual colour sees the steepest place of a blurred edge on its dark side
    assert from_edge.max() < (0.1 if in_linear_light else 0.8)
    assert not found.at_frame.any()


def test_snap_measures_the_step_across_the_edge():
    found = snap(_picture(), resample(BOX, 2.0), 6.0, 0.5, 0.05, in_linear_light=True)
    along = _off_corners(resample(BOX, 2.0))
    # three channels of a step of 0.7; the blur of photo and search together is 1.4 times that of the search
    assert np.median(found.strength[along]) == pytest.approx(100 * 0.7 * np.sqrt(3) / np.sqrt(2), rel=0.1)


def test_snap_stays_where_there_is_no_edge():
    start = resample(BOX, 2.0)
    found = snap(np.full((220, 260, 3), 0.5, np.float32), start, 6.0, 0.5, 0.05, in_linear_light=True)
    assert np.allclose(found.points, start, atol=0.5)
    assert found.strength.max() < 1e-3


def test_snap_marks_what_runs_along_the_frame():
    box = np.array([[0.0, 50.0], [200.0, 50.0], [200.0, 170.0], [0.0, 170.0]])
    start = resample(box, 2.0)
    found = snap(_picture(box=box), start, 6.0, 0.5, 0.05, in_linear_light=True)
    assert found.at_frame[(start[:, 0] < 1)].all()
    assert not found.at_frame[start[:, 0] > 10].any()
    assert (found.strength[found.at_frame] == 0).all()


def test_straight_sides_corners_and_smooth_bends_are_not_ragged():
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    circle = 100 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for smooth in (BOX, circle, 17.0 * BOX):
        assert raggedness(smooth).max() < 0.008


@pytest.mark.parametrize("scale", [1.0, 9.0])
def test_a_side_that_jumps_between_lines_of_print_is_ragged_there_alone_at_any_resolution(scale):
    steps = np.arange(60.0, 200.0, 10.0)
    jagged = np.array([[x + dx, 50.0 + 8.0 * (k % 2)] for k, x in enumerate(steps) for dx in (0.0, 10.0)])
    points = np.vstack([jagged, BOX[2:]]) * scale
    ragged = raggedness(points) > 0.015
    perimeter = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    upper = perimeter[: len(jagged) - 1].sum() / perimeter.sum()
    places = np.arange(len(ragged)) / len(ragged)
    assert ragged[places < upper - 0.03].mean() > 0.7
    assert ragged[(places > upper + 0.03) & (places < 0.97)].mean() == 0
