"""Plan of flips: its forecast against heads of another simulator, what an orbit does, its programme, refusals."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import special

import inertialcal as ic
from independent.flip import UG_OF_SI, Head, Programme, turned
from inertialcal.core.errors import UsageError

UG = 1.0 / UG_OF_SI
ONE = {"positions": 2, "least_flips": 1, "most_flips": 1, "simulate": 0, "available": "20 h"}


@pytest.mark.parametrize("n", [20, pytest.param(60, marks=pytest.mark.slow)])
def test_the_forecast_is_the_scatter_of_another_simulator(n: int, tmp_path: Path) -> None:
    """Heads with white noise and flicker, a sample a second, turned once, by the command on their files."""
    white, rate = 20.0, 1.0
    found = ic.plan_flip(noise=f"{white / math.sqrt(rate)} ug/sqrt(Hz)", instability="1 ug", turn="60 s",
                         quiet="600 s", longest_dwell="300 s", **ONE)  # fmt: skip
    assert found.design.choice["dwell"] == "300 s"
    head = Head(white=white, slow=1.0, angle_error=0.0)
    programme = Programme(2, (300.0, 300.0), 60.0, rate, before=600.0)
    errors: dict[str, list[float]] = {"bias": [], "ambient_acceleration": []}
    stated: dict[str, list[float]] = {"bias": [], "ambient_acceleration": []}
    for seed in range(1, n + 1):
        case = turned(seed, head, programme)
        columns = case.tables["head.csv"].columns
        np.savetxt(tmp_path / "head.csv", np.column_stack(list(columns.values())), "%.6f", ",", comments="",
                   header=",".join(columns))  # fmt: skip
        windows = [case.words[k + 1] for k, word in enumerate(case.words) if word == "--window"]
        rows = ic.flip(tmp_path / "head.csv", windows=windows).rows
        for quantity, found_errors in errors.items():
            for row in rows:
                if row.key.quantity == quantity and row.case.plain and row.key.axis in "yz":
                    assert row.value is not None
                    assert row.u is not None
                    found_errors.append(row.value - case.truth[f"{quantity} {row.key.axis}"])
                    stated[quantity].append(row.u)
    for quantity, size in errors.items():
        forecast = found.of(quantity).u / UG
        assert len(size) == 2 * n
        low, high = special.chdtri(2 * n, [0.9995, 0.0005])
        assert low <= float(np.sum(np.square(size))) / forecast**2 <= high, quantity
        assert math.sqrt(np.mean(np.square(stated[quantity]))) == pytest.approx(forecast, rel=0.4), quantity


def test_white_noise_by_the_closed_form() -> None:
    found = ic.plan_flip(noise="5 ug/sqrt(Hz)", longest_dwell="120 s", **ONE)
    dwell = float(found.design.choice["dwell"].split()[0])
    assert found.of("bias").u == pytest.approx(5.0 * UG / math.sqrt(2.0 * dwell), rel=1e-9)


def test_slow_noise_counts_as_far_as_the_dwells_are_not_the_record() -> None:
    given = {"noise": "1e-3 ug/sqrt(Hz)", "walk": "0.1 ug/sqrt(s)", "longest_dwell": "60 s", **ONE}
    bare = ic.plan_flip(**given, quiet="0 s", turn="0 s").of("bias")
    assert [part.label for part in bare.parts] == ["noise"]  # the dwells are the record
    beside = ic.plan_flip(**given, quiet="300 s", turn="0 s").of("bias")
    assert "random walk of the bias" in [part.label for part in beside.parts]


def test_three_positions_take_a_steady_change_out_and_a_swing_is_least_at_its_best_phase() -> None:
    """Over a hundredth of an orbit a swing is a straight line, which dwells at 0, 180 and 0 deg do not see."""
    given = {"noise": "1e-3 ug/sqrt(Hz)", "swing": "1 ug", "orbit": "1000 h", "longest_dwell": "60 s"}
    two, three = (ic.plan_flip(**given, **{**ONE, "positions": n}).of("bias") for n in (2, 3))
    swing = {part.label: part.u for part in two.parts}["swing with the orbit"]
    rate = 2.0 * math.pi / 3.6e6
    assert swing == pytest.approx(1.0 * UG / math.sqrt(2.0) * 0.5 * rate * 120.0, rel=1e-3)  # half of what it changes
    assert {part.label: part.u for part in three.parts}["swing with the orbit"] < 1e-3 * swing
    any_phase, best = (
        ic.plan_flip(noise="1 ug/sqrt(Hz)", swing="1 ug", longest_dwell="600 s", phase=phase, **ONE).of("bias")
        for phase in ("any", "best")
    )
    assert best.u < any_phase.u


def test_standards_and_turn_on_bind_where_no_dwell_helps() -> None:
    found = ic.plan_flip(noise="1 ug/sqrt(Hz)", u_zero="0.2 ug", wanted={"bias": "0.1 ug"}, simulate=0)
    (lost,) = [one for one in found.remarks if one.code == "not_reached"]
    assert "zero of the electronics alone leaves 0.20 ug" in lost.what
    several = ic.plan_flip(noise="1 ug/sqrt(Hz)", turn_on="2 ug", wanted={"bias": "0.9 ug"}, simulate=0)
    assert int(several.design.choice["flips"]) == 5  # 2 / sqrt(5) = 0.894


def test_the_check_simulates_the_programme_and_the_schedule_has_its_dwells(tmp_path: Path) -> None:
    path = tmp_path / "schedule.csv"
    found = ic.plan_flip(noise="5 ug/sqrt(Hz)", instability="0.5 ug", wanted={"bias": "0.5 ug"}, simulate=20,
                         schedule=str(path))  # fmt: skip
    assert [one.code for one in found.remarks if one.severity != "info"] == ["taken_as_exact"]
    beside = found.of("bias").simulated
    assert beside is not None
    assert beside.tests == 20
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert [row["angle [deg]"] for row in rows][:4] == ["0", "0", "180", "180"]
    dwells = [float(row["duration [s]"]) for row in rows if "dwell" in row["name"]]
    assert dwells == [float(found.design.choice["dwell"].split()[0])] * 2
    assert [row["prompt"] for row in rows if row["prompt"]] == ["Turn the head to 180 deg"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"noise": "5 ug/sqrt(Hz)"}, "nothing is wanted"),
        ({"noise": "5 deg/s/sqrt(Hz)"}, "noise"),
        ({"noise": "5 ug/sqrt(Hz)", "wanted": {"drift": "1 ug"}}, "no such figure"),
        ({"noise": "5 ug/sqrt(Hz)", "available": "1 min"}, "the shortest test"),
        ({"noise": "5 ug/sqrt(Hz)", "available": "1 h", "least_flips": 9, "most_flips": 5}, "most_flips is 5"),
    ],
)
def test_one_clear_message(given: dict[str, object], said: str) -> None:
    with pytest.raises(UsageError) as error:
        ic.plan_flip(**given)
    assert said in str(error.value)
