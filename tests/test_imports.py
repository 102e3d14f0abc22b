"""Who may import whom: the core stands alone, and only Blender's side knows Blender."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

BLENDER = {"bpy", "bpy_extras", "addon_utils", "gpu", "gpu_extras", "mathutils"}
ALLOWED = {
    # folder: third-party packages its files may import, folders of the package they may import relatively
    "core": ({"numpy", "scipy"}, {"core"}),
    "origami_addon": (BLENDER | {"numpy", "scipy", "OpenImageIO"}, {"core", "origami_addon"}),
    "headless": (BLENDER | {"origami"}, set()),
}
WORKER = Path("origami_addon/sfm/worker.py")
WORKER_THIRD_PARTY = {"numpy", "pycolmap"}

IMPORT_ALL_OF_CORE = """
import importlib, importlib.util, pathlib, sys
root = pathlib.Path(sys.argv[1])
spec = importlib.util.spec_from_file_location("origami", root / "__init__.py", submodule_search_locations=[str(root)])
sys.modules["origami"] = package = importlib.util.module_from_spec(spec)
spec.loader.exec_module(package)
for path in sorted((root / "core").glob("*.py")):
    importlib.import_module("origami.core" + ("" if path.stem == "__init__" else "." + path.stem))
print(sorted({"bpy", "pycolmap", "cv2", "PIL", "origami.origami_addon"} & set(sys.modules)))
"""


def test_core_imports_neither_blender_nor_colmap(root: Path) -> None:
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL_OF_CORE, str(root)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


def source_files(root: Path) -> list[Path]:
    """Every module that ships, relative to the checkout."""
    return sorted(path.relative_to(root) for folder in ALLOWED for path in (root / folder).rglob("*.py"))


def imports_of(path: Path, relative: Path) -> tuple[set[str], set[str]]:
    """Third-party packages, and folders of this package, that a module imports anywhere in its text."""
    outside: set[str] = set()
    inside: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            outside |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            outside.add((node.module or "").split(".")[0])
        elif isinstance(node, ast.ImportFrom):
            target = [*relative.parts[: -node.level], *(node.module or "").split(".")]
            inside |= {target[0]} if target[0] else {alias.name for alias in node.names}
    return {name for name in outside if name not in sys.stdlib_module_names}, inside


@pytest.mark.parametrize("folder", sorted(ALLOWED))
def test_layers(root: Path, folder: str) -> None:
    third_party, layers = ALLOWED[folder]
    for relative in source_files(root):
        if relative.parts[0] != folder or relative == WORKER:
            continue
        outside, inside = imports_of(root / relative, relative)
        assert outside <= third_party, f"{relative} imports {sorted(outside - third_party)}"
        assert inside <= layers, f"{relative} imports from {sorted(inside - layers)}"


def test_the_worker_needs_nothing_of_the_package(root: Path) -> None:
    outside, inside = imports_of(root / WORKER, WORKER)
    assert outside <= WORKER_THIRD_PARTY
    assert not inside
