from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.units import factor
from inertialcal.sensors.model.assemble import NOT_ESTIMATED, in_units, model_from
from inertialcal.sensors.model.sensitivity import ChannelReference
from random_models import random_model

SEEDS = st.integers(0, 2**32 - 1)


def estimate(names: tuple[str, ...], values: list[float], units: tuple[str, ...]) -> Estimate:
    covariance = np.diag(np.abs(values)) ** 2
    return Estimate(names, np.array(values), units, (Component("scatter", "A", covariance, 5.0),))


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_model_of_its_own_estimate_is_the_model(seed: int) -> None:
    model = random_model(seed, estimated=True)
    assert model.estimate is not None
    again = model_from(
        model.estimate,
        model.kind,
        model.axes,
        model.scale_factor,
        model.output_unit,
        reference_temperature=model.reference_temperature,
        reference_pressure=model.reference_pressure,
        references={one.channel: ChannelReference(one.reference, one.unit, one.range) for one in model.sensitivities},
    )
    assert [one.channel for one in again.sensitivities] == [one.channel for one in model.sensitivities]
    for name in {one.field for one in model.parameters}:
        np.testing.assert_allclose(again.terms[name], model.terms[name], rtol=1e-14, atol=1e-16, err_msg=name)
    assert {one.name for one in again.parameters} == set(model.estimate.names)
    assert not again.not_estimated


def test_units_are_converted_with_their_covariance() -> None:
    degree = factor("deg/s", "rad/s")
    model = model_from(estimate(("scale_factor_error_x", "bias_x"), [1.0, 0.5], ("%", "deg/s")), "gyro", ("x",))
    assert model.matrix[0, 0, 0] == pytest.approx(1.01)
    assert model.bias[0] == pytest.approx(0.5 * degree)
    assert model.estimate is not None
    assert model.estimate.units == ("1", "rad/s")
    np.testing.assert_allclose(model.estimate.u, [0.01, 0.5 * degree])


def test_what_was_not_estimated_is_named() -> None:
    model = model_from(
        estimate(("scale_factor_error_x", "misalignment_xy"), [0.01, 0.02], ("1", "rad")),
        "gyro",
        ("x", "y"),
        not_estimated={"bias_x": "zero reference subtracted"},
    )
    np.testing.assert_allclose(model.matrix[0], [[1.01, 0.02 * 1.01], [0.0, 1.0]])
    assert model.not_estimated == {
        "scale_factor_error_y": NOT_ESTIMATED,
        "misalignment_yx": NOT_ESTIMATED,
        "bias_x": "zero reference subtracted",
        "bias_y": NOT_ESTIMATED,
    }


def test_stranger_is_refused() -> None:
    with pytest.raises(DataError, match="cross_axis_sensitivity_xz: no parameter of a gyro with axes x, y") as caught:
        model_from(estimate(("cross_axis_sensitivity_xz",), [1.0], ("1",)), "gyro", ("x", "y"))
    assert caught.value.problems[0].code == "unknown_parameter"


def test_wrong_dimension_is_refused() -> None:
    with pytest.raises(DataError, match="cannot be expressed"):
        in_units(estimate(("bias_x",), [1.0], ("deg/s",)), ("m/s^2",))


def test_same_units_are_left_alone() -> None:
    one = estimate(("bias_x",), [1.0], ("rad/s",))
    assert in_units(one, ("rad/s",)) is one


def test_the_own_uncertainty_of_a_source_stays_in_other_units() -> None:
    part = Component("table rate", "B", np.eye(1), stated=(0.05, "%"))
    found = in_units(Estimate(("bias_x",), np.array([1.0]), ("deg/s",), (part,)), ("rad/s",))
    assert found.components[0].stated == (0.05, "%")
    assert found.u[0] == pytest.approx(np.radians(1.0))
