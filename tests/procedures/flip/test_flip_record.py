"""A recording of a turned head without a campaign file: its axes, its windows, given or found."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from inertialcal.core.errors import UsageError
from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.core.units import factor
from inertialcal.procedures.flip.files.record import Said, found_windows, given_windows, head_recording

RATE = 5.0
UTC = 824_817_600 * SECOND  # 1996-02-20 12:00:00


def head(turns: tuple[float, ...], seconds: float = 1800.0, start: int = 0, unit: str = "ug") -> Recording:
    """A head that starts at 0 and is turned by 180 deg and back."""
    t: Array = np.asarray(np.arange(round(seconds * RATE)) / RATE, dtype=np.float64)
    sign = np.where(np.searchsorted(turns, t, side="right") % 2 == 0, 1.0, -1.0)
    x = np.random.default_rng(1).normal([100.0, 900.0, -1200.0], 1.0, (len(t), 3))
    x[:, 1] += 5.0 * sign
    x[:, 2] -= 4.0 * sign
    for turn in turns:
        x[(t >= turn) & (t < turn + 5.0)] += 500.0
    time = start + np.rint(t * SECOND).astype(np.int64)
    channels = tuple(Channel(name, x[:, i].copy(), unit, "header", name) for i, name in enumerate("xyz"))
    return Recording(channels, time, 1.0 / RATE, epoch="utc" if start else "elapsed")


def test_axes_are_taken_by_their_names_and_become_SI() -> None:
    found = head_recording(head(()), None, None)
    assert found.names == ("x", "y", "z")
    assert found.channel("y").unit == "m/s^2"
    assert np.mean(found.channel("y").data) == pytest.approx(905.0 * factor("ug", "m/s^2"), rel=1e-3)


def test_columns_may_be_named_and_their_unit_said() -> None:
    found = head_recording(head(()), {"x": "z"}, "mg")
    assert found.names[0] == "x"
    assert np.mean(found.channel("x").data) == pytest.approx(-1204.0 * factor("mg", "m/s^2"), rel=1e-3)


@pytest.mark.parametrize(
    ("recording", "unit", "words"),
    [
        (Recording((Channel("t1", np.zeros(9)),)), None, "no channel is clearly an axis of an accelerometer"),
        (head((), unit="deg/s"), None, "'x' is in deg/s, need a unit of acceleration"),
        (head((), unit=""), None, "'x' is in no unit, need a unit of acceleration"),
        (head(()), "count", "'x' is in count, need a unit of acceleration"),
    ],
)
def test_what_is_no_accelerometer_is_refused(recording: Recording, unit: str | None, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        head_recording(recording, None, unit)


def test_the_windows_beside_the_turns_are_found_equally_long_with_their_positions() -> None:
    windows, remarks = found_windows(head((600.0, 1200.0)), math.pi)
    assert [window.angle for window in windows] == [0.0, math.pi, math.pi, 0.0]
    assert {window.flip for window in windows} == {"1"}
    lengths = [(window.stop - window.start) / SECOND for window in windows]
    assert lengths == pytest.approx([180.0] * 4)  # a tenth of the record
    for window in windows:
        seconds = np.arange(window.start, window.stop, SECOND) / SECOND
        assert not np.any(((seconds > 599.0) & (seconds < 606.0)) | ((seconds > 1199.0) & (seconds < 1206.0)))
    (told,) = [one for one in remarks if one.code == "turns_found"]
    assert told.what == "2 turns found, at 000/00:10:00, 000/00:20:00: 0 deg before, 180 deg after, and so on by turns"


def test_windows_that_reach_into_each_other_are_one() -> None:
    windows, _ = found_windows(head((600.0, 800.0)), math.pi)
    assert [window.angle for window in windows] == [0.0, math.pi, 0.0]
    assert all(a.stop <= b.start for a, b in pairwise(windows))


def test_the_angle_of_the_turns_is_that_which_is_said() -> None:
    windows, remarks = found_windows(head((900.0,), start=UTC), 1.5)
    assert [window.angle for window in windows] == [0.0, 1.5]
    assert any(one.what.startswith("1 turn found, at 1996-02-20T12:15:00Z: 0 deg before, 85.94") for one in remarks)


def test_a_record_without_a_turn_is_refused_and_its_length_told() -> None:
    with pytest.raises(UsageError, match="no turn of the head is seen in 1800 s") as caught:
        found_windows(head(()), math.pi)
    assert "--window" in caught.value.problems[0].do


def test_given_windows_are_on_the_clock_of_the_record() -> None:
    (windows,) = given_windows([head(())], [Said("60", "000/00:05:00", 0.0)])
    assert (windows[0].start, windows[0].stop) == (60 * SECOND, 300 * SECOND)
    (windows,) = given_windows([head((), start=UTC)], [Said("1996/051/12:01:00", "1996-02-20T12:05:00Z", 0.0)])
    assert (windows[0].start - UTC, windows[0].stop - UTC) == (60 * SECOND, 300 * SECOND)
    with pytest.raises(UsageError, match="mission elapsed time, but when the mission started is not said"):
        given_windows([head((), start=UTC)], [Said("006/00:14:40", "006/00:20:00", 0.0)])
    with pytest.raises(UsageError, match=r"--window 300\.\.60: from 300 to 60: the end is not after the start"):
        given_windows([head(())], [Said("300", "60", 0.0)])


def test_mission_elapsed_time_counts_from_the_start_of_the_mission() -> None:
    said = [Said("005/11:30:00", "005/11:40:00", 0.0)]
    (windows,) = given_windows([head((), start=UTC)], said, "1996-02-15T00:30:00Z")
    assert (windows[0].start - UTC, windows[0].stop - UTC) == (0, 600 * SECOND)


def test_counts_are_sent_to_a_campaign() -> None:
    counts = Recording(tuple(Channel(name, np.arange(9), None, "", name) for name in "xyz"))
    with pytest.raises(UsageError, match="counts become readings by gain, zero and scale factor"):
        head_recording(counts, None, None)


def test_an_axis_that_is_not_named_is_not_taken() -> None:
    """It would be read in the unit of the file as if that were SI."""
    assert head_recording(head((), unit="ug"), {"y": "y"}, None).names == ("y",)
    with pytest.raises(UsageError, match="--column: axis 'w'"):
        head_recording(head(()), {"w": "y"}, None)


def test_each_recording_has_the_windows_that_lie_in_it() -> None:
    early, late = head((), seconds=100.0), head((), seconds=100.0)
    assert late.time_ns is not None
    late = Recording(late.channels, late.time_ns + 500 * SECOND, late.sample_interval)
    first, second = given_windows([early, late], [Said("10", "20", 0.0), Said("510", "520", 1.0)])
    assert ([one.angle for one in first], [one.angle for one in second]) == ([0.0], [1.0])
    with pytest.raises(UsageError, match=r"--window 300\.\.310: lies in none of the 2 recordings"):
        given_windows([early, late], [Said("300", "310", 0.0)])


def test_a_spike_that_may_be_a_turn_makes_the_positions_doubtful() -> None:
    recording = head((600.0, 1200.0))
    seconds = np.arange(len(recording)) / RATE
    x = recording.channel("x").data.copy()
    x[(seconds > 300.0) & (seconds < 302.0)] += 500.0  # somebody pushes: the level returns
    pushed = replace(recording, channels=tuple(replace(c, data=x) if c.name == "x" else c for c in recording.channels))
    (told,) = [one for one in found_windows(pushed, np.pi)[1] if one.code == "turns_found"]
    assert told.severity == "warning"
    assert "the spike at 000/00:05:00 is not taken for a turn: if one is, positions and the sign" in told.what
