"""Tiles and manifest for IIIF: every file that a viewer asks for is there."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
from origami.core.errors import UsageError
from origami.workflow.delivery import iiif_manifest
from origami.workflow.delivery.iiif_manifest import write_manifest
from PIL import Image

URL = "https://example.org/letters/iiif"


@pytest.fixture
def cut(workflow_python, root):
    """The command, and its exit code and sentence."""

    def cut(folder: Path, iiif: Path) -> tuple[int, str]:
        script = root / "workflow" / "scripts" / "iiif_tiles.py"
        words = [workflow_python, str(script), str(folder), str(iiif)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    return cut


def asked_for(info: dict) -> list[str]:
    """The pictures that a viewer may ask for, by the rules of the Image API 3."""
    width, height = info["width"], info["height"]
    found = ["full/max/0/default.jpg"]
    found += [f"full/{each['width']},{each['height']}/0/default.jpg" for each in info["sizes"]]
    (tiles,) = info["tiles"]
    for factor in tiles["scaleFactors"]:
        step = tiles["width"] * factor
        if max(width, height) <= step:
            continue
        for x in range(0, width, step):
            for y in range(0, height, step):
                w, h = min(step, width - x), min(step, height - y)
                size = f"{math.ceil(w / factor)},{math.ceil(h / factor)}"
                found.append(f"{x},{y},{w},{h}/{size}/0/default.jpg")
    return found


@pytest.mark.parametrize("scale", [1, 2.3, 0.4])
def test_a_viewer_finds_every_file(cut, make_run, tmp_path, printed, scale):
    folder, iiif = make_run("Brief #1 ü%"), tmp_path / "out" / "iiif"
    size = (round(640 * scale) + 1, round(800 * scale))
    Image.fromarray(printed).resize(size).save(folder / "page.tif")
    assert cut(folder, iiif) == (0, "")
    write_manifest(iiif, URL + "/")
    manifest = json.loads((iiif / "manifest.json").read_text(encoding="utf-8"))
    (canvas,) = manifest["items"]
    assert (canvas["width"], canvas["height"]) == size
    assert canvas["label"] == {"none": ["Brief #1 ü%"]}
    address = canvas["items"][0]["items"][0]["body"]["service"][0]["id"]
    assert address == f"{URL}/Brief%20%231%20%C3%BC%25"
    place = iiif.parent / unquote(urlsplit(address).path).removeprefix("/letters/")
    info = json.loads((place / "info.json").read_text(encoding="utf-8"))
    assert info["id"] == address
    for name in asked_for(info):
        wanted = name.split("/")[1]
        with Image.open(place / name) as picture:
            assert wanted == "max" or picture.size == tuple(int(length) for length in wanted.split(","))
    for picture in (canvas["thumbnail"][0], canvas["items"][0]["items"][0]["body"]):
        assert (place / picture["id"].removeprefix(f"{address}/")).is_file()
    with Image.open(place / "full/max/0/default.jpg") as whole, Image.open(folder / "page.tif") as page:
        assert np.abs(np.asarray(whole, int) - np.asarray(page, int)).mean() < 3


def test_only_a_new_page_is_cut_again(cut, make_run, tmp_path):
    folder, iiif = make_run("a"), tmp_path / "out" / "iiif"
    cut(folder, iiif)
    tile = iiif / "a" / "full" / "max" / "0" / "default.jpg"
    (iiif / "a" / "stale").mkdir()
    before = tile.stat().st_mtime_ns
    assert cut(folder, iiif) == (0, "")
    assert tile.stat().st_mtime_ns == before
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    report["outputs"]["page.tif"]["sha256"] = "another"
    (folder / "report.json").write_text(json.dumps(report))
    assert cut(folder, iiif) == (0, "")
    assert tile.stat().st_mtime_ns != before
    assert not (iiif / "a" / "stale").exists()
    assert {path.name for path in iiif.iterdir()} == {"a"}


def test_a_folder_of_the_users_is_kept(cut, make_run, tmp_path):
    folder, iiif = make_run("a"), tmp_path / "out" / "iiif"
    (iiif / "a").mkdir(parents=True)
    (iiif / "a" / "mine.txt").write_text("mine")
    code, said = cut(folder, iiif)
    assert code == UsageError.exit_code
    assert "did not write there" in said
    assert [path.name for path in (iiif / "a").iterdir()] == ["mine.txt"]
    (iiif / "a" / "mine.txt").unlink()  # an empty folder, as Snakemake makes
    assert cut(folder, iiif) == (0, "")


def test_another_document_of_the_same_name_is_not_replaced(cut, make_run, tmp_path):
    iiif = tmp_path / "iiif"
    assert cut(make_run("first/letter"), iiif) == (0, "")
    code, said = cut(make_run("second/letter"), iiif)
    assert code == UsageError.exit_code
    assert "holds the tiles of another document" in said
    assert (iiif / json.loads((iiif / "letter" / "tiles.json").read_text())["document"]).name == "letter"


@pytest.fixture
def tiles(tmp_path):
    """A folder of tiles as `iiif_tiles` leaves it, without the pictures."""
    page = {"of_page": "x", "title": "a", "width": 400, "height": 500, "factors": [1], "sizes": [[400, 500]]}
    (tmp_path / "iiif" / "a").mkdir(parents=True)
    (tmp_path / "iiif" / "a" / "tiles.json").write_text(json.dumps(page))
    return tmp_path / "iiif"


def test_the_address_can_change(tiles):
    for address in ("http://localhost:8000", "https://example.org/x"):
        write_manifest(tiles, address)
        assert json.loads((tiles / "manifest.json").read_text())["id"] == f"{address}/manifest.json"
        assert json.loads((tiles / "a" / "info.json").read_text())["id"] == f"{address}/a"


@pytest.mark.parametrize(
    "address", ["", "example.org", "file:///a", "https://", "https://a/b?c=d", "https://a/#b", "https://a/b c"]
)
def test_what_is_no_address_is_refused(tiles, address, capsys):
    assert iiif_manifest.main([str(tiles), f"--url={address}"]) == UsageError.exit_code
    assert "is not the address of a folder" in capsys.readouterr().err
    assert not (tiles / "manifest.json").exists()


def test_a_manifest_of_the_users_is_kept_and_an_empty_folder_is_none(tiles, tmp_path):
    (tiles / "manifest.json").write_text("mine")
    with pytest.raises(UsageError, match="did not write there"):
        write_manifest(tiles, URL)
    with pytest.raises(UsageError, match="holds no page in tiles"):
        write_manifest(tmp_path / "missing", URL)
