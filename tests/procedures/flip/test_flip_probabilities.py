"""Probabilities behind the remarks of a flip, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import NO_REASON, Key
from inertialcal.procedures.flip.readings import Quiet
from inertialcal.procedures.flip.separation.control import _p
from inertialcal.procedures.flip.separation.pooling import Flip, _against_noise
from inertialcal.procedures.flip.separation.uncertainty import _pairs

BIAS = Key("bias", "y")


def flip(value: float, u: float = 1.0, dof: float = np.inf) -> Flip:
    component = Component("noise", "A", np.array([[u**2]]), np.array([dof]))
    estimate = Estimate((BIAS,), np.array([value]), ("m/s^2",), (component,))
    return Flip("1", (BIAS,), np.array([value]), estimate, NO_REASON, ())


@pytest.mark.parametrize("t", [-3.0, -1.0, 0.0, 1.0, 7.0])
def test_a_value_against_its_uncertainty_with_one_degree_of_freedom(t: float) -> None:
    """Student's t with one degree of freedom is Cauchy's: both tails are 1 - (2 / pi) arctan |t|."""
    assert _p(flip(t, dof=1.0), BIAS) == pytest.approx(1.0 - 2.0 / math.pi * math.atan(abs(t)), abs=1e-12)


def test_flips_that_differ_as_their_noise_has_an_exponential_probability() -> None:
    """Three flips leave a chi-square of two degrees of freedom, whose tail is exp(-x / 2)."""
    found = _against_noise(BIAS, [flip(0.0), flip(1.0), flip(2.0)])
    assert found is not None
    square, p = found
    assert square == pytest.approx(2.0)
    assert p == pytest.approx(math.exp(-1.0), rel=1e-6)


def test_noise_that_is_badly_known_makes_a_difference_less_sure() -> None:
    """With n degrees of freedom behind it, F of two and n has the tail (1 + 2 F / n) ** (-n / 2)."""
    found = _against_noise(BIAS, [flip(value, dof=4.0) for value in (0.0, 3.0, 6.0)])
    assert found is not None
    square, p = found
    assert square == pytest.approx(18.0)
    assert p == pytest.approx((1.0 + 18.0 / 12.0) ** -6.0, rel=1e-9)


def test_pairs_elsewhere_have_the_mean_square_about_zero() -> None:
    """What should be zero has a known mean: n stretches tell its square with n degrees of freedom, not n - 1."""
    n = 41
    reading = np.random.default_rng(1).normal(size=n)
    weights = np.zeros((2, n))
    weights[0, 0] = weights[1, 2] = 1.0
    record = Quiet(
        np.arange(n, dtype=np.float64) + 0.5,
        1.0,
        np.zeros(n),
        {"y": reading},
        weights,
        np.array([[0.0, 1.0], [2.0, 3.0]]),
    )
    covariance, dof, _ = _pairs(record, "y", np.array([[0.5, -0.5]]))
    halves = [0.5 * (reading[start] - reading[start + 2]) for start in range(3, n - 2, 3)]  # beside the dwells' own
    assert dof[0] == len(halves)
    assert covariance[0, 0] == pytest.approx(np.mean(np.square(halves)))
