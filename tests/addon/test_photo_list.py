"""The document's list of photos: what its buttons ask for, and what becomes of the list when something fails."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import pytest


@pytest.fixture
def add_on(empty_scene):
    from origami import register, unregister

    register()
    yield
    unregister()


@pytest.fixture
def folder(tmp_path):
    """Files that are photos by their names."""
    for name in ("1.jpg", "2.jpg", "3.jpg"):
        (tmp_path / "sheet" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "sheet" / name).write_bytes(name.encode())
    return tmp_path / "sheet"


class Layout:
    """Notes the buttons that are drawn into it or into parts of it."""

    def __init__(self) -> None:
        self.buttons: list[SimpleNamespace] = []

    def operator(self, name: str, **_: object) -> SimpleNamespace:
        self.buttons.append(SimpleNamespace(bl_idname=name))
        return self.buttons[-1]

    def __getattr__(self, name: str):
        return lambda *_, **__: self


def test_the_plus_beside_the_list_adds(add_on, folder):
    """Whatever was chosen in the dialog before."""
    from origami.origami_addon.window import menus, panels

    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    document = panels.active_document(bpy.context)
    layout = Layout()
    panels._Photos.draw_step(None, bpy.context, layout, document, document.collection.origami.settings)
    (plus,) = (button for button in layout.buttons if button.bl_idname == "origami.add_photos")
    assert (plus.new, plus.rectify) == (False, False)
    layout = Layout()
    menus._import(SimpleNamespace(layout=layout), bpy.context)
    (entry,) = layout.buttons
    assert (entry.new, entry.rectify) == (True, False)
    told = bpy.ops.origami.add_photos.get_rna_type().properties
    assert all(told[name].is_skip_save for name in ("new", "rectify"))


def test_photos_stay_where_rectifying_cannot_start(add_on, folder, monkeypatch):
    """And the user reads the sentence alone."""
    from origami.origami_addon.jobs import running

    monkeypatch.setattr(running, "_current", running.Running(None, "Other"))
    with pytest.raises(RuntimeError) as told:
        bpy.ops.origami.add_photos(directory=f"{folder}/", new=True, rectify=True)
    assert str(told.value).strip() == "Error: A job is running: wait for it, or press ESC"
    monkeypatch.undo()
    assert len(bpy.data.collections["sheet"].origami.photos) == 3
