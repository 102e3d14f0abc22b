"""The document's list of photos: what its buttons ask, and the list after a failure."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from origami.core.errors import UsageError
from origami.origami_addon.jobs import running


@pytest.fixture
def folder(tmp_path):
    """Files that are photos by their names."""
    for name in ("1.jpg", "2.jpg", "3.jpg"):
        (tmp_path / "sheet" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "sheet" / name).write_bytes(name.encode())
    return tmp_path / "sheet"


class Layout:
    """Records the buttons drawn into it or into parts of it."""

    def __init__(self) -> None:
        self.buttons: list[SimpleNamespace] = []

    def operator(self, name: str, **_: object) -> SimpleNamespace:
        self.buttons.append(SimpleNamespace(bl_idname=name))
        return self.buttons[-1]

    def __getattr__(self, name: str):
        return lambda *_, **__: self


def test_the_plus_beside_the_list_adds(add_on, folder):
    """Regardless of the last choice in the dialog."""
    from origami.origami_addon.scene.chosen import active_document
    from origami.origami_addon.window import menus, step_panels

    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    document = active_document(bpy.context)
    layout = Layout()
    step_panels._Photos.draw_step(None, bpy.context, layout, document, document.collection.origami.settings)
    (plus,) = (button for button in layout.buttons if button.bl_idname == "origami.add_photos")
    assert (plus.new, plus.rectify) == (False, False)
    layout = Layout()
    menus._import(SimpleNamespace(layout=layout), bpy.context)
    entry, folders = layout.buttons
    assert folders.bl_idname == "origami.add_folders"
    assert (entry.new, entry.rectify) == (True, False)
    properties = bpy.ops.origami.add_photos.get_rna_type().properties
    assert all(properties[name].is_skip_save for name in ("new", "rectify"))


def test_photos_that_come_by_another_path_are_the_same(add_on, folder):
    """Through a link, or by a way around: a photo that is there twice would be compared with itself."""
    link = folder.parent / "link"
    link.symlink_to(folder, target_is_directory=True)
    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    for again in (folder, link, folder / ".." / "sheet"):
        bpy.ops.origami.add_photos(directory=f"{again}/")
    assert [photo.name for photo in bpy.data.collections["sheet"].origami.photos] == ["1.jpg", "2.jpg", "3.jpg"]


@pytest.mark.parametrize("left", [0, 3])
def test_without_a_ticked_photo_nothing_runs(add_on, folder, left):
    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    group = bpy.data.collections["sheet"].origami
    while len(group.photos) > left:
        group.photos.remove(0)
    for photo in group.photos:
        photo.use = False
    with pytest.raises(RuntimeError, match="No photo of the document is ticked: tick at least three"):
        bpy.ops.origami.rectify()


def test_photos_stay_where_rectifying_cannot_start(add_on, folder, monkeypatch):
    """And the user only reads the message."""
    monkeypatch.setattr(running, "_current", running.Running(None, "Other"))
    with pytest.raises(RuntimeError) as failure:
        bpy.ops.origami.add_photos(directory=f"{folder}/", new=True, rectify=True)
    assert str(failure.value).strip() == "Error: A job is running: wait for it, or press ESC"
    monkeypatch.undo()
    assert len(bpy.data.collections["sheet"].origami.photos) == 3


def test_photos_of_the_same_name_are_distinguished(add_on, folder):
    """Either can be the reference photo, and it stays the same."""
    other = folder.parent / "again"
    other.mkdir()
    (other / "2.jpg").write_bytes(b"another")
    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    group = bpy.data.collections["sheet"].origami
    assert [photo.name for photo in group.photos] == ["1.jpg", "2.jpg", "3.jpg"]
    group.settings.reference = "2.jpg"
    bpy.ops.origami.add_photos(directory=f"{other}/")
    assert [photo.name for photo in group.photos] == ["1.jpg", "sheet/2.jpg", "3.jpg", "again/2.jpg"]
    assert group.settings.reference == "sheet/2.jpg"
    group.active_photo = 3
    bpy.ops.origami.remove_photo()
    assert [photo.name for photo in group.photos] == ["1.jpg", "2.jpg", "3.jpg"]
    assert group.settings.reference == "2.jpg"


def test_moved_photos_are_found_by_name(add_on, folder):
    from origami.origami_addon.operators.photos import lost_photos
    from origami.origami_addon.scene.chosen import active_document
    from origami.origami_addon.scene.known import photos_in_use

    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    document = active_document(bpy.context)
    group = document.collection.origami
    group.photos_placed = json.dumps(photos_in_use(document))
    image = bpy.data.images.new("photo", 1, 1)
    image.filepath = group.photos[1].path
    assert lost_photos(document) == 0
    moved = folder.rename(folder.parent / "elsewhere")
    (folder.parent / "elsewhere" / "3.jpg").rename(folder.parent / "3.jpg")
    running.begin(running.Running(SimpleNamespace(kill=bool, remove_folder=bool), "Fails"))
    running.end()
    assert lost_photos(document) == 3
    with pytest.raises(RuntimeError, match=r"Not in .*: 1\.jpg, 2\.jpg, 3\.jpg; choose"):
        bpy.ops.origami.find_photos(directory=f"{folder.parent / 'nowhere'}/")
    assert bpy.ops.origami.find_photos(directory=f"{moved}/") == {"FINISHED"}
    assert lost_photos(document) == 1
    assert bpy.ops.origami.find_photos(directory=f"{folder.parent}/") == {"FINISHED"}
    assert lost_photos(document) == 0
    now = [str(moved / "1.jpg"), str(moved / "2.jpg"), str(folder.parent / "3.jpg")]
    assert photos_in_use(document) == json.loads(group.photos_placed) == now
    assert image.filepath == now[1]


def test_moved_photos_of_the_same_name_are_not_mixed_up(add_on, folder):
    (folder.parent / "again").mkdir()
    (folder.parent / "again" / "2.jpg").write_bytes(b"another")
    for name in ("sheet", "again"):
        bpy.ops.origami.add_photos(directory=f"{folder.parent / name}/")
    moved = folder.parent / "elsewhere"
    moved.mkdir()
    for name in ("sheet", "again"):
        (folder.parent / name).rename(moved / name)
    bpy.ops.origami.find_photos(directory=f"{moved / 'again'}/")
    (collection,) = bpy.data.collections
    photos = {photo.name: photo for photo in collection.origami.photos}
    assert photos["again/2.jpg"].path == str(moved / "again" / "2.jpg")
    assert photos["sheet/2.jpg"].path == str(folder / "2.jpg")
    bpy.ops.origami.find_photos(directory=f"{moved}/")
    assert photos["sheet/2.jpg"].path == str(moved / "sheet" / "2.jpg")


def test_a_reference_is_known_by_more_folders_than_it_takes(folder):
    """The other photo of that name may be left out of a run."""
    from origami.origami_addon.feasibility import check_reference
    from origami.origami_addon.settings import RunSettings

    photos = [SimpleNamespace(path=path, name=path.name, width=9, height=9) for path in sorted(folder.iterdir())]
    assert check_reference(photos, RunSettings(reference="sheet/2.jpg")) is photos[1]
    with pytest.raises(UsageError, match=r"There is no photo again/2\.jpg"):
        check_reference(photos, RunSettings(reference="again/2.jpg"))


def test_photos_in_folders_inside_are_offered(add_on, folder):
    """And whatever is chosen is taken for what it holds."""
    with pytest.raises(RuntimeError, match=r"they are in folders inside it \(sheet\).*Subfolders"):
        bpy.ops.origami.add_photos(directory=f"{folder.parent}/", new=True)
    bpy.ops.origami.add_photos(directory=f"{folder.parent}/", new=True, recursive=True)
    group = bpy.context.scene.origami.document.origami
    assert [photo.name for photo in group.photos] == ["1.jpg", "2.jpg", "3.jpg"]
    (folder / "no ending").write_bytes(b"\xff\xd8\xff")
    (folder / "words.txt").write_bytes(b"words")
    files = [{"name": "no ending"}, {"name": "words.txt"}]
    bpy.ops.origami.add_photos(directory=f"{folder}/", files=files)
    assert [photo.name for photo in group.photos][3:] == ["no ending"]


def _button(folder):
    bpy.ops.origami.add_photos(directory=f"{folder}/", files=[{"name": "1.jpg"}, {"name": "2.jpg"}], new=True)


def _import_menu(folder):
    """The file browser gives the folder and the file that was clicked."""
    bpy.ops.origami.add_photos(
        directory=f"{folder}/", filepath=str(folder / "2.jpg"), files=[{"name": "2.jpg"}], new=True, rectify=False
    )


def _dropped(folder):
    files = [{"name": path.name} for path in sorted(folder.iterdir())]
    bpy.ops.origami.add_photos(directory=f"{folder}/", files=files, new=True)


def _folder(folder):
    bpy.ops.origami.add_photos(directory=f"{folder}/")


def _one_after_the_other(folder):
    for path in sorted(folder.iterdir()):
        bpy.ops.origami.add_photos(directory=f"{folder}/", files=[{"name": path.name}])


@pytest.mark.parametrize("way_in", [_button, _import_menu, _dropped, _folder, _one_after_the_other])
def test_no_setting_is_other_than_the_command_lines(add_on, folder, way_in):
    """If the user has set nothing, however photos are added, removed, added again or moved."""
    from origami.origami_addon.scene.settings_group import settings_to_json
    from origami.origami_addon.settings import RunSettings
    from origami.origami_addon.settings_json import to_json

    defaults = to_json(RunSettings())
    way_in(folder)
    (collection,) = bpy.data.collections

    def all_settings() -> dict:
        shown = settings_to_json(collection.origami.settings)
        return shown | {name: defaults[name] for name in defaults.keys() - shown.keys()}

    assert all_settings() == defaults
    bpy.ops.origami.add_photos(directory=f"{folder}/")
    assert all_settings() == defaults
    bpy.ops.origami.remove_photo()
    assert all_settings() == defaults
    moved = folder.rename(folder.parent / "elsewhere")
    bpy.ops.origami.find_photos(directory=f"{moved}/")
    assert all_settings() == defaults
    bpy.ops.origami.add_photos(directory=f"{moved}/")
    assert all_settings() == defaults


def test_the_reference_is_forgotten_with_its_photo(add_on, folder):
    """Otherwise a photo of the same name, added later, would become the reference unasked."""
    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    group = bpy.data.collections["sheet"].origami
    group.settings.reference = "2.jpg"
    group.active_photo = 2
    bpy.ops.origami.remove_photo()
    assert group.settings.reference == "2.jpg"
    group.active_photo = 1
    bpy.ops.origami.remove_photo()
    assert group.settings.reference == ""
    bpy.ops.origami.add_photos(directory=f"{folder}/")
    assert group.settings.reference == ""


def test_no_photo_is_taken_out_where_none_is_chosen(add_on, folder):
    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    bpy.data.collections["sheet"].origami.active_photo = 7
    with pytest.raises(RuntimeError, match="Select a photo in the list first"):
        bpy.ops.origami.remove_photo()


def test_photos_have_thumbnails_unless_they_are_lost_or_of_a_kind_that_blender_does_not_draw(add_on, folder):
    """Without a window, Blender gives none of them a number."""
    from origami.origami_addon.window import photo_list

    (folder / "4.heic").write_bytes(b"4")
    for name in ("1.jpg", "2.jpg", "1.jpg", "4.heic", "gone.jpg"):
        photo_list.thumbnail_of(str(folder / name))
    assert set(photo_list._previews) == {str(folder / "1.jpg"), str(folder / "2.jpg")}


def test_the_reference_photo_is_marked_as_set_and_then_as_found(add_on, folder):
    from origami.origami_addon.scene.document import documents
    from origami.origami_addon.window.photo_list import is_reference

    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    (document,) = documents()
    group = document.collection.origami
    assert [is_reference(document, photo) for photo in group.photos] == [False, False, False]
    group.settings.reference = "2.jpg"
    assert [is_reference(document, photo) for photo in group.photos] == [False, True, False]
    camera, outline = (bpy.data.objects.new(name, None) for name in ("camera", "outline"))
    camera["photo"] = "3.jpg"
    document.add(camera, "camera")
    document.add(outline, "outline")
    outline.parent = camera
    assert [is_reference(document, photo) for photo in group.photos] == [False, False, True]


def test_each_photo_says_how_it_was_placed_and_how_sharp_it_is(add_on, folder):
    from origami.core.camera import Camera
    from origami.core.sparse_model import SparseModel
    from origami.origami_addon.scene.document import documents
    from origami.origami_addon.scene.listed_photos import note_photos
    from origami.origami_addon.window.photo_list import judged

    cameras = tuple(
        Camera(name, 100, 100, 100.0, (50.0, 50.0), (0.0, 0.0), np.eye(3), np.array([0.0, 0, 1]))
        for name in ("1.jpg", "2.jpg")
    )
    points = np.array([[0.0, 0, 0], [0.1, 0, 0]])
    seen = np.array([[53.0, 54], [60, 50], [50, 50]])
    model = SparseModel(cameras, points, np.zeros((2, 3), np.uint8), np.array([0, 1, 0]), np.array([0, 0, 1]), seen)
    bpy.ops.origami.add_photos(directory=f"{folder}/", new=True)
    (document,) = documents()
    photos = document.collection.origami.photos
    assert [judged(photo, photos) for photo in photos] == [[], [], []]
    note_photos(document, model, {"1.jpg": 0.4, "2.jpg": 0.5})
    assert judged(photos[0], photos) == ["Placed: 2 points, 2.50 px off", "80 % as sharp as the sharpest"]
    assert judged(photos[1], photos) == ["Placed: 1 points, 0.00 px off", "The sharpest photo"]
    assert judged(photos[2], photos) == ["Could not be placed"]
    note_photos(document, model, {})
    assert judged(photos[0], photos) == ["Placed: 2 points, 2.50 px off"]
