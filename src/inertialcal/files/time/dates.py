"""Dates as spreadsheets and loggers write them, in their own order of day and month, as ISO 8601 text.

``12.03.2024 09:15:00`` has its day first: nobody writes points otherwise. With strokes it is the day that comes first
where a first number is above 12, and the month where a second one is. Where none is, the file does not say, and the
user is asked. A column of dates and one of times of day are one time together. Times of day alone count from midnight.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import date, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, UsageError
from ...core.recording import SECOND, Times
from ..info.describe import Described
from ..text.headers import plain

ORDERS = ("day-first", "month-first")
_CLOCK = (
    r"(?P<hour>[0-9]{1,2}):(?P<minute>[0-9]{2})(?::(?P<second>[0-9]{2})(?:[.,:](?P<fraction>[0-9]{1,9}))?)?"
    r"(?:\s*(?P<half>[AP])\.?M\.?)?"
)
CLOCK = re.compile(rf"(?:(?P<days>[0-9]{{1,6}}) days? )?{_CLOCK}", re.IGNORECASE)
DATE = re.compile(
    rf"(?P<a>[0-9]{{1,4}})(?P<sign>[./-])(?P<b>[0-9]{{1,2}})(?P=sign)(?P<c>[0-9]{{2}}|[0-9]{{4}})"
    rf"(?:[T ,;]\s*{_CLOCK}\s*(?P<zone>Z|UTC|[+-][0-9]{{2}}:?[0-9]{{2}})?)?",
    re.IGNORECASE,
)
DAY_OF_YEAR = re.compile(  # as those of spacecraft: ``2014/295/09:36:36``, ``2014-295T09:36:36``
    rf"(?P<year>[0-9]{{4}})[/:-](?P<day>[0-9]{{3}})[/:T \-]{_CLOCK}\s*(?P<zone>Z|UTC)?", re.IGNORECASE
)
WITH_MONTH = re.compile(  # ``12-Mar-2026 07:40:34``, ``3. M\N{LATIN SMALL LETTER A WITH DIAERESIS}rz 2026``
    r"(?P<day>[0-9]{1,2})\.?[ /-]?(?P<month>[^\W\d_]{3,10})\.?[ /-]?(?P<year>[0-9]{4})"
    rf"(?:[T ,;]\s*{_CLOCK}\s*(?P<zone>Z|UTC|[+-][0-9]{{2}}:?[0-9]{{2}})?)?",
    re.IGNORECASE,
)
NAMED = {  # months as English, German, French, Italian and Spanish call them: as many letters as tell them apart
    1: ("jan", "ene", "gen"), 2: ("feb", "fev"), 3: ("mar", "mrz"), 4: ("apr", "avr", "abr"), 5: ("may", "mai", "mag"),
    6: ("jun", "juin", "giu"), 7: ("jul", "juil", "lug"), 8: ("aug", "aou", "ago"), 9: ("sep", "set"),
    10: ("oct", "okt", "ott"), 11: ("nov",), 12: ("dec", "dez", "dic"),
}  # fmt: skip
ISO_DATE = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}.*")  # read as it is
YEAR = 4  # digits
MONTHS, CENTURY, HALF_DAY, DAY = 12, 2000, 12, 86_400


def check_dates(order: str | None) -> str | None:
    """Return an order of day and month; Raises UsageError for another word."""
    if order is not None and order not in ORDERS:
        raise UsageError(f"dates {order!r}", do=f"Write {' or '.join(ORDERS)}", code="wrong_value")
    return order


def looks_dated(cells: Sequence[str] | NDArray[Any]) -> bool:
    """Whether the first and the last cell are dates in the order of a spreadsheet."""
    ends = [str(cell) for cell in (cells[0], cells[-1])] if len(cells) else [""]
    if all(_month_of(cell) for cell in ends):
        return True
    return all(DAY_OF_YEAR.fullmatch(cell) or (DATE.fullmatch(cell) and not ISO_DATE.fullmatch(cell)) for cell in ends)


def looks_clock(cells: NDArray[Any]) -> bool:
    """Whether the first and the last cell are times of day."""
    return bool(len(cells)) and all(CLOCK.fullmatch(str(cell)) for cell in (cells[0], cells[-1]))


def as_iso(cells: NDArray[Any], order: str | None, name: str, where: str) -> NDArray[Any]:
    """Return dates as ISO 8601 text, shape (n,); cells that are none stay as they are.

    Parameters
    ----------
    order : {"day-first", "month-first"}, optional
        As was said; by default the file decides.
    name, where : str
        Column and file, for messages.

    Raises
    ------
    DataError
        ``ambiguous_date`` where day and month cannot be told apart.
    """
    if len(cells) and _month_of(str(cells[0])):
        return np.array([_of_month(str(cell)) for cell in cells], dtype=object)
    if len(cells) and DAY_OF_YEAR.fullmatch(str(cells[0])):
        return np.array([_of_day(str(cell)) for cell in cells], dtype=object)
    found = [DATE.fullmatch(str(cell)) for cell in cells]
    known = [one for one in found if one is not None]
    if order is None:
        order = _order(known, name, where)
    texts = [str(cell) if one is None else _iso(one, order) for one, cell in zip(found, cells, strict=True)]
    return np.array(texts, dtype=object)


def since_midnight(cells: NDArray[Any]) -> tuple[Times, NDArray[np.int64]]:
    """Return times of day [ns], on over midnight, and the index of each cell that is none."""
    found = [CLOCK.fullmatch(str(cell)) for cell in cells]
    bad = np.array([i for i, one in enumerate(found) if one is None], dtype=np.int64)
    times = np.array([0 if one is None else _nanoseconds(one) for one in found], dtype=np.int64)
    if any(one is not None and one["days"] for one in found):  # elapsed, as pandas writes it
        days = [0 if one is None else int(one["days"] or 0) for one in found]
        return times + np.array(days, dtype=np.int64) * DAY * SECOND, bad
    night = np.concatenate([[0], np.cumsum(np.diff(times) < -DAY * SECOND // 2)]) if len(times) else times
    return times + night * DAY * SECOND, bad


def with_times_of_day(described: Sequence[Described]) -> list[Described]:
    """Return the columns with a column of dates and one of times of day as one, in the place of the dates."""
    texts = [i for i, one in enumerate(described) if one.column.values.dtype.kind == "O" and len(one.column.values)]
    days = [i for i in texts if (match := DATE.fullmatch(str(described[i].column.values[0]))) and not match["hour"]]
    clocks = [i for i in texts if looks_clock(described[i].column.values)]
    joined = list(described)
    if len(days) == 1 and len(clocks) == 1:
        day, clock = (described[one[0]].column for one in (days, clocks))
        both = np.array([f"{a} {b}" for a, b in zip(day.values, clock.values, strict=True)], dtype=object)
        joined[days[0]] = replace(described[days[0]], column=replace(day, values=both), quantity="time")
        joined[clocks[0]] = replace(described[clocks[0]], quantity="")
    return joined


def _order(found: Sequence[re.Match[str]], name: str, where: str) -> str:
    if not found or found[0]["sign"] == "." or len(found[0]["a"]) == YEAR:
        return ORDERS[0]
    first, second = (max(int(one[part]) for one in found) for part in "ab")
    if (first > MONTHS) != (second > MONTHS):
        return ORDERS[first <= MONTHS]
    raise DataError(
        f"{found[0].string!r} in time column {name!r}: which is the day, which the month?",
        where,
        why="no day of the file is above 12",
        do=f"Say it: --dates {ORDERS[0]}, or --dates {ORDERS[1]}",
        code="ambiguous_date",
    )


def _iso(found: re.Match[str], order: str) -> str:
    """Return one date as ISO 8601 text; as it is where it is no date in that order."""
    a, b, c = found["a"], found["b"], found["c"]
    year, month, day = (a, b, c) if len(a) == YEAR else (c, b, a) if order == ORDERS[0] else (c, a, b)
    if len(year) != YEAR:
        year = str(CENTURY + int(year))
    if not 1 <= int(month) <= MONTHS:
        return found.string
    ns = _nanoseconds(found) if found["hour"] else 0
    return f"{year}-{int(month):02d}-{int(day):02d}T{_clock(ns)}{found['zone'] or ''}"


def _month_of(cell: str) -> int:
    """Return the number of the month that a date calls by its name; 0 where it is no such date."""
    found = WITH_MONTH.fullmatch(cell)
    name = "" if found is None else plain(found["month"]).lower()
    return next((number for number, known in NAMED.items() if name.startswith(known)), 0)


def _of_month(cell: str) -> str:
    """Return an instant whose month has its name as ISO 8601 text; as it is where it is none."""
    month, found = _month_of(cell), WITH_MONTH.fullmatch(cell)
    if not month or found is None:
        return cell
    clock = _clock(_nanoseconds(found)) if found["hour"] else "00:00:00"
    return f"{found['year']}-{month:02d}-{int(found['day']):02d}T{clock}{found['zone'] or ''}"


def _of_day(cell: str) -> str:
    """Return an instant by the day of its year as ISO 8601 text; as it is where it is none."""
    found = DAY_OF_YEAR.fullmatch(cell)
    if found is None:
        return cell
    day = date(int(found["year"]), 1, 1) + timedelta(days=int(found["day"]) - 1) if int(found["year"]) else date.max
    same = day.year == int(found["year"])  # no day 0, no day 366 of a common year
    return f"{day}T{_clock(_nanoseconds(found))}{found['zone'] or ''}" if same else cell


def _clock(ns: int) -> str:
    """Return a time of day [ns] as ISO 8601 text."""
    seconds, fraction = divmod(ns, SECOND)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}.{fraction:09d}"


def _nanoseconds(found: re.Match[str]) -> int:
    """Return the time of day [ns]; one that no clock shows is beyond the day, so that it is refused."""
    hour = int(found["hour"])
    if found["half"]:
        hour = hour % HALF_DAY + (HALF_DAY if found["half"].lower() == "p" else 0)
    whole = (hour * 60 + int(found["minute"])) * 60 + int(found["second"] or 0)
    return whole * SECOND + int((found["fraction"] or "0").ljust(9, "0"))
