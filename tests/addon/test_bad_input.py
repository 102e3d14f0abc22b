"""Unusable photos and models: each gives a typed error whose message says what to do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import photo_scene
import pytest
from colmap_models import write_changed_model
from origami.core.camera import Camera
from origami.core.errors import UnusablePhotos, UsageError
from origami.core.placing.checks import useful_points
from origami.core.sparse_model import SparseModel
from origami.origami_addon.files.photos import gather
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


def test_a_burst_is_too_near(tmp_path: Path) -> None:
    """1 to 2 mm apart, with a page 300 mm high."""
    page, desk = photo_scene.print_texture(1), photo_scene.print_texture(2, 0.6)
    pose, random = photo_scene.poses(3)[1], np.random.default_rng(3)
    pictures = [
        photo_scene.render(
            replace(pose, translation=pose.translation + random.normal(0, 0.005, 3)),
            photo_scene.folded_sheet(),
            page,
            desk,
        )
        for _ in range(4)
    ]
    photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    with pytest.raises(UnusablePhotos, match=r"too near each other .* move the camera") as failure:
        place_photos(photos, tmp_path / "work", SETTINGS)
    assert "too far" not in str(failure.value)


def test_two_documents_in_one_folder(tmp_path: Path) -> None:
    pictures = []
    for index, pose in enumerate(photo_scene.poses(6)):
        page, desk = (photo_scene.print_texture(10 * (index % 2) + k, 1 - 0.4 * k) for k in (0, 1))
        pictures.append(photo_scene.render(pose, photo_scene.folded_sheet(), page, desk))
    photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    with pytest.raises(UnusablePhotos, match=r"0.jpg, 2.jpg, 4.jpg; 1.jpg, 3.jpg, 5.jpg.*folder of their own"):
        place_photos(photos, tmp_path / "work", SETTINGS)


def test_a_mirrored_photo(tmp_path: Path) -> None:
    """Structure from motion places it behind a nearly flat sheet."""
    page, desk = photo_scene.print_texture(1), photo_scene.print_texture(2, 0.6)
    pictures = [photo_scene.render(pose, photo_scene.folded_sheet(), page, desk) for pose in photo_scene.poses(5)]
    pictures[2] = pictures[2][:, ::-1]
    photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    try:
        result = place_photos(photos, tmp_path / "work", SETTINGS)
    except UnusablePhotos as error:
        assert "mirrored (2.jpg" in str(error)
    else:
        assert any("2.jpg is left out: it is mirrored" in warning for warning in result.warnings)


def test_a_pattern_that_repeats(tmp_path: Path) -> None:
    row, column = np.mgrid[:640, :640] % 32 - 16
    page = np.where((row**2 + column**2 < 64)[..., None], 30.0, np.full(3, 235.0))
    desk = np.random.default_rng(5).normal(120, 2, (640, 640, 3))
    pictures = [photo_scene.render(pose, photo_scene.folded_sheet(), page, desk) for pose in photo_scene.poses(5)]
    photos, _ = gather(picture_set(tmp_path / "photos", pictures))
    with pytest.raises(UnusablePhotos, match="print seems to repeat"):
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
    (stored,) = (tmp_path / "work").glob("*/0")
    with_names = "for image in model.images.values(): image.name = f'{int(image.name)}.jpg'"
    write_changed_model(stored, tmp_path / "model", with_names)
    with pytest.raises(UnusablePhotos, match="moved or bent"):
        load_model(tmp_path / "model", photos, tmp_path)


def test_no_colmap_model(tmp_path: Path, small_photos: list) -> None:
    with pytest.raises(UnusablePhotos, match="holds no COLMAP model"):
        load_model(tmp_path, small_photos, tmp_path)


def test_a_damaged_colmap_model(tmp_path: Path, small_photos: list) -> None:
    for name in ("cameras.bin", "images.bin", "points3D.bin"):
        (tmp_path / name).write_bytes(b"\1\2\3")
    with pytest.raises(UnusablePhotos, match="cannot be read"):
        load_model(tmp_path, small_photos, tmp_path)


WITHOUT_POINTS = "for key in list(model.points3D): model.delete_point3D(key)"
WITH_FEW_POINTS = "for key in list(model.points3D)[50:]: model.delete_point3D(key)"
WITHOUT_SIZE = "for camera in model.cameras.values(): camera.width = 0"
WITHOUT_FOCAL_LENGTH = "for camera in model.cameras.values(): camera.focal_length = 0"
WITH_WRONG_POINTS = """
random = np.random.default_rng(0)
for point in model.points3D.values():
    point.xyz = point.xyz + random.normal(0, 0.02, 3)
"""
WITHOUT_COLORS = "for point in model.points3D.values(): point.color = np.zeros(3, np.uint8)"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (WITHOUT_POINTS, "Only 0 points"),
        (WITH_FEW_POINTS, "Only 50 points|Only 4. points|Only 3. points"),
        (WITHOUT_SIZE, "export the model again"),
        (WITHOUT_FOCAL_LENGTH, "export the model again"),
        (WITH_WRONG_POINTS, "pixels off on average"),
    ],
)
def test_a_useless_colmap_model(
    tmp_path: Path,
    colmap_model: Path,
    small_photos: list,
    change: str,
    sentence: str,
) -> None:
    model = write_changed_model(colmap_model, tmp_path / "model", change, form="text")
    with pytest.raises(UnusablePhotos, match=sentence):
        load_model(model, small_photos, tmp_path)


def test_a_model_whose_cameras_stand_in_one_place() -> None:
    random = np.random.default_rng(0)
    points = random.uniform([-1, -1, 4], [1, 1, 5], (200, 3))
    cameras = tuple(
        Camera(str(x), 640, 480, 600.0, np.array([320.0, 240]), np.zeros(2), np.eye(3), np.array([-x, 0, 0]))
        for x in (0, 0.03, 0.06)
    )
    seen_by = np.repeat(np.arange(3), 200)
    pixels = np.concatenate([camera.project(points) for camera in cameras])
    model = SparseModel(cameras, points, np.zeros((200, 3), np.uint8), np.tile(np.arange(200), 3), seen_by, pixels)
    with pytest.raises(UnusablePhotos, match="from one place"):
        useful_points(model)


@pytest.mark.parametrize("difference", ["names", "size", "content", "content, no colours"])
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
    if difference == "content, no colours":
        colmap_model = write_changed_model(colmap_model, tmp_path / "model", WITHOUT_COLORS, form="text")
    with pytest.raises(UnusablePhotos, match="does not match the photos"):
        load_model(colmap_model, photos, tmp_path)
