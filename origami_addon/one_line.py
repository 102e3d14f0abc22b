"""Text that may contain any name of a file, for a terminal or a log."""

from __future__ import annotations

import logging
import unicodedata
from pathlib import Path

# Control characters, those that change the writing direction, halves of characters, and separators of lines.
_ESCAPED = ("Cc", "Cf", "Cs", "Zl", "Zp")


def one_line(text: str) -> str:
    """The text with every character escaped that would break its line, or that a terminal would obey."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        letter.encode("unicode_escape").decode("ascii") if unicodedata.category(letter) in _ESCAPED else letter
        for letter in text
    )


def printable(name: str) -> str:
    """A file's name as the name of a document: files such as OBJ have it in a line, and would end the line there."""
    return "".join(letter if letter.isprintable() else "_" for letter in name)


def is_text(path: Path) -> bool:
    """Whether a path is text: POSIX allows any bytes in names, but Blender only takes UTF-8."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return False
    return True


class OneLine(logging.Formatter):
    """Formats each message as one line; a traceback keeps its lines."""

    def formatMessage(self, record: logging.LogRecord) -> str:
        """The message in the handler's format, as `logging.Formatter` asks."""
        record.message = one_line(record.message)
        return super().formatMessage(record)
