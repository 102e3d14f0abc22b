"""The packages that the add-on needs, and whether they are installed."""

from __future__ import annotations

from importlib import metadata

SCIPY, PYCOLMAP = "scipy", "pycolmap"


def found_version(package: str) -> str | None:
    """Version of an installed package, or None. It is not imported, because pycolmap crashes some builds of Blender."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def missing_scipy() -> str | None:
    """The message if scipy, which everything needs, is missing; None if it is installed."""
    if found_version(SCIPY) is not None:
        return None
    return "This Blender's Python has no scipy: install Origami from the zip made for this Blender and system"


def missing_pycolmap() -> str | None:
    """The message if photos cannot be placed, because pycolmap is missing; None if it is installed."""
    if found_version(PYCOLMAP) is not None:
        return None
    return "There is no pycolmap for this system: use an existing COLMAP model of the photos instead"
