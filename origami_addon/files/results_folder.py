"""Folders that results are written into: what is replaced there is Origami's own.

A file marks them, and tells the document whose export made it; a run of the command line names none.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from ...core.errors import UsageError

MARKER = ".origami"
_TEXT = "Origami writes its results into this folder; a later run may replace them.\n"
_DOCUMENT = "Document: "


def mark(out: Path, document: str = "") -> None:
    """Note that the folder is Origami's, and the document whose files it gets.

    Raises
    ------
    OSError
    """
    (out / MARKER).write_text(_TEXT + (f"{_DOCUMENT}{document}\n" if document else ""), encoding="utf-8")


def owner_of(out: Path) -> str | None:
    """The document whose files the folder holds, "" for those of the command line; None if it is not marked."""
    if not (out / MARKER).is_file():
        return None
    _, _, document = (out / MARKER).read_text(encoding="utf-8", errors="replace").partition(_DOCUMENT)
    return document.strip()


def keep_off_others(out: Path, names: Iterable[str], document: str = "") -> None:
    """Make sure that nobody's files are replaced.

    In a folder that Origami has not marked, whatever has the name of a result is the user's; in one that is marked for
    a document, it is that document's.

    Parameters
    ----------
    out : Path
    names : iterable of str
        Of all that may be written into the folder.
    document : str
        Whose files these are; "" for the command line.

    Raises
    ------
    UsageError
    """
    owner = owner_of(out)
    if owner in ("", document):
        return
    for name in names:
        if (out / name).exists() or (out / name).is_symlink():
            raise UsageError(
                f"{out} holds {name}, which Origami did not write and would replace; "
                "choose another folder for the results."
                if owner is None
                else f"{out} holds {name} of the document {owner}, which would be replaced; "
                "choose another folder for the results."
            )


def keep_off_inputs(inputs: Sequence[Path], out: Path, names: Iterable[str]) -> None:
    """Make sure that what is read does not lie where results go: they would replace it.

    Parameters
    ----------
    inputs : sequence of Path
        Files, and folders with what is directly in them.
    out : Path
    names : iterable of str
        Of all that may be written into the folder.

    Raises
    ------
    UsageError
    """
    places = {taken: out / name for name in names if (taken := _place(out / name)) is not None}
    for given in inputs:
        for path in [given, *(given.iterdir() if given.is_dir() else [])]:
            for above in [path.absolute(), *path.absolute().parents, path.resolve(), *path.resolve().parents]:
                where = _place(above)
                if where is not None and where in places:
                    raise UsageError(
                        f"{path} lies where the results go and might be replaced ({places[where]}); "
                        "choose another folder for the results."
                    )


def _place(path: Path) -> tuple[int, int] | None:
    """The same for all names of one file or folder; None where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino
