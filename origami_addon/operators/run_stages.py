"""The buttons that rectify: all stages, or one."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import bpy
from bpy.props import EnumProperty

from ...core.errors import StepFailed, UnusablePhotos, UsageError
from ..dependencies import missing_pycolmap
from ..files.kept import Arrays
from ..jobs.process import RESULT, Job
from ..paper_size import check_unit
from ..scene.declared import sentence
from ..scene.document import Document, documents
from ..scene.edits import forget
from ..scene.modes import set_mode
from ..scene.properties import settings_to_json
from ..scene.read_back import ReadBack, read_back, reference_of
from ..scene.show import (
    OUTLINE,
    PAGE,
    PAGE_FRAME,
    POINTS,
    SHEET,
    Pictures,
    find_camera,
    show_cameras,
    show_outline,
    show_page,
    show_sheet,
)
from ..scene.stale import first_stale, photos_in_use, settings_of
from ..scene.view import look_at
from ..settings_json import from_json
from ..stages import EFFECT, STAGES, about
from ..state import State, from_bytes, state_arrays, state_from_arrays
from ..work_folder import work_folder
from .job_operator import CHANGED, JobOperator, NothingToDo
from .needs import DocumentOperator

_STAGE_ITEMS = [(stage, about(stage).verb, sentence(about(stage).help)) for stage in STAGES]


class StageOperator(JobOperator, DocumentOperator):
    """Runs stages of the active document."""

    def stages(self, document: Document, read: ReadBack) -> Sequence[str]:
        """The stages to run."""
        raise NotImplementedError

    def prepare(self, context: bpy.types.Context) -> tuple[dict[str, Any], Arrays]:
        """As `JobOperator` asks: the document as it is in the scene."""
        document = self.document
        group = document.collection.origami
        read = read_back(document)
        stages = list(self.stages(document, read))
        stages = [*_reached_back(read, stages[0]), *stages]
        require(document, stages[0])
        settings = self._settings_of(group)
        check_unit(from_json(settings).page.paper_size_mm)
        if stages[0] == STAGES[0]:
            if not group.settings.colmap_model and (missing := missing_pycolmap()) is not None:
                raise UnusablePhotos(f"{missing}.")
            photos = photos_in_use(document)
        else:
            photos = json.loads(group.photos_placed)
        if stages[0] == "surface" and "outline" in read.edited:
            stages.insert(0, "find")
        chosen_since = group.find.settings != settings_of("find", settings)
        if stages[0] == "find" and "outline" in read.edited and self.keeps_outline and not chosen_since:
            state = read.state
            assert state.model is not None and state.region is not None
            settings["reference"] = state.model.cameras[state.region.reference].name
            settings["outline"] = state.region.outline.polygon.tolist()
        if "surface" in stages and self._given_creases is not None:
            settings["reference"] = reference_of(read.state).name
            settings["creases"] = self._given_creases
        self._begins = stages[0] == STAGES[0]
        self._outline_given = "outline" in settings
        self._photos, self._settings = photos, self._settings_of(group)
        request = {
            "task": "stages",
            "photos": photos,
            "settings": settings,
            "work": str(work_folder()),
            "stages": stages,
        }
        # Points that were deleted count from the surface on; where that does not run they wait.
        given = state_arrays(read.state if "surface" in stages else _with_all_points(document, read))
        self._before = self._likeness = _likeness(document)
        if len(read.pinned) > 1 and "unwrap" in stages and "surface" not in stages:
            given["pinned"] = read.pinned
        return request, given

    keeps_outline = True
    _given_creases: Sequence[tuple[float, ...]] | None = None
    _given_sheet: int | None = None

    def _settings_of(self, group: Any) -> dict[str, Any]:
        settings = settings_to_json(group.settings)
        return settings if self._given_sheet is None else settings | {"sheet": self._given_sheet}

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """As `JobOperator` asks."""
        stage = message["done"]
        document = self.document
        if _likeness(document) != self._likeness:
            raise StepFailed(CHANGED)
        group = document.collection.origami
        content = (job.folder / RESULT.format(stage=stage)).read_bytes()
        state = state_from_arrays(from_bytes(content))
        yield
        assert state.model is not None
        if stage != STAGES[0]:
            for camera in state.model.cameras:
                find_camera(document, camera)
        document.keep(content)
        yield
        for _ in self._show(document, stage, state, job.folder):
            yield
        if self._begins and not bpy.app.background and document.scene == context.scene:
            look_at(document)
        forget(document, *(part for part, first in EFFECT.items() if STAGES.index(first) <= STAGES.index(stage)))
        if stage == STAGES[0]:
            group.photos_placed = json.dumps(self._photos)
            _note_photos(group, state)
        if stage == "find":
            group.outline_by_hand = self._outline_given
            if self._given_sheet is not None:
                group.settings.sheet = self._given_sheet
        if stage == "surface":
            group.creases = "" if self._given_creases is None else json.dumps(self._given_creases)
        for later in STAGES[STAGES.index(stage) :]:
            getattr(group, later).done = False
        told = getattr(group, stage)
        told.done = True
        told.figures, told.warnings = json.dumps(message["figures"]), json.dumps(message["warnings"])
        told.seconds = message["seconds"]
        told.settings = settings_of(stage, self._settings)
        self._likeness = _likeness(document)

    def _show(self, document: Document, stage: str, state: State, folder: Path) -> Iterator[None]:
        assert state.model is not None
        paths = [Path(path) for path in self._photos]
        photos = [next(path for path in paths if is_named(path, camera.name)) for camera in state.model.cameras]
        pictures = Pictures(sorted((folder / "views").glob("*.jpg")), photos, pack=True)
        for shown in (document.object(role) for role in (POINTS, OUTLINE, SHEET, PAGE, PAGE_FRAME)):
            if shown is not None:
                set_mode(shown, "OBJECT")
        if stage == "place":
            yield from show_cameras(document, state, pictures)
        elif stage == "find":
            yield from show_outline(document, state)
        elif stage in ("surface", "lay_out"):
            yield from show_sheet(document, state, pictures)
        elif stage == "page":
            if document.object(SHEET) is None:
                yield from show_sheet(document, state, pictures)
            yield from show_page(document, state, folder / "page.jpg", pack=True)

    def done_text(self, message: dict[str, Any]) -> str:
        """As `JobOperator` asks."""
        return about(message["done"]).verb

    def as_before(self) -> Callable[[], bool] | None:
        """As `JobOperator` asks."""
        name, before = self._begun_on, self._before
        # The user may have deleted the document meanwhile: undo brings it back.
        return lambda: any(each.name == name and _likeness(each) == before for each in documents())


class ORIGAMI_OT_rectify(StageOperator, bpy.types.Operator):
    """Make the flat page of the document's photos, from the first stage on that is not up to date"""

    bl_idname = "origami.rectify"
    bl_label = "Rectify Photos"
    label = "Rectify Photos"

    def stages(self, document: Document, read: ReadBack) -> Sequence[str]:
        """From the first one that is not done, was done with other settings, or is affected by what was mended."""
        first = first_stale(document, read)
        if first is None:
            raise NothingToDo("Everything is up to date: change a setting or mend something first")
        by_hand = document.collection.origami.creases
        # A photo that is another reference has its creases elsewhere.
        if by_hand and STAGES.index(first) > STAGES.index("find"):
            self._given_creases = json.loads(by_hand)
        return STAGES[STAGES.index(first) :]


class ORIGAMI_OT_run_stage(StageOperator, bpy.types.Operator):
    """Run this stage anew on what the stages before it have found, with whatever was mended by hand"""

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

    @property
    def keeps_outline(self) -> bool:
        """Finding the sheet forgets an outline that was mended; what follows takes it."""
        return self.stage != "find"

    def stages(self, document: Document, read: ReadBack) -> Sequence[str]:
        """The stage alone; unwrapping and making the page include laying it out."""
        if self.stage == "unwrap":
            return ["unwrap", "lay_out"]
        if self.stage == "page" and first_stale(document, read) == "lay_out":
            return ["lay_out", "page"]
        return [self.stage]


def require(document: Document, stage: str) -> None:
    """Make sure that all stages before one are done.

    Raises
    ------
    UsageError
    """
    for before in STAGES[: STAGES.index(stage)]:
        if not getattr(document.collection.origami, before).done:
            raise UsageError(f"{about(before).verb} is not done yet: run it first, or press Rectify Photos.")


def _reached_back(read: ReadBack, first: str) -> Sequence[str]:
    """The stages before the first one to run that must run too, so that what was mended by hand counts."""
    begin = min((STAGES.index(EFFECT[each]) for each in read.edited), default=len(STAGES))
    return STAGES[begin : STAGES.index(first)]


def _with_all_points(document: Document, read: ReadBack) -> State:
    """The document as it is in the scene, but with the points that the user has deleted."""
    return document.state if "points" in read.edited else read.state


def _likeness(document: Document) -> list[Any]:
    """Changes with every stage that is done."""
    told = [getattr(document.collection.origami, stage) for stage in STAGES]
    return [document.likeness(), *((each.done, each.figures, each.seconds) for each in told)]


def is_named(path: Path, name: str) -> bool:
    """Whether a photo's name in its document, with as many folders as tell it from the others, is that of a file."""
    return path.parts[-len(Path(name).parts) :] == Path(name).parts


def _note_photos(group: Any, state: State) -> None:
    assert state.model is not None
    names = [camera.name for camera in state.model.cameras]
    for photo in group.photos:
        placed = any(is_named(Path(bpy.path.abspath(photo.path)), name) for name in names)
        photo.note = "placed" if placed else "could not be placed" if photo.use else ""


CLASSES = (ORIGAMI_OT_rectify, ORIGAMI_OT_run_stage)
