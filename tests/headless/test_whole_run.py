"""A whole run of the example through Blender as a module: every file is there, and the page is the letter."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from numpy.typing import NDArray
from origami.core.numeric.polygon import signed_area
from origami.headless.options import build_parser, settings_from
from PIL import Image
from run_once import FinishedRun
from scipy import ndimage

MILLIMETRES = (215.9, 279.4)
LONG_SIDE = 2000  # pixels of a photo as shipped


def slow_as_shipped(test: Callable) -> Callable:
    """Mark a test that makes the page again: other tests cover its parts quickly."""
    return pytest.mark.slow(pytest.mark.parametrize("finished_run", ["as shipped"], indirect=True)(test))


@pytest.fixture(scope="module")
def report(finished_run: FinishedRun) -> dict:
    return json.loads((finished_run.out / "report.json").read_text(encoding="utf-8"))


def test_exit_code_and_files(finished_run: FinishedRun, report: dict) -> None:
    assert finished_run.exit_code == 0
    expected = {
        *("page.tif", "page.jpg", "document.blend", "sheet.glb", "sheet.obj", "sheet.npz", "uv_layout.svg", "map.npz"),
        *("sheet.usdz", "crease_pattern.svg", "crease_pattern.fold", "log.txt", "report.json"),
        *("outline.json", "creases.json", "outline.jpg", "normal_map.png", "displacement_map.exr"),
    }
    assert expected <= {path.name for path in finished_run.out.iterdir()}
    for name, listed in report["outputs"].items():
        content = (finished_run.out / name).read_bytes()
        assert hashlib.sha256(content).hexdigest() == listed["sha256"]
    assert not list(finished_run.out.glob(".writing-*"))


def test_report(finished_run: FinishedRun, report: dict) -> None:
    hashes = {photo["name"]: photo["sha256"] for photo in report["inputs"]}
    assert hashes == {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in finished_run.photos.iterdir()}
    assert report["versions"].keys() >= {"origami", "blender", "python", "numpy", "scipy", "pycolmap"}
    assert report["settings"]["page"]["paper_size_mm"] == list(MILLIMETRES)
    stages = {stage["name"]: stage for stage in report["stages"]}
    assert stages["place photos"]["seconds"] > 0
    assert stages["place photos"]["figures"]["photos_placed"] == len(hashes)
    assert stages["unwrap"]["figures"]["flipped_triangles"] == 0
    page = stages["make page"]["figures"]
    assert page["paper_lab"] == pytest.approx([95, 0, 0], abs=3)  # 88 % of the full light, and white paper
    assert 0 < page["paper_unevenness_lightness"] < 4
    assert 0 < page["paper_noise_lightness"] < 2
    assert 0 <= page["healed_share"] < 0.1
    sampled = page["photo_pixels_per_page_pixel"]
    assert 0 < sampled["lowest"] < sampled["median"] < 2
    assert sampled["lowest"] < sampled["at_creases"] < 2
    assert stages["write relief"]["figures"]["lowest_page_heights"] < -0.01
    assert (finished_run.out / "report.json").stat().st_mtime_ns == max(
        (finished_run.out / name).stat().st_mtime_ns for name in ("report.json", *report["outputs"])
    )


def test_page_is_the_letter(finished_run: FinishedRun, root: Path) -> None:
    check_page_is_the_letter(finished_run.out, root)


def check_page_is_the_letter(out: Path, root: Path) -> None:
    with Image.open(out / "page.tif") as page:
        assert page.info["icc_profile"]
        dpi = page.info["dpi"][0]
        assert np.array(page.size) / dpi * 25.4 == pytest.approx(MILLIMETRES, rel=0.02)
        grey = np.asarray(page.convert("L"), float)
    with Image.open(root / "examples" / "flat_original" / "trifold_letter.png") as flat:
        original = np.asarray(flat.convert("L").resize(grey.shape[::-1]), float)
    assert worst_shift(print_of(grey), print_of(original)) < 0.006 * len(grey)


def print_of(grey: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ink without the light: how much darker a place is than its surroundings."""
    return np.clip(ndimage.gaussian_filter(grey, 20) - ndimage.gaussian_filter(grey, 1.5), 0, None)


def worst_shift(page: NDArray[np.float64], original: NDArray[np.float64], blocks: int = 6) -> float:
    """Largest distance in pixels by which a block of the page that has print is off its place."""
    shifts = []
    rows, columns = page.shape[0] // blocks, page.shape[1] // blocks
    for row, column in np.ndindex(blocks, blocks):
        here = np.s_[row * rows : (row + 1) * rows, column * columns : (column + 1) * columns]
        one, other = page[here], original[here]
        if other.std() < 0.5 * original.std():
            continue
        spectrum = np.fft.fft2(one - one.mean()) * np.conj(np.fft.fft2(other - other.mean()))
        peak = np.unravel_index(np.argmax(np.fft.ifft2(spectrum).real), one.shape)
        shifts.append(np.hypot(*((p + n // 2) % n - n // 2 for p, n in zip(peak, one.shape))))
    assert len(shifts) > blocks
    return max(shifts)


def test_sheet_is_flat_in_its_own_lengths(finished_run: FinishedRun) -> None:
    with np.load(finished_run.out / "sheet.npz") as sheet:
        xyz, uv, triangles = sheet["xyz"], sheet["uv"], sheet["triangles"]
        scale = float(sheet["mm_per_world_unit"])
        assert str(sheet["unit"]) == "mm"
        assert sheet["cam_centers"].shape == (len(sheet["cam_names"]), 3)
    # the page ends at straight lines through its sides; the paper's own edge is some tenths of a millimetre beside them
    assert uv.min() == pytest.approx(0, abs=0.5)
    in_space = np.linalg.norm(xyz[triangles[:, 0]] - xyz[triangles[:, 1]], axis=1) * scale
    on_page = np.linalg.norm(uv[triangles[:, 0]] - uv[triangles[:, 1]], axis=1)
    assert np.median(np.abs(on_page / in_space - 1)) < 0.005


def test_crease_pattern_is_that_of_the_letter(finished_run: FinishedRun) -> None:
    fold = json.loads((finished_run.out / "crease_pattern.fold").read_text(encoding="utf-8"))
    letters = np.array(fold["edges_assignment"])
    assert sorted(letters) == sorted("BBBBBBBBMV")
    assert len(fold["faces_vertices"]) == 3
    vertices, edges = np.array(fold["vertices_coords"]), np.array(fold["edges_vertices"])
    assert vertices.max(axis=0) == pytest.approx(MILLIMETRES, abs=1e-3)
    # as it was made: folded by 48 degrees at 93 mm from the top, and by 55 the other way at 186 mm
    for letter, angle, from_top in (("V", 48, 93), ("M", -55, 186)):
        (edge,) = np.flatnonzero(letters == letter)
        assert fold["edges_foldAngle"][edge] == pytest.approx(angle, abs=4)
        assert MILLIMETRES[1] - vertices[edges[edge], 1] == pytest.approx(from_top, abs=4)


def test_settings_of_the_report_can_be_used_again(finished_run: FinishedRun) -> None:
    arguments = build_parser().parse_args(["--settings", str(finished_run.out / "report.json")])
    assert settings_from(arguments).page.paper_size_mm == MILLIMETRES


@pytest.fixture
def copy(finished_run: FinishedRun, tmp_path: Path) -> Path:
    """The folder of the finished run, in which a test may run again."""
    return shutil.copytree(finished_run.out, tmp_path / "out")


def test_a_second_run_takes_what_is_there(command: ModuleType, finished_run: FinishedRun, copy: Path) -> None:
    again = [str(finished_run.photos), "-o", str(copy), "--paper", "Letter", "-q"]
    before = (copy / "report.json").read_bytes()
    assert command.main(again) == 2
    assert command.main([*again, "--resume"]) == 0
    assert (copy / "report.json").read_bytes() == before

    (copy / "page.jpg").unlink()
    kept = what_is_kept(copy, "**/result.json", "*.npz")
    assert command.main([*again, "--resume", "--dpi", "50"]) == 0
    now = what_is_kept(copy, "**/result.json", "*.npz")
    gone, made = kept.keys() - now.keys(), now.keys() - kept.keys()
    assert all(path.name.startswith("page-") for path in gone | made)  # the one at 50 dpi replaces the other
    assert all(now[path] == kept[path] for path in kept.keys() & now.keys())
    assert (copy / "page.jpg").exists()
    with Image.open(copy / "page.tif") as page:
        assert page.info["dpi"][0] == pytest.approx(50, abs=0.1)


def again(command: ModuleType, out: Path, photos: Path, *options: str) -> dict:
    """The report of another run over the same structure from motion."""
    placed = what_is_kept(out, "**/result.json")
    # finding which way up the text is takes seconds, and other tests cover it
    assert command.main([str(photos), "-o", str(out), "-q", "--resume", "--turn", "0", *options]) == 0
    assert what_is_kept(out, "**/result.json") == placed
    return json.loads((out / "report.json").read_text(encoding="utf-8"))


def what_is_kept(out: Path, *patterns: str) -> dict[Path, int]:
    """Files in the work folder and when they were written."""
    work = out / "work"
    kept = {path: path.stat().st_mtime_ns for pattern in patterns for path in work.glob(pattern)}
    assert kept
    return kept


def stages_of(report: dict) -> dict[str, dict]:
    return {stage["name"]: stage for stage in report["stages"]}


@slow_as_shipped
def test_outline_and_creases_given_back_make_the_same_page(
    command: ModuleType, copy: Path, example_photos: Path
) -> None:
    found = [json.loads((copy / name).read_text()) for name in ("outline.json", "creases.json")]
    assert found[0]["reference"] == found[1]["reference"]
    assert len(found[1]["creases"]) == 2
    before = flat_places(copy)
    given = ["--outline", str(copy / "outline.json"), "--creases", str(copy / "creases.json")]
    again(command, copy, example_photos, "--paper", "Letter", *given)
    outline = json.loads((copy / "outline.json").read_text())["outline"]
    areas = [abs(signed_area(np.array(corners))) for corners in (outline, found[0]["outline"])]
    assert areas[0] == pytest.approx(areas[1], rel=1e-4)
    # those given are moved to where the points have them, as far as a hand may have missed the place
    creases = json.loads((copy / "creases.json").read_text())["creases"]
    np.testing.assert_allclose(sorted(creases), sorted(found[1]["creases"]), atol=0.0075 * LONG_SIDE)
    apart = np.linalg.norm(flat_places(copy) - before, axis=-1) / MILLIMETRES[1]
    both = np.isfinite(apart)
    assert both.mean() > 0.99 * np.isfinite(before[..., 0]).mean()
    assert np.median(apart[both]) < 0.0003
    assert apart[both].max() < 0.003


def flat_places(out: Path) -> NDArray[np.float64]:
    """Where on the page each place of the photos lies, millimetres."""
    with np.load(out / "map.npz") as stored:
        return stored["to_page"].astype(float)


@slow_as_shipped
def test_white_page_and_bake_without_a_paper_size(
    command: ModuleType, copy: Path, example_photos: Path, root: Path
) -> None:
    later = again(command, copy, example_photos, "--bake", "--light", "white")
    assert {"page_baked.tif", "page.tif"} <= later["outputs"].keys()
    figures = stages_of(later)["make page"]["figures"]
    assert figures["dpi_source"] == "assumed"
    assert len(figures["photos_used"]) > 1
    with np.load(copy / "sheet.npz") as sheet:
        assert str(sheet["unit"]) == "page heights"
        assert sheet["uv"][:, 1].max() == pytest.approx(1, abs=0.02)
    with Image.open(copy / "page.tif") as page, Image.open(copy / "page_baked.tif") as baked:
        assert page.size == baked.size
        assert np.divide(*page.size) == pytest.approx(MILLIMETRES[0] / MILLIMETRES[1], rel=0.01)
        greys = [np.asarray(image.convert("L"), float) for image in (page, baked)]
    assert worst_shift(*map(print_of, greys)) < 0.003 * len(greys[0])


@slow_as_shipped
def test_the_papers_own_method(command: ModuleType, copy: Path, example_photos: Path, root: Path) -> None:
    later = again(
        *(command, copy, example_photos, "--paper", "Letter", "--surface", "ridge_aware"),
        *("--unwrap", "conformal_l1", "--ridge-rows", "--boundary-rows"),
    )
    figures = stages_of(later)
    assert figures["build surface"]["figures"]["creases"] >= 2
    assert figures["unwrap"]["figures"]["flipped_triangles"] == 0
    check_page_is_the_letter(copy, root)
