"""The command `text`: a PDF/A with a text layer, and the words on the page and in each photo."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from .command import exit_code_of
from .delivered import delivering
from .finished_run import FinishedRun, finished_run
from .hocr import read_hocr, words_of
from .on_photos import write_words_in_photos
from .page_in_photos import page_in_photos
from .page_xml import write_page_xml
from .recognition import check_languages, recognize, version_of_tesseract

FOLDER = "text"
# The first is put in place last: with it, all are there.
PDF, HOCR, PLAIN, PAGE, FIGURES = "page.pdf", "page.hocr", "page.txt", "page.xml", "figures.json"


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code; never raises."""
    return exit_code_of(lambda: _text(argv))


def _text(argv: Sequence[str]) -> None:
    parser = argparse.ArgumentParser(
        prog="text.py",
        description="Recognize the text of a finished page: DOCUMENT/text/page.pdf is then a PDF/A-2 that can be "
        "searched, and beside it are the words with their places on the page and in each photo.",
        allow_abbrev=False,
    )
    parser.add_argument("document", metavar="DOCUMENT", type=Path, help="the folder of a finished run of rectify.py")
    parser.add_argument(
        "--languages",
        metavar="NAMES",
        default="eng",
        help="the languages of the text, by Tesseract's names with + between them, such as deu+eng (eng)",
    )
    arguments = parser.parse_args(argv)
    write_text(finished_run(arguments.document), arguments.languages)


def write_text(run: FinishedRun, languages: str) -> None:
    """Write the folder ``text`` of a document.

    Raises
    ------
    UsageError, StepFailed
    """
    pdf, page = run.file("page.pdf"), page_in_photos(run)
    check_languages(languages)
    with delivering(run.folder / FOLDER, PDF) as new:
        recognize(pdf, languages, new / PDF, new / HOCR, new / PLAIN)
        blocks = read_hocr(new / HOCR, page.size_px)
        write_page_xml(new / PAGE, blocks, f"../{run.file('page.tif').name}", page.size_px)
        in_photos = write_words_in_photos(new, page, blocks)
        words = words_of(blocks)
        figures = {
            "of_page": run.hash_of("page.pdf"),
            "languages": languages,
            "program": version_of_tesseract(),
            "words": len(words),
            "confidence": round(sum(word.confidence for word in words) / len(words), 3) if words else None,
            "photos": [asdict(each) for each in in_photos],
        }
        (new / FIGURES).write_text(json.dumps(figures, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
