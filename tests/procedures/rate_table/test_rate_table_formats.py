"""One recording of a stepped table gives the same figures in whatever format it comes, with stamps or a rate alone."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.estimate import Array

RATE = 50.0  # samples a second
STEPS = np.repeat([0.0, 20.0, -20.0, 40.0, -40.0, 60.0, -60.0, 0.0], 100)  # [deg/s]
CLOCK = "time [s]"
EXACT = 1e-9  # relative: stamps are rounded to nanoseconds


def table() -> dict[str, Array]:
    """Return the clock, the rate of the table and three axes, of which z was turned; six digits of each."""
    rng = np.random.default_rng(5)
    sensed = np.outer(STEPS, [0.002, -0.003, 1.01]) + [0.1, 0.2, 0.3] + 0.05 * rng.normal(size=(len(STEPS), 3))
    columns = {CLOCK: np.arange(len(STEPS)) / RATE, "applied [deg/s]": STEPS}
    columns |= {f"gyro_{axis} [deg/s]": sensed[:, i] for i, axis in enumerate("xyz")}
    return {name: values.round(6) for name, values in columns.items()}


def channels() -> dict[str, Array]:
    """Return the columns that are no time, by names without units."""
    return {name.removesuffix(" [deg/s]"): values for name, values in table().items() if name != CLOCK}


def text(path: Path) -> None:
    columns = table()
    np.savetxt(path, np.column_stack([*columns.values()]), "%.6f", ",", header=",".join(columns), comments="")


def parquet(path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    parquet.write_table(pa.table(table()), path)


def feather(path: Path) -> None:
    import pyarrow as pa
    from pyarrow import feather

    feather.write_feather(pa.table(table()), str(path))


def numpy(path: Path) -> None:
    np.savez(path, allow_pickle=False, **table())


def matlab(path: Path) -> None:
    from scipy.io import savemat

    savemat(path, {"time_s": table()[CLOCK]} | {f"{name}_dps": values for name, values in channels().items()})


def hdf5(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file["time"] = table()[CLOCK]
        file["time"].attrs["units"] = "s"
        for name, values in channels().items():
            file[name] = values
            file[name].attrs["units"] = "deg/s"


def workbook(path: Path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    sheet = book.active
    columns = table()
    sheet.append([*columns])
    for row in np.column_stack([*columns.values()]).tolist():
        sheet.append(row)
    book.save(path)


def waveform(path: Path) -> None:
    """Write a TDMS file that says its interval, and not when it began: it has a rate, and no stamps."""
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

    about = {"wf_increment": 1.0 / RATE, "wf_start_offset": 0.0, "unit_string": "deg/s"}
    with TdmsWriter(str(path)) as writer:
        made = [ChannelObject("IMU", name, values, about) for name, values in channels().items()]
        writer.write_segment([RootObject({}), GroupObject("IMU"), *made])


def measurement(path: Path) -> None:
    from asammdf import MDF, Signal

    clock = table()[CLOCK]
    with MDF(version="4.10") as file:
        signals = [Signal(values, clock, name=name, unit="deg/s") for name, values in channels().items()]
        file.append(signals, common_timebase=True)
        file.save(path, overwrite=True)


def database(path: Path) -> None:
    columns = table()
    with sqlite3.connect(path) as made:
        made.execute("create table run (" + ", ".join(f'"{name}" real' for name in columns) + ")")
        rows = np.column_stack([*columns.values()]).tolist()
        made.executemany(f"insert into run values ({', '.join('?' * len(columns))})", rows)
    made.close()


def labview(path: Path) -> None:
    head = ["LabVIEW Measurement", "Writer_Version\t2", "Separator\tTab", "Multi_Headings\tNo", "X_Columns\tOne",
            "***End_of_Header***", "", "Channels\t4", "Y_Unit_Label" + 4 * "\tdeg/s", "X0" + 4 * "\t0",
            "Delta_X" + 4 * f"\t{1.0 / RATE}", "***End_of_Header***", "X_Value\t" + "\t".join(channels())]  # fmt: skip
    rows = ["\t".join(f"{value:.6f}" for value in row) for row in np.column_stack([*table().values()])]
    path.write_text("\r\n".join([*head, *rows, ""]))


WRITERS: dict[str, Callable[[Path], None]] = {
    "a.parquet": parquet, "a.feather": feather, "a.npz": numpy, "a.mat": matlab, "a.h5": hdf5, "a.xlsx": workbook,
    "a.tdms": waveform, "a.mf4": measurement, "a.db": database, "a.lvm": labview,
}  # fmt: skip
QUICK = ("a.npz", "a.tdms")


Figures = dict[tuple[str, ...], tuple[float | None, float | None]]


def figures(path: Path) -> Figures:
    """Return each figure of a file, with its uncertainty."""
    return {
        (str(row.case), row.quantity, row.axis, str(row.method), str(row.condition)): (row.value, row.u)
        for row in ic.rate_table(path, axis="z").rows
    }


@pytest.fixture(scope="module")
def wanted(tmp_path_factory: pytest.TempPathFactory) -> Figures:
    path = tmp_path_factory.mktemp("text") / "a.csv"
    text(path)
    return figures(path)


@pytest.mark.parametrize(
    "name", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in WRITERS]
)
def test_the_figures_are_those_of_the_text(tmp_path: Path, wanted: Figures, name: str) -> None:
    WRITERS[name](tmp_path / name)
    found = figures(tmp_path / name)
    assert found.keys() == wanted.keys()
    assert any(key[1] == "scatter_sample" for key in wanted)  # it was taken for a recording, not for dwells
    for key, (value, u) in wanted.items():
        scale = abs(value or 0.0) + (u or 0.0)
        for got, want in zip(found[key], (value, u), strict=True):
            assert (got is None) == (want is None), key
            assert got is None or want is None or abs(got - want) <= EXACT * scale, key
