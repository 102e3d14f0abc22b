"""Folders of delivered files beside a run's results: complete or as they were, and never over a file of the user's.

Such a folder has the marker of Origami's results, so a later search for photos passes it by, and a list of its files
with their hashes, so a file that somebody has corrected is noticed.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ...core.errors import UsageError
from ...origami_addon.files.atomic import WRITING, sync_folder, write_text_at_once
from ...origami_addon.files.content_hash import sha256_of
from ...origami_addon.files.folder_lock import only_run_in
from ...origami_addon.files.json_files import parsed_json
from ...origami_addon.files.links import is_link
from ...origami_addon.files.marker import claim, foreign, number_of, release
from ...origami_addon.files.results_folder import keep_off_others
from ...origami_addon.system_errors import unwritable_as_failure

# Named differently from a run's report, which says that a page has been finished.
LIST = "delivered.json"
# The owner of the files in the marker: with one, the marker needs no proof beside it, and the list's hashes are better.
_OWNER = "delivery"


@contextmanager
def delivering(folder: Path, last: str) -> Iterator[Path]:
    """An empty folder to write into; at the end of the block its files replace those of an earlier delivery.

    Parameters
    ----------
    folder : Path
        Where the files go; it is made if it is missing.
    last : str
        The file that says that the delivery is complete: it is removed first and put in place last.

    Raises
    ------
    UsageError
        If the folder cannot be used, or a file there is the user's or was changed since it was written.
    """
    with unwritable_as_failure(folder):
        folder.mkdir(exist_ok=True)
    if is_link(folder):
        raise UsageError(f"{folder} is a link, and writing to it would change its target; remove the link.")
    try:
        with only_run_in(folder):
            for unfinished in folder.glob(f"{WRITING}*"):
                shutil.rmtree(unfinished, ignore_errors=True)
            before = _listed(folder)
            _keep_off_changed(folder, before)
            new = Path(tempfile.mkdtemp(prefix=WRITING, dir=folder))
            try:
                yield new
                with unwritable_as_failure(folder):
                    _put_in_place(folder, new, before, last)
            finally:
                shutil.rmtree(new, ignore_errors=True)
    finally:
        with suppress(OSError):  # it is not empty
            folder.rmdir()


def _listed(folder: Path) -> dict[str, list[str]]:
    """The files of the delivery in a folder, each with the hashes that it may have."""
    if not (folder / LIST).exists():
        return {}
    try:
        files: dict[str, Any] = parsed_json(folder / LIST)["files"]
        return {str(name): [str(each) for each in hashes] for name, hashes in files.items()}
    except (ValueError, KeyError, TypeError, AttributeError):
        raise UsageError(f"{folder / LIST} is not Origami's list; move the folder {folder} elsewhere.") from None


def _keep_off_changed(folder: Path, before: dict[str, list[str]]) -> None:
    """Refuse to replace what somebody has edited.

    Raises
    ------
    UsageError
    """
    keep_off_others(folder, [LIST], _OWNER)
    for name, hashes in before.items():
        path = folder / name
        if path.is_file() and sha256_of(path) not in hashes:
            raise UsageError(
                f"{path} was changed since it was written and would be replaced; move it elsewhere, or delete it to "
                "have it made again."
            )


def _put_in_place(folder: Path, new: Path, before: dict[str, list[str]], last: str) -> None:
    """Move the new files into the folder; at any moment the list names all that lie there.

    Raises
    ------
    UsageError
    OSError
    """
    made = sorted(path.relative_to(new).as_posix() for path in new.rglob("*") if path.is_file())
    hashes = {name: [sha256_of(new / name)] for name in made}
    keep_off_others(folder, made, _OWNER)
    for inside in {(folder / name).parent for name in made} - {folder}:
        if os.path.lexists(inside) and (is_link(inside) or not inside.is_dir()):
            raise UsageError(foreign(folder, inside.name))
    stale = [name for name in before if name not in hashes]
    (folder / last).unlink(missing_ok=True)
    claim(folder, [LIST, *made], _OWNER)
    _write_list(folder, before | {name: before.get(name, []) + each for name, each in hashes.items()})
    for name in stale:
        (folder / name).unlink(missing_ok=True)
        if "/" in name:
            with suppress(OSError):  # it is not empty
                (folder / name).parent.rmdir()
    for name in sorted(made, key=lambda each: each == last):
        if name == last:
            _write_list(folder, hashes)
        (folder / name).parent.mkdir(exist_ok=True)
        os.replace(new / name, folder / name)
    release(folder, stale)
    sync_folder(folder)


def _write_list(folder: Path, files: dict[str, list[str]]) -> None:
    content = {"number": number_of(folder), "files": files}
    write_text_at_once(folder / LIST, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
