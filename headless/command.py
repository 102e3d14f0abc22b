"""The command `rectify`: a whole run with the given options; its outcome is the exit code."""

from __future__ import annotations

import argparse
import contextlib
import logging
import sys
from collections.abc import Sequence
from pathlib import Path

import bpy

from ..core.errors import Cancelled, OrigamiError, StepFailed, UsageError
from ..core.watch import Watch
from ..origami_addon import run
from ..origami_addon.export.outputs import OTHER_LIGHT
from ..origami_addon.report import Report
from ..origami_addon.scene import properties
from ..origami_addon.settings import RunSettings
from ..origami_addon.settings_json import as_text
from ..origami_addon.stages import STAGES, about, of_option
from ..origami_addon.system_errors import system_errors_as_failures
from .options import build_parser, settings_from
from .terminal import (
    Progress,
    accept_every_letter,
    keep_quiet_at_exit,
    log_on_screen,
    say,
    stopping_on_signal,
    without_blenders_chatter,
)

INTERNAL_ERROR, SOME_SHEETS_FAILED, STOPPED = 3, 6, 130


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code; never raises."""
    accept_every_letter()
    try:
        return _outcome(argv)
    finally:
        keep_quiet_at_exit()


def _outcome(argv: Sequence[str]) -> int:
    try:
        with system_errors_as_failures():
            return _rectify(build_parser().parse_args(argv))
    except SystemExit as leaving:  # argparse's: 0 after --help, 2 after a wrong option
        return int(leaving.code or 0)
    except KeyboardInterrupt:
        return STOPPED
    except OrigamiError as error:
        for warning in error.warnings if error.exit_code != STOPPED else ():
            say(f"warning: {warning}")
        say(f"{'' if error.exit_code == STOPPED else 'error: '}{error}")
        return int(error.exit_code)
    except Exception as error:
        logging.getLogger("origami").debug("internal error", exc_info=True)
        say(f"internal error: {type(error).__name__}: {error}; please report it together with log.txt")
        return INTERNAL_ERROR


def _rectify(arguments: argparse.Namespace) -> int:
    """Do what the options say and return the exit code.

    Raises
    ------
    UsageError, UnusablePhotos, StepFailed, Cancelled
    """
    settings = settings_from(arguments)
    if arguments.print_settings:
        _print_settings(settings)
        return 0
    if not arguments.photos:
        raise UsageError("No photos were named; give their folder: rectify.py PHOTOS -o OUT")
    if not arguments.output:
        raise UsageError("No folder for the results was named; add -o OUT.")
    start_empty()
    progress = Progress(sys.stderr)
    chatter = contextlib.nullcontext() if arguments.verbose else without_blenders_chatter()
    with stopping_on_signal() as stop, log_on_screen(arguments.verbose, sys.stderr), chatter:
        try:
            report = run.rectify(
                [Path(path) for path in arguments.photos],
                Path(arguments.output),
                settings,
                Watch((lambda fraction, text: None) if arguments.quiet else progress, stop.is_set),
                recursive=arguments.recursive,
                other_photos=arguments.texture_from,
                resume=arguments.resume,
                force=arguments.force,
                stop_after=of_option(arguments.stop_after),
                also_read=[
                    path for path in (arguments.settings, arguments.outline, arguments.creases) if path is not None
                ],
            )
        except StepFailed as error:
            # Ctrl-C reaches the child processes too; their end is then no failure.
            if stop.is_set():
                raise Cancelled("Stopped on request.") from error
            raise
        finally:
            progress.end()
    if not arguments.quiet:
        for warning in report.warnings:
            say(f"warning: {warning}")
        for name in report.outputs:
            if "/" not in name or name.startswith(f"{OTHER_LIGHT}/"):
                say(f"Saved: '{Path(arguments.output) / name}'", sys.stdout)
        if report.stopped_after:
            _print_stopped(report)
    return _print_sheets(report, Path(arguments.output), quiet=arguments.quiet)


def _print_settings(settings: RunSettings) -> None:
    """Print the settings as JSON.

    Raises
    ------
    StepFailed
        If they could not be written; nothing happens if whatever reads them has ended.
    """
    try:
        print(as_text(settings), flush=True)
    except BrokenPipeError:
        pass
    except OSError as error:
        raise StepFailed(f"The settings could not be printed ({error.strerror}); print them elsewhere.") from error


def _print_stopped(report: Report) -> None:
    """Print what the last stage of a run found that stopped after it."""
    for stage in STAGES:
        if about(stage).reported == report.stopped_after:
            found = "; ".join(about(stage).summary(report.stages[-1]["figures"]))
            say(
                f"{about(stage).title}: {found}. Stopped here, as asked; the same command without --stop-after goes on."
            )


def _print_sheets(report: Report, out: Path, *, quiet: bool) -> int:
    """Print the outcome of each sheet of a `--sheet all` run and return the exit code."""
    for number, sheet in enumerate(report.sheets, 1):
        if sheet["failure"]:
            say(f"error: {sheet['failure']}")
        elif not quiet:
            steps = [step["figures"] for step in report.stages if step.get("sheet") == number]
            figures = {name: value for step in steps for name, value in step.items()}
            say(
                f"Sheet {number}: '{out / sheet['folder'] / 'page.tif'}', {figures['width_px']} x "
                f"{figures['height_px']} pixels, from {figures['reference']}, edge "
                f"{100 * figures['outline_confidence']:.0f} % sure",
                sys.stdout,
            )
    return SOME_SHEETS_FAILED if any(sheet["failure"] for sheet in report.sheets) else 0


def start_empty() -> None:
    """Open an empty Blender file for the document, and register the document's properties."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    properties.register()
