"""A batch of three small documents through Snakemake, one of them broken; `make test-batch` runs this."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

pytestmark = pytest.mark.batch
# The paper's edge in the example's first photo at 600 pixels, and methods that take no time.
EDGE = [[176, 83], [430, 106], [403, 263], [422, 398], [385, 533], [27, 493], [16, 357], [67, 226], [70, 75]]
QUICK = "--reference 00.jpg --outline edge.json --surface poisson_l2 --grid-rows 30 --unwrap lscm --turn 0"
LONGEST = 600  # pixels of a photo


@pytest.fixture(scope="module")
def photos(example_photos: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table, and the folders that it names: two good ones, and one with two photos."""
    folder = tmp_path_factory.mktemp("batch") / "photos"
    names = {"a letter": 5, "-Übung {1} $x": 5, "broken": 2}
    for name, number in names.items():
        (folder / name).mkdir(parents=True)
        for path in sorted(example_photos.iterdir())[:number]:
            with Image.open(path) as photo:
                photo.thumbnail((LONGEST, LONGEST))
                photo.save(folder / name / path.name, quality=92)
    (folder / "edge.json").write_text(json.dumps(EDGE))
    with (folder / "documents.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, delimiter=";")
        writer.writerows([["folder", "options"], *([name, QUICK] for name in names)])
    return folder


@pytest.fixture(scope="module")
def python(root: Path) -> Path:
    """The Python that has Snakemake."""
    path = root / ".venv-batch" / "bin" / "python"
    assert path.exists(), "make batch-environment makes it"
    return path


def run(root: Path, python: Path, photos: Path, *options: str) -> tuple[int, dict[str, dict[str, str]], dict[str, Any]]:
    """Run the batch; returns its exit code, the rows of the summary, and how often each rule ran."""
    out = photos.parent / "out"
    command = [str(python), str(root / "workflow" / "batch.py"), str(photos / "documents.csv"), str(out), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    with (out / "summary.csv").open(encoding="utf-8-sig", newline="") as file:
        rows = {row["document"]: row for row in csv.DictReader(file)}
    counted = [line.split() for line in done.stdout.splitlines() + done.stderr.splitlines()]
    rules = {words[0]: int(words[1]) for words in counted if len(words) == 2 and words[0] in ("place", "sheet", "page")}
    return done.returncode, rows, rules


def test_a_batch_goes_on_from_what_it_has(root: Path, python: Path, photos: Path) -> None:
    out = photos.parent / "out"
    good = ["a letter", "-Übung %7B1%7D $x"]

    code, rows, _ = run(root, python, photos)
    assert code == 1
    assert {name: row["state"] for name, row in rows.items()} == {**dict.fromkeys(good, "done"), "broken": "failed"}
    assert rows["broken"]["reason"].startswith("2 of 2 files can be used, but at least 3 photos are needed")
    page = "".join((out / "summary.html").read_text(encoding="utf-8").split())
    assert "2of2filescanbeused" in page
    assert all((out / name / "batch" / "outline.jpg").is_file() for name in good)
    pages = {name: (out / name / "page.tif").read_bytes() for name in good}
    # One thread, the same photos: the same page.
    assert pages[good[0]] == pages[good[1]]

    for path in (photos / "a letter").iterdir():
        shutil.copy(path, photos / "broken")
    code, rows, rules = run(root, python, photos)
    assert (code, rules) == (0, {"place": 1, "sheet": 1, "page": 1})
    assert {row["state"] for row in rows.values()} == {"done"}
    assert (out / "broken" / "page.tif").read_bytes() == pages[good[0]]

    code, rows, rules = run(root, python, photos, "--config", "paper=A4", "dpi=72")
    assert (code, rules) == (0, {"page": 3})
    assert {row["dpi"] for row in rows.values()} == {"72.0"}
