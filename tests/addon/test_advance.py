"""If a step's result is absurd, another way is tried, and the report says which. The steps are stand-ins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from folded import STEPS, Folded, folded_sheet
from origami.core.errors import StepFailed
from origami.core.sheet import FlatMap
from origami.core.watch import SILENT
from origami.origami_addon import steps
from origami.origami_addon.advance import Done, advance_through
from origami.origami_addon.report import Report
from origami.origami_addon.settings import RunSettings
from origami.origami_addon.stages import STAGES, Stage
from origami.origami_addon.state import Placed, State, Surfaced
from origami.origami_addon.steps.work import FIRST as FIRST_WAY
from origami.origami_addon.steps.work import Work

ALL: tuple[Stage, ...] = STAGES[1:-1]  # the first has run, and the last needs photos
# A way as the stand-ins see it: the region, the photos that must not be the reference, and the requested creases.
Seen = tuple[int, tuple[str, ...], Any]
FIRST, SMOOTH = (0, (), None), (0, (), ())


@dataclass
class Stand:
    """Stand-ins for the steps; ``white`` is the white share of the page and ``failing`` the failure in each way."""

    case: Folded
    white: dict[Seen, float] = field(default_factory=dict)
    failing: dict[Seen, str] = field(default_factory=dict)
    called: list[str] = field(default_factory=list)

    def find_sheet(self, *args: Any, other: int, without: Sequence[str], **_: Any) -> Any:
        self.called.append("find")
        self.chosen = other, tuple(without)
        args[1].report.warn(f"edge of {self.chosen}")
        return replace(self.case.state.region, reference=len(without))

    def build_surface(self, state: object, work: Work, *_: object) -> Any:
        self.called.append("surface")
        settings = work.settings
        self.way = (*self.chosen, settings.creases)
        if self.way in self.failing:
            raise StepFailed(self.failing[self.way])
        sheet = self.case.sheet if settings.creases is None else replace(self.case.sheet, ridges=())
        return self.case.model.cameras, sheet

    def unwrap_sheet(self, *_: object) -> Any:
        self.called.append("unwrap")
        return self.case.flat.uv

    def lay_out_page(self, *_: object) -> FlatMap:
        self.called.append("lay out")
        flat = self.case.flat
        return replace(flat, height=flat.height / (1 - self.white.get(self.way, 0.0)))

    def run(self, settings: RunSettings | None = None, stages: Sequence[Stage] = ALL, state: State | None = None):
        report = Report({})
        work = Work([], Path(), settings or RunSettings(), report)
        done: list[Done] = []
        start = Placed(self.case.model) if state is None else state
        for each in advance_through(stages, start, work, lambda stage: SILENT):
            done.append(each)
        return report, done


@pytest.fixture
def stand(monkeypatch: pytest.MonkeyPatch) -> Stand:
    stand = Stand(folded_sheet())
    for stage in ALL:
        monkeypatch.setattr(steps, STEPS[stage], getattr(stand, STEPS[stage]))
    return stand


@pytest.fixture
def barred(stand: Stand) -> Seen:
    """The way without the photo that is the reference at first."""
    return 0, (stand.case.model.cameras[0].name,), None


def test_nothing_else_is_done_where_the_first_way_passes(stand: Stand) -> None:
    report, done = stand.run()
    assert stand.called == ["find", "surface", "unwrap", "lay out"]
    assert [each.stage for each in done] == list(ALL)
    assert report.tried == []
    assert report.warnings == ["edge of (0, ())"]
    assert done[0].report.warnings == report.warnings
    assert done[1].report.warnings == []


def test_a_white_page_is_first_made_without_creases(stand: Stand) -> None:
    stand.white = {FIRST: 0.2}
    report, done = stand.run()
    assert stand.called == ["find", "surface", "unwrap", "lay out", "surface", "unwrap", "lay out"]
    assert isinstance(done[-1].state, Surfaced) and done[-1].state.sheet.ridges == ()
    refused, taken = report.tried
    assert refused["stage"] == "lay_out"
    assert "outside the sheet" in refused["gate"]
    assert refused["figure"] == pytest.approx(0.2, abs=0.01)
    assert refused["figure"] > refused["limit"] > 0
    assert refused["taken"] is False
    assert taken == {"way": "the surface without creases", "taken": True}
    (_, warning) = report.warnings
    assert warning.startswith(
        "The outline that was found leaves 20 % of the page white, as no sheet's does; the surface"
    )
    assert "--outline" in warning


def test_then_from_another_reference_photo(stand: Stand, barred: Seen) -> None:
    stand.white = {FIRST: 0.2, SMOOTH: 0.2}
    report, done = stand.run()
    assert [each.stage for each in done] == ["find", "surface", "unwrap", "surface", "unwrap", *ALL]
    last = done[-1].state
    assert last.region is not None and last.region.reference == 1
    assert [each["way"] for each in report.tried if each["taken"]] == ["another reference photo"]
    assert len(report.tried) == 3
    # The warnings of a rejected way are dropped.
    assert not any("edge of (0, ())" in warning for warning in report.warnings)
    assert any(f"edge of (0, {barred[1]}" in warning for warning in report.warnings)
    again = done[-4]
    assert again.stage == "find"
    assert any("another reference photo was taken instead" in warning for warning in again.report.warnings)


def test_then_from_other_parts_of_the_scene(stand: Stand, barred: Seen) -> None:
    stand.white = dict.fromkeys((FIRST, SMOOTH, barred, (1, (), None)), 0.5)
    report, _ = stand.run()
    assert stand.way == (2, (), None)
    assert [each["taken"] for each in report.tried] == [False] * 4 + [True]


@pytest.mark.parametrize("probability, way", [(0.9, FIRST), (0.4, (1, (), None))])
def test_a_torn_sheet_is_not_left_for_a_rectangle_unless_it_was_doubtful(
    stand: Stand, barred: Seen, probability: float, way: Seen, monkeypatch: pytest.MonkeyPatch
) -> None:
    def find_sheet(*args: Any, **how: Any) -> Any:
        with args[1].report.stage("find sheet") as figures:
            figures["sheet_probability"] = probability
        return stand.find_sheet(*args, **how)

    monkeypatch.setattr(steps, "find_sheet", find_sheet)
    stand.white = dict.fromkeys((FIRST, SMOOTH, barred), 0.2)
    stand.run()
    assert stand.way == way


def test_a_step_that_fails_is_tried_otherwise_too(stand: Stand, barred: Seen) -> None:
    stand.failing = {FIRST: "Only 3 points were found."}
    report, _ = stand.run()
    assert stand.way == barred
    assert report.tried[0]["stage"] == "surface"
    assert report.tried[0]["cause"] == "Only 3 points were found."
    assert any(warning.startswith("Only 3 points were found; another reference") for warning in report.warnings)


def test_where_nothing_is_better_the_first_way_is_kept_and_reported(stand: Stand) -> None:
    stand.white = dict.fromkeys(_every_way(stand), 0.2)
    report, done = stand.run()
    assert stand.way == FIRST
    assert done[-1].stage == "lay_out"
    assert report.tried[-1] == {"way": FIRST_WAY.name, "taken": True}
    (warning,) = (text for text in report.warnings if "white" in text)
    assert "nothing better was found: the page is likely wrong" in warning


def test_what_is_hopeless_is_given_up_in_a_sentence(stand: Stand) -> None:
    stand.white = dict.fromkeys(_every_way(stand), 0.6)
    with pytest.raises(StepFailed, match=r"leaves 60 % of the page white.*\(the surface without creases, .*--outline"):
        stand.run()


def test_a_failure_says_what_the_first_way_failed_with(stand: Stand) -> None:
    stand.failing = {way: f"It failed on {number}." for number, way in enumerate(_every_way(stand))}
    with pytest.raises(StepFailed, match=r"^It failed on 0\.$"):
        stand.run()


def test_what_a_person_gave_is_warned_of_and_kept(stand: Stand) -> None:
    stand.white = dict.fromkeys(_every_way(stand), 0.6)
    given = replace(
        RunSettings(), reference="a", outline=((0.0, 0.0), (9.0, 0.0), (9.0, 9.0)), creases=((0.0, 0.0, 5.0, 5.0),)
    )
    stand.white[0, (), given.creases] = 0.6
    report, done = stand.run(given)
    assert [each.stage for each in done] == list(ALL)
    assert stand.called.count("find") == 1
    assert any("60 % of the page white" in warning for warning in report.warnings)


def test_what_an_earlier_run_found_is_kept(stand: Stand) -> None:
    """In the window only the page is laid out again: the sheet, which may be edited, stays."""
    stand.way = FIRST
    stand.white = {FIRST: 0.6}
    _, done = stand.run(stages=("unwrap", "lay_out"), state=stand.case.state)
    assert [each.stage for each in done] == ["unwrap", "lay_out"]
    assert any("60 % of the page white" in warning for warning in done[-1].report.warnings)


def test_what_is_not_finite_is_never_kept(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(steps, "unwrap_sheet", lambda *_: stand.case.flat.uv * np.nan)
    with pytest.raises(StepFailed, match="The flat map that was found has no place in space"):
        stand.run(stages=("unwrap", "lay_out"), state=stand.case.state)


def _every_way(stand: Stand) -> list[Seen]:
    names = [camera.name for camera in stand.case.model.cameras]
    return [FIRST, SMOOTH, (0, (names[0],), None), (0, (names[1],), None), (1, (), None), (2, (), None)]
