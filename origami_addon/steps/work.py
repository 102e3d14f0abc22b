"""What the steps work with, and the keys under which they keep results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.sheet import sheet_arrays
from ...core.sparse_model import SparseModel
from ..files.kept import Arrays, digest_of, kept, kept_as, key_of
from ..files.photo_pixels import PhotoPixels
from ..files.photos import Photo
from ..report import ROOT, Report, hash_of
from ..settings import RunSettings
from ..stages import Stage
from ..state import Surfaced

# The sources outside the core on which kept results depend.
_COMPUTING = (
    *(f"files/{name}.py" for name in ("photos", "decoded_photo", "photo_pixels", "heif_pixels", "movie_frames")),
    *("steps/*.py", "other_light.py", "sfm/page_client.py"),
)
# The kept images, as `kept` names them.
PAGE_IMAGE, OTHER_IMAGE = "page", "other_light"


@dataclass(frozen=True)
class Work:
    """What the steps of one run share.

    Attributes
    ----------
    photos : sequence of Photo
    folder : Path
        Holds the slow results that are kept.
    settings : RunSettings
    report : Report
    images : set of str
        The kept images that the steps have used so far (see `kept_as`), which include the largest files in the folder.
    """

    photos: Sequence[Photo]
    folder: Path
    settings: RunSettings
    report: Report
    images: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class Way:
    """The choices made where the photos leave several.

    Attributes
    ----------
    name : str
        For the user.
    begins : Stage
        The first stage that it changes.
    other : int
        0 for the sheet in the settings, n for the n-th likeliest region outside the sheets in view.
    without : tuple of str
        Photos that must not be the reference.
    creases : bool
        Whether creases are looked for.
    """

    name: str
    begins: Stage
    other: int = 0
    without: tuple[str, ...] = ()
    creases: bool = True


FIRST = Way("the likeliest sheet in its best photo", "find")


def kept_image(
    work: Work, name: str, key: str, compute: Callable[[], tuple[Arrays, dict[str, Any]]]
) -> tuple[Arrays, dict[str, Any]]:
    """A result as by `kept`, whose file is noted as used."""
    work.images.add(kept_as(name, key))
    return kept(work.folder, name, key, compute, work.report.warn)


def code_digest(root: Path) -> str:
    """A hash of the code that computes kept results; ``root`` is the folder of the extension."""
    computing = [path for name in _COMPUTING for path in sorted((root / "origami_addon").glob(name))]
    return hash_of([*sorted((root / "core").rglob("*.py")), *computing])


@cache
def code() -> str:
    """The hash of this package's code."""
    return code_digest(ROOT)


def camera_values(camera: Camera) -> list[Array]:
    """All numbers of a camera, for `digest_of`."""
    return [np.asarray(value) for value in astuple(camera)[1:]]


def digest_of_flat(state: Surfaced, uv: Array) -> str:
    """A text that changes with the sheet, its flat coordinates or the cameras."""
    poses = [array for camera in state.cameras for array in camera_values(camera)]
    return digest_of(*sheet_arrays(state.sheet).values(), uv, *poses)


def key_with_photos(pixels: PhotoPixels, model: SparseModel, *rest: Any) -> str:
    """The key of a result that depends on the photos' pixels, the sparse model and the ``rest``."""
    contents = [(photo.name, photo.sha256) for photo in pixels.photos]
    poses = [array for camera in model.cameras for array in camera_values(camera)]
    observed = [model.observed_point, model.observed_camera, model.observed_pixel]
    return key_of(code(), contents, digest_of(model.points, *observed, *poses), *rest)
