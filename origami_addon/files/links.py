"""Links, which a run never follows into the user's files."""

from __future__ import annotations

import os
import shutil
import uuid
from pathlib import Path


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
