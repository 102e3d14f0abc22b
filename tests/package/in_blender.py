"""Runs inside a Blender whose BLENDER_USER_RESOURCES is a temporary folder: installs a zip and reports the states.

blender -b --factory-startup --python-exit-code 1 -P tests/package/in_blender.py -- ZIP [keep]
python tests/package/in_blender.py -- ZIP [keep]

The last line of the output is JSON. With `keep` the extension stays installed and enabled; otherwise it is enabled
twice and then removed.
"""

from __future__ import annotations

import importlib
import json
import sys
from collections import Counter
from importlib.machinery import PathFinder
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

import bpy

ADDON = "bl_ext.user_default.origami"
PACKAGES = ("numpy", "scipy", "pycolmap")


def registered() -> Counter[str]:
    """Everything that an add-on can register and Blender can list, with its number of occurrences."""
    found: Counter[str] = Counter()
    for name in dir(bpy.types):
        kind = getattr(bpy.types, name)
        found[f"type {name}"] += 1
        if hasattr(kind, "bl_rna"):
            found.update(f"property {name}.{key}" for key in kind.bl_rna.properties.keys())  # noqa: SIM118 - no dict
        # Once something is added to a menu, the menu's own draw function is the first of these.
        found[f"drawn in {name}"] += max(0, len(getattr(getattr(kind, "draw", None), "_draw_funcs", ())) - 1)
    for name in dir(bpy.app.handlers):
        listed = getattr(bpy.app.handlers, name)
        found[f"handler {name}"] += len(listed) if isinstance(listed, list) else 0
    for keymap in bpy.context.window_manager.keyconfigs.addon.keymaps:
        found[f"keys of {keymap.name}"] += len(keymap.keymap_items)
    found["manual pages"] += len(list(bpy.utils.manual_map()))
    return +found


def places() -> dict[str, str | None]:
    """The file from which each package would be imported if it were not imported yet."""
    importlib.invalidate_caches()
    found = {name: PathFinder.find_spec(name) for name in PACKAGES}
    return {name: spec.origin if spec else None for name, spec in found.items()}


def manual_page() -> str | None:
    """The file that F1 over the big button opens."""
    for prefix, pages in bpy.utils.manual_map():
        for name, page in pages:
            if name == "bpy.ops.origami.rectify":
                return url2pathname(urlparse(prefix + page).path)
    return None


def state() -> dict[str, object]:
    """The current state."""
    module = sys.modules.get(ADDON)
    return {
        "enabled": ADDON in bpy.context.preferences.addons,
        "module": module.__file__ if module else None,
        "registered": registered(),
        "packages": places(),
        "manual page": manual_page(),
    }


def remove() -> None:
    """Uninstall, like the button in the preferences."""
    repositories = [repository.module for repository in bpy.context.preferences.extensions.repos]
    bpy.ops.extensions.package_uninstall(repo_index=repositories.index("user_default"), pkg_id="origami")


def main(archive: str, *options: str) -> None:
    """Install the zip and report each state."""
    states = {"blender": bpy.app.version_string, "before": state()}
    bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
    states["installed"] = state()
    if "keep" not in options:
        bpy.ops.preferences.addon_disable(module=ADDON)
        states["disabled"] = state()
        bpy.ops.preferences.addon_enable(module=ADDON)
        states["enabled again"] = state()
        remove()
        folder = Path(bpy.utils.user_resource("EXTENSIONS"))
        states["removed"] = state()
        states["left behind"] = [path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()]
    print(json.dumps(states), flush=True)


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1 :])
