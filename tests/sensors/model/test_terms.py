from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.units import factor, normalise
from inertialcal.sensors.model.sensor_model import SensorModel
from inertialcal.sensors.model.terms import orders, parameter_keys, values, with_values
from random_models import random_model

SEEDS = st.integers(0, 2**32 - 1)


def by_name(model: SensorModel) -> dict[str, float]:
    return dict(zip((p.name for p in model.parameters), values(model.parameters, model.terms), strict=True))


def test_matrix_in_the_words_of_the_field() -> None:
    """Row = the sensor that reads, column = the axis that moves; misalignments are over the diagonal."""
    model = SensorModel("gyro", ("x", "z"), np.ones(2), "V", np.array([[1.02, 0.03], [0.012, 0.96]]), np.zeros(2))
    named = by_name(model)
    assert named["scale_factor_error_x"] == pytest.approx(0.02)
    assert named["scale_factor_error_z"] == pytest.approx(-0.04)
    assert named["misalignment_xz"] == pytest.approx(0.03 / 1.02)
    assert named["misalignment_zx"] == pytest.approx(0.012 / 0.96)


@pytest.mark.parametrize("seed", range(40))
def test_names_are_unique_and_units_are_printed_ones(seed: int) -> None:
    parameters = random_model(seed).parameters
    assert len({one.name for one in parameters}) == len(parameters)
    for one in parameters:
        assert normalise(one.unit) == one.unit
        assert one.name == str(one.key)


@pytest.mark.parametrize("seed", range(20))
def test_units_carry_every_term_to_the_input_unit(seed: int) -> None:
    """Unit of the parameter times that of its factor in the equation is the input unit."""
    model = random_model(seed)
    unit = model.unit
    factors = {
        "bias": "1",
        "bias_pressure": "Pa",
        "bias_temperature_rate": "degC/s",
        "bias_hysteresis": "1",
        "bias_warm_up": "1",
        "second_order": f"({unit})^2",
        "third_order": f"({unit})^3",
        "scale_factor_asymmetry": unit,
        "g_sensitivity": "m/s^2",
    }
    for one in model.parameters:
        if one.field in factors:
            assert factor(f"({one.unit})*({factors[one.field]})", unit) == 1.0


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_values_come_back_from_changed_terms(seed: int) -> None:
    model = random_model(seed)
    rng = np.random.default_rng(seed)
    wanted = {one: value + abs(value) * rng.normal(0.0, 0.1) for one, value in _pairs(model)}
    terms = with_values(model.terms, wanted)
    np.testing.assert_allclose(values(wanted, terms), list(wanted.values()), rtol=1e-12, atol=1e-15)


def _pairs(model: SensorModel) -> list[tuple]:  # type: ignore[type-arg]
    return list(zip(model.parameters, map(float, values(model.parameters, model.terms)), strict=True))


def test_new_scale_factor_takes_its_row_along() -> None:
    matrix = np.array([[1.02, 0.03], [0.012, 0.96]])
    model = SensorModel("gyro", ("x", "z"), np.ones(2), "V", matrix, np.zeros(2))
    one = next(p for p in model.parameters if p.name == "scale_factor_error_x")
    terms = with_values(model.terms, {one: 0.1})
    np.testing.assert_allclose(terms["matrix"][0], [[1.1, 0.03 * 1.1 / 1.02], [0.012, 0.96]], rtol=1e-15)
    assert model.matrix[0, 0, 0] == 1.02


def test_orders_are_read_from_names() -> None:
    names = [
        "bias_x",
        "bias_temperature_3_x",
        "scale_factor_error_temperature_2_y",
        "cross_axis_sensitivity_temperature_1_xy",
        "bias_warm_up_2_x",
        "warm_up_time_1",
        "bias_temperature_rate_x",
    ]
    assert orders(parameter_keys(names, ("x", "y"))) == {"matrix": 2, "bias_temperature": 3, "bias_warm_up": 2}
