"""Builds the extension: for each platform and Python one zip in dist/, made and checked by Blender's own tool.

.venv/bin/python .ci/extension.py                       all of them
.venv/bin/python .ci/extension.py linux-x64-py313       only these
.venv/bin/python .ci/extension.py --repository          and the index that makes dist/ an extension repository

dist/ then holds only what this run built. The wheels for the zips are downloaded into wheels/ once. Each problem is
reported in one sentence; the exit code is then 1.
"""

from __future__ import annotations

import argparse
import errno
import hashlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = "blender_manifest.toml"
RUNTIME = ("CHANGELOG.md", "LICENSE", "README.md", "__init__.py", "core", "headless", "origami_addon")
# The manual built by `make docs`, and its place in a zip.
MANUAL, MANUAL_IN_ZIP = "out/docs", "docs"

# Values of a zip's manifest that differ from the checkout's; the maximum is the first version that is too new.
BLENDER_VERSIONS = {
    "3.11": {"blender_version_max": "5.1.0"},
    "3.13": {"blender_version_min": "5.1.0"},
    "3.14": {"blender_version_min": "5.1.0"},  # built by distributions with their own Python, as Debian does
}
WHEEL_PLATFORMS = {
    "linux-x64": r"manylinux.*_x86_64",
    "macos-arm64": r"macosx_.*_arm64",
    "windows-x64": r"win_amd64",
}
# A zip stores when its files were changed; with one date for all, the same checkout gives the same zip.
FILE_TIME = 315619200  # 1980-01-02, which in no time zone is before the first date that a zip can hold


class Failed(Exception):
    """A problem, with a sentence that says what to do."""


@dataclass(frozen=True)
class Target:
    """The target of one zip: a platform, in Blender's terms, and a Python."""

    platform: str
    python: str

    @property
    def name(self) -> str:
        """Its name in the zip's file name."""
        return f"{self.platform}-py{self.python.replace('.', '')}"


TARGETS = tuple(
    Target(platform, python)
    for platform, pythons in (
        ("linux-x64", ("3.11", "3.13", "3.14")),
        ("macos-arm64", ("3.11", "3.13")),
        ("windows-x64", ("3.11", "3.13")),
    )
    for python in pythons
)


@dataclass(frozen=True)
class Wheel:
    """A pinned wheel; its file name says what it is and where it runs."""

    sha256: str
    file_name: str

    @property
    def tags(self) -> list[str]:
        """Distribution, version, Python, ABI, platforms."""
        return self.file_name.removesuffix(".whl").split("-")

    def fits(self, target: Target) -> bool:
        """Whether it belongs in the zip for this target."""
        _, _, python, _, platforms = self.tags
        is_python = python == "cp" + target.python.replace(".", "")
        return is_python and re.fullmatch(WHEEL_PLATFORMS[target.platform], platforms) is not None


def pinned_wheels(root: Path = ROOT) -> list[Wheel]:
    """All wheels listed in `.ci/wheels.txt`."""
    lines = (root / ".ci" / "wheels.txt").read_text(encoding="utf-8").splitlines()
    return [Wheel(*line.split()) for line in lines if line and not line.startswith("#")]


def fetch(wheels: Iterable[Wheel], folder: Path) -> None:
    """Download the wheels into the folder; complete ones that are already there are not downloaded again."""
    folder.mkdir(exist_ok=True)
    for wheel in wheels:
        path = folder / wheel.file_name
        if path.exists() and sha256(path) == wheel.sha256:
            continue
        path.unlink(missing_ok=True)
        print(f"Fetching {wheel.file_name} ...", file=sys.stderr)
        download(wheel, folder)


def sha256(path: Path) -> str:
    """The hash of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def download(wheel: Wheel, folder: Path) -> None:
    """Have pip fetch exactly this file, from where pip is set up to look."""
    distribution, version, python, abi, platforms = wheel.tags
    with tempfile.TemporaryDirectory() as work:
        requirement = Path(work) / "requirement.txt"
        requirement.write_text(f"{distribution}=={version} --hash=sha256:{wheel.sha256}\n", encoding="utf-8")
        pip = [sys.executable, "-m", "pip", "download", "--disable-pip-version-check", "--no-input", "--retries", "2"]
        pip += ["--timeout", "60", "--no-deps", "--only-binary=:all:", "--require-hashes"]
        pip += ["--implementation", python[:2], "--python-version", python[2:], "--abi", abi]
        pip += [f"--platform={platform}" for platform in platforms.split(".")]
        done = subprocess.run([*pip, "-r", str(requirement), "-d", str(folder)], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(why_pip_failed(done.stdout + done.stderr, wheel))
    path = folder / wheel.file_name
    if not path.exists() or sha256(path) != wheel.sha256:
        raise Failed(f"pip fetched another file than the {wheel.file_name} of .ci/wheels.txt; correct the list.")


def why_pip_failed(output: str, wheel: Wheel) -> str:
    """The message for a failure of pip."""
    no_answer = r"NewConnectionError|NameResolutionError|Max retries|ConnectTimeout|ReadTimeout|ProxyError|SSLError"
    if os.strerror(errno.ENOSPC) in output:
        return full_disk()
    if re.search(no_answer + "|Network is unreachable|name resolution", output):
        return (
            f"{wheel.file_name} could not be fetched because the package index does not answer; connect this machine "
            "to the network (behind a proxy: export HTTPS_PROXY=http://host:port) and run this again."
        )
    if "DO NOT MATCH THE HASHES" in output:
        return (
            f"The package index has another {wheel.file_name} than .ci/wheels.txt pins; do not use it, and check "
            "which index pip uses (pip config list)."
        )
    if "No matching distribution found" in output:
        return (
            f"The package index has no {wheel.file_name}; check which index pip uses (pip config list), or copy the "
            "file into wheels/."
        )
    errors = [line for line in output.splitlines() if line.startswith("ERROR")] or ["it says nothing"]
    return f"pip could not fetch {wheel.file_name}: {errors[-1]}; fix that and run this again."


def full_disk() -> str:
    """The message for a full disk."""
    return (
        "The disk filled up; make room for 1 GB on the disk of the project and of the temporary files (df -h shows "
        "both; rm -rf ~/.cache/pip frees pip's cache), then run this again."
    )


def read_manifest(root: Path) -> dict[str, Any]:
    """The checkout's manifest."""
    return tomllib.loads((root / MANIFEST).read_text(encoding="utf-8"))


def manifest_for(manifest: dict[str, Any], target: Target, wheels: Iterable[Wheel], files: list[str]) -> dict[str, Any]:
    """The manifest of a zip.

    It names every file, because Blender packs named files in order, but a folder's files in the file system's order.
    """
    return {
        **manifest,
        **BLENDER_VERSIONS[target.python],
        "platforms": [target.platform],
        "wheels": [f"./wheels/{wheel.file_name}" for wheel in wheels],
        "build": {"paths": files},
    }


def as_toml(manifest: dict[str, Any]) -> str:
    """A manifest as text: texts and lists of texts, first at the top level and then in tables."""
    values = {key: value for key, value in manifest.items() if not isinstance(value, dict)}
    tables = {key: value for key, value in manifest.items() if isinstance(value, dict)}
    parts = ["".join(f"{key} = {json.dumps(value, indent=2)}\n" for key, value in values.items())]
    parts += [f"[{name}]\n{as_toml(table)}" for name, table in tables.items()]
    return "\n".join(parts)


def runtime_files(root: Path) -> dict[str, Path]:
    """The files in a zip besides the manifest and the wheels: their names in it, in order, and their paths."""
    if not (root / MANUAL / "index.html").is_file():
        raise Failed(f"The manual is not built; run `make docs`, which builds it in {MANUAL}.")
    tops = {name: root / name for name in RUNTIME} | {MANUAL_IN_ZIP: root / MANUAL}
    found: dict[str, Path] = {}
    for name, top in tops.items():
        for path in [top] if top.is_file() else top.rglob("*"):
            inside = Path(name) / path.relative_to(top)
            if path.is_file() and not any(part == "__pycache__" or part.startswith(".") for part in inside.parts):
                found[inside.as_posix()] = path
    return dict(sorted(found.items()))


def stage(root: Path, folder: Path, target: Target, wheels: Sequence[Wheel]) -> None:
    """Prepare the folder that Blender packs."""
    files = runtime_files(root)
    named = {f"wheels/{wheel.file_name}": root / "wheels" / wheel.file_name for wheel in wheels}
    for name, path in (files | named).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / name)
    manifest = as_toml(manifest_for(read_manifest(root), target, wheels, list(files)))
    (folder / MANIFEST).write_text(manifest, encoding="utf-8", newline="\n")
    for path in folder.rglob("*"):
        if path.is_file():
            path.chmod(0o644)
            os.utime(path, (FILE_TIME, FILE_TIME))


def build(root: Path, target: Target, wheels: Iterable[Wheel], output: Path) -> Path:
    """Make one zip, with the matching wheels in the checkout's wheels/."""
    manifest = read_manifest(root)
    path = output / f"{manifest['id']}-{manifest['version']}-{target.name}.zip"
    with tempfile.TemporaryDirectory(dir=output, prefix=".staged-") as folder:
        stage(root, Path(folder), target, [wheel for wheel in wheels if wheel.fits(target)])
        blender("build", *valid_tags(), "--source-dir", folder, "--output-filepath", str(path))
    blender("validate", *valid_tags(), str(path))
    return path


def write_index(output: Path) -> None:
    """Make the folder of zips a static extension repository: index.json for Blender, index.html for people.

    All zips are in one index, although two are for the same platform and Blender: Blender reads the Python of each from
    its wheels, writes it into the index, and offers a zip if platform, Blender and Python match. Overlaps are errors.
    """
    blender("server-generate", "--repo-dir", str(output), "--html")


def blender_scripts() -> Path:
    """The folder of Blender's scripts, in its Python module; no Blender is started."""
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        raise Failed(f"{sys.executable} has no Blender (bpy); run `make extension`, which sets up one that has.")
    return next(Path(spec.origin).parent.glob("*/scripts"))


def valid_tags() -> list[str]:
    """The option that passes Blender's tags to the tool, as `blender --command extension` does."""
    return ["--valid-tags", str(blender_scripts() / "modules" / "_bpy_internal" / "extensions" / "tags.py")]


def blender(*arguments: str) -> None:
    """Run a command of Blender's extension tool; its warnings count as errors."""
    tool = blender_scripts() / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    done = subprocess.run(
        [sys.executable, str(tool), *arguments], capture_output=True, text=True, env={**os.environ, "TZ": "UTC"}
    )
    said = done.stdout + done.stderr
    if os.strerror(errno.ENOSPC) in said:
        raise Failed(full_disk())
    if done.returncode != 0 or re.search(r"^(WARN|ERROR|FATAL_ERROR)\b", said, re.MULTILINE):
        raise Failed(f"Blender's {arguments[0]} refuses the extension: {' '.join(said.split())}")


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code."""
    targets = {target.name: target for target in TARGETS}
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(targets)} (default: all)")
    parser.add_argument("--repository", action="store_true", help="also write index.json and index.html")
    arguments = parser.parse_args(argv)
    unknown = sorted(set(arguments.names) - set(targets))
    if unknown:
        parser.error(f"there is no {', '.join(unknown)}; choose from {', '.join(targets)}")
    output = ROOT / "dist"
    try:
        wheels = pinned_wheels()
        chosen = [targets[name] for name in arguments.names or targets]
        fetch([wheel for wheel in wheels if any(wheel.fits(target) for target in chosen)], ROOT / "wheels")
        output.mkdir(exist_ok=True)
        for old in [*output.glob(f"{read_manifest(ROOT)['id']}-*.zip"), *output.glob("index.*")]:
            old.unlink()
        for target in chosen:
            path = build(ROOT, target, wheels, output)
            print(f"{path.stat().st_size / 1e6:6.1f} MB  {path.relative_to(ROOT)}", flush=True)
        if arguments.repository:
            write_index(output)
            print(f"           {(output / 'index.json').relative_to(ROOT)}")
    except (Failed, OSError) as error:
        full = isinstance(error, OSError) and error.errno == errno.ENOSPC
        print(full_disk() if full else f"{error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
