"""What shows beside the paper along the page's edge is removed, and print that runs over the edge stays."""

from __future__ import annotations

import numpy as np
from origami.core.light.crumbs import find_crumbs, find_slivers

HEIGHT, WIDTH = 1200, 900
COVERED = np.ones((HEIGHT, WIDTH), bool)


def page():
    return np.ones((HEIGHT, WIDTH), np.float32)


def test_a_dark_speck_at_the_edge_is_a_crumb():
    light = page()
    light[500:520, -2:] = 0.2
    crumbs = find_crumbs(light, COVERED)
    assert crumbs[500:520, -2:].all()
    assert not crumbs[:, : WIDTH - 4].any()


def test_print_that_runs_over_the_edge_stays():
    light = page()
    light[100:200, 600:] = 0.3
    assert not find_crumbs(light, COVERED).any()


def test_a_dim_strip_all_along_the_edge_hides_no_crumbs_though_it_meets_print():
    light = page()
    light[:, -2:] = 0.85
    light[100:200, 600:] = 0.3
    light[700:720, -1] = 0.1
    crumbs = find_crumbs(light, COVERED)
    assert crumbs[700:720, -2:].all()
    assert not crumbs[110:190].any()


def test_a_dim_edge_without_anything_dark_stays():
    light = page()
    light[:, -2:] = 0.85
    assert not find_crumbs(light, COVERED).any()


def test_a_thin_strip_that_no_photo_shows_is_a_sliver():
    covered = COVERED.copy()
    covered[:, :3] = False  # the paper's edge is a little slanted
    covered[-2:, 400:] = False
    slivers = find_slivers(covered)
    assert slivers[:, :3].all()
    assert slivers[-2:, 400:].all()
    assert (slivers & covered).sum() == 0


def test_a_part_of_the_page_that_no_photo_shows_is_none():
    covered = COVERED.copy()
    covered[:, :20] = False
    covered[600:700, 300:400] = False
    assert not find_slivers(covered)[10:-10].any()
