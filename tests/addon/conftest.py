"""A small photo set, rendered and placed once for all tests of structure from motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import photo_scene
import pytest
from colmap_models import write_changed_model

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


@contextmanager
def _enabled() -> Iterator[None]:
    from origami import register, unregister

    register()
    yield
    unregister()
