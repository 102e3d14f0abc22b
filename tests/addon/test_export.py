"""The files of a document are correct as other programs read them."""

from __future__ import annotations

import errno
import json
import os
import struct
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from folded import folded_sheet
from origami.core.errors import StepFailed
from origami.core.fusion.fusion import fuse_page
from origami.core.page.single_photo import page_of_photo
from origami.core.watch import SILENT
from origami.origami_addon.export.models import (
    PHOTO_STEP,
    write_glb,
    write_map,
    write_obj,
    write_sheet,
    write_usd,
)
from origami.origami_addon.export.outputs import (
    KINDS,
    OUTPUTS,
    Finished,
    chosen,
    names_of,
    sheet_with_page,
    write_outputs,
)
from origami.origami_addon.files.image_files import from_blender_image, write_jpeg
from origami.origami_addon.report import Report
from origami.origami_addon.scene.camera_object import VIEWS, write_views
from origami.origami_addon.scene.roles import SHEET
from origami.origami_addon.scene.show import Pictures
from origami.origami_addon.scene.whole_document import build_document
from origami.origami_addon.state import Page, Paged

SIZE = (200, 250)


@pytest.fixture(scope="module")
def case():
    return folded_sheet()


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "Ausgabe ü 1"
    folder.mkdir()
    return folder


@pytest.fixture
def sheet_object(case, out, empty_scene):
    write_jpeg(out / "page.jpg", case.photos[0], 100)
    write_jpeg(out.parent / "Foto ü 0.jpg", case.photos[1], 100)
    views = list(write_views(out / VIEWS, case.model.cameras, case.photos.__getitem__))
    pictures = Pictures(views, [out.parent / "Foto ü 0.jpg"] * 2, pack=False)
    return build_document("Brief ü", case.state, pictures, out / "page.jpg").object(SHEET)


def test_glb_holds_the_mesh_its_map_and_the_page(case, out, sheet_object):
    write_glb(out / "sheet.glb", sheet_object)
    data = (out / "sheet.glb").read_bytes()
    content = json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])
    (mesh,) = content["meshes"]
    assert "TEXCOORD_0" in mesh["primitives"][0]["attributes"]
    assert content["accessors"][mesh["primitives"][0]["indices"]]["count"] == case.sheet.triangles.size
    assert [image["mimeType"] for image in content["images"]] == ["image/jpeg"]
    assert len(content["nodes"]) == 1


def test_obj_holds_the_mesh_its_map_and_the_name_of_the_page(case, out, sheet_object):
    write_obj(out / "sheet.obj", sheet_object)
    lines = [line.split() for line in (out / "sheet.obj").read_text(encoding="utf-8").splitlines()]
    positions = np.array([line[1:] for line in lines if line[:1] == ["v"]], float)
    uv = np.array([line[1:] for line in lines if line[:1] == ["vt"]], float)
    assert len(positions) == len(case.sheet.vertices)
    assert sum(line[:1] == ["f"] for line in lines) == len(case.sheet.triangles)
    np.testing.assert_allclose(uv.min(axis=0), [0, 0], atol=1e-5)
    np.testing.assert_allclose(uv.max(axis=0), [1, 1], atol=1e-5)
    assert "map_Kd page.jpg" in (out / "sheet.mtl").read_text(encoding="utf-8")


WRITERS = {"sheet.glb": write_glb, "sheet.obj": write_obj, "sheet.usdz": write_usd}


@pytest.mark.parametrize("name", WRITERS)
def test_exported_sheet_comes_back_as_it_was(case, out, sheet_object, name):
    import bpy

    WRITERS[name](out / name, sheet_object)
    there = positions_of(sheet_object), corners_of(sheet_object, "page")
    before = set(bpy.data.objects)
    if name.endswith("glb"):
        bpy.ops.import_scene.gltf(filepath=str(out / name))
    elif name.endswith("obj"):
        bpy.ops.wm.obj_import(filepath=str(out / name))
    else:
        bpy.ops.wm.usd_import(filepath=str(out / name))
    (read,) = (item for item in set(bpy.data.objects) - before if item.type == "MESH")
    positions, corners = positions_of(read), corners_of(read, read.data.uv_layers.active.name)
    assert len(corners) == case.sheet.triangles.size
    # some formats change the order of vertices: compare each corner's position in space and on the page
    expected = sorted(np.hstack([there[0][corner_vertices(sheet_object)], there[1]]).round(4).tolist())
    found = sorted(np.hstack([positions[corner_vertices(read)], corners]).round(4).tolist())
    np.testing.assert_allclose(found, expected, atol=2e-4)
    (material,) = read.data.materials
    (image,) = (node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE")
    page = bpy.data.images.load(str(out / "page.jpg"))
    np.testing.assert_array_equal(from_blender_image(image), from_blender_image(page))


@pytest.mark.parametrize("name", ["sheet.glb", "sheet.usdz"])
def test_export_shows_the_page_whatever_the_window_shows(out, sheet_object, name):
    import bpy

    mesh = sheet_object.data
    assert [layer.name for layer in mesh.color_attributes]
    mesh.uv_layers.active = mesh.uv_layers["photo"]
    mesh.uv_layers["photo"].active_render = True
    mesh.materials[0], mesh.materials[1] = mesh.materials[1], mesh.materials[0]
    for image in bpy.data.images:
        if image.has_data or image.size[0]:
            image.pack()
    WRITERS[name](out / name, sheet_object)
    before = set(bpy.data.objects)
    if name == "sheet.glb":
        bpy.ops.import_scene.gltf(filepath=str(out / name))
    else:
        bpy.ops.wm.usd_import(filepath=str(out / name))
    (read,) = (item for item in set(bpy.data.objects) - before if item.type == "MESH")
    assert len(read.data.uv_layers) == 1
    assert not list(read.data.color_attributes)
    (material,) = read.data.materials
    (image,) = (node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE")
    page = bpy.data.images.load(str(out / "page.jpg"))
    np.testing.assert_array_equal(from_blender_image(image), from_blender_image(page))
    corners = corners_of(read, read.data.uv_layers[0].name)
    np.testing.assert_allclose(corners.min(axis=0), [0, 0], atol=1e-5)
    np.testing.assert_allclose(corners.max(axis=0), [1, 1], atol=1e-5)


def test_usdz_is_a_package_as_other_programs_want_it(out, sheet_object):
    import bpy

    write_usd(out / "sheet.usdz", sheet_object)
    with zipfile.ZipFile(out / "sheet.usdz") as package:
        assert [entry.filename for entry in package.infolist()] == ["sheet.usdc", "textures/page.jpg"]
        assert all(entry.compress_type == zipfile.ZIP_STORED for entry in package.infolist())
        assert package.read("textures/page.jpg") == (out / "page.jpg").read_bytes()
    assert sorted(path.name for path in out.iterdir()) == ["cameras", "page.jpg", "sheet.usdz"]
    bpy.ops.wm.usd_import(filepath=str(out / "sheet.usdz"))
    assert "st" in bpy.context.object.data.uv_layers


def positions_of(mesh_object):
    """World positions of its vertices, (V, 3)."""
    local = np.array([vertex.co for vertex in mesh_object.data.vertices])
    matrix = np.array(mesh_object.matrix_world)
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def corners_of(mesh_object, layer):
    """Place of each corner of its triangles on the page, (3F, 2)."""
    return np.array([item.vector for item in mesh_object.data.uv_layers[layer].uv])


def corner_vertices(mesh_object):
    """Index of the vertex at each corner of its triangles, (3F,)."""
    return np.array([loop.vertex_index for loop in mesh_object.data.loops])


def finished(case, folder) -> Finished:
    """The document, ready for export."""
    texture = page_of_photo(case.sheet, case.flat, case.model.cameras, case.photos.__getitem__, 0, SIZE)
    return Finished(
        Paged(*vars(case.state).values(), Page(texture, 100, texture.image)),
        photo=lambda: case.photos[0],
        profile=None,
        bits=None,
        make_object=lambda done: sheet_with_page(done, folder),
        home=folder,
        title="Brief ü",
    )


def test_no_two_outputs_have_a_name_or_a_kind_in_common():
    names = names_of(OUTPUTS)
    assert len(names) == len({*names})
    assert len(KINDS) == sum(bool(each.kind) for each in OUTPUTS)
    assert all(bool(each.label) == bool(each.kind) for each in OUTPUTS)
    assert {name for each in OUTPUTS for name in each.beside} <= {*names}
    for each in OUTPUTS:
        assert each.help[0] == each.help[0].lower() and not each.help.endswith(".") and "|" not in each.help


@pytest.mark.parametrize("each", [each for each in OUTPUTS if each.in_run], ids=lambda each: each.name)
def test_each_output_can_be_written_alone(case, out, tmp_path, empty_scene, each):
    report = Report({})
    write_outputs([each], out, finished(case, tmp_path), report, SILENT)
    assert sorted(path.name for path in out.iterdir()) == sorted((each.name, *each.also))
    assert [stage["name"] for stage in report.stages] == [each.part]


def test_page_size_is_the_papers_not_that_of_its_pixels(case, tmp_path):
    done = finished(case, tmp_path)
    assert done.size_mm == (case.flat.width, case.flat.height)
    flat = replace(case.flat, unit="page heights", width=0.8, height=1.0)
    unknown = replace(done, state=replace(done.state, flat=flat))
    assert unknown.size_mm == pytest.approx((SIZE[0] / 100 * 25.4, SIZE[1] / 100 * 25.4))


def test_a_model_never_has_an_older_picture(case, out):
    older = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    for kinds in (["obj"], ["gltf", "jpeg", "obj"], ["gltf"]):
        work = out / "-".join(kinds)
        work.mkdir()
        write_jpeg(out / "page.jpg", older, 100)
        before = (out / "page.jpg").read_bytes()
        write_outputs(chosen(kinds), out, finished(case, work), Report({}), SILENT)
        assert ((out / "page.jpg").read_bytes() == before) == (kinds == ["gltf"])
        assert {path.name for path in out.iterdir() if path.is_file()} >= set(names_of(chosen(kinds)))


def test_exports_leave_the_document_as_it_was(out, sheet_object):
    import bpy

    before = sorted(item.name for item in bpy.data.objects), len(bpy.data.meshes), len(bpy.data.scenes)
    for name, write in WRITERS.items():
        write(out / name, sheet_object)
    assert (sorted(item.name for item in bpy.data.objects), len(bpy.data.meshes), len(bpy.data.scenes)) == before


def test_sheet_file_holds_positions_and_cameras_in_the_frame_of_the_points(case, out):
    write_sheet(out / "sheet.npz", case.sheet, case.flat, case.model.cameras)
    read = np.load(out / "sheet.npz")
    np.testing.assert_array_equal(read["xyz"], case.sheet.vertices)
    np.testing.assert_array_equal(read["uv"], case.flat.uv)
    assert str(read["unit"]) == "mm"
    assert read["cam_names"].tolist() == ["Foto ü 0.jpg", "Foto ü 1.jpg"]
    camera = case.model.cameras[1]
    np.testing.assert_allclose(read["cam_centers"][1], camera.center)
    in_camera = read["xyz"] @ read["cam_rotations"][1].T + read["cam_translations"][1]
    normalized = in_camera[:, :2] / in_camera[:, 2:]
    r2 = (normalized**2).sum(axis=1, keepdims=True)
    k1, k2 = read["cam_distortions"][1]
    pixels = normalized * (1 + k1 * r2 + k2 * r2**2) * read["cam_focal_lengths"][1] + read["cam_principal_points"][1]
    np.testing.assert_allclose(pixels, camera.project(case.sheet.vertices))
    assert read["cam_sizes"][1].tolist() == [camera.width, camera.height]
    runs = np.split(read["ridges"], np.cumsum(read["ridge_lengths"])[:-1])
    np.testing.assert_array_equal(runs[1], case.sheet.ridges[1])


def test_sheet_file_says_how_exact_the_map_is_in_its_unit(case, out):
    write_sheet(out / "sheet.npz", case.sheet, case.flat, case.model.cameras)
    unknown = np.load(out / "sheet.npz")
    assert np.isnan(unknown["uv_bound"]).all()
    assert unknown["uv_bound"].shape == (len(case.flat.uv),)
    bound = np.linspace(0, 0.02, len(case.sheet.vertices))
    write_sheet(out / "sheet.npz", replace(case.sheet, bound=bound), case.flat, case.model.cameras)
    np.testing.assert_allclose(np.load(out / "sheet.npz")["uv_bound"], 40 * bound, rtol=1e-6)


def test_map_leads_from_page_to_photo_and_back(case, out):
    texture = fuse_page(case.sheet, case.flat, case.model.cameras, case.photos.__getitem__, 0, SIZE).texture
    write_map(out / "map.npz", texture, case.sheet, case.flat, case.model.cameras)
    read = np.load(out / "map.npz")
    np.testing.assert_array_equal(read["photo"], texture.photo)
    position = np.cumsum(read["position_delta"], axis=1, dtype=np.uint16) / read["position_scale"]
    known = texture.photo >= 0
    np.testing.assert_allclose(position[known], texture.position[known], atol=0.04)
    for row, column in ((60, 50), (200, 150)):
        photo, (x, y) = read["photo"][row, column], position[row, column]
        u, v = read["to_page"][photo, int(y // PHOTO_STEP), int(x // PHOTO_STEP)]
        expected = (np.array([column, row]) + 0.5) / SIZE * read["page_size"]
        np.testing.assert_allclose([u, v], expected, atol=3.5)  # mm: up to half a step of 8 pixels either way
    assert "position_delta" in str(read["readme"])


def test_unwritable_place_is_reported(case, out, sheet_object):
    for name, write in WRITERS.items():
        (out / name).mkdir()
        with pytest.raises(StepFailed, match=f"{name} could not be written"):
            write(out / name, sheet_object)


@pytest.mark.parametrize("name", WRITERS)
def test_full_disk_is_reported_in_one_line(out, sheet_object, monkeypatch, name):
    from origami.origami_addon.files import atomic

    # Blender's writers may end without an error; the disk then has no room left.
    monkeypatch.setattr(atomic, "bytes", _no_room, raising=False)
    with pytest.raises(StepFailed, match=r"^sheet\.\w+ could not be written \(No space left on device\): .*\.$"):
        WRITERS[name](out / name, sheet_object)
    assert sorted(path.name for path in out.iterdir()) == ["cameras", "page.jpg"]


def _no_room(_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_blender_without_usd_says_so(case, out, tmp_path, empty_scene, monkeypatch):
    import bpy
    from origami.origami_addon.export import models

    monkeypatch.setattr(
        models, "dir", lambda module: [name for name in dir(module) if "usd" not in name], raising=False
    )
    assert "usd_export" in dir(bpy.ops.wm)
    done, report = finished(case, tmp_path), Report({})
    write_outputs(chosen(["usd", "fold"]), out, done, report, SILENT)
    assert [path.name for path in out.iterdir()] == ["crease_pattern.fold"]
    assert report.warnings == ["This Blender was built without USD and cannot write sheet.usdz: use sheet.glb instead."]
    with pytest.raises(StepFailed, match="without USD"):
        write_outputs(chosen(["usd"]), out, done, report, SILENT)
