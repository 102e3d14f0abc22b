"""A whole document put into a scene at once, as the command line does for its file."""

from __future__ import annotations

from itertools import chain
from pathlib import Path

import bpy

from ..state import LaidOut
from .document import Document, document_of, new_document, remove_document
from .shader_nodes import without_nodes
from .show import Pictures, find_camera, show_cameras, show_outline, show_page, show_sheet
from .unfolding import unfolding


def build_document(name: str, state: LaidOut, pictures: Pictures, page: Path) -> Document:
    """Put a whole document into the scene at once, for a file of its own; one of the same name is replaced.

    The page is face up on the ground plane, readable from above, in true size if the paper's size is known; otherwise
    the page is one unit high.

    Parameters
    ----------
    name : str
    state : LaidOut
    pictures : Pictures
    page : Path
        The page image.
    """
    remove_document(name)
    document = new_document(name, bpy.context.scene)
    document.state = state
    for _ in chain(
        show_cameras(document, state, pictures),
        show_outline(document, state),
        show_sheet(document, state, pictures, unfolding(state.sheet, state.flat)),
        show_page(document, state, page, pack=pictures.pack),
    ):
        pass
    if not _is_the_users(bpy.context.scene):
        _set_up(bpy.context.scene, find_camera(document, state.reference), state)
    return document


def _is_the_users(scene: bpy.types.Scene) -> bool:
    """Whether the scene's camera is not from a document: then its settings are the user's."""
    return scene.camera is not None and document_of(scene.camera) is None


def _set_up(scene: bpy.types.Scene, camera_object: bpy.types.Object, state: LaidOut) -> None:
    """Show the page's colours unchanged, in millimetres if the page has them, through the reference camera."""
    scene.camera = camera_object
    scene.render.resolution_x, scene.render.resolution_y = state.reference.width, state.reference.height
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    if scene.world is None:
        scene.world = _even_light()
    if state.flat.unit == "mm":
        scene.unit_settings.system = "METRIC"
        scene.unit_settings.length_unit = "MILLIMETERS"


def _even_light() -> bpy.types.World:
    """White light from everywhere: a render shows the paper as bright as its picture."""
    world = bpy.data.worlds.new("even light")
    nodes, links = without_nodes(world)
    output = nodes.new("ShaderNodeOutputWorld")
    background = nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    links.new(background.outputs["Background"], output.inputs["Surface"])
    background.location, output.location = (0, 0), (300, 0)
    return world
