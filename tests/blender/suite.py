"""Runs inside a real Blender, without a window: the add-on's tests.

blender --background --python-exit-code 1 --python tests/blender/suite.py -- CHECKOUT [ARGUMENTS ...]

CHECKOUT is a copy of the project. pytest is in the scripts/modules of Blender's user resources; scipy and pycolmap must
be in Blender's own Python, because the tests reset to factory settings and Blender then removes extensions' wheels.
"""

from __future__ import annotations

import importlib.util
import os
import sys

import bpy
import pytest

# They load pycolmap into their own process, which Blender does not survive: both contain glog.
_FILES_NOT_HERE = ("test_bad_input.py", "test_sfm.py")
# They start a separate Python that has Blender as a module.
_NEED_MODULE = (
    "test_preferences.py::test_without_scipy_the_preferences_are_there_to_say_so",
    "test_window_export.py::test_the_command_line_makes_the_same_page",
)
# Features that a distribution's build of Blender may lack.
_NEED_USD = (
    "test_export.py::test_exported_sheet_comes_back_as_it_was[sheet.usdz]",
    "test_export.py::test_export_shows_the_page_whatever_the_window_shows[sheet.usdz]",
    "test_export.py::test_usdz_is_a_package_as_other_programs_want_it",
    "test_export.py::test_exports_leave_the_document_as_it_was",
    "test_export.py::test_unwritable_place_is_reported",
    "test_export.py::test_full_disk_is_reported_in_one_line[sheet.usdz]",
    "test_window_export.py::test_every_kind_of_file_is_written",
)
_NEED_OPENIMAGEIO = (
    "test_photos.py::test_kinds_of_pictures[_decode_with_oiio]",
    "test_photos.py::test_a_hole_in_a_jpeg",
)


def main(checkout: str, *arguments: str) -> int:
    """Run the tests and return pytest's exit code."""
    os.chdir(checkout)
    without = list(_NEED_MODULE)
    if not bpy.app.build_options.usd:
        without += _NEED_USD
    if importlib.util.find_spec("OpenImageIO") is None:
        without += _NEED_OPENIMAGEIO
    ignored = [f"--ignore=tests/addon/{name}" for name in _FILES_NOT_HERE]
    deselected = [f"--deselect=tests/addon/{name}" for name in without]
    options = ["-p", "no:cacheprovider", "-m", "not download"]
    return int(pytest.main([*options, "tests/addon", *ignored, *deselected, *arguments]))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[sys.argv.index("--") + 1 :]))
