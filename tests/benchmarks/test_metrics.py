"""The benchmark's own metrics measure known warps correctly and agree with a scorer beside the data."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import sheets
from scipy.spatial.transform import Rotation

cv2 = pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks import metrics, truth  # noqa: E402
from origami.benchmarks.scorer import CannotScore, Scorer, own_scorer, scorer_in  # noqa: E402

WIDTH, HEIGHT = 700, 1000
PRINTED_ROWS = (65, 935)


@pytest.fixture(scope="module")
def original() -> np.ndarray:
    """A page of different words."""
    random = np.random.default_rng(0)
    page = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    letters = np.array(list("abcdefghijklmnopqrstuvwxyzABCDEFGHKLMNPRSTUVWXYZ0123456789&%?"))
    for line in range(17):
        text = "".join(random.choice(letters, 18))
        place = (int(random.integers(30, 60)), 90 + 52 * line)
        cv2.putText(page, text, place, cv2.FONT_HERSHEY_TRIPLEX, float(random.uniform(1.1, 1.3)), (20, 20, 20), 2)
    return page


def bend(page: np.ndarray, amplitude: float) -> np.ndarray:
    """The page with its columns as sine waves of that amplitude in pixels."""
    y, x = np.mgrid[0 : page.shape[0], 0 : page.shape[1]].astype(np.float32)
    waves = amplitude * np.sin(y / HEIGHT * 16).astype(np.float32)
    return cv2.remap(page, x + waves, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def left_by_an_affine(amplitude: float) -> float:
    """Mean displacement of `bend` on print after the best affine."""
    y = np.arange(*PRINTED_ROWS) / HEIGHT
    wave = amplitude * np.sin(16 * y)
    design = np.stack([y, np.ones_like(y)], -1)
    return float(np.abs(wave - design @ np.linalg.lstsq(design, wave, rcond=None)[0]).mean())


@pytest.fixture(scope="module")
def bent_scores(original: np.ndarray) -> dict[float, dict]:
    return {amplitude: metrics.score_page(original, bend(original, amplitude)) for amplitude in (0.0, 4.0)}


@pytest.mark.parametrize("amplitude", [0.0, 4.0])
def test_known_waves_are_measured(bent_scores, amplitude):
    score = bent_scores[amplitude]
    expected = left_by_an_affine(amplitude)
    assert score["dense"]["mean"] == pytest.approx(expected, abs=0.2)
    assert score["sift"]["mean"] == pytest.approx(expected, abs=0.2)
    assert sum(score["dense"]["bins"]) == pytest.approx(1, abs=0.02)
    assert score["coverage"] == pytest.approx(1, abs=0.02)
    assert score["G"] == pytest.approx(1, abs=0.005)


def test_aspect_and_turn_are_measured(original):
    wider = np.ascontiguousarray(np.rot90(cv2.resize(original, (WIDTH * 103 // 100, HEIGHT)), -1))
    score = metrics.score_page(original, wider)
    assert score["aspect_percent"] == pytest.approx(3, abs=0.1)
    assert score["G"] == pytest.approx(1.03, abs=0.002)
    assert abs(score["turned_degrees"]) == pytest.approx(90, abs=0.1)
    # SIFT's positions are a quarter of a pixel off, towards another side of the print in a turned page.
    assert score["dense"]["mean"] < 0.6
    assert score["similarity"]["mean"] > 2


def test_a_mirrored_page_is_refused(original):
    with pytest.raises(metrics.NoMatch):
        metrics.score_page(original, np.ascontiguousarray(original[:, ::-1]))


def test_a_blank_page_is_refused(original):
    with pytest.raises(metrics.NoMatch, match="50 features"):
        metrics.score_page(original, np.full_like(original, 255))


@pytest.fixture(scope="module")
def shared_scorer(root: Path) -> Scorer:
    folder = root.parent / "shared" / "tools" / "score"
    if not (folder / "score_real.py").is_file():
        pytest.skip("the shared scorer is not beside this checkout")
    return scorer_in(folder)


def test_agrees_with_the_shared_scorer_on_pages(original, bent_scores, shared_scorer):
    theirs = shared_scorer.page(original, bend(original, 4.0))
    ours = bent_scores[4.0]
    assert ours["G"] == pytest.approx(theirs["G"], abs=1e-4)
    for figure in ("sift", "similarity", "dense"):
        for statistic in ("mean", "median", "p95"):
            assert ours[figure][statistic] == pytest.approx(theirs[figure][statistic], abs=0.01)
    np.testing.assert_allclose(ours["dense"]["bins"], theirs["dense"]["bins"], atol=0.002)


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    """A folded letter in the format of the rendered sets: 210 x 300 mm, four cameras."""
    folder = tmp_path_factory.mktemp("scene")
    flat = np.stack(np.meshgrid(np.linspace(0, sheets.WIDTH, 141), np.linspace(0, sheets.HEIGHT, 201)), -1)
    positions = sheets.two_folds().in_space(flat) * [300, -300, -300]
    np.savez(folder / "gt_mesh.npz", xyz=positions, uv=flat * 300)
    photos = [
        {"file": f"photos/{i}.jpg", "R": np.eye(3).tolist(), "t_mm": centre}
        for i, centre in enumerate([[0, 0, -600], [200, 0, -650], [-150, 100, -600], [0, -200, -620]])
    ]
    (folder / "scene.json").write_text(json.dumps({"page_mm": [210.0, 300.0], "photos": photos}))
    return folder


def recovered(scene: Path, noise: float) -> tuple[np.ndarray, np.ndarray, list[str], np.ndarray]:
    """The scene's sheet as found in another frame, ``noise`` mm off, its page 1 % too wide."""
    random = np.random.default_rng(0)
    exact = truth.Truth(scene)
    vertices = exact.positions[::4, ::4].reshape(-1, 3)
    vertices = vertices + noise * random.standard_normal(vertices.shape)
    uv = exact.flat[::4, ::4].reshape(-1, 2) * [1.01, 1]
    uv = uv + noise * random.standard_normal(uv.shape)
    turn = Rotation.from_euler("xyz", [20, 40, 60], degrees=True).as_matrix()
    centres = np.stack(list(exact.centres.values()))
    return 0.01 * vertices @ turn.T + 3, 0.5 * uv, list(exact.centres), 0.01 * centres @ turn.T + 3


def test_exact_sheet_in_another_frame_has_no_error(scene):
    score = truth.score_sheet(scene, *recovered(scene, 0.0))
    assert score["surface_rms"] < 1e-9
    assert score["affine_mean"] < 1e-9
    assert score["aspect_percent"] == pytest.approx(1)
    assert score["outside"] == 0
    assert score["coverage"] == pytest.approx(1, abs=0.01)
    # Half a per cent too wide at the sides, half a per cent too low at top and bottom, after the best similarity.
    assert 0.1 < score["flat_mean"] < 0.3


def test_noise_on_a_sheet_is_measured(scene):
    score = truth.score_sheet(scene, *recovered(scene, 0.3))
    assert score["surface_rms"] == pytest.approx(0.1, rel=0.15)  # 0.3 of 300 mm
    assert score["affine_mean"] > 0.1


def test_agrees_with_the_shared_scorer_on_sheets(scene, shared_scorer):
    sheet = recovered(scene, 0.3)
    ours, theirs = own_scorer().sheet(scene, *sheet), shared_scorer.sheet(scene, *sheet)
    for figure in ("surface_rms", "surface_median", "surface_p95", "flat_mean", "flat_median", "flat_p95"):
        assert ours[figure] == pytest.approx(theirs[figure], rel=0.02)


def test_a_sheet_without_known_cameras_is_refused(scene):
    vertices, uv, _, centres = recovered(scene, 0.0)
    with pytest.raises(CannotScore, match="cameras"):
        own_scorer().sheet(scene, vertices, uv, ["a", "b", "c", "d"], centres)
