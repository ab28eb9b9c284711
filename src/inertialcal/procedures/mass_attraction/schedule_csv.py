"""Schedule of a moved mass as CSV: a row a dwell, and what holds for all dwells in comments above.

Every number is written with the digits that give back its bits. What rows cannot tell (which drive, how many dwells a
cycle, the doubt of what is applied) stands in lines such as ``# drive: sine``; a file without them is a custom
schedule. Columns may stand in other units, where their header says which.
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
from ...files.text.encoding import decode
from ...files.text.headers import bare_name
from ...files.text.table import Table, read_table
from ...files.write.atomic import atomic_write
from ...physics.motion.schedule import MERCURY, UNITS, Schedule

COMMENT = re.compile(r"#\s*(drive|dwells a cycle|dwell|move|u of applied)\s*:\s*(.*?)\s*", re.ASCII)
SAME = 0.05  # of what the mass changes, within which a place is the same one again
FEW = 3  # dwells, that show no cycle
EVEN = 1e-6  # of a dwell, within which all dwells are equally long, and as long as the file says


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
        Of the file; one that is there is replaced.
    schedule : Schedule
        What to write.
    inputs : iterable of path
        Files that it may not replace.
    notes : mapping of str to str, optional
        What else stands above the rows for whoever reads them, such as the constants behind what is applied.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    if Path(path).is_dir():
        raise StoreError("cannot be written: it is a folder", where=str(path), do="Name a file", code="not_written")
    with atomic_write(path, inputs) as aside:
        aside.write_text(schedule.csv(notes or {}), encoding="utf-8")


def read_schedule(path: str | Path) -> Schedule:
    """Return the schedule that a CSV holds.

    Raises
    ------
    DataError
        If the file cannot be read, a column or its unit is missing or wrong, dwells differ in length, or the rows are
        no schedule.
    """
    table = read_table(path)
    said = _comments(decode(load(path).data, str(path))[0])
    there = UNITS | (MERCURY if "mercury" in map(bare_name, table.names) else {})
    columns = {name: _column(table, name, unit) for name, unit in there.items()}
    dwell = _dwell(columns["stop"] - columns["start"], said, table)
    pauses = np.diff(columns["start"]) - dwell
    move = _seconds("move", said, table) if "move" in said else float(max(pauses.min(), 0.0))
    _check_move(move, pauses, dwell, table)
    drive: Any = said.get("drive", "custom")
    cycle = _cycle(columns["applied"], said, table)
    try:
        return Schedule(
            columns["start"], dwell, move, columns["position"], columns["applied"], drive,
            cycle, _relative(said, table), columns.get("mercury"),
        )  # fmt: skip
    except InertialcalError as error:
        raise DataError(error.problems[0].what, where=table.source.path, why="it is no schedule") from None


def _comments(text: str) -> dict[str, str]:
    """Return what the comment lines say."""
    found = (COMMENT.fullmatch(line.strip()) for line in text.splitlines() if line.lstrip().startswith("#"))
    return {match[1]: match[2] for match in found if match}


def _column(table: Table, name: str, wanted: str) -> Array:
    """Return a column in SI; every cell is a number."""
    values, unit = table.numbers(name), table.unit(name)
    if unit is None or not same_dimension(unit, wanted):
        raise DataError(
            f"column {name!r} has " + (f"the unit {unit}" if unit else "no unit"),
            where=table.source.path,
            do=f"Write it as {name} [{wanted}]",
            code="wrong_unit",
        )
    empty = np.flatnonzero(np.isnan(values))
    if len(empty):
        raise DataError(f"{name} is empty", where=table.where(int(empty[0])), why="a dwell needs it", code="missing")
    return convert(values, unit, wanted)


def _dwell(lengths: Array, said: dict[str, str], table: Table) -> float:
    """Return the length of all dwells."""
    if len(lengths) < 2:
        raise DataError(f"{len(lengths)} dwell(s): a schedule has two or more", where=table.source.path)
    dwell = _seconds("dwell", said, table) if "dwell" in said else float(np.median(lengths))
    other = np.abs(lengths - dwell) > EVEN * abs(dwell)
    if other.any():
        i = int(np.argmax(other))
        raise DataError(
            f"a dwell of {lengths[i]:g} s among dwells of {dwell:g} s",
            where=table.where(i),
            why="all dwells of a schedule are equally long",
            do="Mend start or stop, or cut the longer ones",
            code="uneven_dwells",
        )
    return dwell


def _check_move(move: float, pauses: Array, dwell: float, table: Table) -> None:
    """Refuse a file whose comment says another pause than its rows."""
    short = (pauses < move - EVEN * dwell) & (pauses >= 0.0)  # dwells over one another are told as such
    if short.any():
        i = int(np.argmax(short))
        raise DataError(
            f"a pause of {pauses[i]:g} s, where the file says that moves take {move:g} s",
            where=table.where(i + 1),
            do="Mend the start, or the comment line",
            code="schedule",
        )


def _seconds(name: str, said: dict[str, str], table: Table) -> float:
    try:
        return parse_quantity(said[name]).to("s")
    except InertialcalError as error:
        problem = error.problems[0]
        raise DataError(f"# {name}: {problem.what}", where=table.source.path, do=problem.do) from None


def _cycle(applied: Array, said: dict[str, str], table: Table) -> int:
    """Return the dwells a cycle, as the file says and its rows show; of the rows, where it does not say.

    Raises
    ------
    DataError
        If what is applied does not come back after so many dwells, or after any.
    """
    if "dwells a cycle" not in said:
        shown = (k for k in range(2, len(applied) // 2 + 1) if _comes_back(applied, k))
        found = next(shown, 2 if len(applied) <= FEW else None)
        if found is None:
            what, do = "what is applied does not come back after any number of dwells", "Write # dwells a cycle: N"
            raise DataError(what, table.source.path, "the frequency of the drive is not known", do, "schedule")
        return found
    number = _whole(said, table)
    if said.get("drive", "custom") != "custom" and not _comes_back(applied, number):
        what = f"# dwells a cycle: {number}, but what is applied does not come back after {number} dwells"
        raise DataError(what, table.source.path, "the frequency of the drive would be wrong",
                        "Mend the line, or the rows; a drive that never comes back is custom", "schedule")  # fmt: skip
    return number


def _comes_back(applied: Array, dwells: int) -> bool:
    """Return whether the same is applied so many dwells later, throughout."""
    change = np.abs(applied[dwells:] - applied[:-dwells]) if dwells else np.empty(0)
    return bool(change.size == 0 or change.max() <= SAME * np.ptp(applied))


def _whole(said: dict[str, str], table: Table) -> int:
    """Return the dwells a cycle that the file says."""
    text = said["dwells a cycle"]
    if not re.fullmatch(r"[0-9]{1,9}", text, re.ASCII):
        raise DataError(f"# dwells a cycle: {text!r} is no whole number", where=table.source.path, code="schedule")
    return int(text)


def _relative(said: dict[str, str], table: Table) -> float | None:
    """Return the relative doubt of what is applied."""
    if "u of applied" not in said:
        return None
    try:
        return parse_quantity(said["u of applied"]).to("1")
    except InertialcalError as error:
        problem = error.problems[0]
        raise DataError(f"# u of applied: {problem.what}", where=table.source.path, do=problem.do) from None
