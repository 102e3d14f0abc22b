"""The folder for results kept between sessions."""

from __future__ import annotations

import shutil
from pathlib import Path

import bpy

from ..core.errors import StepFailed


def work_folder() -> Path:
    """The folder that Blender gives an extension for its files; for a checkout, one deleted after the session."""
    try:
        package = __package__.rpartition(".")[0]
        return Path(bpy.utils.extension_path_user(package, path="work", create=True))
    except ValueError:
        folder = Path(bpy.app.tempdir) / "origami work"
        folder.mkdir(exist_ok=True)
        return folder


def kept_bytes() -> int:
    """The size of the kept results on disk."""
    return sum(path.stat().st_size for path in work_folder().rglob("*") if path.is_file())


def clear() -> None:
    """Remove all kept results; the folder stays.

    Raises
    ------
    StepFailed
        If a file is in use.
    """
    folder = work_folder()
    for inside in list(folder.iterdir()):
        try:
            if inside.is_dir():
                shutil.rmtree(inside)
            else:
                inside.unlink()
        except OSError as error:
            raise StepFailed(
                f"{inside.name} in {folder} could not be removed ({error.strerror}): close other Blender windows and "
                "clear again."
            ) from error
