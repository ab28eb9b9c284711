"""Trace of a recording: what a picture of it shows, small enough to be kept with the readings.

Channels are decimated by least and largest value per bin. A dwell that became a row of the Readings knows which
(``row``); one at rest that was subtracted, as ``zero_reference`` asks, has no row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.recording import SECOND, Times
from ...signals.segmentation.dwells import Dwell
from ...signals.time.samples import min_max

BINS = 600  # a figure has hardly more pixels across
NO_ROW = -1


@dataclass(frozen=True, eq=False)
class TracedDwells:
    """Dwells cut from a recording, by their start.

    Parameters
    ----------
    start, stop : ndarray, shape (d,)
        First and last sample used, since the first sample of the recording [s].
    level : ndarray, shape (d,)
        Mean reading, nothing subtracted [rad/s]; NaN where no sample is valid.
    applied : ndarray, shape (d,)
        Rate of the table [rad/s].
    row : ndarray of int, shape (d,)
        Row in the Readings of the test; -1 where the dwell was taken as reference at rest.
    """

    start: Array
    stop: Array
    level: Array
    applied: Array
    row: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Trace:
    """One recording.

    Parameters
    ----------
    recording : str
        Its name.
    sensor : str
        Whose level the dwells have: of the axis that was turned, or the first there is.
    names : tuple of str
        Channels [rad/s].
    time : ndarray, shape (b,)
        Of each bin, since the first sample [s].
    lo, hi : ndarray, shape (b, channels)
        Least and largest value [rad/s]; NaN in a gap.
    dwells : TracedDwells
        What was cut from it.
    """

    recording: str
    sensor: str
    names: tuple[str, ...]
    time: Array
    lo: Array
    hi: Array
    dwells: TracedDwells

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
    found = _dwells(kept, lost, row, time_ns, names.index(sensor), len(names))
    return Trace(recording, sensor, tuple(names), bins.time, bins.lo, bins.hi, found)


def _dwells(kept: Cut, lost: Cut, row: NDArray[np.int64], time_ns: Times, column: int, columns: int) -> TracedDwells:
    """Put the dwells in order of time; one that has no mean of the sensors has no level."""
    dwells = [*kept.dwells, *lost.dwells]
    order = np.argsort([dwell.start for dwell in dwells], kind="stable")
    seconds = (time_ns - time_ns[0]) / SECOND
    level = [float(dwell.mean[column]) if len(dwell.mean) == columns else np.nan for dwell in dwells]
    return TracedDwells(
        seconds[[dwell.start for dwell in dwells]][order],
        seconds[[dwell.stop - 1 for dwell in dwells]][order],
        np.array(level)[order],
        np.concatenate([kept.applied, lost.applied])[order],
        row[order],
    )
