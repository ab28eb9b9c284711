"""A thermometer in a topic of its own is interpolated to the stamps of the readings; nothing else is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.core.errors import DataError

asammdf = pytest.importorskip("asammdf")
Numbers = NDArray[np.float64]
RATE, EVERY, LATE = 50.0, 2.0, 0.37  # Hz; s between messages of the thermometer, and its first


def warmth(time: Numbers) -> Numbers:
    """Return a temperature that bends by less than 1e-4 degC between two messages."""
    return np.asarray(20.0 + 3.0 * np.sin(2.0 * np.pi * time / 500.0))


def mdf(path: Path, gap: tuple[float, float] = (1.0, 0.0), second: str = "T_housing", seconds: float = 120.0) -> Path:
    """Write a group of gyros, and one of a thermometer that was silent in a gap."""
    time = np.arange(round(seconds * RATE)) / RATE
    slow = np.arange(LATE, seconds, EVERY)
    slow = slow[~((slow > gap[0]) & (slow < gap[1]))]
    with asammdf.MDF(version="4.10") as file:
        gyros = [asammdf.Signal(np.cos(time), time, name=f"Gyro_{axis}", unit="deg/s") for axis in "XYZ"]
        file.append(gyros, acq_name="imu")
        file.append([asammdf.Signal(warmth(slow), slow, name=second, unit="degC")], acq_name="housing")
        file.save(path)
    return path


def test_a_temperature_follows_the_clock_of_the_readings(tmp_path: Path) -> None:
    found = ic.read(mdf(tmp_path / "a.mf4"))
    assert found.names[-1] == "T_housing"
    inside = slice(round((LATE + EVERY) * RATE), round(110.0 * RATE))
    true = warmth(np.arange(len(found)) / RATE)
    np.testing.assert_allclose(found.channel("T_housing").data[inside], true[inside], atol=1e-3)
    (said,) = [one for one in found.remarks if one.code == "joined_by_time"]
    assert said.severity == "info"
    assert said.do == "To leave it out, name topic imu alone"
    assert "T_housing" not in ic.read(tmp_path / "a.mf4", topics=["imu"]).names
    named = ic.read(tmp_path / "a.mf4", topics=["housing", "imu"])  # in any order
    np.testing.assert_array_equal(named.channel("T_housing").data, found.channel("T_housing").data)


def test_where_the_thermometer_was_silent_nothing_is_invented(tmp_path: Path) -> None:
    found = ic.read(mdf(tmp_path / "a.mf4", gap=(40.0, 80.0)))
    data, time = found.channel("T_housing").data, np.arange(len(found)) / RATE
    assert np.isnan(data[(time > 47.0) & (time < 73.0)]).all()
    assert np.isfinite(data[(time < 40.0) | (time > 82.0)]).all()
    (said,) = [one for one in found.remarks if one.code == "joined_by_time"]
    assert said.severity == "warning"


def test_readings_of_another_clock_are_not_interpolated(tmp_path: Path) -> None:
    path = mdf(tmp_path / "a.mf4", second="Acc_X")
    with pytest.raises(DataError, match="different stamps"):
        ic.read(path, topics=["imu", "housing"])


def test_a_group_of_tdms_and_a_sheet_are_joined_as_well(tmp_path: Path) -> None:
    tdms, openpyxl = pytest.importorskip("nptdms"), pytest.importorskip("openpyxl")
    start = np.datetime64("2026-03-25T08:00:00")
    gyro, slow = np.zeros(200), warmth(np.arange(20.0) * 2.0)
    with tdms.TdmsWriter(tmp_path / "a.tdms") as file:
        about = {"wf_start_time": start, "wf_start_offset": 0.0}
        fast = tdms.ChannelObject("IMU", "Gyro X", gyro, {**about, "wf_increment": 0.2, "unit_string": "deg/s"})
        warm = tdms.ChannelObject("Box", "Temperature", slow, {**about, "wf_increment": 2.0, "unit_string": "degC"})
        file.write_segment([fast, warm])
    book = openpyxl.Workbook()
    book.active.title = "IMU"
    for row in [("Time (s)", "Gyro X (deg/s)"), *((0.2 * k, 0.1 * (k % 3)) for k in range(200))]:
        book.active.append(row)
    sheet = book.create_sheet("Box")
    for row in [("Temperature (degC)", "Time (s)"), *((float(slow[k]), 2.0 * k) for k in range(20))]:
        sheet.append(row)
    book.save(tmp_path / "a.xlsx")
    for name, column in (("a.tdms", "Temperature"), ("a.xlsx", "Temperature (degC)")):
        found = ic.read(tmp_path / name)
        true = warmth(np.arange(200.0) * 0.2)
        np.testing.assert_allclose(found.channel(column).data[:190], true[:190], atol=1e-3)
        assert "joined_by_time" in {one.code for one in found.remarks}
