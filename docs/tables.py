"""Write the manual's tables from the declarations in the source; `make docs` does so first.

.venv/bin/python docs/tables.py
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
FILES, KINDS = ("file", ""), ("kind", "file", "")
SETTINGS, OPTIONS = ("setting", "", "values", "option"), ("option", "in the window")


def module(name: str) -> ModuleType:
    """A module of the checkout, which is loaded as `origami`."""
    return importlib.import_module(f"origami.{name}")


def written() -> Iterator[tuple[Path, str]]:
    """Each page that has such a table, with the text that it ought to have."""
    stages = module("origami_addon.stages")
    for page in dict.fromkeys(stages.about(stage).manual for stage in stages.STAGES):
        named = [stage for stage in stages.STAGES if stages.about(stage).manual == page]
        yield _with_table(ROOT / "docs" / f"{page}.md", SETTINGS, _settings(named))
    yield _with_table(ROOT / "docs" / "command_line.md", OPTIONS, _options())
    yield _with_table(ROOT / "docs" / "export.md", KINDS, _kinds())
    yield _with_table(ROOT / "README.md", FILES, _files())


def _declared() -> list[Any]:
    within = module("core.setting").declarations_within(module("origami_addon.settings").RunSettings)
    return [declared for _, declared in within]


def _settings(stages: list[str]) -> Iterator[tuple[str, ...]]:
    for stage in stages:
        for each in _declared():
            if each.stage == stage and each.label and each.in_panel:
                chosen = each.choices.items() if each.kind is str else ()
                words = [f"**{choice.label}** (`{word}`): {choice.help}" for word, choice in chosen]
                text = ". ".join([each.help, *(["; ".join(words)] if words else [])])
                yield f"**{each.label}**", text, each.values_text, _code(each.option)


def _options() -> Iterator[tuple[str, ...]]:
    for each in _declared():
        if each.option:
            words = [f"`{each.flag} {word}`" for word in each.words]
            flags = (
                [_code(each.option), f"`--no-{each.flag.strip('-')}`"] if each.kind is bool else [_code(each.option)]
            )
            shown = ", ".join(words if each.kind is str and words else [*flags, *words])
            shown += f": {each.typed}" if each.typed else ""
            yield shown, f"**{each.label}**" if each.label and each.in_panel else each.help


def _kinds() -> Iterator[tuple[str, ...]]:
    for each in module("origami_addon.export.outputs").KINDS.values():
        yield f"**{each.label}**", ", ".join(map(_code, (each.name, *each.also))), each.help


def _files() -> Iterator[tuple[str, ...]]:
    for each in module("origami_addon.export.outputs").OUTPUTS:
        if each.in_run:
            yield ", ".join(map(_code, (each.name, *each.also))), each.help


def _code(text: str) -> str:
    return f"`{text}`" if text else ""


def _with_table(page: Path, head: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> tuple[Path, str]:
    """The page with these rows in the table of that head."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = lines.index(_row(head)) + 2
    end = next((n for n in range(start, len(lines)) if not lines[n].startswith("|")), len(lines))
    return page, "\n".join([*lines[:start], *map(_row, rows), *lines[end:]]) + "\n"


def _row(cells: tuple[str, ...]) -> str:
    return " ".join(["|", *(part for cell in cells for part in ([cell, "|"] if cell else ["|"]))])


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "benchmarks"))
    importlib.import_module("run").load_checkout()
    for path, text in written():
        path.write_text(text, encoding="utf-8")
