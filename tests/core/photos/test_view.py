"""How sharp a photo is, and how much two photos show the same view."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.photos.view import likeness, view_of
from photo_scene import folded_sheet, poses, print_texture, render
from scipy import ndimage


def taken(spread: float, count: int) -> list[np.ndarray]:
    """Photos of a sheet with one dark picture on a grey desk, from an arc of ``spread`` degrees to either side."""
    page = np.full_like(print_texture(1), 230.0)
    page[100:300, 80:400] = print_texture(1)[:200, :320] * 0.4
    return [
        render(pose, folded_sheet(), page, None, size=(480, 640)) for pose in poses(count, spread, roll=0.0, seed=4)
    ]


def test_a_blurred_photo_is_less_sharp_and_still_the_same_view() -> None:
    photo = taken(0, 1)[0]
    blurred = ndimage.gaussian_filter(photo, (3, 3, 0))
    assert view_of(blurred).sharpness < 0.5 * view_of(photo).sharpness
    assert likeness(view_of(photo), view_of(blurred)) > 0.99


def test_light_and_depth_of_colour_do_not_matter() -> None:
    photo = taken(0, 1)[0]
    darker = (photo * 0.5).astype(np.uint8)
    deep = photo.astype(np.uint16) * 257
    assert likeness(view_of(photo), view_of(darker)) > 0.999
    assert likeness(view_of(photo), view_of(deep)) == pytest.approx(1, abs=1e-6)
    assert view_of(deep).sharpness == pytest.approx(view_of(photo).sharpness, rel=0.01)


def test_a_hand_that_shakes_shows_the_same_view_and_a_step_aside_another() -> None:
    photo = taken(0, 1)[0]
    shaken = np.roll(photo, (3, -4), axis=(0, 1))
    left, middle, right = (view_of(each) for each in taken(80, 3))
    assert likeness(view_of(photo), view_of(shaken)) > 0.94
    assert likeness(left, right) < likeness(left, middle) < 0.9


def test_photos_of_other_shapes_and_of_one_tone_are_like_nothing() -> None:
    photo = taken(0, 1)[0]
    turned, flat = photo.swapaxes(0, 1), np.full_like(photo, 90)
    assert likeness(view_of(photo), view_of(turned)) == 0
    assert likeness(view_of(photo), view_of(flat)) == 0
    assert view_of(flat).sharpness == 0
