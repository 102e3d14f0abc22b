"""Files written from the window."""

from __future__ import annotations

import json

import pytest


def test_every_kind_of_file_is_written(document, tmp_path):
    import bpy
    from origami.origami_addon.export.outputs import KINDS, names_of

    assert bpy.ops.origami.export(directory=f"{tmp_path}/", kinds=set(KINDS), bits="16") == {"FINISHED"}
    written = {path.name: path.stat().st_size for path in tmp_path.iterdir()}
    assert written.pop(".origami") > 0
    assert written.keys() == set(names_of(KINDS.values()))
    assert min(written.values()) > 100
    assert written["page.tif"] == pytest.approx(document_pixels(document) * 6, rel=0.02)


def document_pixels(document) -> int:
    from origami.origami_addon.scene.sheet_materials import page_image

    width, height = page_image(document).size
    return width * height


def test_the_command_line_makes_the_same_page(document, finished, colmap_model, tmp_path, root):
    """From the exported settings and the same model, bit for bit."""
    import subprocess
    import sys

    import bpy

    assert bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"tiff"}) == {"FINISHED"}
    assert bpy.ops.origami.export_settings(filepath=str(tmp_path / "settings.json")) == {"FINISHED"}
    written = json.loads((tmp_path / "settings.json").read_text(encoding="utf-8"))
    assert len(written["outline"]) == 4
    command = [sys.executable, str(root / "headless" / "rectify.py"), str(finished.parent / "Brief ü")]
    options = ["-o", str(tmp_path / "out"), "--settings", str(tmp_path / "settings.json"), "-q"]
    done = subprocess.run([*command, *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "page.tif").read_bytes() == (tmp_path / "page.tif").read_bytes()


def test_a_page_that_is_not_up_to_date_is_not_exported(document, tmp_path):
    import bpy

    document.object("sheet").data.vertices[200].co.z += 0.01
    with pytest.raises(RuntimeError, match=r"\AError: The page is not up to date[^\n]*\n\Z"):
        bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"tiff"})
    assert not list(tmp_path.iterdir())


def test_an_export_replaces_its_own_files_alone(document, tmp_path):
    import bpy
    from origami.origami_addon.files.marker import claim

    (tmp_path / "page.jpg").write_text("mine")
    for kind in ("jpeg", "obj"):
        with pytest.raises(RuntimeError, match=r"page\.jpg, which Origami did not write"):
            bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={kind})
    assert [path.name for path in tmp_path.iterdir()] == ["page.jpg"]
    for _ in range(2):
        assert bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"uv_svg"}) == {"FINISHED"}
    claim(tmp_path, ["uv_layout.svg"], "another")
    with pytest.raises(RuntimeError, match=r"uv_layout\.svg of the document another"):
        bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"uv_svg"})
    (tmp_path / ".origami").write_text("cranes and frogs")
    with pytest.raises(RuntimeError, match=r"\.origami, which Origami did not write"):
        bpy.ops.origami.export(directory=f"{tmp_path}/", kinds={"uv_svg"})
    assert (tmp_path / ".origami").read_text() == "cranes and frogs"


def test_no_folder_to_export_to_is_reported(document, tmp_path):
    import bpy

    with pytest.raises(RuntimeError, match="There is no folder"):
        bpy.ops.origami.export(directory=str(tmp_path / "nowhere"), kinds={"tiff"})
