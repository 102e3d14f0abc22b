"""Only the document's own files are replaced in a folder of results."""

from __future__ import annotations

import json
import os

import pytest
from marked_folder import mark
from origami.core.errors import UsageError
from origami.origami_addon.files.marker import MARKER, claim, owners
from origami.origami_addon.files.results_folder import keep_off_inputs, keep_off_others

NAMES = ["page.tif", "page.jpg"]


def test_a_folder_that_is_not_marked_holds_the_users_files(tmp_path):
    keep_off_others(tmp_path, NAMES, "Brief ü")
    (tmp_path / "page.jpg").touch()
    with pytest.raises(UsageError, match=r"page\.jpg, which Origami did not write"):
        keep_off_others(tmp_path, NAMES, "Brief ü")
    keep_off_others(tmp_path, NAMES[:1], "Brief ü")


def test_a_marked_folder_holds_the_files_of_its_document(tmp_path):
    assert owners(tmp_path, NAMES) is None
    claim(tmp_path, NAMES, "Brief ü")
    assert owners(tmp_path, NAMES) == dict.fromkeys(NAMES, "Brief ü")
    keep_off_others(tmp_path, NAMES, "Karte")
    (tmp_path / "page.jpg").touch()
    keep_off_others(tmp_path, NAMES, "Brief ü")
    for other in ("Karte", ""):
        with pytest.raises(UsageError, match=r"page\.jpg of the document Brief ü"):
            keep_off_others(tmp_path, NAMES, other)


def test_what_the_command_line_wrote_may_be_replaced(tmp_path):
    mark(tmp_path, NAMES)
    (tmp_path / "page.jpg").touch()
    keep_off_others(tmp_path, NAMES, "Brief ü")
    keep_off_others(tmp_path, NAMES)


def test_what_the_marker_does_not_list_is_the_users(tmp_path):
    mark(tmp_path, ["page.jpg"])
    for name in NAMES:
        (tmp_path / name).touch()
    keep_off_others(tmp_path, ["page.jpg"])
    with pytest.raises(UsageError, match=r"page\.tif, which Origami did not write"):
        keep_off_others(tmp_path, NAMES)
    keep_off_others(tmp_path, NAMES, known=["page.tif"])


def test_a_later_claim_keeps_the_earlier_ones(tmp_path):
    claim(tmp_path, ["page.jpg"], "Brief ü")
    claim(tmp_path, ["page.tif"], "Karte")
    assert owners(tmp_path, NAMES) == {"page.jpg": "Brief ü", "page.tif": "Karte"}
    content = json.loads((tmp_path / MARKER).read_text(encoding="utf-8"))
    assert content["application"] == "Origami"
    assert [path.name for path in tmp_path.iterdir()] == [MARKER]


FORMER = "Origami writes its results into this folder; a later run may replace them.\n"


@pytest.mark.parametrize(("text", "document"), [(FORMER, ""), (FORMER + "Document: Brief ü\n", "Brief ü")])
def test_a_marker_of_before_stands_for_all_results(tmp_path, text, document):
    (tmp_path / MARKER).write_text(text, encoding="utf-8")
    (tmp_path / "page.tif").touch()
    assert owners(tmp_path, NAMES) == dict.fromkeys(NAMES, document)
    if document:
        claim(tmp_path, ["page.jpg"], document)
    else:
        mark(tmp_path, ["page.jpg"])
    assert owners(tmp_path, []) == dict.fromkeys(NAMES, document)


FOREIGN = [
    "",
    "Origami",
    "[]",
    "{}",
    '{"application": "Paperfold", "version": 1, "files": {}}',
    '{"application": "Origami", "version": 2, "files": {}}',
    '{"application": "Origami", "version": 1, "files": ["page.tif"]}',
    "[" * 100000,
    FORMER + "more",
]


@pytest.mark.parametrize("text", FOREIGN)
def test_a_marker_that_is_not_ours(tmp_path, text):
    (tmp_path / MARKER).write_text(text)
    for use in (keep_off_others, claim):
        with pytest.raises(UsageError, match=r"\.origami, which Origami did not write"):
            use(tmp_path, NAMES)
    assert (tmp_path / MARKER).read_text() == text


def test_a_marker_that_is_a_folder_or_a_link_is_not_ours(tmp_path):
    real, folder, linked, dangling = (tmp_path / name for name in ("real", "folder", "linked", "dangling"))
    for out in (real, folder, linked, dangling):
        out.mkdir()
    claim(real, NAMES)
    (folder / MARKER).mkdir()
    (linked / MARKER).symlink_to(real / MARKER)
    (dangling / MARKER).symlink_to(tmp_path / "nowhere")
    for out in (folder, linked, dangling):
        for use in (keep_off_others, claim):
            with pytest.raises(UsageError, match=r"\.origami, which Origami did not write"):
                use(out, NAMES)
    assert not (tmp_path / "nowhere").exists()


def test_a_marker_is_never_written_through(tmp_path):
    """A hard link keeps its content."""
    claim(tmp_path, NAMES[:1])
    before = (tmp_path / MARKER).read_bytes()
    os.link(tmp_path / MARKER, tmp_path / "copy")
    mark(tmp_path, NAMES)
    assert (tmp_path / "copy").read_bytes() == before != (tmp_path / MARKER).read_bytes()


@pytest.mark.parametrize("name", ["page.tif", "work"])
def test_links_in_the_place_of_results(tmp_path, name):
    out, theirs = tmp_path / "out", tmp_path / "theirs"
    out.mkdir()
    mark(out, [*NAMES, "work"])
    for target in (theirs, tmp_path / "nowhere"):
        (out / name).symlink_to(target)
        theirs.mkdir(exist_ok=True)
        with pytest.raises(UsageError, match="is a link"):
            keep_off_others(out, [*NAMES, "work"])
        (out / name).unlink()


def test_a_folder_that_is_itself_reached_by_a_link(tmp_path):
    out, link = tmp_path / "out", tmp_path / "link"
    out.mkdir()
    link.symlink_to(out)
    mark(link, NAMES)
    (out / "page.jpg").touch()
    keep_off_others(link, NAMES)


def test_a_photo_is_not_replaced_in_any_folder(tmp_path):
    mark(tmp_path, NAMES)
    for name in ("page.jpg", "1.jpg"):
        (tmp_path / name).touch()
    keep_off_inputs([tmp_path / "1.jpg"], tmp_path, NAMES)
    with pytest.raises(UsageError, match=r"page\.jpg lies where the results go"):
        keep_off_inputs([tmp_path / "page.jpg"], tmp_path, NAMES)
