"""A compensated reading of a new power-up lies where its stated uncertainty says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.influence import Influence
from inertialcal.procedures.rate_table.reduction import Plan, Truth, reduce, simulate
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.uncertainty import compensated_uncertainty
from inertialcal.statistics.intervals import coverage_factor, covers
from sized import sized

AXES = ("x", "y", "z")
PLAN = Plan(zero_reference=True, standards={"rate_table.rate": Influence(3e-5)})
RUNS = 6
PARAMETERS = ("bias", "scale_factor_error", "misalignment", "scale_factor_asymmetry")


def inside(seed: int) -> list[bool]:
    """Whether the true rate lies in the 95 % interval, per axis, at a reading of a power-up that the fit has not seen.

    The noise of the reading itself is not in the uncertainty of the model; here there is none.
    """
    rng = np.random.default_rng(seed)
    matrix = np.eye(3) + rng.normal(0.0, 0.01, (3, 3))
    truth = Truth(matrix, rng.normal(0.0, 1e-3, 3), rng.normal(0.0, 2e-3, 3), runs=RUNS)
    truth = replace(truth, dwell_std=1e-6, sample_std=1e-6, run_scale_std=0.0)
    result = reduce(PLAN, simulate(PLAN, truth, rng))
    assert result.estimate is not None
    names = [name for name in result.estimate.names if name.rpartition("_")[0] in PARAMETERS]
    runs = [level.std for axis in AXES for level in result.lines[axis].levels if level.name == "run"]
    model = model_from(
        result.estimate.select(names),
        "gyro",
        AXES,
        input_range=np.full((3, 2), [-9, 9]),
        bias_run_to_run=np.array(runs, float),
    )
    applied = rng.uniform(-0.05, 0.05, 3)
    felt = matrix @ applied
    reading = truth.bias + rng.normal(0.0, truth.run_bias_std, 3) + felt + 0.5 * truth.asymmetry * np.abs(felt)
    x, u = compensate(model, reading[None])[0], compensated_uncertainty(model, reading[None])[0]
    half = coverage_factor(RUNS - 1.0) * u
    return [bool(abs(x[i] - applied[i]) <= half[i]) for i in range(len(AXES))]


def hits(n: int) -> np.ndarray:
    return np.asarray(np.sum([inside(seed) for seed in range(1, n + 1)], axis=0))


def test_compensated_readings_are_covered() -> None:
    assert all(covers(int(count), 60) for count in hits(60))


@pytest.mark.slow
def test_compensated_readings_are_covered_long() -> None:
    n = sized(1000, 250)
    assert all(covers(int(count), n) for count in hits(n))
