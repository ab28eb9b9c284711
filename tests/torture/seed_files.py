"""Seeds of the mutations: files that inertialcal makes itself, and a table in every format that it reads."""

from __future__ import annotations

import gzip
import io
import shutil
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias
from unittest.mock import patch

import h5py
import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import parquet
from scipy import io as scipy_io

import inertialcal
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.twin import simulate
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import InertialcalError
from inertialcal.rigs import RIGS
from inertialcal.rigs.hand_held import rig as hand_held
from inertialcal.rigs.mesa import rig as mesa
from inertialcal.rigs.npsat1 import rig as npsat1
from inertialcal.rigs.protocol import on_bench
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.sams_tsh import rig as sams_tsh
from inertialcal.rigs.still_gyro import rig as still_gyro
from npsat1_small import SHORT as SHORT_SUITE
from pad_pairs_made import BENCH as SHORT_RECORD
from pad_pairs_made import flip_records
from ran_campaigns import SHORT as SHORT_TURNS
from safety_net import COUNT, EXAMPLES, copied, faces

Table: TypeAlias = dict[str, NDArray[Any]]
CARDS = "deck.cards"
HELD = hand_held.Bench(sample_rate=25.0, positions=14, rounds=1)
BENCHES: Mapping[str, tuple[Callable[..., Any], Any]] = {  # shorter than those of the rigs
    "rate_table": (rate_table.build, SHORT_TURNS),
    "still_gyro": (still_gyro.build, still_gyro.Bench(samples=1500)),
    "mesa": (mesa.build, mesa.Bench()),
    "hand_held": (hand_held.build, HELD),
    "six_faces": (hand_held.build, replace(HELD, variant="ferraris")),
    "sams_tsh": (sams_tsh.build, SHORT_RECORD),
    "sams_tsh_model": (sams_tsh.build, replace(SHORT_RECORD, ground="jointly")),
    "npsat1": (npsat1.build, SHORT_SUITE),
}
EXPORTED = {"imucal": ".json", "kalibr-model": ".yaml", "imu-tk": ".txt", "realsense": ".json"}  # formats of others


def write_seeds(folder: Path) -> None:
    """Write recordings, decks, campaigns that were run, models and settings into a folder."""
    for name, bench in BENCHES.items():
        made = replace(RIGS.named(name), make=on_bench(*bench))
        with patch.object(type(RIGS), "named", return_value=made):
            simulate(name, folder / f"rig_{name}", seed=1)
    for name in EXAMPLES:
        source = Path(inertialcal.__file__).parent / "examples" / name
        ignore = shutil.ignore_patterns("out", "__pycache__", "__init__.py")
        shutil.copytree(source, folder / f"example_{name}", ignore=ignore)
    for campaign in sorted(folder.iterdir()):
        try:
            run(campaign)
        except InertialcalError as error:
            raise AssertionError(f"{campaign}: {error}") from error
    _recordings(folder)
    _models(folder)


def _recordings(folder: Path) -> None:
    """Write recordings in physical units, from the codes of the rigs."""
    for number, recording in (("1", "ambient_1"), ("2", "ambient_2")):
        columns = {f"gyro_{axis}": (axis, COUNT, -5.0) for axis in "xyz"}
        temperatures = {f"t_{axis}": (f"{axis}_temp", 5.0 / 4095.0 / 0.0264, 6.0) for axis in "xyz"}
        units = dict.fromkeys(columns, "deg/s") | dict.fromkeys(temperatures, "degC")
        source = folder / f"rig_npsat1/recordings/{recording}.csv"
        copied(source, folder / f"thermal{number}.csv", columns | temperatures, units)
    turned = {f"gyro_{axis}": (axis, -COUNT, 5.0) for axis in "xz"}
    columns = {"rate": ("rate_dps", 1.0, 0.0), "gyro_y": ("y", COUNT, -5.0)} | turned
    source = folder / "rig_rate_table/recordings/y_run1.csv"
    copied(source, folder / "rates.csv", columns, dict.fromkeys(columns, "deg/s"))
    for name, source in {
        "still.csv": folder / "rig_still_gyro/recordings/still1.csv",
        "held.csv": folder / "rig_hand_held/recordings/hand1.csv",
        "flip.csv": folder / "rig_sams_tsh/recordings/flip.csv",
        "mass1.csv": folder / "rig_mesa/recordings/run1.csv",
        "mass2.csv": folder / "rig_mesa/recordings/run2.csv",
        "null1.csv": folder / "rig_mesa/recordings/null1.csv",
        "schedule.csv": folder / "rig_mesa/schedule.csv",
    }.items():
        shutil.copy(source, folder / name)
    faces(folder / "rig_six_faces", folder / "faces.csv")
    pad = flip_records(folder / "pad", files=2)
    first = min(one for one in pad.iterdir() if one.suffix != ".header")
    for one in (first, first.with_name(first.name + ".header")):
        shutil.copy(one, folder / one.name.replace(first.name, "record.121f03"))
    pulses = read_csv((folder / "mass1.csv").read_text(encoding="utf-8"))
    (folder / CARDS).write_text(_deck(pulses["pulses"], 1e9 * pulses["tilt_rad"].astype(float)), encoding="utf-8")


def _deck(counts: NDArray[Any], tilt: NDArray[Any]) -> str:
    """Return card images of a series, its correlations and spectrum wanted."""
    series = [[int(float(value or 0)) for value in one] for one in (counts, tilt)]
    head = "".join(f"{value:4d}" for value in (len(counts) // 2 * 2, 100, len(counts), 23, 0, 60, 50, 4, 7, 12))
    cards = [
        "".join(" " * skip + f"{value:>{width}}" + " " * rest for value in one[at : at + 5])
        for one, (skip, width, rest) in zip(series, ((3, 6, 1), (2, 8, 1)), strict=True)
        for at in range(0, len(one), 5)
    ]
    return "\n".join(["   0", head, *cards, "   1\n   2\n   3\n   4\n  10\n   6\n  -1\n"])


def _models(folder: Path) -> None:
    """Write models of a rig in every format that is read, noise of another and settings of plans, by commands."""
    held = folder / "rig_hand_held/out"
    for name, (model, more) in {
        "model.json": ("rig_rate_table/out/model.json", ""),
        "acc.json": ("rig_hand_held/out/model.json", ""),
        "gyro.json": ("rig_hand_held/out/model_gyro.json", ""),
    }.items():
        shutil.copy(folder / model, folder / (more + name))
    for name, ending in EXPORTED.items():
        words = ["export", str(held / "model.json"), "--to", name, "-o", str(folder / f"{name}{ending}"), "--unjudged"]
        command(*words, *([] if name == "imu-tk" else ["--with", str(held / "model_gyro.json")]))
    command("plan", "mass-attraction", "--write-example", str(folder / "moved.toml"))
    noise = command("allan", str(folder / "still.csv"), "--unit", "x=ug", "--column", "x", "--json")
    (folder / "noise.json").write_text(noise, encoding="utf-8")


def command(*words: str) -> str:
    """Return what a command prints; it must succeed."""
    printed = io.StringIO()
    try:
        with redirect_stdout(printed):
            main(words)
    except SystemExit as left:
        assert not left.code, words  # noqa: PT017
    return printed.getvalue()


# Tables in every format


def read_csv(text: str) -> Table:
    """Return the cells of a table by column, as text."""
    rows = [line.split(",") for line in text.splitlines()]
    columns = zip(*rows[1:], strict=True) if len(rows) > 1 else [()] * len(rows[0])
    return {name: np.array(cells, dtype=object) for name, cells in zip(rows[0], columns, strict=True)}


def csv_text(table: Table, separator: str = ",") -> str:
    """Return a table as text; columns may differ in length."""
    length = max((len(column) for column in table.values()), default=0)
    cells = [[*map(str, column), *[""] * (length - len(column))] for column in table.values()]
    return "\n".join([separator.join(table), *(separator.join(row) for row in zip(*cells, strict=True)), ""])


def numbers(table: Table) -> Table:
    """Return the columns of text as numbers; those that are none stay."""
    return {name: _as_numbers(column) for name, column in table.items()}


def _as_numbers(column: NDArray[Any]) -> NDArray[Any]:
    if column.dtype != object:
        return column
    try:
        return np.array([float(str(cell).replace(",", ".") or "nan") for cell in column])
    except ValueError:
        return column


def _matlab(path: Path, table: Table, kind: str) -> None:
    plain = {_variable(name): c.astype(str) if c.dtype.kind == "O" else c for name, c in table.items()}
    scipy_io.savemat(path, plain, format=kind)


def _variable(name: str) -> str:
    kept = "".join(c if c.isalnum() and c.isascii() else "_" for c in name.split(" [", maxsplit=1)[0])
    return f"v{kept}"[:31] if not kept or not kept[0].isalpha() else kept[:31]


def _hdf5(path: Path, table: Table, matlab: bool) -> None:
    with h5py.File(path, "w", userblock_size=512 if matlab else 0) as file:
        for name, column in table.items():
            texts = column.dtype.kind in "OU"
            data = column.astype(str).astype(object) if texts else column
            dataset = file.create_dataset(_variable(name), data=data, dtype=h5py.string_dtype() if texts else None)
            if matlab:
                dataset.attrs["MATLAB_class"] = np.bytes_("double")
    if matlab:
        content = bytearray(path.read_bytes())
        content[:128] = b"MATLAB 7.3 MAT-file, written for a test".ljust(124) + b"\x00\x02IM"
        path.write_bytes(content)


def _npy(path: Path, table: Table) -> None:
    columns = [column.astype(float) for column in table.values() if column.dtype.kind not in "OU"]
    np.save(path, np.column_stack(columns) if columns and len({*map(len, columns)}) == 1 else np.array(columns[:1]))


def _npz(path: Path, table: Table) -> None:
    plain = {name.replace("/", "_"): c.astype(str) if c.dtype.kind == "O" else c for name, c in table.items()}
    with path.open("wb") as file:
        np.savez(file, **plain)  # type: ignore[arg-type]


def _parquet(path: Path, table: Table) -> None:
    columns = [pa.array(column.astype(str) if column.dtype.kind == "O" else column) for column in table.values()]
    parquet.write_table(pa.Table.from_arrays(columns, names=[*table]), path)


def _text(path: Path, table: Table, separator: str = ",") -> None:
    path.write_bytes(csv_text(table, separator).encode("utf-8", "surrogatepass"))


def _packed(path: Path, table: Table) -> None:
    path.write_bytes(gzip.compress(csv_text(table).encode("utf-8", "surrogatepass"), mtime=0))


TEXT: Mapping[str, Callable[[Path, Table], None]] = {
    ".csv": _text,
    ".csv.gz": _packed,
    ".tsv": lambda path, table: _text(path, table, "\t"),
}
BINARY: Mapping[str, Callable[[Path, Table], None]] = {
    ".parquet": _parquet,
    ".npz": _npz,
    ".npy": _npy,
    "_4.mat": lambda path, table: _matlab(path, table, "4"),
    "_5.mat": lambda path, table: _matlab(path, table, "5"),
    "_73.mat": lambda path, table: _hdf5(path, table, matlab=True),
    ".h5": lambda path, table: _hdf5(path, table, matlab=False),
}
