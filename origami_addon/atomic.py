"""Files that are either whole or not there."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..core.errors import StepFailed


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path to write to; what is written takes the place of `path` when the block ends well.

    The path has the same file name, in a temporary folder beside the target. Further files written there (the
    material of an OBJ, say) are moved along with it.

    Raises
    ------
    StepFailed
        If it could not be written: no room, no permission, a folder in its place.
    """
    folder = None
    try:
        folder = Path(tempfile.mkdtemp(prefix=".writing-", dir=path.parent))
        yield folder / path.name
        if not (folder / path.name).is_file():
            raise OSError("nothing was written")
        for written in folder.iterdir():
            os.replace(written, path.parent / written.name)
    except (OSError, RuntimeError) as error:  # Blender's operators and image writer raise RuntimeError
        reason = getattr(error, "strerror", None) or str(error).removeprefix("Error: ").strip()
        raise StepFailed(
            f"{path.name} could not be written ({reason}): make room in {path.parent} or choose another output folder."
        ) from error
    finally:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
