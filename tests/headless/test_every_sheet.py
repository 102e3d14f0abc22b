"""A page of each sheet in view, each in its own folder; the steps are stand-ins that write given content."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from folded import folded_sheet, stand_in_for_steps, white_page
from killed import Killed, killed_after
from origami.core.errors import StepFailed, UsageError
from origami.headless.options import build_parser, settings_from
from origami.origami_addon import new_results, run
from origami.origami_addon.settings import RunSettings
from origami.origami_addon.state import Region

NAMES = ("page.tif", "outline.json", "document.blend", "cameras/01_a.jpg")


def written(sheets: int, text: str) -> dict[str, str]:
    """The files of a run of ``count`` sheets."""
    return {f"sheet-{number}/{name}": f"{text} {number}" for number in range(1, sheets + 1) for name in NAMES}


@pytest.fixture
def stand(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Runs of a number of sheets, and their files in ``out``."""
    out = tmp_path / "out"
    case = folded_sheet()
    found = case.state.region
    now = SimpleNamespace(sheets=2, text="", failing={}, placed=0, homes=[], mentions=[])

    def place(work: run.steps.Work, *_: object) -> object:
        now.placed += 1
        (work.folder / "sfm").mkdir(exist_ok=True)
        return case.model

    def find_sheet(model: object, work: run.steps.Work, *_: object, **how: bool) -> Region:
        sheet = work.settings.sheet
        if sheet in now.failing:
            raise now.failing[sheet]
        now.mentions.append(not how.get("one_of_all"))
        outline = replace(found.outline, notes=(str(sheet),))
        return replace(found, outline=outline)

    def write_results(state: Any, work: object, into: Path, home: Path, *_: object) -> None:
        now.homes.append(home)
        (into / "cameras").mkdir(exist_ok=True)
        for name in NAMES:
            (into / name).write_text(f"{now.text} {state.region.outline.notes[0]}")

    stand_in_for_steps(monkeypatch, run.steps)
    monkeypatch.setattr(run.steps, "sheets_in_view", lambda *_: [None] * now.sheets)
    monkeypatch.setattr(run.steps, "place_photos", place)
    monkeypatch.setattr(run.steps, "find_sheet", find_sheet)
    monkeypatch.setattr(run.steps, "write_results", write_results)

    def go(sheets: int, text: str, seed: int = 0, sheet: Any = "all", **how: bool) -> run.Report:
        now.sheets, now.text = sheets, text
        settings = RunSettings()
        settings = RunSettings(sheet=sheet, sfm=type(settings.sfm)(seed=seed))
        return run.rectify([photos], out, settings, **how)

    def results() -> dict[str, str]:
        names = [path.relative_to(out).as_posix() for path in sorted(out.rglob("*")) if path.is_file()]
        own = ("report.json", "log.txt", ".origami")
        return {n: (out / n).read_text() for n in names if Path(n).name not in own and not n.startswith("work/")}

    return SimpleNamespace(go=go, out=out, results=results, now=now, photos=photos)


def test_each_sheet_has_a_folder_with_a_report_of_its_own(stand: SimpleNamespace) -> None:
    report = stand.go(2, "a")
    assert stand.results() == written(2, "a")
    assert stand.now.placed == 1
    assert stand.now.homes == [stand.out / "sheet-1", stand.out / "sheet-2"]
    assert stand.now.mentions == [False, False]
    whole = json.loads((stand.out / "report.json").read_text())
    assert whole["settings"]["sheet"] == "all"
    assert set(whole["outputs"]) == set(written(2, "")) | {"sheet-1/report.json", "sheet-2/report.json"}
    assert whole["sheets"] == report.sheets == [{"folder": f"sheet-{n}", "failure": None} for n in (1, 2)]
    for number in (1, 2):
        own = json.loads((stand.out / f"sheet-{number}" / "report.json").read_text())
        assert own["settings"]["sheet"] == number
        assert set(own["outputs"]) == set(NAMES)
        assert own["inputs"] == whole["inputs"]


def test_one_sheet_alone_has_its_folder_too(stand: SimpleNamespace) -> None:
    stand.go(1, "a")
    assert stand.results() == written(1, "a")


def test_what_is_unchanged_is_kept(stand: SimpleNamespace) -> None:
    first = stand.go(2, "a")
    again = stand.go(2, "b", resume=True)
    assert stand.results() == written(2, "a")
    assert again.sheets == first.sheets
    (stand.out / "sheet-2" / "page.tif").unlink()
    stand.go(2, "c", resume=True)
    assert stand.results() == written(2, "c")


def test_a_finished_run_is_not_replaced_unasked(stand: SimpleNamespace) -> None:
    stand.go(2, "a")
    with pytest.raises(UsageError, match="finished run"):
        stand.go(2, "b")
    with pytest.raises(UsageError, match="finished run"):
        stand.go(2, "b", sheet=1)
    assert stand.results() == written(2, "a")


@pytest.mark.parametrize("how", ["force", "resume"])
def test_fewer_sheets_leave_none_of_the_run_before(stand: SimpleNamespace, how: str) -> None:
    stand.go(3, "a")
    stand.go(1, "b", seed=1, **{how: True})
    assert stand.results() == written(1, "b")
    assert not (stand.out / "sheet-2").exists()
    marker = json.loads((stand.out / ".origami").read_text())["files"]
    assert not {"sheet-2", "sheet-3"} & set(marker)


@pytest.mark.parametrize("how", ["force", "resume"])
def test_one_page_takes_the_place_of_every_sheet_and_the_other_way_round(stand: SimpleNamespace, how: str) -> None:
    stand.go(2, "a")
    stand.go(2, "b", sheet=2, **{how: True})
    one = dict.fromkeys(NAMES, "b 2")
    assert stand.results() == one
    assert not (stand.out / "sheet-1").exists()
    stand.go(2, "c", **{how: True})
    assert stand.results() == written(2, "c")


def test_one_page_takes_their_place_where_the_report_was_deleted(stand: SimpleNamespace) -> None:
    stand.go(2, "a")
    (stand.out / "report.json").unlink()
    stand.go(2, "b", sheet=1)
    assert stand.results() == dict.fromkeys(NAMES, "b 1")


@pytest.mark.parametrize("sheet", ["all", 1])
def test_what_the_user_put_into_a_sheets_folder_stays(stand: SimpleNamespace, sheet: Any) -> None:
    stand.go(2, "a")
    mine = {f"sheet-2/{name}": "mine" for name in ("notes.txt", "cameras/mine.jpg")}
    for name, text in mine.items():
        (stand.out / name).write_text(text)
    stand.go(1, "b", sheet=sheet, force=True)
    assert stand.results() == mine | (written(1, "b") if sheet == "all" else dict.fromkeys(NAMES, "b 1"))
    assert not (stand.out / "sheet-2" / "report.json").exists()
    assert set(json.loads((stand.out / "sheet-2" / ".origami").read_text())["files"]) == {"cameras"}
    # whatever appears there from now on is the user's
    (stand.out / "sheet-2" / "page.tif").write_text("mine")
    stand.go(1, "c", sheet=1, force=True)
    assert (stand.out / "sheet-2" / "page.tif").read_text() == "mine"
    with pytest.raises(UsageError, match=r"page\.tif, which Origami did not write"):
        stand.go(2, "d", force=True)


def test_a_folder_of_the_users_in_a_sheets_place(stand: SimpleNamespace) -> None:
    mine = stand.out / "sheet-1"
    mine.mkdir(parents=True)
    (mine / "page.tif").write_text("mine")
    (stand.out / "sheet-2").write_text("mine")
    with pytest.raises(UsageError, match="sheet-1, which Origami did not write"):
        stand.go(2, "a")
    (mine / "page.tif").rename(stand.out / "page")
    mine.rmdir()
    with pytest.raises(UsageError, match="sheet-2, which Origami did not write"):
        stand.go(2, "a")
    mine.mkdir()
    (stand.out / "page").rename(mine / "page.tif")
    stand.go(2, "a", sheet=1)
    stand.go(2, "b", sheet=1, force=True)
    users = {"sheet-1/page.tif": "mine", "sheet-2": "mine"}
    assert stand.results() == users | dict.fromkeys(NAMES, "b 1")
    assert set(json.loads((stand.out / "report.json").read_text())["outputs"]) == set(NAMES)


def test_a_file_of_the_users_in_a_sheets_folder(stand: SimpleNamespace) -> None:
    stand.go(2, "a")
    marker = json.loads((stand.out / "sheet-1" / ".origami").read_text())
    del marker["files"]["page_baked.tif"]
    (stand.out / "sheet-1" / ".origami").write_text(json.dumps(marker))
    (stand.out / "sheet-1" / "page_baked.tif").write_text("mine")
    with pytest.raises(UsageError, match=r"page_baked\.tif, which Origami did not write"):
        stand.go(2, "b", force=True)
    assert stand.results() == written(2, "a") | {"sheet-1/page_baked.tif": "mine"}


def test_a_link_in_a_sheets_place_is_not_followed(stand: SimpleNamespace, tmp_path: Path) -> None:
    stand.go(2, "a")
    archive = tmp_path / "archive"
    os.rename(stand.out / "sheet-2", archive)
    (stand.out / "sheet-2").symlink_to(archive)
    with pytest.raises(UsageError, match="is a link"):
        stand.go(2, "b", force=True)
    stand.go(2, "c", sheet=1, force=True)
    assert (archive / "page.tif").read_text() == "a 2"
    assert not (stand.out / "sheet-1").exists()


def test_photos_in_a_sheets_place(stand: SimpleNamespace) -> None:
    stand.out.mkdir()
    os.rename(stand.photos, stand.out / "sheet-1")
    (stand.photos).symlink_to(stand.out / "sheet-1")
    with pytest.raises(UsageError, match="is the folder of the photos"):
        stand.go(2, "a")


def test_an_outline_that_was_edited_stops_the_run(stand: SimpleNamespace) -> None:
    stand.go(2, "a")
    (stand.out / "sheet-2" / "outline.json").write_text("edited")
    for sheet in ("all", 1):
        with pytest.raises(UsageError, match="pass it in with --sheet 2 and --outline"):
            stand.go(2, "b", sheet=sheet, force=True)
    assert stand.results() == written(2, "a") | {"sheet-2/outline.json": "edited"}


@pytest.mark.parametrize("how", [{}, {"force": True}, {"resume": True}])
def test_a_sheet_that_fails_leaves_the_others(stand: SimpleNamespace, how: dict[str, bool]) -> None:
    if how:
        stand.go(3, "a")
    stand.now.failing = {2: StepFailed("No edge.")}
    report = stand.go(3, "b", seed=1, **how)
    made = {name: text for name, text in written(3, "b").items() if not name.startswith("sheet-2/")}
    assert stand.results() == made
    assert [sheet["failure"] for sheet in report.sheets] == [None, "Sheet 2: No edge.", None]
    stand.now.failing = {}
    stand.go(3, "c", seed=1, resume=True)
    assert stand.results() == written(3, "c")


def test_where_all_fail_the_run_fails_and_the_one_before_stays(stand: SimpleNamespace) -> None:
    stand.go(2, "a")
    stand.now.failing = {1: StepFailed("No edge."), 2: UsageError("Too large.")}
    with pytest.raises(
        StepFailed, match=r"None of the 2 sheets could be made\. Sheet 1: No edge\. Sheet 2: Too large\."
    ):
        stand.go(2, "b", force=True)
    with pytest.raises(StepFailed, match=r"\ANo edge\.\Z"):
        stand.go(1, "b", force=True)
    assert stand.results() == written(2, "a")


def test_exit_code_and_a_line_for_each_sheet(
    command: ModuleType, stand: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "start_empty", lambda: None)

    def rendered(*arguments: Any) -> object:
        report = arguments[1].report
        figures = {"width_px": 100, "height_px": 200, "reference": "1.png", "outline_confidence": 0.987}
        report.stages.append({"name": "make page", "figures": figures})
        return white_page()

    monkeypatch.setattr(run.steps, "make_page", rendered)
    options = [str(stand.photos), "-o", str(stand.out), "--sheet", "all"]
    assert command.main(options) == 0
    said = capsys.readouterr()
    for number in (1, 2):
        page = stand.out / f"sheet-{number}" / "page.tif"
        assert f"Sheet {number}: '{page}', 100 x 200 pixels, from 1.png, edge 99 % sure\n" in said.out
    stand.now.failing = {1: StepFailed("No edge.")}
    assert command.main([*options, "--force"]) == 6
    said = capsys.readouterr()
    assert "error: Sheet 1: No edge.\n" in said.err
    assert "Sheet 1" not in said.out and "Sheet 2: " in said.out


@pytest.mark.parametrize("sheet", ["0", "two", "101", "1.5", "All"])
def test_no_number_of_a_sheet(command: ModuleType, sheet: str) -> None:
    assert command.main(["photos", "-o", "out", "--sheet", sheet]) == 2


@pytest.mark.parametrize("option", ["--outline", "--creases"])
def test_what_was_drawn_is_of_one_sheet(
    command: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    drawn = tmp_path / "drawn.json"
    drawn.write_text("[[1, 2], [30, 4], [20, 60]]" if option == "--outline" else "[[1, 2, 30, 4]]")
    options = ["--sheet", "all", "--reference", "a.jpg", option, str(drawn)]
    assert command.main(["photos", "-o", str(tmp_path / "out"), *options]) == 2
    assert "belong to one sheet; name that sheet (--sheet 1, --sheet 2, ...)" in capsys.readouterr().err


def test_settings_that_name_every_sheet_survive_json(tmp_path: Path) -> None:
    settings = settings_from(build_parser().parse_args(["--sheet", "all"]))
    assert settings.sheet == "all"
    file = tmp_path / "settings.json"
    file.write_text('{"sheet": "all"}')
    assert settings_from(build_parser().parse_args(["--settings", str(file)])) == settings
    file.write_text('{"sheet": "both"}')
    with pytest.raises(UsageError, match="sheet must be one of all"):
        settings_from(build_parser().parse_args(["--settings", str(file)]))


# Numbers of sheets in the earlier and the later run, and the later run's option.
BEFORE_AND_AFTER = [(3, "all", 2, "all", "force"), (2, "all", 1, 1, "resume"), (1, 1, 2, "all", "resume")]
AGAIN: tuple[dict[str, bool], ...] = ({}, {"resume": True}, {"force": True})


@pytest.mark.parametrize(
    ("before", "first", "after", "second", "how", "again"),
    [
        pytest.param(*runs, again, marks=() if number == other else pytest.mark.slow)
        for number, runs in enumerate(BEFORE_AND_AFTER)
        for other, again in enumerate(AGAIN)
    ],
)
def test_a_run_killed_while_results_are_exchanged(
    stand: SimpleNamespace,
    monkeypatch: pytest.MonkeyPatch,
    before: int,
    first: Any,
    after: int,
    second: Any,
    how: str,
    again: dict[str, bool],
) -> None:
    def of(sheets: int, sheet: Any, text: str) -> dict[str, str]:
        return written(sheets, text) if sheet == "all" else dict.fromkeys(NAMES, f"{text} {sheet}")

    exchange = new_results.put_in_place
    mine = {"sheet-3/notes.txt": "mine"} | ({"sheet-1/notes.txt": "mine"} if first == "all" else {})
    for calls in itertools.count():
        stand.go(before, "old", sheet=first, force=True)
        for name, text in mine.items():
            (stand.out / name).parent.mkdir(exist_ok=True)
            (stand.out / name).write_text(text)
        with monkeypatch.context() as patch:
            reached: list[Callable[[], bool]] = []

            def from_here_on(out: Path, calls=calls, patch=patch, reached=reached) -> None:
                reached.append(killed_after(calls, patch, "rmdir", "mkdir"))
                exchange(out)

            patch.setattr(run, "put_in_place", from_here_on)
            try:
                stand.go(after, "new", seed=1, sheet=second, **{how: True})
            except Killed:
                pass
            came_to_it = reached[0]()
        if not came_to_it:
            break
        for sheet in stand.out.glob("sheet-*"):
            if (sheet / "report.json").exists():  # a sheet that looks complete is complete
                assert len({(sheet / name).read_text() for name in NAMES}) == 1
        finished = (stand.out / "report.json").exists()
        waiting = (stand.out / "work" / "results" / "report.json").exists()
        if finished and not waiting and not again:
            with pytest.raises(UsageError, match="finished run"):
                stand.go(after, "new", seed=1, sheet=second)
        else:
            stand.go(after, "new", seed=1, sheet=second, **again)
        assert stand.results() == mine | of(after, second, "new")
        for leftover in stand.out.glob("sheet-*"):
            stand_in = second == "all" and int(leftover.name[-1]) <= after
            assert (leftover / "report.json").exists() == stand_in
        for path in stand.out.glob("sheet-*/notes.txt"):
            path.unlink()
        for path in stand.out.glob("sheet-*"):
            if not any(path.iterdir()):
                path.rmdir()
    assert calls > len(NAMES)
