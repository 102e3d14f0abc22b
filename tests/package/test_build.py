"""The zips of the extension: their content, Blender's check of them, and the download of their wheels."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest

# A user's Blender, and the zip that it must be offered; None if there is none.
BLENDERS = [
    ((4, 5, 0), (3, 11, 7), "linux-x64", "linux-x64-py311"),
    ((5, 0, 1), (3, 11, 13), "macos-arm64", "macos-arm64-py311"),
    ((5, 1, 0), (3, 13, 1), "windows-x64", "windows-x64-py313"),
    ((5, 2, 3), (3, 13, 9), "linux-x64", "linux-x64-py313"),
    ((5, 2, 2), (3, 14, 10), "linux-x64", "linux-x64-py314"),
    ((5, 2, 3), (3, 13, 9), "macos-arm64", "macos-arm64-py313"),
    ((5, 0, 1), (3, 11, 13), "windows-x64", "windows-x64-py311"),
    ((5, 1, 0), (3, 11, 13), "linux-x64", None),
    ((4, 4, 3), (3, 11, 11), "linux-x64", None),
    ((5, 2, 3), (3, 13, 9), "linux-arm64", None),
]


@pytest.fixture(scope="session")
def checkout(root: Path, extension: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkout with stand-ins for the wheels, and with files that must not go into a zip."""
    folder = tmp_path_factory.mktemp("checkout")
    for name in (*extension.RUNTIME, ".ci", "blender_manifest.toml", "Makefile", "pyproject.toml"):
        (shutil.copytree if (root / name).is_dir() else shutil.copy)(root / name, folder / name)
    (folder / extension.MANUAL / "_static").mkdir(parents=True)
    for name in ("index.html", "_static/manual.css"):
        (folder / extension.MANUAL / name).write_text("a page")
    for name in (
        f"{extension.MANUAL}/.buildinfo",
        "docs/index.md",
        "core/__pycache__/x.pyc",
        "core/.hidden",
        "tests/test_x.py",
        "notes.txt",
        "origami-0.0.1.zip",
    ):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("not for users")
    (folder / "wheels").mkdir()
    for wheel in extension.pinned_wheels():
        (folder / "wheels" / wheel.file_name).write_text(wheel.file_name)
    return folder


@pytest.fixture(scope="session")
def zips(checkout: Path, extension: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A zip for each target."""
    output = tmp_path_factory.mktemp("dist")
    wheels = extension.pinned_wheels()
    return {target.name: extension.build(checkout, target, wheels, output) for target in extension.TARGETS}


def test_every_pinned_wheel_is_for_one_zip_by_blenders_reading_too(extension: Any, blenders_tool: Any) -> None:
    for wheel in extension.pinned_wheels():
        (target,) = (target for target in extension.TARGETS if wheel.fits(target))
        assert blenders_tool.blender_platforms_from_wheel_platform(wheel.tags[-1]) == [target.platform]
        assert blenders_tool.python_versions_from_wheel(wheel.file_name) == {
            tuple(int(part) for part in target.python.split("."))
        }


def test_every_zip_brings_scipy_and_pycolmap_as_a_run_has_them(root: Path, extension: Any) -> None:
    pins = (root / ".ci" / "requirements.txt").read_text().split()
    for target in extension.TARGETS:
        wheels = sorted(wheel.tags[:2] for wheel in extension.pinned_wheels() if wheel.fits(target))
        assert [name for name, _ in wheels] == ["pycolmap", "scipy"]
        assert {f"{name}=={version}" for name, version in wheels} <= set(pins)


def test_a_zip_holds_what_runs_and_nothing_else(root: Path, extension: Any, zips: dict[str, Path]) -> None:
    for target in extension.TARGETS:
        with zipfile.ZipFile(zips[target.name]) as archive:
            names = archive.namelist()
            assert len(set(names)) == len(names)
            wheels = {f"wheels/{wheel.file_name}" for wheel in extension.pinned_wheels() if wheel.fits(target)}
            assert {name for name in names if name.startswith("wheels/")} == wheels
            for name in wheels:
                assert archive.read(name).decode() == Path(name).name
            own = set(names) - wheels
        assert {Path(name).parts[0] for name in own} == {*extension.RUNTIME, "blender_manifest.toml", "docs"}
        assert {name for name in own if name.startswith("docs/")} == {"docs/index.html", "docs/_static/manual.css"}
        sources = {
            path.relative_to(root).as_posix()
            for folder in ("core", "headless", "origami_addon")
            for path in (root / folder).rglob("*.py")
        }
        assert sources <= own
        assert not [name for name in own if "__pycache__" in name or "/." in name]


def test_the_manifest_of_a_zip_is_the_checkouts_but_for_where_it_runs(
    root: Path, extension: Any, zips: dict[str, Path]
) -> None:
    ours = tomllib.loads((root / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert "wheels" not in ours
    assert "platforms" not in ours
    for target in extension.TARGETS:
        path = zips[target.name]
        assert path.name == f"origami-{ours['version']}-{target.name}.zip"
        with zipfile.ZipFile(path) as archive:
            theirs = tomllib.loads(archive.read("blender_manifest.toml").decode())
        assert theirs["platforms"] == [target.platform]
        for key in ("platforms", "wheels", "build", "blender_version_min", "blender_version_max"):
            theirs.pop(key, None)
        assert theirs == {key: ours[key] for key in ours.keys() - {"build", "blender_version_min"}}


def test_the_same_checkout_gives_the_same_zip(
    checkout: Path, extension: Any, zips: dict[str, Path], tmp_path: Path
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(checkout, copy)
    for path in copy.rglob("*"):
        path.touch()
    (copy / "core" / "camera.py").chmod(0o600)
    target = extension.TARGETS[0]
    again = extension.build(copy, target, extension.pinned_wheels(), tmp_path)
    assert again.read_bytes() == zips[target.name].read_bytes()


def test_a_checkout_packed_by_hand_holds_the_same_but_for_the_manual(
    checkout: Path, extension: Any, zips: dict[str, Path], tmp_path: Path
) -> None:
    path = tmp_path / "by_hand.zip"
    extension.blender("build", "--source-dir", str(checkout), "--output-filepath", str(path))
    with zipfile.ZipFile(path) as by_hand, zipfile.ZipFile(zips["linux-x64-py313"]) as ours:
        in_checkout = {name for name in ours.namelist() if not name.startswith(("wheels/", "docs/"))}
        assert set(by_hand.namelist()) - {"notes.txt"} == in_checkout


def test_no_zip_without_the_manual(checkout: Path, extension: Any, tmp_path: Path) -> None:
    bare = tmp_path / "bare"
    shutil.copytree(checkout, bare, ignore=shutil.ignore_patterns("out"))
    with pytest.raises(extension.Failed, match="make docs"):
        extension.build(bare, extension.TARGETS[0], extension.pinned_wheels(), tmp_path)


def test_what_blender_refuses_is_an_error(checkout: Path, extension: Any, tmp_path: Path) -> None:
    broken = tmp_path / "broken"
    shutil.copytree(checkout, broken)
    manifest = broken / "blender_manifest.toml"
    manifest.write_text(manifest.read_text().replace('"UV"', '"Paper"'))
    with pytest.raises(extension.Failed, match=r"build refuses .*Paper"):
        extension.build(broken, extension.TARGETS[0], extension.pinned_wheels(), tmp_path)


def test_one_repository_offers_each_blender_the_zip_that_fits(
    extension: Any, blenders_tool: Any, zips: dict[str, Path]
) -> None:
    folder = next(iter(zips.values())).parent
    extension.write_index(folder)
    assert (folder / "index.html").exists()
    offers = json.loads((folder / "index.json").read_text())["data"]
    assert len(offers) == len(extension.TARGETS)
    for blender, python, platform, expected in BLENDERS:
        fitting = [
            offer["archive_url"]
            for offer in offers
            if not blenders_tool.repository_filter_skip(
                offer,
                filter_blender_version=blender,
                filter_python_version=python,
                filter_platform=platform,
                skip_message_fn=None,
                error_fn=pytest.fail,
            )
        ]
        assert fitting == ([f"./{zips[expected].name}"] if expected else []), (blender, python, platform)


def test_zips_that_blender_cannot_distinguish_are_an_error(
    extension: Any, zips: dict[str, Path], tmp_path: Path
) -> None:
    for name in ("one.zip", "two.zip"):
        shutil.copy(zips["linux-x64-py313"], tmp_path / name)
    with pytest.raises(extension.Failed, match="duplicate"):
        extension.write_index(tmp_path)


@pytest.fixture
def shelf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only folder in which pip looks."""
    folder = tmp_path / "shelf"
    folder.mkdir()
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(folder))
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    return folder


def small_wheel(extension: Any, folder: Path) -> Any:
    """A wheel for another platform and Python than this one."""
    path = folder / "small-1.0-cp314-cp314-manylinux_2_27_x86_64.manylinux_2_28_x86_64.whl"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("small-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: small\nVersion: 1.0\n")
        archive.writestr("small-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\n")
        archive.writestr("small-1.0.dist-info/RECORD", "")
    return extension.Wheel(hashlib.sha256(path.read_bytes()).hexdigest(), path.name)


def test_a_wheel_is_fetched_once_and_again_when_it_is_broken(extension: Any, shelf: Path, tmp_path: Path) -> None:
    wheel = small_wheel(extension, shelf)
    folder = tmp_path / "wheels"
    extension.fetch([wheel], folder)
    fetched = folder / wheel.file_name
    whole = fetched.read_bytes()
    fetched.write_bytes(whole[:100])
    extension.fetch([wheel], folder)
    assert fetched.read_bytes() == whole
    shutil.rmtree(shelf)
    extension.fetch([wheel], folder)


def test_another_file_than_the_pinned_one_is_refused(extension: Any, shelf: Path, tmp_path: Path) -> None:
    wheel = small_wheel(extension, shelf)
    with pytest.raises(extension.Failed, match=r"has another small-1\.0-cp314"):
        extension.fetch([extension.Wheel("0" * 64, wheel.file_name)], tmp_path / "wheels")
    assert not list((tmp_path / "wheels").iterdir())


@pytest.mark.parametrize(
    ("pip_says", "words"),
    [
        ("ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device", "disk filled up"),
        ("WARNING: Retrying after 'NewConnectionError(x)'\nERROR: No matching distribution found", "HTTPS_PROXY"),
        ("ERROR: No matching distribution found for small==1.0", "has no small-1.0-cp311-cp311-win_amd64.whl"),
        ("Collecting x\nERROR: something else", "ERROR: something else"),
    ],
)
def test_pip_fails(extension: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, pip_says: str, words: str) -> None:
    failed = subprocess.CompletedProcess([], 1, "", pip_says)
    monkeypatch.setattr(extension.subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(extension.Failed, match=words) as failure:
        extension.fetch([extension.Wheel("0" * 64, "small-1.0-cp311-cp311-win_amd64.whl")], tmp_path / "wheels")
    assert "\n" not in str(failure.value)
