"""A table of reduced readings of positions: a row a position, with scatters, numbers of samples and directions."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from ....core.axes import AXES
from ....core.errors import DataError
from ....core.estimate import Array
from ....core.recording import Recording
from ....core.remarks import Remark
from ....files.text.table import Table
from ..orientations.text import LABELS, direction_of, unit_vectors
from ..readings import Readings, Triad
from .channels import Taken

LONGEST = 1_000  # rows; a longer file without time is no table of positions
SCATTER = re.compile(r"(^|_)(std|stdev|sd|sigma|scatter|u)(_|$)", re.IGNORECASE)
SAMPLES = re.compile(r"^(n|samples|n_samples|count)$", re.IGNORECASE)


def is_table(recording: Recording) -> bool:
    """Whether a file is a table of positions: short, without time or sample rate."""
    return recording.time_ns is None and recording.sample_interval is None and len(recording) <= LONGEST


def readings_columns(recording: Recording) -> Recording:
    """Return the columns of readings, without those of scatters and numbers of samples."""
    kept = tuple(c for c in recording.channels if not SCATTER.search(c.name) and not SAMPLES.match(c.name))
    return replace(recording, channels=kept)


def table_readings(table: Table, taken: Taken) -> Readings:
    """Return the rows of a table as positions.

    Parameters
    ----------
    table : Table
        The file.
    taken : Taken
        Its columns of readings.

    Raises
    ------
    DataError
        ``nan_in_required`` if a reading is missing; ``wrong_value`` for a scatter or number that cannot be.
    """
    triads = {sensor: _triad(table, taken, sensor) for sensor in taken.sensors}
    what = f"no time: each of the {len(table)} rows is taken for the mean readings of a position"
    remarks = [Remark("table_of_positions", "info", what, table.source.path, do="Else give the sample rate")]
    if not np.any(triads["acc"].scatter):
        what = "no column of scatters: the noise inside positions is not known, and counts as none"
        remarks.append(Remark("no_scatter", "info", what, table.source.path, do="Name one acc_x_std, and samples"))
    return Readings(
        acc=triads["acc"],
        gyro=triads.get("gyro"),
        direction=_directions(table),
        where=tuple(table.where(k) for k in range(len(table))),
        remarks=(*table.remarks, *taken.remarks, *remarks),
    )


def _triad(table: Table, taken: Taken, sensor: str) -> Triad:
    mean = taken.recording.array([f"{sensor}_{axis}" for axis in AXES])
    missing = ~np.isfinite(mean).all(axis=1)
    if missing.any():
        what = f"{sensor}: a reading of this position is missing"
        raise DataError(what, table.where(int(np.argmax(missing))), do="Leave the row out", code="nan_in_required")
    unit = taken.recording.channel(f"{sensor}_x").unit or ""
    scale = _scale(table, taken, sensor)
    scatter = np.column_stack([_scatter(table, sensor, axis) for axis in AXES]) * scale
    return Triad(mean, scatter, np.repeat(_samples(table)[:, None], len(AXES), axis=1), unit)


def _scale(table: Table, taken: Taken, sensor: str) -> float:
    """Return what turns a difference in the unit of the table into that of the readings."""
    name = taken.columns[f"{sensor}_x"]
    own = table.numbers(name)
    made = taken.recording.array([f"{sensor}_x"])[:, 0]
    at = int(np.argmax(np.abs(own)))
    return float(made[at] / own[at]) if own[at] else 1.0


def _scatter(table: Table, sensor: str, axis: str) -> Array:
    names = [name for name in table.names if SCATTER.search(name) and sensor in name.lower()]
    own = [name for name in names if re.search(rf"(^|_){axis}(_|$)", name.lower())]
    if len(own) != 1:
        return np.zeros(len(table))
    found = table.numbers(own[0])
    wrong = ~(found >= 0.0)
    if wrong.any():
        what = f"column {own[0]!r}: {found[wrong][0]:g} is no scatter"
        raise DataError(what, table.where(int(np.argmax(wrong))), do="Give standard deviations", code="wrong_value")
    return found


def _samples(table: Table) -> Array:
    names = [name for name in table.names if SAMPLES.match(name)]
    if len(names) != 1:
        return np.ones(len(table))
    found = table.numbers(names[0])
    wrong = ~(found >= 1.0)
    if wrong.any():
        what = f"column {names[0]!r}: {found[wrong][0]:g} is no number of samples"
        raise DataError(what, table.where(int(np.argmax(wrong))), code="wrong_value")
    return found


def _directions(table: Table) -> Array | None:
    """Return the directions that the table says, shape (m, 3); None where it says none."""
    names = [name.lower() for name in table.names]
    if all(axis in names for axis in AXES):
        return unit_vectors(table)
    for name in table.names:
        if name.lower() in LABELS:
            found = [direction_of(cell) for cell in table.text(name)]
            if all(one is not None for one in found):
                return np.array(found)
    return None
