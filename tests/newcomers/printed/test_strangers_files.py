"""Files of strangers that were misread, or whose messages led nowhere: each gives the truth in two commands at most."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.core.errors import DataError
from typed_commands import call, call_json

Capsys = pytest.CaptureFixture[str]
BIAS, ERROR, NOISE, PER = 0.18, 0.009, 0.04, 131.0  # deg/s, 1, deg/s, count/(deg/s)
RATES = (0.0, 25.0, 50.0, 75.0, 100.0, 0.0, -25.0, -50.0, -75.0, -100.0, 0.0)
DWELL, SAMPLE_RATE = 8, 25.0  # s, Hz


def turned() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return time, rate of the table, and readings of a gyro about z."""
    applied = np.repeat(RATES, round(DWELL * SAMPLE_RATE))
    noise = np.random.default_rng(3).normal(0.0, NOISE, len(applied))
    return np.arange(len(applied)) / SAMPLE_RATE, applied, (1.0 + ERROR) * (applied + BIAS) + noise


def found(content: dict[str, Any], quantity: str, axis: str) -> tuple[float, float]:
    """Return an estimate with its standard uncertainty."""
    own = {(one["quantity"], one["axis"]): one for one in content["results"] if one["method"] == "result"}
    return own[quantity, axis]["value"], own[quantity, axis]["u"]


def holds(content: dict[str, Any], quantity: str, axis: str, true: float) -> None:
    """Check an estimate."""
    value, u = found(content, quantity, axis)
    assert abs(value - true) < 4.0 * u, (quantity, value, u, true)


def german(number: float, digits: int) -> str:
    """Return a number as a German spreadsheet writes it."""
    return f"{number:,.{digits}f}".translate(str.maketrans(",.", ".,"))


@pytest.mark.parametrize("first", ["sep=;\n", ""])
def test_counts_grouped_by_points_beside_decimal_commas(first: str, tmp_path: Path, capsys: Capsys) -> None:
    """32.804 was read as 32.804 counts: its column has no comma, and there are more such columns than others."""
    rows = [f"{german(t, 2)};{german(a, 1)};{german(np.rint(32768.0 + PER * x), 0)};32.768;32.770"
            for t, a, x in zip(*turned(), strict=True)]  # fmt: skip
    head = "Zeit [s];Sollrate [°/s];Drehrate Z [Digit];Drehrate X [Digit];Drehrate Y [Digit]"
    path = tmp_path / "drehtisch.csv"
    path.write_text(first + "\n".join([head, *rows]) + "\n", encoding="utf-8-sig")
    assert ic.read(path).channel("Drehrate X [Digit]").data[0] == 32768
    chain = ("--scale-factor", "131 count/(deg/s)", "--reference", "32768 count")
    content = call_json(capsys, "rate-table", str(path), "--axis", "z", *chain)
    holds(content, "scale_factor_error", "z", 100.0 * ERROR)
    holds(content, "bias", "z", BIAS)


def test_groups_of_three_digits_that_may_be_decimals_are_refused(tmp_path: Path) -> None:
    rows = [f"{german(n / 10, 1)};{20 + n % 7}.{100 + n % 50}" for n in range(300)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["Zeit [s];Drehrate Z [°/s]", *rows]) + "\n", encoding="utf-8")
    with pytest.raises(DataError, match="grouped digits"):
        ic.read(path)


def test_a_thermometer_in_a_table_of_its_own(tmp_path: Path, capsys: Capsys) -> None:
    """Of SQLite; before, `thermal` asked for a column that the table of the gyro does not have."""
    time = np.arange(3600) * 1.0
    warmth = 20.0 + 30.0 * (1.0 - np.abs(time / 1800.0 - 1.0))
    gyro = BIAS + 0.004 * (warmth - 20.0) + np.random.default_rng(4).normal(0.0, NOISE, len(time))
    with sqlite3.connect(tmp_path / "log.db") as base:
        base.execute("CREATE TABLE env (temp_degC REAL, time_s REAL)")
        base.execute("CREATE TABLE imu (time_s REAL, gyro_z_dps REAL)")
        base.executemany("INSERT INTO imu VALUES (?, ?)", zip(time.tolist(), gyro.tolist(), strict=True))
        base.executemany("INSERT INTO env VALUES (?, ?)", zip(warmth[::10].tolist(), time[::10].tolist(), strict=True))
    base.close()
    path = str(tmp_path / "log.db")
    assert call_json(capsys, "info", path)["results"][0]["next"].split()[1] == "thermal"
    content = call_json(capsys, "thermal", path, "--order", "1")
    holds(content, "bias", "z", BIAS)
    holds(content, "bias_temperature", "z", 0.004)
    (said,) = [one for one in content["remarks"] if one["code"] == "joined_by_time"]
    assert "temp_degC of topic env (360 messages)" in said["what"]


def test_an_only_output_beside_the_speed_of_a_table(tmp_path: Path, capsys: Capsys) -> None:
    """In mV and rpm, no axis named; `info` led to `allan`, `rate-table` to a schedule of dwells."""
    rows = [f"{t:.2f},{a / 6:.6f},{2500.0 + 20.0 * x:.3f}" for t, a, x in zip(*turned(), strict=True)]
    path = tmp_path / "rpm.csv"
    path.write_text("\n".join(["Elapsed Time (s),Table Speed (rpm),Rate Output (mV)", *rows]) + "\n")
    said = call_json(capsys, "info", str(path))["results"][0]["next"]
    assert "rate-table" in said
    assert "--axis AXIS" in said
    content = call_json(capsys, "rate-table", str(path))
    assert content["errors"][0]["do"] == "Add: --axis AXIS"
    chain = ("--reference", "2.5 V", "--scale-factor", "20 mV/(deg/s)")
    content = call_json(capsys, "rate-table", str(path), "--axis", "z", *chain)
    holds(content, "scale_factor_error", "z", 100.0 * ERROR)
    holds(content, "bias", "z", BIAS)


def test_a_column_called_lage_says_how_each_row_lay(tmp_path: Path, capsys: Capsys) -> None:
    """Of a table of means; before, the misalignments were not determined, and `info` asked for a sample rate."""
    rng = np.random.default_rng(7)
    rows = ["Lage;ax [g];ay [g];az [g]"]
    for k in (*range(6),) * 3:
        up = np.eye(3)[k // 2] * (1.0 - 2.0 * (k % 2))
        cells = (german(one, 6) for one in 1.003 * up + [0.006, -0.004, 0.009] + rng.normal(0.0, 3e-4, 3))
        rows.append(f"{'+-'[k % 2]}{'XYZ'[k // 2]};{';'.join(cells)}")
    path = tmp_path / "lagen.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert call_json(capsys, "info", str(path))["results"][0]["next"].split()[1] == "positions"
    content = call_json(capsys, "positions", str(path), "--gravity", "9.80665 m/s2")
    holds(content, "bias", "z", 0.009)
    holds(content, "scale_factor_error", "x", 0.3)
    holds(content, "misalignment", "xy", 0.0)


def test_a_second_record_in_a_file_is_to_be_cut_off(tmp_path: Path, capsys: Capsys) -> None:
    """Sorting, as was advised, would mix the two."""
    rows = [f"{k / 100},{0.01 * (k % 7)}" for k in range(2_000)] * 2
    path = tmp_path / "twice.csv"
    path.write_text("\n".join(["time [s],gyro_z [deg/s]", *rows]) + "\n")
    (error,) = call_json(capsys, "allan", str(path))["errors"]
    assert error["do"].startswith("Cut the record there")


def test_a_schedule_of_seconds_beside_a_clock_in_utc(tmp_path: Path, capsys: Capsys) -> None:
    """Its first dwell was looked for at the first second of 1970."""
    time, _, z = turned()
    start = np.datetime64("2026-03-25T08:00:00.000000000")
    stamps = start + np.round(time * 1e9).astype("timedelta64[ns]")
    rows = [f"{stamp}Z,{value:.6f}" for stamp, value in zip(stamps, z, strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(["time,gyro_z [deg/s]", *rows]) + "\n")
    for name, offset in (("seconds.csv", None), ("instants.csv", start)):
        ends = [(k * DWELL + 1, k * DWELL + DWELL - 1) for k in range(len(RATES))]
        said = ends if offset is None else [
            tuple(f"{offset + np.timedelta64(one, 's')}Z" for one in two) for two in ends]  # fmt: skip
        lines = [f"{a},{b},{rate}" for (a, b), rate in zip(said, RATES, strict=True)]
        (tmp_path / name).write_text("\n".join(["start,stop,rate [deg/s]", *lines]) + "\n")
    both = []
    for name in ("seconds.csv", "instants.csv"):
        words = ("rate-table", str(tmp_path / "log.csv"), "--axis", "z", "--schedule", str(tmp_path / name))
        content = call_json(capsys, *words)
        assert (name == "seconds.csv") == ("since_start" in {one["code"] for one in content["remarks"]})
        both.append(found(content, "scale_factor_error", "z"))
    assert both[0] == both[1]
    assert abs(both[0][0] - 100.0 * ERROR) < 4.0 * both[0][1]


def test_increments_of_a_kvh(tmp_path: Path, capsys: Capsys) -> None:
    """Angles and velocities by the sample, behind a counter that begins anew; m/s was no unit of velocity."""
    rng = np.random.default_rng(5)
    rate = 250.0
    angle = np.radians(rng.normal(BIAS, NOISE, (20_000, 3))) / rate
    speed = rng.normal([0.0, 0.0, 9.81], 0.02, (20_000, 3)) / rate
    head = "Seq,Gyro X (rad),Gyro Y (rad),Gyro Z (rad),Acc X (m/s),Acc Y (m/s),Acc Z (m/s)"
    rows = [",".join([str(k % 128), *(f"{one:.9e}" for one in (*angle[k], *speed[k]))]) for k in range(len(angle))]
    path = tmp_path / "kvh.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    status, out, _ = call(capsys, "info", str(path), "--sample-rate", "250")
    assert status == 0
    assert "look at 'Seq'" not in out
    content = call_json(capsys, "allan", str(path), "--quantity", "increment", "--sample-rate", "250")
    assert content["exit"] == 0
    for axis in "xyz":
        value, u = found(content, "angle_random_walk", axis)
        assert abs(value - NOISE / np.sqrt(rate) * 60.0) < 4.0 * u
        value, u = found(content, "velocity_random_walk", axis)
        assert abs(value - 0.02 / 9.80665 * 1e6 / np.sqrt(rate)) < 4.0 * u


def test_a_clock_of_whole_numbers_is_named_by_the_refusal(tmp_path: Path, capsys: Capsys) -> None:
    """It said to name the time column, which then was refused for want of a unit."""
    z = np.random.default_rng(6).normal(BIAS, NOISE, 5_000)
    rows = [f"{1_000_000_000 + k * 5_000_000},{one:.6f}" for k, one in enumerate(z)]
    path = tmp_path / "vn.csv"
    path.write_text("\n".join(["TimeStartup,gyro_z [deg/s]", *rows]) + "\n")
    content = call_json(capsys, "allan", str(path))
    assert content["errors"][0]["do"] == "Add --unit TimeStartup=UNIT"
    content = call_json(capsys, "allan", str(path), "--unit", "TimeStartup=ns")
    value, u = found(content, "angle_random_walk", "z")
    assert abs(value - NOISE / np.sqrt(200.0) * 60.0) < 4.0 * u


def test_codes_of_a_thermometer_are_no_kelvin(tmp_path: Path, capsys: Capsys) -> None:
    rows = [f"{k / 100},{k % 5},{250 + k % 3}" for k in range(2_000)]
    path = tmp_path / "adis.csv"
    path.write_text("\n".join(["time [s],X_GYRO_OUT,TEMP_OUT", *rows]) + "\n")
    assert "temperature=K" not in call(capsys, "info", str(path))[1]
