"""A requirement on the bias over temperature: where it is judged, the band, and beyond the ramps."""

from __future__ import annotations

from dataclasses import replace

import pytest
from thermal_sweeps import plan, readings

from inertialcal.core.judging import Rule, parse_condition
from inertialcal.procedures.thermal.over_temperature import judged_over, temperatures_of
from inertialcal.procedures.thermal.reduction import OfSensor, reduce
from inertialcal.statistics.guard_band import INTERVAL
from inertialcal.statistics.intervals import binomial_interval, contains

RAMPS = (-30.0, 67.0)


def sensor(seed: int = 1, noise: float = 1e-3, offset: float = 0.01) -> OfSensor:
    found = readings(lambda T: 1e-3 * (T - 20.0), noise=noise, offset=offset, seed=seed)
    return reduce(plan(order=2), found).sensors["x"]


def statuses(one: OfSensor, where: str, limit: float, rule: Rule = INTERVAL) -> list[str]:
    places = judged_over(plan(), one.law, "x", "rad/s", parse_condition(where), -limit, limit, rule)
    return [place.status for place in places]


@pytest.mark.parametrize(("where", "low", "high"), [
    ("temperature >= -20 degC and temperature <= 60 degC", -20.0, 60.0),
    ("temperature >= 253.15 K and temperature <= 60 degC", -20.0, 60.0),
    ("temperature <= 60 degC", -30.0, 60.0),
    ("temperature >= 0 degC", 0.0, 67.0),
    ("abs(temperature) <= 10 degC", -10.0, 10.0),
    ("temperature >= -40 degC and temperature <= 85 degC", -40.0, 85.0),
])  # fmt: skip
def test_the_range_is_that_of_the_condition_an_open_end_that_of_the_ramps(where: str, low: float, high: float) -> None:
    found = temperatures_of(parse_condition(where), RAMPS)
    assert len(found) == 13
    assert (found[0], found[-1]) == pytest.approx((low, high))


def test_pass_fail_and_neither() -> None:
    one = sensor()
    where = "temperature >= -20 degC and temperature <= 60 degC"
    assert set(statuses(one, where, 0.2)) == {"PASS"}
    assert "FAIL" in statuses(one, where, 0.01)
    near = statuses(one, "temperature >= 19 degC and temperature <= 21 degC", 0.004)
    assert set(near) == {"INCONCLUSIVE"}


def test_a_range_by_the_rule_that_is_named() -> None:
    """U is that of the band; a false-accept risk needs no band to PASS; simple acceptance has no third verdict."""
    one = sensor()
    where = "temperature >= 19 degC and temperature <= 21 degC"
    assert statuses(one, where, 0.004, Rule("guard_factor", factor=1.0)) == statuses(one, where, 0.004)
    assert set(statuses(one, where, 0.004, Rule("simple_acceptance"))) <= {"PASS", "FAIL"}
    band, each = (
        next(judged_over(plan(), one.law, "x", "rad/s", parse_condition(where), -1.0, 1.0, rule)).basis
        for rule in (INTERVAL, Rule("false_accept_risk", risk=0.025))
    )
    assert band.accept_upper is not None
    assert each.accept_upper is not None
    assert band.accept_upper < each.accept_upper < 1.0


def test_a_range_wider_than_the_ramps_is_never_passed() -> None:
    one = sensor()
    found = statuses(one, "temperature >= -40 degC and temperature <= 85 degC", 10.0)
    assert found.count("INCONCLUSIVE") >= 3
    assert "FAIL" not in found
    places = judged_over(plan(), one.law, "x", "rad/s", parse_condition("temperature <= 85 degC"), -10.0, 10.0)
    reasons = {place.reason for place in places if place.at > 67.0}
    assert len(reasons) == 1
    assert "outside the range of the ramps" in reasons.pop()


def test_without_uncertainty_it_is_inconclusive() -> None:
    alone = readings(lambda T: 0.0 * T, points=(67.0, -30.0), noise=1e-3)
    one = reduce(plan(), alone).sensors["x"]
    assert set(statuses(one, "temperature >= 0 degC and temperature <= 50 degC", 1.0)) == {"INCONCLUSIVE"}


def test_a_change_is_judged_from_the_reference_temperature() -> None:
    """An offset of any size is in the bias and not in its change; the change is zero where it begins."""
    one = sensor(offset=5.0)
    condition = parse_condition("temperature >= -20 degC and temperature <= 60 degC")
    places = list(judged_over(plan(), one.law, "x", "rad/s", condition, -0.05, 0.05, change=True))
    assert {place.status for place in places} == {"PASS"}
    assert all(abs(place.at - 20.0) > 1.0 for place in places)
    assert places[0].value == pytest.approx(-0.04, abs=2e-3)
    assert "PASS" not in statuses(one, "temperature >= -20 degC", 0.05)
    beyond = replace(plan(), reference_temperature=90.0)
    (reason,) = {one.reason for one in judged_over(beyond, one.law, "x", "rad/s", condition, -1.0, 1.0, change=True)}
    assert reason == "the reference temperature, 90 degC, is outside the range of the ramps"


@pytest.mark.parametrize("change", [False, True])
def test_the_band_holds_the_truth_everywhere_at_once(change: bool) -> None:
    held = 0
    n = 120
    condition = parse_condition("temperature >= -20 degC and temperature <= 60 degC")
    for seed in range(1, n + 1):
        one = sensor(seed)
        places = list(judged_over(plan(), one.law, "x", "rad/s", condition, -1.0, 1.0, change=change))
        inside = [place.interval is not None and contains(place.interval, 1e-3 * (place.at - 20.0)) for place in places]
        held += all(inside)
    assert binomial_interval(held, n)[1] > 0.95  # never too narrow; it may be wider than it need be
