"""The earth rate across the vertical is carried through positions by the rotations between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.constants import EARTH_ROTATION_RATE
from inertialcal.procedures.positions.fit.at_rest import LEVEL, apart, joined, level_covariance
from inertialcal.procedures.positions.fit.rotations import Problem
from inertialcal.procedures.positions.reduction import Plan, Readings, reduce, simulate
from positions_truths import BY_HAND, G

QUIET = replace(BY_HAND, acc_noise=1e-9, gyro_noise=1e-9, acc_between=1e-9, gyro_between=1e-9, angle_between=1e-9,
                sine_of_latitude=np.sin(0.8), sample_interval=0.01)  # fmt: skip
PLAN = Plan(gravity=G, latitude=0.8)


@pytest.fixture(scope="module")
def readings() -> Readings:
    return simulate(PLAN, QUIET, np.random.default_rng(1))


@pytest.fixture(scope="module")
def found(readings: Readings) -> tuple[Problem, np.ndarray, np.ndarray]:
    result = reduce(PLAN, readings)
    assert result.gyro is not None
    assert result.gyro.problem is not None
    assert result.gyro.rotated is not None
    return result.gyro.problem, result.acc.sensor.applied(readings.acc.mean), result.gyro.rotated.W


def test_axes_are_level_and_follow_what_the_earth_rate_really_does(
    readings: Readings, found: tuple[Problem, np.ndarray, np.ndarray]
) -> None:
    problem, force, W = found
    assert readings.gyro is not None
    axes = joined(problem, force, W).axes
    assert np.einsum("mak,mk->ma", axes, force) == pytest.approx(0.0, abs=1e-6)
    rate = (readings.gyro.mean - QUIET.gyro_bias - force @ QUIET.g_sensitivity.T) @ np.linalg.inv(QUIET.gyro_matrix).T
    north = np.einsum("mak,mk->ma", axes, rate)  # the same two numbers in every position
    level = EARTH_ROTATION_RATE.value * np.cos(0.8)
    assert np.hypot(*north.T) == pytest.approx(level, rel=0.02)
    assert np.ptp(north, axis=0) == pytest.approx(0.0, abs=0.02 * level)


def test_covariance_is_that_of_any_first_heading(found: tuple[Problem, np.ndarray, np.ndarray]) -> None:
    problem, force, W = found
    square = (EARTH_ROTATION_RATE.value * np.cos(0.8)) ** 2
    whole = level_covariance(PLAN, joined(problem, force, W))
    assert np.einsum("kmm->m", whole) == pytest.approx(square)  # all of it, shared among the three axes
    single = level_covariance(PLAN, apart(force))
    assert single[0] == pytest.approx(np.diag(np.diag(whole[0])))
    assert np.abs(whole[0] - single[0]).max() > 0.1 * square
    anywhere = level_covariance(Plan(gravity=G), apart(force))
    assert np.einsum("kmm->m", anywhere) == pytest.approx(EARTH_ROTATION_RATE.value**2 * 2.0 / 3.0)


def test_it_is_no_scatter_where_the_gyros_are_good(readings: Readings) -> None:
    gyro = reduce(PLAN, readings).gyro
    assert gyro is not None
    assert gyro.rest.between is not None
    assert np.all(gyro.rest.between < 0.02 * EARTH_ROTATION_RATE.value)
    assert LEVEL in {one.name for one in gyro.sensor.sources}


def test_the_vertical_earth_rate_is_no_g_sensitivity(readings: Readings) -> None:
    """It goes with gravity through every position, and is far larger than what the g-sensitivity is known to."""
    gyro = reduce(PLAN, readings).gyro
    assert gyro is not None
    vertical = EARTH_ROTATION_RATE.value * np.sin(0.8) / G
    assert gyro.sensor.g_sensitivity == pytest.approx(QUIET.g_sensitivity, abs=0.05 * vertical)
