"""Folders for results, in which only Origami's own files are replaced.

A marker file lists what was written there and for which document; a run of the command line names no document.
Everything that it does not list belongs to the user. Links are not followed.

A marker may have been copied here from elsewhere, so it proves nothing alone: it has a random number, and what a run of
the command line wrote is Origami's only where the run's report, its work folder, its lock, or the marker of the folder
above has the same number.
"""

from __future__ import annotations

import json
import os
import shutil
import stat
import uuid
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ...core.errors import UsageError
from .atomic import write_text_at_once
from .json_files import parsed_json

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


def keep_off_others(
    out: Path, names: Iterable[str], document: str = "", known: Iterable[str] = (), folders: Iterable[str] = ()
) -> None:
    """Refuse to replace files that Origami does not own.

    A file with the name of a result belongs to the user unless the marker lists it, and to another document if the
    marker says so.

    Parameters
    ----------
    out : Path
    names : iterable of str
        All names that may be written into the folder.
    document : str
        The document that owns these files; "" for the command line.
    known : iterable of str
        Other files known to be of the command line.
    folders : iterable of str
        Those of the names that are folders.

    Raises
    ------
    UsageError
    """
    names, folders = list(names), set(folders)
    files = dict.fromkeys(known, "") | (owners(out, names) or {})
    for name in names:
        if not os.path.lexists(out / name):
            continue
        if name not in files:
            raise UsageError(foreign(out, name))
        if is_link(out / name):
            raise UsageError(_link(out / name))
        kind = (out / name).lstat().st_mode
        if not (stat.S_ISDIR(kind) if name in folders else stat.S_ISREG(kind)):
            raise UsageError(foreign(out, name))
        if files[name] not in ("", document):
            raise UsageError(
                f"{out} holds {name} of the document {files[name]}, which would be replaced; "
                "choose another folder for the results."
            )


def keep_off_links(folder: Path) -> None:
    """Refuse links in a folder of Origami's.

    Raises
    ------
    UsageError
    """
    for where, folders, files in os.walk(folder):
        for path in (Path(where, name) for name in (*folders, *files)):
            if is_link(path):
                raise UsageError(_link(path))


def _link(path: Path) -> str:
    return (
        f"{path} is a link, and writing to it would change its target; remove the link, or choose another folder for "
        "the results."
    )


def foreign(out: Path, name: str) -> str:
    """The error message for a file of the user's in the place of one of Origami's."""
    return (
        f"{out} holds {name}, which Origami did not write there and would replace; choose another folder for the "
        "results."
    )


def unshared_file(path: Path) -> None:
    """Give a file with several hard links content of its own, so that writing into it leaves the others alone.

    Raises
    ------
    OSError
    """
    if path.lstat().st_nlink > 1:
        own = path.with_name(f"{path.name}-{uuid.uuid4().hex}")
        try:
            shutil.copy2(path, own)
            os.replace(own, path)
        finally:
            own.unlink(missing_ok=True)


def real(path: Path) -> Path:
    """The path without links; of links that lead in a circle, as much as there is (`Path.resolve` would fail)."""
    return Path(os.path.realpath(path))


def is_link(path: Path) -> bool:
    """Whether a path is a symbolic link or a Windows junction."""
    straight = Path(os.path.realpath(path.parent), path.name)
    return path.is_symlink() or os.path.normcase(os.path.realpath(path)) != os.path.normcase(straight)


def keep_off_inputs(inputs: Sequence[Path], out: Path, names: Iterable[str]) -> None:
    """Refuse inputs in places that the results would replace.

    Parameters
    ----------
    inputs : sequence of Path
        Files, and folders with the files directly in them.
    out : Path
    names : iterable of str
        All names that may be written into the folder.

    Raises
    ------
    UsageError
    """
    places = {taken: out / name for name in names if (taken := _place(out / name)) is not None}
    for given in inputs:
        for path in [given, *(given.iterdir() if given.is_dir() else [])]:
            for above in [path.absolute(), *path.absolute().parents, real(path), *real(path).parents]:
                where = _place(above)
                if where is not None and where in places:
                    raise UsageError(
                        f"{path} lies where the results go and might be replaced ({places[where]}); "
                        "choose another folder for the results."
                    )


def _place(path: Path) -> tuple[int, int] | None:
    """An identity shared by all names of one file or folder; None if it does not exist."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino
