"""Files of people who write other words, clocks and layouts: what they say is read, and one command gives the truth."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.files.text.headers import heading
from typed_commands import call, call_json

Capsys = pytest.CaptureFixture[str]
Numbers = NDArray[np.float64]
ERROR, BIAS, NOISE, G = 0.012, 0.25, 0.02, 9.80665  # 1, deg/s, deg/s, m/s^2
RATES = (0.0, 20.0, -20.0, 40.0, -40.0, 60.0, -60.0, 0.0, 20.0, -20.0, 40.0, -40.0)  # a programme that repeats itself


def turned(axis: int, seed: int) -> tuple[Numbers, Numbers, Numbers]:
    """Return time, rate of the table, shape (n,), and readings of three gyros of which one was turned, shape (n, 3)."""
    applied = np.repeat(RATES, 100)
    readings = BIAS + np.random.default_rng(seed).normal(0.0, NOISE, (len(applied), 3))
    readings[:, axis] += (1.0 + ERROR) * applied
    return np.arange(len(applied)) / 20.0, applied, readings


def soaked(seed: int) -> tuple[Numbers, Numbers, Numbers]:
    """Return time, temperature, shape (n,), and readings of three gyros with 0.002 deg/s/K, shape (n, 3)."""
    time = np.arange(3000.0)
    warmth = np.interp(time, [0.0, 1500.0, 2999.0], [-10.0, 50.0, -10.0])
    noise = np.random.default_rng(seed).normal(0.0, NOISE, (len(time), 3))
    return time, warmth, BIAS + 0.002 * (warmth - 20.0)[:, None] + noise


def rest(seed: int, n: int = 3000) -> tuple[Numbers, Numbers]:
    """Return rates [deg/s] and specific force [m/s^2] at rest, shape (n, 3)."""
    random = np.random.default_rng(seed)
    return random.normal(BIAS, NOISE, (n, 3)), random.normal([0.0, 0.0, G], 0.004, (n, 3))


def text(head: Sequence[str], columns: Sequence[Iterable[object]], separator: str = ",") -> str:
    """Return a table as text."""
    rows = [separator.join(map(str, row)) for row in zip(*columns, strict=True)]
    return "\n".join([separator.join(head), *rows]) + "\n"


def printed(values: NDArray[Any], digits: int, comma: bool = False) -> list[str]:
    """Return numbers with so many decimals, with a decimal comma or a point."""
    found = [f"{one:.{digits}f}" for one in values]
    return [one.replace(".", ",") for one in found] if comma else found


def stamps_of(path: Path) -> NDArray[np.int64]:
    """Return the stamps of a file as read [ns]."""
    found = ic.read(path).stamps
    assert found is not None
    return found


def next_of(capsys: Capsys, path: Path) -> list[str]:
    """Return the words of the command that ``info`` says to type next."""
    _, out, _ = call(capsys, "info", str(path))
    (line,) = [one for one in out.splitlines() if one.startswith("next: ")]
    return shlex.split(line)[2:]


def holds(content: dict[str, Any], quantity: str, axis: str, true: float, least: float = 0.0) -> None:
    """Check each estimate of a quantity of an axis."""
    rows = content["results"]
    own = [
        one for one in rows if (one["quantity"], one["axis"], one["method"]) == (quantity, axis, "result") and one["u"]
    ]
    assert own
    assert all(abs(one["value"] - true) < 4.0 * one["u"] + least for one in own), (quantity, axis, own)


@pytest.mark.parametrize(
    ("name", "quantity", "axis", "unit"),
    [
        ("AcX", "acc", "x", None),
        ("gyrX_radps", "gyro", "x", "rad/s"),
        ("wx_deg_sec", "gyro", "x", "deg/s"),
        ("acc_y_ms2", "acc", "y", "m/s^2"),
        ("temp_C", "temperature", "", "degC"),
        ("[ms]", "time", "", "ms"),
        ("Roll Rate (deg/s)", "gyro", "x", "deg/s"),
        ("Nickrate [°/s]", "gyro", "y", "deg/s"),
        ("YawRate", "gyro", "z", None),
        ("roll [deg]", "", "", "deg"),
        ("Velocità angolare X [°/s]", "gyro", "x", "deg/s"),
        ("Giróscopo Z (°/s)", "gyro", "z", "deg/s"),
        ("Aceleración Y (m/s²)", "acc", "y", "m/s^2"),
        ("Temperatura (°C)", "temperature", "", "degC"),
        ("Desviación estándar X [g]", "spread", "", "g"),
        ("delay_ms2", "", "", None),
    ],
)
def test_what_names_of_other_tongues_and_programs_say(name: str, quantity: str, axis: str, unit: str | None) -> None:
    said = heading(name)
    assert (said.quantity, said.axis, said.unit) == (quantity, axis, unit)


@pytest.mark.parametrize("names", ["rx,ry,rz", "p,q,r", "omega_1x,omega_1y,omega_1z"])
def test_three_columns_that_differ_in_one_letter_are_the_axes(names: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rates, _ = rest(1, 50)
    path.write_text(text(["t [s]", *(f"{one} [rad/s]" for one in names.split(","))],
                         [printed(np.arange(50) / 10.0, 1), *(printed(one, 5) for one in rates.T)]))  # fmt: skip
    assert [one.axis for one in ic.read(path).channels if one.quantity == "gyro"] == ["x", "y", "z"]


def test_words_beside_letters_name_no_axis(tmp_path: Path) -> None:
    path = tmp_path / "ins.csv"
    rates, _ = rest(1, 50)
    head = ["t [s]", "GyroX [rad/s]", "GyroY [rad/s]", "GyroZ [rad/s]", "Yaw Rate [rad/s]"]
    path.write_text(
        text(head, [printed(np.arange(50) / 10.0, 1), *(printed(one, 5) for one in (*rates.T, rates[:, 2]))])
    )
    assert [one.axis for one in ic.read(path).channels if one.quantity == "gyro"] == ["x", "y", "z", ""]


def test_an_italian_table_that_runs_its_programme_twice_holds_no_copy(tmp_path: Path, capsys: Capsys) -> None:
    time, applied, readings = turned(2, 4)
    path = tmp_path / "tavola.txt"
    head = ["Tempo [s]", "Velocità tavola [°/s]", *(f"Velocità angolare {one} [°/s]" for one in "XYZ")]
    columns = [printed(time, 2, True), printed(applied, 2, True), *(printed(one, 4, True) for one in readings.T)]
    path.write_text(text(head, columns, "\t"), encoding="utf-16")
    (survey,) = call_json(capsys, "info", str(path))["results"]
    assert "repeated" not in [one["code"] for one in survey["remarks"]]
    content = call_json(capsys, *next_of(capsys, path))
    holds(content, "scale_factor_error", "z", 100.0 * ERROR)
    holds(content, "bias", "z", BIAS)


@pytest.mark.parametrize("unit", ["Counts", "°/s"])
def test_each_file_was_turned_about_its_own_axis(unit: str, tmp_path: Path, capsys: Capsys) -> None:
    """`init` wrote the axis of the first file into all: x was -66 % off."""
    for axis, letter in enumerate("XYZ"):
        time, applied, readings = turned(axis, 10 + axis)
        values = np.rint(2048.0 + readings * 16.384) if unit == "Counts" else readings
        head = ["Zeit [s]", "Tischrate [°/s]", *(f"Kanal {one} [{unit}]" for one in "XYZ")]
        columns = [printed(one, 3) for one in (time, applied, *values.T)]
        (tmp_path / f"Drehtisch_{letter}.csv").write_text(text(head, columns), encoding="utf-8")
    chain = ["--lsb", "5 V / 4096", "--reference", "2.5 V", "--scale-factor", "0.02 V/(deg/s)"]
    status, _, err = call(capsys, "init", str(tmp_path), "--yes", *(chain if unit == "Counts" else ()))
    assert status == 0, err
    content = call_json(capsys, "run", str(tmp_path))
    for turned_axis in "xyz":
        holds(content, "scale_factor_error", turned_axis, 100.0 * ERROR)


def test_gyros_and_accelerometers_of_one_log_are_two_tests_over_temperature(tmp_path: Path, capsys: Capsys) -> None:
    """`run` refused what `init` had written: both tests read the same file, but not the same columns."""
    time, warmth, rates = soaked(5)
    force = np.random.default_rng(6).normal([0.0, 0.0, G], 0.003, (len(time), 3)) + 1e-4 * (warmth - 20.0)[:, None]
    head = ["time_s", "gx_dps", "gy_dps", "gz_dps", "ax_mps2", "ay_mps2", "az_mps2", "setpoint_degC", "probe_degC"]
    columns = [time, *rates.T, *force.T, np.rint(warmth / 20.0) * 20.0, warmth]
    path = tmp_path / "soak.csv"
    path.write_text(text(head, [printed(one, 6) for one in columns]))
    assert call(capsys, "init", str(tmp_path), "--yes")[0] == 0
    content = call_json(capsys, "run", str(tmp_path))
    slopes = [one for one in content["results"] if (one["quantity"], one["power"], one["method"]) ==
              ("bias_temperature", 1, "result") and one["u"]]  # fmt: skip
    assert {one["unit"] for one in slopes} == {"deg/s/degC", "m/s^2/degC"}
    for one in slopes:
        true = 0.002 if one["unit"].startswith("deg") else 1e-4
        assert abs(one["value"] - true) < 5.0 * one["u"], one


def test_which_of_two_thermometers_is_asked_by_info_as_by_the_test(tmp_path: Path, capsys: Capsys) -> None:
    time, warmth, rates = soaked(7)
    head = ["time_s", "gx_dps", "gy_dps", "gz_dps", "t_case [degC]", "t_board [degC]"]
    path = tmp_path / "soak.csv"
    path.write_text(text(head, [printed(one, 5) for one in (time, *rates.T, warmth, warmth + 2.0)]))
    words = next_of(capsys, path)
    assert words[-2:] == ["--column", "temperature=COLUMN"]
    assert call(capsys, *words[:-2])[0] == 2
    assert call(capsys, *words[:-1], "temperature=t_case")[0] == 0


def test_days_of_a_year_are_instants(tmp_path: Path) -> None:
    path = tmp_path / "head.csv"
    stamps = [f"2024/366/23:59:{58 + i // 2:02d}.{5 * (i % 2)}00" for i in range(4)] + ["2025/001/00:00:00.000"]
    path.write_text(text(["GMT", "ax [ug]"], [stamps, range(5)]))
    assert int(stamps_of(path)[-1]) == 1_735_689_600 * 10**9
    assert np.diff(stamps_of(path)).tolist() == [500_000_000] * 4
    path.write_text(text(["GMT", "ax [ug]"], [["2023/366/00:00:00", "2023/366/00:00:01"], range(2)]))
    with pytest.raises(ic.InertialcalError, match=r"no time|not a date"):
        ic.read(path)


@pytest.mark.parametrize(
    ("first", "second", "step"),
    [
        ("12-Mär-2026 07:40:34", "12-Mär-2026 07:40:35", 1.0),
        ("31 dic. 2026 11:59:59 PM", "1 ene. 2027 12:00:00 AM", 1.0),
        ("0 days 00:00:00.500000", "1 days 00:00:00.250000", 86_399.75),
        ("2026-071T07:40:34", "2026-071T07:40:35", 1.0),
    ],
)
def test_months_with_names_and_elapsed_days_are_time(first: str, second: str, step: float, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text(["", "gx [deg/s]"], [[first, second], range(2)]), encoding="utf-8")
    assert np.diff(stamps_of(path)).tolist() == [round(step * 1e9)]


def test_a_table_turned_about_yaw_has_its_command_apart(tmp_path: Path, capsys: Capsys) -> None:
    time, applied, readings = turned(2, 14)
    path = tmp_path / "run.csv"
    head = ["Time(s)", "Rate Table Command (deg/s)", "Roll Rate (deg/s)", "Pitch Rate (deg/s)", "Yaw Rate (deg/s)"]
    path.write_text(text(head, [printed(one, 4) for one in (time, applied, *readings.T)]))
    words = next_of(capsys, path)
    assert words[-2:] == ["--axis", "z"]
    holds(call_json(capsys, *words), "scale_factor_error", "z", 100.0 * ERROR)


def test_a_flip_without_a_clock_says_what_it_takes(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "means.csv"
    path.write_text(text(["Position", "X [ug]", "Y [ug]", "Z [ug]"], [[0, 180] * 3, *[range(6)] * 3]))
    status, _, err = call(capsys, "flip", str(path))
    assert status == 2
    assert "a row an axis and position" in " ".join(err.split())


def test_a_counter_of_32_bits_goes_on(tmp_path: Path, capsys: Capsys) -> None:
    rates, _ = rest(8)
    micros = (np.arange(len(rates)) * 10_000 + 2**32 - 9_000_000) % 2**32
    path = tmp_path / "wrapped.csv"
    path.write_text(text(["micros", "gx [deg/s]", "gy [deg/s]", "gz [deg/s]"],
                         [micros, *(printed(one, 5) for one in rates.T)]))  # fmt: skip
    recording = ic.read(path)
    assert set(np.diff(stamps_of(path)).tolist()) == {10_000_000}
    assert [one.count for one in recording.remarks if one.code == "counter_anew"] == [1]
    assert call(capsys, *next_of(capsys, path), "-q")[0] == 0


def test_a_stamp_that_came_twice_before_a_long_step_lies_midway(tmp_path: Path) -> None:
    time = np.arange(1000) * 0.01
    late, twice = time.copy(), np.concatenate([time[:500], time[499:]])
    late[[300, 700]] = late[[299, 699]]
    for name, stamps, repeated in (("late", late, 0), ("twice", twice, 1)):
        path = tmp_path / f"{name}.csv"
        path.write_text(text(["t [s]", "gx [deg/s]"], [printed(stamps, 2), range(len(stamps))]))
        assert np.count_nonzero(np.diff(stamps_of(path)) == 0) == repeated


def test_gravity_that_reads_one_under_metres_is_told_by_every_test(tmp_path: Path, capsys: Capsys) -> None:
    _, force = rest(9)
    path = tmp_path / "lidar.csv"
    columns = [printed(np.arange(len(force)) / 100.0, 2), *(printed(one, 6) for one in (force / G).T)]
    path.write_text(text(["t [s]", "ax [m/s2]", "ay [m/s2]", "az [m/s2]"], columns))
    (said,) = [
        one for one in call_json(capsys, "allan", str(path))["remarks"] if one["code"] == "gravity_in_another_unit"
    ]
    assert "g" in said["do"]
    content = call_json(capsys, "allan", str(path), "--unit", "acc=g")
    assert "gravity_in_another_unit" not in [one["code"] for one in content["remarks"]]


def test_a_table_of_dwells_reads_grouped_counts_as_info_does(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "drehtisch.csv"
    rates = [0, 30, -30, 60, -60, 100, -100, 0]
    mean = [f"{2512.0 + 20.16 * one:,.2f}".translate(str.maketrans(",.", ".,")) for one in rates]
    path.write_text(text(["Soll-Drehrate [°/s]", "Mittelwert [mV]", "Anzahl"], [rates, mean, ["1.000"] * 8], ";"))
    chain = ["--reference", "2.5 V", "--scale-factor", "20 mV/(deg/s)"]
    holds(call_json(capsys, "rate-table", str(path), "--axis", "x", *chain), "scale_factor_error", "x", 0.8, 1e-6)


def test_faces_in_german_with_their_scatter(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "lagen.csv"
    up = np.concatenate([np.eye(3), -np.eye(3)])
    read = up * [1.002, 0.997, 1.004] + [0.02, -0.015, 0.03] + np.random.default_rng(3).normal(0.0, 1e-5, (6, 3))
    head = ["Lage", *(f"Mittelwert {one} [g]" for one in "XYZ"), *(f"Stabw. {one} [g]" for one in "XYZ"), "n"]
    words = [f"{one} {way}" for way in ("oben", "unten") for one in "XYZ"]
    path.write_text(text(head, [words, *(printed(one, 6) for one in read.T), *[["0.0004"] * 6] * 3, ["2000"] * 6]))
    content = call_json(capsys, "positions", str(path))
    holds(content, "bias", "y", -0.015)
    holds(content, "scale_factor_error", "z", 0.4)
    assert not {"no_scatter", "no_dof"} & {one["code"] for one in content["remarks"]}


def test_a_french_profile_and_a_control_whose_name_has_a_blank(tmp_path: Path, capsys: Capsys) -> None:
    profile, path = tmp_path / "profil.csv", tmp_path / "pot.csv"
    profile.write_text("Fréquence (Hz);DSP (g²/Hz)\n20;0,01\n400;0,01\n", encoding="utf-8")
    random = np.random.default_rng(5)
    spectrum = np.where((f := np.fft.rfftfreq(40_000, 1e-3)) >= 20.0, 1.0, 0.0) * (f <= 400.0)
    drive = np.fft.irfft(spectrum * np.sqrt(0.01 * 1000.0 * 40_000 / 2.0) * np.exp(2j * np.pi * random.random(len(f))))
    columns = [printed(one, 4) for one in (np.arange(40_000) / 1000.0, drive, drive)]
    path.write_text(text(["Temps (s)", "Accélération Pilote (g)", "Accélération Z (g)"], columns), encoding="utf-8")
    words = [one.replace("FILE.csv", str(profile)) for one in next_of(capsys, path)]
    content = call_json(capsys, *words)
    levels = [one["value"] for one in content["results"] if one["quantity"] == "acceleration_rms"]
    assert levels[0] == pytest.approx(np.sqrt(0.01 * 380.0), rel=0.06)  # of the lines within the profile


def test_a_log_in_text_needs_neither_lengths_nor_units(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "flight.log"
    rates, force = rest(11)
    rows = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns", "FMT, 163, 55, IMU, QBffffff, "
            "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"]  # fmt: skip
    for i, (rate, acc) in enumerate(zip(np.radians(rates), force, strict=True)):
        values = ", ".join(f"{one:.6f}" for one in (*rate, *acc))
        rows += [f"IMU, {5_000_000 + 10_000 * i}, {instance}, {values}" for instance in (0, 1)]
    path.write_text("\n".join(rows) + "\n")
    lines = [line for line in call(capsys, "info", str(path))[1].splitlines() if line.startswith("next: ")]
    assert len(lines) == 2
    found = call_json(capsys, *shlex.split(lines[0])[2:])["results"]
    walk = [one["value"] for one in found if one["quantity"] == "angle_random_walk"]
    assert walk == pytest.approx([NOISE / 10.0 * 60.0] * 3, rel=0.1)
