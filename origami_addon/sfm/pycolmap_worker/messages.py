"""What the worker tells its parent, and what it hears from it."""

from __future__ import annotations

import json
import os
import threading
import time
from typing import Any

_SIGN_OF_LIFE_SECONDS = 5
# Parts of the time of a placement after which the features are found, and the photos matched.
EXTRACTED, MATCHED = 0.62, 0.8


def say(message: dict[str, Any]) -> None:
    """Write a line in one piece, because two threads write."""
    os.write(1, (json.dumps(message) + "\n").encode("ascii"))


def report(fraction: float, text: str) -> None:
    say({"progress": round(fraction, 4), "text": text})


def show_life() -> None:
    """Say every few seconds that this process has not been stopped."""

    def repeat() -> None:
        while True:
            time.sleep(_SIGN_OF_LIFE_SECONDS)
            say({})

    threading.Thread(target=repeat, daemon=True).start()


def end_with_parent() -> None:
    """Exit when stdin closes: the parent holds the other end and uses it for nothing else."""

    def wait() -> None:
        while os.read(0, 4096):
            pass
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
