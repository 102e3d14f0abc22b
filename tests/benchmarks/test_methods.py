"""The compared methods: what is left out is out while a method computes, and the time of what is shared is kept."""

from __future__ import annotations

import numpy as np
import pytest
import sheets

pytest.importorskip("cv2", reason="the benchmark's requirements are not installed")

from origami.benchmarks import cells, clock, methods, page_error, plots
from origami.core.surface import creased_surface
from origami.origami_addon import steps
from origami.origami_addon.report import Report
from origami.origami_addon.steps import surface
from origami.origami_addon.steps.work import Work

SWAPPING = [method for method in (methods.STIFFNESS_BY_RULE, *methods.ABLATION) if method.swaps]


@pytest.mark.parametrize("method", SWAPPING, ids=lambda method: method.name)
def test_swaps_are_in_force_for_their_method_alone(method):
    before = [getattr(swap.module, swap.name) for swap in method.swaps]
    with method.in_force():
        for swap in method.swaps:
            assert getattr(swap.module, swap.name) is swap.stand_in
    assert all(getattr(swap.module, swap.name) is value for swap, value in zip(method.swaps, before, strict=True))


def test_names_differ():
    names = [method.name for method in (*methods.ON_PHOTOS, *methods.ABLATION)]
    assert len(set(names)) == len(names)


def test_a_plain_sheet_is_stiffer_than_by_the_rule():
    sheet = sheets.plane()
    random = np.random.default_rng(3)
    flat = random.random((300, 2)) * [sheets.WIDTH, sheets.HEIGHT]
    points = sheet.in_space(flat) + 2e-3 * random.standard_normal((300, 3))
    view = sheets.camera()

    def stiffness(method: methods.Method) -> float:
        with method.in_force():
            outline = sheets.outline_pixels(sheet, view)
            return creased_surface.assess(points, view, outline, method.surface).stiffness

    assert stiffness(methods.STIFFNESS_BY_RULE) == 1
    assert stiffness(methods.DEFAULT) > 1


def test_what_is_shared_costs_what_it_cost(tmp_path, monkeypatch):
    now = iter([0.0, 5.0, 5.0, 5.5])
    monkeypatch.setattr(clock.time, "perf_counter", lambda: next(now))
    stopwatch = clock.Clock()
    result = {"points": np.arange(3.0)}, {"tracks": 3}

    def compute():
        return result

    stopwatch.kept(tmp_path, "tracks", "key", compute, pytest.fail)
    assert stopwatch.take() == {"tracks seconds": 5.0}
    (file,) = tmp_path.glob("tracks-*.npz")
    stopwatch.share(file, tmp_path / "other")
    stopwatch.kept(tmp_path / "other", "tracks", "key", compute, pytest.fail)
    assert stopwatch.take() == {"tracks seconds": 5.0}
    assert stopwatch.take() == {}


def test_what_the_steps_compute_is_timed(tmp_path, monkeypatch):
    of_a_set = cells.Cells(None, None, tmp_path, tmp_path / "pages", None)
    work = Work([], tmp_path, methods.DEFAULT.settings(), Report({}))
    with of_a_set._in_force(methods.DEFAULT):
        steps.unwrap_sheet(sheets.mesh(sheets.plane(), 0.1)[0], work)
        for name in methods.KEPT[:2]:
            surface.kept(tmp_path, name, "key", lambda: ({"points": np.zeros(1)}, {}), pytest.fail)
    assert set(of_a_set._clock.take()) == {f"{name} seconds" for name in methods.KEPT}


def test_maps_of_errors_are_drawn(tmp_path):
    vectors = np.zeros((40, 30, 2))
    vectors[:, :, 1] = 0.1 * np.sin(np.arange(30) / 3)
    vectors[:2] = np.nan
    error = page_error.PageError(vectors, 0.1)
    plots.page_errors({methods.DEFAULT.name: error, methods.PAPER.name: error}, "a set", tmp_path / "errors.png")
    assert (tmp_path / "errors.png").stat().st_size > 10_000
    plots.page_errors({"another method": error}, "a set", tmp_path / "none.png")
    assert not (tmp_path / "none.png").exists()
