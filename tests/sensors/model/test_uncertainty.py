from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.sensors.model.assemble import model_from, with_parameters
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.equation import Conditions, condition_columns, predict
from inertialcal.sensors.model.sensor_model import SensorModel
from inertialcal.sensors.model.terms import values
from inertialcal.sensors.model.uncertainty import compensated_uncertainty, point, reading_by, without_uncertainty
from random_models import conditions, inputs, random_model

SEEDS = st.integers(0, 2**32 - 1)
REACH = 1e-4  # of full scale, by which a step of central differences moves a reading
TRUNCATION = 3e-6  # of the largest derivative, for that step


def moved(model: SensorModel, name: str, by: float) -> SensorModel:
    one = next(p for p in model.parameters if p.name == name)
    value = float(values([one], model.terms)[0])
    return with_parameters(model, {one: value + by})


def sizes(model: SensorModel, x: Array, given_: Conditions) -> dict[str, float]:
    """A step of each parameter that moves readings by about 1e-4 of full scale (or of the time constant)."""
    at = point(model, x, condition_columns(model, len(x), given_))
    assert model.input_range is not None
    reach = REACH * float(np.max(model.input_range))
    found = {}
    for one in model.parameters:
        derivative = np.max(np.abs(reading_by(model, one, at)))
        step = reach / derivative if derivative > 0.0 else 1e-4
        value = abs(float(values([one], model.terms)[0]))
        found[one.name] = 1e-5 * value if one.field == "warm_up_time" else step
    return found


def off_the_kink(model: SensorModel, seed: int) -> Array:
    """Four inputs, none of them zero: there the slope of an asymmetric sensor has two values."""
    return 0.9 * np.delete(inputs(model, seed, 5), 2, axis=0)  # 0.9: a moved model still has an inverse


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_derivatives_are_those_of_predict(seed: int) -> None:
    model = random_model(seed)
    x, given_ = off_the_kink(model, seed), conditions(model, seed, 4)
    at = point(model, x, condition_columns(model, 4, given_))
    steps = sizes(model, x, given_)
    for one in model.parameters:
        h = steps[one.name]
        up, down = (predict(moved(model, one.name, sign * h), x, **given_) for sign in (1.0, -1.0))
        numeric = (up - down) / (2.0 * h)
        analytic = reading_by(model, one, at)
        rounding = 10.0 * np.finfo(float).eps * np.max(np.abs(up)) / h
        allowed = TRUNCATION * np.max(np.abs(analytic)) + rounding
        np.testing.assert_allclose(analytic, numeric, atol=allowed, err_msg=one.name)


@settings(max_examples=10, deadline=None)
@given(SEEDS)
def test_uncertainty_is_that_of_finite_differences_of_compensate(seed: int) -> None:
    model = replace(random_model(seed, estimated=True), bias_run_to_run=None)
    x, given_ = off_the_kink(model, seed), conditions(model, seed, 4)
    r = predict(model, x, **given_)
    steps = sizes(model, x, given_)
    assert model.estimate is not None
    jacobian = np.empty((*x.shape, len(model.estimate.names)))
    for p, name in enumerate(model.estimate.names):
        up, down = (compensate(moved(model, name, sign * steps[name]), r, **given_) for sign in (1.0, -1.0))
        jacobian[:, :, p] = (up - down) / (2.0 * steps[name])
    covariance = model.estimate.covariance
    expected = np.sqrt(np.einsum("nkp,pq,nkq->nk", jacobian, covariance, jacobian))
    np.testing.assert_allclose(compensated_uncertainty(model, r, **given_), expected, rtol=1e-4)


def one_gyro(*, u_bias: float, u_scale: float, correlation: float = 0.0) -> SensorModel:
    covariance = np.array([[u_scale**2, correlation * u_bias * u_scale], [correlation * u_bias * u_scale, u_bias**2]])
    estimate = Estimate(
        ("scale_factor_error_x", "bias_x"),
        np.array([0.01, 0.2]),
        ("1", "rad/s"),
        (Component("scatter", "A", covariance, 8.0),),
    )
    return model_from(estimate, "gyro", ("x",))


def test_bias_and_scale_factor_by_hand() -> None:
    """x = (r - b)/(1 + s): u^2 = (u_b^2 + x^2 u_s^2 + 2 x rho u_b u_s)/(1 + s)^2."""
    model = one_gyro(u_bias=0.003, u_scale=0.002, correlation=-0.4)
    x = np.array([-3.0, 0.0, 2.0])
    expected = np.sqrt(0.003**2 + x**2 * 0.002**2 - 2 * x * 0.4 * 0.003 * 0.002) / 1.01
    found = compensated_uncertainty(model, predict(model, x[:, np.newaxis]))
    np.testing.assert_allclose(found[:, 0], expected, rtol=1e-12)


def test_run_to_run_bias_adds_its_variance() -> None:
    model = replace(one_gyro(u_bias=0.003, u_scale=0.0), bias_run_to_run=np.array([0.004]))
    found = compensated_uncertainty(model, np.array([[0.2]]))
    assert found[0, 0] == pytest.approx(0.005 / 1.01, rel=1e-12)


def test_monte_carlo_over_the_covariance_agrees() -> None:
    """Draw parameters, compensate one reading with each model: the scatter is the uncertainty (to 4 of its sigmas)."""
    model = random_model(8, k=3, linear=True, estimated=True)
    model = replace(model, bias_run_to_run=None)
    assert model.estimate is not None
    x, given_ = inputs(model, 8, 4)[3:], conditions(model, 8, 1)
    r = predict(model, x, **given_)
    rng = np.random.default_rng(0)
    draws = 1500
    drawn = rng.multivariate_normal(model.estimate.values, model.estimate.covariance, draws, method="svd")
    by_name = {one.name: one for one in model.parameters}
    chosen = [by_name[name] for name in model.estimate.names]
    found = np.empty((draws, 3))
    for i, row in enumerate(drawn):
        one = with_parameters(model, dict(zip(chosen, map(float, row), strict=True)))
        found[i] = compensate(one, r, **given_)[0]
    u = compensated_uncertainty(model, r, **given_)[0]
    np.testing.assert_allclose(found.std(axis=0, ddof=1), u, rtol=4.0 / np.sqrt(2.0 * draws) + 0.01)


def test_model_without_covariance_is_refused() -> None:
    with pytest.raises(DataError, match="carries no covariance") as caught:
        compensated_uncertainty(random_model(1, k=2), np.zeros((1, 2)))
    assert caught.value.problems[0].code == "no_covariance"


def test_parameters_without_uncertainty_are_named() -> None:
    assert without_uncertainty(one_gyro(u_bias=0.1, u_scale=0.1)) == ()
    model = random_model(1, k=1)
    assert without_uncertainty(model) == tuple(one.name for one in model.parameters)
