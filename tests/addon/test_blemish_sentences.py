"""Warnings about glare, blur and shadows."""

from __future__ import annotations

import pytest
from origami.core.page.healing import BURNT, UNLIKE, Blemish
from origami.origami_addon.blemish_sentences import blemish_sentence

NAMES = ("a.jpg", "b.jpg", "c.jpg")


@pytest.mark.parametrize(
    ("blemish", "expected"),
    [
        (Blemish("glare", 0.02, 0.02, (1,)), "In a.jpg, 2 % of the page is glare; it was taken from b.jpg."),
        (
            Blemish("blur", 0.3, 0.3, (2, 1)),
            "In a.jpg, 30 % of the page is blurred; it was taken from c.jpg and b.jpg.",
        ),
        (Blemish("shadow", 0.005), "In a.jpg, 0.5 % of the page is in a shadow or under something, and no other "),
        (Blemish("blur", 0.4, 0.1, (1,)), "10 % was taken from b.jpg, and for 30 % no other photo is sharper there"),
        (Blemish(BURNT, 0.03), "3 % of the page is burnt out in every photo that shows it: any print there is lost"),
        (Blemish(UNLIKE, 0.03), "but their print does not line up with that of a.jpg there, so it stays as it is"),
    ],
)
def test_sentence(blemish, expected):
    assert expected in blemish_sentence(blemish, NAMES, 0)
