"""Part of a recording by time: half-open, in UTC or on its own clock, counted."""

from __future__ import annotations

from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError, InertialcalError, UsageError

ELAPSED = "t [s],x [g]\n" + "".join(f"{i}.0,{i}\n" for i in range(10))
UTC = "time,x [g]\n" + "".join(f"2010-04-28T15:10:0{i}Z,{i}\n" for i in range(10))


def write(folder: Path, text: str) -> Path:
    path = folder / "a.csv"
    path.write_text(text, encoding="ascii")
    return path


def test_the_start_belongs_to_it_and_the_stop_does_not(tmp_path: Path) -> None:
    found = ic.read(write(tmp_path, ELAPSED), start=3, stop="6.0")
    assert found.channel("x [g]").data.tolist() == [3, 4, 5]
    assert found.first_row == 5  # of the file: the header is row 1
    assert [one.what for one in found.remarks if one.code == "cut_to_times"] == [
        "3 of 10 samples are in the requested time window"
    ]


@pytest.mark.parametrize(
    ("start", "mission"),
    [
        ("2010-04-28T15:10:07Z", None),
        ("2010/118/15:10:07", None),
        ("1272467407", None),
        (1272467407.0, None),
        ("001/00:00:07", "2010-04-27T15:10:00Z"),
        ("001/00:00:07", "1272381000.0"),
    ],
)
def test_all_ways_to_say_a_time(tmp_path: Path, start: object, mission: object) -> None:
    found = ic.read(write(tmp_path, UTC), start=start, mission_start=mission)
    assert found.channel("x [g]").data.tolist() == [7, 8, 9]


def test_elapsed_time_in_days(tmp_path: Path) -> None:
    assert len(ic.read(write(tmp_path, ELAPSED), start="000/00:00:08")) == 2


def test_stamps_out_of_order_are_chosen_one_by_one(tmp_path: Path) -> None:
    text = "t [s],x [g]\n" + "".join(f"{i},{i}\n" for i in [0.0, 1.0, 5.0, 2.0, 3.0, 4.0, *range(6, 30)])
    found = ic.read(write(tmp_path, text), stop=3.5)
    assert found.channel("x [g]").data.tolist() == [0, 1, 2, 3]
    assert found.first_row == 0


@pytest.mark.parametrize(
    ("text", "options", "kind", "code", "words"),
    [
        (ELAPSED, {"start": 20}, DataError, "nothing_left", "runs from 0 s to 9 s"),
        (UTC, {"stop": "2009-01-01T00:00:00Z"}, DataError, "nothing_left", "runs from 2010-04-28T15:10:00Z to"),
        (UTC, {"start": 20, "stop": 10}, UsageError, "wrong_time", "from 20 to 10: the end must be after the start"),
        (UTC, {"start": "noon"}, UsageError, "wrong_time", "'noon' is no time"),
        (UTC, {"start": "2014_10_22_09"}, UsageError, "wrong_time", "is no time"),
        (UTC, {"start": "001/00:00"}, UsageError, "no_mission_start", "when the mission started is not said"),
        (ELAPSED, {"start": "2010-04-28T15:10:00Z"}, UsageError, "wrong_time", "has elapsed time"),
        ("x [g]\n1\n2\n3\n", {"start": 1}, DataError, "no_time", "need a time column"),
    ],
)
def test_windows_that_cannot_be(
    tmp_path: Path, text: str, options: dict[str, object], kind: type[InertialcalError], code: str, words: str
) -> None:
    with pytest.raises(kind) as caught:
        ic.read(write(tmp_path, text), **options)  # type: ignore[arg-type]
    assert caught.value.problems[0].code == code
    assert words in str(caught.value)
