"""Recordings that others made, with the figures and traps that their authors state (shared data, README)."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from inertialcal.campaign.start.info import info as survey
from inertialcal.core.errors import DataError
from inertialcal.files import read
from inertialcal.files.info.survey import Survey

_MPU6050 = (
    "set-1__rotate-360ccw-around-x-pointing-forward set-1__rotate-360ccw-around-y-pointing-left "
    "set-1__rotate-360ccw-around-z-pointing-up set-1__unmoved-x-pointing-forward set-1__unmoved-x-pointing-up "
    "set-1__unmoved-z-pointing-left set-2__rotate-ccw-around-x-pointing-forward set-2__rotate-ccw-around-x-pointing-up "
    "set-2__rotate-ccw-around-y-pointing-left set-2__rotate-ccw-around-z-pointing-up "
    "set-2__unmoved-with-x-pointing-forward set-2__unmoved-with-x-pointing-forward-10min "
    "set-2__unmoved-with-z-pointing-front-and-x-up set-2__unmoved-with-z-pointing-front-and-y-down"
)
MPU6050 = _MPU6050.split()
PRINTED = 2e-5  # relative; sensor-stats.csv has six digits
RATE_PRINTED = 1e-4


@pytest.fixture
def data(shared: Path) -> Path:
    folder = shared / "data"
    if not folder.is_dir():
        pytest.skip(f"no recordings of others: {folder} is absent")
    return folder


def codes(found: Survey) -> set[str]:
    return {remark.code for remark in found.remarks}


def what(found: Survey, code: str) -> str:
    return next(remark.what for remark in found.remarks if remark.code == code)


@pytest.mark.parametrize("sensor", ["acc", "gyro"])
def test_xsens_mti(data: Path, sensor: str) -> None:
    path = data / "imu_tk_xsens_mti" / f"xsens_{sensor}.mat"
    found = survey(path)
    expected = np.loadtxt(path)
    assert found.rows == 51_175
    assert found.time.sample_rate == pytest.approx(100.0)
    assert found.time.axis is not None
    assert found.time.axis.duration == pytest.approx(511.688)
    assert len(found.time.axis.gaps) == 0
    np.testing.assert_array_equal(read(path).array(), expected[:, 1:])
    knocks = {"glitch"} if sensor == "acc" else set()  # as the unit is laid down: 4 to 9 samples, 50 times the noise
    assert codes(found) == {"nameless_columns", "time_unnamed", "not_at_rest"} | knocks
    assert {channel.resolution for channel in found.channels} == {1.0}
    assert {hint.unit for hint in found.hints} == {"count"}


@pytest.mark.parametrize(
    ("name", "index", "rows", "gyro", "acc"),
    [
        ("example_ferraris_session.csv", "n_samples", 10_376, "deg/s", "m/s2"),
        ("ferraris_example.csv", "n_samples", 50, "", "m/s2"),
        ("annotated_session.csv", "samples", 9_414, "count", "count"),
    ],
)
def test_imucal(data: Path, name: str, index: str, rows: int, gyro: str, acc: str) -> None:
    found = survey(data / "imucal_ferraris" / name)
    assert found.rows == rows
    assert (found.channels[0].name, found.channels[0].quantity) == (index, "index")
    assert found.time.sample_rate is None  # an index column is never time
    assert {hint.target: hint.unit for hint in found.hints} == {"gyro": gyro, "acc": acc}
    assert found.next is not None
    assert found.next.endswith("--sample-rate HZ")


def test_imucal_labels_are_counted(data: Path) -> None:
    found = survey(data / "imucal_ferraris" / "annotated_session.csv")
    assert what(found, "text_column").startswith("column 'part' is text (9 different: x_a, x_p, x_rot, ")


def test_tofupilot_time_cannot_be_in_ns(data: Path) -> None:
    path = data / "tofupilot_thermal" / "imu_raw_data.csv"
    found = survey(path)
    assert found.rows == 8_400
    assert found.time.sample_rate is None
    assert "in ns 1978.6 Hz over 4.245 s" in what(found, "time_unit_unknown")
    assert "'imu.temperature' changes by 91" in what(found, "time_axis_implausible")
    told = survey(path, units={"timestamp": "ns"})
    assert told.time.sample_interval == pytest.approx(0.505403e-3)
    assert "time_axis_implausible" in codes(told)
    by_name = {channel.name: channel for channel in found.channels}
    assert by_name["imu.temperature"].minimum == -17.60306168
    assert by_name["imu.temperature"].maximum == 73.96678925
    assert by_name["imu.status"].quantity == "status"


@pytest.mark.parametrize(
    "folder", [pytest.param(one, marks=pytest.mark.slow if i % 4 else []) for i, one in enumerate(MPU6050)]
)
@pytest.mark.parametrize(
    ("sensor", "kind"), [("gyroscope", "gyro"), ("accelerometer", "acc"), ("temperature", "temperature")]
)
def test_mpu6050_as_its_author_has_it(data: Path, folder: str, sensor: str, kind: str) -> None:
    place = data / "sunsided_mpu6050_static" / folder
    found = survey(place / f"mpu6050_{sensor}.mat")
    with (place / "sensor-stats.csv").open(encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["sensor"] == "MPU6050" and row["type"] == sensor]
    assert found.rows == int(rows[0]["count"])
    assert found.time.sample_rate == pytest.approx(float(rows[0]["freq_mean"]), rel=RATE_PRINTED)
    assert {channel.quantity for channel in found.channels} == {kind}
    for channel, row in zip(found.channels, rows, strict=True):
        assert channel.minimum == pytest.approx(float(row["v_min"]), rel=PRINTED)
        assert channel.maximum == pytest.approx(float(row["v_max"]), rel=PRINTED)
        assert channel.mean == pytest.approx(float(row["v_mean"]), rel=PRINTED, abs=1e-7)
        assert channel.std == pytest.approx(float(row["v_std_dev"]), rel=PRINTED)
        assert not {"stuck", "saturated"} & {*channel.screening.codes}
    assert "stamps_in_bursts" in codes(found)


@pytest.mark.parametrize("folder", [name for name in MPU6050 if "unmoved" in name])
@pytest.mark.parametrize("sensor", ["gyroscope", "accelerometer"])
def test_only_the_disturbed_recording_is_called_so(data: Path, folder: str, sensor: str) -> None:
    found = survey(data / "sunsided_mpu6050_static" / folder / f"mpu6050_{sensor}.mat")
    assert ("disturbance" in codes(found)) == (folder == "set-1__unmoved-x-pointing-up")
    assert "not_at_rest" not in codes(found)


def test_the_unfilled_end_of_one_buffer(data: Path) -> None:
    # The author's count is 6280; the file holds 7000 rows.
    found = survey(data / "sunsided_mpu6050_static" / "set-1__unmoved-z-pointing-left" / "mpu6050_gyroscope.mat")
    (remark,) = [r for r in found.remarks if r.code == "unfilled_end"]
    assert (found.rows, remark.count) == (6_280, 720)


def test_l3g_has_a_step_and_no_rate(data: Path) -> None:
    found = survey(data / "noise" / "l3g_gyro_x" / "gyro2_x.txt")
    (channel,) = found.channels
    assert (found.rows, found.time.sample_rate) == (238_256, None)
    assert channel.resolution == pytest.approx(0.00875, rel=1e-9)
    assert [str(hint) for hint in found.hints] == ["step 0.00875, as ST: --unit column_1=deg/s?"]


@pytest.mark.parametrize(
    ("name", "rows", "first"),
    [
        ("phasedat/PHASE.DAT", 1_001, 0.0),
        ("ocxo/ocxo_frequency.txt", 19_982, 10000000.126856699585915),
        ("gps/gps_1pps_phase_data.txt.gz", 241_218, 2.76845904000198e-7),
        ("Cs5071A/5071A_phase.txt.gz", 556_990, None),  # the README's 557,002 counts twelve comment lines
        ("pink_frequency/pink_frequency.txt", 10_000, 1.62551e-07),
        ("gradev/y.dat", 1_000, 4.902526187444457562e-01),
        ("gradev/y_gap.dat", 1_000, 4.902526187444457562e-01),
    ],
)
def test_allantools_inputs(data: Path, name: str, rows: int, first: float | None) -> None:
    recording = read(data / "noise" / "allantools_reference" / name)
    (channel,) = recording.channels
    assert len(recording) == rows
    assert first is None or channel.data[0] == first
    assert recording.sample_interval is None
    gaps = [remark for remark in recording.remarks if remark.code == "nan_literal"]
    assert [(r.count, r.where.rpartition(":")[2]) for r in gaps] == ([(200, "401")] if "gap" in name else [])


def test_a_column_that_counts_is_an_index(data: Path) -> None:
    recording = read(data / "noise" / "allantools_reference" / "gradev" / "x.dat")
    assert recording.channels[0].quantity == "index"


def test_a_recorder_file_with_several_topics(data: Path) -> None:
    recording = read(data / "vibration" / "endaq_ide" / "test4.IDE")
    assert [one.unit for one in recording.channels] == ["deg/s"] * 3
    (topics,) = (one for one in recording.remarks if one.code == "other_topics")
    assert "GNSS Location" in topics.what


def test_two_recordings_in_a_labview_file(data: Path) -> None:
    path = data / "vibration" / "hrshm_dataset7" / "amplitude_6_Impact_1_vibration.lvm"
    with pytest.raises(DataError, match=r"excitation_vibration .* 13,216 rows") as caught:
        read(path)
    assert caught.value.problems[0].do == "Choose: --topic excitation_vibration"
    assert len(read(path, topics=["excitation_composite"])) == 12375


def test_other_formats_are_named(data: Path) -> None:
    with pytest.raises(DataError, match="JSON"):
        read(data / "noise" / "nist_sp1065_1000pt.json")
