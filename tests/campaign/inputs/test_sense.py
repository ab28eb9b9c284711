"""What is impossible in a recording is left out and counted; a change of sign is an error with its row."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.campaign.file.recordings import ChannelEntry, RecordingEntry
from inertialcal.campaign.inputs.gate import Passed
from inertialcal.campaign.inputs.sense import sensible
from inertialcal.core.errors import DataError
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.procedures.protocol import Facts

N = 2000
FACTS = Facts("gyro", "deg/s", "rad/s", input_range=(-0.2, 0.2))
ENTRY = RecordingEntry(
    sensor="suite", file="run1.csv",
    channels={axis: ChannelEntry(column=axis, unit="rad/s") for axis in "xyz"}
    | {"temperature": ChannelEntry(column="temperature", unit="degC")},
)  # fmt: skip


def recording(**changed: np.ndarray) -> Recording:
    rng = np.random.default_rng(1)
    data = {axis: level + 1e-4 * rng.normal(size=N) for axis, level in zip("xyz", (0.01, -0.02, 0.03), strict=True)}
    data |= {"temperature": 20.0 + 0.01 * rng.normal(size=N)} | changed
    units = dict.fromkeys("xyz", "rad/s")
    channels = tuple(Channel(name, values, units.get(name, "degC"), "header") for name, values in data.items())
    return Recording(channels, sample_interval=0.1, source=Source("/somewhere/run1.csv"), first_row=2)


def judged(body: Recording, chosen: np.ndarray | None = None) -> Passed:
    return sensible("first", ENTRY, FACTS, body, body, at_rest=True, chosen=chosen)


def test_a_clean_recording_is_not_touched() -> None:
    found = judged(recording())
    assert (found.remarks, found.exclusions) == ((), ())


@pytest.mark.parametrize("wrong", [-400.0, 50_000.0])
def test_an_impossible_temperature_is_named_and_counted_and_gone(wrong: float) -> None:
    values = np.full(N, 20.0)
    values[[500, 501]] = wrong
    found = judged(recording(temperature=values))
    gone = found.recording.channel("temperature").data
    assert np.flatnonzero(np.isnan(gone)).tolist() == [500, 501]
    (remark,), (out,) = found.remarks, found.exclusions
    assert (remark.code, remark.where, remark.recording) == ("impossible_temperature", "run1.csv:502", "first")
    assert (out.rule, out.count, out.counts) == ("impossible", 2, "sample")


def test_nothing_but_impossible_values_is_refused() -> None:
    with pytest.raises(DataError) as refused:
        judged(recording(temperature=np.full(N, -400.0)))
    (problem,) = refused.value.problems
    assert (problem.code, problem.where) == ("impossible_temperature", "run1.csv:2")


def test_a_reading_far_beyond_the_range_of_the_sensor() -> None:
    body = recording()
    body.channel("y").data[7] = 1.5
    (remark,) = judged(body).remarks
    assert (remark.code, remark.axis, remark.where) == ("beyond_range", "y", "run1.csv:9")


def test_a_change_is_an_error_where_the_test_takes_samples() -> None:
    body = recording()
    for axis in "xyz":
        body.channel(axis).data[1200:] *= -1.0
    (remark,) = judged(body).remarks
    assert (remark.code, remark.severity, remark.where) == ("sign_changed", "error", "run1.csv:1202")
    assert judged(body, np.arange(N) < 1000).remarks == ()
    (remark,) = judged(body, np.arange(N) > 500).remarks
    assert remark.where == "run1.csv:1202"


def test_a_change_to_a_unit_beyond_the_range_is_named_though_the_samples_are_left_out() -> None:
    body = recording()
    for axis in "xyz":
        body.channel(axis).data[1200:] *= 180.0 / np.pi
    found = judged(body)
    assert {one.code for one in found.remarks} == {"beyond_range", "unit_changed"}
    assert np.isnan(found.recording.channel("x").data[1300:]).all()


def test_columns_change_places_as_the_sensor_has_them() -> None:
    body = recording()
    x, y = (body.channel(axis).data for axis in "xy")  # x is mounted inverted: the column has -x
    x[1200:], y[1200:] = -y[1200:].copy(), -x[1200:].copy()
    mounting = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]
    (remark,) = sensible("first", ENTRY, FACTS, body, body, at_rest=True, mounting=mounting).remarks
    assert remark.code == "axes_changed"
    assert "x goes on as y, y goes on as x" in remark.what


def test_a_unit_shows_in_the_columns_where_a_bias_was_taken_off() -> None:
    raw = recording()
    raw = replace(raw, channels=tuple(replace(raw.channel(axis), unit="m/s^2") for axis in "xyz"))
    for axis in "xyz":
        raw.channel(axis).data[1200:] /= 9.80665
    body = replace(raw, channels=tuple(replace(one, data=one.data - 0.1) for one in raw.channels))
    facts = Facts("accelerometer", "m/s^2", "m/s^2")
    channels = {axis: ChannelEntry(column=axis, unit="m/s^2") for axis in "xyz"}
    entry = RecordingEntry(sensor="suite", file="run1.csv", channels=channels)
    (remark,) = sensible("first", entry, facts, raw, body, at_rest=True).remarks
    assert remark.code == "unit_changed"


def test_a_column_that_the_test_does_not_read_is_named() -> None:
    body = recording()
    raw = Recording((*body.channels, Channel("air", np.full(N, -300.0), "degC", "header")), first_row=2)
    found = sensible("first", ENTRY, FACTS, raw, body, at_rest=True)
    (remark,) = found.remarks
    assert (remark.code, remark.severity) == ("impossible_temperature", "warning")
    assert found.exclusions == ()
