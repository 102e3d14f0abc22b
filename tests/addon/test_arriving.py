"""The user undoes while a result arrives: Blender must find nothing that no undo step has, or it crashes."""

from __future__ import annotations

import bpy
import pytest
from origami.core.errors import StepFailed
from origami.origami_addon.operators import arriving


@pytest.fixture
def collection(add_on):
    """A collection, of which no undo step differs from the next one."""
    made = bpy.data.collections.new("document")
    bpy.context.scene.collection.children.link(made)
    for number in range(3):
        made["number"] = number
        bpy.ops.ed.undo_push(message=f"step {number}")
    bpy.context.scene["number"] = 1
    bpy.ops.ed.undo_push(message="before")
    yield made
    arriving.end(arriving._arriving)


def result(fails=False):
    """Three new objects, one at a time, and an undo step."""
    for number in range(3):
        made = bpy.data.objects.new(f"part {number}", bpy.data.meshes.new("part"))
        bpy.data.collections["document"].objects.link(made)
        yield
        if fails and number:
            raise StepFailed("It fails.")
    bpy.ops.ed.undo_push(message="result")


def parts():
    bpy.context.view_layer.update()
    return sorted(each.name for each in bpy.data.collections["document"].objects)


def test_undo_takes_back_the_whole_result_that_had_begun(collection):
    results = arriving.begin()
    results.add([result()])
    results.advance()
    assert parts() == ["part 0"]
    bpy.ops.ed.undo()
    assert (parts(), bool(results), bpy.context.scene["number"]) == ([], False, 1)
    bpy.ops.ed.redo()
    assert parts() == ["part 0", "part 1", "part 2"]
    bpy.ops.ed.undo()
    bpy.ops.ed.undo()
    assert "number" not in bpy.context.scene and parts() == []


def test_a_result_that_has_not_begun_waits(collection):
    results = arriving.begin()
    results.add([result()])
    bpy.ops.ed.undo()
    assert bool(results) and "number" not in bpy.context.scene
    while results:
        results.advance()
    assert len(parts()) == 3


def test_a_result_that_fails_is_undone_and_its_failure_reported_later(collection):
    results = arriving.begin()
    results.add([result(fails=True)])
    results.advance()
    bpy.ops.ed.undo()
    assert parts() == []
    with pytest.raises(StepFailed, match="It fails"):
        results.advance()


def test_redo_finds_no_half_result_either(collection):
    bpy.ops.ed.undo()
    results = arriving.begin()
    results.add([result()])
    results.advance()
    bpy.ops.ed.redo()  # there is nothing to redo any more: the result has come after what was undone
    assert len(parts()) == 3 and "number" not in bpy.context.scene


def test_without_results_undo_is_blenders_own(collection):
    bpy.ops.ed.undo()
    assert "number" not in bpy.context.scene
    bpy.ops.ed.redo()
    assert bpy.context.scene["number"] == 1
