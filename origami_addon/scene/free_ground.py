"""Puts a new document beside what the scene already holds, and moves all of it with one object."""

from __future__ import annotations

import bpy
import numpy as np

from ...core.arrays import Array
from .document import Document
from .mesh_values import world_corners
from .roles import ORIGIN

_GAP = 0.3  # between a document and what is beside it, in its own width
_SOLID = ("MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD", "VOLUME")  # types that take up room
_DRAWN = 0.02  # size of the origin in Blender's units: two centimetres beside a page


def give_origin(document: Document) -> None:
    """Give a document its origin, to which everything added later is parented; it may have one already."""
    if document.object(ORIGIN) is None:
        origin = bpy.data.objects.new(f"{document.title} origin", None)
        origin.empty_display_size = _DRAWN
        document.add(origin, ORIGIN)


def stand_beside_others(document: Document, parts: tuple[str, ...]) -> None:
    """Move a document to the right of everything that the scene shows, if it stands in its way.

    Parameters
    ----------
    document : Document
        Just made; one without an origin stays.
    parts : tuple of str
        The roles of the parts that need the room.
    """
    scene, origin = document.scene, document.object(ORIGIN)
    if scene is None or origin is None:
        return
    bpy.context.view_layer.update()
    own = _bounds([each for role in parts for each in document.objects(role)])
    others = _bounds(
        [each for each in scene.objects if each.type in _SOLID and not document.made(each) and each.visible_get()]
    )
    if own is None or others is None or (own[0] > others[1]).any() or (own[1] < others[0]).any():
        return
    origin.location.x += others[1, 0] - own[0, 0] + _GAP * (own[1, 0] - own[0, 0])


def _bounds(objects: list[bpy.types.Object]) -> Array | None:
    """The lowest and the highest corner (2, 2) of objects on the ground; None if there are none."""
    if not objects:
        return None
    corners = np.concatenate([world_corners(each) for each in objects])[:, :2]
    return np.array([corners.min(axis=0), corners.max(axis=0)])
