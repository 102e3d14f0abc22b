"""A page is upright by its text, or as the photo was held."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.page import upright_page
from origami.core.page.page import lay_out
from origami.core.page.upright_page import lay_out_upright, up_after, up_of_exif

from .test_single_photo import flat_sheet, letters, photo_of, view_from


@pytest.mark.parametrize(("orientation", "up"), [(1, (0, -1)), (6, (-1, 0)), (3, (0, 1)), (8, (1, 0)), (99, (0, -1))])
def test_up_of_exif(orientation, up):
    """Orientation 6 has the picture's top at the stored left side, 8 at the right one."""
    np.testing.assert_array_equal(up_of_exif(orientation), up)


@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_a_picture_turned_clockwise_has_its_former_side_up(degrees):
    turned = np.radians(degrees)
    # clockwise on screen, y down
    turn = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
    np.testing.assert_allclose(turn @ up_after(degrees), [0, -1], atol=1e-12)


@pytest.mark.parametrize(("confidence", "turns"), [(0.49, 0), (0.5, 1), (1.0, 1)])
def test_the_text_turns_the_page_where_it_is_sure(monkeypatch, confidence, turns):
    sheet, flat = flat_sheet()
    camera = view_from(0.1)
    photo = photo_of(camera, letters)
    monkeypatch.setattr(upright_page, "reading_direction", lambda page: (1, confidence))
    up = np.array([0.0, -1.0])
    page = lay_out_upright(sheet, flat.uv, [camera], lambda _: photo, 0, up)
    wanted = lay_out(sheet, flat.uv, camera, up, quarter_turns=turns)
    np.testing.assert_array_equal(page.flat.uv, wanted.uv)
    assert page.flat.width == wanted.width
    assert (page.quarter_turns, page.confidence) == (1, confidence)


def test_the_page_is_looked_at_as_the_photo_was_held(monkeypatch):
    sheet, flat = flat_sheet()
    camera = view_from(0.1)
    photo = photo_of(camera, letters)
    seen = []
    monkeypatch.setattr(upright_page, "reading_direction", lambda page: seen.append(page.shape) or (0, 1.0))
    for up in ((0.0, -1.0), (1.0, 0.0)):
        lay_out_upright(sheet, flat.uv, [camera], lambda _: photo, 0, np.array(up))
    assert seen[0][0] == 1600 > seen[0][1]
    assert seen[1] == seen[0][::-1]
