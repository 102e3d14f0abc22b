"""Progress and cancelling."""

from __future__ import annotations

import pytest
from origami.core.errors import Cancelled
from origami.core.watch import SILENT, Watch


def test_a_part_covers_its_share_of_the_whole():
    reported = []
    watch = Watch(lambda fraction, text: reported.append((round(fraction, 6), text)))
    part = watch.part(0.5, 0.9)
    part.step(0, "begin")
    part.part(0.5, 1).step(0.5, "deep")
    part.step(1, "end")
    assert reported == [(0.5, "begin"), (0.8, "deep"), (0.9, "end")]


def test_a_part_is_cancelled_with_the_whole():
    with pytest.raises(Cancelled):
        Watch(cancelled=lambda: True).part(0, 1).step(0, "never reported")
    SILENT.step(0.5, "reported to nobody")
