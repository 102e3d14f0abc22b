"""The command line on every set, in a separate process: time and memory of each stage, the score of its page."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from ..origami_addon.files.marker import MARKER
from ..origami_addon.settings_json import as_text
from . import page_error
from .cells import failure, page_figures
from .methods import DEFAULT, Method
from .photo_set import PhotoSet, read_image
from .scorer import Scorer
from .tables import Row
from .truth import Truth

RECTIFY = Path(__file__).resolve().parent.parent / "headless" / "rectify.py"
_STAGE_ENDS = re.compile(r"^(?P<name>[a-z ]+): (?P<seconds>[\d.]+) s, \{")
_POLL_SECONDS = 0.05
# The figures of the stage that places the photos.
_PLACED = "place_photos.json"
_MEBIBYTE = 2**20


@dataclass
class Effort:
    """The memory and processor time of a process and its children; other work on the machine does not change these.

    Linux only, elsewhere 0.
    """

    pid: int
    peak_bytes: int = 0
    processor_seconds: float = 0.0
    _counted_seconds: float = 0.0
    _stop: threading.Event = field(default_factory=threading.Event)

    def watch(self) -> None:
        """Measure until `stop`."""
        while not self._stop.wait(_POLL_SECONDS):
            family = _family(self.pid)
            self.peak_bytes = max(self.peak_bytes, sum(map(_resident_bytes, family)))
            # A child's time only counts as its parent's once the parent has waited for it.
            self.processor_seconds = max(self.processor_seconds, sum(map(_processor_seconds, family)))

    def stop(self) -> None:
        self._stop.set()

    def take(self) -> Row:
        """The peak in MiB and the processor's seconds since the last call."""
        peak, self.peak_bytes = self.peak_bytes, 0
        seconds, self._counted_seconds = self.processor_seconds - self._counted_seconds, self.processor_seconds
        return {"megabytes": peak / _MEBIBYTE, "processor_seconds": seconds}


def _family(pid: int) -> list[int]:
    children: list[str] = []
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            children += listed.read_text().split()
    return [pid, *(member for child in children for member in _family(int(child)))]


def _processor_seconds(pid: int) -> float:
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def _resident_bytes(pid: int) -> int:
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0
    resident = re.search(r"^VmRSS:\s+(\d+) kB", status, re.MULTILINE)
    return 1024 * int(resident[1]) if resident else 0


def run(photo_set: PhotoSet, runs: Path, method: Method, scorer: Scorer) -> list[Row]:
    """One row per stage and one for the whole, which has the page's score and the report's warnings.

    The default's run lies in a folder with the set's name, another method's beside it. Photos are placed once: a later
    benchmark into the same folder reuses the SfM model and its figures, and so do the other methods.

    Parameters
    ----------
    photo_set : PhotoSet
    runs : Path
        Folder for the runs of all sets.
    method : Method
        Its settings are given to the command line.
    scorer : Scorer
    """
    out = runs / photo_set.name
    if method is not DEFAULT:
        out = runs / f"{photo_set.name}, {method.name}"
        _share_placed(runs / photo_set.name, out)
    measured = out / _PLACED
    models = _placed_models(out)
    (out / "report.json").unlink(missing_ok=True)
    out.mkdir(parents=True, exist_ok=True)
    begun = time.perf_counter()
    settings = runs / f"{method.name}.json"
    settings.write_text(as_text(method.settings()), encoding="utf-8")
    stages, last_words, code = _rectify(photo_set, out, settings)
    seconds = time.perf_counter() - begun
    if models == _placed_models(out) and measured.is_file():
        kept = json.loads(measured.read_text())
        seconds += kept["seconds"]
        stages = [kept if stage["stage"] == kept["stage"] else stage for stage in stages]
    else:
        for stage in stages:
            if stage["stage"] == "place photos":
                measured.write_text(json.dumps(stage))
    total: Row = {"set": photo_set.name, "stage": "all", "seconds": seconds}
    total["megabytes"] = max((stage["megabytes"] for stage in stages), default=None)
    total["processor_seconds"] = sum(stage["processor_seconds"] for stage in stages)
    if code != 0:
        total["failure"] = f"exit code {code}: {last_words}"
        return [*stages, total]
    report = json.loads((out / "report.json").read_text())
    total |= {
        "warnings": report["warnings"],
        "figures": {stage["name"]: stage["figures"] for stage in report["stages"]},
    }
    try:
        if photo_set.is_rendered:
            total |= page_error.measure(Truth(photo_set.folder), page_error.read_source(out / "map.npz")).figures()
        total |= page_figures(scorer.page(photo_set.original, read_image(out / "page.tif")))
    except Exception as why:  # a page that cannot be scored is a result
        total |= failure(why)
    return [*stages, total]


def _placed_models(out: Path) -> set[Path]:
    return set((out / "work" / "sfm").glob("*/result.json"))


def _share_placed(source: Path, target: Path) -> None:
    """Take over the SfM model, and its figures, of another run of the same photos."""
    if (source / _PLACED).is_file() and not (target / _PLACED).is_file():
        shutil.copytree(source / "work" / "sfm", target / "work" / "sfm", dirs_exist_ok=True)
        # Without this, the command line takes them for files of the user's.
        shutil.copy(source / MARKER, target)
        shutil.copy(source / _PLACED, target)


def _rectify(photo_set: PhotoSet, out: Path, settings: Path) -> tuple[list[Row], str, int]:
    """Stages with their time and memory, the last line on stderr, and the exit code."""
    command = [sys.executable, RECTIFY, photo_set.photos, "-o", out, "--settings", settings, "--verbose"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    assert process.stderr is not None
    effort = Effort(process.pid)
    watcher = threading.Thread(target=effort.watch, daemon=True)
    watcher.start()
    stages: list[Row] = []
    last_words = ""
    for line in process.stderr:
        last_words = line.strip() or last_words
        if ends := _STAGE_ENDS.match(line):
            row = {"set": photo_set.name, "stage": ends["name"], "seconds": float(ends["seconds"])}
            stages.append(row | effort.take())
    code = process.wait()
    effort.stop()
    watcher.join()
    return stages, last_words, code
