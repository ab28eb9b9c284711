"""Runs of a moved mass that disagree: sign, gain, phase, jumps, and a response that changes within a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.core.remarks import Remark
from inertialcal.physics.motion.schedule import Schedule, repeated
from inertialcal.procedures.mass_attraction.agreement import agreement
from inertialcal.procedures.mass_attraction.plan import Plan
from inertialcal.procedures.mass_attraction.readings import Line, Readings, Run

NG = 9.80665e-9  # [m/s^2]
RESPONSE, NOISE = 0.235, 0.056  # [count/s]
SCHEDULE = repeated([0.29, 0.127, 0.29, 0.432], np.array([44.5, 67.5, 44.5, 21.5]) * NG, cycles=25, dwell=100.0,
                    move=20.0)  # fmt: skip
Spoil = Callable[[Array], Array]


def runs(seed: int, spoil: Spoil | None = None, every: bool = False, walk: float = 0.0) -> Readings:
    """Return four runs; the second is spoiled, or every one."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(4):
        reading = 150.0 + RESPONSE * np.tile([0.0, 1.0, 0.0, -1.0], 25) + NOISE * rng.standard_normal(100)
        reading += walk * np.cumsum(rng.standard_normal(100))
        if spoil is not None and (every or k == 1):
            reading = 150.0 + spoil(reading - 150.0)
        found.append(Run(f"run{k + 1}", SCHEDULE, reading, where=f"run{k + 1}.csv"))
    return Readings(tuple(found))


def found(readings: Readings, plan: Plan | None = None) -> list[Remark]:
    return agreement(plan or Plan(tilt="ignored"), readings)


def late(reading: Array) -> Array:
    """The mass a dwell late throughout: the response is in quadrature."""
    return np.roll(reading, 1)


def gain_from(factor: float, at: int) -> Spoil:
    return lambda reading: np.where(np.arange(len(reading)) < at, reading, factor * reading)


def jump(responses: float, at: int) -> Spoil:
    return lambda reading: reading + RESPONSE * responses * (np.arange(len(reading)) >= at)


@pytest.mark.parametrize(
    ("code", "spoil"),
    [
        ("sign_disagrees", lambda reading: -reading), ("gain_disagrees", lambda reading: 2.0 * reading),
        ("gain_disagrees", lambda reading: 1.5 * reading), ("scale_changed", gain_from(2.0, 52)),
    ],
)  # fmt: skip
@pytest.mark.parametrize("seed", [1, 2])
def test_a_run_that_is_unlike_the_others_is_named_with_its_cause(code: str, spoil: Spoil, seed: int) -> None:
    remarks = found(runs(seed, spoil))
    assert code in [one.code for one in remarks]
    for one in remarks:
        assert one.severity == "error"
        assert "run2" in one.what
        assert one.where == "run2.csv"


def test_a_jump_at_the_same_dwell_of_every_run_is_found_where_it_is() -> None:
    remarks = found(runs(3, jump(2.0, 40), every=True))
    assert {one.code for one in remarks} == {"jump"}
    assert all(abs(one.index - 40) <= 2 for one in remarks)


def test_a_run_in_quadrature_is_refused_by_its_slip_or_named() -> None:
    assert all("run2" in one.what for one in found(runs(4, late)))


def test_half_against_half_names_all_but_by_the_sign_of_the_data_sheet() -> None:
    four = runs(5)
    turned = [replace(one, reading=300.0 - one.reading) for one in four.series[:2]]
    readings = Readings((*turned, *four.series[2:]))
    nominal = RESPONSE / SCHEDULE.amplitude
    assert len(found(readings)) == 4
    by_sheet = found(readings, Plan(tilt="ignored", nominal=nominal))
    assert {(one.code, one.subject) for one in by_sheet} == {("sign_disagrees", "run1"), ("sign_disagrees", "run2")}


def test_lines_reduced_before_are_compared_too() -> None:
    lines = [Line(str(k), 23.0 * NG, RESPONSE * (1.0 + 0.01 * k), 0.01, where=f"runs.csv:{k}") for k in range(4)]
    assert not found(Readings(lines=tuple(lines)))
    lines[2] = replace(lines[2], response=-RESPONSE)
    assert [(one.code, one.where) for one in found(Readings(lines=tuple(lines)))] == [("sign_disagrees", "runs.csv:2")]


@pytest.mark.parametrize("walk", [0.0, 0.1])
def test_sound_runs_are_not_accused(walk: float) -> None:
    """Of 500 simulated campaigns of each kind at most one was: white noise, random walks, smooth drift."""
    assert not [remark for seed in range(12) for remark in found(runs(100 + seed, walk=walk))]


def test_gaps_are_survived() -> None:
    def lossy(reading: Array) -> Array:
        reading = reading.copy()
        reading[[7, 30, 31, 32, 80]] = np.nan
        return reading

    assert not found(runs(6, lossy, every=True))


def test_one_run_or_one_that_cannot_be_fitted_says_nothing() -> None:
    four = runs(7)
    short: Schedule = repeated([0.1, 0.3], np.array([1.0, 2.0]) * NG, cycles=3, dwell=100.0, move=20.0)
    assert not found(Readings((Run("short", short, np.arange(6.0)),)))
    assert not found(Readings(four.series[:1]))
