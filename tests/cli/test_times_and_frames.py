"""--from, --to, --mission-start and --frame: the commands that read recordings take them, and say what is wrong."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.cli.__main__ import main
from pad_pairs_made import header, pair, records, systems


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    return int(str(left.value.code))


@pytest.fixture
def record(tmp_path: Path) -> Path:
    return pair(tmp_path, records(), text=header(more=systems((0.0, 0.0, 90.0))))


def test_info_of_a_part(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    times = ("--from", "000/00:00:36.05", "--to", "2014/295/09:36:36.1", "--mission-start", "2014-10-22T09:36:00Z")
    assert run("info", record.parent, *times, "--frame", "sensor", "--json") == 0
    (found,) = json.loads(capsys.readouterr().out)["results"]
    assert found["rows"] == 5
    assert found["time"]["start"] == "2014-10-22T09:36:36.050000000Z"
    assert {"cut_to_times", "turned_to_sensor_axes"} <= {one["code"] for one in found["remarks"]}


def test_convert_keeps_stamps_and_bits_of_a_part(record: Path, tmp_path: Path) -> None:
    target = tmp_path / "part.parquet"
    assert run("convert", record, target, "--to", "2014_10_22_09_36_36.100", "--quiet") == 0
    written, expected = ic.read(target), ic.read(record)
    assert written.time_ns is not None
    assert expected.time_ns is not None
    assert written.time_ns.tolist() == expected.time_ns[:10].tolist()
    for axis in "xyz":
        assert written.channel(axis).data.tolist() == expected.channel(axis).data[:10].tolist()
        assert written.channel(axis).unit == "g"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--from", "006/00:56"), "when the mission started is not said"),
        (("--from", "2014/366/00:00"), "day 366 of 2014"),
        (("--to", "2013/001/00:00"), "The recording runs from 2014-10-22T09:36:36Z"),
        (("--frame", "station"), "Say one of: data, sensor"),
    ],
)
def test_what_cannot_be_is_said(
    record: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], words: str
) -> None:
    assert run("info", record, *options) == 3  # a file could not be read as asked
    assert words in capsys.readouterr().err
