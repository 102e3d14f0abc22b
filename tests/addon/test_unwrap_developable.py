"""Unwrap Developable works on the user's own meshes."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import ensure_pins

LENGTH, ANGLE = 2.0, 2.5  # of a part of a cylinder of radius 1


def cylinder(angle: float = ANGLE, columns: int = 24, rows: int = 10):
    """A part of a cylinder as quads, selected and active; a whole one if the angle is a full turn."""
    import bpy

    whole = angle >= 2 * np.pi - 1e-9
    around = np.linspace(0, angle, columns + 1)[: columns if whole else None]
    points = [(np.cos(a), np.sin(a), z) for z in np.linspace(0, LENGTH, rows + 1) for a in around]
    width = len(around)
    faces = [
        (row * width + c, row * width + (c + 1) % width, (row + 1) * width + (c + 1) % width, (row + 1) * width + c)
        for row in range(rows)
        for c in range(columns)
    ]
    mesh = bpy.data.meshes.new("label")
    mesh.from_pydata(points, [], faces)
    made = bpy.data.objects.new("label", mesh)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    return made


def uv_of(mesh_object) -> np.ndarray:
    layer = mesh_object.data.uv_layers.active
    return np.array([corner.vector[:] for corner in layer.uv])


def test_a_label_becomes_a_rectangle(add_on):
    import bpy

    label = cylinder()
    label.scale = (2.0, 2.0, 1.0)
    bpy.context.view_layer.update()
    assert bpy.ops.origami.unwrap_developable(method="conformal_l1") == {"FINISHED"}
    uv = uv_of(label)
    extent = np.sort(np.ptp(uv, axis=0))
    chords = 24 * 2 * np.sin(ANGLE / 48)
    assert extent[1] / extent[0] == pytest.approx(2 * chords / LENGTH, rel=1e-3)
    assert uv.min() >= -1e-6 and uv.max() <= 1 + 1e-6


def test_selected_faces_alone_in_edit_mode(add_on):
    import bmesh
    import bpy

    label = cylinder()
    label.data.uv_layers.new(name="own")
    before = uv_of(label)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    edited = bmesh.from_edit_mesh(label.data)
    for face in edited.faces:
        face.select_set(face.index < 24)
    bmesh.update_edit_mesh(label.data)
    assert bpy.ops.origami.unwrap_developable() == {"FINISHED"}
    assert label.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    changed = np.flatnonzero(np.any(uv_of(label) != before, axis=1))
    assert set(changed.tolist()) <= set(range(24 * 4))
    assert len(changed) > 24 * 3


def test_a_tube_needs_a_seam(add_on):
    import bpy

    tube = cylinder(2 * np.pi)
    with pytest.raises(RuntimeError, match="seam"):
        bpy.ops.origami.unwrap_developable()
    for edge in tube.data.edges:
        edge.use_seam = all(vertex % 24 == 0 for vertex in edge.vertices)
    assert bpy.ops.origami.unwrap_developable() == {"FINISHED"}
    extent = np.sort(np.ptp(uv_of(tube), axis=0))
    assert extent[1] / extent[0] == pytest.approx(24 * 2 * np.sin(np.pi / 24) / LENGTH, rel=1e-3)


def test_pins_stay_and_say_the_scale(add_on):
    import bpy

    label = cylinder()
    ensure_pins(label.data.uv_layers.new(name="own"))
    layer = label.data.uv_layers["own"]
    chords = 24 * 2 * np.sin(ANGLE / 48)
    held = {0: (0.1, 0.2), 24: (0.1 + 0.2 * chords, 0.2)}
    for loop in label.data.loops:
        if loop.vertex_index in held:
            layer.uv[loop.index].vector = held[loop.vertex_index]
    layer.pin.foreach_set("value", [loop.vertex_index in held for loop in label.data.loops])
    assert bpy.ops.origami.unwrap_developable() == {"FINISHED"}
    uv = uv_of(label)
    for loop in label.data.loops:
        if loop.vertex_index in held:
            np.testing.assert_allclose(uv[loop.index], held[loop.vertex_index], atol=1e-6)
    np.testing.assert_allclose(np.ptp(uv, axis=0), [0.2 * chords, 0.2 * LENGTH], rtol=1e-3)


def test_sharp_edges_and_painted_bands_become_straight(add_on):
    import bpy

    label = cylinder()
    random = np.random.default_rng(0)
    for vertex in label.data.vertices:
        vertex.co += 0.01 * __import__("mathutils").Vector(random.normal(size=3))
    ruling = set(range(12, 11 * 25, 25))

    def wave() -> float:
        uv = uv_of(label)
        line = np.array([uv[loop.index] for loop in label.data.loops if loop.vertex_index in ruling])
        spread = np.linalg.svd(line - line.mean(axis=0))[1]
        return float(spread[1] / spread[0])

    assert bpy.ops.origami.unwrap_developable() == {"FINISHED"}
    free = wave()
    for edge in label.data.edges:
        edge.use_edge_sharp = set(edge.vertices) <= ruling
    assert bpy.ops.origami.unwrap_developable(ridges="sharp") == {"FINISHED"}
    assert wave() < 0.2 * free
    label.vertex_groups.new(name="fold").add(sorted(ruling), 1.0, "REPLACE")
    assert bpy.ops.origami.unwrap_developable(ridges="group") == {"FINISHED"}
    assert wave() < 0.2 * free


def test_what_is_no_mesh_is_reported(add_on):
    import bpy

    with pytest.raises(RuntimeError, match="Choose a mesh"):
        bpy.ops.origami.unwrap_developable()


def test_a_linked_mesh_is_refused(add_on, tmp_path):
    """Its new map would be gone the next time that the file is opened."""
    import bpy

    name = cylinder().name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "other.blend"), link=True) as (_, here):
        here.objects = [name]
    bpy.context.scene.collection.objects.link(here.objects[0])
    bpy.context.view_layer.objects.active = here.objects[0]
    with pytest.raises(RuntimeError, match="The mesh is linked from another file"):
        bpy.ops.origami.unwrap_developable()


def test_no_face_selected_is_reported(add_on):
    import bpy

    cylinder()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="No face is selected"):
        bpy.ops.origami.unwrap_developable()


def test_the_job_for_large_meshes_gives_the_same_map(add_on):
    import bpy

    label = cylinder()
    assert bpy.ops.origami.unwrap_developable() == {"FINISHED"}
    at_once = uv_of(label)
    label.data.uv_layers.remove(label.data.uv_layers.active)
    assert bpy.ops.origami.unwrap_mesh() == {"FINISHED"}
    np.testing.assert_array_equal(uv_of(label), at_once)


def test_no_face_of_a_monkey_is_folded_over_and_lengths_change_less_than_by_blenders_own(add_on):
    import bpy
    from origami.core.flat.distortion import measure_strain
    from origami.core.numeric.triangles import signed_areas
    from origami.core.unwrap.islands import find_islands
    from origami.origami_addon.scene.foreign_mesh import read_mesh

    bpy.ops.mesh.primitive_monkey_add()
    monkey = bpy.context.active_object
    read = read_mesh(monkey, "none").arrays
    islands = find_islands(*(read[name] for name in ("vertices", "corner_vertex", "triangles", "seams")))

    def measured() -> tuple[int, float]:
        """How many triangles are turned over, and the largest change of a length."""
        uv, flips, worst = uv_of(monkey), 0, 0.0
        for island in islands:
            flat = np.zeros((len(island.sheet.vertices), 2))
            flat[island.vertex_of_corner] = uv[island.corners]
            turned = int((signed_areas(flat, island.sheet.triangles) <= 0).sum())
            flips += min(turned, len(island.sheet.triangles) - turned)  # Blender may mirror a whole island
            worst = max(worst, measure_strain(island.sheet.vertices, island.sheet.triangles, flat).stretch.max())
        return flips, float(worst)

    assert bpy.ops.origami.unwrap_developable() == {"FINISHED"}
    flips, ours = measured()
    assert flips == 0
    for method in ("ANGLE_BASED", "CONFORMAL", "MINIMUM_STRETCH"):
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.uv.unwrap(method=method, margin=0.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        theirs = measured()
        assert theirs[0] > 0 and theirs[1] > ours, (method, theirs, ours)


@pytest.mark.parametrize(("share", "text"), [(3e-9, "less than 0.01 %"), (0.0123, "1.23 %"), (11.5, "1150.00 %")])
def test_tiny_changes_are_not_written_as_powers_of_ten(share, text):
    from origami.origami_addon.operators.unwrap_developable import _stretch_text

    assert _stretch_text(share, share) == f"Unwrapped: lengths change by {text} on average, {text} at most"
