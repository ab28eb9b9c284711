"""Programme of a turned mass as a CSV file: a row a run, as ``physics.motion.turns`` has it.

Columns may have other units, stated in their header.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ...core.errors import DataError
from ...core.units import convert, same_dimension
from ...files.text.table import Table, read_table
from ...files.write.atomic import atomic_write
from ...physics.motion.turns import WRITTEN, Turn, programme_text

UNITS = {"start": "s", "stop": "s", "rate": "rad/s", "angle": "rad"}
FASTEST = 1.0  # [rad/s]: a mass of kilograms on an arm of decimetres turns no faster beside an instrument of ng


def write_programme(path: str | os.PathLike[str], turns: Iterable[Turn], notes: Iterable[str] = ()) -> None:
    """Write a programme as CSV; an existing file is replaced.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    with atomic_write(path, []) as aside:
        aside.write_text(programme_text(turns, notes), encoding="utf-8", newline="\n")


def read_programme(path: str | Path) -> tuple[Turn, ...]:
    """Return the runs of a programme.

    Raises
    ------
    DataError
        If the file cannot be read, a column or its unit is missing or wrong, a name appears twice, runs overlap, or a
        run does not turn, or faster than any mass does (``wrong_rate``).
    """
    table = read_table(path)
    names = table.text("run")
    figures = {name: _column(table, name, unit) for name, unit in UNITS.items()}
    turns: list[Turn] = []
    for k, name in enumerate(names):
        row = {what: float(values[k]) for what, values in figures.items()}
        one = Turn(name, **row, where=table.where(k))
        if not name or name in names[:k]:
            what = f"run {name!r} appears twice" if name else "the run has no name"
            raise DataError(what, one.where, do="Give each run its own name", code="schedule")
        if not one.stop > one.start or (turns and one.start < turns[-1].stop):
            what = f"run {name}: {one.start:g} s to {one.stop:g} s" + (
                f", but {turns[-1].run} ends at {turns[-1].stop:g} s" if turns and one.stop > one.start else ""
            )
            raise DataError(what, one.where, "one mass makes one run after the other", "Correct start or stop",
                            "schedule")  # fmt: skip
        if not 0.0 < abs(one.rate) <= FASTEST:
            what = f"run {name}: a rate of {math.degrees(one.rate):.4g} deg/s"
            why = "the mass does not turn" if one.rate == 0.0 else "no such mass turns so fast"
            raise DataError(what, one.where, why, "Check the unit of the column rate: rate [deg/s]", "wrong_rate")
        turns.append(one)
    return tuple(turns)


def _column(table: Table, name: str, wanted: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    values, unit = table.numbers(name), table.unit(name)
    if unit is None or not same_dimension(unit, wanted):
        what = f"column {name!r} has " + (f"the unit {unit}" if unit else "no unit")
        raise DataError(what, table.source.path, do=f"Write {name} [{WRITTEN[name]}]", code="wrong_unit")
    empty = np.flatnonzero(np.isnan(values))
    if len(empty):
        raise DataError(f"{name} is empty", table.where(int(empty[0])), "a run needs it", code="missing")
    return np.asarray(convert(values, unit, wanted))
