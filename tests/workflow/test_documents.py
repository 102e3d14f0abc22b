"""Which documents a batch has, and which of their options each rule reads."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from origami.core.setting import declarations_within
from origami.origami_addon.settings import RunSettings

NONE: dict[str, Any] = {"paper": None, "dpi": None, "kind": None, "options": "", "languages": "eng"}


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """A folder with three documents."""
    for name in ("b", "-a b", "Ü {1}"):
        (tmp_path / "photos" / name).mkdir(parents=True)
        (tmp_path / "photos" / name / "1.jpg").touch()
    (tmp_path / "photos" / ".hidden").mkdir()
    (tmp_path / "photos" / "note.txt").touch()
    return tmp_path / "photos"


def read(scripts: dict[str, ModuleType], source: Path, **common: Any) -> dict[str, Any]:
    return dict(scripts["documents"].read_documents(source, source / "out", NONE | common))


def table(photos: Path, text: str) -> Path:
    (photos / "documents.csv").write_text(text, encoding="utf-8")
    return photos / "documents.csv"


def test_each_folder_in_a_folder_is_a_document(scripts: dict[str, ModuleType], photos: Path) -> None:
    (photos / "out").mkdir()
    documents = read(scripts, photos, paper="A4")
    assert set(documents) == {"b", "-a b", "Ü %7B1%7D"}
    assert documents["Ü %7B1%7D"].folder == photos / "Ü {1}"
    assert documents["b"].photos() == [str(photos / "b" / "1.jpg")]
    assert documents["b"].arguments("page") == ["--paper=A4"]
    assert documents["b"].arguments("sheet") == []


def test_photos_that_the_workflow_cannot_name_are_followed_by_time(
    scripts: dict[str, ModuleType], photos: Path
) -> None:
    document = read(scripts, photos)["Ü %7B1%7D"]
    assert document.photos() == []
    before = document.others()
    (photos / "Ü {1}" / "1.jpg").write_text("another")
    assert [name for name, *_ in before] == ["'1.jpg'"]
    assert document.others() != before


def test_each_rule_reads_its_own_options(scripts: dict[str, ModuleType], photos: Path) -> None:
    source = table(
        photos,
        "folder;Paper;dpi;kind;options\r\n"
        'b;A4;300;archive;"--light white --match-size=2000 --outline ""an edge.json"" --no-ridge-rows"\r\n',
    )
    (photos / "an edge.json").touch()
    document = read(scripts, source, dpi=200)["b"]
    assert document.arguments("place") == ["--kind=archive", "--match-size=2000"]
    outline = f"--outline={photos / 'an edge.json'}"
    assert document.arguments("sheet") == ["--kind=archive", "--match-size=2000", outline, "--no-ridge-rows"]
    assert document.arguments("page")[-3:] == ["--light=white", "--paper=A4", "--dpi=300"]
    assert document.inputs("sheet") == [str(photos / "an edge.json")]
    assert document.inputs("page") == []


def test_every_option_has_the_rule_of_its_stage(scripts: dict[str, ModuleType]) -> None:
    rules = {
        "place": "place",
        "find": "sheet",
        "surface": "sheet",
        "unwrap": "sheet",
        "lay_out": "page",
        "page": "page",
    }
    named = scripts["options"].RULE_OF_OPTION
    declared = {each.flag: rules[each.stage] for _, each in declarations_within(RunSettings) if each.option}
    declared |= {f"--no-{flag[2:]}": rule for flag, rule in declared.items() if f"--no-{flag[2:]}" in named}
    del declared["--threads"]
    of_the_run = {"--settings": "place", "--recursive": "place", "--texture-from": "page"}
    assert named == declared | of_the_run


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("folder,size\nb,A4\n", "the column 'size'"),
        ("paper\nA4\n", "no column folder"),
        ("folder,paper\nb\n", "Line 2"),
        ("folder,paper\nb,A4,300\n", "Line 2"),
        ("folder,paper\n,A4\n", "names no folder"),
        ("folder\n", "names no document"),
        ('folder\n"b\n', "not CSV"),
        ("folder\nb\n./b\n", "have the name b"),
        ("folder,document\nb,X\n-a b,x\n", "have the name X"),
        ("folder,document\nb,summary.csv\n", "No folder of results"),
        ("folder,document\nb,..\n", "No folder of results"),
        ("folder,options\nb,--sheet all\n", "a row for each sheet"),
        ("folder,options\nb,--force\n", "not for a batch"),
        ("folder,options\nb,--papper A4\n", "no option --papper"),
        ("folder,options\nb,A4\n", "is not an option"),
        ("folder,options\nb,--light 'white\n", "quotation mark"),
    ],
)
def test_a_table_that_cannot_be_meant_is_refused(
    scripts: dict[str, ModuleType], photos: Path, text: str, reason: str
) -> None:
    with pytest.raises(scripts["options"].BatchError, match=reason) as refused:
        read(scripts, table(photos, text))
    assert str(refused.value).endswith(".")


def test_a_table_may_name_a_folder_that_is_missing(scripts: dict[str, ModuleType], photos: Path) -> None:
    document = read(scripts, table(photos, "folder\ngone\n"))["gone"]
    assert document.photos() == [] and document.others() == []


def test_there_must_be_documents(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    for source, reason in ((tmp_path / "gone", "no folder or table"), (tmp_path, "names no document")):
        with pytest.raises(scripts["options"].BatchError, match=reason):
            read(scripts, source)
