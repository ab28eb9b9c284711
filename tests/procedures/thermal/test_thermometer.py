"""Calibration of a temperature channel against a simulator that shares no code: coverage, and ways to break it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from independent.warm.thermometer import HIGH, LOW, Bench, swept
from inertialcal.core.errors import DataError
from inertialcal.core.influence import Influence
from inertialcal.core.judging import Asked, Rule
from inertialcal.core.results import Row
from inertialcal.procedures.thermal.plan import Plan, Thermometer
from inertialcal.procedures.thermal.recordings import Readings, Sweep
from inertialcal.procedures.thermal.thermometer import judge_error, thermometer_rows
from inertialcal.statistics.intervals import covers
from sized import sized

CAMPAIGNS, FEW = sized(60, 30), 12
BENCH = Bench()
NOMINAL = Thermometer(0.0264, -0.5, 25.0)
STATED = {"thermometer.temperature": Influence(0.2, "degC", standard="thermometer", quantity="temperature")}


def thermal(bench: Bench, seed: int, stated: bool = True) -> tuple[Readings, Plan]:
    sweeps = [
        Sweep(f"sweep {k}", f"run {k}", "file.csv", one.time, {"x": one.channel}, {"x": np.zeros(len(one.time))},
              reference=one.reference)
        for k, one in enumerate(swept(bench, seed))
    ]  # fmt: skip
    plan = Plan(thermometers={"x": NOMINAL}, standards=STATED if stated else {})
    return Readings(tuple(sweeps)), plan


def rows(bench: Bench, seed: int, stated: bool = True) -> dict[str, Row]:
    readings, plan = thermal(bench, seed, stated)
    return {row.quantity: row for row in thermometer_rows(plan, readings, "x")}


def truth(bench: Bench) -> dict[str, float]:
    middle = 0.5 * (LOW + HIGH)
    error = bench.offset + (bench.slope - 1.0) * (HIGH - middle)
    at_nominal = middle + bench.offset + bench.slope * (NOMINAL.temperature - middle)
    return {
        "thermometer_slope": NOMINAL.slope * bench.slope,
        "thermometer_voltage": NOMINAL.voltage + NOMINAL.slope * (at_nominal - NOMINAL.temperature),
        "temperature_error": error,
        "temperature_error_of_range": error / (HIGH - LOW),
    }


@pytest.mark.parametrize(
    "bench",
    [
        pytest.param(BENCH, id="as assumed"),
        pytest.param(replace(BENCH, time_constant=300.0), id="chamber far ahead of the sensor"),
        pytest.param(replace(BENCH, runs=8, u_reference=0.0), id="reference better than stated"),
    ],
)
@pytest.mark.parametrize("campaigns", [FEW, pytest.param(CAMPAIGNS, marks=pytest.mark.slow)])
def test_intervals_hold_the_truth(bench: Bench, campaigns: int) -> None:
    true, hits = truth(bench), dict.fromkeys(truth(bench), 0)
    for seed in range(1, campaigns + 1):
        found = rows(bench, seed)
        for name, value in true.items():
            interval = found[name].interval
            assert interval is not None
            hits[name] += (interval.lo or -np.inf) <= value <= (interval.hi or np.inf)
    assert all(covers(count, campaigns) for count in hits.values()), hits


def test_a_delay_is_told_from_the_line() -> None:
    found = rows(replace(BENCH, time_constant=300.0), 1)
    assert found["thermometer_lag"].value == pytest.approx(300.0, rel=0.05)


def test_a_bent_channel_shows_in_the_cubic() -> None:
    straight, bent = rows(BENCH, 1)["thermometer_nonlinearity"], rows(replace(BENCH, cubic=2e-5), 1)
    assert straight.interval is not None
    assert abs(float(straight.value or 0.0)) < 0.05
    assert abs(float(bent["thermometer_nonlinearity"].value or 0.0)) > 0.3


def test_the_error_of_a_bent_channel_is_that_of_the_worst_temperature() -> None:
    """At both ends the cubic takes off what the slope adds: the worst temperature is between."""
    bench = replace(BENCH, offset=0.0, slope=0.95, cubic=3.5e-5, u_reference=0.0)
    away = np.linspace(LOW, HIGH, 801) - 0.5 * (LOW + HIGH)
    error = (bench.slope - 1.0) * away + bench.cubic * away**3
    found = rows(bench, 1)["temperature_error"]
    assert abs(float(found.value or 0.0)) == pytest.approx(np.abs(error).max(), abs=0.1)
    assert abs(error[-1]) < 0.8 * np.abs(error).max()


def verdicts(bench: Bench, **limits: str) -> dict[float, str]:
    """Return the verdicts on the error in degC, by temperature."""
    readings, plan = thermal(bench, 1)
    result = SimpleNamespace(plan=plan, readings=readings, sensors={"x": None})
    limit, lower, upper = (limits.get(name) for name in ("limit", "lower", "upper"))
    asked = Asked("R", "temperature_error", None, "expected", limit, lower, upper, "", Rule())
    tested: Any = SimpleNamespace(id="warm", result=result)
    return {float(one.at or 0.0): one.verdict for one in judge_error(asked, [tested])}


def test_a_requirement_holds_at_every_temperature() -> None:
    bench = replace(BENCH, offset=0.0, slope=1.02, u_reference=0.0)  # 0.8 degC too low at -20 degC, too high at 60 degC
    assert set(verdicts(bench, limit="1.6 degC").values()) == {"PASS"}
    assert set(verdicts(bench, limit="0.2 degC").values()) == {"FAIL"}
    found = verdicts(bench, lower="-0.3 degC", upper="2 degC")
    assert found[min(found)] == "FAIL"
    assert found[max(found)] == "PASS"
    in_kelvin = verdicts(bench, lower="-0.3 K", upper="2 K")  # differences, not temperatures above absolute zero
    assert in_kelvin == found


def test_one_rate_and_one_power_up_are_named() -> None:
    found = rows(replace(BENCH, one_rate=True), 1)
    assert found["thermometer_lag"].reason.code == "one_rate"
    assert found["temperature_error"].reason.code == "one_rate"
    alone = rows(replace(BENCH, runs=1), 1)
    assert {row.reason.code for row in alone.values()} == {"one_run"}


def test_a_reference_that_nobody_states_is_named() -> None:
    found = rows(BENCH, 1, stated=False)
    assert found["temperature_error"].reason.code == "relative"
    assert not found["temperature_error"].shared


def test_a_reference_that_does_not_change_is_refused() -> None:
    sweep = Sweep("a", "run", "file.csv", np.arange(500.0), {"x": np.full(500, 20.0)}, {"x": np.zeros(500)},
                  reference=np.full(500, 20.0))  # fmt: skip
    with pytest.raises(DataError) as refused:
        list(thermometer_rows(Plan(), Readings((sweep,)), "x"))
    assert refused.value.problems[0].code == "no_temperature_change"
