"""A small photo set, rendered, placed and rectified in the window once for all tests; the add-on, enabled."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import photo_scene
import pytest
from colmap_models import write_changed_model
from finished_document import draw_outline

if TYPE_CHECKING:
    from origami.origami_addon.scene.document import Document

_NAMES_AND_COLORS = """
photos, *names = sys.argv[3:]
for image in model.images.values():
    image.name = names[int(image.name)]
model.extract_colors_for_all_images(photos)
"""


@dataclass(frozen=True)
class SmallSet:
    """Six photos of 480 x 640 pixels with their true poses, and the folder in which they were placed."""

    photos: list
    poses: list[photo_scene.Pose]
    work: Path
    settings: object
    result: object


@pytest.fixture(scope="session")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> SmallSet:
    from origami.origami_addon.files.photos import gather
    from origami.origami_addon.sfm.client import SfmSettings, place_photos

    folder = tmp_path_factory.mktemp("small set")
    poses = photo_scene.photo_set(folder / "photos")
    photos, _ = gather(folder / "photos")
    settings = SfmSettings(max_features=1500, threads=1)
    return SmallSet(photos, poses, folder / "work", settings, place_photos(photos, folder / "work", settings))


@pytest.fixture
def small_photos(small_set: SmallSet) -> list:
    return small_set.photos


@pytest.fixture(scope="session")
def colmap_model(small_set: SmallSet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small set's model in COLMAP's format, with the photos' names and colours."""
    (stored,) = small_set.work.glob("*/0")
    photos = [photo.path for photo in small_set.photos]
    values = photos[0].parent, *(path.name for path in photos)
    return write_changed_model(stored, tmp_path_factory.mktemp("colmap"), _NAMES_AND_COLORS, *values)


@pytest.fixture
def add_on(empty_scene: None) -> Iterator[None]:
    """The add-on, enabled, in an empty file."""
    with _enabled():
        yield


@pytest.fixture(scope="module")
def lasting_add_on() -> Iterator[None]:
    """The add-on, enabled for all tests of a file."""
    with _enabled():
        yield


@pytest.fixture
def reopen() -> Callable[[Path], Document]:
    """Opens a .blend with one document, and returns that."""
    import bpy
    from origami.origami_addon.scene.document import documents

    def opened(path: Path) -> Document:
        bpy.ops.wm.open_mainfile(filepath=str(path))
        (document,) = documents()
        return document

    return opened


@pytest.fixture(scope="session")
def finished(small_set: SmallSet, colmap_model: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A .blend with the small set rectified by the big button, beside the folder with its photos, ``Brief ü``."""
    import bpy

    folder = tmp_path_factory.mktemp("window") / "Brief ü"
    shutil.copytree(small_set.photos[0].path.parent, folder)
    path = folder.parent / "finished.blend"
    with _enabled():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        assert bpy.ops.origami.add_photos(directory=f"{folder}/", preset="letter", new=True) == {"FINISHED"}
        settings = bpy.data.collections["Brief ü"].origami.settings
        settings.colmap_model = str(colmap_model)
        settings.surface.grid_rows = 40
        # The default judges creases by many fits; what the window does with a surface is the same for all methods.
        settings.surface.method = "ridge_aware"
        # These photos only show the sheet: no edge can be found in them, so it is drawn.
        assert bpy.ops.origami.run_stage(stage="place") == {"FINISHED"}
        assert bpy.ops.origami.run_stage(stage="find") == {"FINISHED"}
        draw_outline(0.08)
        assert bpy.ops.origami.rectify() == {"FINISHED"}
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def document(finished: Path, lasting_add_on: None, reopen: Callable[[Path], Document]) -> Document:
    """The finished document, reopened."""
    return reopen(finished)


@contextmanager
def _enabled() -> Iterator[None]:
    from origami import register, unregister

    register()
    try:
        yield
    finally:
        unregister()
