"""What a whole run is asked to do, and the photos, movies and models that it reads."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core.watch import Watch
from .files.content_hash import sha256_of
from .files.links import real
from .files.movie_photos import with_photos_of_movies
from .files.photos import Photo, gather
from .other_light import OtherPhotos, gather_others
from .output_folder import movies_folder_of
from .report import Report
from .settings import RunSettings
from .sfm.colmap_files import model_folder
from .stages import Stage

_COLMAP_FILE = re.compile(r"(cameras|images|points3D|rigs|frames)\.(bin|txt)")


@dataclass(frozen=True)
class Asked:
    """What a run is to do; `rectify` explains it. ``left_out`` has a sentence about each file that is not a photo."""

    files: Sequence[Path]
    left_out: Sequence[str]
    other_photos: Sequence[Path]
    out: Path
    settings: RunSettings
    recursive: bool
    force: bool
    stop_after: Stage | None


def read_inputs(asked: Asked, report: Report, watch: Watch) -> tuple[Sequence[Photo], Sequence[OtherPhotos]]:
    """The photos, and those in another light, which the report then lists.

    Raises
    ------
    UsageError, UnusablePhotos
    """
    with report.stage("read photos") as figures:
        report.warn(*asked.left_out)
        pictures, movies = with_photos_of_movies(
            asked.files, lambda _: movies_folder_of(asked.out), report.warn, watch, again=asked.force
        )
        photos, warnings = gather(pictures)
        report.warn(*warnings)
        report.inputs = [_described(photo) for photo in photos]
        report.inputs += [
            {"name": each.path.name, "path": str(real(each.path)), "sha256": each.sha256} for each in movies
        ]
        if asked.settings.colmap_model is not None:
            report.inputs += _files_of_model(Path(asked.settings.colmap_model))
        figures["photos"] = len(photos)
        others = gather_others(asked.other_photos, recursive=asked.recursive)
        for other in others:
            report.inputs += [_described(photo) | {"other_photos": other.name} for photo in other.photos]
    return photos, others


def _described(photo: Photo) -> dict[str, Any]:
    return {
        "name": photo.name,
        "path": str(real(photo.path)),
        "sha256": photo.sha256,
        "width": photo.width,
        "height": photo.height,
        "make": photo.make,
        "model": photo.model,
        "taken": photo.taken,
    }


def _files_of_model(folder: Path) -> list[dict[str, Any]]:
    """The files of a COLMAP model for the report."""
    return [
        {"name": path.name, "path": str(real(path)), "sha256": sha256_of(path)}
        for path in sorted(model_folder(folder).iterdir())
        if _COLMAP_FILE.fullmatch(path.name)
    ]
