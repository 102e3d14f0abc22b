"""Copies of documents that Blender makes are independent."""

from __future__ import annotations

import pytest
from folded import folded_sheet
from folded_document import folded_document
from origami.origami_addon.scene.document import document_of, documents, find_document, remove_document
from origami.origami_addon.scene.roles import CAMERA, ORIGIN, SHEET
from origami.origami_addon.scene.sheet_materials import page_image

CASE = folded_sheet()


@pytest.fixture
def document(add_on, tmp_path):
    return folded_document("Brief ü", CASE, tmp_path, pack=True)


def saved(path):
    import bpy

    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return str(path)


def load(path, *, link):
    """Append or link the document of a file, like File > Append and File > Link."""
    import bpy

    with bpy.data.libraries.load(path, link=link) as (there, here):
        here.collections = [name for name in there.collections if name == "Brief ü"]
    (collection,) = here.collections
    bpy.context.scene.collection.children.link(collection)
    bpy.context.view_layer.update()
    return collection


def duplicate(collection):
    """Like Duplicate Linked in the Outliner: separate objects that share their data."""
    import bpy

    copy = bpy.data.collections.new(f"{collection.name}.001")
    for key in list(collection.keys()):
        copy[key] = collection[key]
    for each in collection.objects:
        copy.objects.link(each.copy())
    bpy.context.scene.collection.children.link(copy)
    bpy.context.view_layer.update()
    return copy


def used(document):
    """All marked data that the document's objects use."""
    found = set()
    for each in document.collection.all_objects:
        found |= {each, each.data, *(slot.material for slot in each.material_slots)}
        found |= {background.image for background in getattr(each.data, "background_images", ())}
        for slot in each.material_slots:
            found |= {node.image for node in slot.material.node_tree.nodes if getattr(node, "image", None)}
    return found - {None}  # the origin has no data


def parted(first, collection):
    """Check that the collection is a separate document that shares nothing with the first one."""
    copy = document_of(collection)
    assert {each.name for each in documents()} == {"Brief ü", "Brief ü.001"}
    assert (first.name, copy.name) == ("Brief ü", "Brief ü.001")
    for document in (first, copy):
        assert document_of(document.object(SHEET)).collection == document.collection
        assert find_document(document.name).collection == document.collection
        assert len(document.objects(CAMERA)) == 2
        assert document.object(SHEET).parent == document.object(ORIGIN)
        assert all(document.made(each) for each in used(document))
    assert not used(first) & used(copy)
    assert page_image(copy) in used(copy)
    assert page_image(first) in used(first)


def test_a_duplicate_is_a_document_of_its_own(document):
    import bpy

    sheet = document.object(SHEET)
    own = bpy.data.materials.new("own")
    if own.node_tree is None:
        own.use_nodes = True  # always so, and deprecated, from Blender 5.0 on
    own.node_tree.nodes.new("ShaderNodeTexImage").image = page_image(document)
    sheet.data.materials.append(own)
    copy = duplicate(document.collection)
    sheet.data.materials.pop()
    (shown,) = (node.image for node in own.node_tree.nodes if getattr(node, "image", None))
    assert shown == page_image(document)
    document_of(copy).object(SHEET).data.materials.pop()
    parted(document, copy)
    assert copy["origami_state"] == document.collection["origami_state"]
    remove_document("Brief ü.001")
    assert document.object(SHEET) == sheet
    assert page_image(document).packed_file is not None


def test_an_appended_document_is_one_of_its_own(document, tmp_path):
    parted(document, load(saved(tmp_path / "saved.blend"), link=False))


def test_a_file_with_two_of_a_name_is_parted_when_it_is_opened(document, tmp_path):
    import bpy
    from origami.origami_addon.scene import document_copies

    document_copies.unregister()
    duplicate(document.collection)
    document_copies.register()
    assert [each.name for each in documents()] == ["Brief ü", "Brief ü"]
    bpy.ops.wm.open_mainfile(filepath=saved(tmp_path / "two.blend"))
    first, copy = documents()
    parted(first, copy.collection)


def test_a_linked_document_is_that_of_its_file(document, tmp_path):
    linked = load(saved(tmp_path / "saved.blend"), link=True)
    (only,) = documents()
    assert only.collection == document.collection != linked
    assert document_of(linked) is None
    assert all(document_of(each) is None for each in linked.all_objects)


def test_where_all_documents_are_linked_the_buttons_say_so(document, tmp_path):
    import bpy
    from origami.origami_addon.operators.needs import DocumentOperator

    path = saved(tmp_path / "saved.blend")
    bpy.context.view_layer.objects.active = document.object(SHEET)
    assert DocumentOperator.missing(bpy.context) == ""
    remove_document(document.name)
    assert "Add the photos" in DocumentOperator.missing(bpy.context)
    load(path, link=True)
    assert "linked from another file" in DocumentOperator.missing(bpy.context)


def test_undo_after_copies_were_parted_finds_whole_documents(document):
    """Blender crashes if the user undoes to a step before which the copies' data were made without a step of theirs."""
    import bpy
    from origami.origami_addon.scene import document_copies

    # In a window, copies are parted a moment later: perhaps after the next undo step.
    bpy.app.handlers.depsgraph_update_post.remove(document_copies._after_update)
    try:
        bpy.ops.ed.undo_push(message="document")
        duplicate(document.collection)
        bpy.ops.ed.undo_push(message="duplicate")
        bpy.context.scene["number"] = 1
        bpy.ops.ed.undo_push(message="something else")
        document_copies.part_copies()
        assert len({each.name for each in documents()}) == 2
        for count in (2, 2, 1):
            bpy.ops.ed.undo()
            bpy.context.view_layer.update()
            assert len(documents()) == count
            assert all(each.object(SHEET).data.name for each in documents())
    finally:
        bpy.app.handlers.depsgraph_update_post.append(document_copies._after_update)
