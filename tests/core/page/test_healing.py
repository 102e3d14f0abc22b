"""Glare, blur, shadows and hands in the reference photo: found, healed where others are better, and never imagined."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from origami.core.numeric.image import shrink
from origami.core.page.healing import BURNT, UNLIKE, heal_page
from origami.core.page.page_light import membrane
from origami.core.page.page_views import view_page
from origami.core.page.render import render_page
from scipy import ndimage

from . import test_render
from .test_render import _HEIGHT, _WIDTH, flat_sheet, view_from

SIZE = (480, 640)
VIEWS = [view_from(x, pixels=800) for x in (0.0, -0.4, 0.4, -0.2, 0.25)]
GAINS = (1.0, 0.85, 0.95, 1.0, 0.9)
CENTRE, RADIUS = (0.4, 0.45), 0.1
_SUBPIXELS = 2
_random = np.random.default_rng(5).uniform(size=(60, 300))


def photo_of(view, print_at, gain=1.0):
    """The plane as a sensor sees it: each pixel is the mean over its area, so strokes are equal in all photos."""
    position = view.center[0]
    fine = test_render.photo_of(view_from(position, pixels=_SUBPIXELS * view.width), print_at, gain)
    return np.rint(shrink(fine, _SUBPIXELS)).astype(np.uint8)


def text(u, v):
    """Lines of irregular strokes between blank margins."""
    line = np.floor(v * 60).astype(int).clip(0, 59)
    stroke = np.floor(u * 400).astype(int).clip(0, 299)
    inside = (np.abs(u - _WIDTH / 2) < 0.3) & (np.abs(v - 0.5) < 0.43) & (v * 60 % 1 < 0.55)
    return np.where(inside & (_random[line, stroke] < 0.5), 50.0, 200.0)


def distance(u, v):
    return np.hypot(u - CENTRE[0], v - CENTRE[1])


def with_glare(u, v):
    return text(u, v) + 260 * np.clip(1.5 - distance(u, v) / RADIUS, 0, 1)


def with_shadow(u, v):
    return text(u, v) * (1 - 0.5 * np.clip((RADIUS * 1.2 - distance(u, v)) / 0.03, 0, 1))


def with_hand(u, v):
    return np.where((distance(u, v) < RADIUS) | ((np.abs(v - CENTRE[1]) < 0.06) & (u > CENTRE[0])), 110.0, text(u, v))


@cache
def _clean():
    return tuple(photo_of(view, text, gain) for view, gain in zip(VIEWS, GAINS, strict=True))


def clean_photos():
    return list(_clean())


def half_blurred(photo):
    """The right half as a moving camera shows it."""
    moved = ndimage.uniform_filter1d(photo.astype(float), 15, axis=1)
    share = np.clip((np.arange(photo.shape[1]) - photo.shape[1] / 2) / 20, 0, 1)[None, :, None]
    return np.rint(photo * (1 - share) + moved * share).astype(np.uint8)


def pages(photos):
    sheet, flat = flat_sheet()
    page = rendered(photos)
    return (page, *heal_page(page, sheet, flat, VIEWS, photos.__getitem__, 0))


def rendered(photos):
    return render_page(*flat_sheet(), VIEWS, photos.__getitem__, 0, SIZE)


SPOILT = {
    "glare": ("glare", lambda photo: photo_of(VIEWS[0], with_glare)),
    "shadow": ("shadow", lambda photo: photo_of(VIEWS[0], with_shadow)),
    "hand": ("shadow", lambda photo: photo_of(VIEWS[0], with_hand)),
    "motion": ("blur", half_blurred),
}


@cache
def spoilt_pages(name):
    """The pages of photos of which the reference alone is spoilt; tests share them, so none may change them."""
    photos = clean_photos()
    photos[0] = SPOILT[name][1](photos[0])
    return pages(photos)


@pytest.mark.parametrize("name", SPOILT)
def test_what_the_reference_alone_has_is_found_and_healed(name):
    kind, _ = SPOILT[name]
    clean = rendered(clean_photos()).image.astype(float)
    before, after, found = spoilt_pages(name)
    assert [blemish.kind for blemish in found] == [kind]
    assert found[0].healed_share > 0.95 * found[0].share
    assert 0 not in found[0].photos

    spoilt = ndimage.gaussian_filter(np.abs(before.image - clean).mean(axis=2), 4) > 12
    replaced = ndimage.binary_closing(after.photo != 0, iterations=3)
    assert (spoilt & replaced).sum() > (0.55 if kind == "blur" else 0.6) * (spoilt | replaced).sum()
    error = np.abs(after.image - clean)[spoilt].mean()
    assert error < 0.35 * np.abs(before.image - clean)[spoilt].mean()


@pytest.mark.parametrize("reference_gain", [1.0, 0.7])
def test_clean_photos_of_unlike_exposure_stay_untouched(reference_gain):
    photos = clean_photos()
    photos[0] = photo_of(VIEWS[0], text, reference_gain)
    before, after, found = pages(photos)
    assert found == ()
    assert after is before


def test_pixels_outside_the_healed_regions_are_the_reference_photos_own():
    before, after, _ = spoilt_pages("hand")
    changed = (after.image != before.image).any(axis=2)
    far = ~ndimage.binary_dilation(after.photo != before.photo, iterations=12)
    assert not changed[far].any()
    np.testing.assert_array_equal(after.position[after.photo == 0], before.position[after.photo == 0])


def test_map_shows_where_healed_pixels_come_from():
    _, after, found = spoilt_pages("shadow")
    row, column = round(CENTRE[1] * 640), round(CENTRE[0] * 640)
    taken = after.photo[row, column]
    assert taken == found[0].photos[0]
    point = np.array([(column + 0.5) / 640 - _WIDTH / 2, _HEIGHT / 2 - (row + 0.5) / 640, 0])
    assert np.abs(after.position[row, column] - VIEWS[taken].project(point)).max() < 1


def test_a_shadow_in_another_photo_is_not_the_references():
    photos = clean_photos()
    photos[2] = photo_of(VIEWS[2], with_hand)
    photos[3] = half_blurred(photos[3])
    assert pages(photos)[2] == ()


def test_what_is_burnt_out_in_every_photo_is_said_and_left():
    def burnt(u, v):
        return np.where(distance(u, v) < RADIUS, 255.0, text(u, v))

    photos = [photo_of(view, burnt, 1.0) for view in VIEWS]
    before, after, found = pages(photos)
    assert after is before
    assert [blemish.kind for blemish in found] == [BURNT]
    assert found[0].healed_share == 0
    assert found[0].share == pytest.approx(np.pi * RADIUS**2 / (_WIDTH * _HEIGHT), rel=0.2)


def test_print_that_does_not_meet_is_left_and_said():
    photos = clean_photos()
    photos[0] = photo_of(VIEWS[0], with_hand)
    sheet, flat = flat_sheet()
    # Towards the camera by a tenth of the page: each photo shows the print elsewhere.
    wrong = replace(sheet, vertices=sheet.vertices + np.array([0, 0, 0.1]))
    page = render_page(wrong, flat, VIEWS, photos.__getitem__, 0, SIZE)
    after, found = heal_page(page, wrong, flat, VIEWS, photos.__getitem__, 0)
    assert after is page
    assert [blemish.kind for blemish in found] == [UNLIKE]


def test_two_photos_alone_cannot_say_which_is_wrong():
    photos = clean_photos()[:2]
    photos[0] = photo_of(VIEWS[0], with_hand)
    sheet, flat = flat_sheet()
    page = render_page(sheet, flat, VIEWS[:2], photos.__getitem__, 0, SIZE)
    assert heal_page(page, sheet, flat, VIEWS[:2], photos.__getitem__, 0) == (page, ())


def test_sixteen_bits_are_healed_from_eight():
    _, shallow, _ = spoilt_pages("hand")
    photos = clean_photos()
    photos[0] = photo_of(VIEWS[0], with_hand).astype(np.uint16) * 257
    _, deep, found = pages(photos)
    assert found and deep.image.dtype == np.uint16
    np.testing.assert_array_equal(deep.photo, shallow.photo)
    assert np.abs(deep.image - shallow.image * 257.0).max() <= 257


def test_photos_are_read_one_at_a_time():
    sheet, flat = flat_sheet()
    asked = []
    photos = clean_photos()
    view_page(sheet, flat, VIEWS, lambda index: asked.append(index) or photos[index])
    assert asked == list(range(len(VIEWS)))


def test_a_membrane_over_a_plane_is_the_plane():
    rows, columns = np.indices((20, 30), dtype=float)
    plane = np.stack([2 * rows - columns, columns], axis=-1)
    known = np.ones(rows.shape, bool)
    known[5:15, 8:22] = False
    np.testing.assert_allclose(membrane(np.where(known[..., None], plane, 99), known), plane, atol=1e-9)
