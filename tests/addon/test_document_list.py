"""The list of documents: one truth about which is active; titles, copies, deletions that take only what is theirs."""

from __future__ import annotations

import bpy
import pytest
from folded import folded_sheet
from folded_document import folded_document
from origami.origami_addon.jobs import running
from origami.origami_addon.scene.document import documents, new_document
from origami.origami_addon.scene.mesh_values import world_corners
from origami.origami_addon.scene.roles import CAMERA, PAGE_FRAME, POINTS, SHEET
from origami.origami_addon.scene.sheet_materials import page_image


@pytest.fixture
def two(add_on, tmp_path):
    """Two documents with results, the second one to the right of the first."""
    case = folded_sheet()
    made = [folded_document(name, case, tmp_path, pack=True) for name in ("Brief", "Karte ü")]
    bpy.context.view_layer.update()
    return made


def active():
    from origami.origami_addon.scene.chosen import active_document

    return active_document(bpy.context)


def choose(document):
    """As a click in the list does it."""
    bpy.context.scene.origami.place = bpy.data.collections.find(document.collection.name)


def select(chosen):
    bpy.context.view_layer.objects.active = chosen


def names_of_everything():
    kinds = (bpy.data.objects, bpy.data.meshes, bpy.data.curves, bpy.data.cameras, bpy.data.materials, bpy.data.images)
    return {each.name for kind in kinds for each in kind}


def test_list_and_selection_never_disagree(two):
    first, second = two
    scene = bpy.context.scene.origami
    for document in (first, second, first):
        choose(document)
        assert active().name == document.name
        assert bpy.data.collections[scene.place] == document.collection
    select(second.object(SHEET))
    assert (active().name, bpy.data.collections[scene.place]) == (second.name, second.collection)
    choose(first)
    assert active().name == first.name
    assert first.made(bpy.context.active_object), "what is selected belongs to the document in the panels"


def test_choosing_leaves_the_mode_of_another_document_alone_of_the_users(two):
    first, second = two
    select(second.object(SHEET))
    bpy.ops.object.mode_set(mode="EDIT")
    choose(first)
    assert second.object(SHEET).mode == "OBJECT"
    assert active().name == first.name
    own = bpy.data.objects.new("own", bpy.data.meshes.new("own"))
    bpy.context.scene.collection.objects.link(own)
    select(own)
    bpy.ops.object.mode_set(mode="EDIT")
    choose(second)
    assert (own.mode, active().name) == ("EDIT", second.name)


def test_a_document_in_another_scene_can_be_chosen(two):
    first, second = two
    select(first.object(SHEET))
    bpy.data.scenes.new("other").collection.children.link(second.collection)
    bpy.context.scene.collection.children.unlink(second.collection)
    choose(second)
    assert active().name == second.name
    assert bpy.context.active_object is None
    choose(first)
    assert active().name == first.name


def test_a_new_document_is_the_active_one_whatever_is_selected(two, tmp_path):
    (tmp_path / "third").mkdir()
    (tmp_path / "third" / "1.jpg").write_bytes(b"")
    select(two[0].object(SHEET))
    bpy.ops.origami.add_photos(directory=f"{tmp_path / 'third'}/", new=True)
    assert active().name == "third"


def test_a_title_renames_what_is_named_after_it(two):
    first, second = two
    own = bpy.data.objects.new("Brief of mine", None)
    first.collection.objects.link(own)
    name, before = first.name, page_image(first)
    first.collection.origami.title = "  Letter 1  "
    assert (first.title, first.name) == ("Letter 1", name)
    assert first.object(SHEET).name == "Letter 1 sheet"
    assert first.object(SHEET).data.name == "Letter 1 sheet"
    assert own.name == "Brief of mine"
    assert page_image(first) == before
    first.collection.origami.title = " "
    assert first.title == "Letter 1", "an empty title is refused"
    second.collection.origami.title = "Letter 1"
    assert second.title == "Letter 1.001"
    assert second.object(SHEET).name == "Letter 1.001 sheet"


def test_a_duplicate_has_everything_of_its_own(two):
    first, _ = two
    own = bpy.data.objects.new("mine", None)
    first.collection.objects.link(own)
    first.object(POINTS).hide_set(True)
    first.collection.origami.photos.add().name = "1.jpg"
    choose(first)
    assert bpy.ops.origami.duplicate_document() == {"FINISHED"}
    copy = active()
    assert copy.name not in {each.name for each in two}
    assert [each.name for each in copy.collection.origami.photos] == ["1.jpg"]
    assert copy.state_digest() == first.state_digest()
    assert own.name not in copy.collection.objects
    theirs, mine = (
        {each for each in document.collection.all_objects if document.made(each)} for document in (first, copy)
    )
    assert len(theirs) == len(mine) and theirs.isdisjoint(mine)
    assert {each.data for each in theirs if each.data}.isdisjoint({each.data for each in mine if each.data})
    assert {each.parent for each in mine if each.parent} <= mine
    assert copy.object(SHEET).name == f"{copy.title} sheet"
    assert copy.object(POINTS).hide_get()
    assert page_image(copy) not in (None, page_image(first))
    bpy.context.view_layer.update()
    right = max(world_corners(each.object(PAGE_FRAME))[:, 0].max() for each in two)
    assert world_corners(copy.object(SHEET))[:, 0].min() > right, "it stands beside the others"


def test_deleting_takes_what_is_the_documents_alone(two):
    first, second = two
    own = bpy.data.objects.new("mine", bpy.data.meshes.new("mine"))
    first.collection.objects.link(own)
    inside = bpy.data.collections.new("inside")
    first.collection.children.link(inside)
    choose(first)
    name, kept = first.name, {each.name for each in second.collection.all_objects}
    assert bpy.ops.origami.delete_document() == {"FINISHED"}
    assert [each.name for each in documents()] == [second.name]
    assert active().name == second.name, "the next one is chosen"
    left = {each.name for each in bpy.data.objects}
    assert left == {*kept, "mine"}
    assert own.name in bpy.context.scene.collection.objects
    assert inside.name in bpy.context.scene.collection.children
    assert not [each for each in names_of_everything() if each.startswith(f"{name} ")]
    assert page_image(second) is not None and second.objects(CAMERA)
    assert bpy.ops.origami.delete_document() == {"FINISHED"}
    assert active() is None and not documents()
    assert not bpy.ops.origami.delete_document.poll()


def test_a_document_at_work_is_not_deleted(two, monkeypatch):
    first, second = two
    monkeypatch.setattr(running, "_current", running.Running(None, "Rectify Photos", first.name))
    choose(first)
    with pytest.raises(RuntimeError, match="A job works on this document"):
        bpy.ops.origami.delete_document()
    choose(second)
    assert bpy.ops.origami.delete_document() == {"FINISHED"}


def test_the_list_shows_documents_alone_and_finds_titles(two):
    from types import SimpleNamespace

    from origami.origami_addon.window.document_list import ORIGAMI_UL_documents

    bpy.data.collections.new("Brief without photos")
    drawn = SimpleNamespace(filter_name="", bitflag_filter_item=1)

    def shown(text):
        drawn.filter_name = text
        flags, _ = ORIGAMI_UL_documents.filter_items(drawn, bpy.context, bpy.data, "collections")
        return [each.name for each, flag in zip(bpy.data.collections, flags, strict=True) if flag]

    assert shown("") == ["Brief", "Karte ü"]
    assert shown("KARTE") == ["Karte ü"]
    assert shown("nothing") == []


def test_each_document_says_how_far_it_is(add_on, monkeypatch):
    from origami.origami_addon.jobs.queue import queue
    from origami.origami_addon.window.document_list import duration, progress_of

    made = [new_document(name, bpy.context.scene) for name in ("new", "done", "failed", "waiting", "at work")]
    done, failed, waiting, at_work = made[1:]
    done.collection.origami.page.done = True
    running.fail(running.Failure(failed.name, "Why.", ()))
    queue.add([waiting.name])
    monkeypatch.setattr(running, "_current", running.Running(None, "Rectify", at_work.name, 0.42))
    shown = {each.name: progress_of(each) for each in documents()}
    assert shown == {
        "new": ("RADIOBUT_OFF", ""),
        "done": ("CHECKMARK", ""),
        "failed": ("ERROR", "failed"),
        "waiting": ("TIME", "waiting"),
        "at work": ("PLAY", "42 %"),
    }
    queue.clear()
    assert [duration(each) for each in (10, 100, 5400)] == ["less than a minute", "about 2 min", "about 1 h 30 min"]
