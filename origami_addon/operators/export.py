"""Exports the page, the mesh and the UV map."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...core.errors import StepFailed, UsageError
from ..export.outputs import KINDS, chosen, names_of
from ..files.atomic import replacing
from ..files.image_files import Bits
from ..files.kept import Arrays
from ..files.marker import claim
from ..files.results_folder import keep_off_inputs, keep_off_others
from ..jobs.process import Job
from ..jobs.requests import AnyRequest, WriteFiles
from ..plan import first_stale
from ..scene.declared import sentence
from ..scene.document import Document
from ..scene.known import known_of
from ..settings_json import as_text
from ..state import Found, reached, state_arrays
from ..work_folder import work_folder
from .folder import AsksForFolder
from .job_operator import JobOperator
from .needs import PICTURE, DocumentOperator
from .nested import start

_KIND_ITEMS = [(kind, each.label, sentence(each.help), 1 << place) for place, (kind, each) in enumerate(KINDS.items())]
_SETTINGS = ".json"
_TICK = "write_"  # begins the name of the property that ticks a kind of file


def _tick(kind: str) -> Any:
    """A tick for a kind of file: a flag of `kinds`, which Blender would draw as buttons that switch each other off."""
    return BoolProperty(
        name=KINDS[kind].label,
        description=sentence(KINDS[kind].help),
        get=lambda self: kind in self.kinds,
        set=lambda self, ticked: setattr(self, "kinds", self.kinds | {kind} if ticked else self.kinds - {kind}),
        options={"SKIP_SAVE"},
    )


class _Files:
    """What to write, and where."""

    directory: StringProperty(name="Folder", description="The folder to write into", subtype="DIR_PATH")
    kinds: EnumProperty(
        name="Files",
        description="The files to write",
        items=_KIND_ITEMS,
        options={"ENUM_FLAG"},
        default={"tiff", "jpeg", "gltf"},
    )
    bits: EnumProperty(
        name="Depth",
        description="Bits per colour in TIFF and PNG",
        items=[
            ("0", "As the Photo", "As many as the photo has"),
            ("8", "8 Bits", "256 steps per colour"),
            ("16", "16 Bits", "65536 steps per colour"),
        ],
    )


class ORIGAMI_OT_export(_Files, AsksForFolder, DocumentOperator, bpy.types.Operator):
    """Write the page, the sheet's mesh and its UV map into a folder"""

    bl_idname = "origami.export"
    bl_label = "Export Document"
    role = PICTURE

    __annotations__ = {f"{_TICK}{kind}": _tick(kind) for kind in KINDS}

    def draw(self, context: bpy.types.Context) -> None:
        """The options beside the file browser."""
        self.layout.label(text="Files")
        column = self.layout.column(align=True)
        for kind, output in KINDS.items():
            row = column.row()
            row.enabled = not output.why_not()
            row.prop(self, f"{_TICK}{kind}")
        self.layout.prop(self, "bits")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write the files, without blocking the window if there is one."""
        chosen = {"directory": self.directory, "kinds": self.kinds, "bits": self.bits}
        return {"FINISHED"} if start(self, bpy.ops.origami.write_files, **chosen) else {"CANCELLED"}


class ORIGAMI_OT_write_files(_Files, JobOperator, DocumentOperator, bpy.types.Operator):
    """Write the page, the sheet's mesh and its UV map into a given folder"""

    bl_idname = "origami.write_files"
    bl_label = "Write Files"
    bl_options = {"INTERNAL"}
    label = "Export Document"
    role = PICTURE
    pushes_undo = False

    def prepare(self, context: bpy.types.Context) -> tuple[AnyRequest, Arrays]:
        """As `JobOperator` asks: the document as it is in the scene."""
        document = self.document
        known = known_of(document)
        if first_stale(known) not in (None, "page"):
            raise UsageError("The page is not up to date: press Rectify Photos, then export again.")
        if not self.kinds:
            raise UsageError("No files are chosen: tick at least one under Files.")
        out = Path(self.directory).resolve()
        _claim(out, names_of(chosen(self.kinds)), document, [Path(path) for path in known.placed])
        self._count = len(self.kinds)
        bits: Bits | None = {"0": None, "8": 8, "16": 16}[self.bits]
        kinds = tuple(sorted(self.kinds))
        request = WriteFiles(known.placed, known.settings, str(work_folder()), kinds, str(out), bits)
        return request, state_arrays(known.state)

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """Nothing in the scene changes."""
        yield

    def finished_text(self) -> str:
        """Where the files are."""
        return f"{self._count} kinds of files written to {self.directory}"


def _claim(out: Path, names: Sequence[str], document: Document, photos: Sequence[Path]) -> None:
    """Check that the files may be written, and note that the document owns them.

    Raises
    ------
    UsageError
        If the folder does not exist or cannot be written, or a file that the document does not own would be replaced.
    """
    if not out.is_dir():
        raise UsageError(f"There is no folder {out}: choose one.")
    try:
        keep_off_inputs(photos, out, names)
        keep_off_others(out, names, document.name)
        claim(out, names, document.name)
    except OSError as error:
        raise UsageError(
            f"{out} cannot be written ({error.strerror}); choose another folder for the results."
        ) from error


class ORIGAMI_OT_export_settings(DocumentOperator, bpy.types.Operator):
    """Write a settings file for the command line, with the outline and creases that were edited by hand"""

    bl_idname = "origami.export_settings"
    bl_label = "Export Settings"

    filepath: StringProperty(name="File", description="The file to write", subtype="FILE_PATH")
    filter_glob: StringProperty(
        name="Filter", description="Kinds of files shown", default=f"*{_SETTINGS}", options={"HIDDEN"}
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file."""
        self.filepath = self.filepath or "settings.json"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write it."""
        path = Path(self.filepath).with_suffix(_SETTINGS)
        try:
            text = settings_text(self.document)
            with replacing(path) as unfinished:
                unfinished.write_text(text, encoding="utf-8")
        except StepFailed as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Settings written to {path}")
        return {"FINISHED"}


def settings_text(document: Document) -> str:
    """A document's settings as JSON, from which the command line, with the same photos, makes the same page.

    Raises
    ------
    StepFailed
        If the user's outline is unusable.
    """
    known = known_of(document)
    settings, state = known.settings, known.state
    by_hand = document.collection.origami.outline_by_hand or "outline" in known.edited
    if isinstance(state, Found) and by_hand:
        polygon = tuple((float(x), float(y)) for x, y in state.region.outline.polygon)
        settings = replace(settings, reference=state.reference.name, outline=polygon)
    if known.creases is not None:
        settings = replace(settings, reference=reached(state, Found).reference.name, creases=known.creases)
    return as_text(settings)


CLASSES = (ORIGAMI_OT_export, ORIGAMI_OT_write_files, ORIGAMI_OT_export_settings)
