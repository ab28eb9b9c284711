"""What a user hands in: tables of columns as files, a command line, a campaign; and the truth behind it.

A :class:`Case` is made by a simulator, may be spoiled by :mod:`faults`, and is written last. Columns carry roles (time,
signals, applied, temperature, run), so that a fault finds what it acts on in any kind of file.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Column = NDArray[Any]

START = 1.7e9  # UNIX seconds of the first sample


@dataclass
class Table:
    """One file: columns by header, their formats and roles. ``kind`` is ``record``, ``reduced`` or ``pad``."""

    columns: dict[str, Column]
    signals: tuple[str, ...]
    time: str = ""
    applied: str = ""
    temperature: str = ""
    run: str = ""
    form: dict[str, str] = field(default_factory=dict)
    kind: str = "record"
    separator: str = ","
    rows: Callable[[list[list[str]]], list[list[str]]] | None = None  # applied to the written cells, a list a row
    pad: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def copy(self) -> Table:
        """Return a table whose arrays may be changed."""
        return replace(self, columns={name: values.copy() for name, values in self.columns.items()})

    def taken(self, rows: Any) -> None:
        """Keep these rows, in this order."""
        self.columns = {name: values[rows] for name, values in self.columns.items()}

    def renamed(self, old: str, new: str) -> None:
        """Give a column another header, in its place."""
        self.columns = {new if name == old else name: values for name, values in self.columns.items()}
        self.signals = tuple(new if name == old else name for name in self.signals)
        self.form = {new if name == old else name: form for name, form in self.form.items()}
        for role in ("time", "applied", "temperature", "run"):
            if getattr(self, role) == old:
                setattr(self, role, new)


@dataclass
class Case:
    """Files, command and truth. ``truth`` is by ``quantity axis``, in the unit that the command prints."""

    procedure: str
    tables: dict[str, Table]
    words: list[str]
    truth: dict[str, float]
    texts: dict[str, str] = field(default_factory=dict)
    fit: tuple[str, ...] = ()  # tables that are fitted, in order; all where empty
    held_out: tuple[str, ...] = ()
    noise: float = 0.0  # standard deviation of a signal's sample [unit of the file]
    rate: float = 0.0  # samples a second
    rng_seed: int = 0
    spoiled: tuple[str, ...] = ()  # tables that a fault was put into
    rail: float = 0.0  # what the code -32768 stands for [unit of the file]; 0: of a size in sigma
    ideal: dict[str, float] = field(default_factory=dict)  # u of the best estimate, by the noise that was drawn

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the tables that are fitted."""
        return self.fit or tuple(name for name in self.tables if name not in self.held_out)

    def copy(self) -> Case:
        """Return a case whose tables may be changed."""
        return replace(
            self,
            tables={name: table.copy() for name, table in self.tables.items()},
            words=list(self.words),
            texts=dict(self.texts),
        )

    def write(self, folder: Path) -> list[str]:
        """Write the files, and return the command; a word that begins with ``@`` is a path in the folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, table in self.tables.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if table.kind == "pad":
                write_pad(path.parent, table)
            else:
                path.write_text(csv_text(table), encoding="utf-8")
        for name, text in self.texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        return [word.replace("@", f"{folder}/") if "@" in word else word for word in self.words]


def csv_text(table: Table) -> str:
    """Return the table as CSV, with a header; a missing number is an empty cell."""
    cells = [_cells(values, table.form.get(name, "%.9g")) for name, values in table.columns.items()]
    rows = [list(table.columns), *(list(row) for row in zip(*cells, strict=True))]
    if table.rows is not None:
        rows = table.rows(rows)
    return "\n".join(table.separator.join(row) for row in rows) + "\n"


def _cells(values: Column, form: str) -> list[str]:
    if values.dtype.kind in "OU":
        return [str(value) for value in values]
    if values.dtype.kind in "iu":
        return [str(value) for value in values.tolist()]
    return ["" if np.isnan(value) else form % value for value in values.tolist()]


def stamp(seconds: float) -> str:
    """Return UNIX seconds as names of archive files have them, ``2023_11_14_22_13_20.000``."""
    whole = int(np.floor(seconds + 0.0005))
    millis = int(np.floor((seconds - whole) * 1000 + 0.5))
    return (
        str(np.datetime64(whole, "s")).replace("T", "_").replace(":", "_").replace("-", "_") + f".{max(millis, 0):03d}"
    )


HEADER = """<?xml version="1.0" encoding="US-ASCII"?><sams2_accel>
  <SensorID>{sensor}</SensorID><TimeZero>{start}</TimeZero>
  <Gain>10.0</Gain><SampleRate>{rate:.4f}</SampleRate><CutoffFreq>{cutoff:.2f}</CutoffFreq>
  <GData file="{name}" format="binary 32 bit IEEE float little endian"/>
  <BiasCoeff x="1.23" y="4.46" z="7.89"/>
  <SensorCoordinateSystem name="{sensor}" r="0.0" p="0.0" w="0.0"/>
  <DataCoordinateSystem name="{sensor}" r="0.0" p="0.0" w="0.0"/>
  <DataQualityMeasure>temperature+gain+axial-mis-alignment</DataQualityMeasure>
</sams2_accel>"""


def write_pad(folder: Path, table: Table) -> Path:
    """Write a pair of the acceleration archive, 32-bit floats (time, x, y, z in g) and header; return the data file."""
    rate, start, sensor = table.pad["rate"], table.pad.get("start", START), table.pad.get("sensor", "121f03")
    values = np.column_stack([table.columns[name] for name in table.signals])
    record = np.empty((len(values), 4), dtype="<f4")
    record[:, 0] = np.arange(len(values)) / rate
    record[:, 1:] = values
    first = stamp(start)
    name = f"{first}-{stamp(start + (len(values) - 1) / rate)}.{sensor}"
    record.tofile(folder / name)
    cutoff = table.pad.get("cutoff", rate / 4.0)
    text = HEADER.format(sensor=sensor, start=first, rate=rate, cutoff=cutoff, name=name)
    (folder / (name + ".header")).write_text(text, encoding="ascii")
    return folder / name


def toml(groups: dict[str, Any]) -> str:
    """Return a campaign as text: scalars, lists, inline tables; dotted headers for tables of tables."""
    lines: list[str] = []
    for name, value in groups.items():
        if isinstance(value, dict):
            lines += [f"[{name}]", *(f"{key} = {_inline(item)}" for key, item in value.items())]
        elif isinstance(value, list):
            for item in value:
                lines += [f"[[{name}]]", *(f"{key} = {_inline(one)}" for key, one in item.items())]
        else:
            lines.append(f"{name} = {_inline(value)}")
    return "\n".join(lines) + "\n"


def _inline(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_inline(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_inline(item) for item in value) + "]"
    return json.dumps(value)


def skew(v: Sequence[float] | Array) -> Array:
    """Return the matrix of the cross product with ``v``."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turned(v: Sequence[float] | Array) -> Array:
    """Return the rotation by the vector ``v`` [rad] (Rodrigues)."""
    v = np.asarray(v, dtype=float)
    angle = float(np.linalg.norm(v))
    if angle < 1e-12:
        return np.eye(3) + skew(v)
    k = skew(v / angle)
    rotation: Array = np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k
    return rotation
