"""The map of least stretch: exact where lengths can be kept, without flips everywhere, less stretched than others."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import corners, label, quads
from origami.core.flat.convex_map import convex_map
from origami.core.flat.distortion import measure_strain
from origami.core.flat.flatten import FlattenSettings, flatten
from origami.core.flat.least_stretch import has_flips
from origami.core.flat.pins import Pins
from origami.core.numeric.triangles import closed_loops
from origami.core.sheet import Sheet


def sheet_of(vertices, faces, *, without=()) -> Sheet:
    """Quads as a sheet; faces may be left out, for a hole."""
    kept = np.delete(np.arange(len(faces)), list(without))
    corner, triangles = corners(faces[kept])
    used, triangles = np.unique(corner[triangles], return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    loops = closed_loops(triangles)
    return Sheet(vertices[used], triangles, (), max(loops, key=len))


def bag(deep: float) -> tuple[np.ndarray, np.ndarray]:
    """A square that bulges into a bag, which every conformal map shrinks, and others fold over."""

    def place(u, v):
        across, up = 2 * u - 1, 2 * v - 1
        inward = np.sin(np.pi * u) * np.sin(np.pi * v)
        return np.stack([across * (1 - 0.5 * inward), up * (1 - 0.5 * inward), deep * inward**0.5], -1)

    return quads(21, 21, place)


def stretch(sheet, uv):
    return measure_strain(sheet.vertices, sheet.triangles, uv).stretch


def change(sheet, uv):
    """By which factor a length is changed at most, longer or shorter."""
    values = measure_strain(sheet.vertices, sheet.triangles, uv).singular_values
    return np.maximum(values, 1 / values).max()


def test_a_label_keeps_its_lengths():
    sheet = sheet_of(*label())
    assert stretch(sheet, flatten(sheet, FlattenSettings("least_stretch"))).max() < 1e-6


@pytest.mark.parametrize("deep", [0.5, 2.0, 6.0])
def test_it_never_folds_over_and_stretches_less_than_the_others(deep):
    sheet = sheet_of(*bag(deep))
    uv = flatten(sheet, FlattenSettings("least_stretch"))
    assert not has_flips(uv * (1, -1), sheet.triangles)
    worst = change(sheet, uv)
    for method in ("arap", "lscm"):
        other = flatten(sheet, FlattenSettings(method), robust_start=False)
        assert has_flips(other * (1, -1), sheet.triangles) or change(sheet, other) > worst, method


def test_the_map_on_a_circle_has_no_flips_whatever_the_surface():
    vertices, faces = bag(6.0)
    for sheet in (sheet_of(vertices, faces), sheet_of(vertices, faces, without=(150, 151, 170, 230))):
        flat = convex_map(sheet)
        assert not has_flips(flat, sheet.triangles)
        np.testing.assert_allclose(np.linalg.norm(flat[sheet.boundary], axis=1), 1)
    turned = Sheet(sheet.vertices, sheet.triangles, (), sheet.boundary[::-1])
    assert not has_flips(convex_map(turned), sheet.triangles)


def test_a_hole_keeps_its_form():
    vertices, faces = label()
    sheet = sheet_of(vertices, faces, without=(420, 421, 460, 461))
    assert len(closed_loops(sheet.triangles)) == 2
    assert stretch(sheet, flatten(sheet, FlattenSettings("least_stretch"))).max() < 1e-6


def test_a_single_triangle():
    sheet = Sheet(np.array([[0, 0, 0], [1, 0, 0], [0.3, 0.8, 0.0]]), np.array([[0, 1, 2]]), (), np.array([0, 1, 2]))
    assert stretch(sheet, flatten(sheet, FlattenSettings("least_stretch"))).max() < 1e-9
    assert not has_flips(convex_map(sheet), sheet.triangles)


def test_pins_stay_where_they_are():
    sheet = sheet_of(*bag(0.5))
    free = flatten(sheet, FlattenSettings("least_stretch"))
    held = np.array([0, 20, 420, 440])
    pins = Pins(held, free[held] * 1.02)
    uv = flatten(sheet, FlattenSettings("least_stretch"), pins=pins)
    np.testing.assert_array_equal(uv[held], pins.uv)
    assert not has_flips(uv * (1, -1), sheet.triangles)
