"""Faults within a run of a moved mass, told apart from drift and from one another."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.physics.motion.schedule import Schedule
from inertialcal.procedures.mass_attraction.agreement import agreement
from inertialcal.procedures.mass_attraction.changes import changes_of, common_change, shifted
from inertialcal.procedures.mass_attraction.plan import Plan
from inertialcal.procedures.mass_attraction.readings import Readings, Run
from inertialcal.procedures.mass_attraction.reduction import reduce

N, RESPONSE, NOISE = 100, 0.235, 0.056  # dwells; [count/s]
AT: Array = np.arange(N, dtype=np.float64)
DRIVE = np.sin(0.5 * np.pi * AT)
SCHEDULE = Schedule(np.asarray(120.0 * AT), 100.0, 20.0, 0.3 - 0.15 * DRIVE, 2.3e-7 * DRIVE, "sine", 4)
PLAN = Plan(tilt="ignored")
X = (AT + 0.5) / N
DRIFTS: dict[str, Callable[[np.random.Generator], Array]] = {
    "none": lambda rng: 0.0 * X,
    "exponential": lambda rng: 1000.0 * np.exp(-3.0 * X),
    "cubic": lambda rng: 1000.0 * (X - 0.4) ** 3,
    "sine": lambda rng: 300.0 * np.sin(2.0 * np.pi * AT / 12.0),
    "weak walk": lambda rng: 0.1 * np.cumsum(rng.standard_normal(N)),
    "strong walk": lambda rng: 30.0 * np.cumsum(rng.standard_normal(N)),
}
WEAK = ("none", "exponential", "cubic", "sine", "weak walk")


def reading(name: str, seed: int, drive: Array = DRIVE) -> Array:
    """Return readings with a drift of so many responses."""
    rng = np.random.default_rng([len(name), seed])
    return 150.0 + RESPONSE * (drive + DRIFTS[name](rng)) + NOISE * rng.standard_normal(N)


@pytest.mark.parametrize("name", DRIFTS)
def test_drift_and_noise_are_no_faults(name: str) -> None:
    """Of 2,600 simulated runs with smooth or random drift, 2 were accused of a fault."""
    assert not [one for seed in range(8) for one in changes_of(SCHEDULE, reading(name, seed)).found]


@pytest.mark.parametrize("name", WEAK)
@pytest.mark.parametrize(("by", "at"), [(1.0, 0), (-1.0, 10), (1.0, 50), (2.0, 40), (0.5, 50)])
def test_a_slip_of_the_schedule_is_found(name: str, by: float, at: int) -> None:
    late = np.where(at > AT, DRIVE, shifted(DRIVE, by))
    *_, last = changes_of(SCHEDULE, reading(name, 1, late)).found
    assert last.kind == "slip"
    assert abs(last.at - at) <= 6
    with pytest.raises(DataError, match="a mass that comes") as caught:
        reduce(PLAN, Readings((Run("7", SCHEDULE, reading(name, 1, late)),)))
    assert caught.value.problems[0].code == "schedule_slip"


@pytest.mark.parametrize("name", WEAK)
@pytest.mark.parametrize("factor", [2.0, 0.5])
def test_a_gain_that_changes_is_refused_although_it_moves_level_and_drift(name: str, factor: float) -> None:
    x = reading(name, 2)
    x[52:] = 150.0 + factor * (x[52:] - 150.0)
    (remark,) = agreement(PLAN, Readings((Run("7", SCHEDULE, x),)))
    assert (remark.code, remark.severity) == ("scale_changed", "error")
    assert abs(remark.index - 52) <= 6


@pytest.mark.parametrize("name", WEAK)
def test_a_jump_of_five_responses_is_subtracted_and_remarked(name: str) -> None:
    sound = reading(name, 3)
    result = reduce(PLAN, Readings((Run("7", SCHEDULE, sound + 5.0 * RESPONSE * (AT >= 43)),)))
    (remark,) = [one for one in result.remarks if one.code == "jump"]
    assert remark.severity == "warning"
    assert abs(remark.index - 43) <= 1
    (response,) = result.responses
    (before,) = reduce(PLAN, Readings((Run("7", SCHEDULE, sound),))).responses
    assert response.amplitude == pytest.approx(before.amplitude, abs=response.u)


def test_a_false_reading_is_left_out() -> None:
    x = reading("exponential", 4)
    x[30] += 5.0 * RESPONSE
    changes = changes_of(SCHEDULE, x)
    assert [(one.kind, one.at) for one in changes.found] == [("reading", 30)]
    assert np.isnan(changes.repaired(x)[30])


def test_a_kink_of_the_drift_is_fitted() -> None:
    changes = changes_of(SCHEDULE, reading("none", 5) + 1000.0 * RESPONSE * np.abs(X - 0.43))
    assert [one.kind for one in changes.found] == ["kink"]
    assert abs(changes.found[0].at - 43) <= 1


def test_a_run_with_many_false_readings_is_refused() -> None:
    x = reading("none", 6)
    x[[20, 41, 62, 83]] += 20.0 * RESPONSE
    (remark,) = agreement(PLAN, Readings((Run("7", SCHEDULE, x),)))
    assert (remark.code, remark.severity) == ("jump", "error")


def test_what_no_run_shows_alone_is_found_at_the_same_dwell_of_every_run() -> None:
    small = [reading("none", seed) + 1.2 * RESPONSE * (AT >= 61) for seed in range(10, 16)]
    assert not [one for x in small for one in changes_of(SCHEDULE, x).found]
    found = common_change([(SCHEDULE, x) for x in small])
    assert found is not None
    assert abs(found.at - 61) <= 1


def test_a_long_run_is_compared_in_pieces() -> None:
    drive = np.tile(DRIVE, 5)
    at: Array = np.arange(len(drive), dtype=np.float64)
    long = Schedule(np.asarray(120.0 * at), 100.0, 20.0, 0.3 - 0.15 * drive, 2.3e-7 * drive, "sine", 4)
    x = RESPONSE * drive + NOISE * np.random.default_rng(7).standard_normal(len(at))
    assert not changes_of(long, x).found
    (jump,) = changes_of(long, x + 5.0 * RESPONSE * (at >= 333)).found
    assert (jump.kind, abs(jump.at - 333) <= 1) == ("jump", True)
    (slip,) = changes_of(long, x + RESPONSE * (at >= 333) * (shifted(drive, 1.0) - drive)).found
    assert (slip.kind, abs(slip.at - 333) <= 4) == ("slip", True)
