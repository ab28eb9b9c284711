"""Do 95 % intervals of the hysteresis, as a model has it, hold the truth? By a simulator that shares no code."""

from __future__ import annotations

import numpy as np
import pytest

from independent import thermal
from inertialcal.procedures.model_terms import ModelTerms
from inertialcal.procedures.protocol import Facts
from inertialcal.procedures.protocol import Tested as Done
from inertialcal.procedures.thermal.reduction import Attitude, Plan, Readings, Sweep, reduce
from inertialcal.procedures.thermal.terms import model_terms
from inertialcal.statistics.intervals import contains, covers, t_interval

POLE = Plan(attitude=Attitude(0.0, 0.0, 0.0, 0.0), latitude=0.5 * np.pi)  # x reads nothing of the earth
PATHS = thermal.Unit(hysteresis=0.01, walk=2e-5)
TRUE = 0.5 * np.radians(PATHS.hysteresis)  # half of the gap between the paths


def terms_of(seed: int) -> ModelTerms:
    """Return the terms of a gyro whose paths differ, in five power-ups."""
    sweeps = []
    for name, table in thermal.ramped(seed, PATHS).tables.items():
        columns = table.columns
        time = columns["unix_s"] - columns["unix_s"][0]
        reading = np.radians(columns["gyro_x [deg/s]"])
        sweeps.append(Sweep(name, name, name, time, {"x": columns["temperature [degC]"]}, {"x": reading}))
    readings = Readings(tuple(sweeps))
    result = reduce(POLE, readings)
    facts = Facts("gyro", "deg/s", "rad/s")
    found = model_terms(result, [Done("thermal", "", "fit", POLE, readings, result, facts=facts)])
    assert found is not None
    return found


def holds(seed: int) -> bool:
    estimate = terms_of(seed).estimate
    assert estimate is not None
    k = estimate.index("bias_hysteresis_x")
    return contains(t_interval(*(float(one[k]) for one in (estimate.values, estimate.u, estimate.dof))), TRUE)


def test_the_hysteresis_is_found() -> None:
    assert holds(1)


@pytest.mark.slow
def test_intervals_hold_the_truth() -> None:
    hits = sum(holds(seed) for seed in range(1, 61))
    assert covers(hits, 60), hits
