"""The METS workspace: complete, valid, and of this page."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from origami.core.errors import UsageError
from origami.workflow.delivery import dewarping, handover, mets, page_xml
from origami.workflow.delivery.finished_run import finished_run
from PIL import Image

METS, XLINK = f"{{{mets.METS}}}", f"{{{mets.XLINK}}}"
HOCR = """<html xmlns="http://www.w3.org/1999/xhtml"><body><div class='ocr_page' title='bbox 0 0 640 800'>
<div class='ocr_carea' id='block_1_1' title="bbox 10 20 100 60"><span class='ocr_line' id='line_1_1'
title="bbox 10 20 100 40"><span class='ocrx_word' id='word_1_1' title='bbox 10 20 40 40; x_wconf 91'>Tom</span></span>
</div></div></body></html>"""


def add_text(folder: Path, of_page: str) -> None:
    text = folder / "text"
    text.mkdir()
    (text / "page.hocr").write_text(HOCR, encoding="utf-8")
    (text / "page.pdf").write_bytes(b"%PDF")
    (text / "figures.json").write_text(json.dumps({"of_page": of_page}))


def files_of(workspace: Path) -> dict[str, Path]:
    """The file of each group; all that METS says of it is checked."""
    root = ElementTree.parse(workspace / "mets.xml").getroot()
    found = {}
    for group in root.iter(f"{METS}fileGrp"):
        (file,) = group
        path = workspace / file.find(f"{METS}FLocat").attrib[f"{XLINK}href"]
        assert hashlib.sha256(path.read_bytes()).hexdigest() == file.attrib["CHECKSUM"]
        assert int(file.attrib["SIZE"]) == path.stat().st_size
        found[group.attrib["USE"]] = path
    named = {each.attrib["FILEID"] for each in root.iter(f"{METS}fptr")}
    assert named == {each.attrib["ID"] for each in root.iter(f"{METS}file")}
    return found


def test_a_page_without_text(run_folder, capsys):
    assert handover.main([str(run_folder)]) == 0, capsys.readouterr().err
    workspace = run_folder / "handover"
    files = files_of(workspace)
    assert set(files) == {"OCR-D-IMG", "OCR-D-SEG-PAGE", "PHOTO", "DEWARPING"}
    assert files["OCR-D-IMG"].read_bytes() == (run_folder / "page.tif").read_bytes()
    page = ElementTree.parse(files["OCR-D-SEG-PAGE"]).getroot().find(f"{{{page_xml.NAMESPACE}}}Page")
    assert workspace / page.attrib["imageFilename"] == files["OCR-D-IMG"]
    grid = ElementTree.parse(files["DEWARPING"]).getroot()
    assert workspace / grid.find(f"{{{dewarping.NAMESPACE}}}DocumentImage").attrib["filename"] == files["PHOTO"]
    text = (workspace / "mets.xml").read_text(encoding="utf-8")
    assert "urn:uuid:01234567-89ab-cdef-0123-456789abcdef" in text
    assert "<mods:title>Brief ü 1</mods:title>" in text


def test_text_is_taken_along_and_the_empty_page_goes(run_folder):
    run = finished_run(run_folder)
    handover.write_handover(run)
    add_text(run_folder, run.hash_of("page.pdf"))
    handover.write_handover(run)
    files = files_of(run_folder / "handover")
    assert set(files) == {"OCR-D-IMG", "OCR-D-OCR-TESS", "PHOTO", "DEWARPING"}
    assert "Tom" in files["OCR-D-OCR-TESS"].read_text(encoding="utf-8")
    assert not (run_folder / "handover" / "OCR-D-SEG-PAGE").exists()


def test_the_text_of_an_earlier_page_is_refused(run_folder):
    add_text(run_folder, "another hash")
    with pytest.raises(UsageError, match=r"is that of an earlier page; run text\.py"):
        handover.write_handover(finished_run(run_folder))
    assert not (run_folder / "handover").exists()


def test_a_photo_that_has_gone_or_changed_is_named(run_folder):
    run = finished_run(run_folder)
    path = run.photos["Foto ü 0.jpg"].path
    path.write_bytes(b"another")
    with pytest.raises(UsageError, match="is no longer the one that the run read"):
        handover.write_handover(run)
    path.unlink()
    with pytest.raises(UsageError, match="is no longer the one that the run read"):
        handover.write_handover(run)


def test_a_photo_that_lies_on_its_side_is_written_upright(workflow_python, run_folder, root):
    """The same photo, stored after a quarter turn clockwise."""
    report = json.loads((run_folder / "report.json").read_text(encoding="utf-8"))
    with np.load(run_folder / "sheet.npz") as stored:
        sheet = dict(stored)
    with np.load(run_folder / "map.npz") as stored:
        arrays = dict(stored)
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # x to the right becomes y down
    sheet["cam_rotations"][0] = quarter @ sheet["cam_rotations"][0]
    sheet["cam_translations"][0] = quarter @ sheet["cam_translations"][0]
    width, height = (int(length) for length in sheet["cam_sizes"][0])
    x, y = sheet["cam_principal_points"][0]
    sheet["cam_sizes"][0], sheet["cam_principal_points"][0] = (height, width), (height - y, x)
    arrays["photo"] = np.where(arrays["photo"] == 0, -1, arrays["photo"])
    rows, columns = arrays["to_page"].shape[1:3]
    entries = np.full((3, rows, rows, 2), np.nan, np.float32)
    entries[:, :, :columns] = arrays["to_page"]
    entries[0] = np.nan
    entries[0, :columns, :rows] = np.rot90(arrays["to_page"][0], -1)
    np.savez(run_folder / "sheet.npz", **sheet)
    np.savez(run_folder / "map.npz", **arrays | {"to_page": entries})
    upright = np.random.default_rng(1).integers(0, 255, (height, width, 3), np.uint8)
    photo = Path(report["inputs"][0]["path"]).with_name("lying.png")
    Image.fromarray(np.rot90(upright, -1)).save(photo)
    digest = hashlib.sha256(photo.read_bytes()).hexdigest()
    report["inputs"][0] |= {"path": str(photo), "sha256": digest, "width": height, "height": width}
    (run_folder / "report.json").write_text(json.dumps(report), encoding="utf-8")

    script = root / "workflow" / "scripts" / "handover.py"
    done = subprocess.run([workflow_python, str(script), str(run_folder)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    files = files_of(run_folder / "handover")
    np.testing.assert_array_equal(np.asarray(Image.open(files["PHOTO"])), upright)
    assert "which is turned by 270 degrees clockwise" in files["DEWARPING"].read_text(encoding="utf-8")


SCHEMAS = {"OCR-D-OCR-TESS": "page.xsd", "OCR-D-SEG-PAGE": "page.xsd", "mets": "mets.xsd"}


def test_files_are_valid_by_their_schemas(workflow_python, make_run):
    """The schema of the dewarping grid is in no package; `test_dewarping` has its rules."""
    if shutil.which("xmllint") is None:
        pytest.skip("xmllint is not installed")
    where = "import importlib.util as u; print(*u.find_spec('ocrd_validators').submodule_search_locations)"
    found = subprocess.run([workflow_python, "-c", where], capture_output=True, text=True, check=False)
    if found.returncode != 0:
        pytest.skip("the schemas of PAGE and METS are missing; .ci/requirements-schemas.txt names their package")
    schemas = Path(found.stdout.strip())
    with_text, without = make_run("with"), make_run("without")
    add_text(with_text, finished_run(with_text).hash_of("page.pdf"))
    for folder in (with_text, without):
        handover.write_handover(finished_run(folder))
        files = files_of(folder / "handover") | {"mets": folder / "handover" / "mets.xml"}
        for group, schema in SCHEMAS.items():
            if group in files:
                done = subprocess.run(
                    ["xmllint", "--nonet", "--noout", "--schema", str(schemas / schema), str(files[group])],
                    capture_output=True,
                    text=True,
                    check=False,
                )
                assert done.returncode == 0, done.stderr
