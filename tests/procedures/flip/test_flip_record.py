"""A recording of a turned head without a campaign file: its axes, its windows, given or found."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from inertialcal.core.errors import UsageError
from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.procedures import PROCEDURES
from inertialcal.procedures.flip.dwells.quiet import Window
from inertialcal.procedures.flip.entry import Position
from inertialcal.procedures.flip.given import described, found_windows
from inertialcal.procedures.flip.inputs import windows_of
from inertialcal.procedures.given import GivenFile, Said

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


def file_of(recording: Recording, *together: Recording, **said: Any) -> GivenFile:
    """A recording in memory, with what the caller says; ``units`` and the like, and the flip's own settings."""
    common = {name: said.pop(name) for name in ("columns", "mission_start") if name in said}
    files: list[GivenFile] = []
    for number, one in enumerate((recording, *together), 1):

        def read(one: Recording = one, **_: Any) -> Recording:
            return one

        files.append(GivenFile(f"{number}.csv", Said(**common), said, {}, read, no_table, has_rows=False,
                               number=number, together=files))  # fmt: skip
    return files[0]


def no_table() -> Any:
    raise AssertionError


def windows(recording: Recording, *together: Recording, **said: Any) -> list[Window]:
    """Windows of a recording, on its clock."""
    own = file_of(recording, *together, **said)
    positions = described(own, PROCEDURES["flip"].inputs).entry["positions"]
    return list(windows_of([Position.model_validate(one) for one in positions], recording, "head"))


def test_axes_and_units_are_taken_by_their_names() -> None:
    found = described(file_of(head((600.0,), unit="g")), PROCEDURES["flip"].inputs)
    assert found.entry["channels"] == {axis: {"column": axis, "unit": "g"} for axis in "xyz"}
    assert found.sensor == {"kind": "accelerometer", "axes": ["x", "y", "z"], "unit": "g"}


def test_a_head_that_feels_next_to_nothing_is_shown_in_ug() -> None:
    recording = head((600.0,), unit="g")
    small = replace(recording, channels=tuple(replace(one, data=1e-6 * one.data) for one in recording.channels))
    assert described(file_of(small), PROCEDURES["flip"].inputs).sensor["unit"] == "ug"


def test_columns_may_be_named() -> None:
    found = described(file_of(head((600.0,)), columns={"x": "z"}), PROCEDURES["flip"].inputs)
    assert found.entry["channels"] == {"x": {"column": "z", "unit": "ug"}}


def test_temperatures_and_gains_are_taken_along() -> None:
    recording = head((600.0,))
    warm = Channel("warm", np.full(len(recording), 18.0), "degC", "header", "", "temperature")
    gain = Channel("gain_y", np.full(len(recording), 10.0))
    found = described(
        file_of(replace(recording, channels=(*recording.channels, warm, gain))), PROCEDURES["flip"].inputs
    )
    assert found.entry["channels"]["temperature"] == {"column": "warm", "unit": "degC"}
    assert found.entry["channels"]["gain_y"] == {"column": "gain_y", "unit": "1"}


@pytest.mark.parametrize(
    ("recording", "words"),
    [
        (Recording((Channel("t1", np.zeros(9)),)), r"no time \(windows are found on a clock\)"),
        (
            Recording((Channel("t1", np.zeros(9)),), np.arange(9) * SECOND, 1.0),
            "cannot tell which column is which axis of the accelerometer",
        ),
        (head((), unit="deg/s"), r"unit missing or of the wrong kind: 'x' \(deg/s\)"),
        (head((), unit=""), r"unit missing or of the wrong kind: 'x' \(\?\)"),
        (head((), unit="count"), r"counts and volts need the chain of the sensor"),
    ],
)
def test_what_is_no_accelerometer_is_refused(recording: Recording, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        described(file_of(recording), PROCEDURES["flip"].inputs)


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
    times = "000/00:10:00 to 000/00:10:05, 000/00:20:00 to 000/00:20:05"
    assert told.what == f"2 turns found: {times}: 0 deg before the first, then 180 deg and 0 deg by turns"


def test_windows_that_reach_into_each_other_are_one() -> None:
    windows, _ = found_windows(head((600.0, 800.0)), math.pi)
    assert [window.angle for window in windows] == [0.0, math.pi, 0.0]
    assert all(a.stop <= b.start for a, b in pairwise(windows))


def test_the_angle_of_the_turns_is_that_which_is_said() -> None:
    windows, remarks = found_windows(head((900.0,), start=UTC), 1.5)
    assert [window.angle for window in windows] == [0.0, 1.5]
    assert any(one.what.startswith("1 turn found: 1996-02-20T12:15:00Z to ") for one in remarks)


def test_a_record_without_a_turn_is_refused_and_its_length_told() -> None:
    with pytest.raises(UsageError, match="no turn of the head found in 1800 s") as caught:
        found_windows(head(()), math.pi)
    assert "windows" in caught.value.problems[0].do


def test_given_windows_are_on_the_clock_of_the_record() -> None:
    (own,) = windows(head(()), windows=["60..000/00:05:00=0 deg"])
    assert (own.start, own.stop) == (60 * SECOND, 300 * SECOND)
    (own,) = windows(head((), start=UTC), windows=["1996/051/12:01:00..1996-02-20T12:05:00Z=0 deg"])
    assert (own.start - UTC, own.stop - UTC) == (60 * SECOND, 300 * SECOND)
    with pytest.raises(UsageError, match="mission elapsed time, but when the mission started is not said"):
        windows(head((), start=UTC), windows=["006/00:14:40..006/00:20:00=0 deg"])
    with pytest.raises(UsageError, match=r"window 300\.\.60: from 300 to 60: the end must be after the start"):
        windows(head(()), windows=["300..60=0 deg"])


def test_mission_elapsed_time_counts_from_the_start_of_the_mission() -> None:
    said = ["005/11:30:00..005/11:40:00=0 deg"]
    (own,) = windows(head((), start=UTC), windows=said, mission_start="1996-02-15T00:30:00Z")
    assert (own.start - UTC, own.stop - UTC) == (0, 600 * SECOND)


def test_each_recording_has_the_windows_that_lie_in_it() -> None:
    early, late = head((), seconds=100.0), head((), seconds=100.0)
    assert late.time_ns is not None
    late = replace(late, time_ns=late.time_ns + 500 * SECOND)
    said = ["10..20=0 deg", "510..520=90 deg"]
    assert [one.angle for one in windows(early, late, windows=said)] == [0.0]
    assert [one.angle for one in windows(late, early, windows=said)] == pytest.approx([math.pi / 2.0])
    with pytest.raises(UsageError, match=r"window 300\.\.310: lies in no recording"):
        windows(early, late, windows=["300..310=0 deg"])
    with pytest.raises(UsageError, match="no window lies in it"):
        windows(early, late, windows=["510..520=0 deg"])


def test_a_push_by_which_the_level_stays_is_no_turn() -> None:
    recording = head((600.0, 1200.0))
    seconds = np.arange(len(recording)) / RATE
    x = recording.channel("x").data.copy()
    x[(seconds > 300.0) & (seconds < 302.0)] += 500.0  # somebody pushes: the level returns
    pushed = replace(recording, channels=tuple(replace(c, data=x) if c.name == "x" else c for c in recording.channels))
    (told,) = [one for one in found_windows(pushed, np.pi)[1] if one.code == "turns_found"]
    assert told.what.startswith("2 turns found")  # the level stays: a turn there is excluded
