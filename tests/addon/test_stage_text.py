"""What the panel says about a stage."""

from __future__ import annotations

import pytest


@pytest.fixture
def document(add_on):
    """A document all of whose stages are done with its current settings."""
    import bpy
    from origami.origami_addon.scene.document import new_document
    from origami.origami_addon.scene.known import settings_of
    from origami.origami_addon.scene.settings_group import settings_to_json
    from origami.origami_addon.stages import STAGES

    made = new_document("sheet", bpy.context.scene)
    group = made.collection.origami
    for stage in STAGES:
        record = getattr(group, stage)
        record.done, record.seconds = True, 1.25
        record.settings = settings_of(stage, settings_to_json(group.settings))
    return made


def texts(document) -> dict[str, str]:
    from origami.origami_addon.stages import STAGES
    from origami.origami_addon.window.stage_text import state_of

    return {stage: state_of(document, stage).text for stage in STAGES}


def test_done(document):
    assert set(texts(document).values()) == {"Done in 1.2 s"}


def test_done_at_once_says_no_time(document):
    document.collection.origami.surface.seconds = 0.01
    assert texts(document)["surface"] == "Done"


def test_not_done(document):
    from origami.origami_addon.window.stage_text import state_of

    document.collection.origami.surface.done = False
    assert state_of(document, "surface").text == "Not done yet"
    assert state_of(document, "surface").icon != state_of(document, "find").icon


def test_another_setting_makes_its_own_stage_stale(document):
    document.collection.origami.settings.surface.grid_rows += 1
    shown = texts(document)
    assert shown.pop("surface") == "Settings changed since: re-run from here"
    assert set(shown.values()) == {"Done in 1.2 s"}


@pytest.mark.parametrize("part", ["outline", "vertices", "page"])
def test_an_edit_affects_its_stage_and_all_later_ones(document, monkeypatch, part):
    from origami.origami_addon.stages import EFFECT, STAGES
    from origami.origami_addon.window import stage_text

    monkeypatch.setattr(stage_text, "edits", lambda _: {part})
    first = STAGES.index(EFFECT[part])
    shown = list(texts(document).values())
    assert shown[:first] == ["Done in 1.2 s"] * first
    assert shown[first:] == ["Edited by hand: re-run from here"] * (len(STAGES) - first)


@pytest.mark.parametrize(("angle", "text"), [(48.4, "valley, 48°"), (-54.6, "mountain, 55°"), (None, "fold unknown")])
def test_creases(angle, text):
    from origami.origami_addon.window.stage_text import crease_text

    assert crease_text(angle) == text
