"""Which files are photos: by their content, whatever their names, in folders and in folders inside them."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import numpy as np
import pytest
from heif_files import encoded
from origami.core.errors import UnusablePhotos, UsageError
from origami.origami_addon.files import photo_files as photo_files_module
from origami.origami_addon.files.photo_files import photo_files
from origami.origami_addon.files.photo_metadata import read_metadata
from origami.origami_addon.files.photos import gather, read_pixels
from origami.origami_addon.files.picture_kinds import kind_of
from origami.origami_addon.steps.results import document_name
from PIL import Image


def picture(number: int) -> Image.Image:
    row, column = np.mgrid[:120, :160]
    shades = np.stack([row * 2, column + 40, 255 - row - column // 2], -1).astype(np.uint8)
    return Image.fromarray(np.roll(shades, 7 * number, 1))


def written(image: Image.Image, kind: str, **options: object) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def tiff(*entries: tuple[int, int, int, int]) -> bytes:
    """A TIFF's header and its first folder."""
    return b"II*\0\x08\0\0\0" + struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *e) for e in entries)


def box(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I4s", 8 + len(content), kind) + content


MOVIE = box(b"ftyp", b"mp42\0\0\0\0isommp42") + box(b"mdat", bytes(100))
DNG = tiff((254, 4, 1, 1), (271, 2, 4, 0), (50706, 1, 4, 1025))
NEF = tiff((254, 4, 1, 1), (330, 4, 1, 400))


def test_a_file_is_what_its_content_says(tmp_path: Path) -> None:
    one = written(picture(1), "JPEG")
    contents = {
        "1 jpeg.HEIC": one,
        "2 heic.JPG": encoded(np.asarray(picture(2))),
        "3 png.jpg": written(picture(3), "PNG"),
        "4.jfif": written(picture(4), "JPEG"),
        "5 two pictures.MPO": written(picture(5), "MPO", save_all=True, append_images=[picture(6)]),
        "6 motion.jpg": written(picture(6), "JPEG") + MOVIE,
        "7 avif.png": encoded(np.asarray(picture(7)), "avif"),
        "8 no ending": written(picture(8), "WEBP"),
        "9.TIFF": written(picture(9), "TIFF"),
        "6 motion.mov": MOVIE,
        "11 notes.txt": b"BMW and other words",
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    photos, warnings = gather(tmp_path)
    assert [photo.name for photo in photos] == list(contents)[:9]
    assert not warnings
    for number, photo in enumerate(photos, 1):
        assert np.abs(read_pixels(photo).astype(int) - np.asarray(picture(number))).mean() < 6, photo.name
    by_name, _ = gather([tmp_path / name for name in list(contents)[:9]])
    assert [photo.sha256 for photo in by_name] == [photo.sha256 for photo in photos]


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("raw.dng", DNG, "is a camera's RAW file and is left out: use the JPEG"),
        ("raw.jpg", DNG, "is a camera's RAW file"),
        ("raw.tif", NEF, "is a camera's RAW file"),
        ("raw.arw", tiff((256, 4, 1, 9)), "is a camera's RAW file"),
        ("raw.jpg", box(b"ftyp", b"crx \0\0\0\1crx isom"), "is a camera's RAW file"),
        ("movie.jpg", MOVIE, "is a movie and is left out"),
        ("moving.jpg", written(picture(0), "GIF"), "is of the kind GIF, which Origami does not read"),
        ("huge.jpg", b"BM" + bytes(100), "is of the kind BMP"),
        ("words.jpg", b"words", "is not a photo that can be decoded"),
    ],
)
def test_files_that_are_no_photos(tmp_path: Path, name: str, content: bytes, sentence: str) -> None:
    for number in range(3):
        picture(number).save(tmp_path / f"{number}.png")
    (tmp_path / name).write_bytes(content)
    photos, warnings = gather([tmp_path / f"{number}.png" for number in range(3)] + [tmp_path / name])
    assert len(photos) == 3
    (warning,) = warnings
    assert warning.startswith(f"{name} {sentence}")


def test_an_ordinary_tiff_is_no_raw_file() -> None:
    assert kind_of(io.BytesIO(tiff((254, 4, 1, 0), (330, 4, 1, 400))), ".tif") == "TIFF"
    assert kind_of(io.BytesIO(written(picture(0), "TIFF")), "") == "TIFF"


def test_names_in_any_script_and_with_a_newline(tmp_path: Path) -> None:
    names = ["стр 1.jpg", "ページ 2.jpg", "صفحة 3.jpg", "two\nlines 4.jpg", "é 5.HEIC"]
    for number, name in enumerate(names[:4]):
        picture(number).save(tmp_path / name)
    (tmp_path / names[4]).write_bytes(encoded(np.asarray(picture(4))))
    photos, warnings = gather(tmp_path)
    assert {photo.name for photo in photos} == set(names)
    assert not warnings
    assert all(read_pixels(photo).shape == (120, 160, 3) for photo in photos)


@pytest.fixture
def folders(tmp_path: Path) -> Path:
    """Photos in left and in right/deep, a finished page in out, and something hidden."""
    for number, folder in enumerate(("left", "right/deep", "out/cameras", ".trash")):
        (tmp_path / folder).mkdir(parents=True)
        picture(number).save(tmp_path / folder / "1.jpg")
    picture(9).save(tmp_path / "left" / "2.jpg")
    (tmp_path / "out" / ".origami").write_text("{}")
    return tmp_path


def test_photos_in_folders_inside(folders: Path) -> None:
    photos, warnings = gather(folders, recursive=True)
    assert [photo.name for photo in photos] == ["left/1.jpg", "2.jpg", "deep/1.jpg"]
    assert not warnings
    with pytest.raises(UnusablePhotos, match=r"they are in folders inside it \(left and right\).*--recursive"):
        gather(folders)


def test_document_is_named_after_the_folder_of_all(folders: Path) -> None:
    photos, _ = gather(folders, recursive=True)
    assert document_name(photos) == folders.name
    assert document_name(photos[:2]) == "left"


def test_each_file_is_looked_into_once(folders: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    looked_into: list[str] = []
    monkeypatch.setattr(photo_files_module, "kind_of_file", lambda file: looked_into.append(file.name) or "JPEG")
    photo_files([folders], recursive=True)
    assert sorted(looked_into) == ["1.jpg", "1.jpg", "2.jpg"]


def test_links_in_a_circle(folders: Path) -> None:
    (folders / "left" / "up").symlink_to(folders)
    assert len(photo_files([folders], recursive=True)[0]) == 3


def test_a_folder_that_cannot_be_read(folders: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def walk(folder: Path, onerror: object) -> list:
        onerror(PermissionError(13, "Permission denied", str(folder)))
        return []

    monkeypatch.setattr(photo_files_module.os, "walk", walk)
    with pytest.raises(UsageError, match=r"cannot be read \(Permission denied\)"):
        gather(folders)


def test_exif_that_points_to_itself_is_read_once() -> None:
    """With 5400 such entries the reading took minutes."""
    exif = tiff(*[(0x8769, 4, 1, 8)] * 5400)
    jpeg = b"\xff\xd8\xff\xe1" + struct.pack(">H", 2 + 6 + len(exif)) + b"Exif\0\0" + exif + b"\xff\xda\0\2\xff\xd9"
    assert read_metadata(jpeg).orientation == 1


def test_more_pixels_than_any_camera_has(tmp_path: Path) -> None:
    """Nothing is decoded, so no memory is taken."""
    png = bytearray(written(picture(0), "PNG"))
    png[16:24] = struct.pack(">II", 60000, 60000)
    (tmp_path / "huge.png").write_bytes(png)
    with pytest.raises(UnusablePhotos, match=r"huge\.png (claims to have|is not a photo)"):
        gather([tmp_path / "huge.png"])
