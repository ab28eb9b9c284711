"""Guard bands of named decision rules: published figures, closed forms, and the stated risk counted on draws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from inertialcal.core.errors import DataError
from inertialcal.core.judging import Process, Rule
from inertialcal.core.results import Interval
from inertialcal.core.units import Quantity
from inertialcal.statistics.decision import decide, decide_by
from inertialcal.statistics.guard_band import GuardBand, guard_band, pass_probability
from inertialcal.statistics.intervals import binomial_interval, coverage_factor

SIMPLE = Rule("simple_acceptance")
RISK = Rule("false_accept_risk", risk=0.02)
K = coverage_factor(math.inf)
N = 40_000  # measurements


def items(sd: float, mean: float = 0.0, risk: float = 0.02) -> Rule:
    """Rule of a global risk; limits -1 and 1."""
    return Rule("false_accept_risk", risk=risk, process=Process(), normal=(mean, sd))


@pytest.mark.parametrize(
    ("factor", "risk"),
    [(3.0, 1e-6), (1.5, 0.0016), (1.0, 0.025), (0.83, 0.05), (1e-9, 0.5)],
)
def test_guard_factors_of_ilac_g8_table_1(factor: float, risk: float) -> None:
    """Specific false-accept risk of a value on the acceptance limit, one limit, U = 2 u; "< 1 ppm" is 1e-6."""
    rule = Rule("guard_factor", factor=factor * 2.0 / K)  # U = 2 u there, 1.96 u here
    assert pass_probability(1.0, 0.01, math.inf, upper=1.0, rule=rule) <= risk * 1.04


def test_the_default_with_one_limit_is_the_rule_of_iso_14253_1() -> None:
    """95 % conformance probability: guard band 1.65 u = 0.83 U with U = 2 u (ISO 14253-1:2017)."""
    assert guard_band(Rule(), 1.0, math.inf, None, 0.0).accept / 2.0 == pytest.approx(0.83, abs=0.01)


@pytest.mark.parametrize(("ratio", "risk"), [(4.6, 0.02)])
def test_global_risk_of_simple_acceptance_as_published(ratio: float, risk: float) -> None:
    """TUR 4.6:1 keeps the false-accept risk below 2 % whatever the process (Harben and Reese, NCSLI Measure 2012)."""
    u = 1.0 / (K * ratio)
    widest = max(_counted_by_quadrature(u, sd) for sd in np.geomspace(0.2, 5.0, 60))
    assert widest == pytest.approx(risk, abs=0.001)
    assert guard_band(items(0.6), u, math.inf, -1.0, 1.0).accept == 0.0


@pytest.mark.parametrize("ratio", [1.5, 2.0, 3.0, 4.0])
def test_worst_guard_band_of_any_process_is_that_of_dobbert(ratio: float) -> None:
    """Handbook of Z540.3, method 6: w = U (1.04 - exp(0.38 ln TUR - 0.54)), a fit to about 0.02 U."""
    u = 1.0 / (K * ratio)
    widest = max(guard_band(items(sd), u, math.inf, -1.0, 1.0).accept for sd in np.geomspace(0.3, 3.0, 25))
    wanted = 1.04 - math.exp(0.38 * math.log(ratio) - 0.54)
    assert widest * ratio == pytest.approx(wanted, abs=0.03)


def _counted_by_quadrature(u: float, sd: float) -> float:
    """Share of items that simple acceptance of -1 to 1 accepts and that do not conform."""
    true = np.linspace(1.0, 1.0 + 8.0 * u, 2001)
    accepted = stats.norm.cdf((1.0 - true) / u) - stats.norm.cdf((-1.0 - true) / u)
    return float(2.0 * np.trapezoid(stats.norm.pdf(true, 0.0, sd) * accepted, true))


@pytest.mark.parametrize(
    ("rule", "u", "dof", "lower", "most"),
    [
        (RISK, 0.2, math.inf, None, 0.02),
        (RISK, 0.2, 4.0, None, 0.02),
        (RISK, 0.05, math.inf, -1.0, 0.02),
        (RISK, 0.3, 6.0, -1.0, 0.02),
        (Rule("guard_factor", factor=1.0), 0.2, 3.0, None, 0.025),
        (Rule("test_uncertainty_ratio", ratio=4.0, otherwise=RISK), 0.2, math.inf, -1.0, 0.02),
        (SIMPLE, 0.2, 5.0, None, 0.5),
    ],
)
def test_a_true_value_at_the_limit_passes_as_often_as_stated(
    rule: Rule, u: float, dof: float, lower: float | None, most: float
) -> None:
    """Measured passes of a true value at the limit: the stated risk at most, and as `pass_probability` says."""
    rng = np.random.default_rng(8)
    found = u if math.isinf(dof) else u * np.sqrt(rng.chisquare(dof, N // 20) / dof)
    values = 1.0 + u * rng.standard_normal(N // 20)
    scatter = np.broadcast_to(found, values.shape)
    passed = sum(
        decide(float(v), float(s), dof, lower, 1.0, rule=rule).status == "PASS"
        for v, s in zip(values, scatter, strict=True)
    )
    low, high = binomial_interval(passed, len(values))
    assert low <= most
    assert low <= pass_probability(1.0, u, dof, lower, 1.0, rule=rule) <= high


@pytest.mark.parametrize(
    ("u", "dof", "sd", "mean"),
    [(0.2, math.inf, 0.6, 0.0), (0.3, math.inf, 0.5, 0.4), (0.25, 8.0, 0.7, 0.0), (0.1, 4.0, 2.0, 0.0)],
)
def test_accepted_items_that_do_not_conform_are_as_many_as_stated(u: float, dof: float, sd: float, mean: float) -> None:
    """Items drawn from the process, each measured once; the band with u known, or as found in each measurement."""
    rng = np.random.default_rng(9)
    true = rng.normal(mean, sd, N)
    values = true + u * rng.standard_normal(N)
    ratio = 1.0 if math.isinf(dof) else np.sqrt(rng.chisquare(dof, N) / dof)
    sizes = np.geomspace(0.05, 4.0, 60) * u
    band = np.interp(u * ratio, sizes, [guard_band(items(sd, mean), s, dof, -1.0, 1.0).accept for s in sizes])
    wrong = int(np.sum((np.abs(values) <= 1.0 - band) & (np.abs(true) > 1.0)))
    low, high = binomial_interval(wrong, N)
    assert low <= 0.02
    if math.isinf(dof):
        assert high >= 0.018  # and not much less: the band is no wider than it must be


def test_an_uncertainty_that_leaves_something_out_breaks_the_stated_risk() -> None:
    """Limit of the method: the error of a table that nobody stated passes many more."""
    band = guard_band(RISK, 0.1, math.inf, None, 1.0).accept
    rng = np.random.default_rng(10)
    values = 1.0 + np.hypot(0.1, 0.1) * rng.standard_normal(N)
    assert np.mean(values <= 1.0 - band) == pytest.approx(0.073, abs=0.006)


def test_a_wider_process_than_stated_has_a_larger_global_risk_but_no_larger_specific_one() -> None:
    rng = np.random.default_rng(11)
    true = 0.9 * stats.t.rvs(3, size=N, random_state=rng)  # wide, heavy tails
    values = true + 0.3 * rng.standard_normal(N)
    narrow = guard_band(items(0.45), 0.3, math.inf, -1.0, 1.0).accept
    specific = guard_band(RISK, 0.3, math.inf, -1.0, 1.0).accept
    assert np.mean((np.abs(values) <= 1.0 - narrow) & (np.abs(true) > 1.0)) > 0.03
    outside = np.abs(true) > 1.0
    assert np.mean(np.abs(values[outside]) <= 1.0 - specific) < 0.02


def test_several_places_that_must_all_pass_need_no_narrower_bands() -> None:
    """A unit beyond the limit at one of ten places passes everywhere in 2 % at most; FAIL is held together."""
    p = 0.95 ** (1.0 / 10.0)
    assert guard_band(RISK, 1.0, 9.0, None, 3.0, p).accept == guard_band(RISK, 1.0, 9.0, None, 3.0).accept
    rng = np.random.default_rng(12)
    reject = guard_band(RISK, 1.0, math.inf, None, 0.0, p).reject
    failed = np.any(rng.standard_normal((N, 10)) > reject, axis=1)
    low, high = binomial_interval(int(failed.sum()), N)
    assert low <= 0.02 <= high


@pytest.mark.parametrize(
    ("value", "status"), [(0.99, "PASS"), (1.0, "PASS"), (1.01, "FAIL"), (-1.0, "PASS"), (-1.01, "FAIL")]
)
def test_simple_acceptance_has_pass_and_fail_alone(value: float, status: str) -> None:
    assert decide(value, 0.5, 3.0, -1.0, 1.0, rule=SIMPLE).status == status


def test_simple_acceptance_without_an_uncertainty_is_inconclusive() -> None:
    assert decide(0.0, None, None, -1.0, 1.0, rule=SIMPLE).status == "INCONCLUSIVE"
    assert decide(0.0, 0.0, None, -1.0, 1.0, rule=SIMPLE).status == "INCONCLUSIVE"


def test_a_ratio_below_the_stated_one_takes_the_other_rule() -> None:
    rule = Rule("test_uncertainty_ratio", ratio=4.0)
    good = decide(0.99, 0.24 / K, None, -1.0, 1.0, rule=rule)
    poor = decide(0.99, 0.26 / K, None, -1.0, 1.0, rule=rule)
    assert (good.status, poor.status) == ("PASS", "INCONCLUSIVE")
    assert good.basis.ratio == pytest.approx(1.0 / 0.24)
    assert (good.basis.accept_upper, poor.basis.accept_upper) == pytest.approx((1.0, 0.74))


def test_a_binary_rule_fails_what_it_cannot_pass() -> None:
    rule = Rule("guard_factor", factor=1.0, binary=True)
    found = decide(0.9, 0.1, None, -1.0, 1.0, rule=rule)
    assert found.status == "FAIL"
    assert found.basis.risk == pytest.approx(stats.norm.cdf(1.0), abs=1e-6)  # of a false reject


def test_the_risk_of_a_verdict_is_that_of_this_measurement() -> None:
    found = decide(0.8, 0.1, 5.0, -1.0, 1.0, rule=SIMPLE)
    assert found.basis.risk == pytest.approx(stats.t.sf(2.0, 5.0) + stats.t.sf(18.0, 5.0))
    assert decide(0.95, 0.1, 5.0, -1.0, 1.0).basis.risk is None  # nothing is decided


@pytest.mark.parametrize("rule", [Rule(), RISK, Rule("guard_factor", factor=1.5), SIMPLE, items(0.6)])
@given(value=st.floats(-3.0, 3.0), u=st.floats(0.02, 1.0), dof=st.floats(1.0, 50.0))
@settings(max_examples=15, deadline=None)
def test_acceptance_limits_agree_with_the_verdict(rule: Rule, value: float, u: float, dof: float) -> None:
    found = decide(value, u, dof, -1.0, 1.0, rule=rule)
    low, high = found.basis.accept_lower, found.basis.accept_upper
    inside = low is not None and high is not None and low - 1e-12 <= value <= high + 1e-12
    if abs(abs(value) - (high or 0.0)) > 1e-9:
        assert (found.status == "PASS") == inside
    mirrored = decide(-value, u, dof, -1.0, 1.0, rule=rule)
    assert mirrored.status == found.status


def test_limits_that_are_too_close_can_pass_nothing() -> None:
    found = decide(0.0, 2.0, None, -1.0, 1.0, rule=RISK)
    assert (found.status, found.basis.accept_upper) == ("INCONCLUSIVE", None)
    assert "wider than the limits" in found.reason
    assert pass_probability(0.0, 2.0, math.inf, -1.0, 1.0, rule=RISK) == 0.0


def test_intervals_that_are_not_students_have_each_rule_or_none() -> None:
    def profile(p: float) -> Interval | None:
        return {0.95: Interval(0.5, 1.4, p), 0.90: Interval(0.6, 1.2, p), 0.96: Interval(0.4, 1.5, p)}.get(p)

    def status(rule: Rule, upper: float) -> str:
        return decide_by(profile, 0.8, 0.2, upper=upper, rule=rule).status

    assert [status(Rule(), 1.2), status(Rule(), 1.19)] == ["PASS", "INCONCLUSIVE"]
    assert [status(SIMPLE, 0.8), status(SIMPLE, 0.79)] == ["PASS", "FAIL"]
    half = Rule("guard_factor", factor=0.5)
    assert [status(half, 1.101), status(half, 1.09), status(half, 0.64)] == ["PASS", "INCONCLUSIVE", "FAIL"]
    assert [status(RISK, 1.5), status(RISK, 1.49), status(RISK, 0.39)] == ["PASS", "INCONCLUSIVE", "FAIL"]
    other = decide_by(profile, 0.8, 0.2, upper=2.0, rule=Rule("false_accept_risk", risk=0.001))
    assert (other.status, other.reason) == ("INCONCLUSIVE", "no interval of 99.8 % is estimated")


def test_a_process_comes_in_the_unit_of_the_limits() -> None:
    process = Process(sd=Quantity(0.2, "%"))
    rule = Rule("false_accept_risk", process=process).within("1", -0.01, 0.01)
    assert rule.normal == pytest.approx((0.0, 0.002))
    centred = Rule("false_accept_risk", process=Process(in_tolerance=0.95)).within("1", 0.0, 2.0 * K)
    assert centred.normal == pytest.approx((K, 1.0))


def test_bands_are_a_pair() -> None:
    assert guard_band(SIMPLE, 1.0, 3.0, -1.0, 1.0) == GuardBand(0.0, 0.0)
    with pytest.raises(DataError, match="degrees of freedom"):
        pass_probability(0.0, 1.0, 0.0, upper=1.0)
