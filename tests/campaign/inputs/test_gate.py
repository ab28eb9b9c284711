"""The gate: samples that are no readings are left out of what a procedure sees, named and counted."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.file.recordings import ChannelEntry, RecordingEntry
from inertialcal.campaign.file.sensors import Sensor
from inertialcal.campaign.inputs import gate as module
from inertialcal.campaign.inputs.gate import Gate, Passed, passed, without_stuck
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.signals.screening.screen import Screening, screen

N = 4000
MIXING = ((1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (0.0, -0.8, 0.6))
SENSOR = Sensor.model_validate({"kind": "gyro", "axes": ["x", "y", "z"], "unit": "rad/s", "chain": {"kind": "none"}})
ENTRY = RecordingEntry(
    sensor="suite", file="run1.csv", channels={axis: ChannelEntry(column=f"g{axis}", unit="rad/s") for axis in "xyz"}
)


def recording(names: tuple[str, ...], width: type = np.float64) -> Recording:
    rng = np.random.default_rng(1)
    channels = tuple(Channel(name, rng.normal(size=N).astype(width), "rad/s", "header") for name in names)
    return Recording(channels, sample_interval=0.01, source=Source("/somewhere/run1.csv"), first_row=2)


def seen(raw: Recording, sensor: Sensor = SENSOR, gate: Gate | None = None, **more: object) -> Passed:
    body = Recording(
        tuple(Channel(one.name[1], one.data, "rad/s", "header") for one in raw.channels), sample_interval=0.01
    )
    return passed(gate or Gate(), "first", ENTRY, sensor, raw, body, at_rest=False, **more)  # type: ignore[arg-type]


def test_a_clean_recording_is_not_touched() -> None:
    found = seen(recording(("gx", "gy", "gz")))
    assert (found.remarks, found.exclusions) == ((), ())


@pytest.mark.parametrize("width", [np.float32, np.float64])
def test_a_glitch_is_named_and_counted_and_gone(width: type[np.float32] | type[np.float64]) -> None:
    raw = recording(("gx", "gy", "gz"), width)
    raw.channels[1].data[1234] = -32768.0
    found = seen(raw)
    y = found.recording.channel("y").data
    assert np.flatnonzero(np.isnan(y)).tolist() == [1234]
    assert y.dtype == width
    assert raw.channels[1].data[1234] == -32768.0
    (remark,) = found.remarks
    assert (remark.code, remark.where, remark.axis) == ("glitch", "run1.csv:1236", "y")
    assert remark.what.startswith("recording first: gy: 1 of 4000 samples")
    (out,) = found.exclusions
    assert (out.rule, out.decided_by, out.count, out.counts) == ("screened", "screening: glitch", 1, "sample")


def test_a_mounting_that_mixes_sensors_spoils_the_axes_that_it_enters() -> None:
    raw = recording(("gx", "gy", "gz"))
    raw.channels[1].data[7] = 1e6
    found = seen(raw, SENSOR.model_copy(update={"mounting": MIXING}))
    lost = {one.name: int(np.isnan(one.data).sum()) for one in found.recording.channels}
    assert lost == {"x": 0, "y": 1, "z": 1}
    assert [one.count for one in found.exclusions] == [1]


def test_of_samples_that_the_test_does_not_take_nothing_is_said() -> None:
    raw = recording(("gx", "gy", "gz"))
    raw.channels[0].data[[10, 3000]] = 1e6
    found = seen(raw, chosen=np.arange(N) > 2000)
    assert [(one.where, one.count) for one in found.remarks] == [("run1.csv:3002", 1)]
    assert [one.count for one in found.exclusions] == [1]


def test_a_column_is_looked_through_once(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[int] = []

    def counted(x: Any, at_rest: bool) -> Screening:
        looked.append(len(x))
        return screen(x, at_rest)

    monkeypatch.setattr(module, "screen", counted)
    gate = Gate()
    for _ in range(3):
        seen(recording(("gx", "gy", "gz")), gate=gate)
    assert len(looked) == 3


def test_a_stuck_temperature_is_named_and_gone() -> None:
    time = np.arange(N)
    rng = np.random.default_rng(2)
    true = 20.0 + 10.0 * np.sin(time / 600.0) + 0.01 * rng.normal(size=N)
    true[N // 2 :] = true[N // 2]
    raw = recording(("gx",))
    raw = replace(raw, channels=(*raw.channels, Channel("temp", np.round(true, 3), "degC", "header")))
    channels = {"x": ChannelEntry(column="gx"), "temperature": ChannelEntry(column="temp", unit="degC")}
    entry = RecordingEntry(sensor="suite", file="run1.csv", channels=channels)
    body = replace(
        raw, channels=tuple(replace(one, name=name) for one, name in zip(raw.channels, channels, strict=True))
    )
    found = without_stuck("first", entry, raw, body)
    (remark,), (exclusion,) = found.remarks, found.exclusions
    assert (remark.code, remark.where, remark.subject) == ("stuck", f"run1.csv:{N // 2 + 2}", "temp")
    assert remark.what.startswith("recording first: temp stays at")
    assert (exclusion.rule, exclusion.count) == ("screened", N // 2)
    gone = np.isnan(found.recording.channel("temperature").data)
    assert gone.tolist() == [False] * (N // 2) + [True] * (N // 2)
    assert not np.isnan(found.recording.channel("x").data).any()
