"""Stamps: numbers and ISO 8601 text as int64 nanoseconds; which numbers are an epoch.

Seconds since 1970 have 10 digits (2001 to 2099), milliseconds 13, microseconds 16, nanoseconds 19. Any other
number of digits is no epoch, and a stamp in seconds beyond them is a misprint.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core import units
from ...core.batches import any_step, batches, changed, every, extremes, mean, near, where
from ...core.batches.summaries import median, median_made
from ...core.estimate import Numbers
from ...core.recording import SECOND, Channel, Recording, Times
from ...core.remarks import Remark
from ...signals.time.time_axis import Steps

EPOCH_FIRST, EPOCH_LAST = 1_000_000_000, 4_102_444_800  # 2001-09-09 and 2100-01-01 [s]
EPOCH_UNITS = {"s": 1, "ms": 1_000, "us": 1_000_000, "ns": 1_000_000_000}
SERIAL_FIRST, SERIAL_LAST = 36_526, 73_051  # 2000-01-01 and 2100-01-01 as spreadsheets count days, from 1899-12-30
SERIAL_EPOCH = 25_569  # 1970-01-01, in such days
MICROSECOND = 1_000  # [ns]: float64 holds no less of a day of such a number
COUNTERS = (16, 24, 32)  # bits
FEWEST_COUNTED = 10  # numbers that show how a counter goes on
LONGEST_STEP = 10.0  # usual steps: samples are lost where a counter begins anew, too
MOST_TWICE = 0.01  # share of stamps that came twice
MIDWAY = 0.5  # of the usual step, by which two of them may differ from twice its length
WIDEST = 9.2e18  # [ns]
EXACT = 2.0**44  # [ns]: smaller products of float64 are right to a thousandth of a nanosecond
ISO = re.compile(
    r"[0-9]{4}-[0-9]{2}-[0-9]{2}[T ][0-9]{2}:[0-9]{2}(?::[0-9]{2}(?:[.,][0-9]{1,9})?)?"
    r"\s*(?P<zone>Z|UTC|[+-][0-9]{2}:?[0-9]{2})?"
)
EARLIEST, LATEST = "1700", "2200"  # years that int64 nanoseconds hold


def epoch_unit(values: Numbers) -> str | None:
    """Return the unit in which all values are an epoch of 2001 to 2099; None where there is none."""
    if not len(values):
        return None
    low, high = extremes(values)
    for unit, per_second in EPOCH_UNITS.items():
        if low >= EPOCH_FIRST * per_second and high < EPOCH_LAST * per_second:
            return unit
    return None


def is_serial(values: Numbers) -> bool:
    """Whether all numbers can be dates of 2000 to 2099 as a spreadsheet keeps them: days with their fraction."""
    if not len(values):
        return False
    low, high = extremes(values)
    return low >= SERIAL_FIRST and high < SERIAL_LAST


def serial_ns(values: Numbers) -> Times:
    """Return days that are such dates (`is_serial`) as nanoseconds since 1970, to the microsecond."""

    def in_ns(part: Numbers) -> Times:
        time_ns = _in_ns(part.astype(np.float64) - SERIAL_EPOCH, units.factor("day", "s") * SECOND)
        return (time_ns + MICROSECOND // 2) // MICROSECOND * MICROSECOND

    return changed(values, in_ns, np.int64)


def going_on(values: Numbers) -> tuple[Numbers, NDArray[np.int64]]:
    """Return whole numbers of a counter of 16, 24 or 32 bits as one that goes on, and the index of each new beginning.

    It began anew where it goes back by so much that the next number, with all bits more, is a usual step ahead.
    """
    nowhere = np.empty(0, dtype=np.int64)
    counted = values.astype(np.int64) if values.dtype.kind == "u" and values.dtype.itemsize < 8 else values
    if counted.dtype.kind != "i" or len(values) < FEWEST_COUNTED or not any_step(counted, lambda step: step < 0):
        return values, nowhere
    counted = counted.astype(np.int64)
    steps = np.diff(counted)
    back = np.flatnonzero(steps < 0)
    usual = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    for bits in COUNTERS:
        ahead = steps[back] + 2**bits
        if counted.min() >= 0 and counted.max() < 2**bits and np.all((ahead > 0) & (ahead <= LONGEST_STEP * usual)):
            steps[back] = ahead
            return np.concatenate([counted[:1], counted[0] + np.cumsum(steps)]), back + 1
    return values, nowhere


def spread_out(time_ns: Times, steps: Steps) -> tuple[Times, NDArray[np.int64]]:
    """Return stamps of which none that came twice, before a step of twice the usual length, and the index of those.

    Such a sample was read in time and stamped too early: it lies midway. Of a row that was written twice the next step
    is a usual one, and its stamp stays as it is.
    """
    nowhere = np.empty(0, dtype=np.int64)
    forward = steps.length > 0
    twice = int(steps.count[steps.length == 0].sum())
    if not twice or twice > MOST_TWICE * len(time_ns):
        return time_ns, nowhere
    usual = float(
        steps.length[forward][np.searchsorted(np.cumsum(steps.count[forward]), steps.count[forward].sum() / 2)]
    )
    apart = np.diff(time_ns)
    late = np.flatnonzero((apart[:-1] == 0) & (np.abs(apart[1:] - 2.0 * usual) <= MIDWAY * usual)) + 1
    if len(late) < twice:  # others came twice for another reason
        return time_ns, nowhere
    found = np.array(time_ns)
    found[late] += apart[late] // 2
    return found, late


def is_utc(time_ns: Times) -> bool:
    """Whether stamps lie in 2001 to 2099."""
    return bool(len(time_ns)) and epoch_unit(time_ns[:1]) == "ns" and epoch_unit(time_ns) == "ns"


def beyond_epoch(values: Numbers) -> NDArray[np.int64]:
    """Return the index of each stamp [s] that is later than 2099: it has digits too many."""
    if len(values) and max(np.abs(np.array(extremes(values), dtype=np.float64))) < EPOCH_LAST:
        return np.empty(0, dtype=np.int64)
    return where(values, lambda part: np.abs(part.astype(np.float64)) >= EPOCH_LAST)


def digits(value: float) -> int:
    """Return the number of digits before the decimal point."""
    return len(str(abs(int(value))))


def to_ns(values: Numbers, unit: str) -> Times | None:
    """Return stamps in nanoseconds; None where they do not fit int64.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Whole numbers (converted without rounding where the unit is a whole number of ns) or floats.
    unit : str
        Of time.
    """
    per_unit = units.factor(unit, "s") * SECOND
    most = 0.0
    for first, stop in batches(values, size=near()):
        part = values[first:stop]
        largest = max(abs(float(part.min())), abs(float(part.max()))) * per_unit
        if not largest < WIDEST:  # NaN too
            return None
        most = max(most, largest)
    return changed(values, lambda part: _in_ns(part, per_unit, most), np.int64)


def _in_ns(values: Numbers, per_unit: float, most: float = WIDEST) -> Times:
    """Return stamps in nanoseconds, of which ``most`` is the largest."""
    if values.dtype.kind in "iu" and per_unit == round(per_unit):
        return values.astype(np.int64) * int(per_unit)
    if most < EXACT:  # the product is as fine as the number itself
        product = np.multiply(values, per_unit, dtype=np.float64)
        return np.rint(product, out=product).astype(np.int64)
    numbers = values.astype(np.float64)
    whole = np.floor(numbers)
    # Apart, so that a stamp of 1e9 s keeps the nanoseconds that float64 holds of it.
    rest = np.rint((numbers - whole) * per_unit).astype(np.int64)
    if per_unit == round(per_unit):
        return whole.astype(np.int64) * int(per_unit) + rest
    return np.rint(numbers * per_unit).astype(np.int64)


def looks_iso(cells: Sequence[str] | NDArray[Any]) -> bool:
    """Whether the first and the last cell are ISO 8601 instants."""
    return bool(len(cells)) and all(ISO.fullmatch(str(cell)) for cell in (cells[0], cells[-1]))


def from_iso(cells: NDArray[Any]) -> tuple[Times, int, NDArray[np.int64]]:
    """Return instants in nanoseconds since 1970 UTC.

    Parameters
    ----------
    cells : ndarray of str, shape (n,)
        ``2010-04-28T15:10:00.5Z``; a blank for the T, an offset for the Z, or no zone.

    Returns
    -------
    time_ns : ndarray of int64, shape (n,)
        0 where a cell is no instant.
    naive : int
        How many cells have no zone; they are taken as UTC.
    bad : ndarray of int64
        Index of the cells that are no instant.
    """
    times = np.zeros(len(cells), dtype=np.int64)
    bad, naive = [], 0
    for i, cell in enumerate(cells):
        match = ISO.fullmatch(str(cell))
        instant = _instant(str(cell), match["zone"]) if match else None
        if instant is None or match is None:
            bad.append(i)
            continue
        naive += match["zone"] is None
        times[i] = instant
    return times, naive, np.array(bad, dtype=np.int64)


def _instant(cell: str, zone: str | None) -> int | None:
    """Nanoseconds since 1970 UTC; None where the calendar has no such day or time."""
    if not EARLIEST <= cell[:4] < LATEST:
        return None
    body = cell[: len(cell) - len(zone)] if zone else cell
    seconds, _, fraction = body.strip().replace(",", ".").partition(".")
    try:
        instant = datetime.fromisoformat(seconds).replace(tzinfo=UTC)
    except ValueError:
        return None
    since = instant - datetime(1970, 1, 1, tzinfo=UTC)
    ns = (since.days * 86_400 + since.seconds) * SECOND + int(fraction.ljust(9, "0") or 0)
    return ns - _offset(zone)


def _offset(zone: str | None) -> int:
    """Offset from UTC [ns]."""
    if zone is None or zone in ("Z", "UTC"):
        return 0
    sign = -1 if zone[0] == "-" else 1
    return sign * (int(zone[1:3]) * 3600 + int(zone[-2:]) * 60) * SECOND


FASTEST = 1.0  # [K/s]
SMALLEST_SWING = 5.0  # [K]
BLOCKS = 100
SAMPLE_RATES = (0.01, 1e5)  # that come into question where the unit of time is not known [Hz]


def time_remarks(recording: Recording) -> tuple[Remark, ...]:
    """Return a remark where the temperature changes faster than anything can.

    Where a time column has no unit, each unit is tried that gives a sample rate of 0.01 Hz to 100 kHz.
    """
    temperatures = [c for c in recording.channels if c.quantity == "temperature"]
    if not temperatures:
        return ()
    if recording.time_ns is not None and len(recording):
        return _remark(temperatures[0], recording.time_ns, SECOND, recording, "")
    clocks = [c for c in recording.channels if c.quantity == "time" and c.unit is None]
    return tuple(
        remark
        for clock in clocks[:1]
        for unit, per_second in EPOCH_UNITS.items()
        if _possible(clock.data, per_second)
        for remark in _remark(temperatures[0], clock.data, per_second, recording, f" if {clock.name!r} is in {unit}")
    )


def _possible(stamps: Numbers, per_second: float) -> bool:
    """Whether the unit gives a usual sample rate."""
    step = median_made(lambda a, b: np.diff(stamps[a : b + 1].astype(np.float64)), stamps[:-1]) / per_second
    return step > 0.0 and SAMPLE_RATES[0] <= 1.0 / step <= SAMPLE_RATES[1]


def _remark(
    temperature: Channel, stamps: Numbers, per_second: float, recording: Recording, condition: str
) -> tuple[Remark, ...]:
    """Swing from the coldest to the warmest block, over the time between them."""
    size = max(1, len(stamps) // BLOCKS)
    if len(stamps) <= near():  # at once: a call a block takes longer than its samples
        blocks = np.arange(len(stamps) // size * size).reshape(-1, size)
        blocks = blocks[np.isfinite(temperature.data[blocks]).all(axis=1)]
        level = np.median(temperature.data[blocks], axis=1)
        middle = np.mean((stamps[blocks] - stamps[0]) / per_second, axis=1)
    else:
        found = []
        for first in range(0, len(stamps) - size + 1, size):
            values, block = temperature.data[first : first + size], stamps[first : first + size]
            if every(values, lambda part: np.isfinite(part).all()):
                found.append((median(values), mean(changed(block, lambda part: (part - stamps[0]) / per_second))))
        level, middle = np.array(found).reshape(-1, 2).T
    if len(level) < 2:
        return ()
    cold, warm = int(np.argmin(level)), int(np.argmax(level))
    swing, between = float(level[warm] - level[cold]), abs(float(middle[warm] - middle[cold]))
    if swing < SMALLEST_SWING or swing <= FASTEST * between:
        return ()
    what = (
        f"{temperature.name!r} changes by {swing:.3g} within {between:.3g} s{condition}: "
        f"no sensor changes faster than {FASTEST:g} K/s, so the time stamps are wrong"
    )
    do = "Check the sample rate (--sample-rate) and the unit of time"
    return (Remark("time_axis_implausible", "warning", what, where=recording.source.path, do=do),)
