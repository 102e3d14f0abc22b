"""The page in colour, in grey, and black and white: the same page, whose photos are blended once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from folded import folded_sheet
from origami.core.watch import SILENT
from origami.origami_addon import steps
from origami.origami_addon.export.outputs import PAGE_FILES, chosen, write_outputs
from origami.origami_addon.files.icc import luminance_shares
from origami.origami_addon.files.photos import gather
from origami.origami_addon.report import Report
from origami.origami_addon.settings import ImageSettings, RunSettings
from origami.origami_addon.state import Paged, extended
from PIL import Image


@pytest.fixture(scope="module")
def case():
    return folded_sheet()


@pytest.fixture(scope="module")
def photos(case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("photos") / "Brief ü"
    folder.mkdir()
    for number, pixels in enumerate([*case.photos, case.photos[0][:, ::-1]]):
        Image.fromarray(pixels).save(folder / f"Foto ü {number}.jpg", quality=95)
    return gather(folder)[0]


@pytest.fixture(scope="module")
def kept(tmp_path_factory) -> Path:
    """The work folder of all runs here."""
    return tmp_path_factory.mktemp("work")


@pytest.fixture
def paged(case, photos, kept):
    """Makes the page with a setting."""

    def make(colour: str) -> Paged:
        settings = RunSettings(image=ImageSettings(source="reference", light="as-photographed", colour=colour))
        page = steps.make_page(case.state, steps.Work(photos, kept, settings, Report({})))
        return extended(case.state, Paged, page=page)

    return make


def written(paged: Paged, photos, out: Path) -> dict[str, Image.Image]:
    """The page's files."""
    outputs = [*PAGE_FILES, *chosen(["png"])]
    write_outputs(outputs, out, steps.finished(photos, paged, out), Report({}), SILENT)
    return {path.name: Image.open(path) for path in out.iterdir() if path.suffix != ".pdf"}


def test_another_colour_blends_nothing_again(paged, kept, monkeypatch):
    color = paged("colour").page.image
    before = {path: path.stat().st_mtime_ns for path in kept.iterdir()}
    monkeypatch.setattr(steps.page, "page_of_photo", None)
    grey, white = (paged(colour).page for colour in ("grey", "black-and-white"))
    assert {path: path.stat().st_mtime_ns for path in kept.iterdir()} == before
    assert (color.ndim, grey.image.shape, white.image.dtype) == (3, color.shape[:2], bool)
    np.testing.assert_array_equal(grey.texture.image, color)
    shares = np.array(luminance_shares(None))
    linear = np.where(color <= 10, color / 255 / 12.92, ((color / 255 + 0.055) / 1.055) ** 2.4) @ shares
    found = np.where(grey.image <= 10, grey.image / 255 / 12.92, ((grey.image / 255 + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(found, linear, atol=0.006)
    assert grey.image[white.image].mean() > grey.image[~white.image].mean() + 30


@pytest.mark.parametrize(
    ("colour", "modes"),
    [("colour", ("RGB", "RGB", "RGB")), ("grey", ("L", "L", "L")), ("black-and-white", ("1", "1", "L"))],
)
def test_the_files_have_the_colour(paged, photos, tmp_path, colour, modes):
    page = paged(colour)
    files = written(page, photos, tmp_path)
    assert tuple(files[name].mode for name in ("page.tif", "page.png", "page.jpg")) == modes
    for name in ("page.tif", "page.png"):
        np.testing.assert_array_equal(np.asarray(files[name]), page.page.image)
    pdf = (tmp_path / "page.pdf").read_bytes()
    assert (b"/CCITTFaxDecode" in pdf) == (colour == "black-and-white")
    assert "Brief ü".encode("utf-16-be").hex().upper().encode() in pdf
