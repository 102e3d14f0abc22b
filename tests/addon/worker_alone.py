"""The worker's own functions. `test_worker.py` runs these tests in a process without Blender."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.placing import checks
from origami.origami_addon.sfm.pycolmap_worker.descriptors import mirrored, unit_vectors
from origami.origami_addon.sfm.pycolmap_worker.look_closer import agreeing, repeated
from origami.origami_addon.sfm.pycolmap_worker.place import SANE_FOCAL_LENGTHS, attempts


def test_the_worker_and_its_client_agree() -> None:
    assert SANE_FOCAL_LENGTHS == checks.SANE_FOCAL_LENGTHS
    names = [name for name, _ in attempts({"threads": 1, "seed": 0}, 5)]
    assert names[-1] == checks.GUESSED


class TestCloserLook:
    def test_twins_are_found_elsewhere_only(self) -> None:
        random = np.random.default_rng(0)
        descriptors = unit_vectors(random.integers(0, 255, (40, 128)))
        keypoints = np.zeros((80, 6))
        keypoints[:, :2] = random.uniform(0, 1000, (80, 2))
        keypoints[:, [2, 5]] = 8.0
        twice = np.vstack([descriptors, descriptors])
        assert repeated(keypoints, twice, 1000) == pytest.approx(1.0, abs=0.1)
        keypoints[40:, :2] = keypoints[:40, :2] + 5
        assert repeated(keypoints, twice, 1000) == 0

    def test_mirroring_twice_changes_nothing(self) -> None:
        descriptors = np.random.default_rng(0).uniform(size=(5, 128))
        assert (mirrored(descriptors) != descriptors).any()
        np.testing.assert_array_equal(mirrored(mirrored(descriptors)), descriptors)

    def test_no_features(self) -> None:
        none = np.zeros((0, 128), np.float32)
        assert repeated(np.zeros((0, 6)), none, 1000) == 0
        assert agreeing(none, none) == 0
