"""Validation of a linear propagation by Monte Carlo against an example of Supplement 1, and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.core.results import Interval
from inertialcal.statistics.propagate import MonteCarlo, compare, tolerance


def estimate(u: float, name: str = "Y") -> Estimate:
    return Estimate((name,), np.zeros(1), ("",), (Component("source", "B", np.array([[u**2]])),))


def drawn(samples: Array) -> MonteCarlo:
    lo, hi = np.quantile(samples, [0.025, 0.975])
    return MonteCarlo(estimate(float(np.std(samples))), (Interval(float(lo), float(hi), 0.95),), samples[:, None])


def test_four_normal_quantities_are_validated_and_one_large_rectangular_one_is_not() -> None:
    """JCGM 101, 9.2.2 and 9.2.4: u = 2 of four normal quantities; of u = 10, rectangular: ± 17.0, the GUM ± 19.9."""
    rng = np.random.default_rng(1)
    normal = rng.normal(size=(200_000, 4)).sum(axis=1)
    (alike,) = compare(estimate(2.0), drawn(normal))
    assert alike.validated
    assert alike.resolved
    half = math.sqrt(3.0) * np.array([1.0, 1.0, 1.0, 10.0])
    (apart,) = compare(estimate(math.sqrt(103.0)), drawn(rng.uniform(-half, half, (200_000, 4)).sum(axis=1)))
    assert not apart.validated
    assert min(apart.d_low, apart.d_high) > 2.5


def test_too_few_draws_show() -> None:
    few = np.random.default_rng(1).normal(0.0, 2.0, 2000)
    assert not compare(estimate(2.0), drawn(few))[0].resolved


@pytest.mark.parametrize(
    ("u", "digits", "delta"),
    [(0.00035, 2, 0.000005), (0.00035, 1, 0.00005), (2.0, 2, 0.05), (10.1, 2, 0.5), (0.0996, 2, 0.005)],
)
def test_numerical_tolerance(u: float, digits: int, delta: float) -> None:
    """JCGM 101, 7.9.2: half a unit of the last digit kept (0.0996 is kept as 0.10)."""
    assert tolerance(u, digits) == pytest.approx(delta, rel=1e-12)


def test_refusals() -> None:
    with pytest.raises(DataError, match="compared with"):
        compare(estimate(2.0, "Z"), drawn(np.arange(100.0)))
    with pytest.raises(DataError, match="numerical tolerance of a standard uncertainty 0"):
        tolerance(0.0)
