"""Which rows the benchmark's tables have: the baselines stand beside the default in each."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks import lights, methods, photo_sets, report, scorer
from origami.benchmarks.photo_set import PhotoSet
from origami.core.errors import StepFailed
from origami.core.page.texture import PageTexture
from origami.origami_addon.state import Page


@pytest.fixture
def rendered_set(tmp_path, monkeypatch) -> PhotoSet:
    """A set whose methods are off by 0.1 % each."""
    (tmp_path / "a set").mkdir()
    (tmp_path / "a set" / "gt_mesh.npz").touch()

    def run_set(photo_set, work, out, compared, *_, others):
        names = [*(method.name for method in compared), *(["page-dewarp"] if others else [])]
        return [{"set": photo_set.name, "method": name, "page_mean": 0.1} for name in names], {}

    monkeypatch.setattr(photo_sets, "run_set", run_set)
    return PhotoSet(tmp_path / "a set")


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("parts", [("cells",), ("ablation",), ("cells", "ablation")])
def test_baselines_stand_in_every_table(rendered_set, tmp_path, parts, quick):
    tables = report._cells([rendered_set], tmp_path, scorer.own_scorer(), parts, quick, print)
    names = {"cells": "rendered", "ablation": "ablation"}
    assert [table.name for table in tables] == [names[part] for part in parts]
    for table in tables:
        shown = [row["method"] for row in table.rows]
        assert len(set(shown)) == len(shown)
        assert {methods.DEFAULT.name, *(baseline.name for baseline in methods.BASELINES)} <= set(shown)
        without = {method.name for method in methods.ABLATION}
        assert without <= set(shown) if table.name == "ablation" else not without & set(shown)
        assert (tmp_path / f"{table.name}.md").is_file()
        # The exact error of the page comes first.
        assert list(table.columns)[:4] == ["set", "method", "page_mean", "page_p95"]


def test_a_set_that_fails_stands_in_the_ablation(rendered_set, tmp_path, monkeypatch):
    failed = {"set": "a set", "method": photo_sets.WHOLE_SET, "failure": "no photo could be placed"}
    monkeypatch.setattr(photo_sets, "run_set", lambda *_, **__: ([failed], {}))
    (table,) = report._cells([rendered_set], tmp_path, scorer.own_scorer(), ("ablation",), False, print)
    assert table.rows == [failed]


def test_each_light_stands_beside_the_reference_photo(rendered_set, tmp_path, monkeypatch):
    """A page that cannot be scored keeps its row, with the reason."""
    figures = {
        "unevenness_L": 1.5,
        "delta_e": {"mean": 0.5, "p95": 1.0},
        "paper_L": [95.0, 99.0],
        "chroma_paper": [0.8, 0.0],
        "mtf": {"1/8": 1.0, "1/4": None},
        "noise_L": 0.2,
        "psnr": 25.0,
        "ssim": 0.95,
    }
    texture = PageTexture(np.zeros((4, 3, 3), np.uint8), np.zeros((4, 3)), np.zeros((4, 3, 2)), 0.0)
    page = Page(texture, 100.0, texture.image)
    monkeypatch.setattr(PhotoSet, "original", np.zeros((4, 3, 3), np.uint8))
    monkeypatch.setattr(photo_sets.Placed, "of", lambda *_: photo_sets.Placed([], None, None))
    monkeypatch.setattr(lights, "own_unevenness", lambda _: 1.2)
    monkeypatch.setattr(lights, "_laid_out", lambda *_: None)

    def make_page(_, work):
        if work.settings.image.light == "white":
            raise StepFailed("no page")
        return page

    monkeypatch.setattr(lights.steps, "make_page", make_page)
    own = scorer.Scorer("a test", lambda *_: {}, lambda *_: figures)
    table = report._lights([rendered_set], tmp_path, own, print)
    assert [row["page"] for row in table.rows] == [*lights.PAGES]
    assert [row.get("failure") for row in table.rows] == [None, "StepFailed: no page", None, None]
    assert "| a set | paper | 1.50 | 1.20 | 0.50 | 1.00 | 95.0 | 0.8 | 0.0 | 1.00 |  | 0.20 |" in table.markdown()
    assert (tmp_path / "light.csv").is_file()
    assert len([*(tmp_path / "light" / "a set").iterdir()]) == 3
