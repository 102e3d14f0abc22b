"""Text recognition: OCRmyPDF with Tesseract."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from ...core.errors import StepFailed, UsageError

_PLUGIN = Path(__file__).with_name("keep_hocr.py")
_WHERE = "ORIGAMI_HOCR"  # as the plugin has it, which only OCRmyPDF can load
_LANGUAGE = re.compile(r"[A-Za-z][A-Za-z0-9_/]*")


def check_languages(languages: str) -> None:
    """Check that Tesseract is there and has data for languages, such as ``deu+eng``.

    Raises
    ------
    UsageError
    """
    wanted = languages.split("+")
    if not all(_LANGUAGE.fullmatch(each) for each in wanted):
        raise UsageError(
            f"{languages!r} names no languages; write Tesseract's short names with + between them, such as deu+eng."
        )
    try:
        listed = _output_of(["tesseract", "--list-langs"])
    except FileNotFoundError:
        raise UsageError(
            "Tesseract, which recognizes the text, is not installed; install it: apt-get install tesseract-ocr"
        ) from None
    known = set(listed.split("\n")[1:])
    missing = [each for each in wanted if each not in known]
    if missing:
        packages = " ".join(f"tesseract-ocr-{each.lower().replace('_', '-')}" for each in missing)
        raise UsageError(
            f"Tesseract has no data for {' and '.join(missing)}; install it (apt-get install {packages}), or choose "
            f"among {', '.join(sorted(known - {'', 'osd'}))}."
        )


def version_of_tesseract() -> str:
    """Its name and version."""
    return _output_of(["tesseract", "--version"]).split("\n", 1)[0]


def _output_of(command: Sequence[str]) -> str:
    """What a program prints; Tesseract before version 5 printed on stderr."""
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False).stdout


def recognize(pdf: Path, languages: str, to: Path, hocr: Path, text: Path) -> None:
    """Make a PDF/A-2 with a text layer of a PDF that is one picture. The picture stays as it is.

    Parameters
    ----------
    pdf : Path
    languages : str
        Checked by `check_languages`.
    to, hocr, text : Path
        The files to write: the PDF/A, the words with their boxes, and the plain text.

    Raises
    ------
    UsageError
        If OCRmyPDF is not installed.
    StepFailed
        If it fails, or says that the file is no PDF/A.
    """
    if importlib.util.find_spec("ocrmypdf") is None:
        raise UsageError(
            f"OCRmyPDF, which makes the text layer, is not installed; install it: {sys.executable} -m pip install "
            "-r .ci/requirements-text.txt"
        )
    command = [sys.executable, "-m", "ocrmypdf", "--quiet", "--plugin", str(_PLUGIN)]
    command += ["--language", languages, "--output-type", "pdfa-2", "--optimize", "0", "--jobs", "1"]
    command += ["--sidecar", str(text), str(pdf), str(to)]
    done = subprocess.run(
        command, env=os.environ | {_WHERE: str(hocr)}, capture_output=True, text=True, errors="replace", check=False
    )
    # OCRmyPDF also ends with an error if what it wrote does not say that it is a PDF/A.
    if done.returncode != 0 or not hocr.is_file():
        said = " ".join(done.stderr.split()) or f"it ended with code {done.returncode}"
        raise StepFailed(f"OCRmyPDF could not make the text layer of {pdf}: {said[-600:]}")
