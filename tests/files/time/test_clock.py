"""Clock: which column is time, in which unit - and which never is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.core.recording import Recording
from inertialcal.files import read

NOW = 1_283_358_139  # 2010-09-01T16:22:19Z


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "a.csv"


def table(path: Path, header: str, *columns: object, rows: int = 30) -> Path:
    lines = [header] if header else []
    for i in range(rows):
        lines.append(",".join(str(c(i) if callable(c) else c) for c in columns))
    path.write_text("\n".join(lines) + "\n")
    return path


def noise(i: int) -> float:
    return (i * 7919 % 101) / 100


def codes(recording: Recording) -> list[str]:
    return [remark.code for remark in recording.remarks]


def stamps(recording: Recording) -> list[int]:
    assert recording.time_ns is not None
    return [int(t) for t in recording.time_ns[:2]]


@pytest.mark.parametrize("name", ["n_samples", "samples", "sample", "index", "frame", "count_", "", "seq"])
def test_an_index_is_never_time(file: Path, name: str) -> None:
    recording = read(table(file, f"{name},gyro_x", lambda i: i, noise))
    assert recording.time_ns is None
    assert recording.sample_interval is None
    assert recording.channels[0].quantity == "index"


def test_an_index_without_header_is_never_time(file: Path) -> None:
    for first in (0, 1):
        recording = read(table(file, "", lambda i, first=first: float(i + first), noise))
        assert recording.time_ns is None
        assert recording.channels[0].quantity == "index"


@pytest.mark.parametrize(
    ("header", "scale", "rate"),
    [("t_s", 0.01, 100.0), ("time [ms]", 10, 100.0), ("timestamp (us)", 2500, 400.0), ("time_ns", 10**6, 1000.0)],
)
def test_the_unit_of_the_header(file: Path, header: str, scale: float, rate: float) -> None:
    recording = read(table(file, f"{header},gyro_x", lambda i: i * scale, noise))
    assert recording.sample_rate == pytest.approx(rate)
    assert (recording.interval_from, recording.time_column) == ("column", header)
    assert recording.epoch == "elapsed"
    assert recording.names == ("gyro_x",)
    assert codes(recording) == []


@pytest.mark.parametrize("power", [0, 3, 6, 9])
def test_an_epoch_is_told_by_its_digits_and_remarked(file: Path, power: int) -> None:
    recording = read(table(file, "timestamp,gyro_x", lambda i: (NOW + 2 * i) * 10**power, noise))
    assert (recording.epoch, recording.sample_interval) == ("utc", 2.0)
    assert stamps(recording) == [NOW * 10**9, (NOW + 2) * 10**9]
    (remark,) = recording.remarks
    assert remark.code == "epoch_inferred"
    assert "from 2010-09-01T16:22:19Z" in remark.what


def test_an_epoch_with_its_unit_needs_no_remark(file: Path) -> None:
    recording = read(table(file, "unix_s,gyro_x", lambda i: NOW + i, noise))
    assert (recording.epoch, codes(recording)) == ("utc", [])


@pytest.mark.parametrize("header", ["unix", "timestamp", "unix_s", "time [s]", "epoch"])
def test_an_eleven_digit_epoch(file: Path, header: str) -> None:
    with pytest.raises(DataError) as caught:
        read(table(file, f"{header},x", lambda i: 12_833_581_390 + i, noise))
    (problem,) = caught.value.problems
    assert problem.code == "epoch_digits"
    assert problem.where == f"{file}:2"
    assert problem.what == f"stamp 12833581390 in {header!r} has 11 digits (30 such stamps)"
    assert problem.why == "seconds since 1970 have 10 digits, milliseconds 13: one digit too many?"


def test_one_stamp_with_a_surplus_digit(file: Path) -> None:
    with pytest.raises(DataError, match=r"a\.csv:9: stamp 12833581460 in 'unix' has 11 digits \(seconds"):
        read(table(file, "unix,x", lambda i: NOW + i if i != 7 else 12_833_581_460, noise))


def test_eleven_digits_of_nanoseconds_are_no_epoch(file: Path) -> None:
    recording = read(table(file, "timestamp,x", lambda i: 12_833_581_390 + i * 10**6, noise))
    assert recording.time_ns is None
    (remark,) = recording.remarks
    assert remark.code == "time_unit_unknown"
    assert "in ns 1000 Hz" in remark.what
    told = read(file, units={"timestamp": "ns"})
    assert told.sample_rate == 1000.0


def test_whole_numbers_without_unit_are_not_taken(file: Path) -> None:
    recording = read(table(file, "time,gyro_x", lambda i: 10 * i, noise))
    assert recording.time_ns is None
    (remark,) = recording.remarks
    assert remark.what == (
        "'time' has whole numbers without a unit, so it is not used as time: in s 0.1 Hz over 290 s; "
        "in ms 100 Hz over 0.29 s"
    )
    assert remark.do == "Add --unit time=UNIT"
    for units in ({"time": "ms"}, {"1": "ms"}):
        assert read(file, units=units).sample_rate == 100.0


def test_fractions_without_unit_are_seconds_and_remarked(file: Path) -> None:
    recording = read(table(file, "t,gyro_x", lambda i: i / 64, noise))
    assert recording.sample_rate == 64.0
    assert codes(recording) == ["time_unit_assumed"]


def test_a_column_of_dates(file: Path) -> None:
    recording = read(table(file, "when,x", lambda i: f"2010-09-01T16:22:{i:02d}Z", noise))
    assert (recording.epoch, recording.sample_interval, codes(recording)) == ("utc", 1.0, [])
    assert stamps(recording)[0] == (NOW - 19) * 10**9
    naive = read(table(file, "x,utc", noise, lambda i: f"2010-09-01 16:22:{i:02d}.5"))
    assert codes(naive) == ["naive_time"]
    assert stamps(naive)[0] == (NOW - 19) * 10**9 + 500_000_000


def test_a_date_that_is_none(file: Path) -> None:
    days = [f"2010-09-01T16:22:{i:02d}Z" for i in range(30)]
    days[4] = "2010-09-31T16:22:04Z"
    with pytest.raises(
        DataError, match=r"a\.csv:6: '2010-09-31T16:22:04Z' in time column 'when' is not a date and time"
    ):
        read(table(file, "when,x", lambda i: days[i], noise))


def test_without_a_header_fractions_that_increase_are_time(file: Path) -> None:
    recording = read(table(file, "", lambda i: 0.5 + i / 128, noise, noise))
    assert recording.sample_rate == 128.0
    assert recording.names == ("column_2", "column_3")
    (remark,) = recording.remarks
    assert remark.what == "'column_1' has no name; it always increases: used as time in seconds"


def test_without_a_header_whole_numbers_are_pointed_out_only(file: Path) -> None:
    recording = read(table(file, "", lambda i: 10 * i, noise))
    assert recording.time_ns is None
    assert codes(recording) == ["time_not_taken"]
    told = read(file, time_column="1", units={"1": "ms"})
    assert told.sample_rate == 100.0


def test_without_a_header_anything_else_is_no_time(file: Path) -> None:
    for first in (noise, lambda i: 1.5):
        assert read(table(file, "", first, noise)).time_ns is None
    assert read(table(file, "", lambda i: i / 8, noise, rows=9)).time_ns is None  # too short to be sure
    assert read(table(file, "", lambda i: i / 8)).time_ns is None  # nothing is left to be measured


def test_the_column_that_is_named_is_taken(file: Path) -> None:
    table(file, "t_s,clock,x", lambda i: i, lambda i: i / 4, noise)
    recording = read(file, time_column="clock")
    assert recording.sample_rate == 4.0
    assert recording.names == ("t_s", "x")
    assert read(file, time_column="2").sample_rate == 4.0


@pytest.mark.parametrize(
    ("column", "code", "words"),
    [
        ("x", "not_time", "'x' is not time: .* of its steps go backward"),
        ("still", "not_time", "'still' is not time: it stands still"),
        ("gone", "time_missing", "time column 'gone' has empty cells"),
        ("whole", "time_unit_unknown", "'whole' has whole numbers without a unit"),
        ("volt_V", "not_time", "'volt_V' is in V"),
        ("label", "text_in_numbers", "'a' in time column 'label' is not a date and time"),
        ("none", "wrong_column", "no column 'none'. The file has: x, still"),
        ("9", "wrong_column", "no column '9'"),
    ],
)  # fmt: skip
def test_a_column_that_cannot_be_time(file: Path, column: str, code: str, words: str) -> None:
    header = "x,still,gone,whole,volt_V,label"
    table(file, header, noise, 7.5, lambda i: "" if i == 3 else i / 2, lambda i: 3 * i, lambda i: i / 2, "a")
    with pytest.raises(DataError, match=words) as caught:
        read(file, time_column=column)
    assert caught.value.problems[0].code == code


def test_time_that_runs_backward_is_remarked_and_not_taken(file: Path) -> None:
    recording = read(table(file, "t_s,x", lambda i: (i % 3) / 2, noise))
    assert recording.time_ns is None
    assert codes(recording)[0] == "not_time"


def test_stamps_beyond_int64(file: Path) -> None:
    with pytest.raises(DataError, match="span more than 292 years"):
        read(table(file, "clock,x", lambda i: (i + 1) * 1e9, noise), time_column="clock", units={"clock": "h"})


def test_the_column_with_a_unit_goes_first(file: Path) -> None:
    recording = read(table(file, "time,unix_s,x", lambda i: i / 3, lambda i: NOW + i, noise))
    assert recording.interval_origin == "time column 'unix_s'"


def test_a_rate_from_elsewhere_goes_before_the_stamps(file: Path) -> None:
    recording = read(table(file, "t_s,x", lambda i: i / 100, noise), sample_rate=102.4)
    assert recording.interval_from == "flag"
    assert recording.sample_rate == pytest.approx(102.4)
    assert str(recording.remarks[0]) == (
        f"warning: {file}: 102.4 Hz was given, the time stamps say 100 Hz. "
        "Check the rate, and the unit of time: --unit COLUMN=UNIT"
    )


@pytest.mark.parametrize(
    ("header", "step", "rate", "severity", "words"),
    [
        ("t_s", 0.1, 0.1, "error", "the time stamps say 10 Hz"),
        ("time", 10, 0.5, "error", "'time' in s says 0.1 Hz, 'time' in ms says 100 Hz"),
        ("time", 10, 100.0, "", ""),
        ("time", 10, 104.0, "warning", "'time' in ms says 100 Hz"),
        ("t_s", 0.1, 10.05, "", ""),
    ],
)
def test_a_rate_that_contradicts_the_stamps(
    file: Path, header: str, step: float, rate: float, severity: str, words: str
) -> None:
    recording = read(table(file, f"{header},x", lambda i: round(i * step, 3), noise), sample_rate=rate)
    found = [one for one in recording.remarks if one.code == "sample_rate_disagrees"]
    assert [one.severity for one in found] == [severity] * bool(severity)
    assert all(words in one.what and f"{rate:g} Hz was given" in one.what for one in found)


def test_a_rate_that_contradicts_a_comment(file: Path) -> None:
    file.write_text("# sample rate: 50 Hz\nx\n" + "\n".join(str(noise(i)) for i in range(30)))
    (remark,) = read(file, sample_rate=10.0).remarks
    assert (remark.code, remark.severity) == ("sample_rate_disagrees", "error")
    assert remark.what == "10 Hz was given, the header says 50 Hz"


def test_a_rate_in_a_comment(file: Path) -> None:
    file.write_text("# sample rate: 50 Hz\nx\n" + "\n".join(str(noise(i)) for i in range(30)))
    recording = read(file)
    assert (recording.sample_rate, recording.interval_from) == (50.0, "header")


@pytest.mark.parametrize("rate", [0.0, -1.0, np.inf, np.nan])
def test_a_rate_that_is_none(file: Path, rate: float) -> None:
    with pytest.raises(InertialcalError, match=r"a sample rate of .* Hz"):
        read(table(file, "x", noise), sample_rate=rate)
