"""Results as tables: markdown to read, csv and json to work with."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Row = dict[str, Any]


@dataclass
class Table:
    """Rows of figures.

    Attributes
    ----------
    name : str
        File name without ending.
    title : str
    columns : dict
        Key of a row's figure to heading and number format: ``{"mean": ("mean px", ".2f")}``.
    rows : list of dict
        A failure is in ``"failure"`` as a sentence; its row has no figures.
    notes : list of str
        Sentences under the table.
    """

    name: str
    title: str
    columns: dict[str, tuple[str, str]]
    rows: list[Row] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def markdown(self) -> str:
        """The table with its title and notes."""
        lines = [f"## {self.title}", ""]
        lines.append("| " + " | ".join(heading for heading, _ in self.columns.values()) + " |")
        lines.append("|" + "---|" * len(self.columns))
        for row in self.rows:
            lines.append("| " + " | ".join(self._cells(row)) + " |")
        return "\n".join([*lines, "", *(f"- {note}" for note in self.notes), ""])

    def _cells(self, row: Row) -> list[str]:
        cells = [_text(row.get(key), form) for key, (_, form) in self.columns.items()]
        if row.get("failure"):
            blank = next((i for i, cell in enumerate(cells) if not cell), len(cells) - 1)
            cells[blank] = f"failed: {row['failure']}"
        return cells

    def write(self, folder: Path) -> None:
        """``name.md``, ``name.csv`` (the columns) and ``name.json`` (everything)."""
        (folder / f"{self.name}.md").write_text(self.markdown(), encoding="utf-8")
        with (folder / f"{self.name}.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, [*self.columns, "failure"], restval="", extrasaction="ignore")
            writer.writeheader()
            writer.writerows(self.rows)
        content = {"title": self.title, "notes": self.notes, "rows": self.rows}
        (folder / f"{self.name}.json").write_text(json.dumps(content, indent=1, ensure_ascii=False), encoding="utf-8")


def _text(value: Any, form: str) -> str:
    if value is None:
        return ""
    if isinstance(value, Sequence) and not isinstance(value, str):
        return " ".join(format(item, form) for item in value)
    return format(value, form) if form and not isinstance(value, str) else str(value)
