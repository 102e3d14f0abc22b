"""The text layer: words that are found in the PDF, files for other programs, and failures that say what to do."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from origami.core.errors import StepFailed, UsageError
from origami.workflow.delivery import recognition
from origami.workflow.delivery.text import main

SCRIPT = Path("workflow/scripts/text.py")


@pytest.fixture
def without_tesseract(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))


@pytest.fixture
def listing_languages(monkeypatch, tmp_path):
    """A Tesseract that has English and Latin."""
    program = tmp_path / "bin" / "tesseract"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\nprintf 'List of available languages (3):\\neng\\nlat\\nosd\\n'\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")


def test_languages_are_checked_before_anything_is_made(listing_languages):
    recognition.check_languages("lat+eng")
    with pytest.raises(
        UsageError, match=r"no data for deu and chi_sim; install it \(apt-get install tesseract-ocr-deu "
    ):
        recognition.check_languages("deu+eng+chi_sim")
    with pytest.raises(UsageError, match=r"tesseract-ocr-chi-sim\), or choose among eng, lat\."):
        recognition.check_languages("chi_sim")
    for wrong in ("", "+", "eng,deu", "--psm", "eng+"):
        with pytest.raises(UsageError, match="names no languages"):
            recognition.check_languages(wrong)


def test_without_tesseract_the_command_says_so_and_writes_nothing(run_folder, without_tesseract, capsys):
    assert main([str(run_folder)]) == UsageError.exit_code
    assert "Tesseract, which recognizes the text, is not installed" in capsys.readouterr().err
    assert not (run_folder / "text").exists()


def test_an_unfinished_run_is_no_document(tmp_path, capsys):
    assert main([str(tmp_path)]) == UsageError.exit_code
    assert "no run has finished there" in capsys.readouterr().err
    assert main([]) == 2
    assert main(["--help"]) == 0


def test_what_ocrmypdf_says_is_in_the_failure(tmp_path, monkeypatch):
    (tmp_path / "ocrmypdf.py").write_text("import sys\nsys.exit('The file is \\n encrypted.')\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    files = [tmp_path / name for name in ("a.pdf", "a.hocr", "a.txt")]
    with pytest.raises(StepFailed, match=r"text layer of \S*page\.pdf: The file is encrypted\."):
        recognition.recognize(tmp_path / "page.pdf", "eng", *files)


def test_the_print_is_found_in_the_pdf_and_in_every_file(workflow_python, make_run, root):
    """On a name that needs care in a command line."""
    if shutil.which("tesseract") is None:
        pytest.skip("tesseract is not installed")
    folder = make_run("-Brief ü 'x' 1")
    done = subprocess.run(
        [workflow_python, str(root / SCRIPT), str(folder), "--languages", "eng"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    text = folder / "text"
    assert {path.name for path in text.iterdir() if not path.name.startswith(".")} == {
        *("page.pdf", "page.hocr", "page.txt", "page.xml", "figures.json", "delivered.json"),
        *("photo_01.xml", "photo_02.xml", "photo_03.xml"),
    }
    figures = json.loads((text / "figures.json").read_text(encoding="utf-8"))
    assert figures["words"] == 9
    assert [each["shown"] for each in figures["photos"][:2]] == [9, 9]
    assert 0 < figures["photos"][2]["shown"] < 9
    for name in ("page.txt", "page.xml", "page.hocr"):
        assert "Kestrel" in (text / name).read_text(encoding="utf-8")
    pdf = (text / "page.pdf").read_bytes()
    assert b"pdfaid" in pdf
    (part,) = {pdf[pdf.index(key) + len(key)] for key in (b"<pdfaid:part>", b'pdfaid:part="') if key in pdf}
    assert chr(part) == "2"
    # The picture itself is the one that Origami wrote.
    original = (folder / "page.pdf").read_bytes()
    jpeg = original[original.index(b"\xff\xd8") : original.rindex(b"\xff\xd9") + 2]
    assert jpeg in pdf
    if shutil.which("pdftotext"):
        found = subprocess.run(["pdftotext", str(text / "page.pdf"), "-"], capture_output=True, text=True, check=True)
        assert "Origami folds paper" in found.stdout
