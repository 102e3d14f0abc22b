"""Sentences in a panel."""

from __future__ import annotations

from typing import Any

import bpy

# Pixels of a letter of the panels at a scale of 1, on average, letters that the icon and the margins take, and the
# fewest in a line.
_LETTER_PIXELS, _MARGIN_LETTERS, _FEWEST_LETTERS = 7, 6, 20


def draw_sentence(layout: Any, sentence: str, icon: str) -> None:
    """A sentence in several lines, because labels do not wrap."""
    letter = _LETTER_PIXELS * bpy.context.preferences.system.ui_scale
    width = max(_FEWEST_LETTERS, int(bpy.context.region.width / letter) - _MARGIN_LETTERS)
    column = layout.column(align=True)
    line = ""
    for word in [*sentence.replace(" : ", "\N{NO-BREAK SPACE}:\N{NO-BREAK SPACE}").split(" "), ""]:
        if word == "" or len(line) + len(word) + 1 > width:
            column.label(text=line, icon=icon)
            line, icon = word, "BLANK1"
        else:
            line = f"{line} {word}".strip()
