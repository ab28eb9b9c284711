"""Titles that a spreadsheet fills up, German words, a waveform without start, faces in mV: the right result."""

from __future__ import annotations

import json
import re
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from typed_commands import call

RATES = (-1200, -500, -100, 0, 100, 500, 1200)
ERROR, BIAS = 0.8, 0.3  # %, deg/s
FACES = ("x+", "x-", "y+", "y-", "z+", "z-")
FACE_ERRORS = (0.01, -0.01, 0.005)
VOLTS = ("--reference", "2.5 V", "--scale-factor", "0.02 V/(deg/s)")


def german(value: float, digits: int) -> str:
    return f"{value:,.{digits}f}".translate(str.maketrans(",.", ".,"))


def figures(out: str, quantity: str) -> dict[str, Any]:
    return {one["axis"]: one for one in json.loads(out)["results"]
            if one["quantity"] == quantity and one["method"] == "result"}  # fmt: skip


def right(out: str, axis: str) -> None:
    for quantity, truth in (("scale_factor_error", ERROR), ("bias", BIAS)):
        one = figures(out, quantity)[axis]
        assert one["value"] == pytest.approx(truth, abs=5.0 * one["u"])
        assert one["u"] < 0.05


@pytest.mark.parametrize("first", ["Zeitpunkt", "Stufe"])
def test_title_lines_as_wide_as_the_table(first: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng, start = np.random.default_rng(1), datetime(2024, 3, 12, 9, 15)
    lines = ["Messprotokoll Kreisel 3;;;", "Chargen-Nr.:;0815;;", f"{first};Drehrate soll (°/s);Drehrate ist (°/s);n"]
    for k, rate in enumerate(4 * RATES):
        begin = {"Zeitpunkt": f"{start + timedelta(minutes=k):%d.%m.%Y %H:%M:%S}", "Stufe": f"Stufe {k}"}
        reading = (1.0 + ERROR / 100.0) * rate + BIAS + 0.01 * rng.standard_normal()
        lines.append(f"{begin[first]};{german(rate, 1)};{german(reading, 3)};100")
    file = tmp_path / "tabelle.csv"
    file.write_text("\r\n".join(lines) + "\r\n", encoding="utf-8-sig", newline="")
    status, out, err = call(capsys, "rate-table", str(file), "--axis", "z", "--json")
    assert status == 0, err
    right(out, "z")


def turned(rate: float = 20.0) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return rate of the table and volts of a gyro about z, 8 s a dwell."""
    applied = np.repeat([0.0, 10, -10, 20, -20, 50, -50, 0, 35, -35, 0], int(8 * rate))
    noise = 0.02 * np.random.default_rng(2).standard_normal(len(applied))
    return applied, 2.5 + 0.02 * ((1.0 + ERROR / 100.0) * applied + BIAS + noise)


def init_and_run(capsys: pytest.CaptureFixture[str], folder: Path, *more: str) -> str:
    status, out, err = call(capsys, "init", str(folder), "--yes", *VOLTS, *more)
    assert status == 0, err
    assert "complete. Next: inertialcal run" in out
    status, out, err = call(capsys, "run", str(folder), "--json")
    assert status == 0, err
    return out


def test_a_german_table_names_its_rate_in_one_word(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    applied, volts = turned(10.0)
    rows = [f"{german(k / 10.0, 1)};{german(a, 2)};{german(1e3 * v, 3)}"
            for k, (a, v) in enumerate(zip(applied, volts, strict=True))]  # fmt: skip
    text = "\n".join(["sep=;", "Zeit [s];Tischdrehrate [°/s];Drehrate Z [mV]", *rows])
    (tmp_path / "tisch.csv").write_text(text + "\n", encoding="utf-8")
    right(init_and_run(capsys, tmp_path), "z")


def test_a_waveform_without_start_is_a_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tdms = pytest.importorskip("nptdms")
    applied, volts = turned()
    step = {"wf_increment": 0.05, "wf_samples": 1}
    channels = [tdms.ChannelObject("DAQ", "Table rate", applied, {"unit_string": "deg/s", **step}),
                tdms.ChannelObject("DAQ", "Gyro Z", volts, {"unit_string": "V", **step})]  # fmt: skip
    with tdms.TdmsWriter(str(tmp_path / "log.tdms")) as writer:
        writer.write_segment(channels)
    right(init_and_run(capsys, tmp_path), "z")


def test_init_yes_says_what_dates_need(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    applied, volts = turned(1.0)
    start = datetime(2024, 3, 12, 9, 15)
    rows = [f"{start + timedelta(seconds=k):%m/%d/%y %H:%M:%S},{a:g},{v:.6f}"
            for k, (a, v) in enumerate(zip(applied, volts, strict=True))]  # fmt: skip
    (tmp_path / "log.csv").write_text("\n".join(["time,table_rate [deg/s],gyro_z [V]", *rows]) + "\n")
    status, _, err = call(capsys, "init", str(tmp_path), "--yes", *VOLTS)
    assert (status, list(tmp_path.glob("*.toml"))) == (3, [])
    assert "which is the day" in " ".join(err.split())
    assert re.search(r"--dates day-first, or --dates month-first", " ".join(err.split()))
    right(init_and_run(capsys, tmp_path, "--dates", "month-first"), "z")


def faces(unit: str) -> str:
    rng, per_volt = np.random.default_rng(3), {"V": 1.0, "mV": 1e3}[unit]
    lines = [f"position,acc_x [{unit}],acc_y [{unit}],acc_z [{unit}]"]
    for name in 2 * FACES:
        force = np.where(np.arange(3) == "xyz".index(name[0]), 1.0 if name[1] == "+" else -1.0, 0.0)
        volts = 1.65 + 0.3 * (force * (1.0 + np.array(FACE_ERRORS)) + 0.001 * rng.standard_normal(3))
        lines.append(",".join([name, *(f"{per_volt * one:.6f}" for one in volts)]))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("unit", ["V", "mV"])
def test_means_of_faces_in_volts(unit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "faces.csv"
    file.write_text(faces(unit))
    options = ("--reference", "1.65 V", "--scale-factor", "0.3 V/g", "--json")
    status, out, err = call(capsys, "positions", str(file), *options)
    assert status == 0, err
    for axis, one in figures(out, "scale_factor_error").items():
        assert one["unit"] == "%"
        assert one["value"] == pytest.approx(100.0 * FACE_ERRORS["xyz".index(axis)], abs=5.0 * one["u"])
    for axis, one in figures(out, "bias").items():
        assert one["value"] == pytest.approx(0.0, abs=5.0 * one["u"]), axis


@pytest.mark.parametrize("unit", ["V", "mV"])
@pytest.mark.parametrize("nominal", ["0.3 V/g", "300 mV/g", ""])
def test_scale_factors_in_volts_are_those_of_the_sensor_and_err_from_what_was_stated(
    nominal: str, unit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "faces.csv"
    file.write_text(faces(unit))
    said = ("--scale-factor", nominal) if nominal else ()
    status, out, err = call(capsys, "positions", str(file), *said, "--acc-zero", "{x=1.65, y=1.65, z=1.65}", "--json")
    assert status == 0, err
    for axis, one in figures(out, "scale_factor").items():
        truth = 0.3 / 9.80665 * (1.0 + FACE_ERRORS["xyz".index(axis)])
        assert (one["unit"], one["value"]) == ("V/(m/s^2)", pytest.approx(truth, abs=5.0 * one["u"]))
    errors = figures(out, "scale_factor_error")
    assert set(errors) == set("xyz")
    for axis, one in errors.items():
        if nominal:
            assert one["value"] == pytest.approx(FACE_ERRORS["xyz".index(axis)], abs=5.0 * one["u"])
        else:  # nothing to differ from: a rounded estimate is no nominal value
            assert one["value"] is None
            assert "no nominal scale factor was stated" in one["reason"]["text"]


@pytest.mark.parametrize(("largest", "step", "told"), [(257.0, 1.0, True), (255.0, 1.0, False), (257.0, 0.5, False)])
@pytest.mark.parametrize(("group", "unit"), [("gyro", "rad/s"), ("acc", "m/s^2")])
def test_info_asks_whether_codes_stand_under_the_unit_of_a_message(
    group: str, unit: str, largest: float, step: float, told: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = step * np.random.default_rng(4).integers(-100, 100, (300, 3))
    values[0, 0] = largest
    names = ",".join(f"{group}_{axis} [{unit}]" for axis in "xyz")
    file = tmp_path / "log.csv"
    table = np.column_stack([np.arange(300) / 100.0, values])
    np.savetxt(file, table, "%.10g", ",", header=f"time [s],{names}", comments="")
    status, out, err = call(capsys, "info", str(file))
    assert status == 0, err
    assert (f"whole numbers up to 257: --unit {group}=count?" in out) == told


def test_a_hobo_says_by_its_label_which_sensor_gave_volts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    seconds, start = np.arange(0, 14400, 4), datetime(2024, 3, 13, 9, 15)
    warm = 20.0 + 30.0 * np.sin(2.0 * np.pi * seconds / 14400.0)
    volts = 2.5 + 0.02 * (0.1 + 0.004 * (warm - 20.0) + 0.01 * np.random.default_rng(5).standard_normal(len(warm)))
    serial = "LGR S/N: 20412345, SEN S/N: 20412345"
    rows = [f"{k + 1},{start + timedelta(seconds=int(s)):%m/%d/%y %I:%M:%S %p},{w:.3f},{v:.6f},"
            for k, (s, w, v) in enumerate(zip(seconds, warm, volts, strict=True))]  # fmt: skip
    head = (
        f'"#","Date Time, GMT+01:00","Temp, °C ({serial}, LBL: Box)","Volt, V ({serial}, LBL: Gyro Z)","Host Connected"'
    )
    text = "\r\n".join(['"Plot Title: Soak"', head, *rows]) + "\r\n"
    (tmp_path / "soak.csv").write_text(text, encoding="utf-8-sig", newline="")
    out = init_and_run(capsys, tmp_path)
    for quantity, truth in (("bias", 0.1), ("bias_temperature", 0.004)):
        one = figures(out, quantity)["z"]
        assert one["value"] == pytest.approx(truth, abs=5.0 * one["u"])


@pytest.mark.parametrize(("unit", "more"), [("mV", ("--reference", "1.65 V", "--scale-factor", "0.3 V/g")),
                                            ("", ("--unit", "acc=g"))])  # fmt: skip
def test_init_takes_a_table_of_faces(
    unit: str, more: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    head, *rows = faces("V").splitlines()
    cells = [row.split(",") for row in rows]
    zero, per = (0.0, 1e3) if unit else (1.65, 1.0 / 0.3)  # in g, where no unit is said
    lines = [",".join([name, *(f"{per * (float(one) - zero):.6f}" for one in values)]) for name, *values in cells]
    (tmp_path / "faces.csv").write_text("\n".join([head.replace(" [V]", f" [{unit}]" if unit else ""), *lines]) + "\n")
    status, out, err = call(capsys, "info", str(tmp_path / "faces.csv"))
    assert status == 0, err
    following = next(line for line in out.splitlines() if line.startswith("next: "))
    assert following.split()[2:3] == ["positions"]
    assert call(capsys, *following.split()[2:])[0] == 0
    status, out, err = call(capsys, "init", str(tmp_path), "--yes", *more)
    assert (status, "complete" in out) == (0, True), err
    status, out, err = call(capsys, "run", str(tmp_path), "--json")
    assert status == 0, err
    for axis, one in figures(out, "scale_factor_error").items():
        assert one["value"] == pytest.approx(100.0 * FACE_ERRORS["xyz".index(axis)], abs=5.0 * one["u"])
