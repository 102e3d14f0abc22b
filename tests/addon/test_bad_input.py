"""Photos and models that cannot serve: each a typed error whose sentence says what to do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import photo_scene
import pytest
from origami.core.errors import UnusablePhotos, UsageError
from origami.origami_addon.photos import gather
from origami.origami_addon.sfm.client import SfmSettings, load_model, place_photos

SETTINGS = SfmSettings(max_features=1500)


def picture_set(folder: Path, pictures: list[np.ndarray]) -> Path:
    for index, picture in enumerate(pictures):
        photo_scene.save(picture, folder / f"{index}.jpg")
    return folder


def test_no_path() -> None:
    with pytest.raises(UsageError, match="No photos"):
        gather([])


def test_unknown_path(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="check the path"):
        gather(tmp_path / "nowhere")


def test_empty_folder(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("no photos here")
    with pytest.raises(UnusablePhotos, match="no photos"):
        gather(tmp_path)


def test_two_photos(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    picture_set(tmp_path, [random.integers(0, 255, (120, 160, 3), np.uint8) for _ in range(2)])
    with pytest.raises(UnusablePhotos, match="at least 3"):
        gather(tmp_path)


def test_the_same_photo_four_times(tmp_path: Path) -> None:
    picture_set(tmp_path, [np.random.default_rng(0).integers(0, 255, (120, 160, 3), np.uint8)] * 4)
    with pytest.raises(UnusablePhotos, match=r"same photo was given 4 times \(0.jpg\)"):
        gather(tmp_path)


def test_all_photos_from_one_place(tmp_path: Path) -> None:
    page, desk = photo_scene.print_texture(1), photo_scene.print_texture(2, 0.6)
    pose = photo_scene.poses(3)[1]
    pictures = []
    for angle in (-0.08, -0.03, 0.03, 0.08):
        turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        turned = photo_scene.Pose(turn @ pose.rotation, turn @ pose.translation)
        pictures.append(photo_scene.render(turned, photo_scene.folded_sheet(), page, desk))
    photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    with pytest.raises(UnusablePhotos, match="from one place"):
        place_photos(photos, tmp_path / "work", SETTINGS)


def test_photos_of_different_things(tmp_path: Path) -> None:
    pictures = []
    for index, pose in enumerate(photo_scene.poses(4)):
        page = photo_scene.print_texture(10 + index)
        pictures.append(photo_scene.render(pose, photo_scene.folded_sheet(), page, None))
    photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    with pytest.raises(UnusablePhotos, match="different things"):
        place_photos(photos, tmp_path / "work", SETTINGS)


@pytest.mark.parametrize("change", ["bent", "moved"])
def test_a_sheet_that_changed_between_photos(tmp_path: Path, change: str) -> None:
    page, desk = photo_scene.print_texture(1), photo_scene.print_texture(2, 0.6)
    before = photo_scene.folded_sheet(40)
    after = photo_scene.folded_sheet(28) if change == "bent" else photo_scene.folded_sheet(40, (0.04, 0.03, 0.1))
    pictures = [
        photo_scene.render(pose, after if index % 2 else before, page, desk)
        for index, pose in enumerate(photo_scene.poses(6))
    ]
    photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    with pytest.raises(UnusablePhotos, match="moved or bent") as failure:
        place_photos(photos, tmp_path / "work", SETTINGS)
    assert failure.value.exit_code == 4


def test_no_colmap_model(tmp_path: Path, small_photos: list) -> None:
    with pytest.raises(UnusablePhotos, match="holds no COLMAP model"):
        load_model(tmp_path, small_photos, tmp_path)


def test_a_damaged_colmap_model(tmp_path: Path, small_photos: list) -> None:
    for name in ("cameras.bin", "images.bin", "points3D.bin"):
        (tmp_path / name).write_bytes(b"\1\2\3")
    with pytest.raises(UnusablePhotos, match="cannot be read"):
        load_model(tmp_path, small_photos, tmp_path)


@pytest.mark.parametrize("difference", ["names", "size", "content"])
def test_a_colmap_model_of_other_photos(
    tmp_path: Path, colmap_model: Path, small_photos: list, difference: str
) -> None:
    if difference == "names":
        photos = [replace(photo, path=photo.path.with_name("x" + photo.path.name)) for photo in small_photos]
    elif difference == "size":
        photos = [replace(photo, width=photo.height, height=photo.width) for photo in small_photos]
    else:
        page = photo_scene.print_texture(77)
        pictures = [photo_scene.render(p, photo_scene.folded_sheet(), page, page) for p in photo_scene.poses(6, seed=5)]
        photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    with pytest.raises(UnusablePhotos, match="does not match the photos"):
        load_model(colmap_model, photos, tmp_path)
