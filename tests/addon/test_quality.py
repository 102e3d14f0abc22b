"""The confidence agrees with the figures."""

from __future__ import annotations

import pytest

GOOD = {
    "photos": 8,
    "photos_placed": 8,
    "views_per_point_mean": 4.3,
    "viewing_angle_median_degrees": 33.0,
    "reprojection_error_mean_px": 0.7,
    "outline_confidence": 0.99,
    "residual_median_page_lengths": 0.0002,
    "stretch_95th_percentile": 0.004,
    "flipped_triangles": 0,
}


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, "good"),
        ({"photos_placed": 6}, "fair"),
        ({"photos_placed": 3}, "poor"),
        ({"views_per_point_mean": 3.5}, "fair"),
        ({"viewing_angle_median_degrees": 5.0}, "poor"),
        ({"reprojection_error_mean_px": 1.5}, "fair"),
        ({"reprojection_error_mean_px": 4.0}, "poor"),
        ({"outline_confidence": 0.2}, "poor"),
        ({"residual_median_page_lengths": 0.0008}, "fair"),
        ({"stretch_95th_percentile": 0.05}, "poor"),
        ({"flipped_triangles": 2}, "poor"),
    ],
)
def test_one_bad_measure_decides(change, expected):
    from origami.origami_addon.window.quality import confidence, measures

    found = measures(GOOD | change)
    assert len(found) == (8 if change.get("flipped_triangles") else 7)
    assert confidence(found) == expected
    assert sum(measure.verdict != "good" for measure in found) == (expected != "good")


def test_only_what_is_known_is_reported():
    from origami.origami_addon.window.quality import confidence, measures

    assert [measure.text for measure in measures({"outline_confidence": 0.5})] == ["Paper's edge 50 % sure"]
    assert confidence(measures({})) == "good"


KNOWN = {"90_percent_of_the_page_within": 0.12, "half_of_the_page_within": 0.05, "height": 297.0, "unit": "mm"}


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, "good"),
        ({"views_per_point_mean": 3.5, "stretch_95th_percentile": 0.05}, "good"),
        ({"90_percent_of_the_page_within": 1.0}, "fair"),
        ({"90_percent_of_the_page_within": 2.0}, "poor"),
        ({"outline_confidence": 0.2}, "poor"),
        ({"flipped_triangles": 2}, "poor"),
        ({"90_percent_of_the_page_within": None, "views_per_point_mean": 3.5}, "fair"),
    ],
)
def test_the_bound_decides_where_it_is_known(change, expected):
    from origami.origami_addon.window.quality import confidence, measures

    assert confidence(measures(GOOD | KNOWN | change)) == expected


@pytest.mark.parametrize(
    ("figures", "text"),
    [
        (KNOWN, "90 % of the page is within 0.12 mm"),
        (KNOWN | {"height": 1.0, "unit": "page heights"}, "90 % of the page is within 12 % of its height"),
    ],
)
def test_the_bound_is_a_sentence(figures, text):
    from origami.origami_addon.window.quality import measures

    assert [measure.text for measure in measures(figures)] == [text]
