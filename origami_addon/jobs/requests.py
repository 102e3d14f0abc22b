"""Requests for jobs: a class for each kind of work, with its parameters except arrays, and its text form."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, cast

from ...core.arrays import Array
from ...core.flat.flatten import FlattenMethod, FlattenSettings
from ..files.image_files import Bits
from ..files.kept import Arrays
from ..plan import Plan
from ..settings import RunSettings
from ..settings_json import merged
from ..stages import Stage
from ..state import state_arrays


@dataclass(frozen=True)
class Request:
    """Work on a document's photos with some settings; ``work`` is the folder for kept results."""

    photos: tuple[str, ...] = ()
    settings: RunSettings = field(default_factory=RunSettings)
    work: str = ""


@dataclass(frozen=True)
class RunStages(Request):
    """Run stages; ``corners`` are those of the page if they differ from the layout's."""

    stages: tuple[Stage, ...] = ()
    corners: tuple[tuple[float, float], ...] | None = None


@dataclass(frozen=True)
class CompareMethods(Request):
    """Unwrap by several methods."""

    methods: tuple[FlattenMethod, ...] = ()


@dataclass(frozen=True)
class WriteFiles(Request):
    """Write files of some kinds into the folder ``out``, TIFF and PNG with ``bits`` bits per colour."""

    kinds: tuple[str, ...] = ()
    out: str = ""
    bits: Bits | None = None


@dataclass(frozen=True)
class LayOtherPhotos(Request):
    """Make a page of the other photos in a folder."""

    directory: str = ""


@dataclass(frozen=True)
class UnwrapMesh:
    """Unwrap any mesh."""

    flatten: FlattenSettings = field(default_factory=FlattenSettings)


AnyRequest = RunStages | CompareMethods | WriteFiles | LayOtherPhotos | UnwrapMesh
_KINDS: dict[str, Any] = {
    kind.__name__: kind for kind in (RunStages, CompareMethods, WriteFiles, LayOtherPhotos, UnwrapMesh)
}


def stages_request(plan: Plan, work: Path, corners: Array | None = None) -> tuple[RunStages, Arrays]:
    """The request to carry out a plan, and the arrays that `tasks.run_stages` is given with it.

    Parameters
    ----------
    plan : Plan
    work : Path
        The folder for what takes long to compute.
    corners : (4, 2) array, optional
        Where the page is to end, if not where it is laid out.
    """
    ends = None if corners is None else tuple((u, v) for u, v in corners.tolist())
    given = state_arrays(plan.start) | ({"pinned": plan.pinned} if len(plan.pinned) else {})
    return RunStages(plan.photos, plan.settings, str(work), plan.stages, ends), given


def request_text(request: AnyRequest) -> str:
    """A request as text."""
    return json.dumps({"do": type(request).__name__, "with": asdict(request)})


def request_from_text(text: str) -> AnyRequest:
    """The request from the text that `request_text` returned."""
    content = json.loads(text)
    return cast(AnyRequest, merged(_KINDS[content["do"]](), content["with"]))
