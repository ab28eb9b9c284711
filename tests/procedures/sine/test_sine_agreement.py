"""Recordings of a drive that disagree: sign, gain, jumps, and a response that changes within one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.physics.motion.schedule import repeated
from inertialcal.procedures.sine.agreement import agreement
from inertialcal.procedures.sine.inputs import Driven, driven_by_schedule, driven_by_sine
from inertialcal.procedures.sine.plan import Plan
from inertialcal.procedures.sine.reduction import Readings, reduce

N, PERIOD, AMPLITUDE, NOISE = 2000, 40.0, 23.0, 10.0
PLAN = Plan(period=PERIOD, phase=0.0)
Spoil = Callable[[Array], Array]
AT = np.arange(N)


def recorded(y: Array, name: str) -> Recording:
    stamps = np.arange(len(y), dtype=np.int64) * 1_000_000_000
    return Recording((Channel("x", y, "m/s^2", axis="x"),), stamps, 1.0, source=Source(f"{name}.csv"))


def by_sine(seed: int, spoil: Spoil | None = None, phase: float | None = 0.0) -> Driven:
    rng = np.random.default_rng(seed)
    y = AMPLITUDE * np.sin(2.0 * np.pi * AT / PERIOD) + NOISE * rng.standard_normal(N)
    y += 0.2 * np.cumsum(rng.standard_normal(N))
    one = recorded(y if spoil is None else spoil(y), "driven")
    return replace(driven_by_sine(one, one.channels[0], PERIOD, phase), name="driven", where="driven.csv")


def by_schedule(k: int, factor: float) -> Driven:
    rng = np.random.default_rng(k)
    schedule = repeated([0.1, 0.2, 0.1, 0.3], np.array([0.0, 1.0, 0.0, -1.0]), cycles=25, dwell=20.0, move=0.0)
    y = factor * np.repeat(schedule.applied, 20) + 0.5 * rng.standard_normal(N)
    one = recorded(y, f"run{k}")
    made = driven_by_schedule(one, one.channels[0], schedule, "schedule.csv")
    return replace(made, name=f"run{k}", where=f"run{k}.csv")


def found(*driven: Driven, plan: Plan = PLAN) -> list[Remark]:
    return agreement(plan, Readings(driven))


@pytest.mark.parametrize(
    ("spoil", "code", "second"),
    [
        (lambda y: y + 5.0 * AMPLITUDE * (AT >= 1200), "jump", 1200.0),
        (lambda y: np.where(AT >= 900, 1.5 * y, y), "scale_changed", 900.0),
    ],
)
def test_what_changes_inside_a_recording_is_named_where_it_is(spoil: Spoil, code: str, second: float) -> None:
    remarks = found(by_sine(1, spoil))
    assert [one.code for one in remarks] == [code]
    assert remarks[0].severity == "error"
    assert "recording driven" in remarks[0].what
    place = float(remarks[0].where.removeprefix("driven.csv: ").removesuffix(" s"))
    assert place == pytest.approx(second, abs=2.0 * PERIOD)


@pytest.mark.parametrize("phase", [0.0, None])
def test_sound_recordings_are_not_accused(phase: float | None) -> None:
    """Of 500 simulated recordings of each of seven kinds at most one was."""
    plan = Plan(period=PERIOD, phase=phase)
    assert not [one for seed in range(10, 15) for one in found(by_sine(seed, phase=phase), plan=plan)]


@pytest.mark.parametrize(("factor", "code"), [(-1.0, "sign_disagrees"), (2.0, "gain_disagrees")])
def test_a_recording_unlike_the_others_is_named(factor: float, code: str) -> None:
    alike = [by_schedule(k, 1.0) for k in range(3)]
    plan = Plan()
    assert not found(*alike, plan=plan)
    assert [(one.code, one.where) for one in found(*alike, by_schedule(3, factor), plan=plan)] == [(code, "run3.csv")]


def test_samples_that_are_no_readings_change_nothing() -> None:
    def lossy(y: Array) -> Array:
        y = y.copy()
        y[np.random.default_rng(3).choice(N, 20, replace=False)] = np.nan
        y[700:760] = np.nan  # stuck
        return y

    assert not found(by_sine(2, lossy))
    clean, spoiled = (reduce(PLAN, Readings((one,))).rows()[0] for one in (by_sine(2), by_sine(2, lossy)))
    assert clean.value is not None
    assert spoiled.value is not None
    assert clean.u is not None
    assert abs(spoiled.value - clean.value) < 0.5 * clean.u


def test_a_dwell_of_which_half_is_missing_is_a_gap() -> None:
    schedule = repeated([0.1, 0.3], np.array([0.0, 1.0]), cycles=25, dwell=20.0, move=0.0)
    y = np.random.default_rng(4).standard_normal(1000)
    y[40:52] = np.nan
    y[60:69] = np.nan
    one = recorded(y, "half")
    made = driven_by_schedule(one, one.channels[0], schedule, "schedule.csv")
    assert len(made.readings) == 49
    assert [remark.code for remark in made.remarks if remark.count == 1] == ["gaps"]
