"""Text that any XML file can hold."""

from __future__ import annotations

import re

# All that XML 1.0 does not know: control characters, and halves of characters in names that are not UTF-8.
_UNKNOWN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def xml_text(text: str) -> str:
    """The text with a replacement character for each character that XML does not know."""
    return _UNKNOWN.sub("\ufffd", text)
