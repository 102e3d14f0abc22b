"""Reads the paper's edge and the creases that a user gives as files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from ..core.errors import UsageError
from .settings_json import read_json, shown


def read_drawn(path: Path | None, what: Literal["outline", "creases"]) -> tuple[str | None, Any]:
    """The reference photo that a file with an outline or creases names, and its list.

    Parameters
    ----------
    path : Path or None
        Holds ``{"reference": name, what: [...]}``, as a run writes it, or just the list, which names no photo. None if
        there is no file; both results are then None.
    what : {"outline", "creases"}

    Raises
    ------
    UsageError
        If it cannot be read or has other content.
    """
    if path is None:
        return None, None
    content = read_json(path, what)
    if not isinstance(content, dict):
        return None, content
    reference = content.get("reference")
    if what not in content or not (reference is None or isinstance(reference, str)):
        raise UsageError(
            f'The {what} file {path} must hold a list, or an object {{"reference": "photo.jpg", "{what}": [...]}}, '
            f"not {shown(content)}."
        )
    return reference, content[what]


def agreed_reference(named: Mapping[str, str | None]) -> str | None:
    """The reference photo that several options name.

    Parameters
    ----------
    named : mapping of str to (str or None)
        For each option the photo's name, with as many of its folders as the user or a run wrote; None if it names none.

    Returns
    -------
    str or None
        The name with most folders; None if no option names a photo.

    Raises
    ------
    UsageError
        If they name different photos.
    """
    given = {option: photo for option, photo in named.items() if photo is not None}
    if not given:
        return None
    longest = max(given, key=lambda option: len(Path(given[option]).parts))
    for option, photo in given.items():
        parts = Path(photo).parts
        if Path(given[longest]).parts[-len(parts) :] != parts:
            raise UsageError(
                f"{option} belongs to the photo {photo}, and {longest} to {given[longest]}; both must be of the same "
                "reference photo: leave one of them out."
            )
    return given[longest]
