"""Quantiles against probabilities in 30 digits, and against those of scipy.stats."""

from __future__ import annotations

from collections.abc import Callable

import mpmath as mp  # type: ignore[import-untyped]
import numpy as np
import pytest
from scipy import stats

from inertialcal.statistics.quantiles import chi_square_quantile, chi_square_upper, f_upper, t_upper

TAILS = (0.3, 1e-3, 1e-9)
ROUNDING = 1e-12  # relative; the t of scipy 1.13 is 6e-12 off, the F of any scipy 2e-9 at p = 1e-9


def f_tail(x: mp.mpf, a: float, b: float) -> mp.mpf:
    """Return the probability beyond x: Abramowitz and Stegun, 26.6.2."""
    return mp.betainc(b / 2, a / 2, 0, b / (b + a * x), regularized=True)


def encloses(tail: Callable[[mp.mpf], mp.mpf], p: float, x: object) -> bool:
    """Return whether the value with the probability p beyond it is x, to rounding."""
    with mp.workdps(30):
        at = mp.mpf(float(np.asarray(x)))
        return bool(tail(at * (1 - ROUNDING)) > p > tail(at * (1 + ROUNDING)))


@pytest.mark.parametrize("dof", [3.5, 7.0, 300.0])
@pytest.mark.parametrize("p", TAILS)
def test_upper_quantiles_are_exceeded_with_their_probability(p: float, dof: float) -> None:
    assert encloses(lambda t: f_tail(t**2, 1.0, dof) / 2, p, t_upper(p, dof))
    assert encloses(lambda x: mp.gammainc(dof / 2, x / 2, regularized=True), p, chi_square_upper(p, dof))
    assert encloses(lambda x: f_tail(x, dof, 40.0), p, f_upper(p, dof, 40.0))


def test_lower_quantiles_are_those_of_scipy() -> None:
    dof = np.array([0.5, 7.0, 500.0])
    for p in (0.1, 0.2, 0.5):
        assert chi_square_quantile(p, dof) == pytest.approx(stats.chi2.ppf(p, dof), rel=1e-8)


def test_infinite_degrees_of_freedom_are_the_limit() -> None:
    assert float(t_upper(1e-6, np.inf)) == pytest.approx(stats.norm.isf(1e-6), rel=1e-12)
    assert float(f_upper(1e-6, 9.0, np.inf)) == pytest.approx(stats.chi2.isf(1e-6, 9.0) / 9.0, rel=1e-12)
    assert float(f_upper(1e-12, 99.0, 30_000.0)) == pytest.approx(2.35196755, rel=1e-6)


def test_what_f_exceeds_with_a_probability_by_its_own_survival() -> None:
    for p in TAILS:
        assert stats.f.sf(float(f_upper(p, 9.0, 40.0)), 9.0, 40.0) == pytest.approx(p, rel=1e-9)
