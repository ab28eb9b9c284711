"""Verdicts: the rule case by case, its risks by closed form and by counting."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.results import Interval
from inertialcal.statistics.decision import (
    Status,
    Verdict,
    decide,
    decide_by,
    holm,
    no_change,
    overall,
)
from inertialcal.statistics.guard_band import pass_probability
from inertialcal.statistics.intervals import binomial_interval, ends, t_quantile

K2, K1 = 1.959964, 1.644854  # normal 97.5 % and 95 % points
EPS = 1e-5
STEPS = 5e-4  # pass_probability takes the scatter in 2,000 steps


@pytest.mark.parametrize(
    ("value", "status"),
    [
        (1.0 - K2 - EPS, "PASS"),
        (1.0 - K2 + EPS, "INCONCLUSIVE"),
        (1.0, "INCONCLUSIVE"),
        (1.0 + K2 - EPS, "INCONCLUSIVE"),
        (1.0 + K2 + EPS, "FAIL"),
        (-9.0 + K2 + EPS, "PASS"),
        (-9.0 + K2 - EPS, "INCONCLUSIVE"),
        (-9.0 - K2 - EPS, "FAIL"),
    ],
)
def test_two_limits(value: float, status: Status) -> None:
    found = decide(value, 1.0, math.inf, lower=-9.0, upper=1.0)
    assert found.status == status
    assert found.interval is not None
    assert found.interval.p == 0.95
    assert ends(found.interval) == pytest.approx((value - K2, value + K2), abs=EPS)
    assert (found.limit_lower, found.limit_upper) == (-9.0, 1.0)


@pytest.mark.parametrize(
    ("lo", "hi", "status"),
    [
        (0.0, 1.0, "PASS"),
        (-2.0, 0.0, "INCONCLUSIVE"),
        (1.0, 2.0, "INCONCLUSIVE"),
        (-2.0, -1e-9, "FAIL"),
        (1.0 + 1e-9, 2.0, "FAIL"),
        (-1e-9, 1.0, "INCONCLUSIVE"),
        (0.0, 1.0 + 1e-9, "INCONCLUSIVE"),
    ],
)
def test_a_limit_itself_conforms(lo: float, hi: float, status: Status) -> None:
    """JCGM 106, 3.3.6: limits belong to what is permissible, so an interval that touches one is not outside."""
    assert decide_by(lambda _p: Interval(lo, hi), 0.5, 0.1, lower=0.0, upper=1.0).status == status


@pytest.mark.parametrize(
    ("value", "status"),
    [
        (1.0 - K1 - EPS, "PASS"),
        (1.0 - K1 + EPS, "INCONCLUSIVE"),
        (1.0 + K1 - EPS, "INCONCLUSIVE"),
        (1.0 + K1 + EPS, "FAIL"),
    ],
)
def test_one_limit_uses_one_sided_bounds(value: float, status: Status) -> None:
    upper = decide(value, 1.0, None, upper=1.0)
    lower = decide(-value, 1.0, None, lower=-1.0)
    assert (upper.status, lower.status) == (status, status)
    assert upper.interval is not None
    assert upper.interval.p == 0.90
    assert "one-sided 95 %" in upper.rule


@given(
    value=st.floats(-5.0, 5.0),
    u=st.floats(0.01, 3.0),
    dof=st.floats(1.0, 100.0),
    shift=st.floats(-10.0, 10.0),
    scale=st.sampled_from([1e-6, 0.5, 1e3]),
)
def test_verdict_follows_unit_and_sign(value: float, u: float, dof: float, shift: float, scale: float) -> None:
    one = decide(value, u, dof, -1.0, 2.0).status
    assert decide(-value, u, dof, -2.0, 1.0).status == one
    assert decide(scale * value, scale * u, dof, -scale, 2.0 * scale).status == one


def test_the_rule_is_told() -> None:
    found = decide(0.9, 0.1, 10.0, upper=1.0)
    assert "JCGM 106" in found.rule
    assert "PASS if the one-sided 95 % bound lies inside" in found.rule
    assert "reaches over a limit" in found.reason
    assert "PASS if the 95 % interval lies inside the limits" in decide(0.0, 0.1, 9.0, -1.0, 1.0).rule


@pytest.mark.parametrize(
    ("value", "u", "dof", "reason"),
    [
        (None, 1.0, 5.0, "the value is not estimated"),
        (math.nan, 1.0, 5.0, "the value is not estimated"),
        (0.0, None, 5.0, "the standard uncertainty is not estimated"),
        (0.0, math.inf, 5.0, "the standard uncertainty is not estimated"),
        (0.0, 0.0, 5.0, "the standard uncertainty is 0"),
        (0.0, 1e-9, 0.0, "no degrees of freedom"),
        (0.0, 1e-9, math.nan, "no degrees of freedom"),
    ],
)
def test_what_was_not_estimated_is_inconclusive(
    value: float | None, u: float | None, dof: float | None, reason: str
) -> None:
    found = decide(value, u, dof, -1.0, 1.0)
    assert found.status == "INCONCLUSIVE"
    assert found.reason.startswith(reason)
    assert found.interval is None


def test_no_change_needs_a_good_measurement() -> None:
    assert no_change(0.1, 0.1, math.inf, 0.5).status == "PASS"
    assert no_change(0.1, 0.5, math.inf, 0.5).status == "INCONCLUSIVE"  # not significant, and yet not shown
    assert no_change(0.9, 0.1, math.inf, 0.5).status == "FAIL"
    assert no_change(-0.9, 0.1, math.inf, 0.5).status == "FAIL"
    none = no_change(0.0, 0.1, math.inf, None)
    assert none.status == "INCONCLUSIVE"
    assert "no allowed change is stated" in none.reason


def test_overall_precedence() -> None:
    def of(*statuses: Status) -> Status:
        return overall([Verdict(status) for status in statuses])

    assert of("PASS", "PASS") == "PASS"
    assert of("PASS", "INCONCLUSIVE") == "INCONCLUSIVE"
    assert of("PASS", "OPEN") == "INCONCLUSIVE"
    assert of("OPEN", "INCONCLUSIVE", "FAIL", "PASS") == "FAIL"
    assert of() == "INCONCLUSIVE"


def test_holm_step_by_step() -> None:
    """0.01 < 0.05/4, 0.013 < 0.05/3, 0.03 > 0.05/2: it stops there, also for the 0.04 below 0.05."""
    assert holm([0.03, 0.01, 0.04, 0.013]).tolist() == [False, True, False, True]
    assert holm([0.04]).tolist() == [True]
    assert holm([]).tolist() == []


def test_holm_holds_its_level_for_correlated_true_hypotheses() -> None:
    rng = np.random.default_rng(1)
    n = 4000
    z = np.sqrt(0.5) * rng.normal(size=(n, 1)) + np.sqrt(0.5) * rng.normal(size=(n, 3))
    p = 2.0 * stats.norm.sf(np.abs(z))
    false = sum(bool(holm(row).any()) for row in p)
    assert binomial_interval(false, n)[0] <= 0.05


@given(dof=st.floats(1.0, 200.0), u=st.floats(0.01, 10.0))
def test_one_limit_has_a_false_pass_in_5_percent(dof: float, u: float) -> None:
    assert pass_probability(3.0, u, dof, upper=3.0) == pytest.approx(0.05, abs=STEPS)
    assert pass_probability(3.0, u, dof, lower=3.0) == pytest.approx(0.05, abs=STEPS)


@given(dof=st.floats(1.0, 200.0), width=st.floats(0.1, 100.0))
def test_two_limits_have_a_false_pass_in_at_most_2_5_percent(dof: float, width: float) -> None:
    assert pass_probability(width, 1.0, dof, 0.0, width) <= 0.025 + STEPS


def test_risk_far_from_and_between_near_limits() -> None:
    assert pass_probability(100.0, 1.0, math.inf, 0.0, 100.0) == pytest.approx(0.025, rel=1e-6)
    assert pass_probability(0.5, 1.0, math.inf, 0.0, 1.0) == 0.0  # narrower than 2 k u: never PASS
    inside = pass_probability(0.0, 1.0, math.inf, -4.0, 4.0)
    assert inside == pytest.approx(stats.norm.cdf(4.0 - K2) - stats.norm.cdf(K2 - 4.0), rel=1e-5)


def test_chance_to_pass_with_few_readings_is_that_of_the_noncentral_t() -> None:
    exact = stats.nct.cdf(-t_quantile(4.0, 0.95), 4.0, -3.0)
    assert pass_probability(0.0, 1.0, 4.0, upper=3.0) == pytest.approx(exact, abs=STEPS)


@pytest.mark.parametrize(("lower", "risk"), [(None, 0.05), (-20.0, 0.025)])
@pytest.mark.parametrize("n", [2000, pytest.param(20_000, marks=pytest.mark.slow)])
def test_false_pass_at_the_limit_by_counting(lower: float | None, risk: float, n: int) -> None:
    """Five readings of a true value on the upper limit: PASS as often as stated, and not more."""
    x = np.random.default_rng(7).normal(1.0, 2.0, (n, 5))
    u = x.std(axis=1, ddof=1) / math.sqrt(5.0)
    found = [decide(float(m), float(s), 4.0, lower, 1.0).status for m, s in zip(x.mean(axis=1), u, strict=True)]
    low, high = binomial_interval(found.count("PASS"), n)
    assert low <= risk <= high
    low, high = binomial_interval(found.count("FAIL"), n)
    assert low <= risk <= high


def test_refusals_by_their_words() -> None:
    with pytest.raises(PlanError, match="limits None to None"):
        decide(1.0, 1.0, 5.0)
    with pytest.raises(PlanError, match="limits 2 to 1"):
        decide(1.0, 1.0, 5.0, 2, 1)
    with pytest.raises(PlanError, match="limits nan to None"):
        decide(1.0, 1.0, 5.0, lower=math.nan)
    with pytest.raises(PlanError, match="probability"):
        decide(1.0, 1.0, 5.0, 0.0, 2.0, p=1.5)
    with pytest.raises(PlanError, match="allowed change -1"):
        no_change(0.0, 1.0, 5.0, -1.0)
    with pytest.raises(DataError, match="u = 0 with 5 degrees of freedom"):
        pass_probability(0.0, 0.0, 5.0, upper=1.0)
    with pytest.raises(DataError, match="p values"):
        holm([0.1, math.nan])
    with pytest.raises(PlanError, match="chance of a false rejection 0"):
        holm([0.1], alpha=0.0)
