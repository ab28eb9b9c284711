"""Positions in a campaign: from the files that `init` finds to models of both sensors, judged on a record held out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from inertialcal.campaign.engine.engine import prepare
from inertialcal.campaign.engine.run import Outcome, run
from inertialcal.campaign.engine.whole import check
from inertialcal.campaign.start.starter import start
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.core.campaign_text import MARK
from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.recording import Recording
from inertialcal.core.results import Row
from inertialcal.files.models.model_json import read_model
from inertialcal.procedures.positions import reduction as positions
from inertialcal.procedures.positions.closed_loop import as_read, before_and_after, judges_of, loops_of, mixed_up
from inertialcal.report.figures.campaign import budget
from inertialcal.report.figures.campaign.budget import MOST
from inertialcal.report.plot import plot
from inertialcal.rigs.hand_held.rig import Bench, build
from inertialcal.statistics.closed_loop import judged, overall
from positions_truths import CUBE, FIXTURE_PLAN

BENCH = Bench(positions=16, dwell=2.5, first=4.0, records=2)
GYRO = ("gyro x at rest", "gyro y at rest", "gyro z at rest", "gyro, rotations")
REQUIRED = '\n[[requirements]]\nid = "R1"\nquantity = "transition_error"\ntests = ["imu_held_out"]\nupper = "2 deg"\n'


def with_units(recording: Recording) -> Recording:
    """Return a recording whose header says its units."""
    units = {"acc": "m/s2", "gyro": "rad/s"}
    named = tuple(replace(c, name=f"{c.name} [{units[c.name[:-2]]}]") for c in recording.channels)
    return replace(recording, channels=named)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two records of a unit and the campaign file that `init` writes for them."""
    made = tmp_path_factory.mktemp("laid")
    for number, recording in enumerate(build(BENCH, 1).recordings.values(), 1):
        (made / f"hand{number}.csv").write_text(csv_text(with_units(recording)), encoding="utf-8")
    path, lines, _ = start(made)
    text = path.read_text(encoding="utf-8")
    assert len(lines) == 4  # maker, part, serial, gravity
    text = text.replace('gravity = "9.80665 m/s2"', 'gravity = "9.807 m/s2"').replace(f"  {MARK}", "")
    path.write_text(text + REQUIRED, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def outcome(folder: Path) -> Outcome:
    return run(folder)


def test_models_of_both_sensors_are_made_and_judged(folder: Path, outcome: Outcome) -> None:
    loop = outcome.results["closed_loop"]
    assert [one["axis"] for one in loop["axes"]] == ["accelerometer", *GYRO]
    assert [one["unit"] for one in loop["axes"]] == ["m/s^2", *["rad/s"] * 3, "deg"]
    assert all(one["verdict"] == "PASS" for one in loop["axes"])
    assert all(one["compensated_rms"] < 0.3 * one["raw_rms"] for one in loop["axes"])
    assert outcome.verdict == "PASS"
    acc, gyro = (read_model(folder / "out" / name) for name in ("model.json", "model_gyro.json"))
    assert (acc.kind, gyro.kind, acc.judged, gyro.judged) == ("accelerometer", "gyro", True, True)
    assert acc.provenance["bias_x"].recordings == ("acc_hand1", "gyro_hand1")
    true = {(one.quantity, one.axis): one.value for one in build(BENCH, 1).truth if one.sensor == "accelerometer"}
    assert acc.bias[0] == pytest.approx(true["bias", "x"], abs=0.01)
    assert acc.matrix[0][2, 0] == pytest.approx(true["misalignment", "zx"], abs=2e-3)


def test_one_test_gives_results_and_models_of_both_sensors_from_one_reduction(folder: Path, outcome: Outcome) -> None:
    found = [Row.from_dict(row) for row in outcome.results["results"] if row["test"] == "imu"]
    units = {(row.key.sensor, row.quantity): row.unit for row in found}
    assert units["accelerometer", "bias"] == "m/s^2"
    assert units["gyro", "bias"] == "rad/s"
    assert units["gyro", "transition_error"] == "rad"
    assert ("accelerometer", "g_sensitivity") not in units
    bias = {(row.key.sensor, row.axis): row.value for row in found if row.quantity == "bias"}
    for sensor, name in (("accelerometer", "model.json"), ("gyro", "model_gyro.json")):
        model = read_model(folder / "out" / name)
        assert [bias[sensor, axis] for axis in "xyz"] == list(model.bias)
    prepared = prepare(check(folder).campaign, 0)
    whole = positions.reduce(prepared.plan, prepared.readings)
    assert {(r.key.sensor, r.axis): r.value for r in whole.rows() if r.quantity == "bias"} == bias
    curves = [(one["name"], one["test"]) for one in outcome.results["curves"]]
    assert [one for one in curves if one[1] == "imu"] == [("positions", "imu"), ("transitions", "imu")]
    assert [one["keys"][0]["sensor"] for one in outcome.results["covariances"]] == ["accelerometer", "gyro"] * 2
    assert {row["influence"] for row in outcome.results["standards"]} >= {"value", "rate"}  # told, as not stated
    json.dumps(outcome.results, allow_nan=False)


def test_report_shows_positions_and_transitions(folder: Path, outcome: Outcome) -> None:
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    for figure in ("positions_sphere", "positions_residuals", "transitions"):
        assert f'id="fig-{figure}-' in page
    assert "g-sensitivity" in page
    assert "the closed loop was not run" not in page
    assert outcome.inputs["hand1.csv"] in page
    assert "<bdi>accelerometer</bdi>" in page
    assert "model_gyro" in page


def test_the_budget_figure_has_a_bar_a_quantity_of_each_sensor(outcome: Outcome) -> None:
    rows = [row for row in outcome.results["budgets"] if row["test"] == "imu"]
    bars = {(row["quantity"], row["axis"], row["sensor"]) for row in rows}
    ax = plot(outcome.results, figure="budget", test="imu")
    assert len(bars) == 9 + 21
    assert len(ax.get_yticks()) == MOST  # the rest is counted beside it
    (picture,) = budget.pictures({"budgets": rows})
    assert picture.note == (" Eighteen quantities more: see the tables.",)  # 30 less 12
    ends = {round(one.get_y(), 3): one.get_x() + one.get_width() for one in ax.patches}
    assert list(ends.values()) == pytest.approx([100.0] * MOST)


def test_a_model_that_is_mixed_up_fails(folder: Path) -> None:
    fitted, held = (prepare(check(folder).campaign, number) for number in (0, 1))
    result = positions.reduce(fitted.plan, fitted.readings)
    assert result.gyro is not None
    right = judged(loops_of(result, [held.readings], "gyro"))
    assert [one.verdict for one in right] == ["PASS"] * 4
    assert [one.unit for one in right] == ["rad/s"] * 3 + ["rad"]
    sensor = result.gyro.sensor
    judges, own = (judges_of(result, one, "gyro") for one in (held.readings, result.readings))
    named = {one.name: one for one in own}
    for name, values in mixed_up(sensor.values, full=True).items():
        wrong = judged(before_and_after(sensor, values, judges, named, 1))
        assert overall(wrong) == "FAIL", name
        assert not any(one.verdict == "PASS" and one.compensated > one.raw for one in wrong)
    opposite = mixed_up(sensor.values, full=True)["the bias with its sign turned"]
    turned = judged(before_and_after(sensor, opposite, judges, named, 1))
    assert {one.reason for one in turned if one.verdict == "FAIL"} >= {
        "the bias with its sign turned does better on hold-out readings: the model is mixed up"
    }
    acc = result.acc.sensor
    judges, own = (judges_of(result, one, "accelerometer") for one in (held.readings, result.readings))
    for name, values in mixed_up(acc.values, full=False).items():
        wrong = judged(before_and_after(acc, values, judges, {own[0].name: own[0]}, 1))
        assert wrong[0].verdict == "FAIL", name


def test_a_model_that_corrects_nothing_neither_passes_nor_fails(folder: Path) -> None:
    fitted, held = (prepare(check(folder).campaign, number) for number in (0, 1))
    result = positions.reduce(fitted.plan, fitted.readings)
    assert result.gyro is not None
    sensor = result.gyro.sensor
    loops = judged(before_and_after(sensor, as_read(sensor), judges_of(result, held.readings, "gyro"), {}, 1))
    assert {one.gain for one in loops} == {0.0}
    assert {one.verdict for one in loops} == {"INCONCLUSIVE"}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('recordings = ["acc_hand1", "gyro_hand1"]', 'recordings = ["gyro_hand1"]', "no recording of accelerometers"),
        (
            'recordings = ["acc_hand1", "gyro_hand1"]',
            'recordings = ["acc_hand2", "gyro_hand1"]',
            "use the same readings",
        ),
        (
            'file = "hand1.csv"\n',
            'file = "hand1.csv"\norientations = ["x+", "x-"]\n',
            "2 orientations for 16 positions",
        ),
        ('file = "hand1.csv"\n', 'file = "hand1.csv"\norientations = ["faces"]\n', "deg away from any face"),
        ('id = "imu"\n', 'id = "imu"\nplan = { turns = 3 }\n', "unknown key plan.turns"),
        ('use = "hold_out"', 'use = "fit"', "both give scale factor and misalignment and bias of one sensor"),
    ],
)
def test_a_mistake_in_the_campaign_is_named(folder: Path, tmp_path: Path, old: str, new: str, said: str) -> None:
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    assert old in text
    for name in ("hand1.csv", "hand2.csv"):
        (tmp_path / name).hardlink_to(folder / name)
    (tmp_path / "campaign.toml").write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises((DataError, PlanError)) as refused:
        run(tmp_path, write=False)
    assert said in str(refused.value)


def test_a_unit_laid_anew_is_judged_with_both_mountings() -> None:
    """The mounting of the fixture is one error in the fit and in what is held out, and two where it was laid anew."""
    fitted, held = (
        positions.reduce(FIXTURE_PLAN, positions.simulate(FIXTURE_PLAN, CUBE, np.random.default_rng(seed)))
        for seed in (1, 2)
    )
    one, other = (
        {loop.axis: loop for loop in loops_of(fitted, [held.readings], "accelerometer", remounted)}
        for remounted in (False, True)
    )
    assert one.keys() == other.keys()
    wider = [name for name in one if other[name].allowed > 1.2 * one[name].allowed]
    assert wider  # the length of gravity does not feel a mounting, its components do
    assert all(other[name].u >= one[name].u for name in one)
