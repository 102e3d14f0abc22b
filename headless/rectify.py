"""Photos of a sheet of paper in, the flat page out: Origami without a window.

blender -b --factory-startup --python-exit-code 3 -P headless/rectify.py -- PHOTOS -o OUT
.venv/bin/python headless/rectify.py PHOTOS -o OUT
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import importlib
import logging
import os
import runpy
import signal
import sys
import threading
import typing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any, TextIO

if typing.TYPE_CHECKING:
    from origami.core.setting import Setting
    from origami.origami_addon.report import Report
    from origami.origami_addon.settings import RunSettings

INTERNAL_ERROR, USAGE_ERROR, SOME_SHEETS_FAILED, STOPPED = 3, 2, 6, 130
DEPENDENCIES = ("bpy", "numpy", "scipy", "pycolmap")

EPILOG = """\
exit codes:
  0    done; report.json lies in OUT
  2    a wrong option or path, or OUT cannot be used
  3    an error inside Origami
  4    the photos cannot serve; others are needed
  5    a step failed
  6    with --sheet all: some of the sheets failed, the others lie in OUT
  130  stopped by Ctrl-C; the next run goes on from there
"""


def origami() -> str:
    """Load Origami and return the name it is loaded under.

    An installed and enabled extension comes first; else the checkout that this file lies in is loaded as `origami`.
    """
    import bpy

    for addon in bpy.context.preferences.addons.keys():  # noqa: SIM118 - Blender's collection, not a dict
        if addon.startswith("bl_ext.") and addon.endswith(".origami"):
            return str(addon)
    runpy.run_path(str(Path(__file__).with_name("checkout.py")))["load_checkout"]()
    return "origami"


def module(name: str) -> ModuleType:
    """A module of Origami, by its name inside the package."""
    return importlib.import_module(f"{origami()}.{name}")


def build_parser() -> argparse.ArgumentParser:
    """The options; each sets one value of the settings (see `--print-settings`) or says how to run."""
    parser = argparse.ArgumentParser(
        prog="rectify.py",
        description="Make one flat page from several photos of a folded or curved sheet of paper.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("photos", nargs="*", metavar="PHOTOS", help="a folder of photos, or photo files; at least 3")
    parser.add_argument("-o", "--output", metavar="OUT", help="the folder for the results; made if it is not there")
    parser.add_argument("--version", action="version", version=f"Origami {module('origami_addon.report').version()}")

    stages = module("origami_addon.stages")
    for heading in dict.fromkeys(stages.about(stage).options for stage in reversed(stages.STAGES)):
        group = parser.add_argument_group(heading)
        for stage in stages.STAGES:
            for declared in declared_options().values():
                if declared.stage == stage and stages.about(stage).options == heading:
                    add_option(group, declared)

    run = parser.add_argument_group("the run")
    run.add_argument(
        "--settings",
        metavar="FILE",
        type=Path,
        help="settings as JSON, or the report.json of another run; options given besides win",
    )
    run.add_argument("--print-settings", action="store_true", help="print the settings as JSON and leave")
    again = run.add_mutually_exclusive_group()
    again.add_argument(
        "--resume",
        action="store_true",
        help="OUT may hold an earlier run: what is unchanged is kept (a run that did not finish always goes on)",
    )
    again.add_argument(
        "--force", action="store_true", help="OUT may hold an earlier run: all is done anew, and then takes its place"
    )
    loud = run.add_mutually_exclusive_group()
    loud.add_argument("-v", "--verbose", action="store_true", help="say also what log.txt says")
    loud.add_argument("-q", "--quiet", action="store_true", help="say nothing but errors")
    return parser


def declared_options() -> dict[tuple[str, ...], Setting]:
    """The settings that have an option, by the names on the way to them in a settings file."""
    within = module("core.setting").declarations_within(module("origami_addon.settings").RunSettings)
    return {path: declared for path, declared in within if declared.option}


def add_option(group: argparse._ArgumentGroup, declared: Setting) -> None:
    """The option of a setting."""
    setting = module("core.setting")
    told = declared.help + (f": {declared.typed}" if declared.typed else "")
    told += "".join(f"; {word}: {choice.help}" for word, choice in declared.choices.items())
    told += f" ({values})" if (values := declared.values_text) else ""
    how: dict[str, Any] = {"metavar": declared.value_name or None}
    if declared.kind is bool:
        how = {"action": argparse.BooleanOptionalAction}
    elif declared.value_name in (setting.FOLDER, setting.FILE):
        how["type"] = Path
    elif declared.kind in (int, float):
        how["type"] = number_or_word(declared)
    elif declared.choices:
        how["choices"] = declared.words
    group.add_argument(declared.flag, **how, help=told.replace("%", "%%"))


def number_or_word(declared: Setting) -> Callable[[str], Any]:
    """Reads the value of an option that is a number or one of a few words."""

    def read(text: str) -> Any:
        try:
            return text if text in declared.words else declared.kind(text)
        except ValueError:
            kinds = " nor ".join(["a whole number" if declared.kind is int else "a number", *declared.words])
            raise argparse.ArgumentTypeError(f"{text!r} is {'neither' if declared.words else 'not'} {kinds}") from None

    return read


def settings_from(arguments: argparse.Namespace) -> RunSettings:
    """The settings file's values, or the defaults, with the options on top."""
    settings = module("origami_addon.settings")
    from_file = module("origami_addon.settings_json")
    base = from_file.read_settings(arguments.settings) if arguments.settings else settings.RunSettings()
    drawn = module("origami_addon.drawn_files")
    outline_photo, outline = drawn.read_drawn(arguments.outline, "outline")
    creases_photo, creases = drawn.read_drawn(arguments.creases, "creases")
    reference = drawn.agreed_reference(
        {"--reference": arguments.reference, "--outline": outline_photo, "--creases": creases_photo}
    )
    for name in ("outline", "creases"):
        other = reference not in (None, base.reference)
        if getattr(base, name) and other and not getattr(arguments, name):
            raise module("core.errors").UsageError(
                f"What {arguments.settings} has as {name} belongs to another reference photo than "
                f"{reference}; give this one's with --{name}, or take it out of the file."
            )
    given = given_options(arguments) | {"reference": reference, "outline": outline, "creases": creases}
    result: RunSettings = from_file.from_json({name: value for name, value in given.items() if value is not None}, base)
    sizes = module("origami_addon.paper_size")
    if arguments.paper is None:
        sizes.check_unit(result.page.paper_size_mm)
    else:
        result = replace(result, page=replace(result.page, paper_size_mm=sizes.paper_size(arguments.paper)))
    result.check()
    return result


def given_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options that were given, as a settings file has them, but for the paper's size, which is a text here."""
    content: dict[str, Any] = {}
    for (*groups, name), declared in declared_options().items():
        value = getattr(arguments, declared.flag.strip("-").replace("-", "_"))
        if value is not None and declared.kind is not tuple:
            inside = content
            for group in groups:
                inside = inside.setdefault(group, {})
            inside[name] = str(value) if isinstance(value, Path) else value
    return content


class Progress:
    """How far a run is, on stderr: a bar on a terminal, otherwise a line for each tenth and each new text."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.is_terminal = stream.isatty()
        self.shown: tuple[int, str] = (-1, "")

    def __call__(self, fraction: float, text: str) -> None:
        percent = int(100 * fraction)
        if (percent, text) == self.shown:
            return
        if self.is_terminal:
            bar = "#" * (percent * 30 // 100)
            self.stream.write(f"\r[{bar:<30}] {percent:3d} %  {text[:60]}\x1b[K")
            self.stream.flush()
            self.shown = (percent, text)
        elif text != self.shown[1] or percent // 10 > self.shown[0] // 10:
            print(f"{percent:3d} %  {text}", file=self.stream, flush=True)
            self.shown = (percent, text)

    def end(self) -> None:
        """Leave the bar's line."""
        if self.is_terminal and self.shown != (-1, ""):
            self.stream.write("\n")
            self.stream.flush()


@contextlib.contextmanager
def stopping_on_signal() -> Iterator[threading.Event]:
    """An event that the first Ctrl-C (or a polite kill) sets; a second Ctrl-C ends the process where it stands."""
    stop = threading.Event()

    def note(number: int, _frame: object) -> None:
        stop.set()
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)


@contextlib.contextmanager
def telling_the_log(verbose: bool, stream: TextIO) -> Iterator[None]:
    """With ``verbose``, what goes into log.txt also goes to the screen."""
    if not verbose:
        yield
        return
    handler = logging.StreamHandler(stream)
    handler.setFormatter(logging.Formatter("%(message)s"))
    logger = logging.getLogger("origami")
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


def rectify(arguments: argparse.Namespace) -> int:
    """Do what the options say; errors come as exceptions."""
    errors, run, watch = module("core.errors"), module("origami_addon.run"), module("core.watch")
    settings = settings_from(arguments)
    if arguments.print_settings:
        print(module("origami_addon.settings_json").as_text(settings))
        return 0
    if not arguments.photos:
        raise errors.UsageError("No photos were named; give their folder: rectify.py PHOTOS -o OUT")
    if not arguments.output:
        raise errors.UsageError("No folder for the results was named; add -o OUT.")
    start_empty()
    progress = Progress(sys.stderr)
    chatter = contextlib.nullcontext() if arguments.verbose else without_blenders_chatter()
    with stopping_on_signal() as stop, telling_the_log(arguments.verbose, sys.stderr), chatter:
        try:
            report = run.rectify(
                [Path(path) for path in arguments.photos],
                Path(arguments.output),
                settings,
                watch.Watch((lambda fraction, text: None) if arguments.quiet else progress, stop.is_set),
                resume=arguments.resume,
                force=arguments.force,
                also_read=[
                    path for path in (arguments.settings, arguments.outline, arguments.creases) if path is not None
                ],
            )
        except errors.StepFailed as error:
            # Ctrl-C reaches the child processes too; their end is then no failure.
            if stop.is_set():
                raise errors.Cancelled("Stopped on request.") from error
            raise
        finally:
            progress.end()
    if not arguments.quiet:
        for warning in report.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        for name in report.outputs:
            if "/" not in name:
                print(f"Saved: '{Path(arguments.output) / name}'")
    return told_of_sheets(report, Path(arguments.output), quiet=arguments.quiet)


def told_of_sheets(report: Report, out: Path, *, quiet: bool) -> int:
    """Say of each sheet of a run of all of them what became of it; the exit code."""
    for number, sheet in enumerate(report.sheets, 1):
        if sheet["failure"]:
            print(f"error: {sheet['failure']}", file=sys.stderr)
        elif not quiet:
            steps = [step["figures"] for step in report.stages if step.get("sheet") == number]
            figures = {name: value for step in steps for name, value in step.items()}
            print(
                f"Sheet {number}: '{out / sheet['folder'] / 'page.tif'}', {figures['width_px']} x "
                f"{figures['height_px']} pixels, from {figures['reference']}, edge "
                f"{100 * figures['outline_confidence']:.0f} % sure"
            )
    return SOME_SHEETS_FAILED if any(sheet["failure"] for sheet in report.sheets) else 0


@contextlib.contextmanager
def without_blenders_chatter() -> Iterator[None]:
    """Keep off stdout what Blender and its exporters say there; they write past `sys.stdout`."""
    sys.stdout.flush()
    stdout = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        with contextlib.suppress(OSError, TypeError, AttributeError):  # Windows has no such handle, and buffers no line
            ctypes.CDLL(None).fflush(None)
        os.dup2(stdout, 1)
        os.close(stdout)
        os.close(nowhere)


def start_empty() -> None:
    """A Blender file with nothing in it, for the document alone, and the properties that the document has."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    module("origami_addon.scene.properties").register()


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code; never raises."""
    try:
        errors = module("core.errors")
        parser = build_parser()
    except Exception as error:
        if isinstance(error, ImportError) and (error.name or "").partition(".")[0] in DEPENDENCIES:
            print(
                f"This Python cannot load {error.name} ({error}); run `make demo` once, which makes .venv, and then "
                ".venv/bin/python headless/rectify.py; or install the extension in Blender, which brings it.",
                file=sys.stderr,
            )
            return USAGE_ERROR
        print(f"internal error: {type(error).__name__}: {error}; please report it", file=sys.stderr)
        return INTERNAL_ERROR
    try:
        return rectify(parser.parse_args(argv))
    except SystemExit as leaving:  # argparse's: 0 after --help, 2 after a wrong option
        return int(leaving.code or 0)
    except KeyboardInterrupt:
        return STOPPED
    except errors.OrigamiError as error:
        for warning in error.warnings if error.exit_code != STOPPED else ():
            print(f"warning: {warning}", file=sys.stderr)
        print(f"{'' if error.exit_code == STOPPED else 'error: '}{error}", file=sys.stderr)
        return int(error.exit_code)
    except Exception as error:
        logging.getLogger("origami").debug("internal error", exc_info=True)
        print(
            f"internal error: {type(error).__name__}: {error}; please report it together with log.txt", file=sys.stderr
        )
        return INTERNAL_ERROR


def command_line() -> list[str]:
    """The arguments meant for this script: under Blender those after ``--``."""
    if os.path.basename(sys.argv[0]) == Path(__file__).name:
        return sys.argv[1:]
    return sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []


if __name__ == "__main__":
    sys.exit(main(command_line()))
