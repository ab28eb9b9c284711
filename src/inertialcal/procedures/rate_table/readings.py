"""What a rate table works on: dwells at known rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.key import Origin
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ...core.unknowns import Unknowns
from ...signals.segmentation.dwells import Dwell, Tally
from ...signals.time.samples import min_max

if TYPE_CHECKING:
    from .turned import Turned

Labels = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Places(Sequence[str]):
    """Places of the rows of a file, ``"rates.csv:12"``: text is made where it is read."""

    file: str  # As messages call it
    rows: NDArray[np.int64]  # shape (n,): of the file, counted from 1

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, at: int) -> str: ...
    @overload
    def __getitem__(self, at: slice) -> Sequence[str]: ...
    def __getitem__(self, at: int | slice) -> str | Sequence[str]:
        """Return one place, or some."""
        return Places(self.file, self.rows[at]) if isinstance(at, slice) else f"{self.file}:{self.rows[at]}"

    def take(self, keep: NDArray[np.bool_]) -> Places:
        """Return the places for which ``keep`` holds."""
        return Places(self.file, self.rows[keep])


@dataclass(frozen=True, eq=False)
class Readings:
    """Dwells, a row each."""

    applied: Array  # shape (n,): rate of the table [rad/s]
    axis: Labels  # shape (n,): axis that was turned
    outputs: Mapping[str, Array]  # shape (n,): mean reading of each sensor [rad/s]; NaN where it was not read
    # shape (n,): standard deviation of the samples within the dwell [rad/s]; NaN or absent where not given
    scatters: Mapping[str, Array] = field(default_factory=dict[str, Array])
    samples: Array | None = None  # shape (n,): number of samples of a dwell
    group: Labels | None = None  # shape (n,): sample set; empty where not given
    run: Labels | None = None  # shape (n,): power-up; empty where not given
    recording: Labels | None = None  # shape (n,): name of the recording or table that the dwell comes from
    where: Sequence[str] = ()  # Place of each row, for messages
    sensors: tuple[str, ...] = ()  # Axes of all sensors of the unit, read or not
    # shape (n, 3): earth rate along the body axes x, y, z, mean over each dwell [rad/s]; to be added to the
    # table's rate
    earth: Array | None = None
    # shape (s, n, 3): what is not known of it: per source, s independent patterns, each one standard uncertainty
    # [rad/s]
    earth_sources: Mapping[str, Array] = field(default_factory=dict[str, Array])
    # What was taken off the readings before, and what is not known of it, by source
    taken_off: Mapping[Origin, Unknowns] = field(default_factory=dict[Origin, Unknowns])
    remarks: tuple[Remark, ...] = ()  # What reading them brought up
    # shape (n,): dwells of recordings that are not read because too many of their samples are missing, invalid or
    # at the rail
    incomplete: NDArray[np.bool_] | None = None
    tallies: tuple[Tally, ...] = ()  # Where the samples of each recording went, in the order of the recordings
    files: tuple[str, ...] = ()  # Of each recording
    traces: tuple[Trace, ...] = ()  # The recordings that the dwells were cut from, for pictures

    def __len__(self) -> int:
        """Return the number of dwells."""
        return len(self.applied)

    def changed(self, **fields: object) -> Readings:
        """Return the same dwells with other values of some fields that no rate, axis or label is among."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        return found

    def take(self, keep: NDArray[np.bool_]) -> Readings:
        """Return the dwells for which ``keep`` holds; the traces, which are of all dwells, stay behind."""
        if keep.all():
            return self.changed(traces=()) if self.traces else self
        return replace(
            self,
            applied=self.applied[keep],
            axis=self.axis[keep],
            outputs={name: y[keep] for name, y in self.outputs.items()},
            scatters={name: s[keep] for name, s in self.scatters.items()},
            samples=None if self.samples is None else self.samples[keep],
            group=None if self.group is None else self.group[keep],
            run=None if self.run is None else self.run[keep],
            recording=None if self.recording is None else self.recording[keep],
            earth=None if self.earth is None else self.earth[keep],
            earth_sources={name: patterns[:, keep] for name, patterns in self.earth_sources.items()},
            taken_off={name: one.take(keep) for name, one in self.taken_off.items()},
            where=self.where.take(keep)
            if isinstance(self.where, Places)
            else (tuple(self.where[i] for i in np.flatnonzero(keep).tolist()) if self.where else ()),
            incomplete=None if self.incomplete is None else self.incomplete[keep],
            traces=(),
        )

    @cached_property
    def turned(self) -> Turned:
        """What its rates decide, the same for all units that were turned alike."""
        from .turned import turned  # noqa: PLC0415 - solves, which starts slowly

        return turned(self.applied, self.axis, self.run, self.recording)

    @cached_property
    def runs(self) -> int:
        """Number of distinct runs; 0 where none is given."""
        return self.turned.runs


BINS = 600  # a figure has hardly more pixels across


NO_ROW = -1


@dataclass(frozen=True, eq=False)
class TracedDwells:
    """Dwells cut from a recording, by their start."""

    start: Array  # shape (d,): first sample used, since the first sample of the recording [s]
    stop: Array  # shape (d,): last sample used, since the first sample of the recording [s]
    level: Array  # shape (d,): mean reading, nothing subtracted [rad/s]; NaN where no sample is valid
    applied: Array  # shape (d,): rate of the table [rad/s]
    # shape (d,): row in the Readings of the test; -1 where the dwell was taken as reference at rest
    row: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Trace:
    """One recording."""

    recording: str  # Its name
    sensor: str  # Whose level the dwells have: of the axis that was turned, or the first there is
    names: tuple[str, ...]  # Channels [rad/s]
    time: Array  # shape (b,): of each bin, since the first sample [s]
    lo: Array  # shape (b, channels): least value [rad/s]; NaN in a gap
    hi: Array  # shape (b, channels): largest value [rad/s]; NaN in a gap
    dwells: TracedDwells  # What was cut from it

    def shifted(self, rows: int) -> Trace:
        """Return the trace where its readings stand after so many others."""
        row = self.dwells.row
        return replace(self, dwells=replace(self.dwells, row=np.where(row == NO_ROW, NO_ROW, row + rows)))


@dataclass(frozen=True, eq=False)
class Cut:
    """Dwells of a recording with the rate of the table in each [rad/s], shape (d,)."""

    dwells: list[Dwell]
    applied: Array

    def choose(self, keep: NDArray[np.bool_]) -> Cut:
        """Return the dwells for which ``keep`` holds."""
        return Cut([dwell for dwell, kept in zip(self.dwells, keep, strict=True) if kept], self.applied[keep])


def trace(
    recording: str, axis: str, names: Sequence[str], signal: Array, time_ns: Times, kept: Cut, lost: Cut, rest: bool
) -> Trace:
    """Return the trace of a recording.

    Parameters
    ----------
    recording : str
        Its name.
    axis : str
        That was turned.
    names, signal, time_ns
        Channels, their samples [rad/s], shape (n, channels), and stamps [ns].
    kept, lost : Cut
        Dwells that became rows, in order, and those that follow as rows without a reading.
    rest : bool
        Dwells of ``kept`` at rest were subtracted and are no rows.
    """
    bins = min_max(signal, time_ns, BINS)
    sensor = axis if axis in names else names[0]
    moving = kept.applied != 0.0 if rest else np.ones(len(kept.dwells), dtype=bool)
    row = np.where(moving, np.cumsum(moving) - 1, NO_ROW)
    row = np.concatenate([row, np.count_nonzero(moving) + np.arange(len(lost.dwells))]).astype(np.int64)
    # Put the dwells in order of time; one that has no mean of the sensors has no level
    dwells = [*kept.dwells, *lost.dwells]
    order = np.argsort([dwell.start for dwell in dwells], kind="stable")
    seconds = (time_ns - time_ns[0]) / SECOND
    level = [float(dwell.mean[names.index(sensor)]) if len(dwell.mean) == len(names) else np.nan for dwell in dwells]
    found = TracedDwells(
        seconds[[dwell.start for dwell in dwells]][order],
        seconds[[dwell.stop - 1 for dwell in dwells]][order],
        np.array(level)[order],
        np.concatenate([kept.applied, lost.applied])[order],
        row[order],
    )
    return Trace(recording, sensor, tuple(names), bins.time, bins.lo, bins.hi, found)
