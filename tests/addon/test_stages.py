"""The table of stages is complete, and data saved under a stage's names is found again."""

from __future__ import annotations

from pathlib import Path

import pytest
from origami.origami_addon import steps
from origami.origami_addon.stages import STAGES, about, parts_of_time


def test_names_that_are_in_files_stay() -> None:
    """The names in .blend files."""
    assert STAGES == ("place", "find", "surface", "unwrap", "lay_out", "page")


def test_the_report_calls_a_stage_as_its_button_does() -> None:
    names = ["place photos", "find sheet", "build surface", "unwrap", "lay out page", "make page"]
    assert [about(stage).reported for stage in STAGES] == names


def test_the_work_of_a_stage_is_named_after_its_button(root: Path) -> None:
    for stage in STAGES:
        verb = about(stage).reported.replace(" ", "_")
        assert [name for name in steps.__all__ if name == verb or name.startswith(f"{verb}_")], stage
        assert (root / "origami_addon" / "steps" / f"{stage}.py").is_file()


def test_no_two_stages_are_called_the_same() -> None:
    for names in ([about(stage).title for stage in STAGES], [about(stage).verb for stage in STAGES]):
        assert len({*names}) == len(STAGES)


def test_each_stage_has_a_page_of_the_manual(root: Path) -> None:
    for stage in STAGES:
        page = (root / "docs" / f"{about(stage).manual}.md").read_text(encoding="utf-8")
        assert "## Settings" in page
        if stage != "lay_out":  # which has no button of its own
            assert f"**{about(stage).verb}**" in page


def test_parts_of_time() -> None:
    assert sum(about(stage).share for stage in STAGES) == 100
    parts = parts_of_time(["unwrap", "lay_out", "page"])
    assert parts == {
        "unwrap": (0.0, pytest.approx(4 / 22)),
        "lay_out": (pytest.approx(4 / 22), pytest.approx(10 / 22)),
        "page": (pytest.approx(10 / 22), pytest.approx(1)),
    }
    for stages in ([stage] for stage in STAGES):
        assert parts_of_time(stages) == {stages[0]: (0.0, 1.0)}
    assert max(end for _, end in parts_of_time(STAGES).values()) <= 1


def test_the_pages_summary_names_its_paper() -> None:
    figures = {"width_px": 30, "height_px": 40, "dpi": 300.0, "dpi_source": "assumed"}
    size = "30 x 40 pixels, 300 dpi (assumed)"
    assert about("page").summary(figures) == [size]  # of a file from before it was measured
    assert about("page").summary(figures | {"paper_lab": None, "paper_unevenness_lightness": None}) == [size]
    measured = figures | {"paper_lab": [94.97, -0.9, 2.26], "paper_unevenness_lightness": 0.63}
    assert about("page").summary(measured) == [size, "Paper L* 95.0, a* -0.9, b* +2.3", "Uneven by 0.6 L*"]
