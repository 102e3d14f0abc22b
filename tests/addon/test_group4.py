"""Bitmaps packed as Group 4 are what libtiff and libtiff's users unpack."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from origami.origami_addon.files import group4 as module
from origami.origami_addon.files.group4 import group4
from origami.origami_addon.files.image_files import write_tiff
from PIL import Image


def unpacked(folder: Path, ink: np.ndarray) -> np.ndarray:
    """The bitmap after a way through a TIFF, as libtiff reads it."""
    write_tiff(folder / "page.tif", ~ink, 300)
    with Image.open(folder / "page.tif") as read:
        assert read.info["compression"] == "group4"
        assert read.mode == "1"
        return ~np.asarray(read)


def test_blank_rows_take_a_bit_each():
    assert group4(np.zeros((3, 10), bool)).hex() == "e0020020"  # three times 1, and twice 000000000001


def test_words_of_the_recommendation():
    row = np.zeros((1, 70), bool)
    row[0, 65:68] = True
    # horizontal; 65 white: 64 and 1, 3 black; the change back to white is at the end of the row above: vertical
    bits = "001" + "11011" + "000111" + "10" + "1" + 2 * "000000000001"
    packed = "".join(f"{byte:08b}" for byte in group4(row))
    assert packed.rstrip("0") == bits.rstrip("0")
    tables = [words.split() for words in (module._WHITE, module._BLACK, module._LONG)]
    assert [len(set(words)) for words in tables] == [64 + 27, 64 + 27, 13]


@pytest.mark.parametrize("width", [1, 2, 7, 8, 9, 63, 64, 65, 500, 1728, 2560, 2561, 4000, 5121])
def test_bitmaps_come_back(tmp_path: Path, width: int):
    random = np.random.default_rng(width)
    rows = [random.random((3, width)) < share for share in (0, 1, 0.01, 0.99, 0.001)]
    walk = np.cumsum(random.integers(-4, 5, (20, 6)), axis=0) + random.integers(0, width, 6)
    rows.append(((np.arange(width)[None, :, None] > walk[:, None]).sum(axis=-1) & 1).astype(bool))
    if width <= 500:  # as many words as pixels
        stripes = np.arange(width)[None] % 2 == 0
        rows += [random.random((3, width)) < 0.5, stripes, ~stripes, stripes, stripes, np.ones((2, width), bool)]
    ink = np.concatenate(rows)
    np.testing.assert_array_equal(unpacked(tmp_path, ink), ink)
    np.testing.assert_array_equal(unpacked(tmp_path, ink[:1]), ink[:1])


def test_a_line_of_dots(tmp_path: Path):
    ink = np.arange(4000)[None] % 2 == 0
    np.testing.assert_array_equal(unpacked(tmp_path, ink), ink)


def test_bands_of_rows_do_not_show(monkeypatch):
    ink = np.random.default_rng(0).random((50, 130)) < 0.3
    whole = group4(ink)
    monkeypatch.setattr(module, "_BAND", 700)
    assert group4(ink) == whole
