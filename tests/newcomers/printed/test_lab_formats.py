"""Files of laboratories whose tables stand beside others, below few units, or under a clock of any name."""

from __future__ import annotations

import datetime
import json
import sqlite3
import struct
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from endaq_files import Group, Subchannel, write_endaq
from newcomer_boards import GYRO_BIASES, six_faces
from newcomer_truths import BIASES, ERRORS, NOISE, Log, at_rest, rate_table

import inertialcal as ic
from inertialcal.core.errors import DataError
from typed_commands import call

pytestmark = pytest.mark.usefixtures("undrawn")
START = datetime.datetime(2025, 6, 17, 7, 30, tzinfo=datetime.UTC)
GYRO = ("gyro_x", "gyro_y", "gyro_z")
Columns = dict[str, tuple[np.ndarray[Any, Any], str]]


def columns(log: Log) -> Columns:
    """Return a rate table in degrees a second, as columns with their units."""
    found = {name: (log.readings[name[-1]], "deg/s") for name in GYRO}
    return found | {"table_rate": (log.applied, "deg/s"), "temperature": (log.temperature, "degC")}


def stamps(log: Log) -> list[datetime.datetime]:
    return [START + datetime.timedelta(microseconds=round(1e6 * one)) for one in log.time]


def mdf(log: Log, path: Path) -> None:
    """Write a group of the gyros, one of a battery."""
    from asammdf import MDF, Signal

    with MDF(version="4.20") as file:
        file.append([Signal(values, log.time, unit, name) for name, (values, unit) in columns(log).items()])
        file.append([Signal(np.arange(3.0), np.arange(3.0) * 10.0, "%", "Battery")])
        file.save(path, compression=1)


def tdms(log: Log, path: Path) -> None:
    """Write a group of the gyros, one of a thermometer that is slower."""
    from nptdms import ChannelObject, TdmsWriter

    step = {"wf_increment": float(log.time[1]), "wf_start_time": np.datetime64("2025-06-17T07:30:00")}
    with TdmsWriter(str(path)) as file:
        slow = ChannelObject("Ambient", "Pt100", np.full(20, 21.5), {"wf_increment": 5.0, "unit_string": "degC"})
        file.write_segment([slow, *(ChannelObject("Gyro", name, values, {**step, "unit_string": unit})
                                    for name, (values, unit) in columns(log).items())])  # fmt: skip


def uff(log: Log, path: Path) -> None:
    """Write functions of numbered nodes whose texts say what they are."""
    import pyuff

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        file = pyuff.UFF(str(path))
        for node, (name, (values, unit)) in enumerate(columns(log).items(), 1):
            one = pyuff.prepare_58(
                binary=1, func_type=1, rsp_node=node, rsp_dir=1, ref_dir=0, ref_node=0, data=values, x=log.time,
                id1=name, rsp_ent_name="NONE", abscissa_spacing=1, abscissa_inc=float(log.time[1]), abscissa_min=0.0,
                abscissa_spec_data_type=17, ordinate_spec_data_type=0, ordinate_axis_units_lab=unit,
                orddenom_spec_data_type=0, num_pts=len(log.time), z_axis_value=0.0,
            )  # fmt: skip
            file.write_sets(one, "add")
        del file


def sqlite(log: Log, path: Path) -> None:
    """Write a table with a number a row and Python's own stamps, which lack the fraction at whole seconds."""
    with sqlite3.connect(path) as file:
        names = [f"{name}_{'degC' if unit == 'degC' else 'dps'}" for name, (_, unit) in columns(log).items()]
        file.execute("CREATE TABLE events(at TEXT, battery REAL)")
        file.executemany("INSERT INTO events VALUES (?, ?)", [("2025-06-17", 3.9), ("2025-06-18", 3.8)])
        file.execute(f"CREATE TABLE samples(id INTEGER PRIMARY KEY, recorded_at TEXT, {', '.join(names)})")
        table = np.column_stack([values for values, _ in columns(log).values()]).tolist()
        rows = [(at.isoformat(), *row) for at, row in zip(stamps(log), table, strict=True)]
        file.executemany(f"INSERT INTO samples(recorded_at, {', '.join(names)}) VALUES (?, ?, ?, ?, ?, ?)", rows)
    file.close()


def excel(log: Log, path: Path) -> None:
    """Write a title, names, units of a few columns alone, an empty row, and the table; and a sheet of remarks."""
    from openpyxl import Workbook

    book = Workbook()
    sheet, about = book.active, book.create_sheet("Operator")
    assert sheet is not None
    about.append(["Name", "K. Huber"])
    found = columns(log)
    for row in (["Drehtisch"], [], ["Timestamp", *found], [None, "deg/s", "", "", "deg/s", ""], []):
        sheet.append(row)
    table = np.column_stack([values for values, _ in found.values()]).tolist()
    for at, own in zip(stamps(log), table, strict=True):
        sheet.append([at.replace(tzinfo=None), *own])
    book.save(path)


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("log.db", sqlite),
        *(pytest.param(*one, marks=pytest.mark.slow)
          for one in (("log.mf4", mdf), ("log.tdms", tdms), ("log.uff", uff), ("log.xlsx", excel))),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)  # fmt: skip
def test_two_commands_from_a_folder_to_the_truth(
    name: str, write: Callable[[Log, Path], None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(rate_table(dwell=10.0), tmp_path / name)
    said = ("--unit", "gyro=deg/s", "--unit", "temperature=degC") if name.endswith("xlsx") else ()
    status, out, err = call(capsys, "init", str(tmp_path), "--yes", *said)
    assert (status, "complete. Next" in out) == (0, True), out + err
    status, _, err = call(capsys, "run", str(tmp_path), "-q")
    assert status == 0, err
    rows = json.loads((tmp_path / "out/results.json").read_text())["results"]
    own = {one["quantity"]: one for one in rows if one["axis"] == "x" and one["method"] == "result"}
    for quantity, true in (("bias", BIASES["x"]), ("scale_factor_error", 100.0 * ERRORS["x"])):
        assert abs(own[quantity]["value"] - true) <= 5.0 * own[quantity]["u"], own[quantity]


def test_a_clock_of_any_name_behind_a_number_of_rows(tmp_path: Path) -> None:
    """Dates are time whatever their column is called; a day that stands beside them is not."""
    path = tmp_path / "log.csv"
    forms = {"recorded_at": "%Y-%m-%dT%H:%M:%S.%f", "erfasst": "%d.%m.%Y %H:%M:%S.%f"}
    for name, form in forms.items():
        rows = [f"{i},{(START + datetime.timedelta(seconds=i / 2)).strftime(form)},0.{i % 7},2024-05-0{1 + i % 3}"
                for i in range(40)]  # fmt: skip
        path.write_text("\n".join([f"id,{name},gyro_x [deg/s],calibrated", *rows]))
        recording = ic.read(path)
        assert (recording.time_column, recording.sample_interval) == (name, 0.5)
        assert recording.time_ns is not None
        assert int(recording.time_ns[0]) == round(START.timestamp()) * 10**9
    path.write_text(path.read_text().replace("17.06.2025", "06/05/2025").replace("erfasst", "logged"))
    with pytest.raises(DataError, match="which is the day, which the month"):
        ic.read(path)


def test_both_data_sheets_of_one_imu_are_taken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Gyros in counts refer to their own nominal scale factor, not to one that is found and rounded."""
    board = six_faces()
    table = np.column_stack([board.time, np.rint(2000.0 * board.acc), np.rint(1000.0 * np.degrees(board.gyro))])
    names = ("acc_x", "acc_y", "acc_z", *GYRO)
    path = tmp_path / "faces.csv"
    np.savetxt(path, table, "%.8g", ",", header=",".join(["t [s]", *names]), comments="")
    words = ["positions", str(path), "--unit", "acc=count", "--unit", "gyro=count", "--json"]
    sheets = ("--scale-factor", "acc=2000 count/(m/s2)", "--scale-factor", "gyro=1024 count/(deg/s)")
    status, out, err = call(capsys, *words, *sheets)
    assert status == 0, err
    rows = [one for one in json.loads(out)["results"] if (one["sensor"], one["method"]) == ("gyro", "result")]
    for axis, bias in zip("xyz", GYRO_BIASES, strict=True):
        own = {one["quantity"]: one for one in rows if one["axis"] == axis}
        assert own["scale_factor_error"]["value"] == pytest.approx(1000.0 / 1024.0 - 1.0, abs=5e-4)
        assert own["bias"]["value"] == pytest.approx(bias * 1000.0 / 1024.0, abs=2e-4)


def test_counts_of_gyros_whose_scale_nobody_knows_are_no_rates(
    shared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = shared / "data/imucal_ferraris/annotated_session.csv"
    words = ["positions", str(path), "--sample-rate", "204.8", "--unit", "acc=count", "--unit", "gyro=count", "--json"]
    _, out, _ = call(capsys, *words)
    biases = [one for one in json.loads(out)["results"] if (one["quantity"], one["sensor"]) == ("bias", "gyro")]
    assert {one["reason"]["code"] for one in biases if one["method"] == "result"} == {"no_scale_factor"}
    sheets = ("--scale-factor", "acc=2090 count/g", "--scale-factor", "gyro=16.4 count/(deg/s)")
    _, out, _ = call(capsys, *words, *sheets)
    values = [one["value"] for one in json.loads(out)["results"]
              if (one["quantity"], one["sensor"], one["method"]) == ("bias", "gyro", "result")]  # fmt: skip
    at_rest_counts = np.array([1.96, -4.45, -3.65])  # of its sections without a turn
    np.testing.assert_allclose(values, np.radians(at_rest_counts / 16.4), atol=np.radians(0.2 / 16.4))


def wav(log: Log, path: Path) -> None:
    """Write thousandths of a degree a second as sound of 24 bits."""
    table = np.rint(1e3 * np.column_stack([log.readings[axis] for axis in "xyz"])).astype("<i4")
    data = table.reshape(-1, 1).view(np.uint8).reshape(-1, 4)[:, :3].tobytes()
    form = struct.pack("<HHIIHH", 1, 3, 50, 450, 9, 24)
    body = b"WAVEfmt " + struct.pack("<I", 16) + form + b"data" + struct.pack("<I", len(data)) + data
    path.write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)


def bare_text(log: Log, path: Path) -> None:
    """Write readings without time."""
    table = np.column_stack([log.readings[axis] for axis in "xyz"])
    np.savetxt(path, table, "%.5f", ",", header="gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]", comments="")


def endaq(log: Log, path: Path) -> None:
    """Write the gyros of a recorder whose library knows channels that the file does not have."""
    gyros = [Subchannel(axis.upper(), "Rotation", "dps", 1e-3, np.rint(1e3 * log.readings[axis]).astype(np.int64))
             for axis in "xyz"]  # fmt: skip
    slow = [Subchannel("Temperature", "Temperature", "\u00b0C", 0.01, np.full(300, 2300))]
    write_endaq(path, [Group("Gyroscope", 50.0, gyros), Group("Env", 1.0, slow)], round(START.timestamp()))


@pytest.mark.parametrize(
    ("name", "write", "words"),
    [
        ("log.csv", bare_text, ("--sample-rate", "50")),
        pytest.param(
            "log.wav", wav, ("--column", "x=channel_1", "--column", "y=channel_2", "--column", "z=channel_3", "--unit",
                             "gyro=mdeg/s"), marks=pytest.mark.slow,
        ),
        pytest.param("log.ide", endaq, (), marks=pytest.mark.slow),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)  # fmt: skip
def test_a_rate_that_the_header_or_the_user_says_begins_a_campaign(
    name: str,
    write: Callable[[Log, Path], None],
    words: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write(at_rest(minutes=4.0), tmp_path / name)
    status, out, err = call(capsys, "init", str(tmp_path), "--yes", *words)
    assert (status, "complete. Next" in out) == (0, True), out + err
    status, _, err = call(capsys, "run", str(tmp_path), "-q")
    assert status == 0, err
    rows = json.loads((tmp_path / "out/results.json").read_text())["results"]
    white = [one["value"] for one in rows if one["quantity"] == "angle_random_walk" and one["method"] == "result"]
    assert white == pytest.approx([NOISE / np.sqrt(50.0) * 60.0] * 3, rel=0.1)
