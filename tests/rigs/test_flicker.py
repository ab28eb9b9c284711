"""1/f noise of a rig: its covariance, its spectrum, differences of means at every lag."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from inertialcal.core.estimate import Array
from inertialcal.rigs.parts.noise import flicker, increment_covariance
from inertialcal.statistics.slow_noise import flicker_covariance


def test_the_variance_of_an_increment_is_four_ln_two() -> None:
    assert increment_covariance(np.array([0.0]))[0] == pytest.approx(4.0 * np.log(2.0), rel=1e-14)


def test_increments_have_the_covariance_that_the_generalised_one_gives() -> None:
    K = flicker_covariance(np.arange(60.0), 1.0)[0]
    expected = [2.0 * K[k] - K[k + 1] - K[abs(k - 1)] for k in range(59)]
    assert increment_covariance(np.arange(59.0)) == pytest.approx(np.array(expected), rel=1e-6, abs=1e-11)


def test_the_series_joins_what_it_continues_and_dies_as_one_over_lag_squared() -> None:
    near, far = increment_covariance(np.array([29.999999, 30.0, 30.000001]))[[0, 2]]
    assert near == pytest.approx(far, rel=1e-6)
    assert increment_covariance(np.array([1e5]))[0] == pytest.approx(-1e-10, rel=1e-8)


def contrast(n: int) -> Array:
    """Weights of the difference of the first and last eighth."""
    weights = np.zeros(n)
    weights[: n // 8], weights[-(n // 8) :] = 8.0 / n, -8.0 / n
    return weights


@pytest.mark.parametrize("n", [64, 1000])
def test_contrasts_have_the_variance_of_the_theory(n: int) -> None:
    h, draws = 2.5, 4000
    x = flicker(h, n, draws, np.random.default_rng(3))
    K = flicker_covariance(np.arange(float(n)), 1.0)
    for weights in (contrast(n), np.eye(n)[0] - np.eye(n)[1], np.eye(n)[0] - np.eye(n)[-1]):
        expected = h * float(weights @ K @ weights)
        found = float(np.var(weights @ x))
        assert found == pytest.approx(expected, rel=5.0 * np.sqrt(2.0 / draws))
    assert np.abs(x.mean(axis=0)).max() < 1e-9


def test_the_spectrum_is_h_over_f() -> None:
    h, rate = 0.7, 25.0
    x = flicker(h, 90_000, 6, np.random.default_rng(4))
    f, density = signal.welch(x, rate, nperseg=4096, axis=0)
    band = (f > 0.05) & (f < 2.0)
    assert np.mean(density[band].mean(axis=1) * f[band]) == pytest.approx(h, rel=0.03)
    low = (f > 0.05) & (f < 0.2)
    assert np.mean(density[low].mean(axis=1) * f[low]) == pytest.approx(h, rel=0.1)


def test_none_is_none_and_the_same_seed_gives_the_same() -> None:
    assert not flicker(0.0, 50, 3, np.random.default_rng(1)).any()
    one, same = (flicker(1.0, 50, 3, np.random.default_rng(1)) for _ in range(2))
    assert np.array_equal(one, same)
    assert one.shape == (50, 3)
