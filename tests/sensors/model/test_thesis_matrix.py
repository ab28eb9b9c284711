"""The published matrix applied as printed makes its own scale errors worse; mended, it removes them.

Figures: issue text and errata of Badescu, NPS thesis, 2011, section IV.E.2.a and equation (2).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.sensors.catalogue import M_PERCENT, flight_unit
from inertialcal.sensors.model.compensate import compensate, first_order
from inertialcal.sensors.model.equation import predict
from inertialcal.sensors.model.sensor_model import SensorModel

ROUNDING = 0.0005  # [%], of the figures quoted
PRINTED = np.array(M_PERCENT) / 100.0

# What the sensors do, by hand from the printed figures: the diagonal is (0.5 - slope)/0.5, an error of the other
# sign; entry (row, column) off the diagonal is the rotation about the row axis that the column axis feels.
TRUTH = np.array(
    [
        [1.0 - 0.00042, -0.00156, -0.00200],
        [0.00102, 1.0 + 0.00400, -0.00139],
        [0.01298, 0.00128, 1.0 - 0.00506],
    ]
)


def matrix_only(model: SensorModel) -> SensorModel:
    return replace(model, bias=np.zeros(3), bias_temperature=None)


def left_over(compensated: Array) -> Array:
    """Scale errors in percent, from readings of unit inputs along each axis."""
    return 100.0 * (np.diag(compensated) - 1.0)


@pytest.fixture(scope="module")
def printed() -> SensorModel:
    return matrix_only(flight_unit().models["as_printed"])


@pytest.fixture(scope="module")
def corrected() -> SensorModel:
    return matrix_only(flight_unit().models["corrected"])


@pytest.fixture(scope="module")
def readings() -> Array:
    """What the sensors read for a unit rate about x, y, z in turn; row = the turn."""
    return TRUTH.T


def test_the_sensors_own_errors(readings: Array) -> None:
    np.testing.assert_allclose(left_over(readings), [-0.042, 0.400, -0.506], atol=ROUNDING)


def test_as_printed_first_order_doubles_the_errors(printed: SensorModel, readings: Array) -> None:
    np.testing.assert_allclose(left_over(first_order(printed, readings)), [-0.101, 0.801, -1.010], atol=ROUNDING)


def test_as_printed_inverse_doubles_the_errors(printed: SensorModel, readings: Array) -> None:
    np.testing.assert_allclose(left_over(compensate(printed, readings)), [-0.104, 0.802, -1.010], atol=ROUNDING)


def test_first_order_is_the_equation_of_the_thesis(printed: SensorModel, readings: Array) -> None:
    by_hand = np.array([r - PRINTED @ r for r in readings])
    np.testing.assert_allclose(first_order(printed, readings), by_hand, atol=1e-16)


def test_corrected_model_predicts_the_sensors(corrected: SensorModel, readings: Array) -> None:
    np.testing.assert_allclose(predict(corrected, np.eye(3)), readings, atol=1e-16)


def test_corrected_first_order_leaves_less_than_3e_5(corrected: SensorModel, readings: Array) -> None:
    assert np.all(np.abs(left_over(first_order(corrected, readings))) < 0.003)
    assert np.any(np.abs(left_over(first_order(corrected, readings))) > 0.001)


def test_corrected_inverse_leaves_nothing(corrected: SensorModel, readings: Array) -> None:
    np.testing.assert_allclose(compensate(corrected, readings), np.eye(3), atol=1e-15)


def test_sign_alone_or_transposition_alone_is_not_enough(corrected: SensorModel, readings: Array) -> None:
    sign_only = np.where(np.eye(3, dtype=bool), -PRINTED, PRINTED)
    transposed_only = PRINTED.T
    for errors in (sign_only, transposed_only):
        wrong = replace(corrected, matrix=np.eye(3) + errors)
        assert np.max(np.abs(compensate(wrong, readings) - np.eye(3))) > 0.005
