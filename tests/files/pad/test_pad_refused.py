"""PAD pairs that cannot be used: one clear message each."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError, InertialcalError, Problem, UsageError
from pad_pairs_made import BIG, START, header, pair, records, stamp, systems

BOMB = (
    '<?xml version="1.0"?><!DOCTYPE sams2_accel [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    "<sams2_accel><SensorID>&b;</SensorID></sams2_accel>"
)
OUTSIDE = '<?xml version="1.0"?><!DOCTYPE x SYSTEM "file:///etc/hostname"><sams2_accel><SensorID/></sams2_accel>'


def head(path: Path) -> Path:
    return path.with_name(path.name + ".header")


def refused(path: Path, kind: type[InertialcalError] = DataError, **options: object) -> Problem:
    with pytest.raises(kind) as caught:
        ic.read(path, **options)  # type: ignore[arg-type]
    (problem,) = caught.value.problems
    return problem


def test_a_truncated_file(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    path.write_bytes(path.read_bytes()[:-5])
    problem = refused(path)
    assert problem.code == "truncated"
    assert "315 bytes are 19 records of 4 numbers and 11 bytes more" in problem.what


def test_a_file_cut_at_a_whole_record(tmp_path: Path) -> None:
    path = pair(tmp_path, records(50))
    path.write_bytes(path.read_bytes()[: 30 * 16])
    problem = refused(head(path))
    assert problem.code == "header_disagrees"
    assert "30 records end 2014-10-22T09:36:36.29Z, the name says 2014-10-22T09:36:36.49Z: 20 records are missing" in (
        problem.what
    )


def test_an_empty_file(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    path.write_bytes(b"")
    assert refused(path).code == "empty_file"


def test_a_missing_member(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    head(path).unlink()
    problem = refused(path)
    assert (problem.code, head(path).name in problem.what) == ("missing_header", True)
    assert refused(tmp_path).code == "missing_header"
    path.rename(tmp_path / "away")
    assert refused(path).code == "missing_file"
    head(path).write_text(header(), encoding="ascii")
    problem = refused(head(path))
    assert (problem.code, path.name in problem.what) == ("missing_data", True)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Gain 10, 142 Hz", "the header is not XML: "),
        ("<sams2_accel><SensorID>121f03</Sensor", "the header is not XML: "),
        ('<?xml version="1.0" encoding="no-such"?><sams2_accel/>', "the header is not XML: "),
        (BOMB, "the header declares a document type"),
        (OUTSIDE, "the header declares a document type"),
        ("<sams2_accel>" + " " * 70_000 + "</sams2_accel>", "the header has more than 65536 bytes"),
        ("<sams2_accel/>", "the header has no SampleRate"),
        (header(sensor=""), "the header has no SensorID"),
        (header(start="2014_02_30_00_00_00"), "TimeZero: '2014-02-30T00:00:00Z' is no time"),
        (header(rate="fast"), "SampleRate 'fast' is not a number"),
        (header(rate="0"), "SampleRate '0': need one above zero"),
        (header(rate="1e-300"), "SampleRate '1e-300': need one above zero, from 0.0001 to 1e+06 Hz"),
        (header(rate="nan"), "SampleRate 'nan' is not a number"),
        (header(layout="binary 64 bit"), "GData format 'binary 64 bit' is none of: binary 32 bit"),
        (header().replace("GData", "Data"), "the header has no GData"),
        (header(more='<BiasCoeff x="1" y="2"/>'), "BiasCoeff z '' is not a number"),
        (header(more='<SensorCoordinateSystem r="1" p="x" w="0"/>'), "SensorCoordinateSystem p 'x' is not a number"),
    ],
)
def test_a_header_that_cannot_be_used(tmp_path: Path, text: str, words: str) -> None:
    path = pair(tmp_path, records(), text=text)
    problem = refused(path)
    assert problem.code == "bad_header"
    assert words in problem.what
    assert problem.where == str(head(path))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (header(sensor="121f04"), "the name says sensor 121f03, the header 121f04"),
        (header(rate="142.00"), "the header says 142 Hz, the stamps of the data say 100 Hz"),
        (header(layout=BIG), "the header says big endian, the bytes are little endian"),
        (header(start="2014_10_22_09_36_37.000"), "the name says 2014-10-22T09:36:36Z, TimeZero in the header"),
    ],
)
def test_header_and_data_that_disagree(tmp_path: Path, text: str, words: str) -> None:
    problem = refused(pair(tmp_path, records(), text=text))
    assert problem.code == "header_disagrees"
    assert words in problem.what


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("0 1 2\n0.01 1 2\n", "3 numbers in a row, need 4"),
        ("0 1 2 3\n0.01 1 2\n", "is not the text that its header says"),
        ("0 1 2 three\n", "is not the text that its header says"),
        ("\n", "need 4"),
        ("µ", "is not the text that its header says"),
    ],
)
@pytest.mark.filterwarnings("ignore:loadtxt")
def test_text_that_is_no_table(tmp_path: Path, data: str, words: str) -> None:
    path = pair(tmp_path, records(), text=header(layout="ascii"))
    path.write_text(data, encoding="utf-8")
    problem = refused(path)
    assert problem.code == "damaged_file"
    assert words in problem.what


@pytest.mark.parametrize(
    ("at", "value", "words"),
    [
        (5, np.nan, "record 6: the time is not a number"),
        (7, -3.0, "record 8: the time is earlier than in the previous record"),
        (7, 1e30, "record 8: 1e+30 s, more than 200 years from the header's time"),
    ],
)
def test_stamps_that_are_no_time(tmp_path: Path, at: int, value: float, words: str) -> None:
    table = records()
    table[at, 0] = value
    problem = refused(pair(tmp_path, table))
    assert problem.code == "bad_stamps"
    assert words in problem.what


# Folders


def test_files_of_several_sensors(tmp_path: Path) -> None:
    pair(tmp_path, records())
    pair(tmp_path, records(), sensor="121f04")
    problem = refused(tmp_path)
    assert problem.code == "several_sensors"
    assert "2 files of 2 sensors: 121f03, 121f04" in problem.what


def test_files_of_several_sample_rates(tmp_path: Path) -> None:
    pair(tmp_path, records())
    later = stamp(START, 60.0)
    pair(tmp_path, records(rate=200.0), start=later, text=header(later, rate="200.0"))
    problem = refused(tmp_path)
    assert problem.code == "several_clocks"
    assert "files of 2 sample rates: 100, 200 Hz" in problem.what
    assert len(ic.read(tmp_path, stop="2014-10-22T09:37:00Z")) == 20


def test_files_that_overlap(tmp_path: Path) -> None:
    pair(tmp_path, records())
    pair(tmp_path, records(), start=stamp(START, 0.1))
    problem = refused(tmp_path)
    assert problem.code == "overlapping_files"
    assert "begins 2014-10-22T09:36:36.1Z, before" in problem.what


def test_data_in_several_coordinate_systems(tmp_path: Path) -> None:
    later = stamp(START, 60.0)
    pair(tmp_path, records(), text=header(more=systems((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))))
    pair(tmp_path, records(), start=later, text=header(later, more=systems((0.0, 0.0, 0.0), (0.0, 0.0, 90.0))))
    assert refused(tmp_path).code == "several_frames"
    found = ic.read(tmp_path, frame="sensor").channel("x").data
    np.testing.assert_allclose(found[20:], -records()[:, 2], atol=1e-11)


def test_a_folder_without_records(tmp_path: Path) -> None:
    assert "this is a folder" in refused(tmp_path).what


# Options


def test_axes_that_the_header_does_not_say(tmp_path: Path) -> None:
    problem = refused(pair(tmp_path, records()), frame="sensor")
    assert problem.code == "no_frames"


def test_options_that_mean_nothing_here(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    assert refused(path, UsageError, frame="station").do == "Say one of: data, sensor"
    assert refused(path, UsageError, time_column="t").code == "wrong_column"
    assert refused(path, UsageError, sample_rate=0.0).code == "sample_rate"
    (tmp_path / "a.csv").write_text("t [s],x [g]\n0,1\n1,2\n", encoding="ascii")
    assert refused(tmp_path / "a.csv", UsageError, frame="sensor").code == "wrong_frame"


def test_no_sample_in_the_window(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    for start in ("2014-10-23T00:00:00Z", "2014/295/09:36:36.195"):
        problem = refused(path, start=start)
        assert problem.code == "nothing_left"
        assert problem.do == "The recording runs from 2014-10-22T09:36:36Z to 2014-10-22T09:36:36.19Z"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads everything")
def test_a_file_that_may_not_be_read(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    path.chmod(0)
    assert "cannot be read" in refused(path).what
