"""What must run, given what is known, without a scene and without a process."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from folded import folded_sheet, white_page
from origami.core.errors import UsageError
from origami.origami_addon.jobs.requests import (
    AnyRequest,
    CompareMethods,
    RunStages,
    UnwrapMesh,
    WriteFiles,
    request_from_text,
    request_text,
    stages_request,
)
from origami.origami_addon.plan import Known, NothingToDo, first_stale, plan, plan_all, plan_stage
from origami.origami_addon.settings import ImageSettings, PageSettings, RunSettings
from origami.origami_addon.stages import EFFECT, STAGES, Part, Stage
from origami.origami_addon.state import AFTER, Found, LaidOut, Placed, State, reached, state_arrays, state_from_arrays

CASE = folded_sheet()
STATE = CASE.state
PHOTOS = ("/photos/1.jpg", "/photos/2.jpg")
SETTINGS = RunSettings(page=PageSettings(paper_size_mm=(160.0, 200.0)))
TEXTS = {stage: f"settings of {stage}" for stage in STAGES}
CREASE = (30.0, 350.0, 570.0, 350.0)
REFERENCE = CASE.model.cameras[0].name


def finished(*edited: Part, **changed: object) -> Known:
    """A document with every stage done, and given edits and changes since."""
    known = Known(PHOTOS, SETTINGS, TEXTS, TEXTS, PHOTOS, STATE, STATE, frozenset(edited))
    return replace(known, **changed)


def after(stage: Stage) -> State:
    """What is known after a stage."""
    nouns = [field.name for field in fields(AFTER[stage])]
    return AFTER[stage](*(getattr(STATE, noun) for noun in nouns))


def test_a_run_that_knows_nothing_does_all() -> None:
    planned = plan_all(Known(PHOTOS, SETTINGS))
    assert (planned.stages, planned.photos, planned.settings) == (STAGES, PHOTOS, SETTINGS)
    assert planned.start == State()


def test_nothing_is_done_twice() -> None:
    assert first_stale(finished()) is None
    with pytest.raises(NothingToDo):
        plan_all(finished())


@pytest.mark.parametrize("stage", STAGES)
def test_another_setting_begins_with_the_stage_that_depends_on_it(stage: Stage) -> None:
    known = finished(wanted=TEXTS | {stage: "other settings"})
    assert plan_all(known).stages == STAGES[STAGES.index(stage) :]


def test_other_photos_start_again_with_those() -> None:
    planned = plan_all(finished(photos=PHOTOS[:1]))
    assert (planned.stages, planned.photos) == (STAGES, PHOTOS[:1])


@pytest.mark.parametrize("part", sorted(EFFECT.keys() - {"frame", "outline"}))
def test_an_edit_begins_where_it_counts(part: Part) -> None:
    expected = STAGES[STAGES.index(EFFECT[part]) :]
    assert plan_all(finished(part)).stages == expected
    # The last stage on its own also uses the edits.
    assert plan_stage(finished(part), "page").stages == expected


def test_an_edited_outline_cuts_the_sheet_again() -> None:
    for planned in (plan_all(finished("outline")), plan_stage(finished("outline"), "unwrap")):
        assert planned.stages[:2] == ("find", "surface")
        assert planned.settings.reference == REFERENCE
        np.testing.assert_array_equal(planned.settings.outline, STATE.region.outline.polygon)


def test_an_edited_outline_is_dropped_where_the_sheet_is_found_again() -> None:
    assert plan_stage(finished("outline"), "find").settings == SETTINGS
    other = finished("outline", wanted=TEXTS | {"find": "another reference"})
    assert plan_all(other).settings == SETTINGS


def test_deleted_points_wait_for_the_surface() -> None:
    fewer = replace(STATE, model=CASE.model.select(np.arange(len(CASE.model.points)) > 0))
    known = finished("points", state=fewer)
    assert plan_stage(known, "find").start is known.computed
    assert plan_stage(known, "surface").start is fewer
    assert plan_stage(known, "page").start is fewer


def test_creases_by_hand_stay_in_their_photo() -> None:
    known = finished(creases=(CREASE,))
    coarser = replace(known, wanted=TEXTS | {"surface": "coarser"})
    assert plan_all(coarser).settings == replace(SETTINGS, reference=REFERENCE, creases=(CREASE,))
    assert plan_all(replace(known, wanted=TEXTS | {"find": "another reference"})).settings == SETTINGS
    assert plan_stage(known, "surface").settings == SETTINGS  # finds them again
    assert plan(known, ("surface",), creases=()).settings.creases == ()


def test_unwrapping_and_the_page_include_laying_out() -> None:
    assert plan_stage(finished(), "unwrap").stages == ("unwrap", "lay_out")
    assert plan_stage(finished(), "page").stages == ("page",)
    assert plan_stage(finished(wanted=TEXTS | {"lay_out": "turned"}), "page").stages == ("lay_out", "page")


def test_pins_hold_where_the_sheet_is_unwrapped_alone() -> None:
    pins = np.array([3, 7])
    known = finished(pinned=pins)
    assert plan_stage(known, "unwrap").pinned is pins
    for stage in ("surface", "page"):
        assert len(plan_stage(known, stage).pinned) == 0
    assert len(plan_all(finished("points", pinned=pins)).pinned) == 0
    assert len(plan_stage(finished(pinned=pins[:1]), "unwrap").pinned) == 0


def test_a_request_carries_out_a_plan(tmp_path: Path) -> None:
    pins = np.array([3, 7])
    planned = plan_stage(finished(pinned=pins), "unwrap")
    request, given = stages_request(planned, tmp_path)
    assert request == RunStages(planned.photos, planned.settings, str(tmp_path), planned.stages)
    assert given.pop("pinned") is pins
    assert given.keys() == state_arrays(planned.start).keys()
    corners = np.array([[0, 0], [9, 0], [9, 9.5], [0, 9]])
    request, given = stages_request(plan_stage(finished(), "lay_out"), tmp_path, corners)
    assert request.corners == ((0, 0), (9, 0), (9, 9.5), (0, 9))
    assert request_from_text(request_text(request)) == request
    assert "pinned" not in given


@pytest.mark.parametrize(
    "known_after, stage, missing",
    [("place", "unwrap", "Find Sheet"), ("find", "page", "Build Surface"), ("unwrap", "page", "Lay Out Page")],
)
def test_a_stage_needs_those_before_it(known_after: Stage, stage: Stage, missing: str) -> None:
    done = {each: TEXTS[each] for each in STAGES[: STAGES.index(known_after) + 1]}
    known = finished(done=done, state=after(known_after))
    with pytest.raises(UsageError, match=f"{missing} is not done yet: run it first"):
        plan(known, (stage,))


def test_a_state_is_all_that_comes_before_it() -> None:
    assert reached(STATE, Placed) is reached(STATE, LaidOut) is STATE
    assert reached(after("find"), Found).reference is CASE.model.cameras[0]
    with pytest.raises(UsageError, match="Place Photos is not done yet"):
        reached(State(), Found)


@pytest.mark.parametrize("stage", STAGES[:-1])
def test_a_state_comes_back_from_its_arrays(stage: Stage) -> None:
    kept = state_arrays(after(stage))
    back = state_from_arrays(kept)
    assert type(back) is AFTER[stage]
    assert state_arrays(back).keys() == kept.keys()


def test_the_page_is_not_among_the_arrays() -> None:
    paged = AFTER["page"](*vars(STATE).values(), white_page())
    assert type(state_from_arrays(state_arrays(paged))) is LaidOut


@pytest.mark.parametrize(
    "request_of_job",
    [
        RunStages(PHOTOS, SETTINGS, "/work", ("lay_out", "page"), ((0.1, 0.2), (3.0, 0.5), (3.0, 4.0), (0.0, 4.0))),
        RunStages(PHOTOS, replace(SETTINGS, reference=REFERENCE, creases=(CREASE,)), "/work", STAGES),
        CompareMethods(PHOTOS, SETTINGS, "/work", ("arap", "lscm")),
        WriteFiles(PHOTOS, RunSettings(image=ImageSettings(bake=True)), "/work", ("jpeg", "tiff"), "/out", 16),
        UnwrapMesh(),
    ],
)
def test_a_request_comes_back_from_its_text(request_of_job: AnyRequest) -> None:
    assert request_from_text(request_text(request_of_job)) == request_of_job


def test_a_state_from_before_cameras_were_adjusted_has_those_placed() -> None:
    arrays = {name: array for name, array in state_arrays(STATE).items() if not name.startswith("cameras.")}
    state = state_from_arrays(arrays)
    assert isinstance(state, LaidOut)
    for camera, placed in zip(state.cameras, STATE.model.cameras, strict=True):
        np.testing.assert_array_equal(camera.center, placed.center)
