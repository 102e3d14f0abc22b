"""What the add-on needs beside Blender, and whether it is there."""

from __future__ import annotations

from importlib import metadata

SCIPY, PYCOLMAP = "scipy", "pycolmap"


def found_version(package: str) -> str | None:
    """Version of an installed package, or None; it is not imported, for pycolmap ends some builds of Blender."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def missing_scipy() -> str | None:
    """What to tell where nothing works without scipy; None where it is there."""
    if found_version(SCIPY) is not None:
        return None
    return "This Blender's Python has no scipy: install Origami from the zip made for this Blender and system"


def missing_pycolmap() -> str | None:
    """What to tell where photos cannot be placed; None where they can."""
    if found_version(PYCOLMAP) is not None:
        return None
    return "There is no pycolmap for this system: give an existing COLMAP model of the photos instead"
