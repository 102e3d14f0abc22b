"""The marker file of a folder of results: which files Origami has written there, and for which document.

A run of the command line names no document. Everything that the marker does not list belongs to the user.

A marker may have been copied here from elsewhere, so it proves nothing alone: it has a random number, and what a run of
the command line wrote is Origami's only where the run's report, its work folder, its lock, or the marker of the folder
above has the same number.
"""

from __future__ import annotations

import json
import os
import stat
import uuid
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ...core.errors import UsageError
from .atomic import write_text_at_once
from .json_files import parsed_json
from .links import is_link

MARKER = ".origami"
# The files beside a marker that have its number too.
REPORT, LOCK, NUMBER = "report.json", ".origami-lock", "work/number.json"
_APPLICATION, _VERSION = "Origami", 1
# Enough for a few dozen names; a larger file cannot be a marker and is not read.
_LARGEST_MARKER = 1 << 20  # bytes
# Until November 2026 the whole marker was this text, followed by the document's name if there was one.
_FORMER_TEXT = "Origami writes its results into this folder; a later run may replace them.\n"
_FORMER_DOCUMENT = "Document: "


def claim(out: Path, names: Iterable[str], document: str = "") -> None:
    """Note these files in the folder's marker before Origami writes them there.

    Parameters
    ----------
    out : Path
    names : iterable of str
    document : str
        The document that owns these files; "" for the command line.

    Raises
    ------
    UsageError
        If something other than a marker has its name.
    OSError
    """
    files = (owners(out, _others_than_marker(out)) or {}) | dict.fromkeys(names, document)
    _write_marker(out, files, number_of(out) or new_number())


def release(out: Path, names: Iterable[str]) -> None:
    """Remove names that Origami no longer owns from a folder's marker; an empty marker is deleted.

    Raises
    ------
    UsageError
        If something other than a marker has its name.
    OSError
    """
    given_up = set(names)
    files = owners(out, _others_than_marker(out))
    if files is None:
        return
    rest = {name: document for name, document in files.items() if name not in given_up or os.path.lexists(out / name)}
    if rest:
        _write_marker(out, rest, number_of(out) or new_number())
    else:
        (out / MARKER).unlink()


def new_number() -> str:
    """A random number for a folder of results."""
    return uuid.uuid4().hex


def number_of(out: Path) -> str:
    """The number of a folder, which its marker and another of its files have, or that other file alone; "" if none."""
    numbers = _proofs(out)
    marked = (_parsed_marker(out) or {}).get("number", "")
    return marked if marked in numbers else next(iter(numbers), "")


def is_marked_with(out: Path, number: str) -> bool | None:
    """Whether a folder's marker has this number; None if it has no marker, or one from before November 2026."""
    marked = (_parsed_marker(out) or {}).get("number", "")
    return marked == number if marked else None


def _others_than_marker(out: Path) -> list[str]:
    return [path.name for path in out.iterdir() if path.name != MARKER]


def _write_marker(out: Path, files: dict[str, str], number: str) -> None:
    content = {"application": _APPLICATION, "version": _VERSION, "number": number, "files": files}
    write_text_at_once(out / MARKER, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def owners(out: Path, names: Iterable[str]) -> dict[str, str] | None:
    """What Origami has written into a folder.

    Parameters
    ----------
    out : Path
    names : iterable of str
        All possible names; a marker from before November 2026 lists nothing and stands for all of them.

    Returns
    -------
    dict or None
        For each name the document that owns the file, "" for the command line; None if the folder has no marker.

    Raises
    ------
    UsageError
        If something other than a marker has its name.
    """
    marker = _parsed_marker(out)
    if marker is None:
        return None
    if "document" in marker:
        return dict.fromkeys(names, marker["document"])
    files = dict(marker["files"])
    number = marker.get("number", "")
    if not number or number in _proofs(out):
        return files
    return {name: document for name, document in files.items() if document}


def _parsed_marker(out: Path) -> dict[str, Any] | None:
    """The content of a folder's marker; None if it has none.

    Raises
    ------
    UsageError
        If something other than a marker has its name.
    """
    text = _text_of_marker(out / MARKER)
    if text is None:
        return None
    if text == _FORMER_TEXT or text.startswith(_FORMER_TEXT + _FORMER_DOCUMENT):
        return {"document": text.removeprefix(_FORMER_TEXT).removeprefix(_FORMER_DOCUMENT).strip()}
    try:
        content = json.loads(text)
        if content["application"] == _APPLICATION and content["version"] == _VERSION:
            files = {str(name): str(document) for name, document in content["files"].items()}
            return {"number": str(content.get("number", "")), "files": files}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    raise UsageError(foreign(out, MARKER))


def _proofs(out: Path) -> list[str]:
    """The numbers that prove a marker of the command line, from its other files."""
    found = [_number_in(out / name) for name in (REPORT, LOCK, NUMBER)]
    found.append(_number_in(out.parent / MARKER))
    return [number for number in found if number]


def _number_in(path: Path) -> str:
    try:
        number = "" if is_link(path) else parsed_json(path)["number"]
    except (OSError, ValueError, KeyError, TypeError):
        return ""
    return number if isinstance(number, str) else ""


def _text_of_marker(path: Path) -> str | None:
    """The content of a marker, "" for anything that cannot be one; None if it does not exist."""
    try:
        status = path.lstat()
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(status.st_mode) or status.st_size > _LARGEST_MARKER:
        return ""
    return path.read_text(encoding="utf-8", errors="replace")


def foreign(out: Path, name: str) -> str:
    """The error message for a file of the user's in the place of one of Origami's."""
    return (
        f"{out} holds {name}, which Origami did not write there and would replace; choose another folder for the "
        "results."
    )
