"""Where what takes long to compute is kept between sessions."""

from __future__ import annotations

from pathlib import Path

import bpy


def work_folder() -> Path:
    """The folder that Blender gives an extension for its files; of a checkout, one that ends with the session."""
    try:
        package = __package__.rpartition(".")[0]
        return Path(bpy.utils.extension_path_user(package, path="work", create=True))
    except ValueError:
        folder = Path(bpy.app.tempdir) / "origami work"
        folder.mkdir(exist_ok=True)
        return folder
