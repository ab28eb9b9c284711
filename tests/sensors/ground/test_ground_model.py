"""Ground models: the forward equation and its way back, by gain, each step once."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.sensors.ground.correction import correct
from inertialcal.sensors.ground.model import GroundModel, Polynomials
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.equation import predict
from inertialcal.sensors.model.sensor_model import SensorModel

AXES = ("x", "y", "z")
UG = 9.80665e-6
T_REF = np.array([18.0, 19.0, 20.0])


def drawn(seed: int, order: Any = "jointly", gains: tuple[float, ...] = (10.0, 100.0)) -> GroundModel:
    """A head of the published family: 1000 ug, 5 ug/degC, 1e-4 a degC, some mrad off; fourth order in temperature."""
    rng = np.random.default_rng(seed)
    powers = 10.0 ** -np.arange(5)[:, None]
    cross = 2e-3 * rng.normal(size=(5, 3, 3)) * powers[:, :, None]
    cross[:, range(3), range(3)] = 0.0
    cross[0] += np.eye(3)
    base = SensorModel("accelerometer", AXES, np.ones(3), "m/s^2", cross, np.zeros(3), reference_temperature=T_REF)
    by_gain = {}
    for gain in gains:
        bias, scale = 1000.0 * UG * rng.normal(size=(5, 3)) * powers, 1e-2 * rng.normal(size=(5, 3)) * powers
        scale[0] += 1.0
        by_gain[gain] = {axis: Polynomials(bias[:, i], scale[:, i]) for i, axis in enumerate(AXES)}
    return GroundModel(base, by_gain, order)


def value(coefficients: Array, away: Array) -> Array:
    return np.asarray(sum(one * away**power for power, one in enumerate(coefficients)))


def forward(ground: GroundModel, x: Array, warm: Array, gains: Array) -> tuple[Array, Array, Array]:
    """Readings v / S0 sample by sample, with the bias and I + A that they were made with."""
    readings, biases, matrices = [], [], []
    for row, degrees, at in zip(x, warm, gains, strict=True):
        away = degrees - T_REF
        matrix = np.array([value(ground.base.matrix[:, i], away[i]) for i in range(3)])
        own = [ground.gains[float(at[i])][axis] for i, axis in enumerate(AXES)]
        bias = np.array([float(value(one.bias, away[i])) for i, one in enumerate(own)])
        scale = np.array([float(value(one.scale, away[i])) for i, one in enumerate(own)])
        readings.append(scale * (bias + matrix @ row))
        biases.append(bias)
        matrices.append(matrix)
    return np.array(readings), np.array(biases), np.array(matrices)


@pytest.fixture
def samples() -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(3)
    x = 50.0 * UG * rng.normal(size=(40, 3))
    return x, T_REF + rng.normal(size=(40, 3)), rng.choice([10.0, 100.0], (40, 3))


def test_jointly_is_the_inverse_of_the_sensor_equation_sample_by_sample(samples: tuple[Array, Array, Array]) -> None:
    x, warm, gains = samples
    ground = drawn(1)
    readings, bias, matrix = forward(ground, x, warm, gains)
    found = correct(ground, readings, temperature=warm, gain=gains)
    assert found.readings == pytest.approx(x, rel=1e-9, abs=1e-9 * UG)
    expected = np.array([np.linalg.solve(m, b) for m, b in zip(matrix, bias, strict=True)])
    assert found.predicted == pytest.approx(expected, rel=1e-10)
    assert not found.remarks


def test_bias_first_takes_the_bias_off_and_then_a_small_angle(samples: tuple[Array, Array, Array]) -> None:
    x, warm, gains = samples
    ground = drawn(1, "bias_first")
    readings, _, matrix = forward(ground, x, warm, gains)
    found = correct(ground, readings, temperature=warm, gain=gains)
    small = np.array([(np.eye(3) - (m - np.eye(3))) @ (m @ row) for m, row in zip(matrix, x, strict=True)])
    assert found.readings == pytest.approx(small, rel=1e-9, abs=1e-9 * UG)
    off = np.abs(found.readings - x).max()
    assert 1e-8 * np.abs(x).max() < off < 1e-3 * np.abs(x).max()  # by the square of the misalignment


def test_a_model_that_tells_no_gains_apart_is_undone_as_compensate_undoes_it() -> None:
    rng = np.random.default_rng(5)
    bias, slopes = rng.normal(size=3), 0.1 * rng.normal(size=(4, 3))
    model = replace(drawn(5).base, matrix=drawn(5).base.matrix * 1.02, bias=bias, bias_temperature=slopes)
    warm = T_REF + rng.normal(size=(30, 3))
    readings = predict(model, 1e-3 * rng.normal(size=(30, 3)), temperature=warm)
    found = correct(GroundModel(model), readings, temperature=warm)
    assert found.readings == pytest.approx(compensate(model, readings, temperature=warm), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("order", ["jointly", "bias_first"])
def test_what_the_bias_left_in_adds_is_what_the_model_predicts(order: Any, samples: tuple[Array, Array, Array]) -> None:
    x, warm, gains = samples
    ground = drawn(2, order)
    readings, _, _ = forward(ground, x, warm, gains)
    without = correct(ground, readings, temperature=warm, gain=gains)
    left = correct(ground, readings, temperature=warm, gain=gains, keep_bias=True)
    assert left.predicted == pytest.approx(without.predicted)
    assert left.readings - without.readings == pytest.approx(without.predicted, rel=1e-9)
    assert np.abs(without.predicted).mean() > 300.0 * UG


@pytest.mark.parametrize("steps", [("scale_factor",), ("misalignment", "scale_factor"), ("bias", "scale_factor"),
                                   ("bias", "scale_factor", "misalignment")])  # fmt: skip
def test_a_step_that_was_made_before_is_not_made_again(
    steps: tuple[str, ...], samples: tuple[Array, Array, Array]
) -> None:
    """By hand: the archive did `steps`; the rest, done here, must lead to the same acceleration."""
    x, warm, gains = samples
    ground = drawn(4)
    readings, bias, matrix = forward(ground, x, warm, gains)
    true = np.array([b + m @ row for b, m, row in zip(bias, matrix, x, strict=True)])
    data = true if "scale_factor" in steps else readings
    data = data - bias if "bias" in steps and "misalignment" not in steps else data
    if "misalignment" in steps:
        data = np.array([np.linalg.solve(m, row) for m, row in zip(matrix, data, strict=True)])
        back = np.array([np.linalg.solve(m, b) for m, b in zip(matrix, bias, strict=True)])
        data = data - back if "bias" in steps else data
    found = correct(ground, data, temperature=warm, gain=gains, applied=steps)
    assert found.readings == pytest.approx(x, rel=1e-8, abs=1e-8 * UG)
    (said,) = found.remarks
    assert said.code == "applied_before"
    assert all(word in said.what for word in [step.replace("_", " ") for step in steps])


def test_a_missing_reading_empties_what_it_enters_and_an_axis_that_was_never_read_does_not() -> None:
    ground = drawn(6, gains=(1.0,))
    x, warm, gains = np.full((5, 3), 10.0 * UG), np.tile(T_REF, (5, 1)), np.ones((5, 3))
    readings, _, matrix = forward(ground, x, warm, gains)
    gap = readings.copy()
    gap[2, 0] = np.nan
    found = correct(ground, gap, temperature=warm, gain=[1.0, 1.0, 1.0])
    assert np.isnan(found.readings).any(axis=1).tolist() == [False, False, True, False, False]
    assert [(one.code, one.count, one.where) for one in found.remarks] == [("condition_missing", 1, "sample 2")]
    gap[:, 0] = np.nan
    found = correct(ground, gap, temperature=warm, gain=[np.nan, 1.0, 1.0])
    assert [one.code for one in found.remarks] == ["misalignment_left_out"]
    assert np.isnan(found.readings[:, 0]).all()
    inner = matrix[0][1:, 1:]
    expected = np.linalg.solve(inner, matrix[0][1:] @ x[0])
    assert found.readings[0, 1:] == pytest.approx(expected, rel=1e-9)


def test_where_gain_or_temperature_is_missing_nothing_is_guessed(samples: tuple[Array, Array, Array]) -> None:
    x, warm, gains = samples
    ground = drawn(7)
    readings, _, _ = forward(ground, x, warm, gains)
    gains[3, 1], warm[5, 2] = np.nan, np.nan
    found = correct(ground, readings, temperature=warm, gain=gains)
    assert sorted(set(np.argwhere(np.isnan(found.readings))[:, 0].tolist())) == [3, 5]
    assert found.remarks[0].count == 2


def test_temperatures_beyond_the_range_are_counted(samples: tuple[Array, Array, Array]) -> None:
    x, warm, gains = samples
    ground = drawn(8)
    ground = replace(ground, base=replace(ground.base, temperature_range=(17.0, 20.0)))
    found = correct(ground, x, temperature=warm, gain=gains)
    beyond = np.any((warm < 17.0) | (warm > 20.0), axis=1)
    assert [(one.code, one.count) for one in found.remarks] == [("outside_temperature_range", int(beyond.sum()))]
    assert "17 to 20 degC" in found.remarks[0].what


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"gain": [1000.0, 100.0, 10.0]}, "no polynomials of x at gain 1000"),
        ({"gain": None}, "the ground model needs the gain"),
        ({"temperature": None}, "no temperature of the head"),
        ({"applied": ["offset"]}, "no step 'offset'"),
        ({"applied": ["bias"], "keep_bias": True}, "removed before"),
    ],
)
def test_what_is_refused(given: dict[str, Any], words: str, samples: tuple[Array, Array, Array]) -> None:
    x, warm, gains = samples
    arguments: dict[str, Any] = {"temperature": warm, "gain": gains} | given
    with pytest.raises(DataError, match=words):
        correct(drawn(9), x, **arguments)


def test_a_curved_model_and_one_in_pressure_are_refused() -> None:
    base = drawn(1).base
    with pytest.raises(DataError, match="has a curve"):
        GroundModel(replace(base, second_order=np.ones(3)))
    with pytest.raises(DataError, match="needs pressure"):
        GroundModel(replace(base, bias_pressure=np.ones(3), reference_pressure=1e5))


def test_a_constant_model_needs_no_temperature() -> None:
    model = SensorModel("accelerometer", ("x",), np.ones(1), "m/s^2", np.array([[1.02]]), np.array([0.5]))
    found = correct(GroundModel(model), np.array([[0.5 + 1.02 * 3.0]]))
    assert found.readings == pytest.approx(np.array([[3.0]]))
    assert found.predicted == pytest.approx(np.array([[0.5 / 1.02]]))
