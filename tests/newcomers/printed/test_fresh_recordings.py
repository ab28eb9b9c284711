"""Recordings as loggers and apps write them, made from manuals and not from our readers: the numbers come back."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from datetime import datetime, timedelta
from functools import reduce
from operator import xor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.files import read
from typed_commands import call_json

N, RATE = 400, 100.0
RNG = np.random.default_rng(12)
TIME = np.arange(N) / RATE
GYRO = RNG.normal((0.35, -0.21, 0.12), 0.02, (N, 3))  # deg/s
ACC = RNG.normal((0.01, -0.02, 9.81), 0.01, (N, 3))  # m/s2
TEMPERATURE = np.linspace(20.0, 50.0, N)
CLOCK = [(datetime(2024, 3, 12, 12, 3, 14, 123000) + timedelta(seconds=t)).strftime("%H:%M:%S.%f")[:-3] for t in TIME]


def joined(*rows: str, end: str = "\n") -> str:
    return end.join(rows) + end


def arduino() -> str:
    return joined(*(f"{at} -> {x:.5f},{y:.5f},{z:.5f}" for at, (x, y, z) in zip(CLOCK, GYRO, strict=True)), end="\r\n")


def plotter() -> str:
    rows = zip(CLOCK, GYRO, strict=True)
    return joined("MPU6050 ready", *(f"{at} -> gx:{x:.5f},gy:{y:.5f},gz:{z:.5f}" for at, (x, y, z) in rows))


def adafruit() -> str:
    title = ("Orientation Sensor Raw Data Test", "", "Current Temperature: 24 C", "")
    rows = (f"Accel: X={a:.5f} Y={b:.5f} Z={c:.5f} | Gyro: X={x:.5f} Y={y:.5f} Z={z:.5f}"
            for (a, b, c), (x, y, z) in zip(ACC, GYRO, strict=True))  # fmt: skip
    return joined(*title, *rows)


def sentence(content: str) -> str:
    return f"${content}*{reduce(xor, content.encode()):02X}"


def vectornav() -> str:
    rows = zip(ACC, np.radians(GYRO), TEMPERATURE, strict=True)
    return joined(*(sentence(",".join(["VNIMU", *(f"{one:+.7f}" for one in (0.4, -0.1, -0.8, *a, *g, t, 101.325))]))
                    for a, g, t in rows), end="\r\n")  # fmt: skip


def shimmer() -> str:
    what = ["Timestamp_Unix_CAL", *(f"Accel_LN_{axis}_CAL" for axis in "XYZ"), *(f"Gyro_{axis}_CAL" for axis in "XYZ")]
    units = ["ms", *["m/(s^2)"] * 3, *["deg/s"] * 3, "Degrees Celsius"]
    names = [f"Shimmer_5E36_{one}" for one in (*what, "Temperature_BMP280_CAL")]
    rows = ((1.7e12 + 1e3 * t, *a, *g, c) for t, a, g, c in zip(TIME, ACC, GYRO, TEMPERATURE, strict=True))
    cells = ("\t".join([*map(repr, map(float, row)), ""]) for row in rows)
    return joined('"sep=\t"', "\t".join([*names, ""]), "\t".join([*units, ""]), *cells)


def racechrono() -> str:
    head = ["This file is created using RaceChrono v8.0.1 ( http://racechrono.com/ ).", "", "Format,3",
            'Session title,"Test"', "Created,12/03/2024,09:15", "", "timestamp,elapsed_time,x_acc,y_acc,z_acc,"
            "x_rate_of_rotation,y_rate_of_rotation,z_rate_of_rotation", "unix time,s,G,G,G,deg/s,deg/s,deg/s",
            ",,101: acc,101: acc,101: acc,102: gyro,102: gyro,102: gyro"]  # fmt: skip
    rows = zip(TIME, ACC / 9.80665, GYRO, strict=True)
    return joined(*head, *(",".join(f"{one:.6f}" for one in (1710234900 + t, t, *a, *g)) for t, a, g in rows))


def german() -> str:
    def cell(value: float, digits: int) -> str:
        return f"{value:,.{digits}f}".translate(str.maketrans(",.", ".,"))

    rows = ([cell(1e3 * t, 0), *(cell(3600.0 * one, 2) for one in g), cell(c, 2)]
            for t, g, c in zip(TIME, GYRO, TEMPERATURE, strict=True))  # fmt: skip
    head = "Zeit [ms];Drehrate X [°/h];Drehrate Y [°/h];Drehrate Z [°/h];Temperatur [°C]"
    return joined("Messung;Drehtisch 3;;;", "Datum;12.03.2024;;;", head, *map(";".join, rows))


def timetable() -> str:
    rows = zip(TIME, GYRO, strict=True)
    return joined("Time,gyro_x,gyro_y,gyro_z", *(f"{t:g} sec,{x:.7g},{y:.7g},{z:.7g}" for t, (x, y, z) in rows))


def betaflight() -> str:
    head = "loopIteration, time (us), gyroADC[0], gyroADC[1], gyroADC[2], vbatLatest (V), flightModeFlags (flags)"
    rows = (
        f"{i}, {12345678 + 10000 * i}, {x:.5f}, {y:.5f}, {z:.5f}, 16.1, ANGLE_MODE" for i, (x, y, z) in enumerate(GYRO)
    )
    return joined(head, *rows)


def r_csv2() -> str:
    rows = ([f"{one:.7g}".replace(".", ",") for one in (t, *g)] for t, g in zip(TIME, GYRO, strict=True))
    head = '"";"zeit";"gyro_x";"gyro_y";"gyro_z"'
    return joined(head, *(";".join([f'"{i}"', *row]) for i, row in enumerate(rows, 1)))


IN_ORDER = ["column_2", "column_3", "column_4"]
FILES: dict[str, tuple[Callable[[], str], list[str], float, bool]] = {  # -> text, columns, unit in deg/s, has time
    "arduino.txt": (arduino, IN_ORDER, 1.0, True),
    "plotter.txt": (plotter, ["gx", "gy", "gz"], 1.0, True),
    "adafruit.txt": (adafruit, ["Gyro.X", "Gyro.Y", "Gyro.Z"], 1.0, False),
    "vectornav.txt": (vectornav, [f"gyro_{axis} [rad/s]" for axis in "xyz"], float(np.degrees(1.0)), False),
    "shimmer.csv": (shimmer, [f"Shimmer_5E36_Gyro_{axis}_CAL" for axis in "XYZ"], 1.0, True),
    "racechrono.csv": (racechrono, [f"{axis}_rate_of_rotation" for axis in "xyz"], 1.0, True),
    "german.csv": (german, [f"Drehrate {axis} [°/h]" for axis in "XYZ"], 1.0 / 3600.0, True),
    "timetable.csv": (timetable, ["gyro_x", "gyro_y", "gyro_z"], 1.0, True),
    "betaflight.csv": (betaflight, ["gyroADC[0]", "gyroADC[1]", "gyroADC[2]"], 1.0, True),
    "r_csv2.csv": (r_csv2, ["gyro_x", "gyro_y", "gyro_z"], 1.0, True),
}


@pytest.mark.parametrize("name", FILES)
def test_numbers_axes_and_time_come_back(tmp_path: Path, name: str) -> None:
    text, columns, unit, has_time = FILES[name]
    path = tmp_path / name
    path.write_bytes(text().encode("cp1252" if name == "german.csv" else "utf-8"))
    found = read(path)
    assert found.array(columns) * unit == pytest.approx(GYRO, abs=2e-5)
    if columns is not IN_ORDER:
        assert [found.channel(one).axis for one in columns] == ["x", "y", "z"]
        assert {found.channel(one).quantity for one in columns} == {"gyro"}
    assert (found.sample_rate == pytest.approx(RATE)) if has_time else (found.time_ns is None)


@pytest.mark.parametrize(
    ("name", "unit"), [("shimmer.csv", "m/s^2"), ("racechrono.csv", "g"), ("vectornav.txt", "m/s^2")]
)
def test_units_that_the_file_says_are_taken(tmp_path: Path, name: str, unit: str) -> None:
    path = tmp_path / name
    path.write_text(FILES[name][0]())
    acc = [one for one in read(path).channels if one.quantity == "acc"]
    assert [(one.axis, one.unit) for one in acc] == [("x", unit), ("y", unit), ("z", unit)]


def test_a_serial_monitor_gives_a_model_over_temperature_in_one_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log.txt"
    log = zip(CLOCK, GYRO, TEMPERATURE, strict=True)
    path.write_text(joined(*(f"{at} -> gx:{x:.5f} gy:{y:.5f} gz:{z:.5f} temp:{t:.3f}" for at, (x, y, z), t in log)))
    content = call_json(capsys, "thermal", str(path), "--unit", "gyro=deg/s", "--unit", "temp=degC")
    rows = [one for one in content["results"] if (one["axis"], one["quantity"]) == ("x", "bias")]
    (bias,) = [one for one in rows if one["method"] == "result" and one["value"]]
    assert abs(bias["value"] - 0.35) < 5.0 * bias["u"]


def test_a_line_that_is_none_is_named_with_its_row(tmp_path: Path) -> None:
    lines = plotter().splitlines()
    lines[200] = "rst:0x1 (POWERON_RESET)"
    (tmp_path / "a.txt").write_text(joined(*lines))
    with pytest.raises(DataError, match="not like the others") as caught:
        read(tmp_path / "a.txt")
    assert caught.value.problems[0].where.endswith("a.txt:201")


def test_a_last_line_that_is_cut_off_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text(plotter() + "12:03:19.1")
    assert len(read(tmp_path / "a.txt")) == N


def test_sentences_with_a_wrong_check_sum_are_left_out_and_counted(tmp_path: Path) -> None:
    lines = vectornav().splitlines()
    lines[7] = lines[7].replace("+", "-", 1)
    lines[9] = lines[9][:30]
    (tmp_path / "a.txt").write_text(joined(*lines))
    found = read(tmp_path / "a.txt")
    assert len(found) == N - 2
    (damaged,) = [one for one in found.remarks if one.code == "damaged_records"]
    assert (damaged.count, damaged.where) == (2, f"{tmp_path / 'a.txt'}:8")


def test_whole_numbers_with_a_point_stay_refused_where_no_cell_has_both_signs(tmp_path: Path) -> None:
    rows = (f"{10 * i:,}".replace(",", ".") + f";{i % 7},5" for i in range(N))
    (tmp_path / "a.csv").write_text(joined("t [ms];gyro_x [deg/s]", *rows))
    with pytest.raises(DataError) as caught:
        read(tmp_path / "a.csv")
    assert caught.value.problems[0].code == "grouped_digits"


def test_words_in_the_first_row_of_a_column_of_words_are_data(tmp_path: Path) -> None:
    rows = (f"{t:.2f},1.5,{'warm' if t < 2 else 'cold'}" for t in TIME)
    (tmp_path / "a.csv").write_text(joined("t [s],gyro_x [deg/s],state", *rows))
    assert len(read(tmp_path / "a.csv")) == N


WORDS = st.sampled_from(
    ["12:03:14.123 -> ", "gx:", "1.5", ",", " ", "\n", "$VNIMU,", "*5A", " sec", "x", "=", "#", ";"]
)


@given(parts=st.lists(WORDS, max_size=60))
def test_whatever_is_printed_is_read_or_refused_in_words(
    tmp_path_factory: pytest.TempPathFactory, parts: list[str]
) -> None:
    path = tmp_path_factory.mktemp("printed") / "a.txt"
    path.write_text("".join(parts))
    with suppress(InertialcalError):
        read(path)
