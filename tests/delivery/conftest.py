"""A finished run of a small folded sheet, without the time that a run takes."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from folded import Folded, folded_sheet
from origami.core.camera import Camera
from origami.core.page.raster import page_lookup
from origami.core.page.texture import PageTexture
from origami.core.page.warp import photo_positions
from origami.origami_addon.export.models import write_map, write_sheet
from origami.origami_addon.files.image_files import write_tiff
from origami.origami_addon.files.pdf import write_pdf
from PIL import Image, ImageDraw, ImageFont

SIZE = (640, 800)  # pixels of the page
DPI = 102
# Lines of print, each with the place of its upper left corner on the page.
PRINT = ((60, 60, "Origami folds paper"), (60, 180, "Kestrel and Hawthorne"), (60, 640, "Harbour Road Falmouth"))
FONT_SIZE = 44
NUMBER = "0123456789abcdef0123456789abcdef"


def steep(case: Folded, tilt: float) -> Camera:
    """The first camera after it has gone around the sheet's middle, so that it sees the back of one half."""
    first = case.model.cameras[0]
    cosine, sine = np.cos(tilt), np.sin(tilt)
    rotation = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]]) @ first.rotation
    middle = case.sheet.vertices.mean(axis=0)
    return replace(
        first, name="steep.jpg", rotation=rotation, translation=first.to_camera_frame(middle) - rotation @ middle
    )


@pytest.fixture(scope="session")
def case() -> Folded:
    """The sheet, with a mountain fold in the middle of its height, and three cameras; the last sees one half only."""
    found = folded_sheet(-0.5)
    model = replace(found.model, cameras=(*found.model.cameras, steep(found, -1.3)))
    return replace(found, model=model)


@pytest.fixture(scope="session")
def printed() -> np.ndarray:
    """The page, (H, W, 3) uint8."""
    page = Image.new("RGB", SIZE, "white")
    draw = ImageDraw.Draw(page)
    for x, y, text in PRINT:
        draw.text((x, y), text, "black", ImageFont.load_default(FONT_SIZE))
    return np.asarray(page)


@pytest.fixture(scope="session")
def finished(case: Folded, printed: np.ndarray, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run; the page's left half is from the first photo, the right one from the second."""
    folder = tmp_path_factory.mktemp("finished")
    cameras = case.model.cameras
    lookup = page_lookup(case.sheet, case.flat, SIZE)
    left, right = (photo_positions(case.sheet, lookup, camera) for camera in cameras[:2])
    photo = np.zeros(SIZE[::-1], np.int16)
    photo[:, SIZE[0] // 2 :] = 1
    texture = PageTexture(printed, photo, np.where((photo == 0)[..., None], left, right), 0.0)
    write_sheet(folder / "sheet.npz", case.sheet, case.flat, cameras)
    write_map(folder / "map.npz", texture, case.sheet, case.flat, cameras)
    write_tiff(folder / "page.tif", printed, DPI)
    write_pdf(folder / "page.pdf", printed, DPI, (case.flat.width, case.flat.height), "Brief")
    return folder


@pytest.fixture
def make_run(case: Folded, finished: Path, tmp_path: Path) -> Callable[[str], Path]:
    """Makes a folder of that run by its name, and its photos."""

    def make(name: str) -> Path:
        folder = tmp_path / "out" / name
        shutil.copytree(finished, folder)
        inputs = []
        for camera in case.model.cameras:
            path = tmp_path / "photos" / camera.name
            path.parent.mkdir(exist_ok=True)
            Image.new("RGB", (camera.width, camera.height), "grey").save(path)
            size = {"width": camera.width, "height": camera.height}
            inputs.append({"name": camera.name, "path": str(path), "sha256": _hash(path)} | size)
        report = {
            "number": NUMBER,
            "inputs": inputs,
            "stages": [{"name": "find sheet", "figures": {"reference": inputs[0]["name"]}}],
            "outputs": {each: {"sha256": _hash(folder / each)} for each in ("page.tif", "page.pdf")},
        }
        (folder / "report.json").write_text(json.dumps(report), encoding="utf-8")
        return folder

    return make


@pytest.fixture
def run_folder(make_run: Callable[[str], Path]) -> Path:
    """One of these folders."""
    return make_run("Brief ü 1")


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture(scope="session")
def workflow_python(root: Path) -> str:
    """A Python with the packages that `.ci/requirements-text.txt` names, which Blender's Python does not have."""
    candidates = [os.environ.get("ORIGAMI_WORKFLOW_PYTHON", ""), sys.executable, str(root / ".venv-batch/bin/python")]
    for python in filter(None, candidates):
        try:
            done = subprocess.run([python, "-c", "import ocrmypdf, pyvips"], capture_output=True, check=False)
        except OSError:
            continue
        if done.returncode == 0:
            return python
    pytest.skip("no Python has what .ci/requirements-text.txt names; `make batch` makes one")
