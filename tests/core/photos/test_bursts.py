"""Many photos from one place are thinned; photos from different places stay."""

from __future__ import annotations

import numpy as np
from origami.core.photos.bursts import near_duplicates
from origami.core.photos.view import View


def burst(count: int, place: int, sharpness: float = 0.5) -> list[View]:
    """Views of one place whose sharpness rises a little from one to the next."""
    pattern = np.random.default_rng(place).normal(size=(48, 64))
    pattern -= pattern.mean()
    return [View(sharpness + 0.01 * index, pattern / np.linalg.norm(pattern)) for index in range(count)]


def test_the_sharpest_photo_of_a_burst_stays() -> None:
    views = [*burst(5, 1), *burst(1, 2), *burst(4, 3)]
    assert near_duplicates(views, enough=3) == {0: 4, 1: 4, 2: 4, 3: 4, 6: 9, 7: 9, 8: 9}


def test_enough_photos_stay_and_the_least_sharp_go_first() -> None:
    assert near_duplicates(burst(6, 1), enough=4) == {0: 5, 1: 5}


def test_different_views_stay_all() -> None:
    assert near_duplicates([burst(1, place)[0] for place in range(15)], enough=3) == {}
