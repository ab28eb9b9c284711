"""Standard deviations compared: against scipy's F distribution, and by simulation of size and coverage."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from inertialcal.core.errors import DataError
from inertialcal.statistics.intervals import binomial_interval
from inertialcal.statistics.scatters import difference_interval, equality_p_value

DOFS = [(2, 2), (3, 30), (30, 3), (69, 23)]


@pytest.mark.parametrize(("n", "m"), DOFS)
def test_p_value_is_that_of_the_f_test(n: int, m: int) -> None:
    ratio = stats.f.ppf(0.99, m, n)
    assert equality_p_value(2.0, n, 2.0 * math.sqrt(ratio), m) == pytest.approx(0.02)
    assert equality_p_value(2.0 * math.sqrt(ratio), m, 2.0, n) == pytest.approx(0.02)


def test_equal_scatters_of_equal_freedom_have_p_1() -> None:
    assert equality_p_value(0.3, 7, 0.3, 7) == pytest.approx(1.0)


@pytest.mark.parametrize(("n", "m"), DOFS)
def test_size_of_the_test_and_coverage_of_the_interval(n: int, m: int) -> None:
    """Size exactly 5 %; coverage at least about 95 % (the interval is wide where both have few degrees of freedom)."""
    draws = 1000
    rejected = hits = 0
    for seed in range(1, draws + 1):
        rng = np.random.default_rng(seed)
        one, other = math.sqrt(rng.chisquare(n) / n), math.sqrt(rng.chisquare(m) / m)
        rejected += equality_p_value(one, n, other, m) <= 0.05
        interval = difference_interval(one, n, 1.5 * other, m)
        hits += (interval.lo or 0.0) <= 0.5 <= (interval.hi or 0.0)
    low, high = binomial_interval(rejected, draws)
    assert low <= 0.05 <= high
    assert binomial_interval(hits, draws)[1] >= 0.94


def test_interval_changes_sign_with_the_order_and_scales() -> None:
    there, back = difference_interval(1.0, 4, 1.7, 9), difference_interval(1.7, 9, 1.0, 4)
    assert there.lo == pytest.approx(-(back.hi or 0.0))
    assert there.hi == pytest.approx(-(back.lo or 0.0))
    assert difference_interval(3.0, 4, 5.1, 9).hi == pytest.approx(3.0 * (there.hi or 0.0))


def test_known_scatters_leave_no_interval() -> None:
    assert difference_interval(1.0, math.inf, 1.7, math.inf).hi == pytest.approx(0.7)


@pytest.mark.parametrize(("std", "dof"), [(0.0, 3.0), (1.0, 0.0), (1.0, math.inf), (math.nan, 3.0)])
def test_scatter_without_freedom_is_refused(std: float, dof: float) -> None:
    with pytest.raises(DataError, match="degrees of freedom"):
        equality_p_value(std, dof, 1.0, 3.0)
