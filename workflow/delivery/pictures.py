"""Pictures that libvips reads and writes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from ...core.errors import StepFailed, UsageError


def opened(path: Path) -> Any:
    """A picture as libvips opens it, as stored: an EXIF rotation is not applied.

    Raises
    ------
    UsageError
        If libvips is not installed.
    StepFailed
        If it cannot read the picture.
    """
    try:
        import pyvips
    except (ImportError, OSError) as error:
        raise UsageError(
            f"libvips, which reads pictures here, cannot be loaded ({error}); install it: {sys.executable} -m pip "
            "install -r .ci/requirements-text.txt"
        ) from None
    try:
        return pyvips.Image.new_from_file(str(path))
    except pyvips.Error as error:
        raise StepFailed(f"{path} cannot be read as a picture: {' '.join(str(error).split())}.") from None


def written(write: Any, *arguments: Any, **options: Any) -> None:
    """Call a function of libvips that writes; its failures become sentences.

    Raises
    ------
    StepFailed
    """
    import pyvips

    try:
        write(*arguments, **options)
    except pyvips.Error as error:
        raise StepFailed(
            f"{arguments[0]} could not be written ({' '.join(str(error).split())}); make room there and run again."
        ) from None
