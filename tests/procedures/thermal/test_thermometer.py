"""Calibration of a temperature channel against a simulator that shares no code: coverage, and ways to break it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from independent.warm.thermometer import HIGH, LOW, Bench, swept
from inertialcal.core.errors import DataError
from inertialcal.core.influence import Influence
from inertialcal.core.results import Row
from inertialcal.procedures.thermal.plan import Plan, Thermometer
from inertialcal.procedures.thermal.recordings import Readings, Sweep
from inertialcal.procedures.thermal.thermometer import thermometer_rows
from inertialcal.statistics.intervals import covers

CAMPAIGNS, FEW = 60, 12
BENCH = Bench()
NOMINAL = Thermometer(0.0264, -0.5, 25.0)
STATED = {"thermometer.temperature": Influence(0.2, "degC", standard="thermometer", quantity="temperature")}


def rows(bench: Bench, seed: int, stated: bool = True) -> dict[str, Row]:
    sweeps = [
        Sweep(f"sweep {k}", f"run {k}", "file.csv", one.time, {"x": one.channel}, {"x": np.zeros(len(one.time))},
              reference=one.reference)
        for k, one in enumerate(swept(bench, seed))
    ]  # fmt: skip
    plan = Plan(thermometers={"x": NOMINAL}, standards=STATED if stated else {})
    return {row.quantity: row for row in thermometer_rows(plan, Readings(tuple(sweeps)), "x")}


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
