"""The vacuum step: line through the difference of two laws over temperature."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.key import Key
from inertialcal.core.results import Row
from inertialcal.procedures.thermal.against import POINTS, offset_rows
from inertialcal.procedures.thermal.reduction import Plan, Result, Truth, reduce, simulate

DEG = float(np.radians(1.0))
AIR = Truth(interval=40.0, white=1e-9, start_up=0.0, hysteresis=0.0, lag=0.0)
PLAN = Plan(order=3, warm_up=0.0)


def reduced(truth: Truth, seed: int, prefix: str = "", plan: Plan = PLAN) -> Result:
    found = reduce(plan, simulate(plan, truth, np.random.default_rng(seed)))
    sweeps = tuple(replace(one, run=f"{prefix}{one.run}") for one in found.readings.sweeps)
    return replace(found, readings=replace(found.readings, sweeps=sweeps))


def rows(change: list[list[float]], plan: Plan = PLAN) -> dict[Key, Row]:
    vacuum = replace(AIR, coefficients=AIR.coefficients + DEG * np.array(change))
    found = offset_rows(reduced(vacuum, 2, "vacuum ", plan), reduced(AIR, 1, plan=plan), "air", "vacuum_offset")
    return {row.key: row for row in found}


def test_a_difference_that_is_a_line_is_the_step() -> None:
    found = rows([[0.05], [1e-4], [0.0], [0.0]])
    step, slope = found[Key("vacuum_step", "x")], found[Key("vacuum_step_temperature", "x")]
    ratio = found[Key("vacuum_step_relative_temperature", "x")]
    offset = found[Key("vacuum_offset", "x")]
    assert step.unit == "rad/s"
    assert slope.unit == "rad/s/degC"
    for row, true in ((step, 0.05 * DEG), (slope, 1e-4 * DEG), (ratio, 2e-3)):
        assert row.value is not None
        assert row.u is not None
        assert abs(row.value - true) < 4.0 * row.u
    assert ratio.value is not None
    assert slope.value is not None
    assert step.value is not None
    assert ratio.value == pytest.approx(slope.value / step.value)
    assert offset.u == pytest.approx(step.u, rel=0.3)  # both are turn-on to turn-on


def test_of_a_difference_that_bends_it_is_the_line_of_least_squares() -> None:
    quiet = replace(AIR, run_std=0.0, slope_std=1e-9)
    vacuum = replace(quiet, coefficients=quiet.coefficients + DEG * np.array([[0.05], [1e-4], [2e-5], [0.0]]))
    one, two = reduced(vacuum, 2, "vacuum "), reduced(quiet, 1)
    laws = [each.sensors["x"].law for each in (one, two)]
    low, high = max(law.domain[0] for law in laws), min(law.domain[1] for law in laws)
    places = np.linspace(low, high, POINTS)
    apart = laws[0].basis(places) @ laws[0].coefficients - laws[1].basis(places) @ laws[1].coefficients
    slope, level = np.polyfit(places - 20.0, apart, 1)
    found = {row.key: row for row in offset_rows(one, two, "air", "vacuum_offset")}
    assert found[Key("vacuum_step", "x")].value == pytest.approx(level, rel=1e-9)
    assert found[Key("vacuum_step_temperature", "x")].value == pytest.approx(slope, rel=1e-9)


def test_a_step_that_may_be_nothing_has_no_relative_slope() -> None:
    row = rows([[0.0], [1e-4], [0.0], [0.0]])[Key("vacuum_step_relative_temperature", "x")]
    assert row.status == "not_estimated"
    assert row.reason.code == "no_step"


def test_outside_what_both_went_through_there_is_no_step() -> None:
    row = rows([[0.05], [0.0], [0.0], [0.0]], replace(PLAN, reference_temperature=90.0))[Key("vacuum_step", "x")]
    assert row.reason.code == "outside"
