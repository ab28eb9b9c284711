from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key
from inertialcal.core.units import factor
from inertialcal.sensors.model.assemble import NOT_ESTIMATED, in_units, model_from, models_from
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


def test_models_of_many_units_are_those_of_each() -> None:
    wide = ("scale_factor_error_x", "misalignment_xy", "bias_x", str(Key("bias_temperature", "y", power=1)))
    units = ("1", "rad", "deg/s", "rad/s/degC")
    given: list[dict[str, object]] = [
        {
            "estimate": estimate(wide, [0.01 * k, 0.02, 0.3 * k, 1e-5], units),
            "kind": "gyro",
            "axes": ("x", "y"),
            "scale_factor": np.array([2.0, 3.0 + k]),
            "output_unit": "V",
            "input_range": np.array([[-1.0, 1.0], [-2.0, 2.0 - k]]),
            "reference_temperature": 25.0,
            "values": {"misalignment_yx": 0.001 * k},
        }
        for k in range(4)
    ]
    given.append({"estimate": estimate(("bias_x",), [1.0], ("m/s^2",)), "kind": "accelerometer", "axes": ("x",)})
    given[1]["scale_factor"] = np.array([0.0, 1.0])  # refused
    given[2]["input_range"] = np.array([[1.0, -1.0], [-1.0, 1.0]])  # refused
    given[3]["temperature_range"] = (1.0, 0.0)  # refused
    given.append(given[0] | {"estimate": estimate(("bias_z",), [1.0], ("rad/s",))})  # refused: no such axis
    for one, found in zip(given, models_from(given), strict=True):
        if isinstance(found, DataError):
            with pytest.raises(DataError, match=re.escape(str(found))):
                model_from(**one)  # type: ignore[arg-type]
            continue
        alone = model_from(**one)  # type: ignore[arg-type]
        for name, part in vars(alone).items():
            if not isinstance(part, np.ndarray) and name != "estimate":
                assert getattr(found, name) == part, name
        assert {name: term.tolist() for name, term in found.terms.items()} == {
            name: term.tolist() for name, term in alone.terms.items()
        }
        assert found.estimate is not None
        assert found.parameters == alone.parameters
        assert not any(term.flags.writeable for term in found.terms.values())
        np.testing.assert_array_equal(found.estimate.values, in_units(one["estimate"], found.estimate.units).values)  # type: ignore[arg-type]
    assert [isinstance(found, DataError) for found in models_from(given)] == [False, True, True, True, False, True]


def test_model_made_at_once_is_one_that_its_checks_accept() -> None:
    (found,) = models_from(
        [{"estimate": estimate(("scale_factor_error_x", "bias_x"), [0.5, 2.0], ("1", "rad/s")), "kind": "gyro",
          "axes": ("x", "y"), "bias_run_to_run": [0.1, 0.2]}]
    )  # fmt: skip
    assert not isinstance(found, DataError)
    found.__post_init__()
    (bad,) = models_from([{"estimate": found.estimate, "kind": "gyro", "axes": ("x", "y"), "bias_run_to_run": -1.0}])
    assert isinstance(bad, DataError)
