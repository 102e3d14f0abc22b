"""Unwraps any developable mesh, from Blender's own UV menus."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from bpy.props import EnumProperty

from ...core.errors import OrigamiError, UnusableMesh
from ...core.flat.flatten import FlattenSettings
from ...core.setting import declaration
from ...core.unwrap.unwrap import unwrap
from ..files.kept import Arrays
from ..jobs.process import Job
from ..jobs.requests import AnyRequest, UnwrapMesh
from ..scene.declared import declared_property
from ..scene.foreign_mesh import read_mesh, unwrap_arguments, write_uv
from .job_operator import JobOperator
from .needs import Operator
from .nested import start

# Faces' corners in a mesh that is unwrapped at once; 3600 take .4 to 1 s of a processor.
_AT_ONCE = 6000
_SHOWN = 1e-4  # a smaller change of lengths is rounding


class _MeshOperator(Operator):
    """Unwraps the active mesh."""

    alone = True

    method: declared_property(replace(declaration(FlattenSettings, "method"), default="least_stretch"))
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
        """An active mesh of this file."""
        active = context.active_object
        if active is None or active.type != "MESH":
            return "Choose a mesh first"
        return "The mesh is linked from another file: make it local, or open that file" if active.data.library else ""

    @property
    def settings(self) -> FlattenSettings:
        """The settings of the core."""
        return FlattenSettings(self.method, self.ridges != "none", self.sides)


class ORIGAMI_OT_unwrap_developable(_MeshOperator, bpy.types.Operator):
    """Unwrap a mesh of paper, cloth or sheet metal at its seams and pins, with the least change of lengths"""

    bl_idname = "origami.unwrap_developable"
    bl_label = "Unwrap Developable"
    bl_options = {"REGISTER", "UNDO"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Unwrap at once what takes no longer than Blender's own; ask before longer work, which has no redo panel."""
        if not self._takes_long(context):
            return self.execute(context)
        return context.window_manager.invoke_props_dialog(self, confirm_text="Unwrap")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Unwrap, without blocking the window if that would take long."""
        if self.options.is_invoke and self._takes_long(context):
            chosen = {"method": self.method, "ridges": self.ridges, "sides": self.sides}
            start(self, bpy.ops.origami.unwrap_mesh, **chosen)
            return {"CANCELLED"}  # the other operator has its own undo step, and this one is done
        try:
            read = read_mesh(context.active_object, self.ridges)
            unwrapped = unwrap(**unwrap_arguments(read.arrays), settings=self.settings)
            write_uv(context.active_object, unwrapped.uv)
        except OrigamiError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for warning in (read.warning, unwrapped.warning):
            if warning is not None:
                self.report({"WARNING"}, warning)
        self.report({"INFO"}, _stretch_text(unwrapped.mean_stretch, unwrapped.most_stretch))
        return {"FINISHED"}

    def _takes_long(self, context: bpy.types.Context) -> bool:
        return not bpy.app.background and len(context.active_object.data.loops) > _AT_ONCE


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
        return UnwrapMesh(self.settings), read.arrays

    def apply(self, context: bpy.types.Context, message: dict[str, Any], job: Job) -> Iterator[None]:
        """As `JobOperator` asks: the UV map."""
        mesh_object = bpy.data.objects.get(self._object)
        if mesh_object is None:
            raise UnusableMesh(f"The object {self._object} is no longer there: unwrap it again.")
        self._warned += self._notes
        self._stretch = message["figures"]["stretch_mean"], message["figures"]["stretch_most"]
        uv = np.load(job.folder / "uv.npy")
        yield
        write_uv(mesh_object, uv)
        yield

    def finished_text(self) -> str:
        """How much the map stretches the surface."""
        return _stretch_text(*self._stretch)


def _stretch_text(mean: float, most: float) -> str:
    return f"Unwrapped: lengths change by {_percent(mean)} on average, {_percent(most)} at most"


def _percent(share: float) -> str:
    return f"{100 * share:.2f} %" if share > _SHOWN else f"less than {100 * _SHOWN:g} %"


def menu(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The entry in Blender's UV menus."""
    self.layout.operator(ORIGAMI_OT_unwrap_developable.bl_idname)


CLASSES = (ORIGAMI_OT_unwrap_developable, ORIGAMI_OT_unwrap_mesh)
