"""What is replaced in a folder of results is Origami's own, and the document's."""

from __future__ import annotations

import pytest
from origami.core.errors import UsageError
from origami.origami_addon.files.results_folder import keep_off_inputs, keep_off_others, mark, owner_of

NAMES = ["page.tif", "page.jpg"]


def test_a_folder_that_is_not_marked_holds_the_users_files(tmp_path):
    keep_off_others(tmp_path, NAMES, "Brief ü")
    (tmp_path / "page.jpg").touch()
    with pytest.raises(UsageError, match=r"page\.jpg, which Origami did not write"):
        keep_off_others(tmp_path, NAMES, "Brief ü")
    keep_off_others(tmp_path, NAMES[:1], "Brief ü")


def test_a_marked_folder_holds_the_files_of_its_document(tmp_path):
    assert owner_of(tmp_path) is None
    mark(tmp_path, "Brief ü")
    assert owner_of(tmp_path) == "Brief ü"
    keep_off_others(tmp_path, NAMES, "Karte")
    (tmp_path / "page.jpg").touch()
    keep_off_others(tmp_path, NAMES, "Brief ü")
    for other in ("Karte", ""):
        with pytest.raises(UsageError, match=r"page\.jpg of the document Brief ü"):
            keep_off_others(tmp_path, NAMES, other)


def test_what_the_command_line_wrote_may_be_replaced(tmp_path):
    mark(tmp_path)
    assert owner_of(tmp_path) == ""
    (tmp_path / "page.jpg").touch()
    keep_off_others(tmp_path, NAMES, "Brief ü")
    keep_off_others(tmp_path, NAMES)


def test_a_photo_is_not_replaced_in_any_folder(tmp_path):
    mark(tmp_path)
    for name in ("page.jpg", "1.jpg"):
        (tmp_path / name).touch()
    keep_off_inputs([tmp_path / "1.jpg"], tmp_path, NAMES)
    with pytest.raises(UsageError, match=r"page\.jpg lies where the results go"):
        keep_off_inputs([tmp_path / "page.jpg"], tmp_path, NAMES)
