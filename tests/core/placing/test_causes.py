"""Photos that cannot be placed: the measurements select a cause, with its evidence and its remedy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from origami.core.camera import Camera
from origami.core.placing.cause import Cause, sentence
from origami.core.placing.causes import possible_causes
from origami.core.placing.causes_in_matches import mirrored_photos, too_near
from origami.core.placing.trial import Trial, lenses_may_differ, prefer_own_lenses
from origami.core.placing.verdict import failure
from origami.core.sparse_model import SparseModel
from origami.origami_addon.files.photos import Photo

WIDTH, HEIGHT = 600, 800
COUNT = 6
PHOTOS = [Photo(Path(f"{i}.jpg"), f"{i}.jpg", WIDTH, HEIGHT, str(i), 1, None, "", "", "", None) for i in range(COUNT)]
EVERYBODY = [(first, second) for first in range(COUNT) for second in range(first + 1, COUNT)]
SHARP = {"features": [3000] * COUNT, "finest_pixels": [1.2] * COUNT, "repeated": [0.0] * COUNT, "mirrored": []}


def matches(pairs: list[tuple[int, int]], number: int = 100, baseline: float = 0.4) -> dict[str, np.ndarray]:
    """``count`` verified matches per pair, of random points in space, from cameras at a distance along x."""
    random = np.random.default_rng(0)
    points = random.uniform([-0.6, -0.8, 1.8], [0.6, 0.8, 2.2], (number, 3))
    pixels = []
    for first, second in pairs:
        seen = [
            0.8 * HEIGHT * (points - [i * baseline - 0.5, 0, 0])[:, :2] / points[:, 2:] + [WIDTH / 2, HEIGHT / 2]
            for i in (first, second)
        ]
        pixels.append(np.hstack(seen))
    return {
        "match_pair": np.repeat(np.array(pairs, int).reshape(-1, 2), number, 0),
        "match_pixel": np.concatenate([np.zeros((0, 4)), *pixels]),
        "match_verified": np.ones(len(pairs) * number, bool),
    }


def trial(
    placed: int = 0,
    excess: float = 0.0,
    error: float = 0.0003,
    focal_lengths: tuple[float, ...] = (0.8,) * COUNT,
    useful: bool = True,
    odd: tuple[int, ...] = (),
) -> Trial:
    """A trial that placed some photos; the odd ones contradict the rest."""
    cameras = tuple(
        Camera(f"{i}.jpg", WIDTH, HEIGHT, focal * HEIGHT, np.zeros(2), np.zeros(2), np.eye(3), np.zeros(3))
        for i, focal in enumerate(focal_lengths[:placed])
    )
    none = np.zeros(0, int)
    model = SparseModel(cameras, np.zeros((0, 3)), np.zeros((0, 3), np.uint8), none, none, np.zeros((0, 2)))
    side = np.isin(np.arange(placed), odd)
    contradiction = 0.2 * (side[:, None] != side) if odd else 0.2 * (1 - np.eye(placed))
    served = placed >= 3
    return Trial(
        "usual",
        model if served else None,
        model if served and useful else None,
        frozenset(range(placed)),
        "",
        contradiction,
        excess,
        error if served else np.inf,
    )


def likeliest(arrays: dict[str, np.ndarray], shared: Trial, own: Trial | None = None, **look: object) -> Cause:
    return possible_causes(PHOTOS, arrays, shared, own, SHARP | look)[0]


def test_a_burst_is_too_near_and_not_too_far() -> None:
    cause = likeliest(matches(EVERYBODY, baseline=0.003), trial())
    assert "too near each other" in cause.claim
    assert "move the camera by a hand's breadth" in cause.remedy
    assert cause.evidence["baseline_degrees"] < 0.5


def test_photos_around_a_sheet_are_not_too_near() -> None:
    assert too_near(PHOTOS, matches(EVERYBODY, baseline=0.1)) is None


def test_nothing_in_common() -> None:
    text = sentence(possible_causes(PHOTOS, matches(EVERYBODY, 20), trial(), None, SHARP))
    assert "different things" in text
    assert "too far apart (of 15 pairs of photos 0 have enough in common)" in text


def test_a_chain_of_photos_is_too_far_apart() -> None:
    chain = [(i, i + 1) for i in range(COUNT - 1)]
    cause = likeliest(matches(chain), trial(3))
    assert "too far apart (of 15 pairs of photos 5 have enough in common)" in cause.claim


def test_two_documents_are_named() -> None:
    first_three = [(0, 2), (0, 4), (2, 4)]
    cause = likeliest(matches([*first_three, (1, 3), (1, 5), (3, 5)]), trial(3))
    assert "(0.jpg, 2.jpg, 4.jpg; 1.jpg, 3.jpg, 5.jpg)" in cause.claim
    assert "a folder of their own" in cause.remedy


def test_repeated_print_comes_before_a_sheet_that_moved() -> None:
    shared = trial(3, excess=18.0, odd=(2,))
    cause = likeliest(matches(EVERYBODY), shared, repeated=[0.5, 0.52, 0.54, 0.3, 0.55, 0.6])
    assert "repeat over the sheet (53 % of the places" in cause.claim
    assert "newspaper" in cause.remedy


def test_blur() -> None:
    cause = likeliest(matches(EVERYBODY, 30), trial(), finest_pixels=[6, 6, 9, 6, 8, 7])
    assert "6 pixels wide, most of all in 2.jpg, 4.jpg, 5.jpg" in cause.claim


def test_blank_paper() -> None:
    assert "only 25 places" in likeliest(matches([]), trial(), features=[25] * COUNT).claim


def test_mirrored_photos_are_named() -> None:
    sides = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    across = [[i, j, 300, 20] for i in range(4) for j in (4, 5)]
    cause = likeliest(matches([*sides, (4, 5)]), trial(4), mirrored=across)
    assert "(4.jpg, 5.jpg and the others" in cause.claim


def test_symmetric_print_is_not_mirrored() -> None:
    agreeing = np.zeros((COUNT, COUNT), int)
    assert mirrored_photos(agreeing, [[0, 1, 90, 80]]) == []
    assert mirrored_photos(agreeing, [[0, 1, 90, 10]]) == [1]


def test_a_sheet_that_moved_in_some_photos() -> None:
    cause = likeliest(matches(EVERYBODY), trial(COUNT, excess=5.0, odd=(1, 4)))
    assert "moved or bent between the photos (1.jpg, 4.jpg show it differently" in cause.claim
    assert "stabilised" not in cause.claim


def test_photos_that_all_contradict_each_other_may_be_of_a_stabilised_video() -> None:
    assert "stabilised" in likeliest(matches(EVERYBODY), trial(COUNT, excess=5.0)).claim


def test_zoom_that_explains_more_but_not_all() -> None:
    own = trial(COUNT, excess=1.5, focal_lengths=(0.8, 1.1) * 3)
    cause = likeliest(matches(EVERYBODY), trial(COUNT, excess=20.0, odd=(1, 3, 5)), own)
    assert "zoom seems to differ between the photos (by a factor of 1.38)" in cause.claim


def test_a_second_cause_is_named_only_where_it_is_near() -> None:
    strong, near, weak = Cause("One is so", "do this", 2.0), Cause("Two is so", "do that", 1.5), Cause("No", "no", 0.1)
    assert sentence([strong, near, weak]) == "One is so: do this. Or two is so: then do that."
    assert sentence([strong, weak]) == "One is so: do this."


def test_the_failure_says_how_many_photos_were_placed() -> None:
    far = [Cause("So", "do this", 1.0)]
    assert failure(PHOTOS, trial(), far) == "None of 6 photos fit together. So: do this."
    assert failure(PHOTOS, trial(3), far).startswith(
        "Only 3 of 6 photos fit together; these do not: 3.jpg, 4.jpg, 5.jpg."
    )
    assert failure(PHOTOS, trial(3, excess=2.0), far).startswith("Only 3 of 6 photos fit together")
    assert failure(PHOTOS, trial(6, excess=2.0), far) == "The photos contradict each other. So: do this."


def test_a_model_without_depth_says_so_itself_unless_a_cause_does() -> None:
    weak = replace(trial(6, useful=False), weakness="There are only 40 points.")
    assert failure(PHOTOS, weak, [Cause("So", "do this", 0.5)]) == "There are only 40 points."
    assert failure(PHOTOS, weak, [Cause("So", "do this", 2.0)]) == "There are only 40 points. So: do this."
    assert failure(PHOTOS, weak, [Cause("So", "do this", 2.0, explains_few_points=True)]) == "So: do this."


class TestOwnLenses:
    zoomed = (0.8, 1.1) * 3

    def test_a_good_set_is_not_tried_again(self) -> None:
        assert not lenses_may_differ(trial(COUNT), PHOTOS, matches(EVERYBODY))

    @pytest.mark.parametrize("shared", [trial(COUNT, excess=2.0), trial(5), trial(COUNT, error=0.0007)])
    def test_one_that_fails_or_fits_badly_is(self, shared: Trial) -> None:
        assert lenses_may_differ(shared, PHOTOS, matches(EVERYBODY))

    def test_photos_with_nothing_in_common_are_not(self) -> None:
        assert not lenses_may_differ(trial(), PHOTOS, matches(EVERYBODY, 20))

    def test_they_are_kept_where_they_explain_the_photos(self) -> None:
        own = trial(COUNT, focal_lengths=self.zoomed)
        for shared in (trial(), trial(COUNT, excess=20.0), trial(5), trial(COUNT, error=0.0007)):
            assert prefer_own_lenses(shared, own, COUNT)

    def test_they_are_not_kept_where_the_lenses_hardly_differ(self) -> None:
        assert not prefer_own_lenses(trial(), trial(COUNT, focal_lengths=(0.8, 0.83) * 3), COUNT)

    def test_they_are_not_kept_where_contradiction_stays(self) -> None:
        shared = trial(COUNT, excess=1.4)
        assert not prefer_own_lenses(shared, trial(COUNT, excess=1.2, focal_lengths=self.zoomed), COUNT)
        assert not prefer_own_lenses(shared, trial(COUNT, excess=0.9, focal_lengths=self.zoomed), COUNT)

    def test_they_are_not_kept_where_a_shared_lens_fits_as_well(self) -> None:
        assert not prefer_own_lenses(trial(COUNT), trial(COUNT, focal_lengths=self.zoomed), COUNT)
