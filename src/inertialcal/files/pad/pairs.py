"""Pairs of data file and header that a path means: either member, or a folder of the archive.

A path is such a pair if its name has the archive's form, if it is a header (by its ending, or by its bytes: XML whose
root is named after an acceleration system), or if a header lies beside it. In a folder all pairs count; where it
holds none, the folders of the archive's tree below it (``year2014/month10/day22/sams2_accel_121f03``) are gone through.

Axes are those that the header says the data are in, or those of the sensor itself.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ...core.batches import batches
from ...core.errors import DataError, UsageError
from ...core.estimate import Array, Numbers
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.times import instant_text, read_instant
from ...physics.attitude import between
from ..info.describe import WRONG_BY
from ..source import read_bytes
from .header import PadHeader, Stamps, median_step, rates_agree, read_header

ROOT = re.compile(rb"\s*(?:<\?xml[^>]*>)?\s*<(?:\w+_accel|iss_rad)[\w.-]*[\s>]")
START = 512  # bytes of a file in which the root stands
TREE = re.compile(r"year\d{4}|month\d{2}|day\d{2}|(?:\w+_accel|iss_rad)_\w+", re.ASCII)
NAMED = re.compile(rb'<GData[^>]*\bfile\s*=\s*"([^"/\\]+)"')


def pairs_of(path: str | Path) -> tuple[Pair, ...]:
    """Return the pairs that a path means; none where it is no acceleration file of the archive.

    Raises
    ------
    DataError
        ``missing_header`` or ``missing_data``, if one member of a pair is not there.
    """
    given = Path(path)
    try:
        if given.is_dir():
            return tuple(_whole(pair, str(path)) for pair in _in_folder(given))
        pair = _pair(given)
    except (OSError, ValueError):  # ValueError: a nul in the name; the reader of bytes says it
        return ()
    return () if pair is None else (_whole(pair, str(path)),)


def _in_folder(folder: Path) -> list[Pair]:
    """Pairs of a folder, else of those below it that the archive's tree has."""
    inside = sorted(folder.iterdir())
    names = {path.name for path in inside}
    data = {
        path.name.removesuffix(HEADER)
        for path in inside
        if not path.name.startswith(".") and path.is_file() and _belongs(path.name, names)
    }
    if data:
        return [Pair(folder / name, folder / (name + HEADER)) for name in sorted(data)]
    below = [path for path in inside if path.is_dir() and TREE.fullmatch(path.name)]
    return [pair for path in below for pair in _in_folder(path)]


def _belongs(name: str, names: set[str]) -> bool:
    return parse_name(name) is not None or (name.endswith(HEADER) and name.removesuffix(HEADER) in names)


def _pair(path: Path) -> Pair | None:
    if path.name.endswith(HEADER):
        data = path.with_name(path.name.removesuffix(HEADER))
        return Pair(data, path) if data.exists() or parse_name(path.name) or _has_root(path) else None
    if parse_name(path.name) or path.with_name(path.name + HEADER).is_file():
        return Pair(path, path.with_name(path.name + HEADER))
    if not path.is_file() or not _has_root(path):
        return None
    named = NAMED.search(read_bytes(path, 2**16))  # a header by another name says where its data lie
    return Pair(path.with_name(named[1].decode("ascii", "replace")), path) if named else None


def _has_root(path: Path) -> bool:
    return ROOT.match(read_bytes(path, START)) is not None


def _whole(pair: Pair, given: str) -> Pair:
    """Refuse a pair that lacks a member."""
    if not pair.data.is_file() and not pair.header.is_file():
        raise DataError("no such file", where=given, do="Check the name and the folder", code="missing_file")
    if not pair.header.is_file():
        raise DataError(
            f"its header is missing: {pair.header.name}",
            where=str(pair.data),
            why="the header gives start, sample rate and layout of the data",
            do="Fetch both files of the pair from the archive",
            code="missing_header",
        )
    if not pair.data.is_file():
        raise DataError(
            f"the data file of this header is missing: {pair.data.name}",
            where=str(pair.header),
            do="Fetch both files of the pair from the archive",
            code="missing_data",
        )
    return pair


HEADER = ".header"
STAMP = r"[0-9]{4}(?:_[0-9]{2}){5}(?:\.[0-9]{1,9})?"
NAME = re.compile(rf"(?P<start>{STAMP})(?P<sign>[+-])(?P<stop>{STAMP})\.(?P<sensor>[A-Za-z0-9_]+)")


@dataclass(frozen=True)
class PadName:
    """What the name of a data file says."""

    start: int  # First sample [ns since 1970 UTC]
    stop: int  # Last sample [ns since 1970 UTC]
    contiguous: bool  # Whether the file goes on where the one before it ended
    sensor: str  # Behind the last dot


def parse_name(name: str) -> PadName | None:
    """Return what a file's name says; None where it is not of the archive's form, or names no possible time."""
    match = NAME.fullmatch(name.removesuffix(HEADER))
    if match is None:
        return None
    try:
        start, stop = read_instant(match["start"]), read_instant(match["stop"])
    except ValueError:
        return None
    return PadName(start, stop, match["sign"] == "+", match["sensor"])


@dataclass(frozen=True)
class Pair:
    """A data file and its header."""

    data: Path
    header: Path

    @property
    def name(self) -> PadName | None:
        """What the name says; None where it is not of the archive's form."""
        return parse_name(self.data.name)


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
        what = "the name is not START-STOP.SENSOR, as in the archive: not compared with header and data"
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
    far = stamps.interval > 0 and max(said * stamps.interval, 1.0 / (said * stamps.interval)) >= WRONG_BY
    what = f"{said:.6g} Hz was given, {by_stamps}"
    return (
        Remark("sample_rate_disagrees", "error" if far else "warning", what, where, do="Leave the sample rate out"),
    )


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
        why="a truncated file loses its end silently",
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
    return (Remark("stop_differs", "warning", f"end of the record: {said}", where, do="The data were used"),)


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


Frame = Literal["data", "sensor"]
FRAMES = ("data", "sensor")
SAME = 1e-9  # of the elements of a matrix, from which two systems have the same axes
BLOCK = 2**18  # samples


def check_frame(frame: str | None) -> None:
    """Refuse a word that names no coordinate system.

    Raises
    ------
    UsageError
        ``wrong_frame``.
    """
    if frame is not None and frame not in FRAMES:
        raise UsageError(f"frame {frame!r}", do=f"Say one of: {', '.join(FRAMES)}", code="wrong_frame")


def C_sensor_data(header: PadHeader) -> Array | None:
    """Return the matrix that takes components in data axes to those of the sensor; None where axes are not said."""
    if header.sensor_system is None or header.data_system is None:
        return None
    return between(header.sensor_system.C_station_system, header.data_system.C_station_system)


def turned(
    values: list[Numbers], header: PadHeader, frame: str | None, where: str
) -> tuple[list[Numbers], tuple[Remark, ...]]:
    """Return the columns with the first three in the axes asked for, in the type that they had.

    Parameters
    ----------
    values : list of ndarray, shape (n,)
        In data axes; changed in place.
    header : PadHeader
        Which says both coordinate systems.
    frame : {"data", "sensor"} or None
        None is as the data are.
    where : str
        File, for messages.

    Raises
    ------
    DataError
        ``no_frames``, if sensor axes are asked for and the header does not say them.
    """
    C = C_sensor_data(header)
    if C is None and frame == "sensor":
        raise DataError(
            "sensor axes requested, but the header gives no coordinate systems",
            where=where,
            do="Read it without --frame",
            code="no_frames",
        )
    if C is None or np.abs(C - np.eye(3)).max() < SAME:
        return values, ()
    if frame != "sensor":
        what = f"x, y, z are the axes of {header.data_system}, not those of the sensor {header.sensor_system}"
        do = "For sensor axes, in which its bias and scale factor are defined, add --frame sensor"
        return values, (Remark("not_sensor_axes", "info", what, where, do=do),)
    for first, stop in batches(*values[:3], size=BLOCK):
        part = slice(first, stop)
        vectors = [column[part].astype(np.float64) for column in values[:3]]
        with np.errstate(invalid="ignore", over="ignore"):  # a sample that is not finite is missing on all axes
            for axis in range(3):
                turned_part = C[axis, 0] * vectors[0]
                for other in (1, 2):
                    turned_part += C[axis, other] * vectors[other]
                values[axis][part] = turned_part
    what = f"x, y, z turned from {header.data_system} to the axes of the sensor {header.sensor_system}"
    return values, (Remark("turned_to_sensor_axes", "info", what, where),)


def sensor_frame(path: str | Path) -> Frame | None:
    """Return ``"sensor"`` for archive records whose axes are not those of their sensor, by the headers alone.

    None for all others, and where a header does not say both systems.

    Raises
    ------
    DataError
        If a header is missing or damaged.
    """
    turns = [C_sensor_data(read_header(pair.header)) for pair in pairs_of(path)]
    known = [C for C in turns if C is not None]
    differ = any(np.abs(C - np.eye(3)).max() >= SAME for C in known)
    return "sensor" if differ and len(known) == len(turns) else None
