"""The flat page as an object beside the sheet, and the frame around it that marks where the page ends."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.errors import StepFailed
from ...core.sheet import FlatMap
from .mesh_values import read_values

_MOVED = 1e-4  # page heights: a corner nearer to its place has not been moved, but rounded by Blender
_GAP = 0.1  # between sheet and page, in widths of the page
_ABOVE = 5e-4  # page heights: the page lies on the ground, and Blender draws the ground's axes over what is in it
_CORNER_UV = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)


def page_to_object(name: str, uv_layer: str) -> bpy.types.Object:
    """A rectangle with the page's UV map, not in a collection yet; `set_page_size` sets its size."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0)] * 4, [], [(3, 2, 1, 0)])
    layer = mesh.uv_layers.new(name=uv_layer, do_init=False)
    layer.uv.foreach_set("vector", _CORNER_UV[::-1].reshape(-1))
    made = bpy.data.objects.new(name, mesh)
    made.hide_select = True  # the user selects the frame instead
    made.hide_render = True  # a render through a camera must show the same as its photo
    return made


def frame_to_object(name: str) -> bpy.types.Object:
    """The page's four edges, not in a collection yet; the user may move the corners."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0)] * 4, [(0, 1), (1, 2), (2, 3), (3, 0)], [])
    made = bpy.data.objects.new(name, mesh)
    made.show_in_front = made.hide_render = True
    return made


def set_page_size(page_object: bpy.types.Object, flat: FlatMap, place: int = 0) -> None:
    """Make the page, or its frame, a rectangle of the page's size at the n-th place to the right of the sheet."""
    unit = page_unit(flat)
    corners = np.column_stack([_corners(flat) * (1, -1), np.zeros(4)]) * unit
    page_object.data.vertices.foreach_set("co", corners.astype(np.float32).reshape(-1))
    page_object.data.update()
    # Paper that the user has cut off the page is still on the sheet.
    reach = max(flat.width / 2, float(flat.uv[:, 0].max()) - flat.width / 2)
    page_object.location = (
        (reach + flat.width * (_GAP + place * (1 + _GAP))) * unit,
        flat.height / 2 * unit,
        _ABOVE * flat.height * unit,
    )


def framed_corners(frame_object: bpy.types.Object, flat: FlatMap) -> Array:
    """The page's corners where the user has put them, (4, 2): u, v in the flat map's unit, clockwise from top left.

    Raises
    ------
    StepFailed
        If one was deleted.
    """
    if frame_object.type != "MESH" or len(frame_object.data.vertices) < 4:
        raise StepFailed("The page's frame has lost a corner: press Ctrl-Z, or delete the frame and press Make Page.")
    positions = read_values(frame_object.data.vertices, "co", 3, np.float32)[:4, :2].astype(float)
    return positions * (1, -1) / page_unit(flat)


def move_corners(frame_object: bpy.types.Object, flat: FlatMap, corners: Array) -> None:
    """Put the corners (4, 2) of a page's frame, which is not in Edit Mode, where `framed_corners` then finds them."""
    for vertex, (u, v) in zip(frame_object.data.vertices, corners * page_unit(flat), strict=False):
        vertex.co = (u, -v, 0)
    frame_object.data.update()


def corners_moved(frame_object: bpy.types.Object, flat: FlatMap) -> bool:
    """Whether the user has moved any corner of the page."""
    return bool(np.abs(framed_corners(frame_object, flat) - _corners(flat)).max() > _MOVED * flat.height)


def places_on_page(page_object: bpy.types.Object, flat: FlatMap) -> NDArray[np.float32] | None:
    """Where a flat map's vertices are on the page, (V, 3) in its object's frame; None if that is no rectangle."""
    if page_object.type != "MESH" or len(page_object.data.vertices) != len(_CORNER_UV):
        return None
    top_left, top_right, _, bottom_left = read_values(page_object.data.vertices, "co", 3, np.float32)
    share = (flat.uv / (flat.width, flat.height)).astype(np.float32)
    return np.asarray(top_left + share[:, :1] * (top_right - top_left) + share[:, 1:] * (bottom_left - top_left))


def page_unit(flat: FlatMap) -> float:
    """The flat map's unit in Blender's: metres if the paper's size is known, otherwise page heights."""
    return 1e-3 if flat.unit == "mm" else 1 / flat.height


def _corners(flat: FlatMap) -> Array:
    return np.array([[0, 0], [flat.width, 0], [flat.width, flat.height], [0, flat.height]], float)
