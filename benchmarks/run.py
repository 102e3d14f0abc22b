"""Measure Origami on photo sets whose flat original is known, on synthetic sheets, and on generated tables.

    .venv/bin/python benchmarks/run.py ../shared/data -o out/benchmark

DATA holds photo sets: folders with photos/ and gt.png, and for rendered scenes gt_mesh.npz and scene.json. Into the
output folder go tables (markdown, csv, json), plots, and the page images. If ../tools/score is beside DATA, its scorers
are used.
"""

from __future__ import annotations

import argparse
import importlib
import os
import runpy
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PARTS = ("runs", "light", "cells", "ablation", "sweep", "tables")

load_checkout = runpy.run_path(str(ROOT / "headless" / "checkout.py"))["load_checkout"]


def seeds_of(text: str) -> list[int]:
    """``0-3,7`` as 0, 1, 2, 3, 7."""
    ends = [part.split("-") for part in text.split(",")]
    return [seed for end in ends for seed in range(int(end[0]), int(end[-1]) + 1)]


def timed_print() -> Callable[[str], None]:
    """A function that prints sentences with the seconds since this call."""
    begun = time.perf_counter()

    def say(text: str) -> None:
        print(f"{time.perf_counter() - begun:6.0f} s  {text}", file=sys.stderr, flush=True)

    return say


def main(arguments: argparse.Namespace) -> int:
    """Measure, write and print; returns 1 if a cell failed that is not a baseline."""
    load_checkout()
    report = importlib.import_module("origami.benchmarks.report")
    return report.measure(
        arguments.data,
        arguments.output,
        parts=arguments.only,
        names=arguments.sets,
        quick=arguments.quick,
        say=timed_print(),
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, nargs="?", default=ROOT.parent / "shared" / "data", metavar="DATA")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "benchmark", metavar="DIR")
    parser.add_argument("--sets", nargs="+", metavar="NAME", help="only these photo sets")
    parser.add_argument(
        "--only",
        nargs="+",
        choices=PARTS,
        default=PARTS,
        help="runs: the command line on every set, with time and memory; light: how the page looks beside its "
        "original; cells: every method on every set; "
        "ablation: the default without each of its parts; sweep: synthetic points; tables: the sheet's outline on "
        "generated tables",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="only the default and its baselines; the sweep with 2000 points; a quarter of the tables",
    )
    # If Blender runs this file, its own arguments come before the two dashes.
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    # By default, the libraries of each step compete for the cores.
    os.environ.setdefault("OMP_NUM_THREADS", str(min(os.cpu_count() or 1, 2)))
    sys.exit(main(parser.parse_args(given)))
