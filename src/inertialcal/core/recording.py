"""Recording: one clock, any number of channels.

Time is int64 nanoseconds, UTC (since 1970-01-01) or elapsed since an origin that the source names. A
stamp means the middle of its averaging window. The sample interval and the averaging time are both kept,
because they differ where there is dead time: 1 s averages saved every 2 s. Channels of different clocks
are different Recordings. Channels keep the type they were stored in: counts stay integers.
"""

from __future__ import annotations

import _thread
import atexit
import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from .batches import batches, changed, columns, count, extremes, is_stored, made
from .errors import DataError
from .estimate import Array
from .remarks import Remark
from .show.result_tables import remarks_line
from .show.rounding import number
from .show.tables import Block, Table, ending, html, text
from .unit.magnitudes import check_sample_rate

Times = NDArray[np.int64]
COMPENSATED = "compensated_by_"  # starts the name of the column by which a file says so; a model's checksum ends it
MARK = 12  # characters of that checksum
SECOND = 1_000_000_000  # [ns]


@dataclass(frozen=True, eq=False)
class Channel:
    """One column of a recording."""

    name: str  # As the file has it
    data: NDArray[Any]  # shape (n,): in the type of the file; floats may hold NaN where a cell was empty
    unit: str | None = None  # As ``core.units`` prints it; None when nobody said
    unit_from: str = ""  # Where the unit comes from: ``"flag"``, ``"header"``, ``"format"``, ``"campaign"`` or ``""``
    axis: str = ""  # ``"x"``, ``"y"``, ``"z"``, or ``""``
    # What it measures as far as the header tells: ``"gyro"``, ``"acc"``, ``"temperature"``, ... or ``""``.
    quantity: str = ""

    def changed(self, **fields: object) -> Channel:
        """Return it with other values of some fields; ``dataclasses.replace`` takes several times as long."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        return found


class Digest:
    """A SHA-256 that a thread works out: who asks for it waits until it is there, and gets the error if there was one.

    A process neither ends nor becomes two while a thread works on one.

    Parameters
    ----------
    work : callable
        Returns it.
    """

    _pending: ClassVar[set[Digest]] = set()

    def __init__(self, work: Callable[[], str]) -> None:
        self._left = [work]  # until it begins
        self._found: Future[str] = Future()

    def begin(self) -> None:
        """Let a thread begin, where none has.

        A thread of the library waits until the new one runs, which on a busy machine takes as long as its work.
        """
        try:
            work = self._left.pop()
        except IndexError:
            return
        self._pending.add(self)
        try:
            _thread.start_new_thread(self._run, (work,))
        except RuntimeError:  # no more threads
            self._run(work)

    def _run(self, work: Callable[[], str]) -> None:
        try:
            self._found.set_result(work())
        except BaseException as error:
            self._found.set_exception(error)
        finally:
            self._pending.discard(self)

    def result(self) -> str:
        """Return it; Raises what working it out raised."""
        self.begin()
        return self._found.result()

    @classmethod
    def finish(cls) -> None:
        """Wait for all that threads work on."""
        for one in tuple(cls._pending):
            one._found.exception()


atexit.register(Digest.finish)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=Digest.finish)


class _Sha256:
    """A field that holds a SHA-256 or who works it out, and gives the SHA-256."""

    def __get__(self, source: Source | None, kind: type[Source]) -> str:
        if source is None:
            return ""  # the default
        held: str | Digest = vars(source)["sha256"]
        return held if isinstance(held, str) else held.result()

    def __set__(self, source: Source, value: str | Digest) -> None:
        vars(source)["sha256"] = value


@dataclass(frozen=True)
class Source:
    """Where a recording was read from: path as given, SHA-256 of its bytes, format in words, name of the reader.

    The SHA-256 may be a `Digest`: it is waited for when it is first asked for.
    """

    path: str = ""
    sha256: _Sha256 = _Sha256()
    format: str = ""
    reader: str = ""

    def __getstate__(self) -> dict[str, str]:
        """Return the fields, for a copy in another process."""
        return vars(self) | {"sha256": self.sha256}


@dataclass(frozen=True)
class ClockRate:
    """How well the rate at which stamps run is known, where who recorded them found that out."""

    u: float  # Standard uncertainty, relative [1]
    dof: float = math.inf  # Its degrees of freedom
    source: str = ""  # Which clock, and when


@dataclass(frozen=True, eq=False)
class Recording:
    """Channels on one clock.

    Raises
    ------
    DataError
        If channels differ in length, share a name, or the time does not fit.
    """

    channels: tuple[Channel, ...]  # All of one length n
    time_ns: Times | None = None  # shape (n,): middle of each averaging window [ns]; None where the file has no time
    sample_interval: float | None = None  # Nominal time from sample to sample [s]
    averaging_time: float | None = None  # Length of the window that a sample is the mean of [s]; None when nobody said
    epoch: Literal["utc", "elapsed"] = "elapsed"  # What time zero is
    interval_from: Literal["column", "flag", "header", ""] = ""  # Where the sample interval comes from
    source: Source = field(default_factory=Source)  # File, hash, format
    remarks: tuple[Remark, ...] = ()  # What reading it brought up
    first_row: int = 0  # Row of the source (counted from 1) of sample 0, for messages; 0 when rows have no meaning
    # Corrections that the source says were made already: ``"bias"``, ``"scale_factor"``, ``"misalignment"``
    applied: tuple[str, ...] = ()
    time_column: str = ""  # Name of the column whose stamps give the sample interval; empty where they do not
    compensated_by: str = ""  # First 12 digits of the checksum of the model that was applied; empty for readings
    cut_off: float | None = None  # Of the low pass before the samples were taken [Hz]; None when nobody said
    clock: ClockRate | None = None  # Of its stamps; None when nobody said

    def __post_init__(self) -> None:
        names = [channel.name for channel in self.channels]
        if len(set(names)) != len(names):
            twice = sorted({name for name in names if names.count(name) > 1})
            raise DataError(f"channel {', '.join(twice)} appears twice", where=self.source.path)
        if self.sample_interval and (wrong := check_sample_rate(1.0 / self.sample_interval)):
            raise DataError(wrong, self.source.path, do="Correct the rate or the time stamps", code="sample_rate")
        lengths = {channel.data.shape for channel in self.channels}
        if self.time_ns is not None:
            lengths.add(self.time_ns.shape)
            if self.time_ns.dtype != np.int64:
                raise DataError(f"time of type {self.time_ns.dtype}, need int64 ns", where=self.source.path)
        if len(lengths) > 1:
            raise DataError(f"channels of different length: {sorted(lengths)}", where=self.source.path)
        if any(len(shape) != 1 for shape in lengths):
            raise DataError(f"channels of shape {lengths.pop()}, need (n,)", where=self.source.path)

    def __len__(self) -> int:
        """Return the number of samples."""
        if self.time_ns is not None:
            return len(self.time_ns)
        return len(self.channels[0].data) if self.channels else 0

    def changed(self, **fields: object) -> Recording:
        """Return it with other values of some fields, which are not checked: as long as the others, named once."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        return found

    @property
    def interval_origin(self) -> str:
        """Where the sample interval comes from, in words; empty where that is not known."""
        return f"time column {self.time_column!r}" if self.interval_from == "column" else self.interval_from

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels, in order."""
        return tuple(channel.name for channel in self.channels)

    def place(self, index: int) -> str:
        """``file:row`` of a sample, or its number where rows have no meaning."""
        path = self.source.path
        if path and self.first_row:
            return f"{path}:{self.first_row + index}"
        return f"{path}: sample {index + 1}" if path else f"sample {index + 1}"

    def channel(self, name: str) -> Channel:
        """One channel by name.

        Raises
        ------
        DataError
            If there is none of that name; the message lists those there are.
        """
        for channel in self.channels:
            if channel.name == name:
                return channel
        raise DataError(
            f"no column {name!r}",
            where=self.source.path,
            do=f"The file has: {', '.join(self.names) or 'none'}",
            code="wrong_column",
        )

    def array(self, names: Sequence[str] | None = None) -> Array:
        """Channels stacked time-first, as float64.

        Parameters
        ----------
        names : sequence of str, optional
            Which; all by default.

        Returns
        -------
        ndarray, shape (n, channels)
            In the unit of each channel.

        Raises
        ------
        DataError
            If a name is not there, or a channel holds text.
        """
        chosen = self.channels if names is None else tuple(self.channel(name) for name in names)
        room = columns(len(self), len(chosen))
        stacked = room if is_stored(room) else np.empty(room.shape)
        for column, channel in enumerate(chosen):
            try:
                for first, stop in batches(stacked[:, column], channel.data):
                    stacked[first:stop, column] = channel.data[first:stop]
            except ValueError:
                what = f"column {channel.name!r} holds {channel.data.dtype} that are not all numbers"
                raise DataError(what, where=self.source.path, code="wrong_column") from None
        return stacked

    @property
    def stamps(self) -> Times | None:
        """Time of each sample [ns], shape (n,): without stamps counted by the sample interval; None without either."""
        if self.time_ns is not None or not self.sample_interval:
            return self.time_ns
        step = self.sample_interval * SECOND
        return made(len(self), np.int64, lambda first, stop: np.rint(np.arange(first, stop) * step))

    @property
    def seconds(self) -> Array | None:
        """Time since the first sample [s], shape (n,); None where the file has no time."""
        if self.time_ns is None or not len(self.time_ns):
            return None
        start = self.time_ns[0]
        elapsed: Array = changed(self.time_ns, lambda part: (part - start).astype(np.float64) / SECOND)
        return elapsed

    @property
    def sample_rate(self) -> float | None:
        """Nominal sampling frequency [Hz]."""
        return 1.0 / self.sample_interval if self.sample_interval else None

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: source and clock, a row a channel, how many remarks."""
        heads = ("channel", "axis", "quantity", "unit", "type", "min", "max", "missing")
        rows = [_cells(channel) for channel in self.channels]
        path = ending(self.source.path) or "recording"
        kind = f" ({self.source.format})" if self.source.format else ""
        grid = Table(heads, rows, f"{path}{kind}: {len(self)} samples, {len(rows)} channel(s)", (5, 6, 7))
        compensated = (f"compensated by model {self.compensated_by}",) if self.compensated_by else ()
        return (grid, _clock(self), *compensated, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return a table with a row a channel."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the same table for a notebook."""
        return html(self.parts())

    def with_unit(self, names: Sequence[str], unit: str, unit_from: str) -> Recording:
        """Return the recording with a unit said for some channels (their numbers stay as they are)."""
        wanted = {self.channel(name).name for name in names}
        channels = tuple(replace(c, unit=unit, unit_from=unit_from) if c.name in wanted else c for c in self.channels)
        return replace(self, channels=channels)


def _cells(channel: Channel) -> tuple[str, ...]:
    said = (channel.name, channel.axis, channel.quantity, channel.unit or "?", str(channel.data.dtype))
    if channel.data.dtype.kind not in "biuf":
        return (*said, "-", "-", "-")
    there = count(channel.data, np.isfinite)
    ends = extremes(channel.data, infinite=False) if there else (None, None)
    return (*said, number(ends[0]), number(ends[1]), str(len(channel.data) - there))


def _clock(recording: Recording) -> str:
    """Return one line on rate, averaging and span."""
    said = []
    if recording.sample_rate is not None:
        origin = f" ({recording.interval_origin})" if recording.interval_from else ""
        said.append(f"{number(recording.sample_rate)} Hz{origin}")
    if recording.averaging_time is not None:
        said.append(f"each the mean of {number(recording.averaging_time)} s")
    if recording.seconds is not None and recording.time_ns is not None:
        said.append(f"{number(recording.seconds[-1])} s from {_instant(recording)}")
    return f"time: {'; '.join(said) or 'none'}"


def _instant(recording: Recording) -> str:
    first = int(recording.time_ns[0]) if recording.time_ns is not None else 0
    if recording.epoch == "utc":
        return f"{np.datetime64(first, 'ns').astype('datetime64[ms]')}Z"
    return f"{number(first / SECOND)} s"
