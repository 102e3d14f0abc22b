from __future__ import annotations

import numpy as np
from origami.core.paper.height_map import Stiffness, height_map

CELL = 0.5
SHAPE = (80, 100)
CORNER = np.array([-3.0, 2.0])
STIFFNESS = Stiffness(nodes=20, tension=1e-5, pull=1e-8)


def plane(right, down):
    return 0.1 * right - 0.2 * down + 1.0


def scattered(count=400, seed=0):
    random = np.random.default_rng(seed)
    right, down = random.uniform(-3, 47, count), random.uniform(2, 42, count)
    return np.column_stack([right, down, plane(right, down)])


def of_cells():
    row, column = np.indices(SHAPE)
    return plane((column + 0.5) * CELL + CORNER[0], (row + 0.5) * CELL + CORNER[1])


def test_a_plane_is_itself():
    assert np.abs(height_map(scattered(), CORNER, CELL, SHAPE, STIFFNESS) - of_cells()).max() < 0.02


def test_a_few_samples_that_are_far_off_hardly_count():
    samples = scattered()
    samples[::15, 2] += 20
    assert np.median(np.abs(height_map(samples, CORNER, CELL, SHAPE, STIFFNESS) - of_cells())) < 0.3


def test_a_crowd_counts_no_more_than_the_few_around_it():
    crowd = np.tile([20.0, 20.0, plane(20.0, 20.0)], (3000, 1))
    both = height_map(np.concatenate([scattered(), crowd]), CORNER, CELL, SHAPE, STIFFNESS)
    assert np.abs(both - of_cells()).max() < 0.02


def test_no_sample_on_the_map_gives_a_level_map():
    far = np.array([[500.0, 500.0, 3.0]])
    assert np.array_equal(height_map(far, CORNER, CELL, SHAPE, STIFFNESS), np.zeros(SHAPE))
