"""The bake in Blender and the warp in the core make the same page."""

from __future__ import annotations

import numpy as np
import pytest
from folded import folded_sheet
from origami.core.page.photo_colors import sample
from origami.core.page.raster import page_lookup
from origami.core.page.warp import photo_positions
from origami.origami_addon.scene.bake import bake_page
from origami.origami_addon.scene.document_frame import document_frame
from origami.origami_addon.scene.sheet_mesh import sheet_to_object

SIZE = (400, 500)


@pytest.fixture
def baked_and_warped(empty_scene):
    import bpy

    case = folded_sheet()
    camera = case.model.cameras[1]
    made = sheet_to_object("sheet", case.sheet, case.flat, camera, document_frame(case.sheet, case.flat))
    bpy.context.scene.collection.objects.link(made)
    baked = bake_page(made, case.photos[1], SIZE)
    lookup = page_lookup(case.sheet, case.flat, SIZE)
    return baked, sample(case.photos[1], photo_positions(case.sheet, lookup, camera), "linear")


def test_bake_and_linear_warp_agree(baked_and_warped):
    baked, warped = baked_and_warped
    assert baked.shape == warped.shape == (500, 400, 3)
    difference = np.abs(baked.astype(int) - warped).max(axis=-1)
    assert (difference <= 2).mean() >= 0.999


def test_bake_leaves_nothing_behind(baked_and_warped):
    import bpy

    assert [len(kind) for kind in (bpy.data.images, bpy.data.materials, bpy.data.scenes)] == [0, 0, 1]
    assert [found.name for found in bpy.data.objects] == ["sheet"]
