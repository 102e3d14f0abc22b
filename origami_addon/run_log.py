"""The log of a run, in the folder of its results."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .files.links import unshared_file
from .one_line import OneLine

log = logging.getLogger("origami")


class _QuietFileHandler(logging.FileHandler):
    """A log that never fails: a full disk is reported once, by the step that needs it."""

    def handleError(self, record: logging.LogRecord) -> None:
        pass


@contextmanager
def logging_to(path: Path) -> Iterator[None]:
    """Also write what is logged into a file."""
    if path.exists():
        unshared_file(path)
    handler = _QuietFileHandler(path, encoding="utf-8", errors="backslashreplace")
    handler.setFormatter(OneLine("%(asctime)s %(levelname)s %(message)s"))
    level = log.level
    log.setLevel(logging.DEBUG)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)
        handler.close()
