from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.sensors.model.equation import predict
from inertialcal.sensors.model.sensor_model import Item, SensorModel, check_item, to_output, to_readings
from random_models import random_model


def plain(**terms: object) -> SensorModel:
    base = SensorModel("gyro", ("x", "y"), np.ones(2), "V", np.eye(2), np.zeros(2), Item("m", "p", "17"))
    return replace(base, **terms)  # type: ignore[arg-type]


def estimate(name: str, value: float, unit: str) -> Estimate:
    return Estimate((name,), np.array([value]), (unit,), (Component("scatter", "A", np.eye(1)),))


@pytest.mark.parametrize(
    ("terms", "text"),
    [
        ({"kind": "magnetometer"}, "kind 'magnetometer' is not known"),
        ({"axes": ("x", "x")}, "are ambiguous"),
        ({"axes": ("x", "y_1")}, "are ambiguous"),
        ({"matrix": np.eye(3)}, r"matrix: shape \(1, 3, 3\), need \(q, 2, 2\)"),
        ({"bias": np.zeros(3)}, r"bias: shape \(3,\), need \(2\)"),
        ({"bias": np.array([0.0, np.nan])}, "bias: not finite"),
        ({"scale_factor": np.array([1.0, 0.0])}, "scale_factor .* zero"),
        ({"bias_temperature": np.ones((1, 2))}, "terms in temperature without reference_temperature"),
        ({"matrix": np.ones((2, 2, 2))}, "terms in temperature without reference_temperature"),
        ({"bias_pressure": np.ones(2)}, "bias_pressure without reference_pressure"),
        ({"bias_warm_up": np.ones((1, 2))}, "bias_warm_up has 1 term"),
        ({"bias_warm_up": np.ones((1, 2)), "warm_up_time": np.array([-5.0])}, r"warm_up_time is \[-5.0\]"),
        ({"bias_run_to_run": np.array([0.1, -0.1])}, "standard deviation is negative"),
        ({"input_range": np.array([[-1.0, 1.0], [2.0, -2.0]])}, "input_range of y: 2 to -2"),
        ({"temperature_range": (30.0, 20.0)}, "temperature_range: 30 to 20"),
        ({"estimate": estimate("bias_z", 0.0, "rad/s")}, "the estimate has bias_z, which the model has not"),
        ({"estimate": estimate("bias_x", 0.0, "deg/s")}, "bias_x is estimated in 'deg/s', the model needs 'rad/s'"),
        ({"estimate": estimate("bias_x", 0.1, "rad/s")}, "bias_x is 0 in the model and 0.1 in its estimate"),
    ],
)
def test_refused(terms: dict[str, object], text: str) -> None:
    with pytest.raises(DataError, match=text):
        plain(**terms)


def test_terms_are_copies_that_cannot_be_written() -> None:
    bias = np.zeros(2)
    model = plain(bias=bias)
    bias[0] = 7.0
    assert model.bias[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        model.bias[0] = 1.0


def test_constant_matrix_and_common_numbers_are_filled_up() -> None:
    model = plain(reference_temperature=22.0, bias_temperature=np.ones((1, 2)))
    assert model.matrix.shape == (1, 2, 2)
    np.testing.assert_array_equal(model.reference_temperature, [22.0, 22.0])


def test_output_is_scale_factor_times_reading() -> None:
    model = plain(scale_factor=np.array([0.5, -2.0]))
    np.testing.assert_array_equal(to_output(model, np.array([[1.0, 1.0]])), [[0.5, -2.0]])
    np.testing.assert_array_equal(to_readings(model, np.array([[0.5, -2.0]])), [[1.0, 1.0]])


def test_output_unit_is_the_printed_one() -> None:
    assert plain(output_unit="pps").output_unit == "count/s"


def test_linear_is_told_by_the_numbers() -> None:
    assert plain(second_order=np.zeros(2)).linear
    assert not plain(second_order=np.array([0.0, 1e-9]), input_range=np.array([[-1.0, 1.0]] * 2)).linear
    assert random_model(3, linear=True).linear


def test_item_of_another_unit_is_refused() -> None:
    check_item(plain(), serial="17", unit="deg/s")
    check_item(plain(), unit="mV")
    with pytest.raises(DataError, match="model is for serial '17', the data are from serial '18'") as caught:
        check_item(plain(), serial="18")
    assert caught.value.problems[0].code == "wrong_serial"
    with pytest.raises(DataError, match=r"data are in 'm/s\^2', the model takes units like 'rad/s' or 'V'") as caught:
        check_item(plain(), unit="m/s^2")
    assert caught.value.problems[0].code == "wrong_unit"


def test_a_warm_up_dies_away_by_e_in_its_time() -> None:
    model = SensorModel(
        kind="gyro", axes=("x",), scale_factor=np.ones(1), output_unit="V", matrix=np.eye(1)[None],
        bias=np.array([0.5]),
        bias_warm_up=np.array([[2.0]]), warm_up_time=np.array([100.0]),
    )  # fmt: skip
    found = predict(model, np.zeros((3, 1)), time=np.array([0.0, 100.0, 1e5]))
    assert found[:, 0] == pytest.approx([2.5, 0.5 + 2.0 / math.e, 0.5])


def test_a_bias_in_temperature_is_its_polynomial_about_the_reference() -> None:
    """c1 d + c2 d^2 + c3 d^3 for each axis, by hand; nothing at the reference itself."""
    model = plain(
        reference_temperature=np.array([20.0, 10.0]),
        bias_temperature=np.array([[0.5, 1.0], [0.25, -2.0], [2.0, 0.125]]),
    )
    found = predict(model, np.zeros((3, 2)), temperature=np.array([20.0, 18.0, 10.0]))
    d_x, d_y = np.array([0.0, -2.0, -10.0]), np.array([10.0, 8.0, 0.0])
    x, y = 0.5 * d_x + 0.25 * d_x**2 + 2.0 * d_x**3, d_y - 2.0 * d_y**2 + 0.125 * d_y**3
    np.testing.assert_allclose(found, np.column_stack([x, y]), rtol=1e-14, atol=1e-14)
