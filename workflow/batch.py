"""A batch on this machine: Snakemake with this workflow, and one batch at a time in a folder of results.

.venv-batch/bin/python workflow/batch.py DOCUMENTS OUT [options of Snakemake, such as --config paper=A4 dpi=300]

The state of the engine lies in OUT/.snakemake, so a batch that was stopped in any way goes on with the same command.
"""

from __future__ import annotations

import fcntl
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WRONG_USAGE, STOPPED = 2, 130
# How much of the machine's memory the documents that run at once may take together.
_SHARE_OF_MEMORY = 0.8
_LOCK, _STATE = ".batch-lock", ".snakemake"


class Refused(Exception):
    """The batch cannot begin; the message is a sentence."""


def main(argv: Sequence[str]) -> int:
    """Run the batch; returns the exit code: 0 if all documents are done, 1 if not."""
    if len(argv) < 2 or any(name.startswith("--") for name in argv[:2]):
        print(__doc__, file=sys.stderr)
        return WRONG_USAGE
    documents, out, options = Path(argv[0]).absolute(), Path(argv[1]).absolute(), list(argv[2:])
    try:
        _check(documents, out)
        with _only_batch_in(out):
            return _run(documents, out, options)
    except Refused as refused:
        print(f"error: {refused}", file=sys.stderr)
        return WRONG_USAGE


def _check(documents: Path, out: Path) -> None:
    if not documents.exists():
        raise Refused(f"There is no folder or table {documents}; check the path.")
    inside = out.resolve().parents
    if documents.resolve() == out.resolve():
        raise Refused(f"{out} is the folder of the documents; choose another for the results.")
    if documents.resolve() in inside[1:]:
        raise Refused(f"{out} lies inside a document's folder; choose a folder for the results beside {documents}.")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refused(f"{out} cannot be used for the results ({error.strerror}); choose another folder.") from error


@contextmanager
def _only_batch_in(out: Path) -> Iterator[None]:
    """Hold the folder; the system lets go of it when this process ends, however that happens.

    Raises
    ------
    Refused
    """
    try:
        with (out / _LOCK).open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield
    except BlockingIOError:
        raise Refused(f"Another batch is writing into {out}; wait for its end, or choose another folder.") from None
    except PermissionError as error:
        raise Refused(f"{out} cannot be written ({error.strerror}); choose another folder.") from error


def _run(documents: Path, out: Path, options: Sequence[str]) -> int:
    state = out / _STATE
    state.mkdir(exist_ok=True)
    (state / "batch.json").write_text(json.dumps({"documents": str(documents), "out": str(out)}), encoding="utf-8")
    snakemake = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "workflow" / "Snakefile")]
    snakemake += ["--profile", str(ROOT / "profiles" / "local"), "--directory", str(out)]
    snakemake += ["--configfile", str(ROOT / "config" / "config.yaml"), str(state / "batch.json")]
    memory_mb = _SHARE_OF_MEMORY * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e6
    snakemake += ["--resources", f"mem_mb={memory_mb:.0f}"]
    # The engine's own lock outlives a batch that was killed; this process holds one that does not.
    if any((state / "locks").glob("*")):
        subprocess.run([*snakemake, "--unlock"], check=False, capture_output=True)
    summary, begun = out / "summary.html", time.time()
    engine = subprocess.Popen([*snakemake, *options])
    while True:
        try:
            code = engine.wait()
            break
        except KeyboardInterrupt:  # the engine has it too, and ends when its jobs have
            continue
    if code > 0 and summary.exists() and summary.stat().st_mtime >= begun:
        print(f"Not all documents are done; {summary} lists them with their reasons.", file=sys.stderr)
    return STOPPED if code < 0 else code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
