"""The script that makes .venv, with faked Pythons: each problem is reported in one sentence."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

# A Python of a given version whose venv holds an interpreter that logs its calls and can be made to fail.
FAKE_PYTHON = """#!/bin/sh
case "$*" in
    *version_info*) echo {version} ;;
    *ensurepip*) {ensurepip} ;;
    "-m venv "*) mkdir -p "$3/bin"; cp "$FAKE_VENV_PYTHON" "$3/bin/python"; chmod +x "$3/bin/python" ;;
esac
"""
FAKE_VENV_PYTHON = """#!/bin/sh
case "$*" in
    *version_info*) echo {version} ;;
    "-m pip install"*) echo "$*" >> "{calls}"; {pip} ;;
    *"import bpy"*) {bpy} ;;
esac
"""


@dataclass
class Checkout:
    """A copy of the script in an empty checkout, and a PATH with only a shell's tools and fakes."""

    folder: Path
    fakes: Path
    calls: Path

    def fake(self, name: str, text: str) -> Path:
        path = self.fakes / name
        path.write_text(text)
        path.chmod(0o755)
        return path

    def python(
        self,
        version: str,
        name: str = "python3",
        *,
        ensurepip: str = "exit 0",
        pip: str = "exit 0",
        bpy: str = "exit 0",
    ) -> Path:
        inner = FAKE_VENV_PYTHON.format(version=version, calls=self.calls, pip=pip, bpy=bpy)
        (self.folder / "venv_python").write_text(inner)
        return self.fake(name, FAKE_PYTHON.format(version=version, ensurepip=ensurepip))

    def run(self, *lists: str, **environment: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["/bin/sh", str(self.folder / ".ci" / "environment.sh"), *lists],
            capture_output=True,
            text=True,
            env={
                "PATH": str(self.fakes),
                "HOME": str(self.folder),
                "FAKE_VENV_PYTHON": str(self.folder / "venv_python"),
                **environment,
            },
        )

    def installs(self) -> list[str]:
        return self.calls.read_text().splitlines() if self.calls.exists() else []


@pytest.fixture
def checkout(root: Path, tmp_path: Path) -> Checkout:
    shutil.copytree(root / ".ci", tmp_path / "checkout" / ".ci")
    fakes = tmp_path / "bin"
    fakes.mkdir()
    for tool in ("awk cat chmod cmp cp df dirname find grep head ln mkdir rm sed sh sort tail tr uname").split():
        (fakes / tool).symlink_to(shutil.which(tool) or "")
    return Checkout(tmp_path / "checkout", fakes, tmp_path / "calls")


def assert_one_sentence(done: subprocess.CompletedProcess[str], *words: str) -> None:
    assert done.returncode == 1
    lines = [line for line in done.stderr.splitlines() if not line.endswith("...")]
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0]


def test_makes_it_once_and_uses_it_again(checkout: Checkout) -> None:
    checkout.python("3.11", "python3.11")
    assert checkout.run().returncode == 0
    assert len(checkout.installs()) == 1
    assert checkout.run().returncode == 0
    assert len(checkout.installs()) == 1
    assert checkout.run(".ci/requirements-test.txt").returncode == 0
    assert checkout.run().returncode == 0
    assert len(checkout.installs()) == 2


def test_changed_pins_are_installed(checkout: Checkout) -> None:
    checkout.python("3.11", "python3.11")
    checkout.run()
    with (checkout.folder / ".ci" / "requirements.txt").open("a") as pins:
        pins.write("more==1\n")
    assert checkout.run().returncode == 0
    assert len(checkout.installs()) == 2


def test_a_shim_that_does_not_run_is_passed_over(checkout: Checkout) -> None:
    checkout.fake("python3.13", "#!/bin/sh\necho 'pyenv: python3.13: command not found' >&2\nexit 127\n")
    checkout.python("3.11", "python3")
    assert checkout.run().returncode == 0


def test_another_python(checkout: Checkout) -> None:
    checkout.python("3.12")
    assert_one_sentence(checkout.run(), "3.12", "3.11 or 3.13", "apt-get install", "PYTHON=")


def test_no_python(checkout: Checkout) -> None:
    assert_one_sentence(checkout.run(), "3.11 or 3.13", "apt-get install", "PYTHON=")


def test_a_named_python(checkout: Checkout) -> None:
    checkout.python("3.12")
    named = checkout.python("3.13", "my-python")
    assert checkout.run(PYTHON=str(named)).returncode == 0
    assert_one_sentence(checkout.run(PYTHON=str(checkout.fakes / "python3")), "3.12", "3.11 and 3.13")
    assert_one_sentence(checkout.run(PYTHON="/no/such/python"), "/no/such/python", "does not run")


def test_no_venv_module(checkout: Checkout) -> None:
    checkout.python("3.11", ensurepip="exit 1")
    assert_one_sentence(checkout.run(), "apt-get install python3.11-venv")


def test_too_little_room(checkout: Checkout) -> None:
    checkout.python("3.11")
    (checkout.fakes / "df").unlink()
    checkout.fake("df", "#!/bin/sh\necho Filesystem 1024-blocks Used Available\necho /dev/x 9 9 500000 9% /\n")
    assert_one_sentence(checkout.run(), "500 MB", "du -x")
    assert not checkout.installs()


@pytest.mark.parametrize(
    ("pip_says", "words"),
    [
        ("ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device", ("disk", "df -h")),
        (
            "WARNING: Retrying (Retry(total=0)) after connection broken by 'NewConnectionError(x)'\n"
            "ERROR: No matching distribution found for bpy==5.0.1",
            ("network", "HTTPS_PROXY"),
        ),
        ("ERROR: No matching distribution found for bpy==5.0.1", ("bpy==5.0.1", "Linux x86_64")),
        ("ERROR: something else", ("something else", "rm -rf")),
    ],
)
def test_pip_fails(checkout: Checkout, pip_says: str, words: tuple[str, ...]) -> None:
    said = checkout.folder / "said"
    said.write_text(pip_says + "\n")
    checkout.python("3.11", pip=f"cat {said}; exit 1")
    assert_one_sentence(checkout.run(), *words)
    # The next run does not mistake the half-made environment for a complete one.
    checkout.python("3.11")
    shutil.copy(checkout.folder / "venv_python", checkout.folder / ".venv" / "bin" / "python")
    assert checkout.run().returncode == 0


def test_missing_system_libraries(checkout: Checkout) -> None:
    error = "ImportError: libXrender.so.1: cannot open shared object file: No such file or directory"
    checkout.python("3.11", bpy=f"echo '{error}'; exit 1")
    assert_one_sentence(checkout.run(), "libXrender.so.1", "apt-get install libxrender1")

    folder = checkout.folder / ".venv" / "lib" / "bpy"
    folder.mkdir(parents=True)
    (folder / "__init__.so").touch()
    checkout.fake("ldd", "#!/bin/sh\nprintf '\\tlibSM.so.6 => not found\\n\\tlibXrender.so.1 => not found\\n'\n")
    assert_one_sentence(checkout.run(), "libsm6 libxrender1")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written(checkout: Checkout) -> None:
    checkout.python("3.11")
    checkout.folder.chmod(0o555)
    try:
        assert_one_sentence(checkout.run(), "cannot be written")
    finally:
        checkout.folder.chmod(0o755)
