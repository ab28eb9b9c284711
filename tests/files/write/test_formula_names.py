"""Names that a spreadsheet would run as a formula: given an apostrophe in CSV, kept elsewhere."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.recording import Channel, Recording
from inertialcal.core.show.tables import csv_cell

NAMES = ("=cmd|' /C calc'!A0", "+1+1 [deg/s]", "-2+3", '@SUM(A1),"b"', "=HYPERLINK")


def recording(name: str) -> Recording:
    unit = "deg/s" if "[deg/s]" in name else None
    data = np.linspace(0.25, 9.75, 20)
    channels = (Channel(name, data, unit), Channel("gyro_y [deg/s]", data, "deg/s"))
    return Recording(channels, np.arange(20, dtype=np.int64) * 10**8, 0.1, interval_from="column")


@pytest.mark.parametrize("name", NAMES)
def test_a_csv_neutralises_it_and_reads_back(tmp_path: Path, name: str) -> None:
    remarks = ic.write(tmp_path / "a.csv", recording(name))
    renamed = [one for one in remarks if one.code == "column_renamed"]
    assert [one.subject for one in renamed] == [name]
    assert "formula" in renamed[0].what
    with (tmp_path / "a.csv").open(newline="", encoding="utf-8") as stream:
        header = next(csv.reader(stream))
    assert header[1:] == [f"'{name}", "gyro_y [deg/s]"]
    found = ic.read(tmp_path / "a.csv")
    assert found.names == (f"'{name}", "gyro_y [deg/s]")
    assert np.array_equal(found.array(), recording(name).array())
    assert found.channels[0].unit == recording(name).channels[0].unit
    assert not [one for one in ic.write(tmp_path / "b.csv", found) if one.code == "column_renamed"]
    assert (tmp_path / "b.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()


@pytest.mark.parametrize("ending", ["parquet", "npz"])
@pytest.mark.parametrize("name", [name for name in NAMES if "/ " not in name and "|" not in name])
def test_other_formats_keep_it(tmp_path: Path, name: str, ending: str) -> None:
    remarks = ic.write(tmp_path / f"a.{ending}", recording(name))
    assert not [one for one in remarks if one.code == "column_renamed"]
    assert ic.read(tmp_path / f"a.{ending}").names[0] == name


def test_a_cell_alone() -> None:
    assert [csv_cell(text) for text in ("-", "=", "", "x=1", "=1", "\ta", "\ra", "-1")] == [
        "-", "=", "", "x=1", "'=1", "'\ta", "'\na", "'-1",
    ]  # fmt: skip
