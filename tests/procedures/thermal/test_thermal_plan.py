"""Plan of a thermal test: its forecast against a chamber of another simulator, its programme, what is refused."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import special

import inertialcal as ic
from independent.thermal import Chamber, Unit, ramped
from inertialcal.core.errors import UsageError
from inertialcal.core.influence import Influence
from inertialcal.procedures.thermal.fit.quantities import change_at
from inertialcal.procedures.thermal.plan import Attitude, Plan
from inertialcal.procedures.thermal.recordings import Readings, Sweep
from inertialcal.procedures.thermal.reduction import bias_at, reduce

DEG = math.radians(1.0)
KNOWN = {
    "noise": "0.00632456 deg/s/sqrt(Hz)", "walk": "2e-5 deg/s/sqrt(s)", "turn_on": "0.003 deg/s",
    "turn_on_slope": "2e-5 deg/s/degC", "coefficient": "2e-4 deg/s/degC", "u_thermometer": "0.5 K", "order": 2,
    "coldest": "-20 degC", "hottest": "60 degC", "room": "20 degC", "soak": "0 s", "ramp": "1.2 K/min",
    "slowest": "1.2 K/min", "latitude": "90 deg", "u_tilt": "0 deg", "warm_up": "1800 s",
}  # fmt: skip
FIVE = {"least_runs": 5, "most_runs": 5, "simulate": 0, "available": "200 h"}
UNIT = Unit(polynomial=(0.02, 2e-4, 3e-6), turn_on=0.003, slope_scatter=2e-5, walk=2e-5, sample=0.002, thermometer=0.5)
CHAMBER = Chamber(runs=5, points=(20.0, -20.0, 60.0, 20.0), speeds=(0.02, 0.02, 0.02))


@pytest.mark.parametrize("n", [20, pytest.param(100, marks=pytest.mark.slow)])
def test_the_forecast_is_the_scatter_of_another_simulator_and_what_the_test_states(n: int) -> None:
    found = ic.plan_thermal(**KNOWN, **FIVE)
    plan = Plan(order=2, warm_up=1800.0, attitude=Attitude(0.0), latitude=0.5 * math.pi,
                standards={"thermometer.temperature": Influence(0.5, "degC")})  # fmt: skip
    errors: dict[str, list[float]] = {"bias": [], "bias_over_temperature": []}
    stated: dict[str, list[float]] = {"bias": [], "bias_over_temperature": []}
    for seed in range(1, n + 1):
        case = ramped(seed, UNIT, CHAMBER)
        sweeps = []
        for name, table in case.tables.items():
            c = {key: np.asarray(value, dtype=float) for key, value in table.columns.items()}
            time = c["unix_s"] - c["unix_s"][0]
            sweeps.append(
                Sweep(name, name, name, time, {"x": c["temperature [degC]"]}, {"x": c["gyro_x [deg/s]"] * DEG})
            )
        law = reduce(plan, Readings(tuple(sweeps))).sensors["x"].law
        for figure in found.figures:
            assert figure.key.at is not None
            at = np.clip([figure.key.at.value], *law.domain)
            plain = figure.key.quantity == "bias"
            made = (bias_at if plain else change_at)(plan, law, "x", "rad/s", at)
            assert made is not None
            away = at[0] - 20.0
            truth = (0.02 if plain else 0.0) + 2e-4 * away + 3e-6 * away**2
            errors[figure.key.quantity].append(float(made.values[0]) - truth * DEG)
            stated[figure.key.quantity].append(float(made.u[0]))
    for quantity, size in errors.items():
        forecast = found.of(quantity).u
        low, high = special.chdtri(n, [0.9995, 0.0005])
        assert low <= float(np.sum(np.square(size))) / forecast**2 <= high, quantity
        assert math.sqrt(np.mean(np.square(stated[quantity]))) == pytest.approx(forecast, rel=0.3), quantity


def test_parts_by_closed_forms() -> None:
    found = ic.plan_thermal(**KNOWN, **FIVE)
    parts = {part.label: part.u / DEG for part in found.of("bias").parts}
    at = found.of("bias").key.at
    assert at is not None
    assert parts["turn-on bias"] == pytest.approx(0.003 / math.sqrt(5.0))
    assert parts["turn-on temperature coefficient"] == pytest.approx(2e-5 * abs(at.value - 20.0) / math.sqrt(5.0))
    assert parts["thermometer"] == pytest.approx(0.5 * 2e-4, rel=1e-3)
    change = {part.label: part.u for part in found.of("bias_over_temperature").parts}
    assert "turn-on bias" not in change
    assert "thermometer" not in change  # of a straight line: the same everywhere


def test_the_shortest_that_is_enough_and_a_loud_no() -> None:
    given = {**KNOWN, "slowest": "0.3 K/min"}
    found = ic.plan_thermal(**given, wanted={"bias": "0.0009 deg/s"}, simulate=0)
    assert 5 < int(found.design.choice["runs"]) < 20
    assert found.of("bias").u <= 0.0009 * DEG
    never = ic.plan_thermal(**{**given, "u_thermometer": "10 K"}, wanted={"bias": "0.0009 deg/s"}, available="40 h",
                            simulate=0)  # fmt: skip
    (lost,) = [one for one in never.remarks if one.code == "not_reached"]
    assert "thermometer alone leaves 0.0020 deg/s, however long" in lost.what


def test_the_schedule_is_a_run_of_the_chamber_and_the_check_simulates_it(tmp_path: Path) -> None:
    path = tmp_path / "schedule.csv"
    found = ic.plan_thermal(**{**KNOWN, **FIVE, "soak": "15 min", "simulate": 20}, schedule=str(path))
    beside = found.of("bias").simulated
    assert beside is not None
    assert beside.agrees(found.of("bias").u)
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    one = [row for row in rows if row["run"] == "3"]
    assert [row["temperature [degC]"] for row in one] == ["20", "-20", "-20", "60", "60", "20", "20"]
    assert [row["ramp [K/min]"] for row in one] == ["0", "-1.2", "0", "1.2", "0", "-1.2", "0"]
    assert float(one[-1]["stop [s]"]) * 5 + 5 * 1800.0 == pytest.approx(found.time)


def test_an_accelerometer_is_told_its_change_alone() -> None:
    found = ic.plan_thermal(noise="100 ug/sqrt(Hz)", coldest="-20 degC", hottest="60 degC", turn_on="1 mg",
                            wanted={"bias_over_temperature": "0.2 mg"}, simulate=0)  # fmt: skip
    assert [one.key.quantity for one in found.figures] == ["bias_over_temperature"]
    with pytest.raises(UsageError, match="no such figure"):
        ic.plan_thermal(noise="100 ug/sqrt(Hz)", coldest="-20 degC", hottest="60 degC", wanted={"bias": "1 mg"})


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "nothing is wanted"),
        ({"noise": "5 V"}, "noise"),
        ({"hottest": "-15 degC", "room": "-18 degC"}, "a range of 10 K"),
        ({"room": "99 degC"}, "outside the range"),
        ({"walk": "3 ug/sqrt(s)"}, "walk"),
        ({"available": "1 min"}, "the shortest test"),
    ],
)
def test_one_clear_message(given: dict[str, object], said: str) -> None:
    with pytest.raises(UsageError) as error:
        ic.plan_thermal(**{**KNOWN, **given})
    assert said in str(error.value)
