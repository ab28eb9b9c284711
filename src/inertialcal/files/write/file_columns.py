"""A recording as the columns of a file: time first, titles that read back, numbers in plain types."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...core import units
from ...core.batches import batches, changed, every, extremes, made
from ...core.errors import DataError, InertialcalError
from ...core.estimate import Numbers
from ...core.recording import COMPENSATED, SECOND, Channel, Recording, Times
from ...core.remarks import Remark
from ..columns import Column, Content
from ..info.describe import Described, describe
from ..text.headers import bare_name, heading
from ..time.clock import find_clock
from ..time.stamps import EARLIEST, LATEST, beyond_epoch, is_utc, to_ns

if TYPE_CHECKING:
    from pyarrow import Array as ArrowArray


Instants = Literal["all", "tellable", "none"]  # that a format has: of any year, of 1700 to 2199, or none


def file_columns(
    recording: Recording, in_names: bool, instants: Instants = "all", legal: Callable[[str], str] = str
) -> tuple[tuple[Column, ...], tuple[Remark, ...]]:
    """Return the columns of a file, and remarks on their names.

    Parameters
    ----------
    recording : Recording
        What to write.
    in_names : bool
        Whether the unit of a column has no other place than its name.
    instants : {"all", "tellable", "none"}
        Instants that the format has.
    legal : callable
        What the format makes of a name; empty where nothing is left of it.

    Raises
    ------
    DataError
        ``time_not_writable``, if the stamps have no form that reads back, or something else would read as time.
    """
    titles, remarks = channel_titles(recording, in_names, legal)
    columns = [
        Column(title.name, plain_numbers(channel.data), title.unit)
        for title, channel in zip(titles, recording.channels, strict=True)
    ]
    if recording.compensated_by:
        mark = made(len(recording), np.uint8, lambda first, stop: np.ones(stop - first, dtype=np.uint8))
        columns.append(Column(legal(f"{COMPENSATED}{recording.compensated_by}"), mark))
    time = time_column(recording, in_names, instants, legal)
    found = (*([] if time is None else [time]), *columns)
    if len(recording):
        _check_clock(found, recording)
    return found, remarks


def _check_clock(columns: tuple[Column, ...], recording: Recording) -> None:
    """Refuse columns of which the reader would take another one for the time."""
    described, _ = describe(columns, {}, "")
    expected = None if recording.time_ns is None else 0
    try:
        taken = find_clock(described, Content(columns, ""), "").column
        reads = (
            f"{columns[taken].name!r} would be mistaken for the time" if taken is not None else "there would be no time"
        )
    except InertialcalError as error:
        taken, reads = -1, error.problems[0].what
    if taken != expected:
        raise DataError(
            f"the time of the recording would not read back: {reads}",
            where=recording.source.path,
            do="Rename that column, or sort the rows by time",
            code="time_not_writable",
        )


def plain_numbers(data: NDArray[Any]) -> NDArray[Any]:
    """Return numbers in the byte order of the machine; truth values as 0 and 1, as they are read."""
    if data.dtype.kind == "b":
        return data.astype(np.uint8)
    return np.ascontiguousarray(data, dtype=data.dtype.newbyteorder("="))


def arrow_array(values: NDArray[Any]) -> ArrowArray:
    """Return a column for Arrow: NaN as null, instants in UTC."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    if values.dtype.kind == "M":
        return pa.array(values.astype(np.int64), pa.timestamp("ns", tz="UTC"))
    return pa.array(values, from_pandas=True)


def stated_rate(recording: Recording) -> float | None:
    """Return the sample rate [Hz] where the stamps do not tell it: it was said, or there is no time.

    The interval that is read back from it may differ in the last bit.
    """
    if recording.interval_from == "column":
        return None
    return recording.sample_rate


@dataclass(frozen=True)
class Title:
    """What a file holds of a column: its name, and its unit where the format has a place for it."""

    name: str
    unit: str | None = None


def channel_titles(
    recording: Recording, in_names: bool, legal: Callable[[str], str] = str
) -> tuple[tuple[Title, ...], tuple[Remark, ...]]:
    """Return a title for each channel, and remarks on those that are not what the channel is called.

    Parameters
    ----------
    recording : Recording
        Whose channels are to be written.
    in_names : bool
        Whether the unit has no other place than the name.
    legal : callable
        What the format makes of a name.
    """
    titles: list[Title] = []
    remarks: list[Remark] = []
    for number, given in enumerate(recording.channels, start=1):
        channel = replace(given, unit=_as_printed(given.unit))
        taken = {title.name for title in titles} | {name for name in recording.names if name != channel.name}
        title = _title(channel, number, taken, in_names, legal)
        titles.append(title)
        remarks += _remarks(channel, title)
    return tuple(titles), tuple(remarks)


def _as_printed(unit: str | None) -> str | None:
    """Return the spelling that is read back: channels made in memory have any."""
    try:
        return units.normalise(unit) if unit else unit
    except InertialcalError:
        return unit


def spelled(name: str, unit: str | None, in_names: bool) -> Iterator[Title]:
    """Yield the ways to write a name and a unit, the plainest first."""
    if in_names:
        yield Title(name)
        bare = bare_name(name)
        yield Title(f"{bare} [{unit}]" if unit else bare)
    else:
        yield Title(name, unit)
        yield Title(name, unit or "")  # an empty unit in the metadata: none, whatever the name says


def read_back(title: Title, values: Channel | Column) -> Described:
    """Return what the reader makes of a column with this title."""
    data = values.data if isinstance(values, Channel) else values.values
    return describe([Column(title.name, data, title.unit)], {}, "")[0][0]


def _title(channel: Channel, number: int, taken: set[str], in_names: bool, legal: Callable[[str], str]) -> Title:
    own, plain = legal(channel.name.strip()), f"channel_{number}"
    by_kind = [f"{channel.quantity}_{channel.axis}"] if channel.quantity and channel.axis else []
    for name in [*by_kind, own, plain] if contradicts(own, channel.unit) else [own, *by_kind, plain]:
        for title in spelled(name, channel.unit, in_names):
            usable = title.name and title.name.isprintable() and title.name not in taken
            if usable and read_back(title, channel).unit == channel.unit:
                return title
    while plain in taken:
        plain += "_"
    return Title(plain, None if in_names else channel.unit)


def contradicts(name: str, unit: str | None) -> bool:
    """Whether the end of a name says another unit: ``gyro_x_mv`` in deg/s."""
    return heading(bare_name(name)).unit not in {None, unit}


def _remarks(channel: Channel, title: Title) -> Iterator[Remark]:
    found = read_back(title, channel)
    if bare_name(title.name) not in {bare_name(channel.name), channel.name.strip()}:
        what = f"column {channel.name!r} is written as {title.name!r}: its own name does not fit its unit or the format"
        yield Remark("column_renamed", "warning", what, subject=channel.name)
    if found.unit != channel.unit:
        what = f"the unit of {channel.name!r}, {channel.unit or 'none'}, cannot be written in a form that reads back"
        yield Remark("unit_not_kept", "warning", what, do="Write Parquet", subject=channel.name)


PLAIN = "time"
EXACT = 2**53  # whole numbers up to here are floats without rounding


def time_column(
    recording: Recording, in_names: bool, instants: Instants = "all", legal: Callable[[str], str] = str
) -> Column | None:
    """Return the time of a recording as a column; None where it has none.

    Parameters
    ----------
    recording : Recording
        Whose time is to be written.
    in_names : bool
        Whether the unit has no other place than the name.
    instants : {"all", "tellable", "none"}
        Instants that the format has.
    legal : callable
        What the format makes of a name.

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
    name = legal(time_name(recording)) or PLAIN
    for values, unit in _forms(recording, recording.time_ns, name, instants):
        for title in _titles(recording, name, unit, values, in_names):
            return Column(title.name, values, title.unit)
    raise DataError(
        f"the stamps ({recording.epoch}) cannot be written in a form that reads back",
        where=recording.source.path,
        why="elapsed time beyond 31 years reads as UTC, and text holds instants of 1700 to 2199",
        do="Use another unit of time, or write Parquet",
        code="time_not_writable",
    )


def time_name(recording: Recording) -> str:
    """Return the name of the column that the time came from, ``"time"`` where that is not known."""
    name = recording.time_column.strip()
    return name if name.isprintable() and name not in {"", *recording.names} else PLAIN


def _forms(recording: Recording, time_ns: Times, name: str, instants: Instants) -> Iterator[tuple[Numbers, str]]:
    """Yield the numbers or instants that read back, the form of the name first; instants have no unit."""
    said = heading(name).unit
    by_name = said if said is not None and units.kind(said) == "time" else None
    utc = recording.epoch == "utc"
    instant = utc and (instants == "all" or (instants == "tellable" and _tellable(time_ns)))
    for unit in dict.fromkeys([by_name or ("" if instant else "s"), "" if instant else "s", "ns"]):
        if not unit:
            yield time_ns.view("datetime64[ns]"), ""
            continue
        values = numbers(time_ns, unit)
        if _keeps(values, unit, time_ns, utc):
            yield values, unit


def numbers(time_ns: Times, unit: str) -> Numbers:
    """Return stamps [ns] in a unit of time: int64 where all are whole, else the nearest floats."""
    per_unit = units.factor(unit, "s") * SECOND
    size = int(per_unit)
    if size != per_unit or size < 1:
        return changed(time_ns, lambda part: part / per_unit)
    if every(time_ns, lambda part: not np.any(part % size)):
        return changed(time_ns, lambda part: part // size, np.int64)
    if max(map(abs, extremes(time_ns))) < EXACT:
        return changed(time_ns, lambda part: part / float(size))
    return changed(time_ns, lambda part: part // size + part % size / float(size))


def _keeps(values: Numbers, unit: str, time_ns: Times, utc: bool) -> bool:
    if unit == "s" and len(beyond_epoch(values)):
        return False
    again = to_ns(values, unit)
    if again is None or is_utc(again) != utc:
        return False
    return all(np.array_equal(again[first:stop], time_ns[first:stop]) for first, stop in batches(again, time_ns))


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
