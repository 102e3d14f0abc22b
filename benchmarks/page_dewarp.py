"""The baseline page-dewarp: one photo, a cubic sheet model fitted to lines of text."""

from __future__ import annotations

import subprocess
import sys
import venv
from collections.abc import Sequence
from pathlib import Path

REQUIREMENTS = Path(__file__).with_name("page-dewarp.txt")
_TIME_LIMIT_SECONDS = 150


class BaselineFailed(Exception):
    """Why there is no page, as one sentence."""


def install() -> Path:
    """The program, in a separate environment inside the current one; created on first use."""
    folder = Path(sys.prefix) / "page-dewarp"
    program = folder / "bin" / "page-dewarp"
    done = folder / "requirements.txt"
    if done.is_file() and done.read_text() == REQUIREMENTS.read_text():
        return program
    try:
        venv.create(folder, with_pip=True, clear=True)
        pip = [folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--no-deps", "-r", REQUIREMENTS]
        subprocess.run(pip, check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError) as why:
        said = getattr(why, "stderr", None) or str(why)
        raise BaselineFailed(f"page-dewarp could not be installed: {said.strip().splitlines()[-1]}") from why
    done.write_text(REQUIREMENTS.read_text())
    return program


def dewarp_any(photos: Sequence[Path], folder: Path) -> Path:
    """The page from the first photo for which page-dewarp makes one.

    Raises
    ------
    BaselineFailed
        If it makes none from any photo.
    """
    for photo in photos:
        try:
            return dewarp(photo, folder)
        except BaselineFailed as why:
            last = why
    raise BaselineFailed(f"no page of any of {len(photos)} photos; of the last: {last}")


def dewarp(photo: Path, folder: Path) -> Path:
    """The page image that page-dewarp makes from ``photo``, written into ``folder``.

    Raises
    ------
    BaselineFailed
        If it made none: its exit code is 0 even then.
    """
    program = install()
    folder.mkdir(parents=True, exist_ok=True)
    page = folder / f"{photo.stem}_thresh.png"
    page.unlink(missing_ok=True)
    try:
        # Grey instead of black and white, so its binarisation does not count against it.
        run = subprocess.run(
            [program, "--no-binary", "1", photo.resolve()],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=_TIME_LIMIT_SECONDS,
        )
    except subprocess.TimeoutExpired as why:
        raise BaselineFailed(f"no page after {_TIME_LIMIT_SECONDS} s") from why
    if not page.is_file():
        said = (run.stderr.strip() or run.stdout.strip() or "no message").splitlines()[-1]
        raise BaselineFailed(f"no page was written ({said})")
    return page
