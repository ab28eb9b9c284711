"""Plan of a turned mass: its forecast against simulated tests of another simulator, its programme, what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from independent.orbit.turned_mass import GATE, Bench, whole_test
from inertialcal.core.errors import DataError, UsageError
from inertialcal.physics.motion.turns import Turn, programme_text
from inertialcal.procedures.turned_mass.joining import S, join
from inertialcal.procedures.turned_mass.programme import read_programme, write_programme
from inertialcal.procedures.turned_mass.readings import Run
from inertialcal.procedures.turned_mass.response import responses_of

HOUR = 3600.0
NULLS = (4648.5, 1774.9)  # by W = -n +- sqrt(A / a - 2 n^2), with a mean radius of the earth
FEW_OF = {"periods": ["1 h", "2 h"], "hours": "12 h", "trials": 0}


def test_the_nulls_are_those_of_the_closed_form() -> None:
    found = ic.plan_turned_mass(**FEW_OF)
    assert found.nulls == pytest.approx(NULLS, abs=0.1)
    rows = {(row.key.quantity, row.member and row.member.label): row.value for row in found.rows}
    assert rows["null_period", "with the orbit"] == pytest.approx(NULLS[0], abs=0.1)


def test_the_forecast_is_the_scatter_of_another_simulator() -> None:
    """Scale factors of 40 tests by a simulator in an inertial frame scatter as forecast, within what 40 show."""
    found = ic.plan_turned_mass(**FEW_OF)
    bench, n = Bench(scale_factor=found.wanted.scale_factor), 40
    periods = tuple(math.copysign(one.turn.period, one.turn.rate) for one in found.runs)
    values = []
    for seed in range(1, n + 1):
        made = whole_test(bench, periods, 12.0 * HOUR, np.random.default_rng([34, seed]))
        runs = [
            Run(Turn(f"run{k}", 0.0, one.length, 2.0 * math.pi / one.period, one.angle), one.times, one.reading, GATE)
            for k, one in enumerate(made)
        ]
        values.append(join(responses_of(runs, found.orbit.rate, 2), found.orbit).values[S] / bench.scale_factor)
    # whole pulses of a gate add a noise of their own, of which a seventh of the variance lies below a turn an hour
    size = float(np.std(values, ddof=1))
    assert size == pytest.approx(found.u_noise, rel=3.3 / math.sqrt(2.0 * (n - 1)))
    assert np.mean(values) == pytest.approx(1.0, abs=3.3 * found.u_noise / math.sqrt(n))


def test_simulated_tests_stand_beside_the_forecast() -> None:
    found = ic.plan_turned_mass(**{**FEW_OF, "trials": 20})
    assert found.simulated is not None
    size, n = found.simulated
    assert n == 20
    assert size == pytest.approx(found.u_noise, rel=3.3 / math.sqrt(2.0 * 19))


def test_noise_is_halved_by_four_times_the_hours_and_what_is_wanted_is_reached() -> None:
    short, long = (ic.plan_turned_mass(**{**FEW_OF, "hours": hours, "wanted": "1 %"}) for hours in ("24 h", "96 h"))
    assert long.u_noise == pytest.approx(0.5 * short.u_noise, rel=0.05)
    assert short.needed is not None
    reached = ic.plan_turned_mass(**{**FEW_OF, "hours": f"{short.needed} s"})
    assert reached.u == pytest.approx(0.01, rel=0.05)
    hopeless = ic.plan_turned_mass(**{**FEW_OF, "wanted": "0.01 %"})
    assert hopeless.needed == math.inf
    assert "not_reached" in {one.code for one in hopeless.remarks}


def test_the_sense_is_that_of_the_sign_and_both_without() -> None:
    found = ic.plan_turned_mass(periods=["+1 h", "-2 h", "90 min"], hours="24 h", trials=0)
    assert [one.turn.named for one in found.runs] == ["+1 h", "-2 h", "+1.5 h", "-1.5 h"]


def test_a_run_that_meets_the_orbit_is_named() -> None:
    found = ic.plan_turned_mass(periods=["1 h", "5742 s"], hours="24 h", trials=0)
    assert [one.met for one in found.runs] == [0, 0, 1, 1]
    assert "orbit_line" in {one.code for one in found.remarks}


def test_the_programme_is_written_and_read_back(tmp_path: Path) -> None:
    path = tmp_path / "schedule.csv"
    found = ic.plan_turned_mass(**FEW_OF, schedule=str(path))
    turns = read_programme(path)
    assert [(one.run, one.start, one.stop, one.angle) for one in turns] == [
        (one.turn.run, one.turn.start, one.turn.stop, one.turn.angle) for one in found.runs
    ]
    rates = [one.rate for one in turns]
    assert rates == pytest.approx([one.turn.rate for one in found.runs], rel=1e-15)
    assert turns[1].start > turns[0].stop


@pytest.mark.parametrize(
    ("rows", "code"),
    [
        ("a,0,100,0.1,0\na,200,300,0.1,0", "schedule"),
        ("a,0,100,0.1,0\nb,50,300,0.1,0", "schedule"),
        ("a,100,100,0.1,0", "schedule"),
        ("a,0,100,0,0", "wrong_rate"),
        ("a,0,100,360,0", "wrong_rate"),
        ("a,0,100,,0", "missing"),
        (",0,100,1,0", "schedule"),
    ],
)
def test_a_programme_that_cannot_be_meant_is_refused_with_its_row(tmp_path: Path, rows: str, code: str) -> None:
    path = tmp_path / "s.csv"
    path.write_text(f"run,start [s],stop [s],rate [deg/s],angle [deg]\n{rows}\n", encoding="utf-8")
    with pytest.raises(DataError) as caught:
        read_programme(path)
    assert caught.value.problems[0].code == code
    assert "s.csv" in caught.value.problems[0].where


def test_columns_without_a_unit_are_refused_and_other_units_read(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    path.write_text("run,start [h],stop [h],rate [rad/s],angle [rad]\na,0,24,0.001,1\n", encoding="utf-8")
    (turn,) = read_programme(path)
    assert (turn.stop, turn.rate, turn.angle) == (86400.0, 0.001, 1.0)
    path.write_text("run,start [s],stop [s],rate,angle [rad]\na,0,24,0.001,1\n", encoding="utf-8")
    with pytest.raises(DataError, match=r"column 'rate' has no unit"):
        read_programme(path)


def test_a_programme_is_the_same_text_twice(tmp_path: Path) -> None:
    turns = (Turn("run1", 0.0, 10.0, 0.1),)
    write_programme(tmp_path / "s.csv", turns, ("a note",))
    assert (tmp_path / "s.csv").read_text(encoding="utf-8") == programme_text(turns, ("a note",))
    assert programme_text(turns, ("a note",)).startswith("# a note\nrun,start [s]")


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"periods": ["1 kg"]}, "periods '1 kg'"),
        ({"periods": ["0 h"]}, "not a time of a turn"),
        ({"periods": ["+1 h"]}, "cannot be told apart"),
        ({"hours": "3 h"}, "turns"),
        ({"speed": "1 h"}, "no setting 'speed'"),
        ({"mass": "-4 kg"}, "mass"),
    ],
)
def test_what_cannot_be_meant_is_refused(given: dict[str, object], match: str) -> None:
    with pytest.raises(UsageError, match=match):
        ic.plan_turned_mass(**given)
