"""Inputs of all kinds of badness: each ends with the right exit code and a sentence that says why.

Structure from motion is a stand-in that fails, so an input that is used ends with exit code 5 and its sentence.
"""

from __future__ import annotations

import io
import json
import os
import re
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from marked_folder import mark
from origami.core.errors import StepFailed
from origami.origami_addon import run
from PIL import Image

USED = "It comes to the structure from motion."


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with three photos."""
    folder = tmp_path_factory.mktemp("good")
    for number in range(3):
        Image.new("RGB", (160, 120), (number, 0, 0)).save(folder / f"{number}.png")
    return folder


@pytest.fixture
def ends(
    command: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str]]:
    """Runs the command; returns its exit code and what it says."""

    def place(*_: object) -> None:
        raise StepFailed(USED)

    monkeypatch.setattr(run.steps, "place_photos", place)
    monkeypatch.setattr(command, "start_empty", lambda: None)

    def rectify(*arguments: object) -> tuple[int, str]:
        code = command.main([*map(str, arguments), "-q"])
        said = capsys.readouterr().err
        assert code != 3, said
        assert "Traceback" not in said
        assert code == 0 or said.endswith(".\n") or "usage:" in said, said
        return code, said

    return rectify


def jpeg(**options: object) -> bytes:
    return encoded("JPEG", **options)


def encoded(kind: str, mode: str = "RGB", **options: object) -> bytes:
    noise = np.random.default_rng(1).integers(0, 256, (120, 160, 3), np.uint8)
    file = io.BytesIO()
    Image.fromarray(noise).convert(mode).save(file, kind, **options)
    return file.getvalue()


def part(content: bytes, share: float) -> bytes:
    return content[: int(share * len(content))]


def with_bytes(content: bytes, at: int, new: bytes) -> bytes:
    return content[:at] + new + content[at + len(new) :]


def of_size(content: bytes, width: int, height: int) -> bytes:
    """A JPEG whose header states another size."""
    at = content.index(b"\xff\xc0") + 5
    return with_bytes(content, at, struct.pack(">HH", height, width))


def png(width: int, height: int, depth: int = 8, data: bytes = b"", more: bytes = b"") -> bytes:
    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + more + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


def with_exif(*entries: tuple[int, int, int, int], then: int = 0) -> bytes:
    """A JPEG with these entries (tag, type, count, value) in the first folder of its EXIF."""
    folder = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *entry) for entry in entries)
    exif = b"Exif\0\0II*\0\x08\0\0\0" + folder + struct.pack("<I", then) + bytes(64)
    content = jpeg()
    return content[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + content[2:]


def tiff(*entries: tuple[int, int, int, int], then: int = 0, then_data: bytes = bytes(64)) -> bytes:
    folder = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *entry) for entry in entries)
    return b"II*\0\x08\0\0\0" + folder + struct.pack("<I", then) + then_data


def usual(width: int, height: int, at: int = 200, size: int = 57600) -> list[tuple[int, int, int, int]]:
    """The entries of an uncompressed TIFF in grey."""
    return [
        (256, 4, 1, width),
        (257, 4, 1, height),
        (258, 3, 1, 8),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 4, 1, at),
        (277, 3, 1, 1),
        (278, 4, 1, height),
        (279, 4, 1, size),
    ]


CUT, DAMAGED, NONE, HUGE, OTHER = "cut short", "damaged", "decoded", "more than any camera", "does not read"
OUT_OF_PLACE = "is left out"
# The name of a file beside three good ones, its content, and words of the sentence about it; none if it is used.
FILES: list[tuple[str, Callable[[], bytes], str]] = [
    ("empty.jpg", lambda: b"", "is empty"),
    ("one.jpg", lambda: b"\xff", NONE),
    ("random.jpg", lambda: np.random.default_rng(2).bytes(5000), NONE),
    ("text.jpg", lambda: b"not a photo\n" * 50, NONE),
    ("zeros.jpg", lambda: bytes(5000), NONE),
    ("soi_eoi.jpg", lambda: b"\xff\xd8\xff\xd9", OUT_OF_PLACE),
    ("soi.jpg", lambda: b"\xff\xd8\xff\xe0", OUT_OF_PLACE),
    *[(f"cut{cut}.jpg", lambda cut=cut: part(jpeg(), cut / 100), OUT_OF_PLACE) for cut in (1, 5, 20, 50, 80, 99)],
    *[(f"cut_eoi{cut}.jpg", lambda cut=cut: part(jpeg(), cut / 100) + b"\xff\xd9", OUT_OF_PLACE) for cut in (5, 20)],
    *[
        (f"progressive{cut}.jpg", lambda cut=cut: part(jpeg(progressive=True), cut / 100), OUT_OF_PLACE)
        for cut in (5, 50, 95)
    ],
    ("junk_behind.jpg", lambda: jpeg() + bytes(1000), ""),
    ("height0.jpg", lambda: of_size(jpeg(), 160, 0), OUT_OF_PLACE),
    ("width0.jpg", lambda: of_size(jpeg(), 0, 120), OUT_OF_PLACE),
    ("huge.jpg", lambda: of_size(jpeg(), 65500, 65500), OUT_OF_PLACE),
    ("small.jpg", lambda: encoded_small("JPEG"), "too small"),
    ("small.png", lambda: encoded_small("PNG"), "too small"),
    ("no_tables.jpg", lambda: jpeg().replace(b"\xff\xdb", b"\xff\xec"), OUT_OF_PLACE),
    ("grey.jpg", lambda: jpeg(mode="L"), ""),
    ("bad_profile.jpg", lambda: jpeg(icc_profile=b"\1" * 300), ""),
    ("jpeg.png", jpeg, ""),
    ("png.jpg", lambda: encoded("PNG"), ""),
    ("webp.jpg", lambda: encoded("WEBP"), ""),
    ("tiff.jpg", lambda: encoded("TIFF"), ""),
    ("gif.jpg", lambda: encoded("GIF"), OTHER),
    ("bmp.jpg", lambda: encoded("BMP"), OTHER),
    ("bmp_huge.jpg", lambda: with_bytes(encoded("BMP"), 18, struct.pack("<ii", 60000, 60000)), OTHER),
    ("icon.jpg", lambda: encoded("ICO"), OUT_OF_PLACE),
    ("photoshop.jpg", lambda: b"8BPS\0\1" + bytes(200), OUT_OF_PLACE),
    ("openexr.jpg", lambda: b"\x76\x2f\x31\x01" + bytes(200), OUT_OF_PLACE),
    ("radiance.jpg", lambda: b"#?RADIANCE\n" + bytes(200), OUT_OF_PLACE),
    ("dpx.jpg", lambda: b"SDPX" + bytes(3000), OUT_OF_PLACE),
    ("svg.jpg", lambda: b"<svg xmlns='http://www.w3.org/2000/svg'/>", OUT_OF_PLACE),
    ("pdf.jpg", lambda: encoded("PDF"), OUT_OF_PLACE),
    ("jpeg2000.jpg", lambda: encoded("JPEG2000"), OUT_OF_PLACE),
    ("movie.jpg", lambda: b"\0\0\0\x18ftypmp42" + bytes(300), OUT_OF_PLACE),
    ("heic.jpg", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + bytes(300), OUT_OF_PLACE),
    ("heic_endless.heic", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + b"\0\0\0\x08meta" * 200, OUT_OF_PLACE),
    ("heic_size0.heic", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic\0\0\0\0meta" + bytes(99), OUT_OF_PLACE),
    ("heic_size64.heic", lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic\0\0\0\1meta" + b"\xff" * 99, OUT_OF_PLACE),
    ("avif.avif", lambda: b"\0\0\0\x18ftypavif\0\0\0\0mif1avif" + bytes(300), OUT_OF_PLACE),
    ("raw.dng", lambda: tiff((50706, 1, 4, 1), (256, 4, 1, 10)), "RAW"),
    ("raw.cr2", lambda: np.random.default_rng(3).bytes(300), "RAW"),
    *[(f"cut{cut}.png", lambda cut=cut: part(encoded("PNG"), cut / 100), OUT_OF_PLACE) for cut in (1, 20, 60, 98)],
    ("checksum.png", lambda: with_bytes(encoded("PNG"), 500, b"\0\0\0\0\0\0"), OUT_OF_PLACE),
    ("lie.png", lambda: png(65500, 65500), OUT_OF_PLACE),
    ("lie2g.png", lambda: png(2**31 - 1, 2**31 - 1, 16), OUT_OF_PLACE),
    ("bomb.png", lambda: png(20000, 20000, data=bytes(20000)), OUT_OF_PLACE),
    ("zero_size.png", lambda: png(0, 0), OUT_OF_PLACE),
    ("no_data.png", lambda: png(200, 200), OUT_OF_PLACE),
    ("depth3.png", lambda: png(200, 200, 3), OUT_OF_PLACE),
    ("chunk_beyond.png", lambda: png(200, 200, more=b"\xff\xff\xff\xffiCCP"), OUT_OF_PLACE),
    ("grey.png", lambda: encoded("PNG", mode="L"), ""),
    ("transparent.png", lambda: encoded("PNG", mode="RGBA"), ""),
    ("palette.png", lambda: encoded("PNG", mode="P"), ""),
    ("bits.png", lambda: encoded("PNG", mode="1"), ""),
    *[(f"cut{cut}.webp", lambda cut=cut: part(encoded("WEBP"), cut / 100), OUT_OF_PLACE) for cut in (5, 50, 95)],
    *[(f"cut{cut}.tif", lambda cut=cut: part(encoded("TIFF"), cut / 100), OUT_OF_PLACE) for cut in (1, 50, 95)],
    ("to_itself.tif", lambda: tiff(*usual(160, 120), then=8, then_data=bytes([9]) * 30000), ""),
    ("exif_to_itself.tif", lambda: tiff(*usual(160, 120), (34665, 4, 1, 8), then_data=bytes([8]) * 30000), ""),
    ("huge.tif", lambda: tiff(*usual(2**31 - 1, 2**31 - 1)), OUT_OF_PLACE),
    ("wide.tif", lambda: tiff(*usual(60000, 60000)), OUT_OF_PLACE),
    ("strip_beyond.tif", lambda: tiff(*usual(160, 120, at=2**32 - 16, size=2**32 - 1)), OUT_OF_PLACE),
    ("strips.tif", lambda: tiff(*usual(160, 120)[:5], (273, 4, 2**32 - 1, 8), (279, 4, 2**32 - 1, 8)), OUT_OF_PLACE),
    ("no_entries.tif", lambda: tiff(), OUT_OF_PLACE),
    ("count.tif", lambda: b"II*\0\x08\0\0\0\xff\xff" + bytes(99), OUT_OF_PLACE),
    ("offset.tif", lambda: b"II*\0\xff\xff\xff\xff" + bytes(99), OUT_OF_PLACE),
    ("big.tif", lambda: b"II+\0\x08\0\0\0" + struct.pack("<QQ", 16, 2**60) + bytes(99), OUT_OF_PLACE),
    ("exif_to_itself.jpg", lambda: with_exif(*[(0x8769, 4, 1, 8)] * 500), ""),
    ("exif_next.jpg", lambda: with_exif((0x10F, 2, 4, 0), then=8), ""),
    ("exif_count.jpg", lambda: with_exif((0x10F, 2, 2**32 - 1, 8), (0x110, 12, 2**32 - 1, 8)), ""),
    ("exif_beyond.jpg", lambda: with_exif((0x10F, 2, 100, 2**32 - 1)), ""),
    ("exif_focal0.jpg", lambda: with_exif((0x920A, 5, 1, 40), (0xA405, 3, 1, 0)), ""),
    ("exif_focal.jpg", lambda: with_exif((0x8769, 4, 1, 8), (0xA405, 3, 1, 65535)), ""),
    ("exif_type.jpg", lambda: with_exif((0x112, 99, 1, 3), (0x10F, 0, 0, 0)), ""),
    ("exif_turn.jpg", lambda: with_exif((0x112, 3, 1, 999)), ""),
    ("exif_mirrored.jpg", lambda: with_exif((0x112, 3, 1, 2)), "mirrored"),
]


def encoded_small(kind: str) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (60, 40)).save(file, kind)
    return file.getvalue()


@pytest.mark.parametrize(("name", "content", "words"), FILES, ids=[name for name, *_ in FILES])
def test_a_file_among_photos(
    ends: Callable[..., tuple[int, str]],
    good: Path,
    tmp_path: Path,
    name: str,
    content: Callable[[], bytes],
    words: str,
) -> None:
    (tmp_path / name).write_bytes(content())
    code, said = ends(good, tmp_path / name, "-o", tmp_path / "out")
    assert code == 5
    assert said.endswith(f"error: {USED}\n")
    assert words in said
    assert (name in said) == bool(words)


HIT = "\x1b[31mred\n\u202e"
DEEP = "[" * 100000
LONG_NUMBER = "1" + "0" * 400
LONGER_NUMBER = "9" * 5000
# The content of a settings file, and words of the sentence about it.
SETTINGS = [
    ("", "not valid JSON"),
    ("\0", "not valid JSON"),
    ("\ufeff{}", "not valid JSON"),
    (DEEP, "nests too deep"),
    ('{"sfm":' * 100000, "nests too deep"),
    ("null", "must be an object"),
    ("3", "must be an object"),
    ('"text"', "must be an object"),
    ("[{}]", "must be an object"),
    ("NaN", "must be an object"),
    ('{"settings": 3}', "must be an object"),
    ('{"settings": {"settings": {}}}', "There is no setting settings"),
    ('{"sfm": []}', "sfm must be an object"),
    ('{"sfm": null}', "sfm must be an object"),
    (f'{{"sfm": {{"seed": {LONG_NUMBER}}}}}', "whole number"),
    (f'{{"sfm": {{"seed": {LONGER_NUMBER}}}}}', "not valid JSON"),
    (f'{{"sfm": {{"seed": -{LONG_NUMBER}}}}}', "whole number"),
    ('{"sfm": {"seed": 1e400}}', "whole number"),
    ('{"sfm": {"seed": NaN}}', "whole number"),
    ('{"sfm": {"seed": -Infinity}}', "whole number"),
    ('{"sfm": {"seed": true}}', "whole number"),
    ('{"sfm": {"seed": "1"}}', "whole number"),
    ('{"sfm": {"seed": 1.5}}', "whole number"),
    ('{"sfm": {"seed": null}}', "whole number"),
    ('{"sfm": {"seed": -1}}', "must lie between"),
    ('{"sfm": {"threads": 1e9}}', "must lie between"),
    ('{"sfm": {"threads": 0}}', "must lie between"),
    (f'{{"surface": {{"smoothness": {LONG_NUMBER}}}}}', "must be a number"),
    ('{"surface": {"smoothness": NaN}}', "must be a number"),
    ('{"surface": {"smoothness": -1}}', "must lie between"),
    ('{"surface": {"method": 3}}', "must be one of"),
    ('{"surface": {"method": ["developable"]}}', "must be one of"),
    ('{"surface": {"method": {}}}', "must be one of"),
    ('{"surface": {"method": null}}', "must be one of"),
    ('{"page": {"paper_size_mm": 5}}', "must be a list"),
    ('{"page": {"paper_size_mm": [1e400, 2]}}', "must be a number"),
    (f'{{"page": {{"paper_size_mm": [{LONG_NUMBER}, 2]}}}}', "must be a number"),
    ('{"page": {"paper_size_mm": [-1, 2]}}', "paper"),
    ('{"page": {"paper_size_mm": [0, 0]}}', "paper"),
    ('{"sheet": 0}', "sheet"),
    ('{"sheet": "none"}', "sheet"),
    ('{"sheet": 1e30}', "sheet"),
    ('{"outline": 3}', "must be a list"),
    ('{"outline": [3]}', "must be a list"),
    ('{"reference": "a", "outline": [[NaN, 0], [1, 0], [1, 1]]}', "must be a number"),
    (f'{{"reference": "a", "outline": [[{LONG_NUMBER}, 0], [1, 0], [1, 1]]}}', "must be a number"),
    ('{"reference": "a", "outline": [[1e308, 0], [-1e308, 0], [0, 1e308]]}', "would leave any photo"),
    ('{"colmap_model": "a\\u0000b"}', "must be a text"),
    ('{"reference": "a\\u0000b"}', "must be a text"),
    ('{"reference": "\\ud800"}', "choose one of"),
    ('{"reference": ""}', "choose one of"),
    (json.dumps({"reference": HIT}), r"\\x1b\[31mred\\n\\u202e"),
    (json.dumps({HIT: 1}), r"\\x1b\[31mred\\n\\u202e"),
    (json.dumps({"x" * 100000: 1}), "There is no setting"),
    (json.dumps({"colmap_model": "x" * 5000}), "holds no COLMAP model|File name too long"),
]


@pytest.mark.parametrize(("content", "words"), SETTINGS, ids=range(len(SETTINGS)))
def test_a_settings_file(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, content: str, words: str
) -> None:
    (tmp_path / "settings.json").write_text(content, encoding="utf-8")
    code, said = ends(good, "-o", tmp_path / "out", "--settings", tmp_path / "settings.json")
    assert code == 2 or ("COLMAP" in said and code == 4), said
    assert re.search(words, said), said
    assert len(said) < 6000
    assert "\x1b" not in said


DRAWN = [
    ("", "not valid JSON"),
    (DEEP, "nests too deep"),
    ("{}", "must hold a list"),
    ("null", "|"),
    ("3", "must be a list"),
    ('"x"', "must be a list"),
    ("[]", "three corners|"),
    ("[[0, 0]]", "corners|must have 4"),
    ('[["a", "b"], [1, 2], [3, 4]]', "must be a number|must have 4"),
    ("[[0, 0, 0], [1, 1, 1], [2, 0, 0]]", "must have"),
    ("[[NaN, 0, 1, 1], [9, 0, 1, 1]]", "must be a number|must have 2"),
    (f"[[{LONG_NUMBER}, 0, 0, 0]]", "must be a number|must have 2"),
    ('{"reference": "\\u0000", "outline": [], "creases": []}', "belongs to the photo"),
    ('{"reference": 3, "outline": [], "creases": []}', "must hold a list"),
    ("[[0, 0], [1e300, 0], [0, 1e300]]", "would leave any photo|must have 4"),
    ("[[-5, 0], [50, 0], [0, 50]]", "leaves the photo|must have 4"),
    ("[[5, 5], [50, 5], [5, 5], [50, 50]]", "crosses or touches|must have 4"),
    ("[[1, 1, 1, 1]]", "has no length|must have 2"),
    ("[[1, 1, 1e9, 1]]", "would leave any photo|must have 2"),
]


@pytest.mark.parametrize("option", ["--outline", "--creases"])
@pytest.mark.parametrize(("content", "words"), DRAWN, ids=range(len(DRAWN)))
def test_an_outline_or_creases(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, content: str, words: str, option: str
) -> None:
    (tmp_path / "drawn.json").write_text(content, encoding="utf-8")
    code, said = ends(good, "-o", tmp_path / "out", "--reference", "1.png", option, tmp_path / "drawn.json")
    assert code == 2 or (USED in said and code == 5)
    assert code == 5 or re.search(words, said), said


OPTIONS = [
    (["--dpi", "1e400"], "dpi"),
    (["--dpi", "nan", "--paper", "A4"], "dpi"),
    (["--dpi", "-5", "--paper", "A4"], "dpi"),
    (["--dpi", "0", "--paper", "A4"], "dpi"),
    (["--dpi", "1" + 400 * "0", "--paper", "A4"], "dpi"),
    (["--dpi", 5000 * "9", "--paper", "A4"], "dpi"),
    (["--dpi", "300"], "paper"),
    (["--dpi", ""], "dpi"),
    (["--threads", "0"], "threads"),
    (["--threads", "1.5"], "threads"),
    (["--threads", 5000 * "9"], "threads"),
    (["--seed", "-1"], "seed"),
    (["--seed", "x"], "seed"),
    (["--paper", "0x0"], "paper|mm"),
    (["--paper", "1e9x1e9"], "WIDTHxHEIGHT"),
    (["--paper", "9" * 400], "paper|mm"),
    (["--paper", "nan"], "WIDTHxHEIGHT"),
    (["--paper", "\n"], "WIDTHxHEIGHT"),
    (["--paper", HIT], "WIDTHxHEIGHT"),
    (["--sheet", "0"], "sheet"),
    (["--sheet", "-1"], "sheet"),
    (["--sheet", "x"], "sheet"),
    (["--surface", "magic"], "surface"),
    (["--grid", "x"], "unrecognized|grid"),
    (["--reference", "nowhere.jpg"], "choose one of"),
    (["--reference", HIT], r"\\x1b\[31mred"),
    (["--reference", "."], "choose one of"),
    (["--reference", "/"], "choose one of|say which"),
    (["--colmap-model", "nowhere"], "holds no COLMAP model"),
    (["--outline", "nowhere.json"], "check the path"),
    (["--creases", "."], "directory"),
    (["--settings", "nowhere.json"], "check the path"),
    (["--settings", os.devnull], "not a file"),
    (["--settings", "."], "directory"),
    (["--settings", "x" * 300], "too long|check the path"),
    (["--outline", os.devnull], "not a file"),
    (["--texture-from", "nowhere"], "nowhere"),
    (["--texture-from", os.devnull], "not a"),
    (["--resume", "--force"], "not allowed"),
    (["--nothing"], "unrecognized"),
    (["-o", ""], "No folder for the results"),
]


@pytest.mark.parametrize(("options", "words"), OPTIONS, ids=range(len(OPTIONS)))
def test_options(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, options: list[str], words: str
) -> None:
    code, said = ends(good, "-o", tmp_path / "out", *options)
    assert code == (4 if "--colmap-model" in options else 2)
    assert re.search(words, said), said
    assert "\x1b" not in said


def pipe(path: Path) -> None:
    os.mkfifo(path)


def file(path: Path) -> None:
    path.write_text("theirs")


def folder(path: Path) -> None:
    path.mkdir()


def circle(path: Path) -> None:
    path.symlink_to(path.name)


def dangling(path: Path) -> None:
    path.symlink_to("nowhere at all")


def zeros(path: Path) -> None:
    path.symlink_to("/dev/zero")


POSIX = pytest.mark.skipif(sys.platform == "win32", reason="pipes and links of POSIX")


@POSIX
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: None, "check the path"),
        (folder, "no photos"),
        (file, "are needed"),
        (pipe, "a pipe or a device"),
        (circle, "check the path"),
        (dangling, "check the path"),
        (zeros, "a pipe or a device"),
        (lambda path: [folder(path), pipe(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), zeros(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), circle(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), folder(path / "1.jpg")], "no photos"),
        (lambda path: [folder(path), file(path / "\n.jpg")], r"are needed.*\\n.jpg"),
        (lambda path: [folder(path), file(path / "\x1b[2J.jpg")], r"are needed.*\\x1b\[2J.jpg"),
        (lambda path: [folder(path), file(path / os.fsdecode(b"\xff\xfe.jpg"))], "are needed.*is not text"),
    ],
)
def test_the_place_of_the_photos(
    ends: Callable[..., tuple[int, str]], tmp_path: Path, make: Callable[[Path], object], words: str
) -> None:
    make(tmp_path / "photos")
    code, said = ends(tmp_path / "photos", "-o", tmp_path / "out")
    assert code in (2, 4)
    assert re.search(words, said), said


@POSIX
@pytest.mark.parametrize("name", ["x" * 300, "x" * 5000, os.fsdecode(b"\xff"), "\n", "a\x1b[31m", "∆ελτα"])
def test_names_of_photos_and_results(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, name: str
) -> None:
    for arguments in ([tmp_path / name, "-o", tmp_path / "out"], [good, "-o", tmp_path / name]):
        code, said = ends(*arguments)
        assert code in (2, 5)
        assert code == 2 or USED in said


def states(folder: Path) -> dict[str, tuple[int, ...]]:
    """What lies in a folder."""
    there = {path.name: path.lstat() for path in folder.iterdir()}
    return {name: (state.st_mode, state.st_ino, state.st_size, state.st_mtime_ns) for name, state in there.items()}


RESULTS = ["page.tif", "page.jpg", "document.blend", "report.json", "log.txt", "sheet.obj", "map.npz", "outline.json"]
KINDS = [file, folder, pipe, circle, dangling, zeros]


@POSIX
@pytest.mark.parametrize("make", KINDS)
@pytest.mark.parametrize("name", [*RESULTS, ".origami", ".origami-lock", "work", "cameras"])
def test_something_in_the_place_of_a_result(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, name: str, make: Callable[[Path], object]
) -> None:
    """In a folder that nobody marked, and in one whose marker was copied from elsewhere."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    mark(elsewhere, [*RESULTS, "work", "cameras"])
    for copied in (False, True):
        out = tmp_path / f"out {copied}"
        out.mkdir()
        if copied and name != ".origami":
            (out / ".origami").write_bytes((elsewhere / ".origami").read_bytes())
        make(out / name)
        before = states(out)
        for flag in ("-q", "--force", "--resume"):
            code, said = ends(good, "-o", out, flag)
            assert code == 2
            assert name in said
            assert states(out) == before


@POSIX
@pytest.mark.parametrize("make", KINDS)
@pytest.mark.parametrize("name", ["page.tif", "log.txt", "cameras", "work", "report.json"])
def test_something_in_the_place_of_a_result_that_a_run_has_made(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, name: str, make: Callable[[Path], object]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    mark(out, [*RESULTS, "work", "cameras"])
    make(out / name)
    code, said = ends(good, "-o", out, "--force")
    allowed = (make is folder) == (name in ("cameras", "work")) and make in (file, folder)
    assert code == (5 if allowed else 2)
    assert (USED if allowed else name) in said


@POSIX
@pytest.mark.parametrize("make", [file, pipe, circle, dangling, zeros])
def test_something_in_the_place_of_the_folder(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, make: Callable[[Path], object]
) -> None:
    make(tmp_path / "out")
    for out in (tmp_path / "out", tmp_path / "out" / "below"):
        code, said = ends(good, "-o", out)
        assert code == 2
        assert "choose another folder" in said or "check the path" in said
