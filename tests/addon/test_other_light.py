"""Other photos of the same sheet: placed on its page in any light, from any camera; others are refused, and why."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import other_light_scene as scene
import pytest
from origami.core.errors import UnusablePhotos, UsageError
from origami.core.page.raster import interpolate, page_lookup
from origami.core.placing.result import SfmSettings
from origami.origami_addon import other_light
from origami.origami_addon.other_light import OtherPage, gather_others, lay_other_photos
from origami.origami_addon.report import Report
from origami.origami_addon.settings import ImageSettings, RunSettings
from origami.origami_addon.state import Paged
from origami.origami_addon.steps import Work
from photo_scene import poses, save
from PIL import Image

SETTINGS = RunSettings(sfm=SfmSettings(threads=1, max_features=1500), image=ImageSettings(source="reference"))
OTHER_SIZE, OTHER_ZOOM = (700, 560), 1.5


@dataclass(frozen=True)
class Laid:
    """A page with a page of other photos, its report, the true cameras of these, and what is needed to lay more."""

    state: Paged
    work: Work
    folder: Path
    page: OtherPage
    cameras: dict


@pytest.fixture(scope="module")
def laid(tmp_path_factory: pytest.TempPathFactory) -> Laid:
    """One folder with all kinds of photos, laid at once."""
    folder = tmp_path_factory.mktemp("other light")
    state, photos = scene.known_page(folder / "photos")
    plain, zoomed, bent = poses(3, spread=20, seed=5)
    ultraviolet = folder / "ultraviolet"
    save(scene.other_photo(plain), ultraviolet / "plain.png")
    exif = Image.Exif()
    exif[0x0112] = 6  # held upright: to be turned by 90 degrees
    save(scene.other_photo(zoomed, size=OTHER_SIZE, zoom=OTHER_ZOOM), ultraviolet / "zoomed.jpg", exif=exif)
    save(scene.other_photo(bent, angle=0.1), ultraviolet / "bent.png")
    work = Work(photos, folder / "work", SETTINGS, Report({}))
    page = lay_other_photos(state, gather_others([ultraviolet])[0], work)
    cameras = {
        "plain.png": scene.camera("plain.png", plain),
        "zoomed.jpg": scene.camera("zoomed.jpg", zoomed, OTHER_SIZE, OTHER_ZOOM),
    }
    return Laid(state, work, folder, page, cameras)


def test_pages_lie_on_each_other_pixel_by_pixel(laid: Laid) -> None:
    page, other = laid.state.page, laid.page.state.page
    assert other.texture.image.shape == page.texture.image.shape
    assert other.dpi == page.dpi
    sheet = laid.state.sheet
    lookup = page_lookup(sheet, laid.state.flat, scene.PAGE_PX)
    points = interpolate(lookup, sheet.triangles, sheet.vertices)
    compared = 0
    for index, camera in enumerate(laid.page.state.cameras):
        mine = other.texture.photo == index
        if camera.name in laid.cameras and mine.any():
            compared += mine.sum()
            true = laid.cameras[camera.name]
            off = np.linalg.norm(other.texture.position[mine] - true.project(points[mine]), axis=1)
            per_pixel = np.median(np.linalg.norm(np.diff(true.project(points), axis=1), axis=2))
            assert np.median(off) < 0.1 * per_pixel
            assert np.percentile(off, 95) < 0.3 * per_pixel
    assert compared > 0.9 * other.texture.photo.size


def test_the_light_stays_as_photographed(laid: Laid) -> None:
    image = laid.page.state.page.texture.image.astype(float)
    printed = laid.state.page.texture.image.astype(float)
    assert np.corrcoef(image.mean(axis=2).ravel(), printed.mean(axis=2).ravel())[0, 1] < -0.9  # inverted
    assert (image[..., 2] > 1.5 * image[..., 0]).mean() > 0.9  # and blue


def test_the_report_says_what_was_placed_and_what_was_not(laid: Laid) -> None:
    (stage,) = (each for each in laid.work.report.stages if each["name"] == other_light.OTHER_PHOTOS)
    figures = stage["figures"]["photos"]
    assert {camera.name for camera in laid.page.state.cameras} == {"plain.png", "zoomed.jpg"}
    for name in ("plain.png", "zoomed.jpg"):
        assert figures[name]["agreeing"] > 300
        assert figures[name]["reprojection_error_px"] < 0.7
        assert figures[name]["aligned_share"] > 0.95
    assert figures["zoomed.jpg"]["focal_length_over_long_side"] == pytest.approx(1.5 * 0.85, rel=0.03)
    sentences = " ".join(laid.work.report.warnings)
    name = laid.page.photos.name
    assert (
        f"{name}: bent.png is left out: it shows the sheet in another shape than the photos of the page do."
        in sentences
    )


def test_a_second_run_keeps_the_page(laid: Laid, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(other_light, "place_on_page")
    work = replace(laid.work, report=Report({}))
    again = lay_other_photos(laid.state, laid.page.photos, work)
    np.testing.assert_array_equal(again.state.page.texture.image, laid.page.state.page.texture.image)
    assert work.report.stages[-1]["figures"] == laid.work.report.stages[-1]["figures"]
    assert work.report.warnings == laid.work.report.warnings


OTHERS = {
    "bent": ({"angle": 0.1}, "The sheet was bent or unfolded between the page's photos and those in bent"),
    "other print": ({"seed": 9}, "None of the photos in other print could be placed on the page"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_nothing_to_lay(laid: Laid, name: str) -> None:
    changed, sentence = OTHERS[name]
    (pose,) = poses(1)
    save(scene.other_photo(pose, **changed), laid.folder / name / "0.png")
    with pytest.raises(UnusablePhotos, match=sentence):
        lay_other_photos(laid.state, gather_others([laid.folder / name])[0], laid.work)


def test_name_of_the_folder_however_it_is_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "uv"
    (folder / "deep").mkdir(parents=True)
    Image.new("RGB", (300, 200)).save(folder / "only.png")
    monkeypatch.chdir(folder)
    for path in (folder, Path(), folder / "deep" / "..", Path("../uv")):
        assert [each.name for each in gather_others([path])] == ["uv"]


def test_folders_of_one_name_and_without_photos(tmp_path: Path) -> None:
    for folder in (tmp_path / "a" / "uv", tmp_path / "b" / "UV"):
        folder.mkdir(parents=True)
    with pytest.raises(UsageError, match="Two folders of other photos are called uv"):
        gather_others([tmp_path / "a" / "uv", tmp_path / "b" / "UV"])
    with pytest.raises(UnusablePhotos, match="There are no photos in"):
        gather_others([tmp_path / "a" / "uv"])
    (tmp_path / "a" / "uv" / "broken.png").write_bytes(b"no picture")
    with pytest.raises(UnusablePhotos, match="None of the 1 files can be used as a photo"):
        gather_others([tmp_path / "a" / "uv"])
