"""Structure from motion: right poses, the same bits again, kept results, a worker that ends when it should."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import photo_scene
import pytest
from colmap_models import write_changed_model
from origami.core.errors import Cancelled, StepFailed, UnusablePhotos
from origami.core.placing import checks
from origami.core.sparse_model import SparseModel
from origami.core.watch import SILENT, Watch
from origami.origami_addon.files.photos import gather, read_pixels
from origami.origami_addon.sfm import client, worker_process
from origami.origami_addon.sfm.client import SfmSettings, load_model, place_photos
from origami.origami_addon.sfm.colmap_cameras import to_camera
from PIL import Image
from scipy.spatial.transform import Rotation


def similarity_residual(found: np.ndarray, true: np.ndarray) -> float:
    """Root mean square distance of (N, 3) points after the best similarity, in units of the true points' spread."""
    a, b = found - found.mean(0), true - true.mean(0)
    a = Rotation.align_vectors(b, a)[0].apply(a)
    scale = (a * b).sum() / (a**2).sum()
    return float(np.sqrt(((scale * a - b) ** 2).sum() / (b**2).sum()))


def centers(model: SparseModel) -> np.ndarray:
    return np.array([camera.center for camera in model.cameras])


def test_poses_points_and_lens(small_set) -> None:
    model, figures = small_set.result.model, small_set.result.figures
    assert [camera.name for camera in model.cameras] == [photo.name for photo in small_set.photos]
    assert figures["photos_left_out"] == []
    assert not figures["focal_length_guessed"]
    assert not small_set.result.warnings
    assert similarity_residual(centers(model), np.array([pose.center for pose in small_set.poses])) < 0.01
    assert figures["focal_length_over_long_side"] == pytest.approx(photo_scene.FOCAL_OVER_LONG_SIDE, rel=0.01)
    assert model.views_per_point().min() >= 3
    assert len(model.points) > 500
    assert figures["reprojection_error_mean_px"] < 0.5
    assert model.reprojection_errors().mean() == pytest.approx(figures["reprojection_error_mean_px"])


def test_colors_are_those_of_the_photos(small_set) -> None:
    from origami.origami_addon.files.photos import read_pixels

    model = small_set.result.model
    mine = model.observed_camera == 0
    column, row = model.observed_pixel[mine].astype(int).T
    shown = read_pixels(small_set.photos[0])[row, column].astype(float)
    assert np.corrcoef(shown.ravel(), model.colors[model.observed_point[mine]].ravel())[0, 1] > 0.9


def test_second_run_takes_the_kept_model(small_set, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_process, "WORKER", Path("/no/such/worker"))
    again = place_photos(small_set.photos, small_set.work, small_set.settings)
    np.testing.assert_array_equal(again.model.points, small_set.result.model.points)


def test_one_thread_gives_the_same_bits_and_an_interrupted_run_goes_on(small_set, tmp_path: Path) -> None:
    stop = False

    def progress(fraction: float, text: str) -> None:
        nonlocal stop
        stop = stop or "features in photo 3" in text

    with pytest.raises(Cancelled):
        place_photos(small_set.photos, tmp_path, small_set.settings, Watch(progress, lambda: stop))
    texts: list[str] = []
    again = place_photos(small_set.photos, tmp_path, small_set.settings, Watch(lambda _, text: texts.append(text)))
    assert not any("features in photo 1 " in text for text in texts), "photo 1 was in the database already"
    for name in ("points", "observed_pixel", "observed_point", "colors"):
        np.testing.assert_array_equal(getattr(again.model, name), getattr(small_set.result.model, name))
    np.testing.assert_array_equal(centers(again.model), centers(small_set.result.model))


_FEATURES = """
import sys, numpy as np
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import pycolmap
from pycolmap_worker import features, photos
folder, settings = Path(sys.argv[2]), {"max_image_size": 400, "max_features": 500}
indices = [int(path.stem) for path in sorted(folder.glob("*.ppm"))]
options = pycolmap.FeatureExtractionOptions()
options.use_gpu, options.num_threads, options.max_image_size = False, 1, 400
options.sift.max_num_features = 500
single = pycolmap.FeatureExtractor.create(options)
for threads in (1, 2):
    for start in range(0, len(indices), threads):
        batch = indices[start : start + threads]
        for index, (found, descriptors) in zip(batch, features.features(folder, batch, settings)):
            pixels = photos.read_picture(folder / photos.picture_of(index))
            keypoints, expected = single.extract(pycolmap.Bitmap.from_array(pixels).clone_as_grey())
            places = np.array([(each.x, each.y) for each in keypoints]).reshape(-1, 2)
            assert np.array_equal(found[:, :2], places) and np.array_equal(descriptors.data, expected.data)
            print(index, len(found), *pixels.mean((0, 1)).round(2))
assert not list(folder.glob("features*"))
"""


def test_the_worker_sees_the_photos_as_they_were_decoded(tmp_path: Path) -> None:
    """Each kind of file, with one thread and two; features are those of the decoded pixels, bit for bit."""
    photo = photo_scene.print_texture(3)[:300, :400].astype(np.uint8)
    kinds = {
        "0.png": Image.fromarray(photo),
        "1.webp": Image.fromarray(photo),
        "2.jpg": Image.fromarray(photo[::-1]).convert("CMYK"),
        "3.jpg": Image.fromarray(photo).convert("L"),
        "4.png": Image.fromarray(photo[..., 0].astype(np.uint16) * 257),
        "5.png": Image.new("RGB", (400, 300), (200, 100, 50)),
        "6.jpg": Image.fromarray(photo),
    }
    rotated = Image.Exif()
    rotated[0x0112] = 6
    for name, picture in kinds.items():
        picture.save(tmp_path / name, **({"exif": rotated} if name == "6.jpg" else {}))
    photos, _ = gather(tmp_path)
    assert len(photos) == len(kinds)
    folder = tmp_path / "work"
    folder.mkdir()
    client._stage(photos, folder, SfmSettings(max_image_size=400), SILENT)
    done = subprocess.run(
        [sys.executable, "-c", _FEATURES, str(worker_process.WORKER.parent), str(folder)],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    samples = [line.split() for line in done.stdout.splitlines() if line[:1].isdigit()]
    assert len(samples) == 2 * len(photos)
    assert [line for line in samples if line[0] == "5"] == [["5", "0", "200.0", "100.0", "50.0"]] * 2
    for line in samples:
        pixels = read_pixels(photos[int(line[0])])
        levels = pixels >> 8 if pixels.dtype == np.uint16 else pixels
        assert [float(value) for value in line[2:]] == levels.mean((0, 1)).round(2).tolist()
        assert int(line[1]) > 100 or line[0] == "5"


def test_mixed_orientation_and_a_photo_of_something_else(small_set, tmp_path: Path) -> None:
    page, desk = photo_scene.print_texture(1), photo_scene.print_texture(1001, 0.6)
    for index, pose in enumerate(small_set.poses):
        size = (640, 480) if index in (1, 4) else (480, 640)
        photo_scene.save(
            photo_scene.render(pose, photo_scene.folded_sheet(), page, desk, size), tmp_path / f"{index}.jpg"
        )
    photo_scene.save(np.random.default_rng(0).integers(0, 255, (640, 480, 3), np.uint8), tmp_path / "stranger.jpg")
    photos, _ = gather(tmp_path)
    result = place_photos(photos, tmp_path / "work", replace(small_set.settings, threads=2))
    assert result.figures["photos_left_out"] == ["stranger.jpg"]
    assert any("stranger.jpg" in warning for warning in result.warnings)
    cameras = result.model.cameras
    assert [(c.width, c.height) for c in cameras] == [(p.width, p.height) for p in photos[:6]]
    assert len({camera.focal_length for camera in cameras}) == 1, "one lens for both orientations"
    assert similarity_residual(centers(result.model), np.array([pose.center for pose in small_set.poses])) < 0.01
    assert result.model.reprojection_errors().mean() < 0.5


def test_three_photos(small_set, tmp_path: Path) -> None:
    result = place_photos(small_set.photos[1:4], tmp_path, small_set.settings)
    assert len(result.model.cameras) == 3
    assert len(result.model.points) > 300


@pytest.fixture
def workers(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen]:
    """The processes that are started from now on."""
    started: list[subprocess.Popen] = []
    start = subprocess.Popen

    def remember(*arguments: object, **options: object) -> subprocess.Popen:
        started.append(start(*arguments, **options))
        return started[-1]

    monkeypatch.setattr(subprocess, "Popen", remember)
    return started


AT_WORK = "features in photo 1 "  # the worker reports each finished photo and continues


def test_cancel_ends_the_worker(small_set, tmp_path: Path, workers: list[subprocess.Popen]) -> None:
    asked = threading.Event()

    def ask(_: float, text: str) -> None:
        if AT_WORK in text:
            asked.set()

    with pytest.raises(Cancelled):
        place_photos(small_set.photos, tmp_path, small_set.settings, Watch(ask, asked.is_set))
    assert workers[0].poll() is not None, "the worker is gone when the call returns"


def test_a_worker_that_is_killed(small_set, tmp_path: Path, workers: list[subprocess.Popen]) -> None:
    def shoot(_: float, text: str) -> None:
        if AT_WORK in text:
            workers[0].kill()

    with pytest.raises(StepFailed, match="memory"):
        place_photos(small_set.photos, tmp_path, small_set.settings, Watch(shoot))


def test_no_worker_outlives_its_parent() -> None:
    """A parent that is killed closes the worker's stdin."""
    wait = "import threading; threading.Event().wait()"
    stand_in = (
        "import sys; sys.path.insert(0, sys.argv[1]); from pycolmap_worker import messages; messages.end_with_parent();"
        f"print('at work', flush=True); {wait}"
    )
    parent_code = (
        "import subprocess, sys;"
        f"subprocess.Popen([sys.executable, '-c', {stand_in!r}, sys.argv[1]], stdin=subprocess.PIPE); {wait}"
    )
    command = [sys.executable, "-c", parent_code, str(worker_process.WORKER.parent)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == "at work\n"
        parent.kill()
        # the worker holds the other end of the same pipe, so it ends once both processes are gone
        assert parent.communicate(timeout=60) == ("", None)


@pytest.mark.parametrize(
    ("name", "content", "more_warnings"),
    [
        ("model.npz", b"", 0),
        ("result.json", b"cut off", 0),
        pytest.param("database.db", b"cut off", 1, marks=pytest.mark.slow),
    ],
)
def test_what_a_power_failure_left_is_made_again(
    small_set, tmp_path: Path, name: str, content: bytes, more_warnings: int
) -> None:
    (folder,) = small_set.work.iterdir()
    copy = tmp_path / folder.name
    shutil.copytree(folder, copy)
    if name == "database.db":
        (copy / "result.json").unlink()
    (copy / name).write_bytes(content)
    result = place_photos(small_set.photos, tmp_path, small_set.settings)
    assert len(result.warnings) == len(small_set.result.warnings) + more_warnings
    for now, before in zip(result.model.cameras, small_set.result.model.cameras, strict=True):
        np.testing.assert_array_equal(now.translation, before.translation)


def test_a_worker_that_was_stopped_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "asleep.py").write_text("import time; time.sleep(600)")
    monkeypatch.setattr(worker_process, "WORKER", tmp_path / "asleep.py")
    monkeypatch.setattr(worker_process, "_MOST_SILENT_SECONDS", 0.5)
    with pytest.raises(StepFailed, match="no sign of life"):
        worker_process.run_worker({}, tmp_path, SILENT)


@pytest.mark.parametrize("form", ["binary", "text"])
def test_existing_colmap_model(small_set, colmap_model: Path, tmp_path: Path, form: str) -> None:
    if form == "text":
        colmap_model = write_changed_model(colmap_model, tmp_path, form="text")
    result = load_model(colmap_model, small_set.photos, tmp_path / "work")
    assert len(result.model.points) == len(small_set.result.model.points)
    np.testing.assert_allclose(centers(result.model), centers(small_set.result.model), atol=1e-9)
    assert result.model.reprojection_errors().mean() == pytest.approx(
        small_set.result.model.reprojection_errors().mean(), rel=1e-6
    )


@pytest.mark.parametrize("form", ["binary", "text"])
def test_names_with_spaces_in_a_colmap_model(small_set, colmap_model: Path, tmp_path: Path, form: str) -> None:
    photos = []
    for photo in small_set.photos:
        name = f"a sheet {photo.name}"
        shutil.copy(photo.path, tmp_path / name)
        photos.append(replace(photo, path=tmp_path / name, name=name))
    spaced = "for image in model.images.values(): image.name = f'a sheet {image.name}'"
    model = write_changed_model(colmap_model, tmp_path / "model", spaced, form=form)
    result = load_model(model, photos, tmp_path / "work")
    assert [camera.name for camera in result.model.cameras] == [photo.name for photo in photos]


_HALF_AS_LARGE = """
for camera in model.cameras.values():
    camera.rescale(240, 320)
for image in model.images.values():
    for point in image.points2D:
        point.xy = point.xy / 2
"""


def test_colmap_model_at_another_size_and_with_a_photo_less(small_set, colmap_model: Path, tmp_path: Path) -> None:
    write_changed_model(colmap_model, tmp_path, _HALF_AS_LARGE)
    result = load_model(tmp_path, small_set.photos[:5], tmp_path / "work")
    assert [camera.width for camera in result.model.cameras] == [480] * 5
    assert result.model.reprojection_errors().mean() < 0.5
    assert any("5.jpg" in warning for warning in result.warnings)


@pytest.mark.parametrize("in_exif", ["nothing", "one focal length for all", "both focal lengths"])
def test_zoom_in_every_other_photo(small_set, tmp_path: Path, in_exif: str) -> None:
    page, desk = photo_scene.print_texture(1), photo_scene.print_texture(1001, 0.6)
    for index, pose in enumerate(small_set.poses):
        zoom = 1.35 if index % 2 else 1.0
        exif = Image.Exif()
        if in_exif != "nothing":
            zoom_in_exif = zoom if in_exif == "both focal lengths" else 1.0
            exif.get_ifd(0x8769)[0xA405] = round(zoom_in_exif * photo_scene.FOCAL_OVER_LONG_SIDE * 36 * 800 / 768)
        picture = photo_scene.render(pose, photo_scene.folded_sheet(), page, desk, zoom=zoom)
        photo_scene.save(picture, tmp_path / f"{index}.jpg", exif=exif)
    photos, _ = gather(tmp_path)
    result = place_photos(photos, tmp_path / "work", small_set.settings)
    assert [camera.name for camera in result.model.cameras] == [photo.name for photo in photos]
    found = np.array([camera.focal_length / 640 for camera in result.model.cameras])
    np.testing.assert_allclose(found[::2], photo_scene.FOCAL_OVER_LONG_SIDE, rtol=0.01)
    np.testing.assert_allclose(found[1::2], 1.35 * photo_scene.FOCAL_OVER_LONG_SIDE, rtol=0.01)
    assert similarity_residual(centers(result.model), np.array([pose.center for pose in small_set.poses])) < 0.01
    (warning,) = result.warnings
    assert f"{'The camera or its zoom' if in_exif == 'both focal lengths' else 'The zoom'} differs between" in warning
    assert ("tried" in result.figures) == (in_exif != "both focal lengths")


def test_a_guessed_focal_length_is_reported(small_set, tmp_path: Path) -> None:
    """As if the worker had come to its last attempt."""
    kept = next(small_set.work.glob("*/result.json")).parent
    shutil.copytree(kept, tmp_path / kept.name)
    content = json.loads((kept / "result.json").read_text())["content"] | {"way": checks.GUESSED}
    digest = hashlib.sha256((kept / "model.npz").read_bytes() + json.dumps(content, sort_keys=True).encode())
    stored = {"sha256": digest.hexdigest(), "content": content}
    (tmp_path / kept.name / "result.json").write_text(json.dumps(stored))
    result = place_photos(small_set.photos, tmp_path, small_set.settings)
    assert result.figures["focal_length_guessed"]
    assert any("focal length" in warning for warning in result.warnings)


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [
        ("OPENCV", [700, 700.1, 300, 400, 0.05, -0.02, 1e-4, -2e-4]),
        # the rational terms cancel out up to the fourth power of the radius
        ("FULL_OPENCV", [700, 700, 300, 400, 0.05, 0.01, 0, 0, 0.002, 0.02, 0.001, 0]),
    ],
)
def test_weak_other_terms_of_a_colmap_lens_go_into_the_radial_ones(kind: str, parameters: list[float]) -> None:
    pose = np.hstack([np.eye(3), np.zeros((3, 1))])
    camera = to_camera("a", kind, (600, 800), np.array(parameters), pose)
    fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 = [*parameters, 0, 0, 0, 0][:12]
    x, y = np.random.default_rng(1).uniform([-0.42, -0.56], [0.42, 0.56], (200, 2)).T
    r2 = x**2 + y**2
    radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    expected = [
        fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2)) + cx,
        fy * (y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y**2)) + cy,
    ]
    seen = camera.project(np.stack([x, y, np.ones_like(x)], axis=1))
    assert np.hypot(*(seen.T - expected)).max() < 0.25


def test_colmap_lenses() -> None:
    pose = np.hstack([np.eye(3), np.zeros((3, 1))])
    same = {
        "SIMPLE_PINHOLE": [700, 300, 400],
        "PINHOLE": [700, 700, 300, 400],
        "SIMPLE_RADIAL": [700, 300, 400, 0.0],
        "RADIAL": [700, 300, 400, 0.0, 0.0],
        "OPENCV": [700, 700, 300, 400, 0.0, 0.0, 0.0, 0.0],
        "FULL_OPENCV": [700, 700, 300, 400, *[0.0] * 8],
    }
    for kind, parameters in same.items():
        camera = to_camera("a", kind, (600, 800), np.array(parameters), pose)
        assert camera.focal_length == 700, kind
        np.testing.assert_array_equal(camera.principal_point, [300, 400], err_msg=kind)
        np.testing.assert_array_equal(camera.distortion, [0, 0], err_msg=kind)
    radial = to_camera("a", "OPENCV", (600, 800), np.array([700, 700, 300, 400, 0.1, -0.02, 0, 0]), pose)
    np.testing.assert_array_equal(radial.distortion, [0.1, -0.02])
    for kind, parameters in {
        "OPENCV_FISHEYE": [700, 700, 300, 400, 0.1, 0, 0, 0],
        "OPENCV": [700, 700, 300, 400, 0, 0, 1e-2, 0],
        "PINHOLE": [700, 720, 300, 400],
        "FULL_OPENCV": [700, 700, 300, 400, 0, 0, 0, 0, 0.3, 0, 0, 0],
    }.items():
        with pytest.raises(UnusablePhotos, match="undistort"):
            to_camera("a", kind, (600, 800), np.array(parameters), pose)
