"""Generate photos of sheets on tables, with the exact outline of the sheet in every photo.

    .venv/bin/python benchmarks/tabletops/generate.py --seeds 0-59 --out DIR

A seed gives the same folder every time: photos/, truth.json and contact.jpg, about 1 s for each photo. The benchmark
measures on the seeds 0 to 59; tune on others, 1000 to 1259, so that its figures describe tables that nobody tuned for.
Sixty seeds in a row have each kind of table four times, and each kind of sheet at least eight times.

    .venv/bin/python benchmarks/tabletops/generate.py --seeds 1000-1059 --change moved --out DIR

With --change the later photos show the sheet moved on the table by 3 to 30 mm and 1 to 5 degrees, or its bends more or
less by 4 to 14 degrees; books and crossing folds are left out.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from run import load_checkout, seeds_of  # noqa: E402


def main(arguments: argparse.Namespace) -> None:
    """Write the scenes, one after the other."""
    load_checkout()
    changed, files = (importlib.import_module(f"origami.benchmarks.tabletops.{name}") for name in ("changed", "files"))
    scene = importlib.import_module("origami.benchmarks.tabletops.scene")
    for seed in arguments.seeds:
        begun = time.perf_counter()
        table, sheet = scene.kinds(seed)
        if arguments.change and sheet not in changed.SHEETS:
            continue
        files.write(seed, arguments.out / f"{seed:04d}", change=arguments.change)
        print(f"{seed:04d}: {sheet} on {table}, {time.perf_counter() - begun:.1f} s", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, required=True, help="for example 0-59 or 3,7")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="each scene gets a folder in it")
    parser.add_argument("--change", choices=("moved", "bent"), default="", help="between the photos")
    main(parser.parse_args())
