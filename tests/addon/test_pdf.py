"""The page as a PDF: its size, its picture and its names, as a reader of the format finds them."""

from __future__ import annotations

import io
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from origami.core.errors import StepFailed
from origami.origami_addon.files.icc import grey_profile, srgb_profile
from origami.origami_addon.files.image_files import write_jpeg, write_tiff
from origami.origami_addon.files.pdf import write_pdf
from PIL import Image

TITLE = "Brief ü & <Größe> 漢"
SIZE = (127.0, 203.3)  # millimetres


@pytest.fixture
def picture() -> np.ndarray:
    colors = np.random.default_rng(0).integers(0, 256, (21, 13, 3), dtype=np.uint8)
    return colors.repeat(8, axis=0).repeat(8, axis=1)[:-3, :-1]


def written(path: Path, image: np.ndarray) -> bytes:
    write_pdf(path, image, 150, SIZE, TITLE)
    return path.read_bytes()


def objects_of(pdf: bytes) -> dict[int, tuple[bytes, bytes]]:
    """Dictionary and stream of each object, found by the table at the end of the file."""
    start = int(re.search(rb"startxref\n(\d+)\n%%EOF\n\Z", pdf)[1])
    lines = pdf[start:].splitlines()
    assert lines[0] == b"xref"
    found = {}
    for number in range(1, int(lines[1].split()[1])):
        place, _, used = lines[2 + number].split()
        assert used == b"n"
        head = f"{number} 0 obj\n".encode()
        assert pdf[int(place) :].startswith(head)
        entries = re.compile(rb"(.*?)(?:\nstream\n|\nendobj\n)", re.DOTALL).match(pdf, int(place) + len(head))
        length = re.search(rb"/Length (\d+)", entries[1])
        content = pdf[entries.end() : entries.end() + int(length[1])] if length else b""
        if length:
            assert pdf[entries.end() + len(content) :].startswith(b"\nendstream\nendobj\n")
        found[number] = entries[1], content
    return found


def picture_of(pdf: bytes) -> tuple[bytes, bytes]:
    return next(each for each in objects_of(pdf).values() if b"/Subtype /Image" in each[0])


def profile_in(pdf: bytes) -> bytes:
    number = int(re.search(rb"/ICCBased (\d+) 0 R", picture_of(pdf)[0])[1])
    return zlib.decompress(objects_of(pdf)[number][1])


def test_colour_is_the_jpeg_with_its_profile(tmp_path: Path, picture):
    pdf = written(tmp_path / "page.pdf", picture)
    write_jpeg(tmp_path / "page.jpg", picture, 150)
    entries, content = picture_of(pdf)
    assert content == (tmp_path / "page.jpg").read_bytes()
    assert b"/Filter /DCTDecode" in entries
    assert profile_in(pdf) == srgb_profile()
    assert b"/Width 103 /Height 165" in entries


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_grey_is_a_jpeg_of_one_channel(tmp_path: Path, picture, dtype):
    grey = picture[..., 0].astype(dtype) * dtype(np.iinfo(dtype).max // 255)
    pdf = written(tmp_path / "page.pdf", grey)
    with Image.open(io.BytesIO(picture_of(pdf)[1])) as read:
        assert read.mode == "L"
        assert np.abs(np.asarray(read).astype(int) - picture[..., 0]).mean() < 6
    assert profile_in(pdf) == grey_profile()


def test_black_and_white_is_lossless(tmp_path: Path, picture):
    image = picture[..., 0] > 120
    entries, content = picture_of(written(tmp_path / "page.pdf", image))
    assert b"/Filter /CCITTFaxDecode /DecodeParms << /K -1 /Columns 103 /Rows 165 >>" in entries
    assert b"/ColorSpace /DeviceGray /BitsPerComponent 1" in entries
    write_tiff(tmp_path / "page.tif", image, 150)  # whose strip other tests decode
    assert (tmp_path / "page.tif").read_bytes().endswith(content)


def test_page_has_the_papers_size(tmp_path: Path, picture):
    pages = [each for each, _ in objects_of(written(tmp_path / "page.pdf", picture)).values() if b"/Page " in each]
    (box,) = (re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", page) for page in pages if b"/MediaBox" in page)
    assert [float(side) for side in box.groups()] == pytest.approx([360, 203.3 / 25.4 * 72], abs=1e-3)


def test_title_in_any_script(tmp_path: Path, picture):
    pdf = written(tmp_path / "page.pdf", picture)
    (title,) = re.findall(rb"/Title <([0-9A-F]+)>", pdf)
    assert bytes.fromhex(title.decode()).decode("utf-16") == TITLE
    xmp = next(content for entries, content in objects_of(pdf).values() if b"/Subtype /XML" in entries).decode()
    assert "Brief ü &amp; &lt;Größe&gt; 漢" in xmp
    write_pdf(tmp_path / "page.pdf", picture, 150, SIZE, "a\nb\x01\udce4c")  # as from a folder's name
    assert b"<FEFF006100620063>" in (tmp_path / "page.pdf").read_bytes()


def test_same_page_same_file(tmp_path: Path, picture):
    first, second = (written(tmp_path / name, picture) for name in ("a.pdf", "b.pdf"))
    assert first == second
    other = written(tmp_path / "a.pdf", 255 - picture)
    assert re.search(rb"/ID \[.*\]", first)[0] != re.search(rb"/ID \[.*\]", other)[0]


def test_failure_is_reported_and_leaves_nothing(tmp_path: Path, picture):
    (tmp_path / "page").mkdir()
    with pytest.raises(StepFailed, match="page could not be written"):
        write_pdf(tmp_path / "page", picture, 150, SIZE, TITLE)
    assert [path.name for path in tmp_path.iterdir()] == ["page"]
