"""The benchmark measures light, colour, sharpness and noise that were put into a page, and agrees with others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from origami.core.numeric.cielab import cielab
from origami.core.numeric.image import encoded, linear_light

cv2 = pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks import light, scorer  # noqa: E402
from origami.benchmarks.metrics import NoMatch  # noqa: E402

WIDTH, HEIGHT = 400, 1000


@pytest.fixture(scope="module")
def original() -> np.ndarray:
    """Words on white paper, between blank margins, and a coloured box."""
    random = np.random.default_rng(0)
    page = np.full((HEIGHT, WIDTH, 3), 250, np.uint8)
    letters = np.array(list("abcdefghijklmnopqrstuvwxyzABCDEFGHKLMNPRSTUVWXYZ0123456789&%?"))
    for line in range(14):
        text = "".join(random.choice(letters, 10))
        cv2.putText(page, text, (60, 130 + 52 * line), cv2.FONT_HERSHEY_TRIPLEX, 1.1, (20, 20, 20), 2)
    page[860:930, 80:330] = (60, 120, 190)
    return page


def spoilt(original: np.ndarray) -> np.ndarray:
    """Lit less and less to the right, yellower, blurred and noisy."""
    lit = linear_light(original[..., ::-1]) * np.linspace(0.8, 0.65, WIDTH)[None, :, None] * [1.0, 0.97, 0.85]
    lit = cv2.GaussianBlur(lit, (0, 0), 0.7)
    lit *= 1 + 0.01 * np.random.default_rng(4).standard_normal((HEIGHT, WIDTH, 1))
    return np.ascontiguousarray(encoded(lit.astype(np.float32), np.dtype(np.uint8))[..., ::-1])


def in_place(original: np.ndarray, page: np.ndarray) -> light.Laid:
    """A page that lies on its original already."""
    same_size = cv2.resize(page, original.shape[1::-1], interpolation=cv2.INTER_CUBIC)
    return light.Laid(original, same_size, np.ones(original.shape[:2], bool))


@pytest.fixture(scope="module")
def scores(original) -> dict[str, dict]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(light, "lay_on", in_place)
        return {"same": light.score_light(original, original), "spoilt": light.score_light(original, spoilt(original))}


def test_a_page_like_its_original_has_no_faults(scores, original):
    score = scores["same"]
    assert score["unevenness_L"] < 2  # print beside blank paper
    assert light.own_unevenness(original) == pytest.approx(score["unevenness_L"], abs=0.1)
    assert score["delta_e"]["p95"] < 0.5
    assert score["noise_L"] < 0.1
    assert score["mtf"]["1/8"] == pytest.approx(1, abs=0.02)
    assert score["ssim"] > 0.99
    assert score["psnr"] > 35


def test_faults_are_measured(scores):
    score = scores["spoilt"]
    white = linear_light(np.full((1, 1, 3), 250, np.uint8))[0, 0].astype(float)
    # one gain brings the middle to white; half of what is brighter is cut off there
    darkest = cielab(white * 0.65 / 0.725 * np.ones(3))[0]
    assert score["unevenness_L"] == pytest.approx(100 - darkest, rel=0.3)
    assert score["chroma_paper"][0] == pytest.approx(np.hypot(*cielab(white * 0.725 * [1.0, 0.97, 0.85])[1:]), abs=0.7)
    assert score["mtf"]["1/8"] == pytest.approx(np.exp(-2 * (np.pi * 0.125 * 0.7 * 2) ** 2), abs=0.06)
    assert score["ssim"] < scores["same"]["ssim"] - 0.01
    assert score["noise_L"] > 0.15


def test_an_original_without_blank_paper_is_refused(monkeypatch):
    shade = np.linspace(0, 250, HEIGHT).astype(np.uint8)
    full = np.ascontiguousarray(np.broadcast_to(shade[:, None, None], (HEIGHT, WIDTH, 3)))
    full[::7] = 0
    monkeypatch.setattr(light, "lay_on", in_place)
    with pytest.raises(NoMatch, match="blank paper"):
        light.score_light(full, full)


@pytest.mark.slow
def test_a_bent_and_shifted_page_is_laid_onto_its_original(original):
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    bent = cv2.remap(original, x + 3 + 2 * np.sin(y / 90), 0.98 * y + 5, cv2.INTER_CUBIC, borderValue=(250, 250, 250))
    there = cv2.resize(original, (2 * WIDTH, 2 * HEIGHT), interpolation=cv2.INTER_CUBIC)
    laid = light.lay_on(there, bent)
    assert light.transfer(laid)["1/8"] > 0.9
    assert light.transfer(in_place(there, bent))["1/8"] < 0.5


@pytest.mark.slow
def test_agrees_with_the_scorer_beside_the_data(root: Path, original):
    file = root.parent / "shared" / "tools" / "score" / "score_light.py"
    if not file.is_file():
        pytest.skip("the shared scorers are not beside this checkout")
    ours = light.score_light(original, spoilt(original))
    theirs = scorer.load(file).score(original, spoilt(original))
    # OpenCV's CIELAB, which the other uses, is right to 0.2
    for figure in ("paper_L", "chroma_paper"):
        assert ours[figure] == pytest.approx(theirs[figure], abs=0.3)
    assert ours["unevenness_L"] == pytest.approx(theirs["unevenness_L"], abs=0.15)
    assert ours["noise_L"] == pytest.approx(theirs["noise_L"], abs=0.02)
    for statistic in ("mean", "p95"):
        assert ours["delta_e"][statistic] == pytest.approx(theirs["delta_e"][statistic], abs=0.25)
    for frequency in light.FREQUENCIES:
        assert ours["mtf"][frequency] == pytest.approx(theirs["mtf"][frequency], abs=0.03)
