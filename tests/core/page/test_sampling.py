"""How finely photos sample a page, on cases where every pixel has its place."""

from __future__ import annotations

import numpy as np
import pytest
from folded import COLUMNS, HEIGHT_MM, folded_sheet
from origami.core.page.sampling import measure_sampling
from origami.core.page.single_photo import page_of_photo
from origami.core.page.texture import PageTexture
from origami.core.sheet import Sheet

SIZE = (160, 200)


def texture_of(matrix, photo=None):
    """A page whose pixels are at these multiples of their column and row in one photo."""
    column, row = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    position = (np.stack([column, row], -1) @ np.transpose(matrix)).astype(np.float32)
    photo = np.zeros((SIZE[1], SIZE[0]), np.int16) if photo is None else photo
    return PageTexture(np.zeros((*photo.shape, 3), np.uint8), photo, position, 0.0)


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_the_coarser_direction_counts(turn):
    case = folded_sheet()
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    found = measure_sampling(texture_of(rotation @ np.diag([0.4, 1.5])), case.sheet, case.flat)
    assert found.median == pytest.approx(0.4, rel=1e-3)
    assert found.lowest == pytest.approx(0.4, rel=1e-2)
    assert found.at_creases == pytest.approx(0.4, rel=1e-3)


def test_only_what_lies_near_creases_counts_there():
    case = folded_sheet()
    photo = np.zeros((SIZE[1], SIZE[0]), np.int16)
    texture = texture_of(np.eye(2), photo)
    upper = np.arange(SIZE[1]) < SIZE[1] // 2 - 4
    texture.position[upper] = texture.position[upper] * 0.5  # the lower half is sampled twice as finely
    crease = Sheet(case.sheet.vertices, case.sheet.triangles, case.sheet.ridges[:1], case.sheet.boundary)
    found = measure_sampling(texture, crease, case.flat)
    assert found.lowest == pytest.approx(0.5)
    assert found.at_creases == pytest.approx(1.0)


def test_neighbours_from_two_photos_do_not_count():
    case = folded_sheet()
    photo = np.zeros((SIZE[1], SIZE[0]), np.int16)
    photo[:, SIZE[0] // 2 + 1 :] = 1
    texture = texture_of(np.eye(2), photo)
    texture.position[photo == 1] += 300
    assert measure_sampling(texture, case.sheet, case.flat).lowest == pytest.approx(1.0)


def test_a_photo_samples_slanted_paper_more_coarsely():
    fold = 0.9
    case = folded_sheet(fold)
    plain = Sheet(case.sheet.vertices, case.sheet.triangles, (), case.sheet.boundary)
    texture = page_of_photo(case.sheet, case.flat, case.model.cameras, case.photos.__getitem__, 0, SIZE)
    found = measure_sampling(texture, plain, case.flat)
    camera = case.model.cameras[0]
    crease = case.sheet.ridges[0][COLUMNS // 2 : COLUMNS // 2 + 2]
    in_photo, on_page = (
        np.linalg.norm(np.diff(at[crease], axis=0)) for at in (camera.project(case.sheet.vertices), case.flat.uv)
    )
    level = in_photo / on_page * HEIGHT_MM / SIZE[1]  # photo pixels per page pixel along the crease
    assert 0.4 * level < found.lowest < found.median < level
    assert found.at_creases is None


def test_a_page_in_no_photo_has_no_sampling():
    case = folded_sheet()
    nowhere = texture_of(np.eye(2), np.full((SIZE[1], SIZE[0]), -1, np.int16))
    assert measure_sampling(nowhere, case.sheet, case.flat) is None
