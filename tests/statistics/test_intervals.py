"""Intervals against closed forms, the table of the GUM, scipy's distributions, and counted coverage."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.results import Interval
from inertialcal.statistics.intervals import (
    band_factor,
    binomial_interval,
    chi_square_interval,
    contains,
    coverage_factor,
    covers,
    ends,
    student_of_mixture,
    t_interval,
    t_quantile,
    upper_bound,
)

TABLE_G2 = 0.0051  # rounding of JCGM 100:2008, Table G.2
CLOSED = 1e-12  # relative
DOF = st.floats(0.3, 1e4)
P = st.floats(0.01, 0.99)


@pytest.mark.parametrize(
    ("dof", "p", "printed"),
    [
        (1, 0.95, 12.71),
        (2, 0.95, 4.30),
        (3, 0.95, 3.18),
        (4, 0.95, 2.78),
        (5, 0.95, 2.57),
        (10, 0.90, 1.81),
        (10, 0.95, 2.23),
        (10, 0.99, 3.17),
        (20, 0.95, 2.09),
        (50, 0.95, 2.01),
        (math.inf, 0.95, 1.960),
        (math.inf, 0.99, 2.576),
    ],
)
def test_coverage_factors_of_the_gum(dof: float, p: float, printed: float) -> None:
    assert coverage_factor(dof, p) == pytest.approx(printed, abs=TABLE_G2)


@given(p=P)
def test_students_t_of_one_and_two_degrees_of_freedom(p: float) -> None:
    cauchy = math.tan(math.pi * (p - 0.5))
    two = (2.0 * p - 1.0) / math.sqrt(2.0 * p * (1.0 - p))
    assert t_quantile(1, p) == pytest.approx(cauchy, rel=1e-9, abs=1e-12)
    assert t_quantile(2, p) == pytest.approx(two, rel=1e-9, abs=1e-12)


@given(dof=DOF, p=P)
def test_quantiles_agree_with_scipys_distribution(dof: float, p: float) -> None:
    assert stats.t.cdf(t_quantile(dof, p), dof) == pytest.approx(p, rel=1e-8)


@given(value=st.floats(-1e3, 1e3), u=st.floats(1e-6, 1e3), dof=DOF, p=P, k=st.floats(0.01, 100.0))
def test_interval_follows_shift_and_scale(value: float, u: float, dof: float, p: float, k: float) -> None:
    one, other = t_interval(value, u, dof, p), t_interval(k * value + 7.0, k * u, dof, p)
    assert ends(other) == pytest.approx(k * np.array(ends(one)) + 7.0, rel=1e-9, abs=1e-6)
    assert one.p == p


def test_more_degrees_of_freedom_never_widen() -> None:
    factors = [coverage_factor(dof) for dof in (0.7, 1.0, 2.5, 9.0, 1e3, math.inf)]
    assert factors == sorted(factors, reverse=True)


def test_the_upper_bound_is_the_end_of_the_interval_of_twice_the_tail() -> None:
    interval = t_interval(2.0, 0.3, 6.0, 0.90)
    assert upper_bound(2.0, 0.3, 6.0, 0.95) == pytest.approx(interval.hi, rel=CLOSED)


def test_standard_deviation_with_two_degrees_of_freedom() -> None:
    """Chi-square of 2 is exponential: quantile -2 ln(1 - p)."""
    found = chi_square_interval(3.0, 2.0, 0.9)
    assert found.lo == pytest.approx(3.0 * math.sqrt(2.0 / (-2.0 * math.log(0.05))), rel=CLOSED)
    assert found.hi == pytest.approx(3.0 * math.sqrt(2.0 / (-2.0 * math.log(0.95))), rel=CLOSED)


@given(dof=st.floats(0.5, 1e4), p=P)
def test_standard_deviation_against_scipy(dof: float, p: float) -> None:
    found = chi_square_interval(1.0, dof, p)
    lo, hi = ends(found)
    assert stats.chi2.sf(dof / lo**2, dof) == pytest.approx(0.5 * (1.0 - p), rel=1e-7)
    assert stats.chi2.cdf(dof / hi**2, dof) == pytest.approx(0.5 * (1.0 - p), rel=1e-7)


def test_an_open_side_holds_everything() -> None:
    assert ends(Interval(None, 2.0)) == (-math.inf, 2.0)
    assert contains(Interval(None, 2.0), -1e300)
    assert not contains(Interval(3.0, None), 2.9)
    assert contains(Interval(1.0, 2.0), 2.0)


def test_standard_deviation_that_is_known() -> None:
    found = chi_square_interval(3.0, math.inf)
    assert (found.lo, found.hi) == (3.0, 3.0)


def test_no_hit_and_all_hits_in_closed_form() -> None:
    n, tail = 12, 0.025
    assert binomial_interval(0, n, 0.95) == pytest.approx((0.0, 1.0 - tail ** (1.0 / n)), rel=CLOSED)
    assert binomial_interval(n, n, 0.95) == pytest.approx((tail ** (1.0 / n), 1.0), rel=CLOSED)


@given(n=st.integers(1, 500), share=st.floats(0.0, 1.0), p=st.floats(0.5, 0.999))
def test_binomial_interval_against_scipy(n: int, share: float, p: float) -> None:
    hits = round(share * n)
    exact = stats.binomtest(hits, n).proportion_ci(p, method="exact")
    assert binomial_interval(hits, n, p) == pytest.approx((exact.low, exact.high), rel=1e-9, abs=1e-12)


def test_rule_for_coverage() -> None:
    assert covers(285, 300)
    assert covers(950, 1000)
    assert not covers(880, 1000)  # the normal factor in place of Student's t with few degrees of freedom
    assert covers(998, 1000)  # uncertainties that are too large pass: how wide they are is told beside
    edges = [hits for hits in range(301) if covers(hits, 300)]
    assert edges == list(range(edges[0], edges[-1] + 1))


@pytest.mark.parametrize("true_coverage", [0.95, 0.97, 1.0])
def test_rule_for_coverage_seldom_fails_a_good_interval(true_coverage: float) -> None:
    hits = np.arange(1001)
    passes = np.array([covers(int(h), 1000) for h in hits])
    assert stats.binom.pmf(hits, 1000, true_coverage)[~passes].sum() <= 0.001


def test_band_of_one_value_is_its_interval() -> None:
    assert band_factor(1, 7.0, 0.95) == pytest.approx(coverage_factor(7.0, 0.95), rel=CLOSED)
    assert band_factor(1, 7.0, 0.95, "scheffe") == pytest.approx(coverage_factor(7.0, 0.95), rel=1e-9)


def test_bands_in_closed_form() -> None:
    known = stats.norm.ppf(0.5 * (1.0 + 0.95 ** (1.0 / 5.0)))
    assert band_factor(5, math.inf, 0.95) == pytest.approx(known, rel=CLOSED)
    assert band_factor(2, math.inf, 0.95, "scheffe") == pytest.approx(math.sqrt(-2.0 * math.log(0.05)), rel=CLOSED)
    assert band_factor(3, 8.0, 0.95, "scheffe") == pytest.approx(math.sqrt(3.0 * stats.f.ppf(0.95, 3, 8)), rel=1e-9)


def test_band_holds_for_all_points_of_a_line_at_once() -> None:
    """Scheffe for a line with 6 degrees of freedom: every point of it in 95 % of all fits."""
    rng = np.random.default_rng(3)
    n, dof, factor = 2000, 6, band_factor(2, 6.0, 0.95, "scheffe")
    error = rng.standard_normal((n, 2))
    std = np.sqrt(rng.chisquare(dof, n) / dof)
    hits = np.count_nonzero(np.hypot(*error.T) <= factor * std)  # largest over all directions
    low, high = binomial_interval(int(hits), n)
    assert low <= 0.95 <= high


def test_interval_keeps_its_promise_for_five_readings() -> None:
    rng = np.random.default_rng(1)
    x = rng.normal(3.0, 2.0, (1000, 5))
    u = x.std(axis=1, ddof=1) / math.sqrt(5.0)
    found = [t_interval(m, s, 4.0) for m, s in zip(x.mean(axis=1), u, strict=True)]
    assert covers(sum(contains(i, 3.0) for i in found), 1000)


@pytest.mark.parametrize("dof", [0.0, -1.0, math.nan])
def test_no_degrees_of_freedom_is_refused(dof: float) -> None:
    with pytest.raises(DataError, match="degrees of freedom"):
        coverage_factor(dof)
    with pytest.raises(DataError, match="degrees of freedom"):
        band_factor(3, dof)
    with pytest.raises(DataError, match="no scatter was estimated"):
        chi_square_interval(1.0, dof)


@pytest.mark.parametrize("p", [0.0, 1.0, -0.1, math.nan])
def test_a_probability_outside_is_refused(p: float) -> None:
    with pytest.raises(PlanError, match="probability"):
        t_interval(0.0, 1.0, 5.0, p)


def test_other_refusals_by_their_words() -> None:
    with pytest.raises(DataError, match="value nan with standard uncertainty 1"):
        t_interval(math.nan, 1.0, 5.0)
    with pytest.raises(DataError, match="value 1 with standard uncertainty -1"):
        upper_bound(1.0, -1.0, 5.0)
    with pytest.raises(DataError, match="standard deviation -2"):
        chi_square_interval(-2.0, 5.0)
    with pytest.raises(DataError, match="5 hits in 4 trials"):
        binomial_interval(5, 4)
    with pytest.raises(DataError, match="0 hits in 0 trials"):
        covers(0, 0)
    with pytest.raises(PlanError, match="simultaneous interval of 0 values"):
        band_factor(0, 5.0)


def test_a_mixture_has_the_interval_of_one_student() -> None:
    u, dof = student_of_mixture(np.array([2.0]), np.array([1.0]))
    assert (u, dof > 100.0) == (2.0, True)  # normal
    u, dof = student_of_mixture(np.full(2, 1e-9), np.array([0.4, 0.6]), 7.0)
    assert u == pytest.approx(1e-9)
    assert dof == pytest.approx(7.0, rel=0.01)
    u, dof = student_of_mixture(np.array([1.0, 5.0]), np.array([0.7, 0.3]))
    half = stats.t.ppf(0.975, dof) * u
    outside = 0.7 * 2.0 * stats.norm.sf(half) + 0.3 * 2.0 * stats.norm.sf(half / 5.0)
    assert outside == pytest.approx(0.05, rel=0.02)
    u, dof = student_of_mixture(np.array([1.0, 1000.0]), np.array([0.6, 0.4]))
    assert (dof, u > 1.0) == (1.0, True)
