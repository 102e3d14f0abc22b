from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.local_fit import local_fits

AT = np.linspace(-1, 1, 9)
PARABOLA = np.stack([np.ones_like(AT), AT, AT**2], axis=1)


def linear_loss(residual: np.ndarray) -> np.ndarray:
    return 1 / np.maximum(residual, 1e-6)


def test_a_wrong_neighbour_does_not_bend_the_fit():
    truth = np.array([[[2.0], [-1.0], [0.5]], [[0.0], [3.0], [1.0]]])
    values = PARABOLA @ truth
    values[0, 3] += 5
    found, residual = local_fits(PARABOLA, values, np.ones((2, 9)), linear_loss, rounds=30, ridge=1e-12)
    np.testing.assert_allclose(found, truth, atol=1e-4)
    assert residual[0].argmax() == 3
    assert residual[0, 3] == pytest.approx(5, abs=1e-3)


def test_one_basis_for_all_gives_what_a_basis_for_each_gives():
    random = np.random.default_rng(4)
    values, weight = random.random((20, 9, 2)), random.random((20, 9))
    each = np.broadcast_to(PARABOLA, (20, *PARABOLA.shape))
    one, of_one = local_fits(PARABOLA, values, weight, linear_loss, rounds=4, ridge=1e-9)
    many, of_many = local_fits(each, values, weight, linear_loss, rounds=4, ridge=1e-9)
    np.testing.assert_allclose(one, many, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(of_one, of_many, rtol=1e-6, atol=1e-9)


def test_the_first_weights_count_and_the_ridge_holds_what_is_not_determined():
    values = np.array([[[1.0], [1.0], [7.0]]])
    line = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.0]])
    found, _ = local_fits(line, values, np.array([[1.0, 1.0, 0.0]]), linear_loss, rounds=1, ridge=1e-9)
    np.testing.assert_allclose(found[0, :, 0], [1, 0], atol=1e-6)
