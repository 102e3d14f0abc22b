"""Builds the add-on's zip for a Blender, plays the scenes in its window, runs the add-on's tests in it, prints results.

.venv/bin/python tests/blender/run.py BLENDER [--only SCENE ...]

`--only suite` runs the tests alone.

BLENDER is the command that starts one, or the folder of a separate system with one inside (entered by chroot, which
needs root). Xvfb and ImageMagick must be there too. The exit code is 1 if anything fell short.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent.parent
HERE = Path(__file__).resolve().parent
OUT = ROOT / "out" / "blender"
WORK = Path("user", "extensions", ".user", "user_default", "origami", "work")
LOG = "blender.log"
RESULTS = ("pictures", "results.json", "screen.log", "install.log", LOG)
MANUAL = (
    *("panel_empty", "photos_dialog", "running", "finished"),
    *("step_photos", "step_placing", "step_sheet", "step_surface", "step_unwrap", "step_page", "step_quality"),
    *("step_export", "through_camera", "stretch", "unfold", "points_by_error", "outline_edit", "page_frame"),
    *("uv_editor", "unwrap_menu", "unwrap_dialog", "queue"),
)
SUITE = "suite"
_NEEDED_BY_TESTS = ("pytest", "iniconfig", "pluggy", "Pygments", "packaging", "pillow")
_LEFT_OUT = shutil.ignore_patterns(".*", "out", "dist", "wheels", "__pycache__")
# Python's output when a function called by Blender fails: in a panel, a poll, a handler, a timer.
_FAULT = re.compile(r"^.*Traceback \(most recent call last\):\n(?:[ \t].*\n)+(.*)", re.MULTILINE)
_PYTHON_OF = "import sys; print('python', '{}.{}'.format(*sys.version_info))"


class Blender:
    """The place of Blender: in this system, or in a folder with a separate system."""

    def __init__(self, given: str) -> None:
        folder = Path(given)
        self.system = folder.resolve() if (folder / "usr").is_dir() else None
        self.command = ["blender"] if self.system else shlex.split(given)

    def inside(self, path: Path) -> str:
        """A path as Blender sees it."""
        return str(path if self.system is None else Path("/") / path.relative_to(self.system))

    def scratch(self) -> Path:
        """A folder that Blender sees too."""
        return Path(tempfile.mkdtemp(prefix="origami-window-", dir=self.system and self.system / "tmp"))

    def run(self, *arguments: str, capture: bool = False) -> subprocess.CompletedProcess[str]:
        """Run a command where Blender is; in a folder, with /proc mounted for this run only."""
        command = list(arguments)
        if self.system is not None:
            enter = 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"'
            command = ["unshare", "--mount", "sh", "-c", enter, str(self.system), *command]
        return subprocess.run(command, capture_output=capture, text=True)

    def python(self) -> str:
        """The version of its Python, as 3.13."""
        done = self.run(*self.command, "--background", "--factory-startup", "--python-expr", _PYTHON_OF, capture=True)
        said = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("python ")]
        if not said:
            raise SystemExit(f"{' '.join(self.command)} does not run: {done.stdout[-500:]}{done.stderr[-500:]}")
        return said[0]


def extension_script() -> ModuleType:
    """`.ci/extension.py`."""
    spec = importlib.util.spec_from_file_location("extension_script", ROOT / ".ci" / "extension.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["extension_script"] = module
    spec.loader.exec_module(module)
    return module


def lay_out(folder: Path, python: str) -> None:
    """Put the zip, the photos and the scenes into the folder."""
    extension = extension_script()
    target = extension.Target("linux-x64", python)
    if target not in extension.TARGETS:
        raise SystemExit(f"There is no zip for Python {python}: use a Blender from 4.5 to 5.2.")
    wheels = [wheel for wheel in extension.pinned_wheels() if wheel.fits(target)]
    try:
        extension.fetch(wheels, ROOT / "wheels")
        extension.build(ROOT, target, wheels, folder).rename(folder / "extension.zip")
    except extension.Failed as error:
        raise SystemExit(str(error)) from error
    shutil.copytree(ROOT / "examples" / "trifold_letter", folder / "trifold_letter")
    draw_two_sheets(folder / "two_sheets")
    shutil.copytree(HERE, folder / "tests")


def draw_two_sheets(folder: Path) -> None:
    """Write photos of two sheets on a table, and the middles of the sheets in each photo."""
    sys.path += [str(ROOT / "tests"), str(ROOT / ".venv" / "packages")]
    drawn = importlib.import_module("table_scene")
    table = drawn.two_sheets()
    middles = np.column_stack([drawn.TWO_PLACES, (0.0, 0.0)])
    folder.mkdir()
    for camera, photo in zip(table.model.cameras, table.photos, strict=True):
        Image.fromarray(photo).save(folder / camera.name)
    shown = {camera.name: camera.project(middles).tolist() for camera in table.model.cameras}
    (folder / "middles.json").write_text(json.dumps(shown), encoding="utf-8")


def run_suite(blender: Blender, folder: Path, python: str) -> bool:
    """Run the add-on's tests inside Blender, without a window; whether all passed."""
    pinned = [
        line.split()[0]
        for listed in (ROOT / ".ci", ROOT / "benchmarks")
        for file in sorted(listed.glob("requirements*.txt"))
        for line in file.read_text(encoding="utf-8").splitlines()
        if line.partition("==")[0] in _NEEDED_BY_TESTS
    ]
    user = folder / "suite"
    modules = user / "scripts" / "modules"
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(modules)]
    for_blender = ["--python-version", python, "--only-binary", ":all:"]
    subprocess.run([*install, *for_blender, *dict.fromkeys(pinned)], check=True)
    shutil.copytree(ROOT, folder / "checkout", ignore=_LEFT_OUT)
    os.environ |= {"BLENDER_USER_RESOURCES": blender.inside(user), "TMPDIR": blender.inside(folder)}
    script = ["--python-exit-code", "1", "--python", blender.inside(folder / "tests" / "suite.py")]
    return (
        blender.run(*blender.command, "--background", *script, "--", blender.inside(folder / "checkout")).returncode
        == 0
    )


def print_results(results: dict, log: str) -> bool:
    """Print the results and Python's failures in Blender's log; returns whether everything is as it should be."""
    faults = _FAULT.findall(log)
    good = not results["too_long"] and not faults
    for scene in results["scenes"]:
        print(f"\n{scene['scene']} ({scene['seconds']} s)")
        for shown in scene["shown"]:
            good &= shown["holds"]
            print(f"  {'ok  ' if shown['holds'] else 'FAIL'}  {shown['what']}  {shown['value']}")
        if scene["wrong"]:
            good = False
            print(f"  FAIL  {scene['wrong']}")
    print(f"\nBlender's main thread, held by the add-on:\n{results['held']}")
    for line in results["too_long"]:
        print(f"  FAIL  too long: {line}")
    for line in faults:
        print(f"  FAIL  in Blender's log: {line}")
    return good


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("blender", metavar="BLENDER")
    parser.add_argument("--only", nargs="+", default=[], metavar="SCENE")
    parser.add_argument(
        "--work", type=Path, help="what an earlier run kept of long work, to go through the rest faster"
    )
    parser.add_argument("--manual", action="store_true", help="put the manual's pictures into docs/pictures")
    parser.add_argument("--keep", action="store_true", help="keep the folder that Blender worked in")
    arguments = parser.parse_args(argv)
    blender = Blender(arguments.blender)
    folder = blender.scratch()
    passed = True
    try:
        python = blender.python()
        lay_out(folder, python)
        if SUITE in arguments.only or not arguments.only:
            passed = run_suite(blender, folder, python)
        if arguments.only == [SUITE]:
            return 0 if passed else 1
        if arguments.work:
            shutil.copytree(arguments.work, folder / WORK)
        os.environ["SCENES"] = " ".join(name for name in arguments.only if name != SUITE)
        script = folder / "tests" / "window.sh"
        blender.run("sh", blender.inside(script), blender.inside(folder), *blender.command)
        shutil.rmtree(OUT, ignore_errors=True)
        OUT.mkdir(parents=True)
        for source, name in ((folder / WORK, "work"), *((folder / name, name) for name in RESULTS)):
            if source.is_dir():
                shutil.copytree(source, OUT / name)
            elif source.exists():
                shutil.copy(source, OUT / name)
    finally:
        if not arguments.keep:
            shutil.rmtree(folder, ignore_errors=True)
    if arguments.manual:
        for picture in MANUAL:
            shutil.copy(OUT / "pictures" / f"{picture}.png", ROOT / "docs" / "pictures")
    if not (OUT / "results.json").exists():
        print("Blender's window ended before the scenes did", file=sys.stderr)
        return 1
    results = json.loads((OUT / "results.json").read_text(encoding="utf-8"))
    return 0 if print_results(results, (OUT / LOG).read_text("utf-8", "replace")) and passed else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
