"""Unwrapping any developable mesh, from Blender's own UV menus."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty

from ...core.errors import UnusableMesh
from ...core.flatten import FlattenSettings
from ..files.kept import Arrays
from ..jobs.process import Job
from ..scene.foreign_mesh import read_mesh, write_uv
from ..scene.properties import FLATTENER_ITEMS
from .job_operator import JobOperator


class ORIGAMI_OT_unwrap_developable(JobOperator, bpy.types.Operator):
    """Lay a mesh of paper, cloth or sheet metal flat, at its seams and pins, so that lengths stay as they are"""

    bl_idname = "origami.unwrap_developable"
    bl_label = "Unwrap Developable"
    bl_options = {"UNDO"}  # to adjust the last operation would hold the window up: the settings are asked for before
    label = "Unwrap Developable"
    pushes_undo = False
    _asked = False

    method: EnumProperty(
        name="Method", description="What the flat map keeps of the surface", items=FLATTENER_ITEMS, default="arap"
    )
    ridges: EnumProperty(
        name="Straighten",
        description="What becomes straight in the map",
        items=[
            ("none", "Nothing", "Leave all lines as they come out"),
            ("group", "Painted Ridges", "The bands painted into the active vertex group"),
            ("sharp", "Sharp Edges", "The edges marked sharp"),
        ],
        default="none",
    )
    sides: BoolProperty(
        name="Straighten Sides", description="Ask the four sides of a sheet to become straight", default=False
    )

    @classmethod
    def ready(cls, context: bpy.types.Context) -> bool:
        """Whether a mesh is active."""
        if context.active_object is None or context.active_object.type != "MESH":
            cls.poll_message_set("Choose a mesh first")
            return False
        return True

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask how, then work while the window goes on."""
        if bpy.app.background:
            return self.execute(context)
        self._asked = True
        return context.window_manager.invoke_props_dialog(self, confirm_text="Unwrap")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Begin once the user has answered; wait for the end where nobody was asked."""
        return self.begin_modal(context) if self._asked else super().execute(context)

    def prepare(self, context: bpy.types.Context) -> tuple[dict[str, Any], Arrays]:
        """As `JobOperator` asks: the mesh of the active object."""
        self._object = context.active_object.name
        read = read_mesh(context.active_object, self.ridges)
        self._notes = [] if read.warning is None else [read.warning]
        settings = FlattenSettings(self.method, self.ridges != "none", self.sides)
        return {"task": "unwrap", "flatten": asdict(settings)}, read.arrays

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """As `JobOperator` asks: the UV map."""
        mesh_object = bpy.data.objects.get(self._object)
        if mesh_object is None:
            raise UnusableMesh(f"The object {self._object} is no longer there: unwrap it again.")
        self._warned += self._notes
        self._stretch = message["figures"]["stretch_mean"]
        uv = np.load(job.folder / "uv.npy")
        yield
        write_uv(mesh_object, uv)
        yield

    def finished_text(self) -> str:
        """What the map changes of the surface."""
        return f"Unwrapped, stretched by {100 * self._stretch:.2g} % on average"


def menu(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The entry in Blender's UV menus."""
    self.layout.operator(ORIGAMI_OT_unwrap_developable.bl_idname)


CLASSES = (ORIGAMI_OT_unwrap_developable,)
