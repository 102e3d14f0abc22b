"""Shows the results: through the cameras, and the sheet's stretch."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import bpy
from bpy.props import EnumProperty

from ...core.errors import UsageError
from ..presets import PRESETS, apply_preset
from ..scene.camera_object import draw_photo
from ..scene.chosen import active_document
from ..scene.document import Document, document_of, role_of
from ..scene.listed_photos import is_named
from ..scene.roles import CAMERA, OUTLINE, PAGE_FRAME, SHEET
from ..scene.sheet_mesh import BOUND_COLOR, STRETCH_COLOR
from ..scene.view import keep_cameras_aside, show_pictures, show_way, shown_way
from ..stages import Stage, about
from .needs import DocumentOperator

# Type of the objects that the user edits, and the stage that makes them.
_EDITED: dict[str, tuple[str, Stage]] = {
    OUTLINE: ("CURVE", "find"),
    SHEET: ("MESH", "surface"),
    PAGE_FRAME: ("MESH", "page"),
}
_FORMAT = ("resolution_x", "resolution_y", "resolution_percentage")
COLOURINGS = (
    ("TEXTURE", "Picture", "The page, or the photo if there is no page yet"),
    ("VERTEX", "Stretch", "Blue where the flat map keeps lengths, red where it changes them by 2 % or more"),
    (
        "BOUND",
        "Accuracy",
        "Blue where the page is exact, red where it may be off by 0.3 % of its height or more, a millimetre of A4",
    ),
)
_NO_BOUND = (
    "The accuracy of this page is not known: its surface is not Developable, was edited by hand, or is from an older "
    "version. Run Build Surface and Unwrap again with the developable surface."
)
_TRANSPARENCY = ("show_xray", "xray_alpha")


def look_through(context: bpy.types.Context, camera_object: bpy.types.Object, *, past_objects: bool = False) -> None:
    """Show the 3D views through a camera, in the format of its photo.

    Parameters
    ----------
    context : bpy.types.Context
    camera_object : bpy.types.Object
    past_objects : bool
        Whether objects in front of the photo become transparent.
    """
    scene = context.scene
    scene.camera = camera_object
    if (document := document_of(camera_object)) is not None:  # a hidden camera shows no photo
        keep_cameras_aside(document, hidden=False)
    draw_photo(camera_object, "BACK")
    scene.render.resolution_x, scene.render.resolution_y = camera_object["photo_size"]
    scene.render.resolution_percentage = 100
    for area in context.screen.areas if context.screen is not None else ():
        if area.type == "VIEW_3D":
            area.spaces.active.region_3d.view_perspective = "CAMERA"
            area.spaces.active.shading.type = "SOLID"
            show_pictures(area.spaces.active)
            if past_objects:
                area.spaces.active.shading.show_xray = True
                area.spaces.active.shading.xray_alpha = 0.0
            region = next(region for region in area.regions if region.type == "WINDOW")
            with context.temp_override(area=area, region=region):
                bpy.ops.view3d.view_center_camera()


class Restore(Protocol):
    """Restores what `views_to_restore` has noted."""

    def __call__(self, *, transparency_alone: bool = False) -> None:
        """Restore everything, or only how transparent objects are."""


def views_to_restore(context: bpy.types.Context) -> Restore:
    """A function that restores the window's 3D views, and the scene's camera and format, to their present state."""
    scene, screen = context.scene, context.screen
    named, shown = scene.name, "" if screen is None else screen.name
    camera = None if scene.camera is None else scene.camera.name
    size = {name: getattr(scene.render, name) for name in _FORMAT}
    # Positions instead of areas, because the user may close an area meanwhile, and Blender then frees it.
    before = {
        place: {name: _copied(getattr(part, name)) for part, name in _parts_of_view(area)}
        for place, area in enumerate(screen.areas if screen is not None else ())
        if area.type == "VIEW_3D"
    }

    def restore(*, transparency_alone: bool = False) -> None:
        scene = bpy.data.scenes.get(named)
        if scene is not None and not transparency_alone:
            scene.camera = None if camera is None else bpy.data.objects.get(camera)
            for name, value in size.items():
                setattr(scene.render, name, value)
        screen = bpy.data.screens.get(shown)
        areas = dict(enumerate(screen.areas)) if screen is not None else {}
        for place, values in before.items():
            if place in areas and areas[place].type == "VIEW_3D":
                for part, name in _parts_of_view(areas[place]):
                    if name in _TRANSPARENCY or not transparency_alone:
                        setattr(part, name, values[name])

    return restore


def _parts_of_view(area: bpy.types.Area) -> list[tuple[Any, str]]:
    """Everything that `look_through` changes in a 3D view, in the order in which it must be set.

    A view drawn through a camera takes over the camera's rotation.
    """
    space = area.spaces.active
    of_view = ("view_perspective", "view_camera_zoom", "view_camera_offset", "view_rotation")
    of_shading = ("type", "light", "color_type", *_TRANSPARENCY)
    return [
        *((space.region_3d, name) for name in of_view),
        *((space.shading, name) for name in of_shading),
        (space.overlay, "show_relationship_lines"),
    ]


def _copied(value: Any) -> Any:
    return value if isinstance(value, str | float | int) else tuple(value)


def make_active(context: bpy.types.Context, chosen: bpy.types.Object) -> None:
    """Select only this object, in Object Mode, and show it if it is hidden.

    Raises
    ------
    UsageError
        If the user has made something else of the object's data, or the window does not show it, because it is in
        another scene, or its collection is excluded or hidden.
    """
    layer = context.view_layer
    kind, stage = _EDITED[role_of(chosen)]
    if chosen.type != kind:
        raise UsageError(
            f"{chosen.name} is no longer a {kind.lower()}: press Ctrl-Z, or delete it and press {about(stage).verb}."
        )
    if layer.objects.get(chosen.name) != chosen:
        raise UsageError(
            f"{chosen.name} is not in this scene, or its collection is excluded: go to its scene, or tick its "
            "collection in the Outliner."
        )
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    chosen.hide_set(False)
    chosen.hide_viewport = False
    if not chosen.visible_get():
        raise UsageError(f"{chosen.name} is hidden with its collection: show that in the Outliner first.")
    for each in layer.objects:
        each.select_set(each == chosen)
    layer.objects.active = chosen


class ORIGAMI_OT_look_through(DocumentOperator, bpy.types.Operator):
    """Look through the camera of the selected photo: the sheet appears over its photo"""

    bl_idname = "origami.look_through"
    bl_label = "Look Through Camera"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """The camera of the selected photo."""
        document = active_document(context)
        there = document is not None and _camera_of_chosen(document) is not None
        return "" if there else "The selected photo has no camera: place the photos first, or select another"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Go there."""
        look_through(context, _camera_of_chosen(self.document))
        return {"FINISHED"}


class ORIGAMI_OT_show_sheet(DocumentOperator, bpy.types.Operator):
    """Show the sheet with its picture, or coloured by how much the flat map stretches it or how exact its page is"""

    bl_idname = "origami.show_sheet"
    bl_label = "Show Sheet"
    role = SHEET

    by: EnumProperty(
        name="By",
        description="What to colour the sheet by",
        items=COLOURINGS,
    )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """That of the way to colour the sheet."""
        return next(text for by, _, text in COLOURINGS if by == properties.by)

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """A flat sheet."""
        document = active_document(context)
        sheet_object = None if document is None else document.object(SHEET)
        if sheet_object is None or sheet_object.type != "MESH":
            there = False
        else:
            there = STRETCH_COLOR in sheet_object.data.color_attributes
        return "" if there else "There is no flat sheet yet: unwrap it first"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set the shading of the 3D views, and turn those that show the flat page, which has no such colours."""
        attributes = self.object.data.color_attributes
        name = BOUND_COLOR if self.by == "BOUND" else STRETCH_COLOR
        if name not in attributes:
            self.report({"ERROR"}, _NO_BOUND)
            return {"CANCELLED"}
        attributes.active_color = attributes[name]
        document, screen = self.document, context.screen
        views = [area.spaces.active for area in screen.areas if area.type == "VIEW_3D"] if screen is not None else []
        if screen is not None and any(shown_way(document, context.scene, each) == "PAGE" for each in views):
            show_way(document, "SHEET", screen)
        for space in views:
            space.shading.type, space.shading.light = "SOLID", "FLAT"
            space.shading.color_type = "TEXTURE" if self.by == "TEXTURE" else "VERTEX"
        return {"FINISHED"}


class ORIGAMI_OT_apply_preset(DocumentOperator, bpy.types.Operator):
    """Set the document's settings to those for this kind of document"""

    bl_idname = "origami.apply_preset"
    bl_label = "Settings For"
    bl_options = {"REGISTER", "UNDO"}

    preset: EnumProperty(
        name="Kind",
        description="The kind of document",
        items=[(name, preset.label, preset.description) for name, preset in PRESETS.items()],
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set them."""
        apply_preset(self.document.collection.origami.settings, self.preset)
        return {"FINISHED"}


def _camera_of_chosen(document: Document) -> bpy.types.Object | None:
    group = document.collection.origami
    if not 0 <= group.active_photo < len(group.photos):
        return None
    path = Path(bpy.path.abspath(group.photos[group.active_photo].path))
    return next((each for each in document.objects(CAMERA) if is_named(path, each["photo"])), None)


CLASSES = (ORIGAMI_OT_look_through, ORIGAMI_OT_show_sheet, ORIGAMI_OT_apply_preset)
