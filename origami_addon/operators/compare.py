"""Compares the methods of unwrapping."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

import bpy
import numpy as np

from ...core.errors import StepFailed
from ...core.flat.flatten import FlattenMethod
from ..files.kept import Arrays
from ..jobs.process import RESULT, Job
from ..jobs.requests import AnyRequest, CompareMethods
from ..scene.known import known_of
from ..scene.modes import in_object_mode
from ..scene.roles import SHEET
from ..scene.sheet_mesh import PAGE_UV, page_uv, set_uv
from ..state import LaidOut, reached, state_arrays, state_from_arrays
from ..work_folder import work_folder
from .job_operator import JobOperator
from .needs import DocumentOperator


class ORIGAMI_OT_compare_methods(JobOperator, DocumentOperator, bpy.types.Operator):
    """Unwrap the sheet with every method, each into its own UV map beside the page's"""

    bl_idname = "origami.compare_methods"
    bl_label = "Compare Methods"
    label = "Compare Methods"
    role = SHEET

    def prepare(self, context: bpy.types.Context) -> tuple[AnyRequest, Arrays]:
        """As `JobOperator` asks: the sheet as it is in the scene."""
        known = known_of(self.document)
        self._stretch: dict[str, float] = {}
        request = CompareMethods(known.placed, known.settings, str(work_folder()), get_args(FlattenMethod))
        return request, state_arrays(reached(known.state, LaidOut))

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """As `JobOperator` asks: a UV map for each method."""
        method = message["done"]
        sheet_object = self.object
        if sheet_object is None:
            raise StepFailed("The sheet's object was deleted: run Build Surface and Unwrap, then compare.")
        with np.load(job.folder / RESULT.format(stage=method)) as stored:
            state = reached(state_from_arrays(dict(stored)), LaidOut)
        yield
        corners = page_uv(state.flat)[state.sheet.triangles.reshape(-1)]
        with in_object_mode(sheet_object):
            if sheet_object.type != "MESH" or len(sheet_object.data.loops) != len(corners):
                raise StepFailed("The sheet's mesh has other faces than were unwrapped: run Unwrap once, then compare.")
            set_uv(sheet_object.data, f"{PAGE_UV} {method}", corners)
        self._stretch[method] = message["figures"]["stretch_95th_percentile"]
        yield

    def done_text(self, message: dict[str, Any]) -> str:
        """As `JobOperator` asks."""
        return f"Unwrap by {message['done']}"

    def finished_text(self) -> str:
        """The stretch of each method."""
        stretches = ", ".join(f"{method} {100 * stretch:.2f} %" for method, stretch in self._stretch.items())
        return f"Stretch in the worst twentieth: {stretches}"


CLASSES = (ORIGAMI_OT_compare_methods,)
