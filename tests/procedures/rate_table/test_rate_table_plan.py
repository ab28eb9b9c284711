"""Plan of a rate table: its forecast against tests of another simulator, its programme, what is refused."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from scipy import special

import inertialcal as ic
from independent.rate_table import Gyros, Protocol, reduced
from inertialcal.core.errors import UsageError
from inertialcal.core.influence import Influence
from inertialcal.procedures.planned import TestPlan
from inertialcal.procedures.rate_table.plan import Attitude, Plan
from inertialcal.procedures.rate_table.planning import Programme
from inertialcal.procedures.rate_table.readings import Readings
from inertialcal.procedures.rate_table.reduction import reduce
from typed_commands import call

DEG = math.radians(1.0)
KNOWN = {
    "noise": "0.00447214 deg/s/sqrt(Hz)", "fastest": "36 deg/s", "turn_on": "0.002 deg/s", "turn_on_scale": "150 ppm",
    "dwell_scatter": "0.001 deg/s", "latitude": "90 deg", "u_tilt": "0 deg", "u_rate": "100 ppm",
    "u_mounting": "0.01 deg",
}  # fmt: skip
GYROS = Gyros(turn_on=0.002, slope_scatter=150e-6, sample=0.02, dwell=0.001, table_rate=1e-4, fixture=0.01 * DEG)
STANDARDS = {"rate_table.rate": Influence(1e-4), "rate_table.mounting": Influence(0.01 * DEG, "rad")}
SHORT = {"longest_dwell": "10 s", "least_runs": 5, "most_runs": 5, "simulate": 0}


def laid(found: TestPlan) -> Programme:
    """Return the dwells of a recording."""
    return cast("tuple[Programme, int]", found.design.detail)[0]


def readings_of(seed: int, rates: tuple[float, ...]) -> tuple[Readings, dict[str, float]]:
    """Return one test of another simulator, as the procedure reads it."""
    case = reduced(seed, GYROS, Protocol(rates=rates, runs=5, samples=200, rate=20.0))
    c = case.tables["table.csv"].columns
    run = np.array([str(one)[1:] for one in c["run"]])
    outputs = {a: np.asarray(c[f"g{a} [deg/s]"] * DEG, dtype=float) for a in "xyz"}
    scatters = dict.fromkeys("xyz", np.asarray(c["std [deg/s]"] * DEG, dtype=float))
    made = Readings(np.asarray(c["rate [deg/s]"] * DEG, dtype=float), np.array(c["axis"], dtype=str), outputs, scatters,
                    np.asarray(c["n"], dtype=float), run=run, sensors=("x", "y", "z"))  # fmt: skip
    return made, case.truth


@pytest.mark.parametrize("n", [20, pytest.param(100, marks=pytest.mark.slow)])
def test_the_forecast_is_the_scatter_of_another_simulator_and_what_the_test_states(n: int) -> None:
    found = ic.plan_rate_table(**KNOWN, **SHORT, available="24 h")
    rates = tuple(float(x) / DEG for x in laid(found).rates)
    plan = Plan(standards=STANDARDS, attitude=Attitude(0.0), latitude=0.5 * math.pi)
    errors: dict[str, list[float]] = {"bias": [], "scale_factor_error": []}
    stated: dict[str, list[float]] = {"bias": [], "scale_factor_error": []}
    for seed in range(1, n + 1):
        made, truth = readings_of(seed, rates)
        result = reduce(plan, made).estimate
        assert result is not None
        for quantity, unit in (("bias", DEG), ("scale_factor_error", 0.01)):
            for at, key in enumerate(result.keys):
                if key.quantity == quantity:
                    errors[quantity].append(float(result.values[at]) - truth[f"{quantity} {key.axis}"] * unit)
                    stated[quantity].append(float(result.u[at]))
    for quantity, size in errors.items():
        forecast = found.of(quantity).u
        low, high = special.chdtri(n, [0.9995, 0.0005])  # the three sensors share the table: n, not 3 n
        assert low <= n * np.mean(np.square(size)) / forecast**2 <= high, quantity
        assert math.sqrt(np.mean(np.square(stated[quantity]))) == pytest.approx(forecast, rel=0.25), quantity


def test_what_more_runs_and_longer_dwells_leave_is_in_proportion() -> None:
    few = ic.plan_rate_table(**KNOWN, **SHORT, available="24 h")
    many = ic.plan_rate_table(**KNOWN, **{**SHORT, "least_runs": 10, "most_runs": 10}, available="24 h")
    for one, other in zip(few.figures, many.figures, strict=True):
        for part in (part for part in one.parts if part.u > 0.01 * one.u):
            rest = next(p for p in other.parts if p.label == part.label)
            assert rest.u == pytest.approx(
                part.u / math.sqrt(2.0) if part.remedy else part.u, rel=0.03
            )  # weights differ a little
    # the slope of a line through rates that alternate in sense, by noise of one dwell: closed form of least squares
    programme = laid(few)
    x, length = programme.rates, programme.stop - programme.start
    noise = next(p.u for p in few.of("scale_factor_error").parts if p.label == "noise")
    white = math.radians(0.00447214) ** 2
    solve = np.linalg.pinv(np.column_stack([np.ones(len(x)), x, np.abs(x)]))[1]
    assert noise == pytest.approx(math.sqrt(white * float(np.sum(solve**2 / length)) / 5.0), rel=2e-2)


def test_the_shortest_test_that_is_enough_is_chosen_and_more_is_not_possible_than_the_standards_allow() -> None:
    found = ic.plan_rate_table(**KNOWN, wanted={"bias": "0.0004 deg/s"}, simulate=0)
    assert found.of("bias").u <= 0.0004 * DEG * 1.001
    shorter = [one for one in found.others if one.time < found.time]
    assert all(one.ratio() > 1.0 for one in shorter)
    assert shorter
    never = ic.plan_rate_table(**KNOWN, wanted={"scale_factor_error": "50 ppm", "bias": "0.0004 deg/s"}, simulate=0)
    (lost,) = [one for one in never.remarks if one.code == "not_reached"]
    assert lost.severity == "error"
    assert "table rate alone leaves 100 ppm, however long" in lost.what
    assert never.time == found.time  # what can be reached is planned
    late = ic.plan_rate_table(**KNOWN, wanted={"bias": "0.0004 deg/s"}, available="7 h", simulate=0)
    assert [one.code for one in late.remarks if one.severity == "error"] == ["not_in_time"]
    assert late.time <= 7.0 * 3600.0


def test_dwells_are_whole_turns_and_senses_alternate(tmp_path: Path) -> None:
    path = tmp_path / "schedule.csv"
    found = ic.plan_rate_table(noise="0.2 deg/sqrt(h)", fastest="100 deg/s", wanted={"bias": "0.01 deg/s"},
                               longest_dwell="30 s", simulate=0, schedule=str(path))  # fmt: skip
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    runs = int(found.design.choice["runs"])
    assert len(rows) == 3 * runs * 8
    one = [row for row in rows if row["recording"] == "y_run2"]
    rates = np.array([float(row["rate [deg/s]"]) for row in one])
    assert float(np.sum(rates)) == 0.0
    assert sorted(np.abs(rates)) == [25.0, 25.0, 50.0, 50.0, 75.0, 75.0, 100.0, 100.0]
    start, stop = (np.array([float(row[f"{name} [s]"]) for row in one]) for name in ("start", "stop"))
    assert np.all(start[1:] > stop[:-1])
    turns = np.abs(rates) * (stop - start) / 360.0
    whole = np.abs(rates) * float(found.design.choice["dwell"].split()[0]) >= 360.0
    assert turns[whole] == pytest.approx(np.round(turns[whole]), abs=1e-3)


def test_the_noun_reads_the_schedule_and_its_figures_lie_within_the_forecast(tmp_path: Path) -> None:
    """Recordings made as schedule.csv says, with noise drawn here, give what was forecast."""
    known: dict[str, object] = {
        "noise": "0.002 deg/s/sqrt(Hz)", "fastest": "72 deg/s", "turn_on": "0.003 deg/s", "latitude": "90 deg",
        "u_tilt": "0 deg", "sizes": 3, "longest_dwell": "10 s", "least_runs": 5, "most_runs": 5,
    }  # fmt: skip
    found = ic.plan_rate_table(**known, available="24 h", simulate=0, schedule=str(tmp_path / "schedule.csv"))
    with (tmp_path / "schedule.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    rng, dt = np.random.default_rng([32, 1]), 0.1
    text = ['schema = 2\n[campaign]\nid = "planned"\n[site]\nlatitude = "90 deg"\n[sensors.gyros]\nkind = "gyro"\n'
            'axes = ["x", "y", "z"]\nunit = "deg/s"\n']  # fmt: skip
    names = list(dict.fromkeys(row["recording"] for row in rows))
    for name in names:
        own = [row for row in rows if row["recording"] == name]
        time = np.arange(0.05, float(own[-1]["stop [s]"]) + 5.0, dt)
        rate = np.zeros(len(time))
        for row in own:
            rate[(time >= float(row["start [s]"])) & (time < float(row["stop [s]"]))] = float(row["rate [deg/s]"])
        turned = "xyz".index(own[0]["axis"])
        y = rng.normal(0.0, 0.003, 3) + rng.normal(0.0, 0.002 / math.sqrt(dt), (len(time), 3))
        y[:, turned] += 1.001 * (rate + 7.292115e-5 / DEG)
        np.savetxt(tmp_path / f"{name}.csv", np.column_stack([time, y]), "%.9f", ",", comments="",
                   header="time [s],x [deg/s],y [deg/s],z [deg/s]")  # fmt: skip
        text.append(
            f'[recordings.{name}]\nsensor = "gyros"\nfile = "{name}.csv"\naxis = "{own[0]["axis"]}"\n'
            f'run = "{own[0]["run"]}"\nclock = {{ column = "time" }}\n'
            'channels = { x = { column = "x", unit = "deg/s" }, y = { column = "y", unit = "deg/s" },'
            ' z = { column = "z", unit = "deg/s" } }\n'
            'schedule = { file = "schedule.csv", unit = "deg/s", recording = "recording" }\n'
        )
    text.append(f'[[tests]]\nid = "rates"\nprocedure = "rate_table"\nrecordings = {names!r}\n'
                'plan = { attitude = { tilt = "0 deg" } }\n'.replace("'", '"'))  # fmt: skip
    (tmp_path / "campaign.toml").write_text("".join(text), encoding="utf-8")
    made = {(row["quantity"], row["axis"]): row for row in ic.run(tmp_path).results["results"]}
    for axis in "xyz":
        bias, scale = made["bias", axis], made["scale_factor_error", axis]
        assert bias["u"] == pytest.approx(found.of("bias").u / DEG, rel=0.6)  # of five power-ups
        assert abs(bias["value"]) < 4.5 * found.of("bias").u / DEG
        assert abs(scale["value"] - 0.1) < 4.5 * 100.0 * found.of("scale_factor_error").u


def test_a_sequence_takes_the_schedule(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The steps of a rehearsal are the rows of schedule.csv, with the limits of its bench kept."""
    assert call(capsys, "simulate", "rate_table", "--lab", "-o", str(tmp_path / "lab"))[0] == 0
    found = ic.plan_rate_table(noise="0.002 deg/s/sqrt(Hz)", fastest="4.5 deg/s", sizes=3, longest_dwell="30 s",
                               least_runs=12, most_runs=12, available="200 h", simulate=0,
                               schedule=str(tmp_path / "lab" / "schedule.csv"))  # fmt: skip
    assert found.design.choice["runs"] == "12"
    path = tmp_path / "lab" / "LAB.toml"
    head, _, _ = path.read_text(encoding="utf-8").partition("[[sequence.steps]]")
    steps = (
        '[sequence.schedule]\nfile = "schedule.csv"\nname = "name"\nrecording = "recording"\nprompt = "prompt"\n'
        'set = { "bench.rate" = "rate" }\nrecord = { for = "1 s" }\n'
        'stable = { channel = "rate_dps", follows = "bench.rate", within = "0.001 deg/s", for = "4 s" }\n'
    )
    path.write_text(head + steps, encoding="utf-8")
    status, out, err = call(capsys, "sequence", str(path), "--check")
    assert (status, err) == (0, "")
    assert "216 steps" in out
    assert "and 36 prompts" in out
    fast = path.with_name("schedule.csv").read_text(encoding="utf-8").replace(",4.5,", ",5.5,")
    path.with_name("schedule.csv").write_text(fast, encoding="utf-8")
    assert call(capsys, "sequence", str(path), "--check")[0] == 3  # beyond the limits of the bench


def test_a_bias_that_wanders_costs_less_where_senses_alternate() -> None:
    """The same rates in rising order would leave more of a random walk in the scale factor."""
    found = ic.plan_rate_table(noise="1e-6 deg/s/sqrt(Hz)", walk="0.001 deg/s/sqrt(s)", fastest="100 deg/s",
                               available="24 h", least_runs=5, most_runs=5, longest_dwell="10 s",
                               simulate=0)  # fmt: skip
    programme = laid(found)
    x, middle = programme.rates, 0.5 * (programme.start + programme.stop)

    def slope(rates: np.ndarray) -> float:
        solve = np.linalg.pinv(np.column_stack([np.ones(len(rates)), rates, np.abs(rates)]))[1]
        return float(solve @ np.minimum.outer(middle, middle) @ solve)

    assert slope(x) < 0.35 * slope(np.sort(x))
    u = next(p.u for p in found.of("scale_factor_error").parts if p.label == "random walk of the bias")
    assert u == pytest.approx(math.sqrt(slope(x) * (0.001 * DEG) ** 2 / 5.0), rel=0.05)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "noise"),
        ({"noise": "0.2 deg/sqrt(h)", "fastest": "100 deg/s"}, "nothing is wanted"),
        ({**KNOWN, "wanted": {"drift": "1 deg/s"}}, "no such figure"),
        ({**KNOWN, "wanted": {"bias": "1 deg"}}, "bias="),
        ({**KNOWN, "wanted": {"bias": "0 deg/s"}}, "need more than 0"),
        ({**KNOWN, "available": "1 min"}, "the shortest test"),
        ({**KNOWN, "available": "9 h", "least_runs": 9, "most_runs": 5}, "most_runs is 5"),
        ({**KNOWN, "speed": "9 h"}, "no setting"),
    ],
)
def test_one_clear_message(given: dict[str, object], said: str) -> None:
    with pytest.raises(UsageError) as error:
        ic.plan_rate_table(**given)
    assert said in str(error.value)
