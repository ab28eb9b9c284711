"""Whether name, header and data of an archive pair tell of one and the same record."""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Numbers
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.times import instant_text
from .header import PadHeader
from .name import Pair, parse_name
from .time import Stamps, median_step, rates_agree

MILLISECOND = SECOND // 1000  # names and headers give times to it
RECORDS = 1e-3  # share of the records that may lack or be too many before the pair is refused
FIRST = 1000  # records that tell the byte order


def check_byte_order(time: Numbers, header: PadHeader, where: str) -> None:
    """Refuse data whose bytes lie the other way round.

    Raises
    ------
    DataError
        ``header_disagrees``.
    """
    some = time[:FIRST]
    if not header.number_type or len(some) < 2 or _goes(some, header.sample_rate):
        return
    if _goes(some.byteswap(), header.sample_rate):
        said, found = ("little", "big") if header.number_type.startswith("<") else ("big", "little")
        raise _disagrees(f"the header says {said} endian, the bytes are {found} endian", where)


def _goes(time: Numbers, sample_rate: float) -> bool:
    with np.errstate(invalid="ignore", over="ignore"):
        step = median_step(time)
    return bool(np.all(np.isfinite(time)) and 0.5 < step * sample_rate < 2.0)


def check_pair(pair: Pair, header: PadHeader, stamps: Stamps, said_rate: float | None) -> tuple[Remark, ...]:
    """Return remarks on small disagreements of a pair.

    Parameters
    ----------
    pair : Pair
        Files.
    header : PadHeader
        Of it.
    stamps : Stamps
        Of its data.
    said_rate : float or None
        Sample rate by flag [Hz], which goes before the header.

    Raises
    ------
    DataError
        ``header_disagrees``: sensor, start, sample rate, or number of records.
    """
    where = str(pair.data)
    remarks = _rate(header, stamps, said_rate, where)
    name = pair.name
    if name is None:
        what = "the name is not that of the archive, START-STOP.SENSOR: it was not compared with header and data"
        return (*remarks, Remark("name_not_archived", "info", what, where))
    if name.sensor.lower() != header.sensor.lower():
        raise _disagrees(f"the name says sensor {name.sensor}, the header {header.sensor}", where)
    late = abs(name.start - header.time_zero)
    if late > SECOND / header.sample_rate + MILLISECOND:
        said = f"the name says {instant_text(name.start)}, TimeZero in the header {instant_text(header.time_zero)}"
        raise _disagrees(f"start of the record: {said}", where)
    _check_records(name.stop, header, stamps, where)
    return (*remarks, *_stops(name.stop, header, stamps, where))


def _rate(header: PadHeader, stamps: Stamps, said: float | None, where: str) -> tuple[Remark, ...]:
    if len(stamps.time_ns) < 2 or rates_agree(stamps, said or header.sample_rate):
        return ()
    by_stamps = f"the stamps of the data say {1.0 / stamps.interval:.6g} Hz" if stamps.interval > 0 else "stamps repeat"
    if said is None:
        raise _disagrees(f"the header says {header.sample_rate:g} Hz, {by_stamps}", where)
    return (Remark("rate_disagrees", "warning", f"{said:.6g} Hz was said, {by_stamps}", where),)


def _check_records(stop: int, header: PadHeader, stamps: Stamps, where: str) -> None:
    """Refuse data that end far from the stop in the name."""
    found = len(stamps.time_ns)
    off = (stamps.end - stop) / SECOND * header.sample_rate
    if abs(off) <= max(2.0, RECORDS * found) + header.sample_rate * (0.001 + stamps.resolution):
        return
    raise DataError(
        f"{found} records end {instant_text(_to_microsecond(stamps.end))}, the name says {instant_text(stop)}: "
        f"{abs(off):.0f} records {'too many' if off > 0 else 'are missing'}",
        where=where,
        why="a file that was cut short loses its end silently",
        do="Fetch it again from the archive",
        code="header_disagrees",
    )


def _stops(stop: int, header: PadHeader, stamps: Stamps, where: str) -> tuple[Remark, ...]:
    """Remark where name, header and data do not end at the same millisecond."""
    ends = {"the name": stop, "the data": stamps.end}
    named = parse_name(header.data_file)
    if named is not None:
        ends["GData in the header"] = named.stop
    if max(ends.values()) - min(ends.values()) <= MILLISECOND + stamps.resolution * SECOND:
        return ()
    said = ", ".join(f"{what} {instant_text(_to_microsecond(end))}" for what, end in ends.items())
    return (Remark("stop_differs", "warning", f"end of the record: {said}", where, do="The data were taken"),)


def _to_microsecond(instant: int) -> int:
    return round(instant / 1000) * 1000


def _disagrees(what: str, where: str) -> DataError:
    return DataError(
        what,
        where=where,
        why="one of them belongs to another record",
        do="Fetch both files of the pair again from the archive",
        code="header_disagrees",
    )
