"""A ground model on recordings: which channel is what, and what is added."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.recording import Channel, Recording
from inertialcal.sensors.ground.correction import correct_recording
from inertialcal.sensors.ground.model import GroundModel, Polynomials
from inertialcal.sensors.model.sensor_model import SensorModel

BASE = SensorModel("accelerometer", ("x", "y"), np.ones(2), "m/s^2", np.array([[1.0, 0.01], [0.0, 1.0]]), np.zeros(2),
                   reference_temperature=np.full(2, 20.0))  # fmt: skip
BY_GAIN = {
    10.0: {"x": Polynomials(np.array([1.0, 0.5]), np.array([2.0])), "y": Polynomials(np.array([3.0]), np.ones(1))},
    100.0: {"x": Polynomials(np.array([5.0, 0.5]), np.array([2.0])), "y": Polynomials(np.array([7.0]), np.ones(1))},
}
GROUND = GroundModel(BASE, BY_GAIN)


def recording(**columns: list[float]) -> Recording:
    units = {"x": "m/s^2", "y": "m/s^2", "temperature": "degC", "temperature_x": "K", "gain_x": "1", "other": "V"}
    return Recording(tuple(Channel(name, np.array(data), units[name]) for name, data in columns.items()))


def test_each_sample_has_the_polynomials_of_its_gain_and_the_other_channels_stay() -> None:
    raw = recording(x=[2.0, 10.0], y=[3.0, 3.0], temperature=[20.0, 22.0], gain_x=[10.0, 100.0], other=[1.0, 2.0])
    done = correct_recording(GROUND, raw, {"x": 10.0, "y": 10.0})
    assert done.names == ("x", "y", "temperature", "gain_x", "other", "predicted_x", "predicted_y")
    assert done.channel("y").data == pytest.approx([0.0, 0.0])
    assert done.channel("x").data == pytest.approx([1.0 - 1.0, 5.0 - (5.0 + 0.5 * 2.0)])
    assert done.channel("predicted_x").data == pytest.approx([1.0 - 0.03, 6.0 - 0.03])
    assert done.channel("predicted_x").unit == "m/s^2"
    assert done.channel("other").data.tolist() == [1.0, 2.0]


def test_the_temperature_of_an_axis_goes_before_that_of_the_head() -> None:
    raw = recording(x=[2.0], y=[3.0], temperature=[20.0], temperature_x=[273.15 + 24.0])
    done = correct_recording(GROUND, raw, {"x": 10.0, "y": 10.0})
    assert done.channel("x").data == pytest.approx([1.0 - (1.0 + 0.5 * 4.0)])


def test_an_axis_that_is_not_there_is_left_out() -> None:
    done = correct_recording(GROUND, recording(x=[2.0], temperature=[20.0]), {"x": 10.0, "y": 10.0})
    assert done.names == ("x", "temperature", "predicted_x")
    assert done.channel("x").data == pytest.approx([0.0])
    assert [one.code for one in done.remarks] == ["misalignment_left_out"]


def test_without_a_gain_nothing_is_guessed() -> None:
    with pytest.raises(DataError, match="needs the gain"):
        correct_recording(GROUND, recording(x=[2.0], y=[3.0], temperature=[20.0]), {})
