"""Recordings of one content in every format: a unit at rest that warms, on faces, on a table.

What a format has no words for - names, units, a temperature beside the axes - is not in its file.
"""

from __future__ import annotations

import sqlite3
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import newcomer_files as own
import numpy as np
from newcomer_boards import ACC_NOISE, GYRO_NOISE, Array, Board, G, six_faces

XYZ, DEG = "xyz", 180.0 / np.pi
SAMPLE_RATE, ROWS = 10.0, 600


@dataclass(frozen=True)
class Sheet:
    """Columns with their units beside a time [s]; the board of it, for writers of messages with fixed fields."""

    time: Array
    columns: Mapping[str, tuple[Array, str]]
    board: Board

    def named(self, form: str = "{} [{}]") -> dict[str, Array]:
        """Return the columns, the unit in their names, time first."""
        every = {"time": (self.time, "s")} | dict(self.columns)
        return {form.format(name, unit): values for name, (values, unit) in every.items()}


def bench(seed: int = 8) -> Sheet:
    """Return a board at rest that warms from 10 to 40 degC while the supply steps between 4.8 and 5.2 V."""
    rng = np.random.default_rng(seed)
    time = np.arange(ROWS) / SAMPLE_RATE
    temperature = 10.0 + 30.0 * time / time[-1]
    supply = np.tile(np.repeat([5.0, 4.8, 5.2], 50), ROWS // 150)
    drift = np.outer(temperature - 20.0, [0.004, -0.003, 0.002]) + np.outer(supply - 5.0, [0.3, 0.3, 0.3])
    gyro = np.radians(0.3 + drift) + GYRO_NOISE * rng.standard_normal((ROWS, 3))
    acc = np.array([0.0, 0.0, G]) + 0.1 * drift + ACC_NOISE * rng.standard_normal((ROWS, 3))
    board = Board(time, gyro, acc, temperature, SAMPLE_RATE)
    pulses = np.rint(1000.0 + 20.0 * np.sin(2.0 * np.pi * time / 3.0) + rng.standard_normal(ROWS))
    return _sheet(board, {"temperature": (temperature, "degC"), "supply": (supply, "V"), "pulses": (pulses, "count")})


def moved(seed: int = 11) -> Sheet:
    """Return a board beside a mass that comes and goes every 3 s: its x axis follows."""
    rest = bench(seed).board
    acc = rest.acc.copy()
    acc[:, 0] += 0.05 * np.sin(2.0 * np.pi * rest.time / 3.0)
    return _sheet(Board(rest.time, rest.gyro, acc, rest.temperature, rest.sample_rate), {})


def turned(seed: int = 9) -> Sheet:
    """Return a board on a table that turns about z at eleven rates."""
    rng = np.random.default_rng(seed)
    steps = (0.0, 20.0, 40.0, 60.0, 80.0, 0.0, -20.0, -40.0, -60.0, -80.0, 0.0)
    applied = np.repeat(steps, 50)
    n = len(applied)
    gyro = np.radians(np.outer(applied, [0.003, 0.003, 1.012]) + 0.3) + GYRO_NOISE * rng.standard_normal((n, 3))
    acc = np.array([0.0, 0.0, G]) + ACC_NOISE * rng.standard_normal((n, 3))
    board = Board(np.arange(n) / SAMPLE_RATE, gyro, acc, np.full(n, 23.0), SAMPLE_RATE)
    return _sheet(board, {"table_rate": (applied, "deg/s")})


def faces() -> Sheet:
    """Return a board laid on its faces."""
    return _sheet(six_faces(), {})


def shaken(seed: int = 10) -> Sheet:
    """Return a board on a shaker that moves along z at a flat density of 0.01 g2/Hz from 20 to 200 Hz."""
    rng = np.random.default_rng(seed)
    rate, n = 1000.0, 12_000
    lines = np.fft.rfftfreq(n, 1.0 / rate)
    spectrum = np.fft.rfft(rng.standard_normal(n)) * ((lines >= 10.0) & (lines <= 300.0))
    acc = G * np.sqrt(0.01 * rate / 2.0) * np.outer(np.fft.irfft(spectrum, n), [0.02, 0.03, 1.0]) + [0.0, 0.0, G]
    gyro = GYRO_NOISE * rng.standard_normal((n, 3))
    return _sheet(Board(np.arange(n) / rate, gyro, acc, np.full(n, 23.0), rate), {})


def _sheet(board: Board, others: Mapping[str, tuple[Array, str]]) -> Sheet:
    gyro = {f"gyro_{axis}": (DEG * board.gyro[:, i], "deg/s") for i, axis in enumerate(XYZ)}
    acc = {f"acc_{axis}": (board.acc[:, i], "m/s^2") for i, axis in enumerate(XYZ)}
    return Sheet(board.time, gyro | acc | dict(others), board)


def csv(sheet: Sheet, path: Path) -> None:
    """Write text."""
    named = sheet.named()
    np.savetxt(path, np.column_stack(list(named.values())), "%.9g", ",", header=",".join(named), comments="")


def npz(sheet: Sheet, path: Path) -> None:
    """Write arrays of numpy, a name each."""
    np.savez_compressed(path, **sheet.named("{} [{}]"))  # type: ignore[arg-type]


def matlab(sheet: Sheet, path: Path) -> None:
    """Write variables, the unit behind an underscore."""
    from scipy.io import savemat

    words = {"deg/s": "deg_s", "m/s^2": "m_s2"}
    every = {"time": (sheet.time, "s")} | dict(sheet.columns)
    savemat(path, {f"{name}_{words.get(unit, unit)}": values for name, (values, unit) in every.items()})


def hdf5(sheet: Sheet, path: Path) -> None:
    """Write data sets with units as attributes."""
    import h5py

    with h5py.File(path, "w") as file:
        for name, (values, unit) in {"time": (sheet.time, "s"), **sheet.columns}.items():
            file.create_dataset(name, data=values).attrs["units"] = unit


def frame(sheet: Sheet) -> Any:
    """Return a table of pandas."""
    import pandas as pd

    return pd.DataFrame(sheet.named())


def sqlite(sheet: Sheet, path: Path) -> None:
    """Write a table."""
    connection = sqlite3.connect(path)
    frame(sheet).to_sql("log", connection, index=False)
    connection.close()


def json_lines(sheet: Sheet, path: Path) -> None:
    """Write an object a line."""
    frame(sheet).to_json(path, orient="records", lines=True, double_precision=15)


def excel(sheet: Sheet, path: Path) -> None:
    """Write a sheet, row by row."""
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    page = book.create_sheet("log")
    page.append(list(sheet.named()))
    for row in np.column_stack(list(sheet.named().values())).tolist():
        page.append(row)
    book.save(path)


def tdms(sheet: Sheet, path: Path) -> None:
    """Write channels of a waveform."""
    from nptdms import ChannelObject, TdmsWriter

    step = {"wf_increment": 1.0 / sheet.board.sample_rate, "wf_start_offset": 0.0, "wf_samples": len(sheet.time)}
    with TdmsWriter(str(path)) as writer:
        writer.write_segment([ChannelObject("log", name, values, step | {"unit_string": unit})
                              for name, (values, unit) in sheet.columns.items()])  # fmt: skip


def mdf(version: str) -> Callable[[Sheet, Path], None]:
    """Return a writer of a version of MDF."""

    def write(sheet: Sheet, path: Path) -> None:
        from asammdf import MDF, Signal

        with MDF(version=version) as file:
            file.append([Signal(values, sheet.time, name=name, unit=unit)
                         for name, (values, unit) in sheet.columns.items()], common_timebase=True)  # fmt: skip
            file.save(path, overwrite=True)

    return write


def lvm(sheet: Sheet, path: Path) -> None:
    """Write a LabVIEW measurement."""
    n = len(sheet.columns)
    units = "\t".join(unit for _, unit in sheet.columns.values())
    head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", "Decimal_Separator\t.", "X_Columns\tOne",
            "***End_of_Header***\t", "", f"Channels\t{n}", f"Samples\t{len(sheet.time)}", f"Y_Unit_Label\t{units}",
            "***End_of_Header***", "\t".join(["X_Value", *sheet.columns, "Comment"])]  # fmt: skip
    rows = np.column_stack([sheet.time, *(values for values, _ in sheet.columns.values())])
    path.write_text("\n".join([*head, *("\t".join(f"{one:.9g}" for one in row) for row in rows)]) + "\n")


def uff(sheet: Sheet, path: Path) -> None:
    """Write functions of time: rotations and accelerations of a node by direction, the rest by name."""
    import pyuff

    kinds = {"gyro": (11, 3), "acc_": (12, 0)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        file = pyuff.UFF(str(path))
        for name, (values, unit) in sheet.columns.items():
            kind, turn = kinds.get(name[:4], (0, 0))
            direction = "xyz".index(name[-1]) + 1 + turn if kind else 0
            file.write_sets(pyuff.prepare_58(
                binary=1, func_type=1, rsp_node=1, rsp_dir=direction, ref_dir=0, ref_node=0, data=values, x=sheet.time,
                id1=name, rsp_ent_name="NONE" if kind else name, abscissa_spacing=1,
                abscissa_inc=1.0 / sheet.board.sample_rate, abscissa_min=0.0, abscissa_spec_data_type=17,
                ordinate_spec_data_type=kind, ordinate_axis_units_lab=unit, orddenom_spec_data_type=0,
                num_pts=len(sheet.time), z_axis_value=0.0,
            ), "add")  # fmt: skip
        del file


def wav(sheet: Sheet, path: Path) -> None:
    """Write floats without names and units."""
    from scipy.io import wavfile

    table = np.column_stack([values for values, _ in sheet.columns.values()])
    wavfile.write(path, round(sheet.board.sample_rate), table.astype(np.float32))


def miniseed(sheet: Sheet, path: Path) -> None:
    """Write whole numbers of a millionth of the unit, a trace a column."""
    from pymseed import MS3TraceList

    with MS3TraceList() as traces, path.open("wb") as stream:
        for name, (values, _) in sheet.columns.items():
            counts = np.rint(np.asarray(values) * 1e6).astype(np.int32)
            trace = f"FDSN:GR_{name.replace('_', '').upper()}__H_N_Z"
            traces.add_data(sourceid=trace, data_samples=counts, sample_type="i",
                            sample_rate=sheet.board.sample_rate, starttime=own.START * 10**9)  # fmt: skip
        for record in traces.generate(max_record_length=512, format_version=3):
            stream.write(record)


def of_board(write: own.Writer) -> Callable[[Sheet, Path], None]:
    """Return a writer of messages with fixed fields."""
    return lambda sheet, path: write(sheet.board, path)


SHEETS: dict[str, tuple[str, Callable[[Sheet, Path], None]]] = {
    "CSV": (".csv", csv),
    "npz": (".npz", npz),
    "MATLAB": (".mat", matlab),
    "HDF5": (".h5", hdf5),
    "Parquet": (".parquet", lambda sheet, path: frame(sheet).to_parquet(path)),
    "Feather": (".feather", lambda sheet, path: frame(sheet).to_feather(path)),
    "SQLite": (".db", sqlite),
    "JSON lines": (".jsonl", json_lines),
    "Excel": (".xlsx", excel),
    "TDMS": (".tdms", tdms),
    "MDF 4": (".mf4", mdf("4.10")),
    "MDF 3": (".mdf", mdf("3.30")),
    "LVM": (".lvm", lvm),
    "UFF 58": (".uff", uff),
    "WAV": (".wav", wav),
    "miniSEED": (".mseed", miniseed),
    "ROS 1 bag": (".bag", of_board(own.ros_1("/imu", warm=True))),
    "ROS 2 db3": (".db3", of_board(own.ros_2("/imu", "SQLITE3", warm=True))),
    "ROS 2 folder": ("", of_board(own.ros_2("/imu", "SQLITE3", warm=True))),
    "MCAP": (".mcap", of_board(own.ros_2("/imu", "MCAP", warm=True))),
    "ULog `sensor_combined`": (".ulg", of_board(own.ulog_combined)),
    "ULog `sensor_gyro`": (".ulg", of_board(own.ulog_sensors)),
    "DataFlash .bin": (".bin", of_board(own.dataflash_old)),
    "DataFlash .log": (".log", of_board(own.dataflash_text)),
}
