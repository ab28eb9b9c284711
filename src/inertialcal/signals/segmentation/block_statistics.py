"""A long record as statistics of short blocks of time: mean, variance, least and largest value, each sample seen once.

Blocks are of equal length in time and begin with the first sample; a block without a sample is not there, so a gap
costs nothing.

Channels may be of any type and are not copied: a day of three axes at 250 samples a second stays as large as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Numbers
from ...core.recording import SECOND, Times
from ..time.samples import Flags, Indices
from ..time.time_axis import AGAIN, backward_steps

FULL = 0.5  # part of the usual number of samples from which a block counts

Signal = Numbers | Sequence[Numbers]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of a record that hold samples."""

    # first, stop: samples of each block, half-open, shape (b,)
    first: Indices
    stop: Indices
    at: Indices  # which block of time it is, counted from 0 at the first sample, ascending, shape (b,)
    start_ns: int  # where block 0 begins [ns]
    length_ns: int  # of a block [ns]
    # mean, variance, lo, hi: of the finite samples, the variance with n - 1 [unit of the signal, or its square]; NaN
    # where too few, shape (b, channels)
    mean: Array
    variance: Array
    lo: Array
    hi: Array
    count: NDArray[np.int64]  # finite samples, shape (b, channels)

    def __len__(self) -> int:
        return len(self.first)

    @property
    def length(self) -> float:
        """Of a block [s]."""
        return self.length_ns / SECOND

    @property
    def time_ns(self) -> Times:
        """Middle of each block, shape (b,) [ns]."""
        return self.start_ns + self.at * self.length_ns + self.length_ns // 2

    @property
    def full(self) -> Flags:
        """Blocks with at least half of the usual number of samples in every channel, shape (b,)."""
        fewest = self.count.min(axis=1)
        return np.asarray(fewest >= max(2.0, FULL * float(np.median(fewest))))

    def of(self, channels: Sequence[bool]) -> Blocks:
        """Return the same blocks of some channels.

        Parameters
        ----------
        channels : sequence of bool, shape (channels,)
            Which.

        Raises
        ------
        DataError
            If none is left.
        """
        chosen = np.asarray(channels, dtype=bool)
        if not chosen.any():
            raise DataError("no channels left")
        parts = {name: getattr(self, name)[:, chosen] for name in ("mean", "variance", "lo", "hi", "count")}
        return replace(self, **parts)


def block_statistics(
    signal: Signal, length: float, time_ns: Times | None = None, sample_interval: float | None = None
) -> Blocks:
    """Return the statistics of the blocks of a record.

    Parameters
    ----------
    signal : ndarray, shape (n,) or (n, channels), or a sequence of ndarray, shape (n,)
        Of any type of number; a value that is not finite is left out.
    length : float
        Of a block [s].
    time_ns : ndarray of int64, shape (n,), optional
        Stamps, not descending [ns].
    sample_interval : float, optional
        From sample to sample [s], where there are no stamps.

    Raises
    ------
    DataError
        If the shapes do not fit, there is no sample, or time runs backwards.
    PlanError
        If a block is not longer than no time, or there are neither stamps nor an interval.
    """
    channels = columns(signal)
    n = len(channels[0])
    if not length * SECOND >= 1.0:
        raise PlanError(f"blocks of {length:g} s, need a positive length")
    if time_ns is None:
        if not (sample_interval and sample_interval > 0.0):
            raise PlanError("no time and no sample interval", do="Give time_ns or sample_interval")
        time_ns = np.rint(np.arange(n) * (sample_interval * SECOND)).astype(np.int64)
    if time_ns.shape != (n,):
        raise DataError(f"{n} samples, time of shape {time_ns.shape}")
    first, at = _first(time_ns, round(length * SECOND))
    stop = np.append(first[1:], n)
    return Blocks(first, stop, at, int(time_ns[0]), round(length * SECOND), *moments(channels, first, stop))


def columns(signal: Signal) -> list[Numbers]:
    """Return the channels of a signal one by one, each of shape (n,), not copied.

    Raises
    ------
    DataError
        If there are no samples, or channels of different length.
    """
    if isinstance(signal, np.ndarray):
        table = signal[:, np.newaxis] if signal.ndim == 1 else signal
        found = list(table.T) if table.ndim == 2 else []
    else:
        found = list(signal)
    if not found or any(one.ndim != 1 or len(one) != len(found[0]) for one in found) or not len(found[0]):
        shapes = [np.shape(one) for one in found] or np.shape(signal)
        raise DataError(f"a signal of shape {shapes}, need (n,) or (n, channels) with samples")
    return found


def moments(
    channels: Sequence[Numbers], first: Indices, stop: Indices
) -> tuple[Array, Array, Array, Array, NDArray[np.int64]]:
    """Return mean, variance, least, largest and number of the finite samples [first, stop), each (b, channels)."""
    from .._kernels import fill_moments  # noqa: PLC0415 - numba starts slowly

    shape = (len(channels), len(first))
    mean, variance, lo, hi = (np.empty(shape) for _ in range(4))
    count = np.empty(shape, dtype=np.int64)
    for k, x in enumerate(channels):
        fill_moments(x, first, stop, mean[k], variance[k], lo[k], hi[k], count[k])
    return mean.T, variance.T, lo.T, hi.T, count.T


def _first(time_ns: Times, length: int) -> tuple[Indices, Indices]:
    """First sample of each block that holds any, and its place in time."""
    from .._kernels import fill_first  # noqa: PLC0415 - numba starts slowly

    room = min(len(time_ns), (int(time_ns.max()) - int(time_ns[0])) // length + 1)
    first, at = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
    found = fill_first(time_ns, length, first, at)
    if found < 0:
        raise DataError(backward_steps(time_ns), f"sample {-1 - found}", do=AGAIN, code="time_backwards")
    return first[:found], at[:found]


FEWEST = 16  # places from which a scatter can be told
NORMAL = 0.6744897501960817  # median of |x| for unit normal x


@dataclass(frozen=True, eq=False)
class LevelScatter:
    """How much means of w blocks differ where nothing happens between, slow noise included."""

    blocks: Blocks
    quiet: Flags

    def of(self, w: int, gap: int) -> Array:
        """Return the standard deviation of the difference of two means of w blocks, ``gap`` blocks apart.

        From as many undisturbed places as the record has; where they are fewer than 16, of means over shorter windows,
        which is no smaller, down to single blocks; infinite where that fails too.

        Returns
        -------
        ndarray, shape (channels,)
        """
        rows = np.flatnonzero(self.quiet)
        mean = self.blocks.mean[rows]
        mean = mean - np.median(mean, axis=0) if len(rows) else mean
        total = np.vstack([np.zeros(mean.shape[1]), np.cumsum(mean, axis=0)])
        at = self.blocks.at[rows]
        while w >= 1:
            span = 2 * w + gap
            begin = np.arange(0, max(len(rows) - span + 1, 0), max(w // 2, 1))
            begin = begin[at[begin + span - 1] - at[begin] == span - 1] if len(begin) else begin
            if len(begin) >= FEWEST:
                left = total[begin + w] - total[begin]
                right = total[begin + span] - total[begin + w + gap]
                scatter = np.median(np.abs(right - left), axis=0) / (w * NORMAL)
                return np.where(scatter > 0.0, scatter, np.inf)
            w //= 2
        return np.full(self.blocks.mean.shape[1], np.inf)


def quiet_level(blocks: Blocks, quiet: Flags, at: int, way: int, w: int, walls: Flags) -> tuple[Array, int]:
    """Return the mean of the quiet blocks beside a place, shape (channels,), and their number.

    Looked at are ``w`` blocks of time from the block ``at`` on, to later (way 1) or to earlier ones (-1), not across
    walls.
    """
    a, b = (int(i) for i in np.searchsorted(blocks.at, (at, at + w) if way > 0 else (at - w, at)))
    hit = np.flatnonzero(walls[a:b])
    if len(hit):
        a, b = (a, a + int(hit[0])) if way > 0 else (a + int(hit[-1]) + 1, b)
    rows = a + np.flatnonzero(quiet[a:b])
    if not len(rows):
        return np.full(blocks.mean.shape[1], np.nan), 0
    return np.asarray(blocks.mean[rows].mean(axis=0)), len(rows)
