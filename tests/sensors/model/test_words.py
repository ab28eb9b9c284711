from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key
from inertialcal.core.units import normalise
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.model.sensitivity import Sensitivity
from inertialcal.sensors.model.sensor_model import Item, Provenance, SensorModel, equation, lines, show
from random_models import random_model


def test_the_published_matrix_in_words() -> None:
    """The thesis prints 1.298 % as m_xz: the rotation about x that z feels."""
    said = {one.name: one.words for one in lines(flight_unit().models["corrected"])}
    assert said["misalignment_zx"] == "z sensor reads 1.298 % of x motion"
    assert said["misalignment_xy"] == "x sensor reads -0.156 % of y motion"
    assert said["scale_factor_error_x"] == "x sensor reads 0.042 % too little of x motion"
    assert said["scale_factor_error_y"] == "y sensor reads 0.4 % too much of y motion"


def test_bias_in_the_unit_of_the_field() -> None:
    model = SensorModel("accelerometer", ("x",), np.ones(1), "V", np.eye(1), np.array([9.80665e-6]))
    assert lines(model)[1].words == "x sensor reads 1 ug at no input"
    assert lines(model)[1].unit == "m/s^2"
    gyro = replace(model, kind="gyro", bias=np.radians([0.25]))
    assert lines(gyro)[1].words == "x sensor reads 0.25 deg/s at no input"


@pytest.mark.parametrize("seed", range(25))
def test_every_parameter_has_a_line_with_its_uncertainty(seed: int) -> None:
    model = random_model(seed, estimated=True)
    assert model.estimate is not None
    rows = lines(model)
    assert [row.name for row in rows] == [one.name for one in model.parameters]
    by_name = {row.name: row for row in rows}
    for name, u, value in zip(model.estimate.names, model.estimate.u, model.estimate.values, strict=True):
        assert by_name[name].u == u
        assert by_name[name].value == pytest.approx(value, rel=1e-12, abs=1e-14)
        assert by_name[name].origin == "from rate_x on rt_x, rt_x2"
    text = show(model)
    for row in rows:
        assert f"{row.name} = " in text
        assert row.words in text
        assert normalise(row.unit) == row.unit


def test_equation_has_only_the_terms_of_the_model() -> None:
    bare = SensorModel("gyro", ("x",), np.full(1, 28.6), "V", np.eye(1), np.zeros(1))
    assert equation(bare)[:3] == ["u = M x", "v = S0 * { K0 + u } + noise", "K0 = bias"]
    full = replace(
        bare,
        matrix=np.array([[[1.0]], [[0.01]], [[0.001]]]),
        bias_temperature=np.ones((2, 1)),
        bias_pressure=np.ones(1),
        bias_warm_up=np.ones((1, 1)),
        warm_up_time=np.ones(1),
        bias_temperature_rate=np.ones(1),
        bias_hysteresis=np.ones(1),
        scale_factor_asymmetry=np.ones(1),
        second_order=np.ones(1),
        third_order=np.ones(1),
        g_sensitivity=np.ones((1, 3)),
        reference_temperature=np.full(1, 22.0),
        reference_pressure=101325.0,
    )
    assert equation(full)[:3] == [
        "u = M(T) x,  M(T) = M_0 + M_1 (T - T_ref) + M_2 (T - T_ref)^2",
        "v = S0 * { K0 + u + K1'/2 |u| + K2 u^2 + K3 u^3 + G f } + noise",
        "K0 = bias + b_1 (T - T_ref) + b_2 (T - T_ref)^2 + b_p (p - p_ref) + A_1 exp(-t / tau_1) + b_r dT/dt"
        " + b_h sign(dT/dt)",
    ]
    assert "T_ref = 22 degC" in equation(full)
    assert "p_ref = 101325 Pa" in equation(full)


def test_show_says_whose_it_is_and_where_it_holds() -> None:
    text = show(flight_unit().models["corrected"])
    for part in (
        "Systron Donner 3 x QRS11-00005-565, serial flight: gyro, axes x, y, z; not confirmed by held-out recordings",
        "Source: Badescu, NPS thesis, 2011, Table 15, corrected",
        "S0 = 0.5 V/(deg/s)",
        "T_ref = x 25.7, y 25.4, z 25.3 degC",
        "row = the sensor that reads, column = the axis that moves",
        "Holds for: inputs -5 to 5 deg/s; temperatures -21 to 66 degC",
        "published without covariance",
    ):
        assert part in text


def test_show_of_a_bare_model() -> None:
    model = SensorModel("gyro", ("x",), np.ones(1), "rad/s", np.eye(1), np.zeros(1), judged=True)
    text = show(model)
    assert "unnamed sensor: gyro, axes x; judged on held-out recordings" in text
    assert "S0 = 1\n" in text
    assert "Holds for: no range stated" in text
    assert "(no uncertainty)" in text


def test_reasons_and_origins_stand_beside_each_parameter() -> None:
    model = SensorModel(
        "gyro",
        ("x",),
        np.ones(1),
        "rad/s",
        np.eye(1),
        np.zeros(1),
        Item("m", "p", "1"),
        bias_run_to_run=np.radians([0.016]),
        input_range=np.radians([[-5.0, 4.0]]),
        pressure_range=(0.0, 1e5),
        not_estimated={"bias_x": "one run"},
        provenance={"bias_x": Provenance(source="a table")},
    )
    text = show(model)
    assert "bias_x = 0 rad/s  (one run; a table)" in text
    assert "standard deviation: 0.016 deg/s" in text
    assert "inputs -5 to 4 deg/s; pressures 0 to 100000 Pa" in text


def test_a_model_over_supply_in_words() -> None:
    supply = Sensitivity("supply", "V", 5.0, np.array([0.02]), np.array([1e-4]), np.array([0.3]), (4.85, 5.15))
    noise = Estimate(
        (Key("angle_random_walk", "x"),),
        np.array([1.5e-4]),
        ("rad/sqrt(s)",),
        (Component("fit", "A", np.array([[1e-10]]), 9.0),),
    )
    bare = SensorModel("gyro", ("x",), np.full(1, 28.6), "V", np.eye(1), np.zeros(1), condition="vacuum")
    model = replace(bare, reference_temperature=np.full(1, 25.0), sensitivities=(supply,), noise=noise)
    assert equation(model)[:4] == [
        "u = M(supply) x,  M(supply) = M_0 + diag(s_supply) d_supply",
        "v = S0 * { K0 + u } + noise",
        "K0 = bias + b_supply d_supply + b_supply_T d_supply (T - T_ref)",
        "d_supply = supply - 5 V",
    ]
    said = {one.name: one for one in lines(model)}
    assert said["bias_supply_x"].words == "x bias, change with supply"
    assert (said["bias_supply_x"].value, said["bias_supply_x"].unit) == (0.02, "rad/s/V")
    assert said["bias_supply_temperature_x"].words == "x bias, change with supply and T - T_ref together"
    assert said["bias_supply_temperature_x"].unit == "rad/s/V/degC"
    assert said["scale_factor_error_supply_x"].words == "x scale factor, change with supply"
    assert said["scale_factor_error_supply_x"].unit == "1/V"
    for text in (show(model), str(model)):
        assert "condition vacuum" in text
        assert "supply 4.85 to 5.15 V" in text
        assert "noise, angle random walk: x 0.000150 ± 0.000010 rad/sqrt(s)" in text


def test_many_recordings_behind_a_parameter_are_counted() -> None:
    names = tuple(f"run_{number}" for number in range(1, 16))
    made = random_model(1, estimated=True)
    assert made.estimate is not None
    model = replace(made, provenance={name: Provenance("rate", names) for name in made.estimate.names})
    assert {row.origin for row in lines(model)} == {"from rate on 15 recordings"}
