from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.sensors.model.compensate import compensate, felt_range
from inertialcal.sensors.model.equation import inverted, mixed
from inertialcal.sensors.model.sensor_model import SensorModel


@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_inverse_is_that_of_the_textbook(k: int) -> None:
    rng = np.random.default_rng(k)
    matrix = np.eye(k) + rng.normal(0.0, 0.1, (200, k, k))
    np.testing.assert_allclose(inverted(matrix) @ matrix, np.broadcast_to(np.eye(k), matrix.shape), atol=2e-15 * k**2)


def test_rows_are_multiplied_by_their_own_matrix() -> None:
    matrices = np.array([[[1.0, 2.0], [0.0, 1.0]], [[0.0, 1.0], [-1.0, 0.0]]])
    x = np.array([[3.0, 4.0], [3.0, 4.0]])
    np.testing.assert_array_equal(mixed(matrices, x), [[11.0, 4.0], [4.0, -3.0]])
    np.testing.assert_array_equal(mixed(matrices[:1], x), [[11.0, 4.0], [11.0, 4.0]])
    np.testing.assert_array_equal(mixed(matrices, x[:1]), [[11.0, 4.0], [4.0, -3.0]])


def test_missing_reading_spreads_along_the_entries_that_are_there() -> None:
    x = np.array([[np.nan, 1.0, 1.0]])
    matrix = np.array([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.1, 0.0, 1.0]]])
    np.testing.assert_array_equal(mixed(matrix, x), [[np.nan, 1.0, np.nan]])


def test_entry_of_zero_takes_nothing_whatever_the_rows_around_it() -> None:
    matrices = np.array([np.eye(2), [[1.0, 0.5], [0.0, 1.0]]])
    x = np.array([[3.0, np.nan], [3.0, np.nan]])
    np.testing.assert_array_equal(mixed(matrices, x), [[3.0, np.nan], [np.nan, np.nan]])
    np.testing.assert_array_equal(mixed(matrices, np.array([[3.0, np.inf]] * 2)), [[3.0, np.inf], [np.inf, np.inf]])


@pytest.mark.parametrize("k", [2, 3])
def test_matrix_that_is_singular_beyond_the_range_is_refused(k: int) -> None:
    """M = I (1 - (T - 20)/100) is zero at 120 degC, far from the range that was checked."""
    model = SensorModel(
        "gyro",
        ("x", "y", "z")[:k],
        np.ones(k),
        "rad/s",
        np.array([np.eye(k), -0.01 * np.eye(k)]),
        np.zeros(k),
        reference_temperature=np.full(k, 20.0),
        temperature_range=(0.0, 40.0),
    )
    r = np.ones((2, k))
    np.testing.assert_allclose(compensate(model, r, temperature=np.array([20.0, 70.0])), [[1.0] * k, [2.0] * k])
    with pytest.raises(DataError, match="singular at a temperature of the data"):
        compensate(model, r, temperature=np.array([20.0, 120.0]))
    unbounded = replace(model, temperature_range=None)
    with pytest.raises(DataError, match="matrix cannot be inverted"):
        compensate(unbounded, r, temperature=np.array([20.0, 120.0]))
    assert np.isnan(compensate(unbounded, r, temperature=np.nan)).all()


def test_range_felt_is_the_widest_over_the_temperatures() -> None:
    matrices = np.array([[[1.0, 0.5], [0.0, 1.0]], [[2.0, -0.5], [0.0, 0.5]]])
    ends = felt_range(matrices, np.array([[-1.0, 3.0], [0.5, 1.0]]))
    # x sensor: 1*(-1..3) + 0.5*(0.5..1) and 2*(-1..3) - 0.5*(0.5..1); y sensor: 0.5..1 and 0.25..0.5, widened to 0
    np.testing.assert_allclose(ends, [[-2.5, 5.75], [0.0, 1.0]])
