"""Write the manual's tables, and a batch's table of options, from the declarations; `make docs` does so first.

.venv/bin/python docs/tables.py
"""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
FILES, KINDS = ("file", ""), ("kind", "file", "")
SETTINGS, OPTIONS, PRESETS = ("setting", "", "values", "option"), ("option", "in the window"), ("kind", "settings")
USEFUL_OPTIONS = ("option", "")
# The options in the README, in their order; the manual and `--help` have all.
_USEFUL = (
    *("--paper", "--dpi", "--image", "--light", "--colour", "--bake", "--turn", "--reference", "--outline"),
    *("--creases", "--sheet", "--colmap-model", "--settings", "--recursive", "--threads", "--texture-from"),
    *("--resume", "--force"),
)


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
    yield _with_table(ROOT / "docs" / "photos.md", PRESETS, _presets())
    readme = ROOT / "README.md"
    text = _table_in(readme.read_text(encoding="utf-8"), FILES, _files())
    yield readme, _table_in(text, USEFUL_OPTIONS, _useful_options())
    yield ROOT / "workflow" / "schemas" / "rule_of_option.json", json.dumps(_rule_of_option(), indent=2) + "\n"


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


def _rule_of_option() -> dict[str, str]:
    """The rule of a batch that reads each option; threads are those of the batch itself."""
    stages = module("origami_addon.stages").STAGES
    found = {}
    for each in _declared():
        if each.option and each.flag != "--threads":
            place = stages.index(each.stage)
            # as in rules/rectify.smk, whose rules stop after the first stage, and after unwrapping
            rule = "place" if place == 0 else "sheet" if place <= stages.index("unwrap") else "page"
            found |= dict.fromkeys([each.flag, *([_negated(each)] if each.kind is bool else [])], rule)
    return found


def _negated(declared: Any) -> str:
    return f"--no-{declared.flag.strip('-')}"


def _options() -> Iterator[tuple[str, ...]]:
    for each in _declared():
        if each.option:
            shown = _as_typed(each) + (f": {each.typed}" if each.typed else "")
            yield shown, f"**{each.label}**" if each.label and each.in_panel else each.help


def _as_typed(declared: Any) -> str:
    words = [f"`{declared.flag} {word}`" for word in declared.words]
    if declared.kind is str and words:
        return ", ".join(words)
    without = [_code(_negated(declared))] if declared.kind is bool else []
    return ", ".join([_code(declared.option), *without, *words])


def _useful_options() -> Iterator[tuple[str, ...]]:
    """The options as `--help` explains them."""
    actions = {
        flag: each for each in module("headless.options").build_parser()._actions for flag in each.option_strings
    }
    typed = {each.flag: _as_typed(each) for each in _declared() if each.option}
    for flag in _USEFUL:
        value = f" {actions[flag].metavar}" if actions[flag].metavar else ""
        yield typed.get(flag, _code(flag + value)), actions[flag].help.replace("%%", "%")


def _presets() -> Iterator[tuple[str, ...]]:
    for each in module("origami_addon.presets").PRESETS.values():
        yield f"**{each.label}**", each.description[0].lower() + each.description[1:]


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
    return page, _table_in(page.read_text(encoding="utf-8"), head, rows)


def _table_in(text: str, head: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> str:
    lines = text.splitlines()
    start = lines.index(_row(head)) + 2
    end = next((n for n in range(start, len(lines)) if not lines[n].startswith("|")), len(lines))
    return "\n".join([*lines[:start], *map(_row, rows), *lines[end:]]) + "\n"


def _row(cells: tuple[str, ...]) -> str:
    return " ".join(["|", *(part for cell in cells for part in ([cell, "|"] if cell else ["|"]))])


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "benchmarks"))
    importlib.import_module("run").load_checkout()
    for path, text in written():
        path.write_text(text, encoding="utf-8")
