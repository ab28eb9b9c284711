"""Runs and readings of a rate table that disagree: each mistake is named, with its run; sound campaigns are silent."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.key import AXES
from inertialcal.core.remarks import Remark
from inertialcal.procedures.rate_table.agreement import agreement_many
from inertialcal.procedures.rate_table.plan import Plan
from inertialcal.procedures.rate_table.readings import Readings

RATES = np.radians([-10.0, -5.0, -2.0, 2.0, 5.0, 10.0])
MATRIX = np.array([[1.004, 0.002, -0.001], [0.001, 0.997, 0.003], [-0.002, 0.001, 1.001]])


def campaign(
    seed: int = 1, runs: int = 5, axes: str = "xyz", rates: np.ndarray = RATES, noise: float = 0.002, k3: float = 0.0
) -> Readings:
    """Return the dwells of runs about each axis, with a bias of its own in each; noise of a dwell [deg/s]."""
    rng = np.random.default_rng(seed)
    applied, axis, run, parts = [], [], [], []
    for name in axes:
        for number in range(runs):
            rate = np.outer(rates, np.eye(3)[AXES.index(name)]) @ MATRIX.T
            offset = np.radians(0.05 * rng.standard_normal(3) + noise * rng.standard_normal((len(rates), 3)))
            parts.append(rate + k3 * rate**3 + offset)
            applied.append(rates)
            axis += [name] * len(rates)
            run += [f"{name}{number + 1}"] * len(rates)
    y = np.concatenate(parts)
    return Readings(
        np.concatenate(applied),
        np.array(axis),
        dict(zip(AXES, y.T, strict=True)),
        run=np.array(run),
        where=tuple(f"t.csv:{i + 2}" for i in range(len(y))),
        sensors=AXES,
    )


def spoiled(readings: Readings, run: str, factor: float) -> Readings:
    """Return the readings, those of a run multiplied."""
    times = np.where(readings.run == run, factor, 1.0)
    return replace(readings, outputs={s: y * times for s, y in readings.outputs.items()})


def found(readings: Readings, plan: Plan | None = None) -> Sequence[Remark]:
    """Return what disagrees."""
    return agreement_many([(plan or Plan(), readings)])[0]


@pytest.mark.parametrize(
    ("factor", "code", "says"),
    [
        (-1.0, "sign_disagrees", "the sign is inverted"),
        (np.pi / 180.0, "unit_disagrees", "readings in rad/s, taken for deg/s"),
        (180.0 / np.pi, "unit_disagrees", "readings in deg/s, taken for rad/s"),
        (1.02, "gain_disagrees", "the other runs"),
        (1.5, "gain_disagrees", "which should be 1"),
    ],
)
def test_one_run_of_five(factor: float, code: str, says: str) -> None:
    """The run is named, and nothing else."""
    remarks = found(spoiled(campaign(), "y3", factor))
    assert [remark.code for remark in remarks] == [code]
    assert remarks[0].severity == "error"
    assert "run y3 about y" in remarks[0].what
    assert says in remarks[0].what
    assert remarks[0].where == "t.csv:44"


@pytest.mark.parametrize("factor", [-1.0, np.pi / 180.0, 1.2])
@pytest.mark.parametrize("runs", [1, 2, 5])
def test_all_runs_about_an_axis_are_judged_against_the_nominal(factor: float, runs: int) -> None:
    """A single run, and runs that all have the same mistake: one remark."""
    readings = campaign(runs=runs, axes="x")
    assert readings.run is not None
    for run in np.unique(readings.run):
        readings = spoiled(readings, str(run), factor)
    remarks = found(readings)
    assert len(remarks) == 1
    assert ("all" in remarks[0].what) == (runs > 1)


def test_nearly_half_of_the_runs() -> None:
    """Two of five in rad/s."""
    remarks = found(spoiled(spoiled(campaign(), "x1", np.pi / 180.0), "x4", np.pi / 180.0))
    assert [(one.code, one.subject) for one in remarks] == [
        ("unit_disagrees", "run x1 about x"),
        ("unit_disagrees", "run x4 about x"),
    ]


def test_files_of_two_axes_that_were_exchanged() -> None:
    """Both runs are named, with the axis that was turned."""
    readings = campaign()
    axis = readings.axis.copy()
    axis[readings.run == "x2"], axis[readings.run == "y2"] = "y", "x"
    remarks = found(replace(readings, axis=axis))
    assert [one.code for one in remarks] == ["axes_disagree"] * 2
    assert "x was turned, but y reads +0.99" in remarks[1].what or "x was turned, but y reads +0.99" in remarks[0].what


@pytest.mark.parametrize(("runs", "off", "severity"), [(5, 100.0, "error"), (1, 100.0, "error"), (5, 0.05, "warning")])
def test_one_reading(runs: int, off: float, severity: str) -> None:
    """It is named by its row; a small one is a warning."""
    readings = campaign(runs=runs)
    outputs = {s: y.copy() for s, y in readings.outputs.items()}
    outputs["x"][3] += np.radians(off)
    remarks = found(replace(readings, outputs=outputs))
    assert [(one.code, one.severity, one.where) for one in remarks] == [("reading_disagrees", severity, "t.csv:5")]


@pytest.mark.parametrize(("rates", "limit"), [((2, 5, 10), 9.0), ((2, 5, 10), 7.5), ((1, 2, 3, 5, 6), 5.5),
                                              ((1, 2, 3, 4, 5, 8, 10), 6.0)])  # fmt: skip
@pytest.mark.parametrize("runs", [1, 5])
def test_means_that_saturate(rates: tuple[float, ...], limit: float, runs: int) -> None:
    """The highest rate, or the two highest, both ways; other axes are not touched. One run shows what is large."""
    both = np.radians([*(-rate for rate in reversed(rates)), *rates])
    readings = campaign(runs=runs, rates=both)
    clipped = np.clip(readings.outputs["y"], -np.radians(limit), np.radians(limit))
    remarks = found(replace(readings, outputs={**readings.outputs, "y": clipped}))
    assert [(one.code, one.axis) for one in remarks] == [("saturated", "y")]


def test_readings_that_are_the_applied_rates() -> None:
    """A column of commanded rates is no reading."""
    readings = campaign(runs=1, axes="x")
    remarks = found(replace(readings, outputs={**readings.outputs, "x": readings.applied.copy()}))
    assert [one.code for one in remarks] == ["copy_of_applied"]


def test_copies_in_a_table_of_means_are_named_once_a_run() -> None:
    """One power-up turns the unit about each axis in its turn."""
    readings = campaign(runs=2)
    readings = replace(readings, run=np.array([one[1] for one in np.asarray(readings.run)]))
    copies = {s: np.where(readings.axis == s, readings.applied, y) for s, y in readings.outputs.items()}
    remarks = found(replace(readings, outputs=copies))
    assert [(one.code, one.subject) for one in remarks] == [("copy_of_applied", "run 1"), ("copy_of_applied", "run 2")]
    assert all("x and y and z hold the rates of the table" in one.what for one in remarks)


def test_a_reading_at_the_rail_is_left_out_and_not_named() -> None:
    """The rules that leave dwells out come first."""
    readings = campaign()
    outputs = {s: np.minimum(y, np.radians(6.0)) for s, y in readings.outputs.items()}
    assert not found(replace(readings, outputs=outputs), Plan(input_range=(-np.radians(6.0), np.radians(6.0))))


@pytest.mark.parametrize("runs", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("case", ["plain", "cubic", "one axis", "few rates", "low rates", "missing"])
def test_sound_campaigns_are_silent(runs: int, case: str) -> None:
    """Offsets of the runs, curvature, few runs, few and low rates, samples left out."""
    given = {
        "cubic": {"k3": 2.0}, "one axis": {"axes": "z"}, "few rates": {"rates": RATES[[0, 2, 5]]},
        "low rates": {"rates": 0.005 * RATES, "noise": 0.02},
    }.get(case, {})  # fmt: skip
    for seed in range(10):
        readings = campaign(seed, runs, **given)  # type: ignore[arg-type]
        if case == "missing":
            gone = np.random.default_rng(seed).random(len(readings)) < 0.1
            readings = replace(readings, outputs={s: np.where(gone, np.nan, y) for s, y in readings.outputs.items()})
        assert not found(readings)


def test_runs_at_other_rates_are_not_compared() -> None:
    """A curved sensor reads another slope at low rates: no mistake."""
    fast, slow = campaign(1, 3, "x", k3=1.0), campaign(2, 3, "x", 0.2 * RATES, k3=1.0)
    assert fast.run is not None
    assert slow.run is not None
    both = Readings(
        np.concatenate([fast.applied, slow.applied]),
        np.concatenate([fast.axis, slow.axis]),
        {s: np.concatenate([fast.outputs[s], slow.outputs[s]]) for s in AXES},
        run=np.concatenate([fast.run, np.char.add("slow ", slow.run.astype(str))]),
        sensors=AXES,
    )
    assert not found(both)
