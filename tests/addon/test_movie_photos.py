"""Photos out of movies: which frames, where they are written, when they are used again."""

from __future__ import annotations

import hashlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from origami.core.errors import Cancelled, StepFailed, UnusablePhotos, UsageError
from origami.core.watch import Watch
from origami.origami_addon.files import movie_photos
from origami.origami_addon.files.movie_photos import movies_among, take_photos
from origami.origami_addon.files.photo_files import photo_files, photos_in
from origami.origami_addon.files.photos import gather, read_pixels
from PIL import Image

WIDTH, HEIGHT, FRAMES = 320, 240, 48


def frame(number: int) -> np.ndarray:
    """A frame of one plain colour beside print that moves; every fourth is sharp, the others are blurred."""
    random = np.random.default_rng(5)
    wide = cv2.resize(random.integers(0, 256, (HEIGHT // 4, 3 * WIDTH // 4, 3), np.uint8), None, fx=4, fy=4)
    picture = wide[:, 4 * number : 4 * number + WIDTH].copy()
    picture[:, :40] = (200, 60, 30)
    return picture if number % 4 == 2 else cv2.GaussianBlur(picture, (0, 0), 3)


@pytest.fixture(scope="module")
def movie(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("movie") / "a walk.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 12, (WIDTH, HEIGHT))
    for number in range(FRAMES):
        writer.write(frame(number)[..., ::-1])
    writer.release()
    return path


def test_sharp_frames_from_the_whole_movie_become_photos(movie: Path, tmp_path: Path) -> None:
    taken = take_photos(movie, tmp_path)
    numbers = [each.number for each in taken.frames]
    assert len(numbers) in range(8, 13)
    assert sum((number - 1) % 4 == 2 for number in numbers) >= len(numbers) - 1
    assert np.diff([0, *numbers, FRAMES]).max() <= 10
    assert [each.seconds for each in taken.frames] == pytest.approx([(n - 1) / 12 for n in numbers], abs=1e-3)
    assert [path.name for path in taken.pictures] == [f"a walk-{n:02d}.png" for n in numbers]
    pixels = np.asarray(Image.open(taken.pictures[3])).astype(int)
    assert pixels.shape == (HEIGHT, WIDTH, 3)
    assert abs(pixels - frame(numbers[3] - 1)).mean() < 20
    assert abs(pixels[100, 15] - (200, 60, 30)).max() < 8
    photos, warnings = gather(taken.pictures)
    assert [photo.name for photo in photos] == [path.name for path in taken.pictures]
    assert not warnings
    assert read_pixels(photos[0]).shape == (HEIGHT, WIDTH, 3)


def test_frames_are_written_once_and_again_where_they_were_changed(movie: Path, tmp_path: Path) -> None:
    first = take_photos(movie, tmp_path)
    before = [path.stat().st_mtime_ns for path in first.pictures]
    assert take_photos(movie, tmp_path) == first
    assert [path.stat().st_mtime_ns for path in first.pictures] == before
    first.pictures[2].write_bytes(b"")
    assert take_photos(movie, tmp_path) == first
    assert hashlib.sha256(first.pictures[2].read_bytes()).hexdigest() == first.frames[2].sha256
    (first.folder / "frames.json").write_text("[1]")
    assert take_photos(movie, tmp_path) == first


def test_a_stopped_choice_is_not_taken_for_a_finished_one(movie: Path, tmp_path: Path) -> None:
    steps: list[float] = []
    late = Watch(lambda fraction, text: steps.append(fraction), lambda: bool(steps) and steps[-1] > 0.9)
    with pytest.raises(Cancelled):
        take_photos(movie, tmp_path, late)
    assert len(take_photos(movie, tmp_path).frames) >= 8


def test_a_damaged_movie_is_named(movie: Path, tmp_path: Path) -> None:
    content = movie.read_bytes()
    for name, data in (("half.avi", content[:2000]), ("empty.avi", content[:40])):
        damaged = tmp_path / name
        damaged.write_bytes(data)
        with pytest.raises(UnusablePhotos, match=rf"{name} is a movie that Blender cannot decode"):
            take_photos(damaged, tmp_path / "frames")
    assert not list((tmp_path / "frames").glob("*"))


def test_a_folder_that_cannot_be_written_to_is_named(movie: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(StepFailed, match=r"a walk\.avi cannot be written into .*file .*: copy the movie"):
        take_photos(movie, tmp_path / "file")


def test_a_movie_that_is_too_large_leaves_no_folder(
    movie: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(movie_photos, "MOST_PIXELS", WIDTH * HEIGHT - 1)
    with pytest.raises(UnusablePhotos, match="more than any camera's movie"):
        take_photos(movie, tmp_path)
    assert not list(tmp_path.iterdir())


def test_only_movies_are_movies(movie: Path, tmp_path: Path) -> None:
    text = tmp_path / "letter.mov"
    text.write_text("The wide, wide world")
    old = tmp_path / "old.mov"
    old.write_bytes(b"\0\0\0\x08wide\0\0\0\x10mdat" + bytes(8))
    assert movies_among([movie, text, old, tmp_path / "gone.mov"]) == [movie, old]


def test_a_folder_gives_its_movies_only_where_it_has_no_photos(movie: Path, tmp_path: Path) -> None:
    for name in ("IMG_1.mov", "other.mp4"):
        (tmp_path / name).write_bytes(movie.read_bytes())
    files, sentences = photo_files([tmp_path], recursive=False)
    assert [file.name for file in files] == ["IMG_1.mov", "other.mp4"] and not sentences
    Image.fromarray(frame(2)).save(tmp_path / "IMG_1.jpg")
    files, sentences = photos_in(tmp_path, recursive=False)
    assert [file.name for file in files] == ["IMG_1.jpg"]
    assert len(sentences) == 1 and "(other.mp4): name a movie to use it" in sentences[0]


def test_a_burst_is_thinned(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    for place in range(3):
        picture = cv2.resize(random.integers(0, 256, (12, 16, 3), np.uint8), (WIDTH, HEIGHT))
        for number in range(6):
            noisy = np.clip(picture + random.normal(0, 3 + number, picture.shape), 0, 255).astype(np.uint8)
            Image.fromarray(noisy).save(tmp_path / f"{place}{number}.png")
    photos, warnings = gather([tmp_path])
    assert len(photos) == 12
    assert len({photo.name[0] for photo in photos}) == 3
    assert warnings and all("nearly the same view as" in sentence for sentence in warnings)


def test_nothing_but_a_missing_file_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no file or folder"):
        photo_files([tmp_path / "gone.mp4"], recursive=False)
