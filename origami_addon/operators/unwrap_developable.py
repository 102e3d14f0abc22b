"""Unwraps any developable mesh, from Blender's own UV menus."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np
from bpy.props import EnumProperty

from ...core.errors import UnusableMesh
from ...core.flat.flatten import FlattenSettings
from ...core.setting import declaration
from ..files.kept import Arrays
from ..jobs.process import Job
from ..jobs.requests import AnyRequest, UnwrapMesh
from ..scene.declared import declared_property
from ..scene.foreign_mesh import read_mesh, write_uv
from .job_operator import JobOperator
from .needs import Operator
from .nested import start


class _MeshOperator(Operator):
    """Unwraps the active mesh."""

    alone = True

    method: declared_property(declaration(FlattenSettings, "method"))
    ridges: EnumProperty(
        name="Straighten",
        description="What becomes straight in the map",
        items=[
            ("none", "Nothing", "Straighten nothing"),
            ("group", "Painted Ridges", "The bands painted into the active vertex group"),
            ("sharp", "Sharp Edges", "The edges marked sharp"),
        ],
        default="none",
    )
    sides: declared_property(declaration(FlattenSettings, "boundary_rows"))

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """An active mesh."""
        there = context.active_object is not None and context.active_object.type == "MESH"
        return "" if there else "Choose a mesh first"


class ORIGAMI_OT_unwrap_developable(_MeshOperator, bpy.types.Operator):
    """Unwrap a mesh of paper, cloth or sheet metal at its seams and pins without changing lengths"""

    bl_idname = "origami.unwrap_developable"
    bl_label = "Unwrap Developable"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the options."""
        if bpy.app.background:
            return self.execute(context)
        return context.window_manager.invoke_props_dialog(self, confirm_text="Unwrap")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Unwrap, without blocking the window if there is one."""
        chosen = {"method": self.method, "ridges": self.ridges, "sides": self.sides}
        return {"FINISHED"} if start(self, bpy.ops.origami.unwrap_mesh, **chosen) else {"CANCELLED"}


class ORIGAMI_OT_unwrap_mesh(_MeshOperator, JobOperator, bpy.types.Operator):
    """Unwrap a mesh with given settings"""

    bl_idname = "origami.unwrap_mesh"
    bl_label = "Unwrap Developable"  # the name of its undo step
    bl_options = {"UNDO", "INTERNAL"}
    label = "Unwrap Developable"
    pushes_undo = False

    def prepare(self, context: bpy.types.Context) -> tuple[AnyRequest, Arrays]:
        """As `JobOperator` asks: the mesh of the active object."""
        self._object = context.active_object.name
        read = read_mesh(context.active_object, self.ridges)
        self._notes = [] if read.warning is None else [read.warning]
        settings = FlattenSettings(self.method, self.ridges != "none", self.sides)
        return UnwrapMesh(settings), read.arrays

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
        """How much the map stretches the surface."""
        return f"Unwrapped, stretched by {100 * self._stretch:.2g} % on average"


def menu(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The entry in Blender's UV menus."""
    self.layout.operator(ORIGAMI_OT_unwrap_developable.bl_idname)


CLASSES = (ORIGAMI_OT_unwrap_developable, ORIGAMI_OT_unwrap_mesh)
