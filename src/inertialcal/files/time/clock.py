"""Clock: which column is time, in which unit, and what its time stamps say.

A column is time because it is named so (``t``, ``time``, ``timestamp``, ``unix``, ``epoch``, ...), holds dates, or is
told to be; where none is, texts that are dates are time whatever they are called. Without any header the first column
is time only if it is strictly increasing and not in whole steps. A count of rows is never time. The unit comes from
flag or header; without one only two things are taken, and remarked: numbers that are an epoch of 2001 to 2099 by
their digits, and fractions as seconds. Whole numbers without a unit stay untaken: the remark says what each unit
would mean. Days as spreadsheets count them (45363.4 is a morning in March 2024) are dates where the column is called
so or no sensor is as fast as their steps were in seconds; where both could be, the user is asked.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...core import units
from ...core.batches import changed, every
from ...core.errors import DataError
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ...signals.time.time_axis import Steps, steps_of
from ..columns import Content
from ..info.describe import Described, find_column
from ..text.hobo import zone_of
from .dates import as_iso, looks_clock, looks_dated, since_midnight, with_times_of_day
from .stamps import (
    beyond_epoch,
    digits,
    epoch_unit,
    from_iso,
    going_on,
    is_serial,
    is_utc,
    looks_iso,
    serial_ns,
    spread_out,
    to_ns,
)

FEWEST = 10  # rows from which an unnamed first column can be time
BACKWARD = 0.1  # share of backward steps from which a column is no time
LARGEST_STEP = 1000  # largest step of stamps that are taken for seconds with a digit too many
SLOWEST, FASTEST = 0.01, 1e5  # sample rates that come into question [Hz]
DAY, DAY_LENGTH = "day", 86_400.0  # [s]
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # of stamps [s]
ALIKE = 0.25  # relative difference of two steps that are alike
SAID_UTC = re.compile(r"(?:^|[^A-Za-z])(?:unix|epoch|utc)(?:[^A-Za-z]|$)", re.IGNORECASE)
SAID_DATE = re.compile(r"(?:^|[^a-z])(?:date|datetime|datum)(?:[^a-z]|$)", re.IGNORECASE)
SAID_FROM = 10**8 * SECOND  # 1973: a smaller number in a column of that name counts from the start of a record


@dataclass(frozen=True, eq=False)
class Clock:
    """Time of a file."""

    column: int | None = None  # Position of the column that is time
    time_ns: Times | None = None  # shape (n,): stamps [ns]
    epoch: Literal["utc", "elapsed"] = "elapsed"  # What time zero is
    remarks: tuple[Remark, ...] = ()  # What was taken, and what was not
    steps: Steps | None = None  # Of the stamps, where they were counted


@dataclass(frozen=True)
class _Place:
    """The file, for messages."""

    path: str
    content: Content
    dates: str | None = None  # Order of day and month, as was said

    def row(self, index: int) -> str:
        return self.content.place(self.path, index)


class _NotTimeError(Exception):
    """Why a column is not taken as time."""

    def __init__(self, remark: Remark):
        self.remark = remark
        super().__init__(remark.what)


def find_clock(
    described: Sequence[Described],
    content: Content,
    path: str,
    time_column: str | None = None,
    dates: str | None = None,
) -> Clock:
    """Return the time of a file; empty where it has none.

    ``dates``: order of day and month, ``"day-first"`` or ``"month-first"``, where it was said.

    Raises
    ------
    DataError
        If a stamp has digits too many for an epoch (code ``epoch_digits``), is no instant, or the column
        that was named is not there or cannot be time.
    """
    place = _Place(path, content, dates)
    described = with_times_of_day(described)
    if time_column is not None:
        at = find_column(described, time_column, path)
        try:
            return _clock(described[at], at, place)
        except _NotTimeError as reason:
            raise DataError(
                reason.remark.what, where=reason.remark.where, do=reason.remark.do, code=reason.remark.code
            ) from None
    remarks: list[Remark] = []
    for at, is_said in _candidates(described):
        try:
            clock = _clock(described[at], at, place)
        except _NotTimeError as reason:
            remarks += [reason.remark] if is_said else []
            continue
        except DataError as error:
            if is_said or error.problems[0].code == "ambiguous_date":
                raise
            continue
        return replace(clock, remarks=(*remarks, *clock.remarks))
    return _unnamed(described, place) or Clock(remarks=tuple(remarks))


def _candidates(described: Sequence[Described]) -> list[tuple[int, bool]]:
    """Columns that are time by name or type, those with a unit or dates first; then, unsaid, texts that are dates."""
    found, unsaid = [], []
    for i, column in enumerate(described):
        dates = column.column.values.dtype.kind == "M"
        text = column.column.values.dtype.kind == "O"
        cells = column.column.values
        named = text and (column.quantity == "time" or i == 0)
        iso = named and any(looks(cells) for looks in (looks_iso, looks_dated, looks_clock))
        if text and not named and (looks_iso(cells) or looks_dated(cells)) and cells[0] != cells[-1]:
            unsaid.append((i, False))  # ``id, recorded_at``
        if dates or iso or (column.quantity == "time" and not text):
            found.append((not (dates or iso or column.unit), i))
    return [*((i, True) for _, i in sorted(found)), *unsaid]


def _clock(described: Described, at: int, place: _Place) -> Clock:
    """Clock of one column, or the reason why it is none."""
    kind = described.column.values.dtype.kind
    remarks: tuple[Remark, ...] = ()
    if kind == "M":
        _require_complete(described, place)
        stamps = described.column.values
        if stamps.dtype != "datetime64[ns]":
            stamps = changed(stamps, np.array, "datetime64[ns]")
        time_ns = stamps.view(np.int64)
        remarks = _without_zone(described, place) if described.column.naive else ()
    elif kind == "O":
        time_ns, remarks = _from_text(described, place)
    else:
        time_ns, remarks = _from_numbers(described, place)
    ahead = zone_of(described.name)
    if ahead is not None and any(one.code == "naive_time" for one in remarks):
        time_ns = changed(time_ns, lambda part: part - ahead, "int64")
        remarks = (Remark("zone_of_header", "info", f"stamps of {described.name!r}: UTC by their header", place.path),)
    steps = _require_forward(described, time_ns, place)
    time_ns, late = spread_out(time_ns, steps)
    if len(late):
        steps = steps_of(time_ns)
        what = f"stamp of {described.name!r} repeated before a step twice as long: the sample is taken to lie midway"
        remarks += (Remark("stamp_midway", "info", what, place.row(int(late[0])), len(late)),)
    dated = kind == "M" or (kind == "O" and not looks_clock(described.column.values))
    utc = dated or is_utc(time_ns) or _said_utc(described.name, time_ns)
    return Clock(at, time_ns, "utc" if utc else "elapsed", remarks, steps)


def _said_utc(name: str, time_ns: Times) -> bool:
    """Whether the name says that stamps before 2001 are UTC: their digits alone do not."""
    return len(time_ns) > 0 and int(time_ns[0]) >= SAID_FROM and SAID_UTC.search(name) is not None


def _require_complete(described: Described, place: _Place) -> None:
    gone = np.concatenate([described.column.empty, described.column.not_a_number])
    if len(gone):
        raise _NotTimeError(
            Remark(
                "time_missing",
                "error",
                f"time column {described.name!r} has empty cells: not used as time",
                where=place.row(int(gone.min())),
                count=len(gone),
                do="Fill in the times, or delete these rows",
            )
        )


def _require_forward(described: Described, time_ns: Times, place: _Place) -> Steps:
    """Return the steps of a time that goes forward, most of the time."""
    steps = steps_of(time_ns)
    backward = int(steps.count[steps.length < 0].sum()) / max(len(time_ns) - 1, 1)
    forward = bool(np.any(steps.length > 0))
    if len(time_ns) > 1 and (not forward or backward > BACKWARD):
        share = f"{100 * backward:.0f} % of its steps go backward" if forward else "it stands still"
        raise _NotTimeError(
            Remark(
                "not_time",
                "warning",
                f"{described.name!r} is not time: {share}",
                where=place.path,
                do="Name the time column (--time-column), or sort the rows",
            )
        )
    return steps


def _from_text(described: Described, place: _Place) -> tuple[Times, tuple[Remark, ...]]:
    """Return the stamps of a column of dates."""
    cells = described.column.values
    if looks_clock(cells):
        time_ns, bad = since_midnight(cells)
        naive = 0
    else:
        cells = as_iso(cells, place.dates, described.name, place.path) if looks_dated(cells) else cells
        time_ns, naive, bad = from_iso(cells)
    if len(bad):
        cell = str(described.column.values[bad[0]])[:60]
        more = f" ({len(bad)} such cells)" if len(bad) > 1 else ""
        raise DataError(
            f"{cell!r} in time column {described.name!r} is not a date and time{more}",
            where=place.row(int(bad[0])),
            do="Write it like 2010-04-28T15:10:00Z. Dates with strokes: --dates day-first, or month-first",
            code="text_in_numbers",
        )
    return time_ns, _without_zone(described, place) if naive else ()


def _without_zone(described: Described, place: _Place) -> tuple[Remark, ...]:
    what = f"stamps of {described.name!r} have no time zone: UTC is assumed"
    return (Remark("naive_time", "warning", what, where=place.path, do="Add Z, or the offset"),)


def _from_numbers(described: Described, place: _Place) -> tuple[Times, tuple[Remark, ...]]:
    """Return the stamps of a column of numbers."""
    values = described.column.values
    if not len(values) or not described.column.is_number:
        raise _NotTimeError(Remark("not_time", "warning", f"{described.name!r} holds no numbers", place.path))
    _require_complete(described, place)
    unit = described.unit
    remarks: tuple[Remark, ...] = ()
    if unit is None:
        unit, remarks = _unit(described, place)
    elif units.kind(unit) != "time":
        raise _NotTimeError(Remark("not_time", "warning", f"{described.name!r} is in {unit}", place.path))
    if unit == "s":
        _refuse_digits(described, place, beyond_epoch(values))
    if unit == DAY and is_serial(values):
        return serial_ns(values), (*remarks, *_without_zone(described, place))
    values, again = going_on(values)
    if len(again):
        what = f"{described.name!r} is a counter that begins anew: it goes on behind its largest number"
        remarks += (Remark("counter_anew", "info", what, place.row(int(again[0])), len(again)),)
    time_ns = to_ns(values, unit)
    if time_ns is None:
        what = f"stamps of {described.name!r} in {unit} span more than 292 years"
        raise _NotTimeError(Remark("not_time", "warning", what, where=place.path, do="Check the unit"))
    return time_ns, remarks


def _unit(described: Described, place: _Place) -> tuple[str, tuple[Remark, ...]]:
    """Return the unit that the numbers alone allow, with its remark."""
    values, name = described.column.values, described.name
    epoch = epoch_unit(values)
    if epoch is not None:
        stamps = to_ns(values[:1], epoch)
        first = np.datetime64(int(stamps[0]) if stamps is not None else 0, "ns").astype("datetime64[s]")
        what = f"{name!r} has no unit; its digits make it an epoch in {epoch}, from {first}Z"
        return epoch, (Remark("epoch_inferred", "info", what, where=place.path),)
    _refuse_surplus(described, place)
    if is_serial(values) and (found := _serial(described, place)):
        return found
    if every(values, lambda part: np.all(part == np.rint(part))):
        raise _NotTimeError(_unit_unknown(name, values, place.path))
    what = f"{name!r} has no unit: seconds are assumed"
    do = f"Otherwise add {_option(name, 'ms')}"
    return "s", (Remark("time_unit_assumed", "warning", what, where=place.path, do=do),)


def _serial(described: Described, place: _Place) -> tuple[str, tuple[Remark, ...]] | None:
    """Return days as the unit of numbers that can be dates of a spreadsheet; None where they are none."""
    values, name = described.column.values.astype(np.float64), described.name
    step = float(np.median(np.abs(np.diff(values)))) if len(values) > 1 else 0.0
    if step == 0.0 or np.all(values == np.rint(values)):
        return None
    first = np.datetime64(int(serial_ns(values[:1])[0]), "ns").astype("datetime64[s]")
    if SAID_DATE.search(name) or step * FASTEST < 1.0:
        what = f"{name!r} has no unit; taken as days of a spreadsheet, from {first}"
        return DAY, (Remark("epoch_inferred", "info", what, where=place.path),)
    if step * DAY_LENGTH * SLOWEST > 1.0:
        return None
    what = f"{name!r} has no unit, so it is not used as time: as dates of a spreadsheet it begins {first}, with "
    what += f"{1.0 / (step * DAY_LENGTH):.4g} Hz; in s it has {1.0 / step:.4g} Hz"
    do = f"Say which: {_option(name, DAY)}, or {_option(name, 's')}"
    raise _NotTimeError(Remark("time_unit_unknown", "warning", what, where=place.path, do=do))


def unit_rates(described: Sequence[Described]) -> dict[str, float]:
    """Return the sample rates [Hz] that the time column of a file means, by unit; empty where it has none.

    Only where its unit is not known, and its steps are alike.
    """
    clocks = [one for one in described if one.quantity == "time" and one.unit is None and one.column.is_number]
    if len(clocks) != 1 or not clocks[0].column.is_complete or len(clocks[0].column.values) < FEWEST:
        return {}
    steps = np.diff(clocks[0].column.values.astype(np.float64))
    step = float(np.median(steps))
    if step <= 0.0 or np.mean(np.abs(steps - step) > ALIKE * step) > BACKWARD:
        return {}
    return {f"{clocks[0].name!r} in {unit} says": rate for unit, rate in _rates(step).items()}


def _rates(step: float) -> dict[str, float]:
    """Sample rate [Hz] that a step means in each unit, where it comes into question."""
    return {unit: 1.0 / (step * size) for unit, size in UNITS.items() if SLOWEST <= 1.0 / (step * size) <= FASTEST}


def _unit_unknown(name: str, values: NDArray[Any], path: str) -> Remark:
    """Remark that says what each unit would mean."""
    steps = np.diff(values.astype(np.float64))
    step = float(np.median(steps)) if len(steps) else 0.0
    span = float(values.max()) - float(values.min())
    rates = _rates(step) if step > 0.0 else {}
    meant = [f"in {unit} {rate:.5g} Hz over {span * UNITS[unit]:.4g} s" for unit, rate in rates.items()]
    return Remark(
        "time_unit_unknown",
        "warning",
        f"{name!r} has whole numbers without a unit, so it is not used as time: {'; '.join(meant) or 'no unit fits'}",
        where=path,
        do=f"Add {_option(name, 'UNIT')}",
    )


def _option(name: str, unit: str) -> str:
    """Return the option that gives a column a unit, as it is typed."""
    return f"--unit {shlex.quote(f'{name}={unit}')}"


def _refuse_surplus(described: Described, place: _Place) -> None:
    """Seconds since 1970 with a digit too many: all, or some among good ones."""
    if every(described.column.values, lambda part: not np.any((np.abs(part) >= 1e10) & (np.abs(part) < 1e11))):
        return
    values = described.column.values.astype(np.float64)
    size = np.abs(values)
    eleven = (size >= 1e10) & (size < 1e11)
    among_epochs = epoch_unit(np.array([np.median(values)])) == "s"
    step = float(np.median(np.abs(np.diff(values)))) if len(values) > 1 else 0.0
    if among_epochs or (np.median(eleven) == 1.0 and step <= LARGEST_STEP):
        _refuse_digits(described, place, np.flatnonzero(eleven))


def _refuse_digits(described: Described, place: _Place, at: NDArray[np.int64]) -> None:
    if not len(at):
        return
    value = described.column.values[at[0]]
    more = f" ({len(at)} such stamps)" if len(at) > 1 else ""
    unit = epoch_unit(described.column.values)
    do = f"Give its unit: {_option(described.name, unit)}" if unit else "Correct the stamps"
    raise DataError(
        f"stamp {value:.0f} in {described.name!r} has {digits(value)} digits{more}",
        where=place.row(int(at[0])),
        why="seconds since 1970 have 10 digits, milliseconds 13: one digit too many?",
        do=do,
        code="epoch_digits",
    )


def _unnamed(described: Sequence[Described], place: _Place) -> Clock | None:
    """Clock of a file without header: the first column, if it can be nothing else."""
    if len(described) < 2 or described[0].column.named or described[0].quantity == "index":
        return None
    column = described[0].column
    if not column.is_number or not column.is_complete or len(column.values) < FEWEST:
        return None
    values = column.values.astype(np.float64)
    if not np.all(np.diff(values) > 0.0):
        return None
    if np.all(values == np.rint(values)):
        what = f"{column.name!r} looks like time in whole numbers: not used"
        do = "If it is time: --time-column 1 --unit 1=UNIT"
        return Clock(remarks=(Remark("time_not_taken", "warning", what, where=place.path, do=do),))
    given = described[0].unit
    time_ns = to_ns(values, given or "s") if given is None or units.kind(given) == "time" else None
    if time_ns is None:
        return None
    what = f"{column.name!r} has no name; it always increases: used as time in {given or 'seconds'}"
    remark = Remark("time_unnamed", "warning", what, where=place.path, do="Otherwise name the columns in a header")
    return Clock(0, time_ns, "utc" if is_utc(time_ns) else "elapsed", (remark,))
