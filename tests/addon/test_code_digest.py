"""Results kept under `work/` are recomputed after a change in the code on which they depend."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from origami.origami_addon.steps.work import _COMPUTING, code_digest


@pytest.fixture(scope="module")
def copy(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("code")
    for name in ("core", "origami_addon"):
        shutil.copytree(root / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def test_every_file_of_the_core_counts(copy: Path) -> None:
    files = sorted((copy / "core").rglob("*.py"))
    assert copy / "core" / "paper" / "outline.py" in files
    seen = {code_digest(copy)}
    for file in files:
        file.write_text(file.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
        digest = code_digest(copy)
        assert digest not in seen, file
        seen.add(digest)


@pytest.mark.parametrize("name", ["steps/find.py", "files/photos.py", "files/decoded_photo.py"])
def test_what_computes_or_reads_beside_it_counts_too(copy: Path, name: str) -> None:
    before = code_digest(copy)
    file = copy / "origami_addon" / name
    file.write_text(file.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    assert code_digest(copy) != before


def test_what_computes_beside_it_is_there(root: Path) -> None:
    assert not [name for name in _COMPUTING if not list((root / "origami_addon").glob(name))]


def test_what_only_shows_results_does_not_count(copy: Path) -> None:
    before = code_digest(copy)
    panels = copy / "origami_addon" / "window" / "panels.py"
    panels.write_text("# changed\n", encoding="utf-8")
    assert code_digest(copy) == before
