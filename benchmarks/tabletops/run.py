"""Measure how well Origami finds the sheet on generated tables.

    .venv/bin/python benchmarks/tabletops/run.py -o out/tables
    .venv/bin/python benchmarks/tabletops/run.py -o out/tuning --seeds 1000-1059 --image-size 1000

Without --seeds these are the sixty scenes of the benchmark, 0 to 59, as in `make benchmark`; tune on 1000 to 1259
instead. Scenes and placed photos stay in the output folder, so measuring again after a change of the finder takes
seconds for each scene. Tables, json and a picture of each reference photo with the true outline (green) and the found
one (red) go there too.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from run import load_checkout, seeds_of, timed_print  # noqa: E402


def main(arguments: argparse.Namespace) -> int:
    """Measure, write and print; returns 1 if a scene crashed."""
    load_checkout()
    measure = importlib.import_module("origami.benchmarks.tabletops.measure")
    tables = measure.run(
        arguments.scenes or arguments.output / "scenes",
        arguments.output,
        arguments.seeds or measure.BENCHMARK_SEEDS,
        measure.settings_for(arguments.threads, arguments.image_size),
        timed_print(),
    )
    print("\n".join(table.markdown() for table in tables))
    return int(any(row["verdict"] == "crashed" for row in tables[-1].rows))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    parser.add_argument("--scenes", type=Path, metavar="DIR", help="the scenes; default: scenes in the output")
    parser.add_argument("--seeds", type=seeds_of, help="for example 1000-1059 or 3,7")
    parser.add_argument("--threads", type=int, help="of structure from motion")
    parser.add_argument("--image-size", type=int, help="long side of the photos in structure from motion")
    # By default, the libraries of each step compete for the cores.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main(parser.parse_args()))
