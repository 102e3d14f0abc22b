"""Read a COLMAP model that somebody else made."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pycolmap

from .model_arrays import model_arrays
from .results import save


def load(request: dict[str, Any], folder: Path) -> None:
    """Read a COLMAP model, binary or text; its cameras are passed on unchanged."""
    limit_memory(request["most_memory"])
    try:
        model = pycolmap.Reconstruction(request["model"])
        for number, name in names_in_text(Path(request["model"])).items():
            model.images[number].name = name
    except Exception:  # whatever a damaged model raises
        return save(folder, {}, {"placed": False, "names": []})
    names = sorted(image.name for image in model.images.values() if image.has_pose)
    save(folder, model_arrays(model, names), {"placed": True, "names": names})


def names_in_text(folder: Path) -> dict[int, str]:
    """The names of a text model's images by their numbers; COLMAP itself reads them only up to the first space."""
    if (folder / "images.bin").exists():  # COLMAP prefers it
        return {}
    names = {}
    with (folder / "images.txt").open(encoding="utf-8") as lines:
        for line in lines:
            if line.strip() and not line.startswith("#"):
                number, *_, name = line.strip().split(maxsplit=9)
                names[int(number)] = name
                next(lines, None)  # the image's points
    return names


def limit_memory(most: int) -> None:
    """Let the system refuse more memory than this; Windows and macOS cannot."""
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (most, most))
