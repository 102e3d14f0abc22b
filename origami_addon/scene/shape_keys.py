"""The shape keys that unfold a sheet with one slider, **Unfold**: 0 is folded, 1 is flat.

Blender and other programs blend shape keys straight, which would shorten the paper. So each vertex moves along a Bézier
curve of degree 4 through its places at `BETWEEN`: further keys hold what its control points add to the straight blend,
weighed by Bernstein's polynomials of the slider, which stay between 0 and 1, as many programs demand. The curve follows
turning paper better than straight pieces between the same places: the largest stretch of a letter folded in three by
120 degrees is .004 % instead of 1.1 % (16 % without these keys), and of a sheet rolled up by 270 degrees .16 instead of
4.1 % (60 %).
"""

from __future__ import annotations

from math import comb

import bpy
import numpy as np

from ...core.arrays import Array
from .mesh_values import read_values
from .modes import in_edit_mode

UNFOLD = "Unfold"
BETWEEN = (0.25, 0.5, 0.75)  # the places on the way
_DEGREE = len(BETWEEN) + 1
_BENDS = {number: f"{UNFOLD} Bend {number}" for number in range(1, _DEGREE)}  # the inner control points' keys
_ACTION = "origami_unfold_action"  # of the object: the user's animation of its keys, while it has none
_FRAMES = 48  # of an exported opening: two seconds


def put_unfolding(sheet_object: bpy.types.Object, shapes: Array) -> None:
    """Give a sheet the slider, or move its shapes: the slider's value and animation stay.

    Parameters
    ----------
    sheet_object : bpy.types.Object
        In Object Mode.
    shapes : (K + 1, V, 3) array
        Its vertices at each of the K places `BETWEEN`, and flat.
    """
    mesh = sheet_object.data
    folded = read_values(mesh.vertices, "co", 3, np.float32).astype(float)
    if mesh.shape_keys is None:
        sheet_object.shape_key_add(name="Basis", from_mix=False)
    _put_key(sheet_object, UNFOLD, shapes[-1])
    places = np.array(BETWEEN)[:, None, None]
    lacking = shapes[:-1] - ((1 - places) * folded + places * shapes[-1])
    weights = np.array([[_weight(number, place) for number in _BENDS] for place in BETWEEN])
    for number, added in zip(_BENDS, np.tensordot(np.linalg.inv(weights), lacking, axes=1), strict=True):
        _drive(_put_key(sheet_object, _BENDS[number], folded + added), number)
    sheet_object.active_shape_key_index = 0  # Edit Mode edits the folded sheet
    _return_action(sheet_object)


def unfold_slider(sheet_object: bpy.types.Object) -> bpy.types.ShapeKey | None:
    """The key whose value, from 0 to 1, says how far open the sheet is; None if it has never been flat."""
    keys = sheet_object.data.shape_keys
    return None if keys is None else keys.key_blocks.get(UNFOLD)


def unfolded_share(sheet_object: bpy.types.Object) -> float:
    """How far open the sheet is shown, from 0 to 1."""
    slider = unfold_slider(sheet_object)
    return 0.0 if slider is None else float(slider.value)


def shown_positions(sheet_object: bpy.types.Object) -> Array:
    """The vertices (V, 3) of a sheet as it is shown; folded in Edit Mode, or if a modifier changes their number."""
    mesh = sheet_object.data
    folded = read_values(mesh.vertices, "co", 3, np.float32)
    if in_edit_mode(sheet_object) or unfolded_share(sheet_object) == 0:
        return folded
    shown = sheet_object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return read_values(shown.vertices, "co", 3, np.float32) if len(shown.vertices) == len(folded) else folded


def clear_shape_keys(sheet_object: bpy.types.Object) -> None:
    """Remove all shape keys; the user's animation of them waits for `put_unfolding`."""
    keys = sheet_object.data.shape_keys
    if keys is None:
        return
    if keys.animation_data is not None and keys.animation_data.action is not None:
        sheet_object[_ACTION] = keys.animation_data.action
    sheet_object.shape_key_clear()


def move_vertices(mesh: bpy.types.Mesh, positions: Array) -> None:
    """Move a mesh to other positions (V, 3) of its vertices, and its shape keys along with it."""
    if mesh.shape_keys is not None:
        moved = positions - read_values(mesh.vertices, "co", 3, np.float32)
        for key in mesh.shape_keys.key_blocks:
            own = key != mesh.shape_keys.reference_key
            _set_positions(key.data, read_values(key.data, "co", 3, np.float32) + moved if own else positions)
    _set_positions(mesh.vertices, positions)
    mesh.update()


def animate_opening(sheet_object: bpy.types.Object) -> bpy.types.Action:
    """Replace the drivers, which other programs do not know, by an animation in which the sheet opens; it is folded."""
    keys = sheet_object.data.shape_keys
    keys.animation_data_clear()
    for frame in range(_FRAMES + 1):
        _open(keys, frame / _FRAMES)
        for name in (UNFOLD, *_BENDS.values()):
            keys.key_blocks[name].keyframe_insert("value", frame=frame)
    _open(keys, 0.0)
    action = keys.animation_data.action
    action.name = UNFOLD
    return action


def _open(keys: bpy.types.Key, share: float) -> None:
    keys.key_blocks[UNFOLD].value = share
    for number, name in _BENDS.items():
        keys.key_blocks[name].value = _weight(number, share)


def _weight(number: int, share: float) -> float:
    """Bernstein's polynomial of a control point at a share of the way."""
    return comb(_DEGREE, number) * share**number * (1 - share) ** (_DEGREE - number)


def _put_key(sheet_object: bpy.types.Object, name: str, shape: Array) -> bpy.types.ShapeKey:
    keys = sheet_object.data.shape_keys.key_blocks
    key = keys.get(name)
    if key is None:
        key = sheet_object.shape_key_add(name=name, from_mix=False)
        key.value = 0.0  # Blender 5.0 adds it at 1
    _set_positions(key.data, shape)
    return key


def _drive(key: bpy.types.ShapeKey, number: int) -> None:
    """Weigh a control point's key by its polynomial of the slider."""
    key.driver_remove("value")
    driver = key.driver_add("value").driver
    slider = driver.variables.new()
    slider.name = "unfold"
    slider.targets[0].id_type = "KEY"
    slider.targets[0].id = key.id_data
    slider.targets[0].data_path = f'key_blocks["{UNFOLD}"].value'
    # Simple enough for Blender to compute it without Python, even in files from others.
    factors = ["unfold"] * number + ["(1 - unfold)"] * (_DEGREE - number)
    driver.expression = " * ".join([str(comb(_DEGREE, number)), *factors])


def _return_action(sheet_object: bpy.types.Object) -> None:
    action = sheet_object.pop(_ACTION, None)
    keys = sheet_object.data.shape_keys
    if action is not None and keys.animation_data.action is None:
        keys.animation_data.action = action
        if keys.animation_data.action_slot is None and keys.animation_data.action_suitable_slots:
            keys.animation_data.action_slot = keys.animation_data.action_suitable_slots[0]


def _set_positions(items: bpy.types.bpy_prop_collection, positions: Array) -> None:
    items.foreach_set("co", positions.astype(np.float32).reshape(-1))
