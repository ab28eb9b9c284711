"""Quantiles against those of scipy.stats."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from inertialcal.statistics.quantiles import chi_square_quantile, chi_square_upper, f_upper, t_upper

TAILS = (0.3, 1e-3, 1e-9)


@pytest.mark.parametrize("p", TAILS)
def test_upper_quantiles_are_those_of_scipy(p: float) -> None:
    dof = np.array([3.5, 7.0, 300.0])
    assert t_upper(p, dof) == pytest.approx(stats.t.isf(p, dof), rel=1e-12)
    assert chi_square_upper(p, dof) == pytest.approx(stats.chi2.isf(p, dof), rel=1e-12)
    assert f_upper(p, dof, 40.0) == pytest.approx(stats.f.isf(p, dof, 40.0), rel=1e-8)  # theirs: 2e-9 off at 1e-9


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
