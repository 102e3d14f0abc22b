"""A whole run whose first way gives an absurd page: it takes the next way, and report.json says so."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from folded import folded_sheet, stand_in_for_steps
from origami.core.errors import StepFailed
from origami.origami_addon import run
from origami.origami_addon.settings import RunSettings


@pytest.fixture
def stand(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A run with stand-ins for the expensive steps; the white share of its page depends on the reference photo."""
    out = tmp_path / "out"
    case = folded_sheet()
    smooth = replace(case.sheet, ridges=())
    now = SimpleNamespace(white={})

    def find_sheet(*_: Any, other: int, without: tuple[str, ...], **__: Any) -> Any:
        if other:
            raise StepFailed("Nothing else in the photos looks like a sheet.")
        return replace(case.state.region, reference=len(without))

    def lay_out_page(state: Any, *_: object) -> Any:
        white = now.white.get(state.region.reference, 0.0)
        return replace(case.flat, height=case.flat.height / (1 - white))

    def write_results(state: Any, work: object, into: Path, *_: object) -> None:
        (into / "document.blend").write_text(f"reference {state.region.reference}")

    stand_in_for_steps(monkeypatch, run.steps)
    monkeypatch.setattr(run.steps, "place_photos", lambda *_: case.model)
    monkeypatch.setattr(run.steps, "find_sheet", find_sheet)
    monkeypatch.setattr(run.steps, "build_surface", lambda *_: (case.model.cameras, smooth))
    monkeypatch.setattr(run.steps, "lay_out_page", lay_out_page)
    monkeypatch.setattr(run.steps, "write_results", write_results)

    def go() -> dict[str, Any]:
        run.rectify([photos], out, RunSettings())
        return dict(json.loads((out / "report.json").read_text()))

    return SimpleNamespace(go=go, now=now, out=out)


def test_the_first_way_alone_leaves_nothing_to_report(stand: SimpleNamespace) -> None:
    assert stand.go()["tried"] == []
    assert (stand.out / "document.blend").read_text() == "reference 0"


def test_the_second_way_is_taken_where_the_first_is_refused(stand: SimpleNamespace) -> None:
    stand.now.white = {0: 0.5}
    report = stand.go()
    assert (stand.out / "document.blend").read_text() == "reference 1"
    refused, taken = report["tried"]
    assert (refused["stage"], refused["taken"]) == ("lay_out", False)
    assert refused["figure"] == pytest.approx(0.5, abs=0.01)
    assert refused["limit"] < 0.1
    assert "50 % of the page white" in refused["cause"]
    assert taken == {"way": "another reference photo", "taken": True}
    assert sum("another reference photo was taken instead" in warning for warning in report["warnings"]) == 1


def test_no_way_passes(stand: SimpleNamespace) -> None:
    stand.now.white = {0: 0.5, 1: 0.5}
    with pytest.raises(StepFailed, match=r"50 % of the page white.*give the outline by hand"):
        stand.go()
    assert not (stand.out / "report.json").exists()
    assert "refused" in (stand.out / "log.txt").read_text()
