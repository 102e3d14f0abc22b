"""The frames of a movie that serve as photos."""

from __future__ import annotations

import numpy as np
from origami.core.photos.frame_choice import choose_frames
from origami.core.photos.view import View


def views(places: np.ndarray, sharpness: np.ndarray) -> list[View]:
    """Views along a path: as unlike as their places are apart."""
    first, second = np.linalg.qr(np.random.default_rng(1).normal(size=(48 * 64, 2)))[0].T.reshape(2, 48, 64)
    thumbnails = [np.cos(each) * first + np.sin(each) * second for each in places]
    return [View(float(sharp), thumbnail) for sharp, thumbnail in zip(sharpness, thumbnails)]


def test_a_short_movie_gives_all_its_frames() -> None:
    assert choose_frames(views(np.linspace(0, 1, 5), np.ones(5)), 12).tolist() == [0, 1, 2, 3, 4]


def test_each_stretch_gives_its_sharpest_frame() -> None:
    sharpness = np.full(60, 0.2)
    sharpest = np.array([2, 7, 13, 21, 28, 32, 39, 44, 46, 53])  # one in each, where the camera moves evenly
    sharpness[sharpest[:8]] = 0.9
    chosen = choose_frames(views(np.linspace(0, 1, 60), sharpness), 6)
    assert len(chosen) == 6
    assert set(chosen.tolist()) <= set(sharpest.tolist()) | set(range(50, 60))


def test_a_blurred_stretch_still_gives_a_frame() -> None:
    sharpness = np.where(np.arange(60) < 20, 0.05, 0.8)
    chosen = choose_frames(views(np.linspace(0, 1, 60), sharpness), 6)
    assert (chosen < 20).sum() == 2


def test_a_camera_that_rests_gives_few_frames_of_its_rest() -> None:
    resting, moving = np.zeros(60), np.linspace(0, 1, 20)
    chosen = choose_frames(views(np.concatenate([resting, moving]), np.ones(80)), 8)
    assert (chosen >= 60).sum() >= 4


def test_a_camera_that_never_moves_gives_frames_spread_over_time() -> None:
    chosen = choose_frames(views(np.zeros(40), np.ones(40)), 4)
    assert chosen.tolist() == [0, 10, 20, 30]
