from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.sensors.chain.converter import Chain
from inertialcal.sensors.model.on_recordings import apply_chain, compensate_recording
from inertialcal.sensors.model.sensitivity import Sensitivity
from inertialcal.sensors.model.sensor_model import Item, SensorModel

EARLIER = Remark("gaps", "info", "1 gap")


def recording(*channels: Channel) -> Recording:
    n = len(channels[0].data)
    return Recording(
        channels,
        np.arange(n) * 2_000_000_000,
        2.0,
        1.0,
        source=Source("rt_x.csv", "ab" * 32, "csv"),
        remarks=(EARLIER,),
        first_row=2,
    )


def counts(name: str, *codes: float, unit: str | None = "count") -> Channel:
    return Channel(name, np.array(codes), unit)


CHAIN = Chain(("x",), 5.0 / 4095, (0, 4095), "rad/s", scale_factor=2.0, reference="channel", validity_minimum=2.4)
MODEL = SensorModel(
    "gyro",
    ("x",),
    np.array([2.0]),
    "V",
    np.array([[1.25]]),
    np.array([0.1]),
    Item(serial="7"),
    bias_temperature=np.array([[0.01]]),
    reference_temperature=20.0,  # type: ignore[arg-type]
    input_range=np.array([[-1.0, 1.0]]),
)


def test_chain_on_a_recording() -> None:
    raw = recording(
        counts("a", 2100, 4095, 2100),
        counts("r", 2048, 2048, 2048),
        counts("bit", 3000, 3000, 10),
        Channel("id", np.array([5, 6, 7])),
    )
    done = apply_chain(CHAIN, raw, {"x": "a", "reference": "r", "validity_x": "bit"})
    assert done.names == ("x", "id")
    x = done.channel("x")
    assert (x.unit, x.unit_from, x.axis, x.quantity) == ("rad/s", "chain", "x", "gyro")
    np.testing.assert_allclose(x.data, [52 * 5.0 / 4095 / 2.0, np.nan, np.nan])
    assert done.time_ns is raw.time_ns
    assert done.source is raw.source
    assert done.remarks[0] is EARLIER
    assert [(one.code, one.where) for one in done.remarks[1:]] == [("rail", "rt_x.csv:3"), ("test_low", "rt_x.csv:4")]


def test_place_names_the_row_of_the_file() -> None:
    raw = recording(counts("a", 2100, 5000), counts("r", 2048, 2048), counts("bit", 3000, 3000))
    with pytest.raises(DataError, match=r"rt_x.csv:3: x: code 5000"):
        apply_chain(CHAIN, raw, {"x": "a", "reference": "r", "validity": "bit"})


def test_place_without_a_file_is_the_sample() -> None:
    raw = Recording((counts("a", 2100, 4095), counts("r", 2048, 2048), counts("bit", 3000, 3000)))
    done = apply_chain(CHAIN, raw, {"x": "a", "reference": "r", "validity": "bit"})
    assert done.remarks[0].where == "sample 2"


def test_column_in_volts_is_refused() -> None:
    raw = recording(counts("a", 1.0, unit="V"), counts("r", 2048), counts("bit", 3000))
    with pytest.raises(DataError, match="column 'a' is in V, the chain takes counts") as caught:
        apply_chain(CHAIN, raw, {"x": "a", "reference": "r", "validity": "bit"})
    assert caught.value.problems[0].code == "wrong_unit"


def test_missing_columns_are_refused() -> None:
    raw = recording(counts("a", 2100), counts("bit", 3000))
    with pytest.raises(DataError, match="no reference channel for x"):
        apply_chain(CHAIN, raw, {"x": "a", "validity": "bit"})
    with pytest.raises(DataError, match="no column 'r'"):
        apply_chain(CHAIN, raw, {"x": "a", "reference": "r", "validity": "bit"})
    with pytest.raises(DataError, match="no column named for axis x"):
        apply_chain(CHAIN, raw, {"reference": "r"})


def test_reference_for_one_of_two_axes_is_refused() -> None:
    chain = Chain(("x", "y"), 1.0, None, reference="channel")
    raw = recording(counts("a", 1), counts("b", 1), counts("r", 1))
    with pytest.raises(DataError, match="no reference channel for y"):
        apply_chain(chain, raw, {"x": "a", "y": "b", "reference_x": "r"})


@pytest.mark.parametrize("unit", ["deg/s", "rad/s", "V", "mV"])
def test_model_on_a_recording_in_any_unit(unit: str) -> None:
    """x = (r - 0.1 - 0.01 (T - 20))/1.25; r is the column over the scale factor where it is an output."""
    readings = {"deg/s": np.degrees([0.4, 1.65]), "rad/s": [0.4, 1.65], "V": [0.8, 3.3], "mV": [800.0, 3300.0]}[unit]
    raw = recording(
        Channel("id", np.array([5, 6])),
        Channel("rate", np.array(readings), unit),
        Channel("t", np.array([293.15, 303.15]), "K"),
    )
    done = compensate_recording(MODEL, raw, {"x": "rate", "temperature": "t"})
    assert done.names == raw.names
    assert done.time_ns is raw.time_ns
    expected = np.array([0.24, 1.16])
    in_degrees = unit == "deg/s"
    assert done.channel("rate").unit == ("deg/s" if in_degrees else "rad/s")
    np.testing.assert_allclose(done.channel("rate").data, np.degrees(expected) if in_degrees else expected)
    np.testing.assert_array_equal(done.channel("id").data, [5, 6])
    assert [(one.code, one.where, one.count) for one in done.remarks[1:]] == [("outside_input_range", "rt_x.csv:3", 1)]


def test_temperature_may_be_given_beside_the_columns() -> None:
    raw = recording(Channel("rate", np.array([0.4]), "rad/s"))
    done = compensate_recording(MODEL, raw, {"x": "rate"}, temperature=20.0)
    assert done.channel("rate").data[0] == pytest.approx(0.24)
    with pytest.raises(DataError, match="no temperature given"):
        compensate_recording(MODEL, raw, {"x": "rate"})


def test_unit_is_never_guessed() -> None:
    with pytest.raises(DataError, match="column 'rate' has no unit") as caught:
        compensate_recording(MODEL, recording(Channel("rate", np.array([0.4]))), {"x": "rate"}, temperature=20.0)
    assert caught.value.problems[0].code == "no_unit"
    with pytest.raises(DataError, match="data are in 'g'"):
        compensate_recording(MODEL, recording(Channel("rate", np.array([0.4]), "g")), {"x": "rate"}, temperature=20.0)


def test_other_channels_come_from_columns_in_any_unit() -> None:
    """x = r - 0.5 (supply - 5 V) - 1e-6 (p - 1e5 Pa)."""
    model = replace(
        MODEL, matrix=np.eye(1), bias=np.zeros(1), bias_temperature=None, bias_pressure=np.array([1e-6]),
        reference_pressure=1e5, sensitivities=(Sensitivity("supply", "V", 5.0, np.array([0.5])),),
    )  # fmt: skip
    raw = recording(
        Channel("rate", np.array([0.4, 0.4]), "rad/s"),
        Channel("bus", np.array([5000.0, 5200.0]), "mV"),
        Channel("chamber", np.array([100.0, 0.0]), "kPa"),
        Channel("dull", np.zeros(2)),
    )
    columns = {"x": "rate", "supply": "bus", "pressure": "chamber"}
    done = compensate_recording(model, raw, columns)
    np.testing.assert_allclose(done.channel("rate").data, [0.4, 0.4 - 0.1 + 0.1], rtol=1e-14)
    beside = compensate_recording(model, raw, {"x": "rate"}, pressure=1e5, channels={"supply": np.array([5.0, 5.2])})
    np.testing.assert_allclose(beside.channel("rate").data, [0.4, 0.3], rtol=1e-14)
    with pytest.raises(DataError, match="no supply given"):
        compensate_recording(model, raw, {"x": "rate", "pressure": "chamber"})
    with pytest.raises(DataError, match="column 'dull' has no unit"):
        compensate_recording(model, raw, columns | {"supply": "dull"})
