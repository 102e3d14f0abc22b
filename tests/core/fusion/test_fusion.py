"""The page from all photos: what single photos spoil is gone, nothing is doubled, and nothing shows where they meet."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import printed_plane
import pytest
from origami.core.fusion.fusion import fuse_page
from origami.core.numeric.image import shrink
from origami.core.page.single_photo import page_of_photo
from origami.core.sheet import FlatMap
from printed_plane import HEIGHT, WIDTH, flat_sheet, letters, paper, sheet_from, view_from
from scipy import ndimage

SIZE = (480, 640)
VIEWS = [view_from(x, pixels=800) for x in (0.0, -0.4, 0.4, -0.2, 0.25)]
GAINS = (1.0, 0.85, 0.95, 1.0, 0.9)
CENTRE, RADIUS = (0.4, 0.45), 0.1
_SUBPIXELS = 2
_random = np.random.default_rng(5).uniform(size=(60, 300))


def photo_of(view, print_at, gain=1.0):
    """The plane as a sensor sees it: each pixel is the mean over its area, so strokes are equal in all photos."""
    position = view.center[0]
    fine = printed_plane.photo_of(view_from(position, pixels=_SUBPIXELS * view.width), print_at, gain)
    return np.rint(shrink(fine, _SUBPIXELS)).astype(np.uint8)


def text(u, v):
    """Lines of irregular strokes between blank margins."""
    line = np.floor(v * 60).astype(int).clip(0, 59)
    stroke = np.floor(u * 400).astype(int).clip(0, 299)
    inside = (np.abs(u - WIDTH / 2) < 0.3) & (np.abs(v - 0.5) < 0.43) & (v * 60 % 1 < 0.55)
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


def fused(photos, sheet_and_flat=None, views=VIEWS, size=SIZE):
    sheet, flat = sheet_and_flat or flat_sheet()
    return fuse_page(sheet, flat, views[: len(photos)], photos.__getitem__, 0, size)


def of_reference(photo):
    sheet, flat = flat_sheet()
    return page_of_photo(sheet, flat, VIEWS, [photo].__getitem__, 0, SIZE).image.astype(float)


SPOILT = {
    "glare": lambda: photo_of(VIEWS[0], with_glare),
    "shadow": lambda: photo_of(VIEWS[0], with_shadow),
    "hand": lambda: photo_of(VIEWS[0], with_hand),
    "motion": lambda: half_blurred(_clean()[0]),
}


@pytest.mark.parametrize("name", SPOILT)
def test_what_the_reference_alone_has_is_gone(name):
    photos = clean_photos()
    clean = of_reference(photos[0])
    photos[0] = SPOILT[name]()
    before = np.abs(of_reference(photos[0]) - clean).mean(axis=2)
    page = fused(photos)
    after = np.abs(page.texture.image - clean).mean(axis=2)
    spoilt = ndimage.gaussian_filter(before, 4) > 12
    assert after[spoilt].mean() < 0.35 * before[spoilt].mean()
    assert after[ndimage.gaussian_filter(before, 4) < 0.5].mean() < 5  # strokes are 150 levels dark
    assert page.burnt_share == 0
    spoilt_share = {"glare": 0.094, "shadow": 0.06, "hand": 0.09, "motion": 0.0}[name]
    assert page.healed_share == pytest.approx(spoilt_share, rel=0.25)


@pytest.mark.parametrize("reference_gain", [1.0, 0.7])
def test_the_page_has_the_references_exposure(reference_gain):
    photos = clean_photos()
    photos[0] = photo_of(VIEWS[0], text, reference_gain)
    blank = np.s_[:30, 50:-50]
    assert np.abs(fused(photos).texture.image[blank] - of_reference(photos[0])[blank]).max() <= 3


def test_what_single_other_photos_have_is_not_on_the_page():
    photos = clean_photos()
    clean = fused(photos).texture.image.astype(float)
    photos[2] = photo_of(VIEWS[2], with_hand)
    photos[3] = half_blurred(photos[3])
    difference = ndimage.gaussian_filter(np.abs(fused(photos).texture.image - clean).mean(axis=2), 4)
    assert difference.max() < 12


def test_a_bright_hand_on_a_dark_sheet_is_gone():
    def dark(u, v):
        return 0.2 * text(u, v)

    def with_bright_hand(u, v):
        return np.where(distance(u, v) < RADIUS, 185.0, dark(u, v))

    photos = [photo_of(view, dark, gain) for view, gain in zip(VIEWS, GAINS, strict=True)]
    clean = fused(photos).texture.image.astype(float)
    photos[0] = photo_of(VIEWS[0], with_bright_hand)
    difference = ndimage.gaussian_filter(np.abs(fused(photos).texture.image - clean).mean(axis=2), 4)
    assert difference.max() < 12  # the hand is 145 levels brighter


def test_a_noisy_photo_hardly_counts_on_blank_paper():
    photos = clean_photos()
    noise = np.random.default_rng(2).normal(0, 12, photos[1].shape)
    photos[1] = np.clip(photos[1] + noise, 0, 255).astype(np.uint8)
    margin = fused(photos).texture.image[5:35, 50:-50, 1].astype(float)
    assert margin.std() < 1.5


def test_a_hand_as_bright_as_the_paper_is_known_by_its_colour():
    photos = clean_photos()
    clean = fused(photos).texture.image.astype(float)
    hand = photo_of(VIEWS[0], lambda u, v: np.where(distance(u, v) < RADIUS, 1.0, 0.0), 1.0)[..., :1] > 0
    photos[0] = np.where(hand, np.array([230, 190, 130], np.uint8), photos[0])
    difference = ndimage.gaussian_filter(fused(photos).texture.image - clean, (4, 4, 0))  # not the strokes
    assert np.abs(difference).max() < 10  # a hand is 70 levels bluer


def test_a_photo_in_black_and_white_takes_no_colour_away():
    def in_blue(photo):
        dark = photo[..., :1] < 120
        return np.where(dark, np.array([40, 60, 190], np.uint8), photo)

    photos = [in_blue(photo) for photo in clean_photos()]
    clean = fused(photos).texture.image.astype(float)
    photos[0] = np.repeat(photos[0].mean(axis=2, keepdims=True).astype(np.uint8), 3, axis=2)
    grey = fused(photos).texture.image.astype(float)
    blueness = [(each[..., 2] - each[..., 0])[100:-100, 80:-80].mean() for each in (clean, grey)]
    assert blueness[1] > 0.8 * blueness[0] > 5


def test_the_map_shows_where_pixels_come_from():
    photos = clean_photos()
    photos[0] = photo_of(VIEWS[0], with_hand)
    texture = fused(photos).texture
    row, column = round(CENTRE[1] * 640), round(CENTRE[0] * 640)
    taken = texture.photo[row, column]
    assert taken != 0
    point = np.array([(column + 0.5) / 640 - WIDTH / 2, HEIGHT / 2 - (row + 0.5) / 640, 0])
    assert np.abs(texture.position[row, column] - VIEWS[taken].project(point)).max() < 1


def test_what_is_burnt_out_in_every_photo_is_counted():
    def burnt(u, v):
        return np.where(distance(u, v) < RADIUS, 255.0, text(u, v))

    page = fused([photo_of(view, burnt) for view in VIEWS])
    assert page.burnt_share == pytest.approx(np.pi * RADIUS**2 / (WIDTH * HEIGHT), rel=0.2)


def test_print_that_does_not_meet_is_not_doubled():
    photos = clean_photos()
    sheet, flat = flat_sheet()
    # Towards the camera by a tenth of the page: each photo shows the print elsewhere, five lines and more away.
    wrong = replace(sheet, vertices=sheet.vertices + np.array([0, 0, 0.1]))
    texture = fuse_page(wrong, flat, VIEWS, photos.__getitem__, 0, SIZE).texture
    single = [page_of_photo(wrong, flat, VIEWS, photos.__getitem__, k, SIZE).image.astype(float) for k in range(5)]
    contrast = ndimage.gaussian_filter(texture.image[..., 0].astype(float) ** 2, 8)
    contrast -= ndimage.gaussian_filter(texture.image[..., 0].astype(float), 8) ** 2
    of_single = [
        ndimage.gaussian_filter(s[..., 0] ** 2, 8) - ndimage.gaussian_filter(s[..., 0], 8) ** 2 for s in single
    ]
    inside = np.s_[120:-120, 100:-100]
    assert np.median((contrast / np.max(of_single, axis=0))[inside]) > 0.6  # the mean of five would have a fifth


@pytest.mark.parametrize("count", [1, 2])
def test_few_photos_make_a_whole_page(count):
    photos = clean_photos()[:count]
    texture = fused(photos).texture
    assert texture.blank_share == 0
    assert np.abs(texture.image - of_reference(photos[0])).mean() < 4


def test_sixteen_bits_are_blended_with_eight():
    photos = clean_photos()
    shallow = fused(photos).texture
    photos[0] = photos[0].astype(np.uint16) * 257
    deep = fused(photos).texture
    assert deep.image.dtype == np.uint16
    assert (deep.photo != shallow.photo).mean() < 1e-4  # where two photos count the same, rounding decides
    assert np.abs(deep.image / 257.0 - shallow.image).max() <= 1


def test_each_photo_is_read_twice_at_most():
    asked = []
    photos = clean_photos()
    sheet, flat = flat_sheet()
    fuse_page(sheet, flat, VIEWS, lambda index: asked.append(index) or photos[index], 0, SIZE)
    assert max(asked.count(index) for index in range(len(VIEWS))) == 2


def test_threads_do_not_change_the_page():
    photos = clean_photos()
    sheet, flat = flat_sheet()
    pages = [fuse_page(sheet, flat, VIEWS, photos.__getitem__, 0, SIZE, threads).texture for threads in (1, 2)]
    np.testing.assert_array_equal(pages[0].image, pages[1].image)


def test_sharp_photo_beats_a_larger_blurred_one():
    cameras = [view_from(0.1, distance=1.8), view_from(-0.1, distance=2.0)]
    photos = [printed_plane.photo_of(cameras[0], letters, blur=3), printed_plane.photo_of(cameras[1], letters)]
    texture = fused(photos, views=cameras, size=printed_plane.SIZE).texture
    inside = np.s_[15:-15, 15:-15]
    assert (texture.photo[inside] == 1).mean() > 0.95


def test_desk_beside_the_paper_is_not_taken_for_the_page():
    cameras = [view_from(0.1), view_from(-0.1)]

    def with_desk(u, v):
        return np.where(u < 0.02 + 0.01 * np.sin(9 * v), 15.0, letters(u, v))

    photos = [printed_plane.photo_of(cameras[0], letters, blur=2), printed_plane.photo_of(cameras[1], with_desk)]
    texture = fused(photos, views=cameras, size=printed_plane.SIZE).texture
    assert texture.image[:, :14].min() > 150  # blank margin, no desk


def test_photos_of_unlike_exposure_meet_without_a_seam():
    """Nothing is printed, so any step in brightness would show."""
    cameras = [view_from(-1.5), view_from(1.5)]
    photos = [printed_plane.photo_of(cameras[k], paper, gain=gain) for k, gain in enumerate((1.0, 0.7))]
    bent = sheet_from(lambda x: (x, -0.9 * np.abs(x)))
    texture = fused(photos, bent, cameras, printed_plane.SIZE).texture
    assert set(np.unique(texture.photo)) == {0, 1}
    inner = texture.image[8:-8, 8:-8, 0].astype(int)
    assert np.ptp(inner) <= 3
    assert abs(np.median(inner) - 200) <= 2  # the reference's exposure


def test_what_is_hidden_in_a_photo_is_taken_from_another():
    """A steep ridge along the page's middle: each camera sees only the side that is turned to it."""
    steep = sheet_from(lambda x: (0.5 * x, -0.87 * np.abs(x)))
    photos = [np.full((400, 400, 3), 80, np.uint8)] * 2
    texture = fused(photos, steep, [view_from(-2.5), view_from(2.5)], printed_plane.SIZE).texture
    assert (texture.photo[:, :110] == 0).mean() > 0.98
    assert (texture.photo[:, 130:] == 1).mean() > 0.98


def test_page_outside_the_mesh_is_white_and_counted():
    sheet, flat = flat_sheet()
    wider = FlatMap(flat.uv, 2 * WIDTH, HEIGHT, flat.unit, None)
    texture = fused(clean_photos(), (sheet, wider), size=(960, 640)).texture
    assert texture.blank_share == pytest.approx(0.5, abs=0.01)
    assert (texture.image[:, 490:] == 255).all()
    assert (texture.photo[:, 490:] == -1).all()
