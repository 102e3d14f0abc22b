"""The sheet's creases as the vertex group `ridge`, which the user may paint and erase.

An edge attribute keeps the order of the vertices along each crease that was found or drawn.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array, Indices
from ...core.creases.creases import crease_figures
from ...core.creases.painted_ridges import PaintedRidges, painted_ridges
from ...core.sheet import Sheet
from .mesh_values import empty_group, members, read_edges, read_values, set_attribute

RIDGE_GROUP = "ridge"
RUN = "ridge_run"  # of an edge: number of its crease, from 1, negative if the crease goes from its end to its start
_SHARP = "sharp_edge"  # Blender's own name: shading is not smoothed across such an edge
_FOLD_ANGLES = "origami_fold_angles"  # of the object: those of the numbered creases in degrees, NaN where unknown
# Folds of at least this angle, in degrees, weigh 1 in the group; flatter ones less, but more than nothing.
_FULL_WEIGHT, _LEAST_WEIGHT = 90.0, 0.05
# Paint within this many edges of a known crease belongs to it.
_BESIDE = 2
# If less than this share of a crease is in the group, it may be a stroke across an erased one, and is read as paint.
_LEAST_SHARE = 0.5


@dataclass(frozen=True)
class Creases:
    """The creases in the group, each as a list of vertices.

    Attributes
    ----------
    known : dict of int to Indices
        Those with which the sheet was built, by their number, from 0; erased ones are missing.
    painted : tuple of Indices
        Those painted since then.
    """

    known: dict[int, Indices]
    painted: tuple[Indices, ...]


def put_ridges(sheet_object: bpy.types.Object, sheet: Sheet) -> None:
    """Mark the edges along a sheet's creases, and put their vertices into the group, weighted by fold sharpness."""
    runs = _ridge_runs(sheet_object.data, sheet.ridges)
    set_attribute(sheet_object.data, RUN, "INT", "EDGE", runs)
    set_attribute(sheet_object.data, _SHARP, "BOOLEAN", "EDGE", runs != 0)
    group = empty_group(sheet_object, RIDGE_GROUP)
    angles = np.array([crease.fold_angle for crease in crease_figures(sheet)])
    sheet_object[_FOLD_ANGLES] = angles.tolist()
    strengths = np.clip(np.abs(np.nan_to_num(angles, nan=_FULL_WEIGHT)) / _FULL_WEIGHT, _LEAST_WEIGHT, 1)
    for number in np.argsort(strengths):  # where creases meet, the sharpest counts
        group.add(sheet.ridges[number].tolist(), float(strengths[number]), "REPLACE")


def _ridge_runs(mesh: bpy.types.Mesh, ridges: tuple[Indices, ...]) -> NDArray[np.int32]:
    """For each edge the number of its crease, signed by direction."""
    edges = read_edges(mesh)
    runs = np.zeros(len(edges), np.int32)
    if not ridges:
        return runs
    steps = np.concatenate([np.column_stack([ridge[:-1], ridge[1:]]) for ridge in ridges])
    number = np.repeat(np.arange(1, len(ridges) + 1), [len(ridge) - 1 for ridge in ridges])
    # Either end of an edge may come first, in the mesh and in a crease.
    keys, wanted = (np.sort(pairs, axis=1) @ (len(mesh.vertices), 1) for pairs in (edges, steps))
    order = np.argsort(keys)
    at = order[np.searchsorted(keys, wanted, sorter=order)]
    runs[at] = np.where(edges[at, 0] == steps[:, 0], number, -number)
    return runs


def fold_angles(sheet_object: bpy.types.Object) -> dict[int, float | None]:
    """Fold angle in degrees of each crease with which the sheet was built, by its number; None if unknown."""
    angles = enumerate(sheet_object.get(_FOLD_ANGLES, ()))
    return {number: None if np.isnan(angle) else float(angle) for number, angle in angles}


def read_ridges(sheet_object: bpy.types.Object, flat: Array | None = None) -> tuple[Indices, ...]:
    """All creases, known ones first, painted ones last; parameters as for `read_creases`."""
    creases = read_creases(sheet_object, flat)
    return (*creases.known.values(), *creases.painted)


def read_creases(sheet_object: bpy.types.Object, flat: Array | None = None) -> Creases:
    """The creases: the known ones that are still in the group, and those painted since then.

    Parameters
    ----------
    sheet_object : bpy.types.Object
        Not in Edit Mode.
    flat : (V, 2) array, optional
        The vertices on the flat page, on which painted creases are straight; without it they are straight in space.
    """
    in_group = members(sheet_object, RIDGE_GROUP)
    known = _known_ridges(sheet_object.data, in_group)
    return Creases(known, _painted_since(sheet_object.data, in_group, known, flat).runs)


def _painted_since(
    mesh: bpy.types.Mesh, in_group: Indices, known: dict[int, Indices], flat: Array | None
) -> PaintedRidges:
    """The creases painted into the group in addition to the known ones, and the painted spots that show no crease."""
    painted = np.zeros(len(mesh.vertices), bool)
    painted[in_group] = True
    taken = np.zeros(len(painted), bool)
    taken[np.concatenate([np.zeros(0, np.int64), *known.values()])] = True
    if not (painted & ~taken).any():
        return PaintedRidges((), ())
    edges = read_edges(mesh)
    for _ in range(_BESIDE):
        taken[edges[taken[edges].any(axis=1)]] = True
    positions = read_values(mesh.vertices, "co", 3, np.float32).astype(float) if flat is None else flat
    return painted_ridges(positions, edges, (painted & ~taken).astype(float))


def _known_ridges(mesh: bpy.types.Mesh, in_group: Indices) -> dict[int, Indices]:
    """The creases of the marked edges, by number, as far as both ends are still in the group."""
    if RUN not in mesh.attributes or not len(in_group):
        return {}
    runs = read_values(mesh.attributes[RUN].data, "value", 1, np.int32)
    marked = np.flatnonzero(runs)
    left = set(in_group.tolist())
    steps: dict[int, list[tuple[int, int]]] = {}
    for run, (a, b) in zip(runs[marked].tolist(), read_edges(mesh)[marked].tolist(), strict=True):
        if a in left and b in left:
            steps.setdefault(abs(run), []).append((a, b) if run > 0 else (b, a))
    whole = np.bincount(np.abs(runs[marked]))
    ridges: dict[int, Indices] = {}
    for number in sorted(steps):
        following = dict(steps[number])
        starts = [a for a in following if a not in set(following.values())] or list(following)[:1]
        for start in starts:
            line = [start]
            while line[-1] in following:
                line.append(following.pop(line[-1]))
            if len(line) - 1 >= _LEAST_SHARE * whole[number]:
                ridges[number - 1] = np.array(line, np.int64)
    return ridges
