"""Iteratively reweighted least squares: known minima, and an objective that only falls."""

from __future__ import annotations

import numpy as np
import pytest
from origami.core.errors import Cancelled, StepFailed
from origami.core.numeric.robust import Loss, factorize, minimize, solve_symmetric
from origami.core.watch import Watch
from scipy import sparse

_NOTHING = sparse.csr_array((1, 1))


def _one_unknown(values: list[float], loss: Loss) -> float:
    rows = sparse.csr_array(np.ones((len(values), 1)))
    return float(minimize(rows, np.array(values), loss, _NOTHING, tolerance=1e-10, max_iterations=500).solution[0])


def test_squared_gives_the_mean_and_l1_the_median():
    values = [0.0, 1.0, 2.0, 3.0, 100.0]
    assert _one_unknown(values, Loss("squared")) == pytest.approx(21.2)
    assert _one_unknown(values, Loss("l1", 1e-6)) == pytest.approx(2.0, abs=1e-4)


def test_cauchy_forgets_the_outlier():
    values = [0.0, 0.1, -0.1, 0.05, -0.05, 1000.0]
    rows = sparse.csr_array(np.ones((6, 1)))
    fit = minimize(rows, np.array(values), Loss("cauchy", 0.1), _NOTHING, start=np.zeros(1), max_iterations=100)
    assert abs(fit.solution[0]) < 1e-4


@pytest.mark.parametrize("kind", ["l1", "cauchy"])
def test_the_objective_never_rises(kind):
    random = np.random.default_rng(0)
    rows = sparse.csr_array(random.normal(size=(300, 20)))
    target = rows @ random.normal(size=20) + 0.01 * random.normal(size=300)
    target[::7] += random.normal(scale=30, size=len(target[::7]))
    smoothness = sparse.diags_array(np.full(20, 0.1), format="csr")
    start = random.normal(size=20)
    fit = minimize(rows, target, Loss(kind, 0.01), smoothness, start=start, tolerance=0, max_iterations=40)
    steps = np.diff(fit.objective)
    assert len(steps) == 40
    assert (steps <= 1e-9 * np.abs(fit.objective[0])).all()
    assert fit.objective[-1] < 0.9 * fit.objective[0]


@pytest.mark.parametrize("kind", ["squared", "l1", "cauchy"])
def test_weight_is_the_slope_of_the_loss_over_the_residual(kind):
    loss = Loss(kind, 0.3)
    residual = np.array([-2.0, -0.29, 0.1, 0.31, 5.0])
    step = 1e-6
    slope = (loss.value(residual + step) - loss.value(residual - step)) / (2 * step)
    np.testing.assert_allclose(loss.weight(residual), slope / residual, rtol=1e-5)


def test_linear_term_shifts_the_minimum():
    quadratic = sparse.csr_array(np.array([[2.0]]))
    fit = minimize(sparse.csr_array((0, 1)), np.empty(0), Loss("squared"), quadratic, linear=np.array([6.0]))
    assert fit.solution[0] == pytest.approx(3.0)


def test_symmetric_systems_are_solved():
    matrix = sparse.csc_array(np.array([[4.0, 1.0], [1.0, 3.0]]))
    np.testing.assert_allclose(solve_symmetric(matrix, np.array([1.0, 2.0])), [1 / 11, 7 / 11], rtol=1e-10)


def test_undetermined_unknowns_are_reported():
    with pytest.raises(StepFailed, match="no single solution"):
        factorize(sparse.csc_array((3, 3)))


def test_cancel():
    rows = sparse.csr_array(np.ones((2, 1)))
    with pytest.raises(Cancelled):
        minimize(rows, np.ones(2), Loss("l1"), _NOTHING, watch=Watch(cancelled=lambda: True))
