"""Sensitivities after another test: what is not known of what was taken off moves them as readings moved by it do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from sensitivity_cases import SUPPLY, codes, recordings_of, row, truth_of

from independent import climate
from independent.climate import Unit, Visits
from inertialcal.core.errors import PlanError
from inertialcal.core.estimate import Array
from inertialcal.core.key import AXES, Key, Origin
from inertialcal.core.recording import Recording
from inertialcal.core.unknowns import Unknowns
from inertialcal.procedures.protocol import Tested as Done
from inertialcal.procedures.sensitivity.held_out import joined
from inertialcal.procedures.sensitivity.plan import Plan
from inertialcal.procedures.sensitivity.readings import Readings, readings_from, recorded
from inertialcal.procedures.sensitivity.reduction import Result, reduce

PARTS = Origin("scatter between runs", test="thermal", level="run")
LEVEL, SLOPE = 0.01, 3e-6  # [rad/s], [rad/s/degC]: what is taken off
U = np.array([[2e-4, 0.0], [1e-6, 2e-7]])  # of both unknowns in level and slope
WEIGHTS = 1e-8  # they follow the readings a little


def basis(recording: Recording) -> Array:
    """Return level and slope of each sample, shape (n, 2)."""
    T = np.asarray(recording.channel("temperature").data, dtype=float)
    return np.column_stack([np.ones(len(T)), T - 20.0])


@dataclass(frozen=True)
class Line:
    """A line over temperature, the same of all axes, with two unknowns."""

    law: tuple[float, float] = (LEVEL, SLOPE)
    test: str = "thermal"
    unit: str = "rad/s"
    reference_temperature: float | None = None

    def apply(
        self, recordings: Sequence[tuple[str, Recording]]
    ) -> tuple[list[Recording], list[Mapping[Origin, Unknowns]]]:
        made: list[Recording] = []
        found: list[Mapping[Origin, Unknowns]] = []
        for _, one in recordings:
            off = basis(one) @ np.array(self.law)
            channels = tuple(replace(c, data=c.data - off) if c.name in AXES else c for c in one.channels)
            made.append(replace(one, channels=channels))
            changes = np.repeat((U @ basis(one).mean(axis=0))[:, None, None], 3, axis=2)
            found.append({PARTS: Unknowns(PARTS, "A", changes, (), np.zeros((2, 0)), np.array([4.0, 5.0, 6.0]))})
        return made, found


def readings(plan: Plan, *corrections: Line) -> Readings:
    case = climate.supplied(1, Unit(), Visits(runs=3, dwell=100.0, axes="xy"))
    found = []
    for one in recordings_of(case):
        T = replace(one.recording.channels[0], name="temperature", data=one.conditions["temperature"]["x"], unit="degC")
        recording = replace(one.recording, channels=(*one.recording.channels, T))
        found.append(replace(one, recording=recording, corrections=corrections))
    return readings_from(plan, found, "rad/s")


def result(plan: Plan, *corrections: Line) -> Result:
    return reduce(plan, readings(plan, *corrections))


def test_each_unknown_moves_the_terms_as_readings_moved_by_it() -> None:
    plan = replace(SUPPLY, to=["supply", "temperature"], order=1)
    found = result(plan, Line())
    assert found.estimate is not None
    (part,) = [one for one in found.estimate.components if one.origin == PARTS]
    assert part.changes is not None
    for s in range(2):
        moved = result(plan, Line((LEVEL + float(U[s, 0]), SLOPE + float(U[s, 1])))).estimate
        assert moved is not None
        np.testing.assert_allclose(part.changes[s], moved.values - found.estimate.values, rtol=1e-3, atol=WEIGHTS)
    slope = found.estimate.index(Key("bias_temperature", "x", power=1))
    np.testing.assert_allclose(part.changes[:, slope], -U[:, 1], rtol=1e-3, atol=1e-15)
    both = [found.estimate.index(Key("bias_temperature", axis, power=1)) for axis in "xy"]
    assert part.covariance[both[0], both[1]] == pytest.approx(float(U[:, 1] @ U[:, 1]), rel=1e-3)
    assert np.broadcast_to(part.dof, len(found.estimate.keys))[both].tolist() == [4.0, 5.0]


def test_the_supply_is_what_it_is_without_whatever_was_taken_off() -> None:
    """A line over temperature is in the fit: the supply's terms do not follow what is taken off."""
    with_it, without = result(SUPPLY, Line()), result(SUPPLY)
    truth = truth_of(climate.supplied(1), "bias_supply x")
    for one in (with_it, without):
        found = row(one, "bias_supply x")
        assert found.value == pytest.approx(truth, rel=0.1)
    assert row(with_it, "bias_supply x").u == pytest.approx(row(without, "bias_supply x").u, rel=0.05)
    assert "outside" not in codes(with_it)


def test_tests_reduced_together_have_it_taken_off_once() -> None:
    taken = readings(SUPPLY, Line())
    halves = [[one for one in taken.recorded if (one.name == "run1.csv") == first] for first in (True, False)]
    tests = []
    for name, half in zip("ab", halves, strict=True):
        own = readings_from(SUPPLY, half, "rad/s")
        tests.append(Done(name, "", "fit", SUPPLY, own, reduce(SUPPLY, own)))
    made = joined(tests)
    assert made is not None
    np.testing.assert_allclose(made[1].values["x"], taken.values["x"])
    assert set(made[1].taken_off) == {PARTS}


def test_a_warm_up_after_a_law_over_temperature_is_refused() -> None:
    with pytest.raises(PlanError, match="a start-up is not told from a law"):
        recorded(Plan(to=["warm_up"]), [], [Line()])
