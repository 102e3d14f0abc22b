"""Makes a page of other photos of the same sheet, such as ultraviolet ones."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty

from ...core.errors import StepFailed, UsageError
from ..files.kept import Arrays
from ..jobs.process import OTHER_PICTURE, Job
from ..jobs.requests import AnyRequest, LayOtherPhotos
from ..plan import first_stale
from ..scene.known import known_of
from ..scene.show import show_other_page
from ..state import LaidOut, reached, state_arrays
from ..work_folder import work_folder
from .folder import AsksForFolder
from .job_operator import CHANGED, JobOperator
from .needs import PICTURE, DocumentOperator
from .nested import start


class _Folder:
    """Where the other photos are."""

    directory: StringProperty(name="Folder", description="The folder of the other photos", subtype="DIR_PATH")


class ORIGAMI_OT_add_other_light(_Folder, AsksForFolder, DocumentOperator, bpy.types.Operator):
    """Make a page of other photos of the same untouched sheet, in ultraviolet, infrared or raking light"""

    bl_idname = "origami.add_other_light"
    bl_label = "Add Other Light"
    role = PICTURE

    filter_image: BoolProperty(name="Photos", description="Show photos too", default=True, options={"HIDDEN"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the page, without blocking the window if there is one."""
        begun = start(self, bpy.ops.origami.lay_other_photos, directory=self.directory)
        return {"FINISHED"} if begun else {"CANCELLED"}


class ORIGAMI_OT_lay_other_photos(_Folder, JobOperator, DocumentOperator, bpy.types.Operator):
    """Make a page of the other photos in a given folder"""

    bl_idname = "origami.lay_other_photos"
    bl_label = "Lay Other Photos"
    bl_options = {"INTERNAL"}
    label = "Add Other Light"
    role = PICTURE

    def prepare(self, context: bpy.types.Context) -> tuple[AnyRequest, Arrays]:
        """As `JobOperator` asks: the document as it is in the scene."""
        known = known_of(self.document)
        if first_stale(known) is not None:
            raise UsageError("The page is not up to date: press Rectify Photos, then add the other light again.")
        self._digest = self.document.state_digest()
        directory = str(Path(bpy.path.abspath(self.directory)).resolve())
        request = LayOtherPhotos(known.placed, known.settings, str(work_folder()), directory)
        return request, state_arrays(known.state)

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """As `JobOperator` asks."""
        document = self.document
        if document.state_digest() != self._digest:
            raise StepFailed(CHANGED)
        flat = reached(document.state, LaidOut).flat
        yield from show_other_page(document, flat, message["name"], job.folder / OTHER_PICTURE)

    def finished_text(self) -> str:
        """Where the page is."""
        return f"The page of {Path(self.directory).name} lies beside the page"


CLASSES = (ORIGAMI_OT_add_other_light, ORIGAMI_OT_lay_other_photos)
