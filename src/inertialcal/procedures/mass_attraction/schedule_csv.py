"""Schedule of a moved mass as CSV: a row a dwell, and comments above for what all dwells have in common.

Numbers are written with all digits of their bits. Comments such as ``# drive: sine`` give the drive, the dwells a
cycle and the uncertainty of what is applied; a file without them is a custom schedule. Columns may have other units,
stated in their header.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import DataError, InertialcalError, StoreError
from ...core.estimate import Array
from ...core.units import convert, parse_quantity, same_dimension
from ...files.source import load
from ...files.text.headers import bare_name
from ...files.text.layout import decode
from ...files.text.table import Table, read_table
from ...files.write.atomic import atomic_write
from ...physics.motion.schedule import MERCURY, UNITS, Schedule

COMMENT = re.compile(r"#\s*(drive|dwells a cycle|dwell|move|u of applied)\s*:\s*(.*?)\s*", re.ASCII)
SAME = 0.05  # of the range applied: a smaller difference is the same place again
FEW = 3  # dwells, too few to show a cycle
EVEN = 1e-6  # of a dwell: tolerance of equal lengths


def write_schedule(
    path: str | os.PathLike[str],
    schedule: Schedule,
    inputs: Iterable[str | Path] = (),
    notes: Mapping[str, str] | None = None,
) -> None:
    """Write a schedule as CSV.

    Parameters
    ----------
    path : path
        Of the file; an existing one is replaced.
    schedule : Schedule
        What to write.
    inputs : iterable of path
        Files that it may not replace.
    notes : mapping of str to str, optional
        Further comments above the rows, such as the constants behind what is applied.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    if Path(path).is_dir():
        raise StoreError("cannot be written: it is a folder", where=str(path), do="Name a file", code="not_written")
    with atomic_write(path, inputs) as aside:
        aside.write_text(schedule.csv(notes or {}), encoding="utf-8", newline="\n")


def read_schedule(path: str | Path) -> Schedule:
    """Return the schedule in a CSV file.

    Raises
    ------
    DataError
        If the file cannot be read, a column or its unit is missing or wrong, dwells differ in length, or the rows are
        not a schedule.
    """
    table = read_table(path)
    text = decode(load(path).data, str(path))[0]
    matches = (COMMENT.fullmatch(line.strip()) for line in text.splitlines() if line.lstrip().startswith("#"))
    comments = {match[1]: match[2] for match in matches if match}
    there = UNITS | (MERCURY if "mercury" in map(bare_name, table.names) else {})
    columns = {name: _column(table, name, unit) for name, unit in there.items()}
    dwell = _dwell(columns["stop"] - columns["start"], comments, table)
    pauses = np.diff(columns["start"]) - dwell
    move = float(max(pauses.min(), 0.0))
    if "move" in comments:
        move = _quantity("move", "s", comments, table)
        short = (pauses < move - EVEN * dwell) & (pauses >= 0.0)  # overlapping dwells are refused as such
        if short.any():
            i = int(np.argmax(short))
            what = f"a pause of {pauses[i]:g} s, but moves take {move:g} s in this file"
            do = "Correct the start, or the comment line"
            raise DataError(what, where=table.where(i + 1), do=do, code="schedule")
    drive: Any = comments.get("drive", "custom")
    cycle = _cycle(columns["applied"], comments, table)
    u = _quantity("u of applied", "1", comments, table) if "u of applied" in comments else None
    try:
        return Schedule(columns["start"], dwell, move, columns["position"], columns["applied"], drive, cycle, u,
                        columns.get("mercury"))  # fmt: skip
    except InertialcalError as error:
        raise DataError(error.problems[0].what, where=table.source.path, why="it is not a schedule") from None


def _column(table: Table, name: str, wanted: str) -> Array:
    """Return a column in SI; every cell is a number."""
    values, unit = table.numbers(name), table.unit(name)
    if unit is None or not same_dimension(unit, wanted):
        what, do = f"column {name!r} has " + (f"the unit {unit}" if unit else "no unit"), f"Write {name} [{wanted}]"
        raise DataError(what, where=table.source.path, do=do, code="wrong_unit")
    empty = np.flatnonzero(np.isnan(values))
    if len(empty):
        raise DataError(f"{name} is empty", where=table.where(int(empty[0])), why="a dwell needs it", code="missing")
    return convert(values, unit, wanted)


def _dwell(lengths: Array, comments: dict[str, str], table: Table) -> float:
    """Return the length of all dwells."""
    if len(lengths) < 2:
        raise DataError(f"{len(lengths)} dwell(s): a schedule has two or more", where=table.source.path)
    dwell = _quantity("dwell", "s", comments, table) if "dwell" in comments else float(np.median(lengths))
    other = np.abs(lengths - dwell) > EVEN * abs(dwell)
    if other.any():
        i = int(np.argmax(other))
        what, why = f"a dwell of {lengths[i]:g} s among dwells of {dwell:g} s", "all dwells must be equally long"
        raise DataError(what, table.where(i), why, "Correct start or stop, or cut the longer ones", "uneven_dwells")
    return dwell


def _quantity(name: str, unit: str, comments: dict[str, str], table: Table) -> float:
    """Return the quantity of a comment line."""
    try:
        return parse_quantity(comments[name]).to(unit)
    except InertialcalError as error:
        problem = error.problems[0]
        raise DataError(f"# {name}: {problem.what}", where=table.source.path, do=problem.do) from None


def _cycle(applied: Array, comments: dict[str, str], table: Table) -> int:
    """Return the dwells a cycle: of the comment, which the rows must agree with, or of the rows.

    Raises
    ------
    DataError
        If what is applied does not repeat after so many dwells, or after any.
    """
    if "dwells a cycle" not in comments:
        shown = (k for k in range(2, len(applied) // 2 + 1) if _repeats(applied, k))
        found = next(shown, 2 if len(applied) <= FEW else None)
        if found is None:
            what, do = "what is applied does not repeat after any number of dwells", "Add a line # dwells a cycle: N"
            raise DataError(what, table.source.path, "the frequency of the drive is unknown", do, "schedule")
        return found
    text = comments["dwells a cycle"]
    if not re.fullmatch(r"[0-9]{1,9}", text, re.ASCII):
        raise DataError(f"# dwells a cycle: {text!r} is not a whole number", where=table.source.path, code="schedule")
    number = int(text)
    if comments.get("drive", "custom") != "custom" and not _repeats(applied, number):
        what = f"# dwells a cycle: {number}, but what is applied does not repeat after {number} dwells"
        do = "Correct the line, or the rows; a drive that never repeats is custom"
        raise DataError(what, table.source.path, "the frequency of the drive would be wrong", do, "schedule")
    return number


def _repeats(applied: Array, dwells: int) -> bool:
    """Return whether the same is applied so many dwells later, throughout."""
    change = np.abs(applied[dwells:] - applied[:-dwells]) if dwells else np.empty(0)
    return bool(change.size == 0 or change.max() <= SAME * np.ptp(applied))
