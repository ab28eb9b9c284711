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
from inertialcal.rigs.protocol import Changes, Rig, Twin
from typed_commands import call

RUNS = (*(Run(f"run{i}") for i in range(1, 4)), Run("null1", moved=False))
OPTIONS = ("--gate", "100 s", "--column", "pulses", "--unit", "pulses=count")


def small(seed: int, changes: Changes) -> Twin:
    return mesa.build(Bench(runs=RUNS, lost=0.0), seed)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(RIGS, "small_mesa", Rig("small_mesa", "", small))
        return simulate("small_mesa", tmp_path_factory.mktemp("moved") / "mesa", 2).folder


def files(folder: Path) -> tuple[str, ...]:
    moved = (str(folder / f"recordings/run{i}.csv") for i in range(1, 4))
    return (*moved, "--schedule", str(folder / "schedule.csv"), "--null", str(folder / "recordings/null1.csv"))


KNOWN = ("--tilt", "tilt_rad", "--tilt-is", "known", "--mercury", "9.2e-10 rad", "--nominal", "10.21 count/s/ug")


def test_it_gives_what_the_campaign_gives(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = call(capsys, "mass-attraction", *files(folder), *OPTIONS, *KNOWN, "--json")
    assert status == 0
    rows = {(row["quantity"], row["condition"]): row for row in json.loads(out)["results"]}
    shown = {(row["quantity"], row["condition"]): row for row in run(folder, write=False).results["results"]}
    for key in (("scale_factor", "run run1 alone"), ("null_response", "run null1 alone")):
        assert rows[key]["unit"] == shown[key]["unit"]
        assert rows[key]["u"] == pytest.approx(shown[key]["u"], rel=1e-6)
    assert rows["scale_factor", ""]["value"] == pytest.approx(shown["scale_factor", ""]["value"], rel=1e-9)


def test_python_gives_the_same_and_draws_it(folder: Path, tmp_path: Path) -> None:
    paths = [folder / f"recordings/run{i}.csv" for i in range(1, 4)]
    found = ic.mass_attraction(paths, folder / "schedule.csv", column="pulses", gate="100 s", units={"pulses": "count"})
    assert found.to_frame()["quantity"][0] == "scale_factor"
    assert "scale_factor" in str(found)
    assert found.rows[0].unit == "count/s/ug"
    for name in ("mass_runs", "mass_series", "mass_line"):
        ic.plot(found, figure=name)


def test_the_schedule_may_begin_when_it_is_said_to(folder: Path) -> None:
    """The record of run 1 begins with its schedule; said an hour later, the phase is another or nothing fits."""
    one = folder / "recordings/run1.csv"
    options: dict[str, Any] = {"column": "pulses", "gate": "100 s", "units": {"pulses": "count"}}
    own = ic.mass_attraction(one, folder / "schedule.csv", **options)
    same = ic.mass_attraction(one, folder / "schedule.csv", begin="2010-04-28T20:00:00Z", stamp="end", **options)
    assert same.rows[0].value == pytest.approx(own.rows[0].value)
    with pytest.raises(InertialcalError, match="100 of 100 samples lie in no dwell"):
        ic.mass_attraction(one, folder / "schedule.csv", begin="2010-04-28T20:00:00Z", **options)
    with pytest.raises(InertialcalError, match="the record ends 30 dwells before its schedule"):
        ic.mass_attraction(one, folder / "schedule.csv", begin="2010-04-28T21:00:00Z", stamp="end", **options)
    with pytest.raises(InertialcalError, match="begin: "):
        ic.mass_attraction(one, folder / "schedule.csv", begin="noon", **options)


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
    found = ic.mass_attraction(folder / "recordings/run1.csv", tmp_path / "plan.csv", column="pulses", gate="100 s",
                               units={"pulses": "count"})  # fmt: skip
    assert "relative_to_fixture" not in [one.code for one in found.remarks]
    estimate = found.result.estimate
    assert estimate is not None
    (part,) = [one for one in estimate.components if one.source == "acceleration applied"]
    assert np.sqrt(part.covariance[0, 0]) == pytest.approx(doubt * abs(estimate.values[0]))
    assert estimate.values[0] * planned.schedule.amplitude == pytest.approx(found.responses[0].amplitude)


def test_a_table_without_time_is_a_row_a_dwell(folder: Path, tmp_path: Path) -> None:
    with_time = (folder / "recordings/run1.csv").read_text().splitlines()
    table = tmp_path / "run1.csv"
    table.write_text("\n".join(["pulses [count]", *(line.split(",")[1] for line in with_time[1:])]) + "\n")
    own = ic.mass_attraction(table, folder / "schedule.csv", gate="100 s")
    same = ic.mass_attraction(folder / "recordings/run1.csv", folder / "schedule.csv", column="pulses", gate="100 s",
                              units={"pulses": "count"})  # fmt: skip
    assert own.rows[0].value == pytest.approx(same.rows[0].value)
    table.write_text("\n".join(table.read_text().splitlines()[:-1]) + "\n")
    with pytest.raises(InertialcalError, match="99 rows, but the schedule has 100 dwells"):
        ic.mass_attraction(table, folder / "schedule.csv", gate="100 s")
    with pytest.raises(InertialcalError, match="a gate of 10 s, rows of dwells of 100 s"):
        ic.mass_attraction(table, folder / "schedule.csv", gate="10 s")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--column", "pulses", "--unit", "pulses=count"), "nothing says for how long they were counted"),
        (("--gate", "100 s"), "no column is clearly that of the pulses"),
        (("--gate", "100"), "gate: '100'"),
        (("--gate=-100 s",), "gate: '-100 s' It must be above zero"),
        ((*OPTIONS, "--nominal=-10 count/s/ug"), "nominal: '-10 count/s/ug' It must be above zero"),
        ((*OPTIONS, "--begin", "2010-04-28T20:00:00Z"), "one begin of the schedule"),
        ((*OPTIONS, "--stamp", "late"), "stamp 'late' There are: start, middle, end"),
        ((*OPTIONS, "--stamp", "end"), "whatever its stamp is"),
        (("--gate", "130 s", "--column", "pulses", "--unit", "pulses=count"), "the mass dwells for 100 s"),
        ((*OPTIONS, "--tilt", "case_degc"), "has no unit of tilt"),
        ((*OPTIONS, "--tilt", "tilt_rad", "--tilt-is", "known"), "needs the nominal scale factor"),
        ((*OPTIONS, "--tilt-is", "guessed"), "There are: regressed, known, ignored"),
        ((*OPTIONS, "--u-high-g", "1 count/s/ug"), "Say --high-g"),
        ((*OPTIONS, "--in", "deg"), "no unit of acceleration"),
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
    assert call(capsys, "mass-attraction", one, "--schedule", one)[0] == 3


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
