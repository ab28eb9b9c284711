"""Time as a column: in the name and unit that it came with, where that keeps every stamp to the nanosecond.

Else an instant (UTC) or nanoseconds (elapsed). Whole numbers stay whole. Each form is tried on the reader's own
functions: what is written reads back as the same stamps and the same epoch.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core import units
from ...core.errors import DataError
from ...core.estimate import Numbers
from ...core.recording import SECOND, Recording, Times
from ..columns import Column
from ..text.headers import heading
from ..time.stamps import EARLIEST, LATEST, beyond_epoch, is_utc, to_ns
from .titles import Title, contradicts, read_back, spelled

PLAIN = "time"
EXACT = 2**53  # whole numbers up to here are floats without rounding


def time_column(recording: Recording, in_names: bool, instants: bool = True) -> Column | None:
    """Return the time of a recording as a column; None where it has none.

    Parameters
    ----------
    recording : Recording
        Whose time is to be written.
    in_names : bool
        Whether the unit has no other place than the name.
    instants : bool
        Whether the format has a type for instants of any year; else only those of 1700 to 2199 can be told.

    Returns
    -------
    Column
        Whole numbers or floats with their unit in name or metadata, or ``datetime64[ns]``.

    Raises
    ------
    DataError
        ``time_not_writable``, if no form reads back.
    """
    if recording.time_ns is None:
        return None
    name = time_name(recording)
    for values, unit in _forms(recording, recording.time_ns, name, instants):
        for title in _titles(recording, name, unit, values, in_names):
            return Column(title.name, values, title.unit)
    raise DataError(
        f"the stamps ({recording.epoch}) cannot be written so that they read back as they are",
        where=recording.source.path,
        why="elapsed time beyond 31 years reads as UTC, and text holds instants of 1700 to 2199",
        do="Say the time in another unit, or write Parquet",
        code="time_not_writable",
    )


def time_name(recording: Recording) -> str:
    """Return the name of the column that the time came from, ``"time"`` where that is not known."""
    name = recording.time_column.strip()
    return name if name.isprintable() and name not in {"", *recording.names} else PLAIN


def _forms(recording: Recording, time_ns: Times, name: str, instants: bool) -> Iterator[tuple[Numbers, str]]:
    """Yield the numbers or instants that read back, the form of the name first; instants have no unit."""
    said = heading(name).unit
    by_name = said if said is not None and units.kind(said) == "time" else None
    utc = recording.epoch == "utc"
    instant = utc and (instants or _tellable(time_ns))
    for unit in dict.fromkeys([by_name or ("" if instant else "s"), "" if instant else "s", "ns"]):
        if not unit:
            yield time_ns.astype("datetime64[ns]"), ""
            continue
        values = numbers(time_ns, unit)
        if _keeps(values, unit, time_ns, utc):
            yield values, unit


def numbers(time_ns: Times, unit: str) -> Numbers:
    """Return stamps [ns] in a unit of time: int64 where all are whole, else the nearest floats."""
    per_unit = units.factor(unit, "s") * SECOND
    size = int(per_unit)
    if size != per_unit or size < 1:
        return time_ns / per_unit
    whole = time_ns // size
    rest = time_ns - whole * size
    if not rest.any():
        return whole
    if int(np.abs(time_ns).max()) < EXACT:
        return time_ns / float(size)
    return whole + rest / float(size)


def _keeps(values: Numbers, unit: str, time_ns: Times, utc: bool) -> bool:
    if unit == "s" and len(beyond_epoch(values)):
        return False
    again = to_ns(values, unit)
    return again is not None and bool(np.array_equal(again, time_ns)) and is_utc(again) == utc


def _tellable(time_ns: Times) -> bool:
    """Whether text can hold these instants."""
    instants = time_ns.astype("datetime64[ns]")
    early, late = instants < np.datetime64(EARLIEST), instants >= np.datetime64(LATEST)
    return not bool(np.any(early | late))


def _titles(recording: Recording, name: str, unit: str, values: Numbers, in_names: bool) -> Iterator[Title]:
    """Titles under which the column reads as time in that unit, and that no channel has."""
    names = (PLAIN, f"{PLAIN}_stamp")
    for one in names if unit and contradicts(name, unit) else dict.fromkeys((name, *names)):
        for title in spelled(one, unit or None, in_names):
            found = read_back(title, Column(title.name, values, title.unit))
            fits = found.unit in {None, unit} if not unit else found.unit == unit
            if fits and found.quantity == "time" and title.name not in recording.names:
                yield title
