"""The options of the command line, and the settings that follow from them."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..core.errors import UsageError
from ..core.setting import FILE, FOLDER, Setting, declarations_within
from ..origami_addon.drawn_files import agreed_reference, read_drawn
from ..origami_addon.paper_size import check_unit, paper_size
from ..origami_addon.presets import PRESETS
from ..origami_addon.report import version
from ..origami_addon.settings import RunSettings
from ..origami_addon.settings_json import from_json, read_settings
from ..origami_addon.stages import STAGES, about, as_option

_EPILOG = """\
exit codes:
  0    done; report.json is in OUT
  2    a wrong option or path, or OUT cannot be used
  3    an error inside Origami
  4    the photos cannot be used; take others
  5    a step failed
  6    with --sheet all: some of the sheets failed, the others are in OUT
  130  stopped by Ctrl-C; the next run continues from there
"""


def build_parser() -> argparse.ArgumentParser:
    """The parser of the options. Each sets one of the settings (see `--print-settings`) or says how to run."""
    parser = argparse.ArgumentParser(
        prog="rectify.py",
        description="Make one flat page from several photos of a folded or curved sheet of paper.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "photos", nargs="*", metavar="PHOTOS", help="a folder of photos, photo files (at least 3), or a movie"
    )
    parser.add_argument("-o", "--output", metavar="OUT", help="the folder for the results; created if missing")
    parser.add_argument("--version", action="version", version=f"Origami {version()}")

    for heading in dict.fromkeys(about(stage).options for stage in reversed(STAGES)):
        group = parser.add_argument_group(heading)
        for stage in STAGES:
            for declared in _declared_options().values():
                if declared.stage == stage and about(stage).options == heading:
                    _add_option(group, declared)

    run = parser.add_argument_group("the run")
    run.add_argument(
        "--texture-from",
        metavar="DIR",
        type=Path,
        action="append",
        default=[],
        help="other photos of the same untouched sheet, in ultraviolet, infrared or raking light, after treatment, or "
        "better ones: makes a page of them in OUT/other_light, named after the folder, pixel by pixel on the page; may "
        "be given several times, once for each light",
    )
    base = run.add_mutually_exclusive_group()
    base.add_argument(
        "--settings",
        metavar="FILE",
        type=Path,
        help="settings as JSON, or the report.json of another run; options on the command line override them",
    )
    base.add_argument(
        "--kind",
        choices=list(PRESETS),
        help="settings for a kind of document; options on the command line override them: "
        + "; ".join(f"{name}: {_as_help(preset.description)}" for name, preset in PRESETS.items()),
    )
    run.add_argument(
        "--recursive", action="store_true", help="also take the photos in the folders inside a folder of photos"
    )
    run.add_argument("--print-settings", action="store_true", help="print the settings as JSON and exit")
    run.add_argument(
        "--stop-after",
        choices=[as_option(stage) for stage in STAGES[:-1]],
        help="stop after this stage and write no page; the same command without it, or with a later stage, goes on "
        "from there: " + "; ".join(f"{as_option(stage)}: {about(stage).help}" for stage in STAGES[:-1]),
    )
    again = run.add_mutually_exclusive_group()
    again.add_argument(
        "--resume",
        action="store_true",
        help="OUT may hold an earlier run: keep what is unchanged (an unfinished run always continues)",
    )
    again.add_argument(
        "--force", action="store_true", help="OUT may hold an earlier run: compute everything again, then replace it"
    )
    loud = run.add_mutually_exclusive_group()
    loud.add_argument("-v", "--verbose", action="store_true", help="also print what goes into log.txt")
    loud.add_argument("-q", "--quiet", action="store_true", help="print only errors")
    return parser


def _as_help(description: str) -> str:
    """A sentence of the window in the middle of a help text."""
    return description[0].lower() + description[1:]


def settings_from(arguments: argparse.Namespace) -> RunSettings:
    """The values of the settings file or the kind of document, or the defaults, with the options on top.

    Raises
    ------
    UsageError
    """
    base = _base(arguments)
    outline_photo, outline = read_drawn(arguments.outline, "outline")
    creases_photo, creases = read_drawn(arguments.creases, "creases")
    reference = agreed_reference(
        {"--reference": arguments.reference, "--outline": outline_photo, "--creases": creases_photo}
    )
    for name in ("outline", "creases"):
        other = reference not in (None, base.reference)
        if getattr(base, name) and other and not getattr(arguments, name):
            raise UsageError(
                f"The setting {name} in {arguments.settings} belongs to another reference photo than {reference}; "
                f"give the one for this photo with --{name}, or remove it from the file."
            )
    given = _given_options(arguments) | {"reference": reference, "outline": outline, "creases": creases}
    result = from_json({name: value for name, value in given.items() if value is not None}, base)
    if arguments.paper is None:
        check_unit(result.page.paper_size_mm)
    else:
        result = replace(result, page=replace(result.page, paper_size_mm=paper_size(arguments.paper)))
    result.check()
    return result


def _base(arguments: argparse.Namespace) -> RunSettings:
    """The settings that the options override.

    Raises
    ------
    UsageError
    """
    if arguments.settings:
        return read_settings(arguments.settings)
    return from_json(PRESETS[arguments.kind].content) if arguments.kind else RunSettings()


def _given_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options that were given, as in a settings file, except the paper's size, which is still text."""
    content: dict[str, Any] = {}
    for (*groups, name), declared in _declared_options().items():
        value = getattr(arguments, declared.flag.strip("-").replace("-", "_"))
        if value is not None and declared.kind is not tuple:
            inside = content
            for group in groups:
                inside = inside.setdefault(group, {})
            inside[name] = str(value) if isinstance(value, Path) else value
    return content


def _declared_options() -> dict[tuple[str, ...], Setting]:
    """The settings that have an option, each with its path of names in a settings file."""
    return {path: declared for path, declared in declarations_within(RunSettings) if declared.option}


def _add_option(group: argparse._ArgumentGroup, declared: Setting) -> None:
    """The option of a setting."""
    text = declared.help + (f": {declared.typed}" if declared.typed else "")
    text += "".join(f"; {word}: {choice.help}" for word, choice in declared.choices.items())
    text += f" ({values})" if (values := declared.values_text) else ""
    how: dict[str, Any] = {"metavar": declared.value_name or None}
    if declared.kind is bool:
        how = {"action": argparse.BooleanOptionalAction}
    elif declared.value_name in (FOLDER, FILE):
        how["type"] = Path
    elif declared.kind in (int, float):
        how["type"] = _number_or_word(declared)
    elif declared.choices:
        how["choices"] = declared.words
    group.add_argument(declared.flag, **how, help=text.replace("%", "%%"))


def _number_or_word(declared: Setting) -> Callable[[str], Any]:
    """A function that reads the value of an option: a number, or one of a few words."""

    def read(text: str) -> Any:
        try:
            return text if text in declared.words else declared.kind(text)
        except ValueError:
            kinds = " nor ".join(["a whole number" if declared.kind is int else "a number", *declared.words])
            raise argparse.ArgumentTypeError(f"{text!r} is {'neither' if declared.words else 'not'} {kinds}") from None

    return read
