"""How a command for a document ended, written down."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


@pytest.fixture
def document(tmp_path: Path) -> Path:
    return tmp_path / "out" / "a document"


def recorded(scripts: dict[str, ModuleType], document: Path, code: str, *options: str) -> tuple[int, dict[str, Any]]:
    """The exit code, and what was written."""
    ended = scripts["record"].main([str(document), "place", *options, "--", sys.executable, "-c", code])
    (written,) = (document / "batch").glob("*.json")
    return ended, {"file": written.name, **json.loads(written.read_text(encoding="utf-8"))}


def test_a_command_that_does_well(scripts: dict[str, ModuleType], document: Path) -> None:
    report = {"stages": [{"name": "place photos", "seconds": 2.5, "cpu_seconds": 2.0, "figures": {}}]}
    writes = f"open({str(document / 'report.json')!r}, 'w').write({json.dumps(report)!r})"
    code, receipt = recorded(scripts, document, f"print('Ü'); sum(range(10**7)); {writes}")
    assert (code, receipt["file"]) == (0, "place.json")
    assert 0 < receipt["cpu_seconds"] < 30 and receipt["peak_memory_mb"] > 5
    assert receipt["stages"][0]["cpu_seconds"] == 2.0
    assert (document / "batch" / "place.log").read_text(encoding="utf-8") == "Ü\n"
    # The next command makes no report, so that one is no part of its costs.
    os.utime(document / "report.json", (1e9, 1e9))
    assert recorded(scripts, document, "pass")[1]["stages"] == []


@pytest.mark.parametrize(
    ("said", "exit_code", "sentence"),
    [
        ("error: No photo.", 4, "No photo."),
        ("warning: x\\nerror: One.\\nerror: Two.", 5, "Two."),
        ("usage: ...\\nrectify.py: error: argument --dpi: wrong", 2, "argument --dpi: wrong"),
        ("internal error: KeyError: 1; please report it", 3, "internal error: KeyError: 1; please report it"),
        ("Traceback\\nBoom", 1, "The run ended with exit code 1: Boom"),
        ("", 7, "The run ended with exit code 7: it printed nothing"),
    ],
)
def test_a_command_that_fails(
    scripts: dict[str, ModuleType], document: Path, said: str, exit_code: int, sentence: str
) -> None:
    code, failed = recorded(scripts, document, f"import sys; print('{said}', file=sys.stderr); sys.exit({exit_code})")
    assert (code, failed["exit_code"], failed["file"]) == (exit_code, exit_code, "place.failed.json")
    assert failed["sentence"].startswith(sentence)
    done, receipt = recorded(scripts, document, "pass")
    assert (done, receipt["file"]) == (0, "place.json")


def test_an_engine_that_tries_elsewhere_is_not_told_of_unusable_photos(
    scripts: dict[str, ModuleType], document: Path
) -> None:
    for exit_code, reported in ((4, 0), (3, 3)):
        code, failed = recorded(scripts, document, f"import sys; sys.exit({exit_code})", "--succeed-if-explained")
        assert (code, failed["exit_code"]) == (reported, exit_code)


def test_a_command_that_is_killed(scripts: dict[str, ModuleType], document: Path) -> None:
    code, failed = recorded(scripts, document, "import os; os.kill(os.getpid(), 9)")
    assert code == 137
    assert "memory" in failed["sentence"]


def test_a_command_that_is_not_there(scripts: dict[str, ModuleType], document: Path) -> None:
    assert scripts["record"].main([str(document), "place", "--", "/no/such/command"]) == 127
    failed = json.loads((document / "batch" / "place.failed.json").read_text())
    assert failed["sentence"] == "/no/such/command cannot be started (No such file or directory); check the path."


def test_blender_runs_it_too(root: Path, document: Path) -> None:
    # As Blender runs a script: the arguments are Blender's own, and those of the script come after --.
    blender = (
        "import sys; path = sys.argv[sys.argv.index('-P') + 1]; "
        "exec(compile(open(path).read(), path, 'exec'), {'__name__': '__main__', '__file__': path})"
    )
    script = root / "workflow" / "scripts" / "record.py"
    command = [sys.executable, "-c", blender, "-b", "-P", str(script), "--", str(document), "document", "--"]
    done = subprocess.run(
        [*command, sys.executable, "-c", "import sys; sys.exit(sys.argv[1:] != ['--', 'x'])", "--", "x"]
    )
    assert done.returncode == 0
    assert (document / "batch" / "document.json").exists()


def test_a_stop_is_no_failure(root: Path, document: Path) -> None:
    waits = (
        "import signal, sys, time; signal.signal(15, lambda *_: sys.exit(130)); print('on', flush=True); time.sleep(60)"
    )
    record = [sys.executable, str(root / "workflow" / "scripts" / "record.py"), str(document), "place", "--"]
    process = subprocess.Popen([*record, sys.executable, "-c", waits])
    log = document / "batch" / "place.log"
    for _ in range(200):
        if log.exists() and log.read_text() == "on\n":
            break
        time.sleep(0.05)
    else:
        pytest.fail("the command did not begin within ten seconds")
    os.kill(process.pid, signal.SIGTERM)
    assert process.wait(20) == 130
    assert [path.name for path in log.parent.iterdir()] == ["place.log"]
