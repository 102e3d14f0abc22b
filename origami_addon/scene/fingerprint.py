"""Tells an object that still is as it was made from one that was mended by hand.

An object carries the fingerprint of what was put into it; undo, saving and opening the file take it along.
"""

from __future__ import annotations

import hashlib

import bpy
import numpy as np

from .mesh_values import members, read_values
from .ridge_group import RIDGE_GROUP
from .sheet_mesh import PAGE_UV

_FINGERPRINT = "origami_fingerprint"


def remember(made: bpy.types.Object) -> None:
    """Note that an object, in Object Mode, is as it was made."""
    made[_FINGERPRINT] = _fingerprint(made)


def has_fingerprint(made: bpy.types.Object) -> bool:
    """Whether it was noted how the object was made."""
    return _FINGERPRINT in made


def is_as_made(made: bpy.types.Object) -> bool:
    """Whether an object in Object Mode is as it was made, as far as a user can mend it."""
    return bool(made.get(_FINGERPRINT) == _fingerprint(made))


def _fingerprint(made: bpy.types.Object) -> str:
    digest = hashlib.blake2b(digest_size=8)
    if made.type == "CURVE":
        for spline in made.data.splines:
            digest.update(read_values(spline.points, "co", 4, np.float32).tobytes())
    elif made.type == "MESH":
        digest.update(read_values(made.data.vertices, "co", 3, np.float32).tobytes())
        digest.update(members(made, RIDGE_GROUP).tobytes())
        layer = made.data.uv_layers.get(PAGE_UV)
        if layer is not None:
            digest.update(read_values(layer.uv, "vector", 2, np.float32).tobytes())
    return digest.hexdigest()
