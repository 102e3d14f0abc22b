"""The script of a job: does the work of the request in its folder and reports in lines of JSON."""

from __future__ import annotations

import json
import logging
import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import OrigamiError
from ...core.watch import Watch
from ..files.kept import Arrays
from ..system_errors import system_errors_as_failures
from .process import GIVEN, REQUEST
from .requests import request_from_text
from .tasks import TASKS

log = logging.getLogger("origami")

Say = Callable[..., None]


def main(folder: Path) -> int:
    """Do the job in ``folder`` and return the exit code; errors are reported, not raised."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    logging.basicConfig(stream=sys.stderr, level=logging.INFO, format="%(message)s")
    request = request_from_text((folder / REQUEST).read_text(encoding="utf-8"))
    with np.load(folder / GIVEN) as stored:
        given: Arrays = dict(stored)
    watch = Watch(lambda fraction, text: _say(progress=fraction, text=text))
    try:
        with system_errors_as_failures():
            TASKS[type(request)](request, given, folder, _say, watch)
    except OrigamiError as error:
        _say(error=str(error), kind=type(error).__name__, warnings=error.warnings)
    except Exception as error:
        log.exception("internal error")
        _say(error=f"Internal error ({type(error).__name__}: {error}); please report it.", kind="StepFailed")
    return 0


def _say(**message: Any) -> None:
    print(json.dumps(message), flush=True)


def _end_with_parent() -> None:
    """Exit when the window is gone: nobody waits for the result."""
    while os.read(0, 1024):  # not `sys.stdin`, whose lock would delay Python's exit
        pass
    os._exit(1)
