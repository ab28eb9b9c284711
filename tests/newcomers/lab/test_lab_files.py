"""Files of a test laboratory: what ``info`` says to type gives the truth, in two commands, and no advice is wrong."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import Any

import lab_files as lab
import numpy as np
import pytest
from newcomer_boards import ACC_BIASES, ACC_ERRORS, ACC_NOISE, GYRO_NOISE, G, board_at_rest, six_faces
from newcomer_files import _imu, stamps
from newcomer_tables import DATA_SHEET
from newcomer_truths import BIASES, ERRORS, SLOPES, chamber, rate_table
from obedience import next_command, next_commands

import inertialcal as ic
from inertialcal.core.errors import DataError
from typed_commands import call

Rows = list[dict[str, Any]]
FEW = 6.0  # standard uncertainties that an estimate may be off
WHITE = {"angle_random_walk": np.degrees(GYRO_NOISE) / np.sqrt(100.0) * 60.0,
         "velocity_random_walk": ACC_NOISE / np.sqrt(100.0) / G * 1e6}  # fmt: skip
LOG, RESTING = chamber(hours=1.0), board_at_rest()


def results(capsys: pytest.CaptureFixture[str], *words: str) -> Rows:
    status, out, err = call(capsys, *words, "--json")
    assert status == 0, err or out
    found: Rows = json.loads(out)["results"]
    return found


def one(rows: Rows, quantity: str, axis: str) -> dict[str, Any]:
    return next(row for row in rows if (row["quantity"], row["axis"], row["status"]) == (quantity, axis, "estimated")
                and not row["power"])  # fmt: skip


def check_chamber(rows: Rows, axes: str = "xyz") -> None:
    for axis in axes:
        found = one(rows, "bias", axis)
        assert abs(found["value"] - (1.0 + ERRORS[axis]) * BIASES[axis]) <= FEW * found["u"], found
        slope = next(
            row for row in rows if (row["quantity"], row["axis"], row["power"]) == ("bias_temperature", axis, 1)
        )
        assert abs(slope["value"] - (1.0 + ERRORS[axis]) * SLOPES[axis]) <= FEW * slope["u"], slope


def check_white(rows: Rows, quantities: tuple[str, ...] = tuple(WHITE)) -> None:
    for quantity in quantities:
        found = [row["value"] for row in rows if row["quantity"] == quantity and row["value"] is not None]
        assert found == pytest.approx([WHITE[quantity]] * 3, rel=0.08)


def check_faces(rows: Rows) -> None:
    for axis, error, bias in zip("xyz", ACC_ERRORS, ACC_BIASES, strict=True):
        for quantity, true, slack in (("scale_factor_error", 100.0 * error, 0.05), ("bias", bias, 2e-3)):
            found = next(row for row in rows if (row["quantity"], row["axis"]) == (quantity, axis)
                         and row["sensor"].startswith("acc"))  # fmt: skip
            assert abs(found["value"] - true) <= FEW * found["u"] + slack, found


IN_VOLTS = {
    "keysight.csv": lab.keysight(LOG, "VDC").encode(),
    "keysight_utf_16.csv": lab.keysight(LOG, "VDC").encode("utf-16"),
    "keysight_mvdc.csv": lab.keysight(LOG, "mVDC", 1e3).encode(),
    "kickstart.csv": lab.kickstart(LOG).encode(),
}


@pytest.mark.parametrize("name", IN_VOLTS)
def test_volts_of_a_multimeter_need_the_data_sheet_alone(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    path.write_bytes(IN_VOLTS[name])
    words = next_command(capsys, str(path), DATA_SHEET)
    assert words[0] == "thermal"
    check_chamber(results(capsys, *words))


def test_units_beside_values_are_those_of_a_header(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log.csv"
    path.write_text(lab.volts_beside(LOG))
    status, _, err = call(capsys, "thermal", str(path))
    assert status == 2
    assert '--scale-factor "NUMBER V/(deg/s)" --reference "NUMBER V"' in err
    assert "--unit" not in err
    chain = ("--reference", DATA_SHEET["reference"], "--scale-factor", DATA_SHEET["scale_factor"])
    check_chamber(results(capsys, "thermal", str(path), *chain))


def test_an_alternating_voltage_is_no_reading(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log.csv"
    path.write_text(lab.keysight(LOG, "VAC"))
    status, _, err = call(capsys, "thermal", str(path))
    assert status == 2
    assert "alternating voltage has no sign" in err
    assert "--" not in err
    path.write_text(lab.keysight(LOG, "ADC"))
    _, out, _ = call(capsys, "info", str(path), "--json")
    (said, *_) = [row for row in json.loads(out)["results"][0]["remarks"] if row["code"] == "unknown_unit"]
    assert "amperes of direct current as well as codes" in said["what"]


def test_a_reading_of_a_multimeter_without_header(tmp_path: Path) -> None:
    path = tmp_path / "buffer.txt"
    path.write_text(lab.keithley(LOG))
    found = ic.read(path)
    assert len(found) == len(LOG.time)
    assert found.sample_interval == 1.0
    assert found.channels[0].unit == "V"
    assert np.asarray(found.channels[0].data) == pytest.approx(LOG.volts()["x"], abs=1e-7)


@pytest.mark.parametrize(
    ("zone", "start", "utc"),
    [
        ("GMT+01:00", datetime(2026, 11, 30, 9, 15), "2026-11-30T08:15"),
        ("GMT+02:00", datetime(2026, 7, 30, 9, 15), "2026-07-30T07:15"),
        ("GMT-05:00", datetime(2026, 11, 30, 9, 15), "2026-11-30T14:15"),
        ("GMT+05:30", datetime(2026, 11, 30, 9, 15), "2026-11-30T03:45"),
        ("GMT+00:00", datetime(2026, 11, 30, 9, 15), "2026-11-30T09:15"),
    ],
)
def test_the_zone_in_the_header_of_a_hobo(
    zone: str, start: datetime, utc: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "hobo.csv"
    path.write_bytes(lab.hobo(LOG, zone, start, event=zone == "GMT+01:00"))
    (found,) = results(capsys, "info", str(path))
    assert found["time"]["start"].startswith(utc)
    assert found["rows"] == len(LOG.time)
    assert {row["code"] for row in found["remarks"]} & {"naive_time", "time_repeated", "unknown_unit"} == set()
    words = next_command(capsys, str(path), {})
    assert words[0] == "thermal"
    check_chamber(results(capsys, *words))


XSENS = {
    "tabs.txt": lab.xsens(RESTING),
    "commas.csv": lab.xsens(RESTING, ","),
    "begins_anew.txt": lab.xsens(RESTING, first=2**32 - 20_000),
    "utc.txt": lab.xsens(RESTING, utc=True),
    "more.txt": lab.xsens(RESTING, more=True),
    "dot.csv": lab.dot(RESTING),
}


@pytest.mark.parametrize("name", XSENS)
def test_counters_and_units_of_xsens(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / name
    path.write_text(XSENS[name])
    (found,) = results(capsys, "info", str(path))
    assert found["time"]["sample_rate"] == pytest.approx(100.0)
    assert not [row for row in found["remarks"] if row["code"] in ("gap", "time_backward", "time_unit_unknown")]
    if name == "utc.txt":
        assert found["time"]["start"].startswith("2026-11-30T09:15:00.000")
    words = next_command(capsys, str(path), {})
    assert words[0] == "allan"
    check_white(results(capsys, *words))


def test_a_lost_packet_is_a_gap_and_units_of_xsens_can_be_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "lost.txt"
    rows = lab.xsens(six_faces(), more=True).splitlines(keepends=True)
    path.write_text("".join([*rows[:500], *rows[700:]]))
    recording = ic.read(path)
    assert np.diff(np.asarray(recording.time_ns)).max() == 201 * 20_000_000
    (said,) = [row for row in recording.remarks if row.code == "units_of_format"]
    assert "--unit gyro=UNIT" in said.do
    assert ic.read(path, units={"gyro": "deg/s"}).channel("Gyr_X").unit == "deg/s"
    path.write_text("".join(rows))
    check_faces(results(capsys, *next_command(capsys, str(path), {})))


@pytest.mark.parametrize("packing", ["NONE", "LZ4", "ZSTD"])
def test_an_only_chunk_that_is_cut_is_read_as_far_as_it_is_whole(packing: str, tmp_path: Path) -> None:
    from mcap.writer import CompressionType
    from mcap.writer import Writer as Mcap
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    path = tmp_path / "cut.mcap"
    with path.open("wb") as stream:
        mcap = Mcap(stream, chunk_size=50_000_000, compression=getattr(CompressionType, packing))
        mcap.start(profile="ros1", library="test")
        text, _ = store.generate_msgdef("sensor_msgs/msg/Imu")
        channel = mcap.register_channel(
            "/imu", "ros1", mcap.register_schema("sensor_msgs/Imu", "ros1msg", text.encode())
        )
        for ns, message in zip(stamps(RESTING), _imu(store.types, RESTING, True, range(6000)), strict=True):
            mcap.add_message(channel, int(ns), bytes(store.serialize_ros1(message, "sensor_msgs/msg/Imu")), int(ns))
        mcap.finish()  # type: ignore[no-untyped-call]
    whole = path.read_bytes()
    path.write_bytes(whole[:300_000])
    found = ic.read(path)
    assert 800 < len(found) < 6000
    assert found.array(["angular_velocity.x"])[:, 0] == pytest.approx(RESTING.gyro[: len(found), 0])
    (said,) = [row for row in found.remarks if row.code == "torn_file"]
    assert "in the middle of a chunk" in said.what
    if packing != "NONE":
        path.write_bytes(whole[:5_000])
        with pytest.raises(
            DataError, match=rf"packed by {packing.lower()}, of which nothing can be unpacked: 4,967 bytes"
        ):
            ic.read(path)


def test_increments_of_px4_become_rates(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "rest.ulg"
    path.write_bytes(lab.vehicle_imu(RESTING))
    recording = ic.read(path)
    assert recording.array(["gyro.x"])[:, 0] == pytest.approx(RESTING.gyro[:, 0], rel=1e-6, abs=1e-9)
    assert [recording.channel(name).unit for name in ("gyro.x", "acc.z")] == ["rad/s", "m/s^2"]
    words = next_command(capsys, str(path), {})
    check_white(results(capsys, *words))
    status = ic.read(path, topics=["vehicle_imu_status"])
    units = {row.name: (row.quantity, row.unit) for row in status.channels}
    assert units["mean_gyro.x"] == ("gyro", "rad/s")
    assert units["mean_accel.z"] == ("acc", "m/s^2")
    assert units["temperature_accel"] == ("temperature", "degC")
    assert not [name for name in units if "clipping" in name or "id" in name]


def test_instances_of_px4_are_listed_each_with_its_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "two.ulg"
    path.write_bytes(lab.vehicle_imu(RESTING, 2))
    printed = next_commands(capsys, str(path))
    assert [line.rpartition("--topic ")[2] for line in printed] == ["'vehicle_imu[0]'", "'vehicle_imu[1]'"]
    check_white(results(capsys, "allan", str(path), "--topic", "vehicle_imu[1]"))


BOARDS = {"serial.txt": lab.serial_monitor, "control_desk.csv": lab.control_desk, "unicleo.csv": lab.unicleo}


@pytest.mark.parametrize("name", BOARDS)
def test_programs_of_boards(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / name
    path.write_text(BOARDS[name](RESTING))
    words = next_command(capsys, str(path), {})
    assert words[0] == "allan"
    check_white(results(capsys, *words), ("angle_random_walk",) if name == "control_desk.csv" else tuple(WHITE))


def test_registers_as_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "adis.csv"
    path.write_text(lab.evaluation_gui(RESTING))
    words = next_command(capsys, str(path), {})
    assert words == ["info", str(path), "--unit", "gyro=UNIT", "--unit", "acc=mg"]
    check_white(results(capsys, "allan", str(path), "--unit", "gyro=deg/s", "--unit", "acc=mg"))


FACES, TURNED = six_faces(), rate_table()
WITHOUT_HEADER = {
    "allan": ([RESTING.time, RESTING.gyro, RESTING.acc], "--column x=2 --column y=3 --column z=4 --unit rad/s"),
    "allan_alone": ([RESTING.gyro], "--sample-rate 100 --unit rad/s"),
    "positions": ([FACES.time, FACES.acc, FACES.gyro],
                  "--column acc_x=2 --column acc_y=3 --column acc_z=4 --column gyro_x=5 --column gyro_y=6 "
                  "--column gyro_z=7 --unit acc=m/s2 --unit gyro=rad/s"),
    "positions_bare": ([FACES.acc], "--column acc_x=1 --column acc_y=2 --column acc_z=3 --sample-rate 50 --unit m/s2"),
    "rate-table": ([TURNED.time, TURNED.applied, *TURNED.readings.values()],
                   "--axis x --column applied=2 --column x=3 --column y=4 --column z=5 --unit deg/s"),
    "thermal": ([LOG.time, *LOG.readings.values(), LOG.temperature],
                "--sample-rate 1 --column x=2 --column y=3 --column z=4 --column temperature=5 --unit deg/s "
                "--unit temperature=degC"),
}  # fmt: skip


@pytest.mark.parametrize("ending", [".csv", ".mat"])
@pytest.mark.parametrize("name", WITHOUT_HEADER)
def test_columns_without_names_by_number(
    name: str, ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A text, or a matrix of MATLAB: one command after ``info``."""
    from scipy.io import savemat

    columns, options = WITHOUT_HEADER[name]
    path = tmp_path / f"data{ending}"
    if ending == ".mat":
        savemat(path, {"data": np.column_stack(columns)})
    else:
        path.write_text(lab.numbers(columns))
    noun = name.split("_", maxsplit=1)[0]
    rows = results(capsys, noun, str(path), *options.split())
    if noun == "allan":
        check_white(rows, ("angle_random_walk",))
    elif noun == "positions":
        check_faces(rows)
    elif noun == "thermal":
        check_chamber(rows)
    else:
        found = one(rows, "scale_factor_error", "x")
        assert abs(found["value"] - 100.0 * ERRORS["x"]) <= FEW * found["u"] + 0.005


def test_info_says_what_to_type_of_columns_without_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "data.csv"
    path.write_text(lab.numbers([FACES.time, FACES.acc, FACES.gyro]))
    (found,) = results(capsys, "info", str(path))
    (said,) = [row for row in found["remarks"] if row["code"] == "nameless_columns"]
    assert said["what"].startswith("6 columns of 3,280 rows without names")
    assert "positions: --column acc_x=COLUMN" in said["do"]
    assert found["next"] is None
    for noun, wanted in (
        ("positions", "--column acc_x=COLUMN --column acc_y=COLUMN --column acc_z=COLUMN --unit UNIT"),
        ("thermal", "--column z=COLUMN --column temperature=COLUMN --unit UNIT --unit temperature=UNIT"),
        ("flip", "--column x=COLUMN --column y=COLUMN --column z=COLUMN --unit UNIT"),
    ):
        status, _, err = call(capsys, noun, str(path))
        assert status == 2
        assert wanted in " ".join(err.split())


LAID = np.vstack([sign * np.eye(3)[i] for i in range(3) for sign in (1.0, -1.0)] * 2)
HEADS = (
    "g{}_applied [g]",
    "g{}_reference [g]",
    "g_{} [g]",
    "a_ref_{} [g]",
    "true_{} [g]",
    "nominal_g{} (g)",
    "Soll_{} [g]",
)
OUTPUTS = {"out_{} [g]": 1.0, "out_{} [V]": 0.3, "out_{} [counts]": 16384.0, "acc_{} [m/s^2]": G}


def laid(head: str, output: str, sign: float = 1.0, size: float = 1.0) -> str:
    """Return a table of what was applied and read in each of twelve positions."""
    noise = 1e-5 * np.random.default_rng(4).standard_normal(LAID.shape)
    readings = OUTPUTS[output] * (LAID * (1.0 + ACC_ERRORS) + ACC_BIASES / G + noise) + (
        2.5 if "[V]" in output else 0.0
    )
    names = [one.format(axis) for one in (head, output) for axis in "xyz"]
    rows = (",".join(f"{one:.7g}" for one in row) for row in np.hstack([sign * size * LAID, readings]))
    return lab.lines([",".join(names), *rows], "\n")


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize("head", HEADS)
def test_a_table_of_what_was_applied_and_read(
    head: str, output: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "faces.csv"
    path.write_text(laid(head, output))
    words = next_command(capsys, str(path), {})
    assert words == ["positions", str(path)]
    rows = results(capsys, *words)
    for axis, error, bias in zip("xyz", ACC_ERRORS, ACC_BIASES, strict=True):
        if output in ("out_{} [V]", "out_{} [counts]"):
            found, true = one(rows, "scale_factor", axis)["value"], OUTPUTS[output] * (1.0 + error) / G
            assert found == pytest.approx(true, rel=1e-4)
        else:
            assert one(rows, "scale_factor_error", axis)["value"] == pytest.approx(100.0 * error, abs=0.01)
            found = one(rows, "bias", axis)
            assert found["value"] * (G if found["unit"] == "g" else 1.0) == pytest.approx(bias, abs=2e-3)


def test_counts_without_a_unit_beside_what_was_applied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "faces.csv"
    path.write_text(laid("g{}_applied [g]", "out_{} [counts]").replace(" [counts]", ""))
    status, _, err = call(capsys, "positions", str(path))
    assert status == 2
    assert "--unit acc=UNIT" in err
    rows = results(capsys, "positions", str(path), "--unit", "acc=count")
    assert one(rows, "scale_factor", "x")["value"] == pytest.approx(16384.0 * (1.0 + ACC_ERRORS[0]) / G, rel=1e-4)


@pytest.mark.parametrize(("sign", "size", "said"), [(1.0, 2.0, "which is not gravity"), (-1.0, 1.0, "is named")])
def test_what_was_applied_and_cannot_be_is_refused(
    sign: float, size: float, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "faces.csv"
    path.write_text(laid("g{}_applied [g]", "out_{} [g]", sign, size))
    status, _, err = call(capsys, "positions", str(path))
    assert status == 3
    assert said in err


def test_a_model_of_one_axis_is_not_beyond_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Axes that were not turned have no ends to be beyond, and noise at the ends is none."""
    path, model = tmp_path / "turned.csv", tmp_path / "model.json"
    names = ["time [s]", "table_rate [deg/s]", *(f"gyro_{axis} [deg/s]" for axis in "xyz")]
    path.write_text(",".join(names) + "\n" + lab.numbers([TURNED.time, TURNED.applied, *TURNED.readings.values()]))
    results(capsys, "rate-table", str(path), "--axis", "x", "-o", str(model))
    status, out, err = call(capsys, "compensate", str(model), str(path), "-o", str(tmp_path / "out.csv"), "--json")
    assert status == 0, err
    codes = {row["code"] for row in json.loads(out)["remarks"]}
    assert "outside_input_range" not in codes
    assert "axis_not_moved" in codes
    fast = TURNED.readings["x"] * 1.5
    path.write_text(
        ",".join(names) + "\n" + lab.numbers([TURNED.time, TURNED.applied, fast, *[TURNED.readings[a] for a in "yz"]])
    )
    _, out, _ = call(capsys, "compensate", str(model), str(path), "-o", str(tmp_path / "out.csv"), "--json")
    (beyond,) = [row for row in json.loads(out)["remarks"] if row["code"] == "outside_input_range"]
    assert "x -1.396 to 1.396 rad/s" in beyond["what"]


def test_a_gyro_model_finds_the_force_beside_the_gyros(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As `positions` did, which made the model."""
    path, model = tmp_path / "faces.csv", tmp_path / "model.json"
    names = ["time [s]", *(f"acc_{axis} [m/s^2]" for axis in "xyz"), *(f"gyro_{axis} [rad/s]" for axis in "xyz")]
    path.write_text(",".join(names) + "\n" + lab.numbers([FACES.time, FACES.acc, FACES.gyro]))
    results(capsys, "positions", str(path), "-o", str(model))
    for sensor in ("acc", "gyro"):
        own = str(tmp_path / f"model_{sensor}.json")
        status, out, err = call(capsys, "compensate", own, str(path), "-o", str(tmp_path / "out.csv"), "--json")
        assert status == 0, err
        assert not [row for row in json.loads(out)["remarks"] if row["code"] == "outside_input_range"]
