"""The benchmark's own metrics measure known warps correctly and agree with scorers beside the data."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import sheets
from scipy.spatial.transform import Rotation

cv2 = pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks import metrics, scorer, truth, waves  # noqa: E402

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


def left_of_the_waves(amplitude: float, rows: tuple[int, int]) -> np.ndarray:
    """Displacement of `bend` in these rows after the best straight line, which is all that an affine can do there."""
    y = np.arange(*rows) / HEIGHT
    wave = amplitude * np.sin(16 * y)
    return wave - np.polyval(np.polyfit(y, wave, 1), y)


@pytest.fixture(scope="module")
def bent_scores(original: np.ndarray) -> dict[float, dict]:
    return {amplitude: metrics.score_page(original, bend(original, amplitude)) for amplitude in (0.0, 4.0)}


@pytest.mark.parametrize("amplitude", [0.0, 4.0])
def test_known_waves_are_measured(bent_scores, amplitude):
    score = bent_scores[amplitude]
    expected = np.abs(left_of_the_waves(amplitude, PRINTED_ROWS)).mean()
    assert score["dense"]["mean"] == pytest.approx(expected, abs=0.2)
    assert score["sift"]["mean"] == pytest.approx(expected, abs=0.2)
    assert sum(score["dense"]["bins"]) == pytest.approx(1, abs=0.02)
    assert score["coverage"] == pytest.approx(1, abs=0.02)
    assert score["G"] == pytest.approx(1, abs=0.005)


def test_waves_of_rules_are_measured(original):
    """A frame on a page whose columns are sine waves: its sides wave, its top and foot stay straight."""
    page = original.copy()
    cv2.rectangle(page, (20, 40), (680, 960), (20, 20, 20), 3)
    rules = metrics.find_rules(page)
    across, down = np.abs(rules[:, 1] - rules[:, 0]).T
    upright = down > across
    assert 4 <= upright.sum() < len(rules)
    registered = metrics.register(page, bend(page, 3.0), np.eye(3)[:2])
    waving = metrics.waves_of_rules(registered, rules[upright])
    assert waving.lines == upright.sum()
    expected = left_of_the_waves(3.0, (40, 960))
    assert waving.rms == pytest.approx(expected.std(), rel=0.1)
    assert waving.worst == pytest.approx(np.abs(expected).max(), rel=0.1)
    level = metrics.waves_of_rules(registered, rules[~upright])
    assert level.lines == (~upright).sum()
    assert level.rms < 0.1
    assert level.worst < 0.5


def test_a_page_without_rules_has_no_waves():
    none = waves.waves([])
    assert none.lines == 0
    assert np.isnan(none.rms)


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
def shared_scorers(root: Path) -> Path:
    folder = root.parent / "shared" / "tools" / "score"
    if not (folder / "score_real.py").is_file():
        pytest.skip("the shared scorers are not beside this checkout")
    return folder


def test_agrees_with_the_shared_scorer_on_pages(original, bent_scores, shared_scorers):
    theirs = scorer.scorer_of(shared_scorers / "score_real.py").page(original, bend(original, 4.0))
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
    lens = {"width": 400, "height": 300, "fx": 300.0, "fy": 300.0, "cx": 200.0, "cy": 150.0, "k1": 0.0, "k2": 0.0}
    photos = [
        lens | {"file": f"photos/{i}.jpg", "R": np.eye(3).tolist(), "t_mm": centre}
        for i, centre in enumerate([[0, 0, -600], [200, 0, -650], [-150, 100, -600], [0, -200, -620]])
    ]
    (folder / "scene.json").write_text(json.dumps({"page_mm": [210.0, 300.0], "photos": photos}))
    return folder


@pytest.fixture(scope="module")
def exact(scene: Path) -> truth.Truth:
    return truth.Truth(scene)


def recovered(exact: truth.Truth, noise: float) -> tuple[np.ndarray, list[str], np.ndarray]:
    """The scene's surface as found in another frame, ``noise`` mm off."""
    random = np.random.default_rng(0)
    vertices = exact.positions[::4, ::4].reshape(-1, 3)
    vertices = vertices + noise * random.standard_normal(vertices.shape)
    turn = Rotation.from_euler("xyz", [20, 40, 60], degrees=True).as_matrix()
    centres = np.stack([camera.center for camera in exact.cameras.values()])
    return 0.01 * vertices @ turn.T + 3, list(exact.cameras), 0.01 * centres @ turn.T + 3


def test_exact_surface_in_another_frame_has_no_error(exact):
    score = truth.score_surface(exact, *recovered(exact, 0.0))
    assert score["surface_rms"] < 1e-9
    assert score["outside"] == 0
    assert score["coverage"] == pytest.approx(1, abs=0.01)


def test_noise_on_a_surface_is_measured(exact):
    score = truth.score_surface(exact, *recovered(exact, 0.3))
    assert score["surface_rms"] == pytest.approx(0.1, rel=0.15)  # 0.3 of 300 mm


def test_agrees_with_the_shared_scorer_on_surfaces(scene, exact, shared_scorers):
    vertices, names, centres = recovered(exact, 0.3)
    ours = truth.score_surface(exact, vertices, names, centres)
    flat = exact.flat[::4, ::4].reshape(-1, 2)
    theirs = scorer.load(shared_scorers / "evaluate.py").eval_mesh(str(scene), vertices, flat, (names, centres))
    for figure in ("rms", "median", "p95"):
        assert ours[f"surface_{figure}"] == pytest.approx(theirs[f"recon_{figure}_pct"], rel=0.02)


def test_a_surface_without_known_cameras_is_refused(exact):
    vertices, _, centres = recovered(exact, 0.0)
    with pytest.raises(ValueError, match="cameras"):
        truth.score_surface(exact, vertices, ["a", "b", "c", "d"], centres)
