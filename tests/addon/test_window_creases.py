"""Creases that a user draws, drops, paints or erases in the window."""

from __future__ import annotations

import json

import numpy as np
import pytest
from finished_document import stages


def draw_crease(document) -> int:
    """Draw a crease, and return which of the document's creases it is."""
    import bpy
    from origami.origami_addon.operators.edit_creases import creases_in_photo

    before = creases_in_photo(document.state)
    drawn = (120.0, 480.0, 360.0, 470.0)
    assert bpy.ops.origami.draw_crease(start=drawn[:2], end=drawn[2:]) == {"FINISHED"}
    assert all(stage.done for stage in stages(document).values())
    there = np.array(creases_in_photo(document.state)).reshape(-1, 2, 2)
    assert len(there) >= len(before) + 1
    # There is a crease somewhere on the drawn line, wherever its ends are now.
    middle = np.array(drawn).reshape(2, 2).mean(axis=0)
    span = there[:, 1] - there[:, 0]
    share = np.clip(((middle - there[:, 0]) * span).sum(axis=1) / (span**2).sum(axis=1), 0, 1)
    distance = np.linalg.norm(there[:, 0] + share[:, None] * span - middle, axis=1)
    assert distance.min() < 8
    given = json.loads(document.collection.origami.creases)
    assert given[-1] == pytest.approx(drawn)
    angles = json.loads(stages(document)["surface"].figures)["fold_angles_degrees"]
    assert len(angles) == len(there)
    return int(distance.argmin())


def test_a_crease_is_drawn(document):
    draw_crease(document)


@pytest.mark.slow
def test_a_crease_is_drawn_and_dropped(document):
    import bpy
    from origami.origami_addon.operators.edit_creases import creases_in_photo
    from origami.origami_addon.scene.read_back import read_back

    document.collection.origami.settings.surface.method = "developable"
    assert bpy.ops.origami.rectify() == {"FINISHED"}
    drawn = draw_crease(document)
    assert read_back(document).edited == frozenset()
    there = creases_in_photo(document.state)
    assert bpy.ops.origami.drop_crease(index=drawn) == {"FINISHED"}
    assert len(creases_in_photo(document.state)) < len(there)
    with pytest.raises(RuntimeError, match="no longer on the sheet"):
        bpy.ops.origami.drop_crease(index=99)


def test_finding_ridges_again_forgets_the_drawn_ones(document):
    import bpy

    kept = document.state.sheet
    document.collection.origami.creases = json.dumps([[120.0, 480.0, 360.0, 470.0]])
    assert bpy.ops.origami.run_stage(stage="surface") == {"FINISHED"}
    assert document.collection.origami.creases == ""
    np.testing.assert_array_equal(document.state.sheet.vertices, kept.vertices)


def test_an_erased_ridge_is_no_crease_and_a_painted_one_is(document):
    import bpy
    from origami.origami_addon.scene.read_back import read_back

    sheet = document.object("sheet")
    group = sheet.vertex_groups["ridge"]
    group.remove(range(len(sheet.data.vertices)))
    uv = document.state.flat.uv
    size = np.array([document.state.flat.width, document.state.flat.height])
    # A stroke where there is no crease.
    inner = (uv[:, 0] > 0.25 * size[0]) & (uv[:, 0] < 0.8 * size[0])
    step = np.sqrt(size.prod() / len(uv))
    along = np.abs(uv[:, 1] - 0.8 * size[1]) < 1.2 * step
    group.add(np.flatnonzero(inner & along).tolist(), 1.0, "REPLACE")
    read = read_back(document)
    assert read.edited == {"creases"}
    (ridge,) = read.state.sheet.ridges
    assert np.ptp(uv[ridge, 0]) > 0.45 * size[0]
    assert np.abs(uv[ridge, 1] - 0.8 * size[1]).max() < 1.5 * step
    document.collection.origami.settings.flatten.ridge_rows = True
    assert bpy.ops.origami.run_stage(stage="unwrap") == {"FINISHED"}
    line = document.state.flat.uv[document.state.sheet.ridges[0]]
    spread = np.linalg.svd(line - line.mean(axis=0))[1]
    assert spread[1] < 0.01 * spread[0]
