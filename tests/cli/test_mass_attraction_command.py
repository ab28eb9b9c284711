"""mass-attraction FILE... --schedule S: what it finds, what it refuses, the same from Python."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import InertialcalError
from inertialcal.procedures.mass_attraction.schedule_csv import write_schedule
from inertialcal.rigs import RIGS
from inertialcal.rigs.mesa import rig as mesa
from inertialcal.rigs.mesa.rig import Bench, Run
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.twin import Changes, Twin
from typed_commands import call, same_rows

RUNS = (*(Run(f"run{i}") for i in range(1, 4)), Run("null1", moved=False))
OPTIONS = ("--gate", "100 s", "--column", "x=pulses")
SAID: dict[str, Any] = {"gate": "100 s", "columns": {"x": "pulses"}}


def small(seed: int, changes: Changes) -> Twin:
    return mesa.build(Bench(runs=RUNS, lost=0.0), seed)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(RIGS, "small_mesa", Rig("small_mesa", "", small))
        return simulate("small_mesa", tmp_path_factory.mktemp("moved") / "mesa", 2).folder


def files(folder: Path) -> tuple[str, ...]:
    runs = (str(folder / f"recordings/{run.name}.csv") for run in RUNS)
    return (*runs, "--schedule", str(folder / "schedule.csv"), "--null", "null1")


def test_command_python_and_campaign_give_the_same_rows(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = same_rows(
        capsys, "mass-attraction", [folder / f"recordings/{run.name}.csv" for run in RUNS], tmp_path / "campaign",
        schedule=str(folder / "schedule.csv"), null=["null1.csv"], gate="100 s", tilt="known", mercury="9.2e-10 rad",
        tilt_sign=1, columns={"x": "pulses", "tilt": "tilt_rad"}, scale_factor="10.21 count/s/ug",
        standards={"source_mass.density": "0.3 %", "tilt_meter.mercury": "3e-10 rad"},
    )  # fmt: skip
    assert "relative_to_fixture" not in [one.code for one in found.remarks]
    assert len(list((tmp_path / "campaign" / "recordings").glob("schedule*.csv"))) == 1
    moved = {one.name: one.moved for one in found.result.responses}
    assert moved == {run.name: run.moved for run in RUNS}


def test_like_the_campaign_of_a_rig_it_gives_the_rows_of_the_campaign(folder: Path) -> None:
    paths = [folder / f"recordings/{run.name}.csv" for run in RUNS]
    found = ic.mass_attraction(paths, like=str(folder))
    own = [row for row in run(folder, write=False).results["results"] if row["test"] != "model"]
    named = [{**row.to_dict(), "test": ""} for row in found.rows]
    assert json.loads(json.dumps(named)) == [{**row, "test": ""} for row in json.loads(json.dumps(own))]


def test_options_of_the_mass_hold_with_like_too(folder: Path) -> None:
    paths = [folder / f"recordings/{run.name}.csv" for run in RUNS]
    found = ic.mass_attraction(paths, like=str(folder), null=[paths[0].name])
    assert {one.name: one.moved for one in found.result.responses} == {run.name: run is not RUNS[0] for run in RUNS}
    one = folder / "recordings/run1.csv"
    with pytest.raises(InertialcalError, match="before its schedule"):
        ic.mass_attraction(one, like=str(folder), begin="2010-04-28T23:00:00Z")
    with pytest.raises(InertialcalError, match="the campaign states the gate"):
        ic.mass_attraction(one, like=str(folder), gate="100 s")


def test_python_draws_it(folder: Path) -> None:
    paths = [folder / f"recordings/run{i}.csv" for i in range(1, 4)]
    found = ic.mass_attraction(paths, schedule=str(folder / "schedule.csv"), **SAID)
    assert found.to_frame()["quantity"][0] == "scale_factor"
    assert "scale_factor" in str(found)
    assert found.rows[0].unit == "count/s/ug"
    for name in ("mass_runs", "mass_series", "mass_line"):
        ic.plot(found, figure=name)


def test_the_schedule_may_begin_at_an_instant(folder: Path) -> None:
    """The record of run 1 begins with its schedule; an hour later, the phase is another or nothing fits."""
    one, options = folder / "recordings/run1.csv", SAID | {"schedule": str(folder / "schedule.csv")}
    own = ic.mass_attraction(one, **options)
    same = ic.mass_attraction(one, begin="2010-04-28T20:00:00Z", stamp="end", **options)
    assert same.rows[0].value == pytest.approx(own.rows[0].value)
    with pytest.raises(InertialcalError, match="100 of 100 samples lie in no dwell"):
        ic.mass_attraction(one, begin="2010-04-28T20:00:00Z", **options)
    with pytest.raises(InertialcalError, match="the record ends 30 dwells before its schedule"):
        ic.mass_attraction(one, begin="2010-04-28T21:00:00Z", stamp="end", **options)
    with pytest.raises(InertialcalError, match="begin: "):
        ic.mass_attraction(one, begin="noon", **options)


def test_a_planned_schedule_is_read_with_the_doubt_of_what_it_applies(folder: Path, tmp_path: Path) -> None:
    """From `plan mass-attraction` to the budget, nothing typed again."""
    planned = ic.plan_mass_attraction(
        body={"cube": "20 cm", "count": 18, "stand_off": "10 cm"}, timing={"length": "12000 s"},
        motion={"rig": ["0 cm", "60 cm"], "stroke": ["0 cm", "50 cm"]}, uncertainty={"density": "3 %"},
    )  # fmt: skip
    assert planned.schedule is not None
    write_schedule(tmp_path / "plan.csv", planned.schedule)
    doubt = planned.schedule.u_applied
    assert doubt is not None
    assert doubt >= 0.03
    found = ic.mass_attraction(folder / "recordings/run1.csv", schedule=str(tmp_path / "plan.csv"), **SAID)
    assert "relative_to_fixture" not in [one.code for one in found.remarks]
    estimate = found.result.estimate
    assert estimate is not None
    (part,) = [one for one in estimate.components if one.source == "acceleration applied"]
    assert np.sqrt(part.covariance[0, 0]) == pytest.approx(doubt * abs(estimate.values[0]))
    assert estimate.values[0] * planned.schedule.amplitude == pytest.approx(found.result.responses[0].amplitude)


def test_a_table_without_time_is_a_row_a_dwell(folder: Path, tmp_path: Path) -> None:
    with_time = (folder / "recordings/run1.csv").read_text().splitlines()
    table = tmp_path / "run1.csv"
    table.write_text("\n".join(["pulses [count]", *(line.split(",")[1] for line in with_time[1:])]) + "\n")
    schedule = str(folder / "schedule.csv")
    own = ic.mass_attraction(table, schedule=schedule, gate="100 s")
    same = ic.mass_attraction(folder / "recordings/run1.csv", schedule=schedule, **SAID)
    assert own.rows[0].value == pytest.approx(same.rows[0].value)
    table.write_text("\n".join(table.read_text().splitlines()[:-1]) + "\n")
    with pytest.raises(InertialcalError, match="99 rows, but the schedule has 100 dwells"):
        ic.mass_attraction(table, schedule=schedule, gate="100 s")
    with pytest.raises(InertialcalError, match="a gate of 10 s, rows of dwells of 100 s"):
        ic.mass_attraction(table, schedule=schedule, gate="10 s")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--column", "x=pulses"), 'Add: --gate "GATE s"'),
        (("--gate", "100 s"), "cannot tell which column holds the output of the sensor"),
        (("--gate", "100", "--column", "pulses"), "'100' has no unit"),
        (("--gate=-100 s", "--column", "pulses"), "gate -100 s: need a positive time"),
        ((*OPTIONS, "--begin", "2010-04-28T20:00:00Z"), "100 of 100 samples lie in no dwell"),
        ((*OPTIONS, "--stamp", "late"), "'late' is not one of"),
        ((*OPTIONS, "--reference", "1 V"), '--gate "100 s" is of pulses, reference is of none'),
        (("--column", "x=pulses", "--lsb", "5 V / 4095"), "counts and volts need the scale factor of the sensor"),
        (("--gate", "130 s", "--column", "x=pulses"), "the mass dwells for 100 s"),
        ((*OPTIONS, "--column", "tilt=case_degc"), "unit missing or of the wrong kind: 'case_degc'"),
        ((*OPTIONS, "--null", "null2.csv"), "no such file among those given"),
        ((*OPTIONS, "--tilt", "guessed"), "'guessed' is not one of"),
        ((*OPTIONS, "--tilt-sign", "0"), "tilt-sign"),
        ((*OPTIONS, "--high-g", "1 count/s/ug"), "is not a TOML table"),
        ((*OPTIONS, "--figure", "mass_runs"), "no file for the figure is named"),
    ],
)
def test_what_cannot_be_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], words: str
) -> None:
    status, _, err = call(capsys, "mass-attraction", *files(folder), *options)
    assert status in (2, 3)
    assert words in " ".join(err.split())


def test_a_file_twice_and_a_schedule_that_is_none_are_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = str(folder / "recordings/run1.csv")
    assert call(capsys, "mass-attraction", one, one, "--schedule", str(folder / "schedule.csv"))[0] == 2
    assert call(capsys, "mass-attraction", one, "--schedule", one, *OPTIONS)[0] == 3
    assert call(capsys, "mass-attraction", one, *OPTIONS)[0] == 2


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('gate = "100 s"', 'gate = "10 s"', "the gate of the chain 10 s"),
        ('mass = { schedule = "schedule.csv"', 'mass = { schedule = "other.csv"', "'other.csv' does not exist"),
        ('stand_off = "0.076 m"', 'stand_off = "7.6 m"', "cannot attract more than"),
        ('begin = "2010-04-28T20:00:00Z"', 'begin = "noon"', "mass.begin"),
    ],
)
def test_a_campaign_that_does_not_fit_is_refused(folder: Path, tmp_path: Path, old: str, new: str, words: str) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy)
    file = copy / "campaign.toml"
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(InertialcalError, match=words):
        run(copy, write=False)
