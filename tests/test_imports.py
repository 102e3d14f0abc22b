"""Which package may import which: the core is independent, and only Blender's side imports Blender."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

BLENDER = {"addon_utils", "blf", "bpy", "bpy_extras", "gpu", "gpu_extras", "mathutils"}
ALLOWED = {
    # folder: third-party packages its files may import, folders of the package they may import relatively
    "core": ({"numpy", "scipy"}, {"core"}),
    "origami_addon": (BLENDER | {"numpy", "scipy", "OpenImageIO"}, {"core", "origami_addon"}),
    "headless": (BLENDER, {"core", "origami_addon", "headless"}),
}
# Folders and modules of origami_addon; each imports from its own line and from those before it.
ORDER = (
    ("one_line", "system_errors", "paper_size"),
    ("files", "child_process"),
    ("sfm",),
    (
        "settings",
        "settings_json",
        "drawn_files",
        "state",
        "stages",
        "plan",
        "costs",
        "report",
        "work_folder",
        "feasibility",
        "dependencies",
    ),
    ("scene",),
    ("presets",),
    ("export",),
    ("steps",),
    ("other_light",),
    ("advance", "own_results", "new_results", "output_folder"),
    ("pages_of_sheets", "run_inputs", "unchanged_run", "run_log"),
    ("run",),
    ("jobs",),
    ("operators",),
    ("window",),
    ("preferences",),
    ("addon",),
    ("__init__",),
)
# Modules at the top of the core, for all its packages; each imports from those before it.
TOP = ("arrays", "errors", "camera", "sparse_model", "sheet", "watch", "setting")
# Packages of the core, in order, each with the earlier ones from which it imports.
PACKAGES = {
    "numeric": (),
    "photos": ("numeric",),
    "paper": ("numeric",),
    "creases": ("numeric",),
    "surface": ("numeric", "creases"),
    "edge": ("numeric", "paper", "surface"),
    "flat": ("numeric",),
    "page": ("numeric", "flat"),
    "tracks": ("numeric", "flat", "page"),
    "fusion": ("numeric", "page", "tracks"),
    "light": ("numeric", "page"),
    "relief": ("numeric", "page", "light"),
    "unwrap": ("numeric", "flat"),
    "checks": ("numeric", "creases", "surface", "flat", "tracks"),
    "placing": ("checks",),
}
WORKER = Path("origami_addon/sfm/worker.py")
WORKER_MODULES = Path("origami_addon/sfm/pycolmap_worker")
WORKER_THIRD_PARTY = {"numpy", "pycolmap"}

IMPORT_ALL_OF_CORE = """
import importlib, importlib.util, pathlib, sys
root = pathlib.Path(sys.argv[1])
spec = importlib.util.spec_from_file_location("origami", root / "__init__.py", submodule_search_locations=[str(root)])
sys.modules["origami"] = package = importlib.util.module_from_spec(spec)
spec.loader.exec_module(package)
for path in sorted((root / "core").rglob("*.py")):
    path = path.parent if path.stem == "__init__" else path.with_suffix("")
    importlib.import_module(".".join(("origami", *path.relative_to(root).parts)))
print(sorted({"bpy", "pycolmap", "cv2", "PIL", "origami.origami_addon"} & set(sys.modules)))
"""


def test_core_imports_neither_blender_nor_colmap(root: Path) -> None:
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL_OF_CORE, str(root)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


def source_files(root: Path) -> list[Path]:
    """Every module that ships, relative to the checkout."""
    return sorted(path.relative_to(root) for folder in ALLOWED for path in (root / folder).rglob("*.py"))


def imports_of(path: Path, relative: Path) -> tuple[set[str], set[tuple[str, ...]]]:
    """Third-party packages, and modules of this package by their parts, that a module imports anywhere in its text."""
    outside: set[str] = set()
    inside: set[tuple[str, ...]] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            outside |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            outside.add((node.module or "").split(".")[0])
        elif isinstance(node, ast.ImportFrom):
            target = (*relative.parts[: -node.level], *(node.module.split(".") if node.module else ()))
            inside |= {(*target, alias.name) for alias in node.names}
    return {name for name in outside if name not in sys.stdlib_module_names}, inside


@pytest.mark.parametrize("folder", sorted(ALLOWED))
def test_layers(root: Path, folder: str) -> None:
    third_party, layers = ALLOWED[folder]
    for relative in source_files(root):
        if relative.parts[0] != folder or relative == WORKER or relative.is_relative_to(WORKER_MODULES):
            continue
        outside, inside = imports_of(root / relative, relative)
        folders = {parts[0] for parts in inside}
        assert outside <= third_party, f"{relative} imports {sorted(outside - third_party)}"
        assert folders <= layers, f"{relative} imports from {sorted(folders - layers)}"


def test_rooms_of_the_core(root: Path) -> None:
    uses: dict[str, set[str]] = {}
    for relative in source_files(root):
        if relative.parts[0] == "core":
            own = Path(relative.parts[1]).stem
            used = {parts[1] for parts in imports_of(root / relative, relative)[1]}
            uses[own] = uses.get(own, set()) | used - {own}
    assert not uses.pop("__init__")
    assert set(uses) == {*TOP, *PACKAGES}
    for place, module in enumerate(TOP):
        assert uses[module] <= set(TOP[:place]), f"core/{module}.py imports from {sorted(uses[module])}"
    for place, (package, declared) in enumerate(PACKAGES.items()):
        assert set(declared) <= set(list(PACKAGES)[:place])
        assert uses[package] - set(TOP) == set(declared), (
            f"core/{package}/ imports from {sorted(uses[package] - set(TOP))}"
        )


def test_the_packages_are_those_in_the_documentation(root: Path) -> None:
    text = (root / "docs" / "architecture.md").read_text(encoding="utf-8")
    top, *packages = text.split("The packages of the core", 1)[1].split("\n\n")[1].splitlines()[2:]
    assert re.findall(r"`(\w+)\.py`", top.split("|")[1]) == list(TOP)
    cells = [row.split("|") for row in packages]
    named = [(re.findall(r"`(\w+)/`", row[1]), tuple(re.findall(r"`(\w+)/`", row[-2]))) for row in cells]
    assert named == [([package], declared) for package, declared in PACKAGES.items()]


def test_what_the_documentation_names_is_there(root: Path) -> None:
    text = (root / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = {name.rstrip("/") for name in re.findall(r"`([\w./]+(?:\.py|/))`", text)}
    folders = ("core", "origami_addon", "headless", "workflow", "benchmarks", "docs", "tests", ".ci", "flamenco")
    there = [f"/{path.relative_to(root).as_posix()}" for folder in folders for path in (root / folder).rglob("*")]
    there += [f"/{folder}" for folder in folders]
    assert len(named) > 100
    assert not {name for name in named if not any(path.endswith(f"/{name}") for path in there)}


def test_order_within_the_add_on(root: Path) -> None:
    rank = {name: place for place, names in enumerate(ORDER) for name in names}
    for relative in source_files(root):
        if relative.parts[0] != "origami_addon":
            continue
        own = Path(relative.parts[1]).stem
        used = {parts[1] for parts in imports_of(root / relative, relative)[1] if parts[0] == "origami_addon"}
        above = {name for name in used if rank[name] > rank[own]}
        assert not above, f"{relative} imports from {sorted(above)}"


def test_the_order_is_the_one_in_the_documentation(root: Path) -> None:
    text = (root / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = text.split("Within `origami_addon/`", 1)[1].split("\n\n")[1].splitlines()[2:]
    named = [[Path(name).stem for name in re.findall(r"`(\w+(?:/|\.py))`", row.split("|")[1])] for row in rows]
    assert [sorted(names) for names in named] == [sorted(names) for names in ORDER]


def test_the_worker_needs_nothing_of_the_package(root: Path) -> None:
    assert imports_of(root / WORKER, WORKER) == ({WORKER_MODULES.name}, set())
    modules = [path.relative_to(root) for path in (root / WORKER_MODULES).glob("*.py")]
    assert len(modules) > 1
    for module in modules:
        outside, inside = imports_of(root / module, module)
        assert outside <= WORKER_THIRD_PARTY
        assert all(target[: len(WORKER_MODULES.parts)] == WORKER_MODULES.parts for target in inside)


def test_no_test_loads_pycolmap_beside_blender(root: Path) -> None:
    """A process that loads both ends at some later time, in any test: see `tests/colmap_models.py`."""
    for path in (root / "tests").rglob("test_*.py"):
        for statement in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(statement, ast.Import | ast.ImportFrom):
                names = {alias.name for alias in statement.names}
                assert "pycolmap" not in names, path.name
                module = str(getattr(statement, "module", ""))
                assert not (module.endswith(".sfm") and names & {"worker", WORKER_MODULES.name}), path.name
                assert WORKER_MODULES.name not in module, path.name
