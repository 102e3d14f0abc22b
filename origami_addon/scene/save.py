"""Saves the file that holds the documents."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import bpy

from ..files.atomic import replacing


def save_document(path: Path, home: Path | None = None) -> None:
    """Save the whole file as a copy; its pictures stay where they are, with paths relative to it.

    Parameters
    ----------
    path : Path
    home : Path, optional
        The folder to which it will be moved, together with the pictures beside it.

    Raises
    ------
    StepFailed
        If it could not be written.
    """
    here = {image: image.filepath_raw for image in bpy.data.images if image.filepath_raw}
    try:
        for image, picture in here.items():
            # Windows has no relative paths to another drive.
            with suppress(ValueError):
                there, beside = Path(bpy.path.abspath(picture)).resolve(), path.parent.resolve()
                start = beside if home is None or there.is_relative_to(beside) else home.resolve()
                relative = os.path.relpath(there, start)
                image.filepath_raw = "//" + Path(relative).as_posix()
        with replacing(path) as temporary:
            bpy.ops.wm.save_as_mainfile(filepath=str(temporary), copy=True, compress=True, relative_remap=False)
    finally:
        for image, picture in here.items():
            image.filepath_raw = picture
