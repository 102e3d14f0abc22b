"""The buttons that run stages: all of them, or one."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.props import EnumProperty

from ...core.arrays import Array
from ...core.errors import StepFailed, UnusablePhotos, UsageError
from ..dependencies import missing_pycolmap
from ..files.kept import Arrays
from ..jobs.process import RESULT, UNFOLDING, Job
from ..jobs.requests import AnyRequest, stages_request
from ..paper_size import check_unit
from ..plan import Known, Plan, plan_all, plan_stage
from ..scene.chosen import active_document
from ..scene.declared import sentence
from ..scene.document import Document, documents
from ..scene.edits import forget
from ..scene.free_ground import stand_beside_others
from ..scene.known import known_of
from ..scene.listed_photos import is_named, list_movie_photos, note_photos
from ..scene.modes import set_mode
from ..scene.roles import OUTLINE, PAGE, PAGE_FRAME, POINTS, SHEET
from ..scene.show import Pictures, find_camera, show_cameras, show_outline, show_page, show_sheet
from ..scene.view import look_at, show_way
from ..stages import EFFECT, STAGES, about
from ..state import Found, LaidOut, Placed, State, Surfaced, from_bytes, reached, state_from_arrays
from ..work_folder import work_folder
from .job_operator import CHANGED, JobOperator
from .needs import DocumentOperator

_STAGE_ITEMS = [(stage, about(stage).verb, sentence(about(stage).help)) for stage in STAGES]


class StageOperator(JobOperator, DocumentOperator):
    """Base of the operators that run stages of a document."""

    sheet: int | None = None  # the number of the sheet to take, if not that of the settings

    def plan(self, known: Known) -> Plan:
        """The stages to run, from what is known of the document.

        Raises
        ------
        OrigamiError, NothingToDo
        """
        raise NotImplementedError

    def corners(self, plan: Plan) -> Array | None:
        """The corners of the page, if they are not to be those of the layout."""
        return None

    def prepare(self, context: bpy.types.Context) -> tuple[AnyRequest, Arrays]:
        """As `JobOperator` asks: the document as it is in the scene."""
        known = known_of(self.document, self.sheet)
        self._plan, self._wanted = self.plan(known), known.wanted
        _check_before(self._plan)
        self._before = self._digest = _digest(self.document)
        return stages_request(self._plan, work_folder(), self.corners(self._plan))

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """As `JobOperator` asks."""
        stage = message["done"]
        document = self.document
        if _digest(document) != self._digest:
            raise StepFailed(CHANGED)
        group = document.collection.origami
        content = (job.folder / RESULT.format(stage=stage)).read_bytes()
        state = state_from_arrays(from_bytes(content))
        yield
        if stage == STAGES[0]:
            self._plan = replace(self._plan, photos=list_movie_photos(document, self._plan.photos, message["movies"]))
        else:
            for camera in reached(state, Placed).model.cameras:
                find_camera(document, camera)
        document.keep(content)
        yield
        _leave_modes(document)
        for _ in self._show(document, stage, state, job.folder):
            yield
            _leave_modes(document)  # the user may have gone back to Edit Mode meanwhile
        if self._plan.places_photos and not bpy.app.background and self._is_watched(context, document):
            _turn_views(document, stage)
        forget(document, *(part for part, first in EFFECT.items() if STAGES.index(first) <= STAGES.index(stage)))
        settings = self._plan.settings
        if stage == STAGES[0]:
            group.photos_placed = json.dumps(self._plan.photos)
            note_photos(document, reached(state, Placed).model, message["sharpness"])
        if stage == "find":
            group.outline_by_hand = settings.outline is not None
            if self.sheet is not None:
                group.settings.sheet = self.sheet
        if stage == "surface":
            group.creases = "" if settings.creases is None else json.dumps(settings.creases)
            group.crease = -1  # they have other numbers
        for later in STAGES[STAGES.index(stage) :]:
            getattr(group, later).done = False
        record = getattr(group, stage)
        record.done = True
        record.figures, record.warnings = json.dumps(message["figures"]), json.dumps(message["warnings"])
        record.seconds = message["seconds"]
        record.settings = self._wanted[stage]
        self._digest = _digest(document)

    def _is_watched(self, context: bpy.types.Context, document: Document) -> bool:
        """Whether the user is at the document, whose views then follow it; otherwise they are the user's."""
        shown = active_document(context)
        return document.scene == context.scene and shown is not None and shown.name == document.name

    def _show(self, document: Document, stage: str, state: State, folder: Path) -> Iterator[None]:
        paths = [Path(path) for path in self._plan.photos]
        cameras = reached(state, Placed).model.cameras
        photos = [next(path for path in paths if is_named(path, camera.name)) for camera in cameras]
        pictures = Pictures(sorted((folder / "views").glob("*.jpg")), photos, pack=True)
        if stage == "place":
            yield from show_cameras(document, reached(state, Placed), pictures)
        elif stage == "find":
            yield from show_outline(document, reached(state, Found))
        elif stage in ("surface", "lay_out") or (stage == "page" and document.object(SHEET) is None):
            yield from show_sheet(document, reached(state, Surfaced), pictures, _shapes(state, folder))
        if stage == "page":
            first = document.object(PAGE) is None
            yield from show_page(document, reached(state, LaidOut), folder / "page.jpg", pack=True)
            if first:
                stand_beside_others(document, (SHEET, PAGE_FRAME))

    def done_text(self, message: dict[str, Any]) -> str:
        """As `JobOperator` asks."""
        return about(message["done"]).verb

    def as_before(self) -> Callable[[], bool] | None:
        """As `JobOperator` asks."""
        name, before = self._begun_on, self._before
        # The user may have deleted the document meanwhile: undo brings it back.
        return lambda: any(each.name == name and _digest(each) == before for each in documents())


class ORIGAMI_OT_rectify(StageOperator, bpy.types.Operator):
    """Make the flat page of the document's photos, starting at the first stage that is not up to date"""

    bl_idname = "origami.rectify"
    bl_label = "Rectify Photos"
    label = "Rectify Photos"

    def plan(self, known: Known) -> Plan:
        """All stages that are not up to date."""
        return plan_all(known)


class ORIGAMI_OT_run_stage(StageOperator, bpy.types.Operator):
    """Run this stage again on the results of the stages before it, including what you edited by hand"""

    bl_idname = "origami.run_stage"
    bl_label = "Run Stage"

    stage: EnumProperty(
        name="Stage",
        description="The stage to run",
        items=_STAGE_ITEMS,
    )

    @property
    def label(self) -> str:
        """What the user sees while it runs."""
        return about(self.stage).verb

    def plan(self, known: Known) -> Plan:
        """The stage, with those that belong to it."""
        return plan_stage(known, self.stage)


def _leave_modes(document: Document) -> None:
    """Put the objects whose data are replaced into Object Mode: in others their data cannot be written."""
    for shown in (document.object(role) for role in (POINTS, OUTLINE, SHEET, PAGE, PAGE_FRAME)):
        if shown is not None:
            set_mode(shown, "OBJECT")


def _check_before(plan: Plan) -> None:
    """Refuse at once what would otherwise fail, or give a wrong page, after a long run.

    Raises
    ------
    UsageError, UnusablePhotos
    """
    check_unit(plan.settings.page.paper_size_mm)
    if plan.places_photos and not plan.photos:
        raise UsageError(
            "No photo of the document is ticked: tick at least three in the step Photos, or add some there."
        )
    if plan.places_photos and not plan.settings.colmap_model and (missing := missing_pycolmap()) is not None:
        raise UnusablePhotos(f"{missing}.")


def _turn_views(document: Document, stage: str) -> None:
    """Show a new document as it grows, and in the end its page, in the open windows."""
    if stage != STAGES[-1]:
        look_at(document)
        return
    for window in bpy.context.window_manager.windows:
        show_way(document, "PAGE", window.screen)


def _shapes(state: State, folder: Path) -> Array | None:
    """The shapes of the sheet on its way to flat, which a job has left in its folder; None if it is not flat yet."""
    if not isinstance(state, LaidOut):
        return None
    with np.load(folder / UNFOLDING) as stored:
        return np.asarray(stored["shapes"])


def _digest(document: Document) -> list[Any]:
    """A value that changes whenever a stage finishes or its result is undone."""
    records = [getattr(document.collection.origami, stage) for stage in STAGES]
    return [document.state_digest(), *((each.done, each.figures, each.seconds) for each in records)]


CLASSES = (ORIGAMI_OT_rectify, ORIGAMI_OT_run_stage)
