"""Samples that are averages over less than their interval: made ones, Barnes's bias function, and the terms of a fit.

With D(t) the variance that t of integrated noise has (|t| for white noise, t^2 log|t| for flicker, |t|^3 for a random
walk of the rate; up to even powers, which differences take away), the autocovariance of the averages follows by
differences over the averaging time, and the Allan variance from that of the averages of m samples. A ratio of Allan
variances is Barnes's bias function (Barnes and Allan, NIST TN 1318, 1990).
"""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.sensors.noise.expected import expected_variance
from inertialcal.sensors.noise.terms import BiasInstability, RandomWalk, RateRandomWalk, Term
from inertialcal.signals.allan import allan

TERMS: dict[int, Term] = {0: RandomWalk(1.0), -1: BiasInstability(1.0), -2: RateRandomWalk(1.0)}


def ratio(power: int, m: int, interval: float, averaging: float) -> float:
    """Return the Allan variance of averages with dead time over that of contiguous ones at the same tau."""
    return variance(power, m, averaging / interval) / variance(power, m, 1.0)


def variance(power: int, m: int, filled: float) -> float:
    """Return the Allan variance of averages over ``filled`` of an interval of 1, but for a factor."""
    lags = np.arange(2.0 * m)
    near, far = structure(lags, power), structure(lags + filled, power) + structure(lags - filled, power)
    covariance = (2.0 * near - far) / (filled * filled)
    both = np.concatenate([covariance[:0:-1], covariance])  # of lags -(2m - 1) to 2m - 1
    window = np.concatenate([-np.ones(m), np.ones(m)]) / m
    return 0.5 * float(np.correlate(window, window, mode="full") @ both)


def structure(t: Array, power: int) -> Array:
    t = np.abs(t)
    if power == 0:
        return -t
    return t**3 if power == -2 else t**2 * np.log(np.where(t > 0.0, t, 1.0))


def test_1_s_every_2_s_inflates_white_noise_by_sqrt_2() -> None:
    fine = np.random.default_rng(5).normal(size=(20_000, 30))  # 1 s averages, every other one saved
    full = allan(fine, 1.0, quantity="rate", factors=[16])
    thin = allan(fine[::2], 2.0, quantity="rate", averaging=1.0, factors=[8])
    assert np.sqrt(thin.variance.mean() / full.variance.mean()) == pytest.approx(np.sqrt(2.0), rel=0.02)
    (remark,) = thin.remarks
    assert remark.code == "dead_time"
    assert "white noise shows 1.41 times" in remark.what


def test_nothing_is_said_where_samples_fill_their_interval() -> None:
    x = np.random.default_rng(6).normal(size=4000)
    assert allan(x, 1.0, quantity="rate").remarks == ()
    assert allan(x, 1.0, quantity="rate", averaging=1.0).remarks == ()


def test_bias_functions_of_barnes() -> None:
    assert ratio(0, 5, 2.0, 1.0) == pytest.approx(2.0, rel=1e-9)
    # B_2 for mu = 1: with T = r tau_a, the Allan variance of one sample is (3 r - 1) / 2 that of adjacent averages;
    # contiguous ones over T are r times as long.
    assert ratio(-2, 1, 3.0, 1.0) * 3.0 == pytest.approx((3.0 * 3.0 - 1.0) / 2.0, rel=1e-9)


@pytest.mark.parametrize("power", TERMS)
@pytest.mark.parametrize("averaging", [0.9, 0.5, 0.1])
def test_terms_expect_what_barnes_does(power: int, averaging: float) -> None:
    m = [1, 2, 5, 40]
    with_dead_time = expected_variance(TERMS[power], np.array(m), 2.0, 2.0 * averaging)
    contiguous = expected_variance(TERMS[power], np.array(m), 2.0)
    expected = [ratio(power, each, 1.0, averaging) for each in m]
    assert with_dead_time / contiguous == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("averaging", [1.1, 0.0, -1.0, np.nan])
def test_averaging_times_that_cannot_be(averaging: float) -> None:
    with pytest.raises(DataError, match=r"averaging time of .* s at a sample interval of 1 s"):
        allan(np.zeros(100), 1.0, quantity="rate", averaging=averaging)
