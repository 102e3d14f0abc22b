"""Where what takes long to compute is kept between sessions."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy

from .report import ROOT


def work_folder() -> Path:
    """The folder that Blender gives an extension for its files; of a checkout, one that ends with the session."""
    try:
        package = __package__.rpartition(".")[0]
        return Path(bpy.utils.extension_path_user(package, path="work", create=True))
    except ValueError:
        folder = Path(tempfile.gettempdir()) / f"{ROOT.name}-origami-work"
        folder.mkdir(exist_ok=True)
        return folder
