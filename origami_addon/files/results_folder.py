"""Guards a folder of results: nothing is written over the user's files, through links, or over the inputs."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Sequence
from pathlib import Path

from ...core.errors import UsageError
from .links import is_link, real
from .marker import foreign, owners


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
