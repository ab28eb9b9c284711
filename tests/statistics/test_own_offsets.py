"""Slopes within groups and the mean of their intercepts: many sets at once, and the scatter between clusters."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize

from inertialcal.statistics.own_offsets import fit_own_offsets


def test_many_sets_of_readings_are_the_same_as_each_alone() -> None:
    rng = np.random.default_rng(1)
    groups, x = np.repeat(np.arange(12), 6), np.tile(np.linspace(-1.0, 1.0, 6), 12)
    y = 2.0 * x + rng.standard_normal((5, 12))[:, groups] * [[0.0], [1e-6], [0.1], [1.0], [10.0]]
    y = y + 0.1 * rng.standard_normal(y.shape)
    together = fit_own_offsets(x[:, None], y, groups, groups // 3)
    assert together is not None
    for i, one in enumerate(y):
        own = fit_own_offsets(x[:, None], one, groups, groups // 3)
        assert own is not None
        for name in ("coefficients", "covariance", "solve", "local", "mean_square"):
            assert np.array_equal(getattr(together, name)[i], getattr(own, name)), name


@pytest.mark.parametrize("seed", range(1, 6))
def test_the_mean_of_intercepts_is_that_of_paule_and_mandel(seed: int) -> None:
    # Centred inputs: intercepts are means of groups; their variances s^2 / n, the root by another solver.
    rng = np.random.default_rng(seed)
    sizes = np.array([4, 6, 10, 20])
    groups = np.repeat(np.arange(4), sizes)
    x = np.concatenate([np.linspace(-1.0, 1.0, n) for n in sizes])
    y = x + rng.standard_normal(4)[groups] + 0.5 * rng.standard_normal(len(x))
    found = fit_own_offsets(x[:, None], y, groups, groups)
    assert found is not None
    means = np.array([y[groups == k].mean() for k in range(4)])
    own = float(found.mean_square) / sizes

    def excess(t: float) -> float:
        weight = 1.0 / (own + t)
        return float(np.sum(weight * (means - weight @ means / weight.sum()) ** 2)) - 3.0

    t = optimize.brentq(excess, 0.0, 100.0, xtol=1e-15) if excess(0.0) > 0.0 else 0.0
    weight = 1.0 / (own + t)
    assert found.coefficients[0] == pytest.approx(weight @ means / weight.sum(), rel=1e-9)
    assert found.covariance[0, 0] == pytest.approx(1.0 / weight.sum(), rel=1e-8)
