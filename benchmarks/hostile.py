"""Mutated inputs under a limit of memory and time: no internal error, no hang.

    python benchmarks/hostile.py [--count N] [--seed S] [--only photos|model|settings|kept|kills] [--photos FOLDER]

Each round mutates one thing with a seed of its own: bytes of a photo, of a COLMAP model, of a settings file or of what
a run left are flipped, cut out, repeated or cut off; or a run is killed at a random time and resumed. A round that
fails prints its seed, with which `--seed S --count 1` repeats it. The exit code is the number of rounds that failed.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "examples" / "trifold_letter"
MOST_BYTES = 4 << 30  # of addresses
MOST_SECONDS = 60.0
ALLOWED = (0, 2, 4, 5)
SETTINGS = {"sfm": {"seed": 1, "threads": 1}, "page": {"paper_size_mm": [210, 297]}, "image": {"dpi": 50}}


def mutated(content: bytes, random: np.random.Generator) -> bytes:
    """A file's content with one to four changes."""
    changed = bytearray(content)
    for _ in range(random.integers(1, 5)):
        at, length = (int(random.integers(0, most)) for most in (max(len(changed), 1), 64))
        kind = random.integers(0, 5)
        if kind == 0 and changed:
            changed[at] ^= 1 << int(random.integers(0, 8))
        elif kind == 1:
            changed[at : at + length] = random.bytes(length)
        elif kind == 2:
            changed[at : at + length] = b""
        elif kind == 3:
            changed[at:at] = changed[at : at + length] * int(random.integers(1, 9))
        else:
            del changed[at:]
    return bytes(changed)


def mutate(path: Path, random: np.random.Generator) -> None:
    path.write_bytes(mutated(path.read_bytes(), random))


def command(*arguments: object) -> list[str]:
    """The command line, limited."""
    run = f"import runpy, sys; sys.argv = sys.argv[1:]; runpy.run_path({str(ROOT / 'headless/rectify.py')!r}, "
    return limited(run + "run_name='__main__')", "rectify.py", *arguments)


def limited(script: str, *arguments: object) -> list[str]:
    """A Python script under the limit of memory, which only Linux enforces."""
    limit = f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({MOST_BYTES}, {MOST_BYTES}))\n"
    return [sys.executable, "-c", (limit if sys.platform == "linux" else "") + script, *map(str, arguments)]


def outcome(*arguments: object, seconds: float = MOST_SECONDS) -> str:
    """What is wrong with a run; empty if nothing is."""
    return ended(command(*arguments, "-q"), seconds)


def ended(process: list[str], seconds: float = MOST_SECONDS) -> str:
    """What is wrong with how a process ends; empty if nothing is."""
    try:
        done = subprocess.run(process, capture_output=True, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return f"no end within {seconds:.0f} s"
    if done.returncode in ALLOWED and "Traceback" not in done.stderr:
        return ""
    return f"exit code {done.returncode}: {done.stderr[-400:]}"


def photos_round(folder: Path, source: Path, random: np.random.Generator) -> str:
    """Mutates one of three photos; with two left, the run ends once all are read."""
    for path in sorted(source.iterdir())[:3]:
        shutil.copy(path, folder)
    mutate(sorted(folder.iterdir())[0], random)
    (folder / "out").mkdir()
    return outcome(folder, "-o", folder / "out", "--reference", "no such photo")


def settings_round(folder: Path, source: Path, random: np.random.Generator) -> str:
    """Mutates a settings file."""
    (folder / "settings.json").write_text(json.dumps(SETTINGS))
    mutate(folder / "settings.json", random)
    return outcome(source, "-o", folder / "out", "--settings", folder / "settings.json", "--reference", "no such photo")


def model_round(folder: Path, source: Path, random: np.random.Generator) -> str:
    """Mutates a file of a COLMAP model of the photos, binary or text."""
    kind = ("bin", "txt")[int(random.integers(0, 2))]
    shutil.copytree(made_once("model", source) / kind, folder / "model")
    paths = sorted((folder / "model").iterdir())
    mutate(paths[int(random.integers(0, len(paths)))], random)
    script = (
        "import runpy; from pathlib import Path; "
        f"runpy.run_path({str(ROOT / 'headless/checkout.py')!r})['load_checkout']()\n"
        "from origami.core.errors import OrigamiError\n"
        "from origami.origami_addon.files.photos import gather\n"
        "from origami.origami_addon.sfm.colmap_model import load_model\n"
        f"photos = gather({str(source)!r})[0]\n"
        f"try: load_model(Path({str(folder / 'model')!r}), photos, Path({str(folder / 'work')!r}))\n"
        "except OrigamiError as error: raise SystemExit(error.exit_code)"
    )
    return ended(limited(script))


def kept_round(folder: Path, source: Path, random: np.random.Generator) -> str:
    """Mutates a file that a finished run left, and resumes; the page must be the same."""
    finished = made_once("run", source)
    out = folder / "out"
    shutil.copytree(finished, out)
    paths = sorted(path for path in out.rglob("*") if path.is_file() and path.name not in ("log.txt", ".origami"))
    path = paths[int(random.integers(0, len(paths)))]
    mutate(path, random)
    wrong = outcome(source, "-o", out, "--resume", "--threads", 1, seconds=10 * MOST_SECONDS)
    refused = not (out / "report.json").exists() or path.name in ("report.json", "outline.json", "creases.json")
    if wrong or refused:
        return wrong and f"{path.relative_to(out)}: {wrong}"
    same = (out / "page.tif").read_bytes() == (finished / "page.tif").read_bytes()
    return "" if same else f"{path.relative_to(out)}: another page"


def kills_round(folder: Path, source: Path, random: np.random.Generator) -> str:
    """Kills a run at a random time, and resumes; the page must be the same as without."""
    finished, out = made_once("run", source), folder / "out"
    seconds = json.loads((finished / "report.json").read_text())["seconds"]
    with subprocess.Popen(command(source, "-o", out, "--threads", 1, "-q"), stderr=subprocess.DEVNULL) as process:
        time.sleep(float(random.uniform(0, 1.2 * seconds)))
        process.kill()
    wrong = outcome(source, "-o", out, "--resume", "--threads", 1, seconds=20 * MOST_SECONDS)
    if wrong:
        return wrong
    return "" if (out / "page.tif").read_bytes() == (finished / "page.tif").read_bytes() else "another page"


ROUNDS: dict[str, Callable[[Path, Path, np.random.Generator], str]] = {
    "photos": photos_round,
    "settings": settings_round,
    "model": model_round,
    "kept": kept_round,
    "kills": kills_round,
}
_made: dict[str, Path] = {}
_SCRATCH = tempfile.TemporaryDirectory(prefix="origami-hostile-")


def made_once(what: str, source: Path) -> Path:
    """A finished run of the photos, or a COLMAP model of them as binary and text."""
    if what in _made:
        return _made[what]
    folder = Path(_SCRATCH.name) / what
    if what == "run":
        subprocess.run(command(source, "-o", folder, "--threads", 1, "-q"), check=True)
    else:
        subprocess.run(
            [sys.executable, "-c", _MODEL, str(folder), *map(str, sorted(source.iterdir()))],
            capture_output=True,
            check=True,
        )
    _made[what] = folder
    return folder


_MODEL = """
import sys, pathlib, numpy as np, pycolmap
from PIL import Image
folder, *photos = map(pathlib.Path, sys.argv[1:])
database, placed = folder / "database.db", folder / "placed"
placed.mkdir(parents=True)
pycolmap.extract_features(database, photos[0].parent, camera_mode=pycolmap.CameraMode.SINGLE)
pycolmap.match_exhaustive(database)
model = pycolmap.incremental_mapping(database, photos[0].parent, placed)[0]
for kind in ("bin", "txt"):
    (folder / kind).mkdir()
model.write_binary(folder / "bin")
model.write_text(folder / "txt")
"""


def main() -> int:
    """Run the rounds; returns how many failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10, help="rounds of each kind")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first round")
    parser.add_argument("--only", choices=ROUNDS, help="one kind")
    parser.add_argument("--photos", type=Path, default=EXAMPLE)
    arguments = parser.parse_args()
    failed = 0
    for kind in [arguments.only] if arguments.only else ROUNDS:
        for seed in range(arguments.seed, arguments.seed + arguments.count):
            with tempfile.TemporaryDirectory(dir=_SCRATCH.name) as folder:
                wrong = ROUNDS[kind](Path(folder), arguments.photos, np.random.default_rng(seed))
            if wrong:
                failed += 1
                print(f"{kind}, seed {seed}: {wrong}", flush=True)
        print(f"{kind}: {arguments.count} rounds", flush=True)
    return failed


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
