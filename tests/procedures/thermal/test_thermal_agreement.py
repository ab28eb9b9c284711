"""Runs over temperature that disagree: sign, unit, another curve; sound ones are silent."""

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.remarks import Remark
from inertialcal.procedures.thermal.fit.agreement import disagreements
from inertialcal.procedures.thermal.fit.cells import cells_of, series_of
from inertialcal.procedures.thermal.plan import Plan
from inertialcal.procedures.thermal.recordings import Readings, Sweep

TEMPERATURE = np.concatenate([np.linspace(20, -20, 400), np.linspace(-20, 60, 800), np.linspace(60, 20, 400)])


def bench(runs: int, seed: int = 1, slope: float = 2e-4) -> Readings:
    """Return sweeps of a gyro with offsets of their own."""
    rng = np.random.default_rng(seed)
    away = TEMPERATURE - 20.0
    sweeps = []
    for number in range(1, runs + 1):
        own = slope + 1e-6 * rng.standard_normal()
        y = 0.02 + own * away + 3e-6 * (slope > 0.0) * away**2
        y = y + 0.003 * rng.standard_normal() + 0.002 * rng.standard_normal(len(away))
        time = np.arange(0.0, 10.0 * len(y), 10.0)
        name = f"run{number}"
        sweeps.append(Sweep(name, name, f"{name}.csv", time, {"x": TEMPERATURE}, {"x": np.radians(y)}))
    return Readings(tuple(sweeps))


def found(readings: Readings) -> list[Remark]:
    """Return what disagrees."""
    return disagreements("x", cells_of(Plan(), series_of(Plan(), readings, "x")), readings)


def changed(readings: Readings, run: int, change: object) -> Readings:
    """Return the readings, those of a run changed."""
    sweeps = list(readings.sweeps)
    sweeps[run] = replace(sweeps[run], outputs={"x": change(sweeps[run].outputs["x"])})  # type: ignore[operator]
    return replace(readings, sweeps=tuple(sweeps))


@pytest.mark.parametrize("runs", [1, 3])
def test_a_stuck_channel(runs: int) -> None:
    """Its bias would be known to nothing at all."""
    remarks = found(changed(bench(runs), 0, lambda y: np.full_like(y, 1.234e-4)))
    assert [(one.code, one.severity, one.where) for one in remarks] == [("constant", "error", "run1.csv")]


@pytest.mark.parametrize("runs", [3, 5])
@pytest.mark.parametrize(("factor", "code"), [(-1.0, "sign_disagrees"), (np.pi / 180.0, "unit_disagrees")])
def test_one_run_of_several(runs: int, factor: float, code: str) -> None:
    """It alone is named, with its file."""
    remarks = found(changed(bench(runs), 1, lambda y: factor * y))
    assert [(one.code, one.severity, one.where) for one in remarks] == [(code, "error", "run2.csv")]


@pytest.mark.parametrize(("factor", "code"), [(-1.0, "sign_disagrees"), (np.pi / 180.0, "unit_disagrees")])
def test_of_two_runs_nothing_tells_which(factor: float, code: str) -> None:
    """Both are named."""
    assert [one.code for one in found(changed(bench(2), 1, lambda y: factor * y))] == [code] * 2


def test_a_flat_bias_shows_its_unit_by_its_noise() -> None:
    """The curve says nothing."""
    assert [one.code for one in found(changed(bench(4, slope=0.0), 2, np.radians))] == ["unit_disagrees"]


def test_another_curve() -> None:
    """A run that bends the other way by far."""
    bend = np.radians(2e-5 * (TEMPERATURE - 20.0) ** 2)
    remarks = found(changed(bench(5), 0, lambda y: y + bend))
    assert [(one.code, one.severity, one.where) for one in remarks] == [("run_differs", "error", "run1.csv")]


@pytest.mark.parametrize("runs", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("slope", [2e-4, 0.0])
def test_sound_runs_are_silent(runs: int, slope: float) -> None:
    """Offsets and slopes of their own, flat or not."""
    for seed in range(5):
        assert not found(bench(runs, seed, slope))
