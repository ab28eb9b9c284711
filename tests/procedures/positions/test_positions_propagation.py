"""What is wrong at rest, or with the accelerometers, goes into the matrix of the gyros as a fit again would take it.

Derivatives by differences: the readings at rest, or the accelerometers, are changed and everything is fitted anew.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.procedures.positions.fit.accelerometer import Fitted
from inertialcal.procedures.positions.fit.at_rest import LEVEL, apart
from inertialcal.procedures.positions.fit.gyro import MODEL, fit_gyro, problem_of
from inertialcal.procedures.positions.readings import local_gravity
from inertialcal.procedures.positions.reduction import Readings, Result, reduce, simulate
from positions_truths import BY_HAND, BY_HAND_PLAN, FIXTURE_PLAN, PLAN, TURNED

TESTS = {"by hand": (BY_HAND_PLAN, BY_HAND), "turned": (FIXTURE_PLAN, TURNED)}
SMALL = 1e-9
CLOSE = 1e-3  # of the largest of a covariance
RATE, LENGTH = 1e-7, 1e-6  # steps [rad/s], [1]


def reduced(name: str) -> Result:
    """Reduce right readings with the uncertainty of noisy ones: nothing is weighed anew when they change."""
    plan, truth = TESTS[name]
    quiet = replace(
        truth,
        acc_noise=SMALL,
        gyro_noise=SMALL,
        acc_between=SMALL,
        gyro_between=SMALL,
        angle_between=SMALL,
        sine_of_latitude=1.0,
        sample_interval=0.02,
    )
    readings = simulate(PLAN, quiet, np.random.default_rng(2))
    assert readings.gyro is not None
    acc = replace(readings.acc, scatter=readings.acc.scatter * truth.acc_noise / SMALL)
    gyro = replace(readings.gyro, scatter=readings.gyro.scatter * truth.gyro_noise / SMALL)
    return reduce(plan, replace(readings, acc=acc, gyro=gyro))


@pytest.fixture(scope="module", params=TESTS)
def result(request: pytest.FixtureRequest) -> Result:
    return reduced(request.param)


def fitted(result: Result, readings: Readings, acc: Fitted) -> Array:
    """Matrix, bias and g-sensitivity, shape (21,)."""
    assert result.gyro is not None
    assert result.gyro.rotated is not None
    force = result.acc.sensor.applied(readings.acc.mean)
    return fit_gyro(
        result.plan, readings, acc, np.ones(3), np.zeros(3), result.gyro.rotated.W, apart(force)
    ).sensor.values


def test_bias_and_g_sensitivity(result: Result) -> None:
    assert result.readings.gyro is not None
    gyro, force = result.readings.gyro, result.acc.sensor.applied(result.readings.acc.mean)
    columns = np.column_stack([np.ones(len(force)), force / 9.8])
    derivative = np.zeros((21, 12))
    for k in range(3):
        for j, at in enumerate((k, 3 + 3 * k, 4 + 3 * k, 5 + 3 * k)):
            ends = []
            for step in (RATE, -RATE):
                mean = gyro.mean.copy()
                mean[:, k] += step * columns[:, j]
                ends.append(fitted(result, replace(result.readings, gyro=replace(gyro, mean=mean)), result.acc))
            derivative[:, at] = (ends[0] - ends[1]) / (2.0 * RATE) * (9.8 if j else 1.0)
    assert derivative[9:] == pytest.approx(np.eye(12), abs=1e-6)
    assert result.gyro is not None
    assert result.gyro.rest.fits is not None
    level = np.zeros((12, 12))
    for k, fit in enumerate(result.gyro.rest.fits):
        own = [k, 3 + 3 * k, 4 + 3 * k, 5 + 3 * k]
        level[np.ix_(own, own)] = fit.parts[LEVEL]
    expected = derivative @ level @ derivative.T
    (found,) = (one.covariance for one in result.gyro.sensor.sources if one.name == LEVEL)
    for part in (np.s_[:9, :9], np.s_[:9, 9:12], np.s_[:9, 12:], np.s_[9:12, 9:12], np.s_[12:, 12:]):
        assert found[part] == pytest.approx(expected[part], abs=CLOSE * np.abs(expected[part]).max())


def test_accelerometers() -> None:
    """Those of a test by hand turn the ends of every transition."""
    result = reduced("by hand")
    sensor = result.acc.sensor
    derivative = np.zeros((21, 12))
    for number in range(12):
        ends = []
        for step in (LENGTH, -LENGTH):
            values = sensor.values.copy()
            values[number] += step
            changed = replace(result.acc, sensor=replace(sensor, values=values))
            ends.append(fitted(result, result.readings, changed))
        derivative[:, number] = (ends[0] - ends[1]) / (2.0 * LENGTH)
    expected = (derivative @ sensor.covariance @ derivative.T)[:9, :9]
    assert result.gyro is not None
    (found,) = (one.covariance for one in result.gyro.sensor.sources if one.name == MODEL)
    assert found[:9, :9] == pytest.approx(expected, abs=CLOSE * np.abs(expected).max())


def test_scatter_between_positions_tilts_gravity_as_noise_inside_does(result: Result) -> None:
    """Noise s of a mean reading turns the direction of gravity by s / g, wherever it comes from."""
    assert result.gyro is not None
    between, gravity = 0.02, local_gravity(result.plan)
    variances = [
        problem_of(result.plan, result.readings, acc, result.gyro.rest, np.ones(3), np.zeros(3)).up_variance
        for acc in (replace(result.acc, between=0.0), replace(result.acc, between=between))
    ]
    assert variances[1] - variances[0] == pytest.approx(np.full(len(variances[0]), (between / gravity) ** 2))
