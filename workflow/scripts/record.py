"""Run a command for a document of a batch, and write down how it ended and what it cost.

python workflow/scripts/record.py OUT/document place -- python headless/rectify.py PHOTOS -o OUT/document ...

In the folder `batch` of the document, it writes `place.log` with all that the command printed, and `place.json` if the
command did well or `place.failed.json`, with the command's own sentence, if it did not. The exit code is the command's.
It needs nothing but Python, so Blender's own will do: blender -b -P record.py -- OUT/document ...
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import Any

FOLDER = "batch"
STOPPED = 130
# The exit codes of `rectify.py` with which it says what is wrong with the photos or the options: no other computer
# would do better.
EXPLAINED = (2, 4, 5, 6)
_COSTS = ("name", "seconds", "cpu_seconds", "peak_memory_mb", "read_bytes", "written_bytes")
_ERROR = re.compile(r"(?:rectify\.py: )?((?:internal )?error): (.+)")


def main(argv: Sequence[str]) -> int:
    """Run the command; returns the exit code."""
    parser = argparse.ArgumentParser(description="Run a command for a document of a batch, and record how it ended.")
    parser.add_argument("document", type=Path, help="the folder of the document's results")
    parser.add_argument("name", help="of the step, for the names of the files")
    parser.add_argument(
        "--succeed-if-explained",
        action="store_true",
        help="exit with 0 if the command said what is wrong with the photos, for engines that try again elsewhere",
    )
    parser.epilog = "After these, -- and the command."
    own, command = list(argv), []
    if "--" in argv:
        own, command = own[: own.index("--")], own[own.index("--") + 1 :]
    given = parser.parse_args(own)
    if not command:
        parser.error("name the command after --")
    code = record(command, given.document, given.name)
    return 0 if given.succeed_if_explained and code in EXPLAINED else code


def record(command: Sequence[str], document: Path, name: str) -> int:
    """Run a command and write down how it ended; returns its exit code, or 128 and the signal that killed it."""
    folder = document / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    receipt, failed, log = (folder / f"{name}{ending}" for ending in (".json", ".failed.json", ".log"))
    for path in (receipt, failed):
        path.unlink(missing_ok=True)
    begun, earlier = time.time(), _costs_of_children()["cpu_seconds"]
    with log.open("wb") as lines:
        code = _run(command, lines)
    costs = {"seconds": round(time.time() - begun, 2), **_costs_of_children()}
    if costs["cpu_seconds"] is not None and earlier is not None:
        costs["cpu_seconds"] = round(costs["cpu_seconds"] - earlier, 2)
    if code == 0:
        _write(receipt, costs | {"stages": _stages(document, begun)})
    elif code != STOPPED:
        sentence = sentence_in(log.read_text("utf-8", "replace"), code, log)
        _write(failed, costs | {"exit_code": code, "sentence": sentence})
        print(f"{document.name}: {sentence}", file=sys.stderr)
    return code


def sentence_in(printed: str, code: int, log: Path) -> str:
    """The sentence with which a command failed, from what it printed."""
    said = [found for line in printed.splitlines() if (found := _ERROR.fullmatch(line.strip()))]
    if said:
        kind, sentence = said[-1].groups()
        return sentence if kind == "error" else f"{kind}: {sentence}"
    if code > 128:
        return (
            f"The run was ended from outside (signal {code - 128}), most likely because memory ran out; give it more, "
            "or run fewer documents at once, and run again."
        )
    last = printed.strip().splitlines()[-1:] or ["it printed nothing"]
    return f"The run ended with exit code {code}: {last[0].strip()} (all of it: {log})"


def _run(command: Sequence[str], lines: Any) -> int:
    """Run a command to its end; whoever asks this process to stop asks the command."""
    asked: list[int] = []
    process = None

    def pass_on(number: int, _frame: object) -> None:
        asked.append(number)
        if process is not None:
            process.send_signal(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, pass_on)
    environment = os.environ | {"PYTHONUTF8": "1"}
    try:
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=lines, stderr=subprocess.STDOUT, env=environment
        )
        if asked:
            process.send_signal(asked[-1])
        code = process.wait()
    except OSError as error:
        lines.write(f"error: {command[0]} cannot be started ({error.strerror}); check the path.\n".encode())
        return 127
    if asked:
        return STOPPED
    return code if code >= 0 else 128 - code


def _costs_of_children() -> dict[str, float | int | None]:
    """Processor time and the largest process of what this process started; None where the system does not report it."""
    try:
        import resource
    except ImportError:
        return {"cpu_seconds": None, "peak_memory_mb": None}
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    unit = 1_000_000 if sys.platform == "darwin" else 1000
    return {"cpu_seconds": round(used.ru_utime + used.ru_stime, 2), "peak_memory_mb": used.ru_maxrss // unit}


def _stages(document: Path, begun: float) -> list[dict[str, Any]]:
    """What the stages of a run that began at a given time cost, from its report; none if it made no report."""
    for name in ("work/stopped.json", "report.json"):
        try:
            if (document / name).stat().st_mtime < begun:
                continue
            report = json.loads((document / name).read_text(encoding="utf-8"))
            return [{key: stage.get(key) for key in _COSTS} for stage in report["stages"]]
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue
    return []


def _write(path: Path, content: dict[str, Any]) -> None:
    """Write a file completely or not at all."""
    unfinished = path.with_name(f".{path.name}-{uuid.uuid4().hex}")
    text = json.dumps(content, indent=1, ensure_ascii=False) + "\n"
    unfinished.write_text(text, encoding="utf-8", errors="backslashreplace")  # names of files need not be text
    os.replace(unfinished, path)


if __name__ == "__main__":
    under_blender = Path(sys.argv[0]).name != Path(__file__).name
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if under_blender else sys.argv[1:]))
