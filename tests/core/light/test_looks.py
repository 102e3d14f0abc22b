"""The light is taken off the page, exactly at folds, and print, pictures and the paper's tone stay what they are."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.light.looks import relit
from origami.core.light.normals import corner_normals
from origami.core.numeric.image import encoded, linear_light
from origami.core.sheet import FlatMap, Sheet

SIZE = (600, 800)
WIDTH, HEIGHT = 0.75, 1.0
FOLD = 0.4  # of the height
WHITE, TONED = np.array([0.8, 0.8, 0.8]), np.array([0.8, 0.7, 0.5])


def folded(angle=40.0, rows=40, columns=30):
    """A sheet folded along a row of vertices; the lower part rises towards the viewer."""
    v = np.concatenate([np.linspace(0, FOLD, rows // 2 + 1), np.linspace(FOLD, HEIGHT, rows // 2 + 1)[1:]])
    u, v = np.meshgrid(np.linspace(0, WIDTH, columns + 1), v)
    below = np.maximum(v - FOLD, 0)
    bend = np.deg2rad(angle)
    y = np.minimum(v, FOLD) + below * np.cos(bend)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    vertices = np.stack([u, -y, below * np.sin(bend)], -1).reshape(-1, 3)
    sheet = Sheet(vertices, triangles, (index[rows // 2],), np.concatenate([index[:-1, 0], index[-1, :-1]]))
    return sheet, FlatMap(np.stack([u, v], -1).reshape(-1, 2), WIDTH, HEIGHT, "page heights", None)


def places():
    u, v = np.meshgrid((np.arange(SIZE[0]) + 0.5) / SIZE[0] * WIDTH, (np.arange(SIZE[1]) + 0.5) / SIZE[1])
    return u, v


def light():
    """A lamp from above the page: each half has its own light, which also falls off to the right."""
    u, v = places()
    half = np.where(v < FOLD, 1.0, 0.55)
    return (half * (1 - 0.5 * u))[..., None] * np.array([1.0, 0.95, 0.85])


def printed(paper):
    """Lines of strokes, a dark picture and a tinted box on paper of a colour: the reflectance of each pixel."""
    u, v = places()
    page = np.broadcast_to(paper, (*u.shape, 3)).copy()
    strokes = (v % 0.025 < 0.012) & (u % 0.012 < 0.006) & (u > 0.06) & (u < 0.69) & (v > 0.06) & (v < 0.94)
    page[strokes] *= 0.08
    page[(u > 0.1) & (u < 0.4) & (v > 0.5) & (v < 0.75)] = [0.02, 0.05, 0.08]
    page[(u > 0.5) & (u < 0.68) & (v > 0.6) & (v < 0.75)] = paper * [0.75, 0.85, 1.0]
    return page


def look(reflectance, how, dtype=np.uint8):
    sheet, flat = folded()
    image = encoded((reflectance * light()).astype(np.float32), np.dtype(dtype))
    return image, relit(image, np.ones(image.shape[:2], bool), sheet, flat, how)


def test_on_white_each_colour_is_its_share_of_the_papers():
    page = printed(WHITE)
    _, found = look(page, "white")
    off = linear_light(found.image) - page / WHITE
    inside = np.s_[10:-10, 10:-10]
    assert np.percentile(np.abs(off)[inside], 99) < 0.02
    near_fold = np.s_[round(FOLD * SIZE[1]) - 2 : round(FOLD * SIZE[1]) + 2, 10:40]  # blank margin
    assert np.abs(off[near_fold]).max() < 0.03
    assert 0.2 < found.blank.mean() < 0.7


def test_toned_paper_keeps_its_tone_and_loses_the_shading():
    _, found = look(printed(TONED), "paper")
    blank = linear_light(found.image[10:-10, 8:40])  # the left margin
    cast = np.array([1.0, 0.95, 0.85])  # of the lamp, which no photo can tell from the paper's
    expected = TONED * cast / (TONED * cast).max()
    np.testing.assert_allclose(blank.mean(axis=(0, 1)) / blank.mean(axis=(0, 1)).max(), expected, atol=0.01)
    assert np.ptp(blank[..., 1]) < 0.05
    assert blank[..., 0].mean() == pytest.approx(0.88, abs=0.01)


def test_as_photographed_nothing_changes():
    image, found = look(printed(WHITE), "as-photographed")
    assert found.image is image


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(lambda u, v: [0.05 + 0.6 * u, 0.3 + 0.2 * v, 0.7 - 0.5 * u], id="coloured to its edges"),
        pytest.param(
            lambda u, v: [np.where((u * 60 % 1 < 0.3) & (v * 40 % 1 < 0.4), 0.7, 0.05)] * 3, id="white on black"
        ),
        pytest.param(lambda u, v: [np.random.default_rng(1).uniform(0.1, 0.8, u.shape)] * 3, id="no blank paper"),
    ],
)
def test_a_page_without_blank_paper_stays_as_it_is(page):
    image, found = look(np.stack([np.broadcast_to(c, places()[0].shape) for c in page(*places())], axis=-1), "white")
    assert found.paper is None
    np.testing.assert_array_equal(found.image, image)


def test_sixteen_bits_stay_sixteen_bits():
    shallow, deep = (look(printed(WHITE), "white", dtype)[1].image for dtype in (np.uint8, np.uint16))
    assert deep.dtype == np.uint16
    assert np.abs(deep / 257.0 - shallow)[linear_light(shallow) < 0.9].max() < 4


def test_what_no_photo_shows_stays_white():
    sheet, flat = folded()
    image = encoded((printed(WHITE) * light()).astype(np.float32), np.dtype(np.uint8))
    covered = np.ones(image.shape[:2], bool)
    covered[:, :20] = False
    image[:, :20] = 255
    assert (relit(image, covered, sheet, flat, "paper").image[:, :20] == 255).all()


@pytest.mark.parametrize("size", [(1, 1), (3, 5), (30, 40)])
def test_tiny_pages_have_a_look_too(size):
    sheet, flat = folded()
    image = np.full((*size[::-1], 3), 180, np.uint8)
    assert relit(image, np.ones(size[::-1], bool), sheet, flat, "white").image.shape == image.shape


def test_an_unknown_look_is_refused():
    with pytest.raises(ValueError, match="look must be one of"):
        look(printed(WHITE), "sepia")


def test_normals_change_at_the_crease_alone():
    sheet, _ = folded(angle=40.0)
    normals = corner_normals(sheet)
    above = sheet.vertices[sheet.triangles][..., 2].max(axis=1) == 0
    np.testing.assert_allclose(normals[above], np.broadcast_to([0, 0, 1], normals[above].shape), atol=1e-9)
    below = normals[~above].reshape(-1, 3)
    np.testing.assert_allclose(below, np.broadcast_to(below[0], below.shape), atol=1e-9)
    assert np.degrees(np.arccos(below[0, 2])) == pytest.approx(40)
