"""Time axis: nominal sample interval, jitter, gaps, repeated and unsorted stamps, dead time.

Stamps are int64 nanoseconds. A step is the difference of two neighbouring stamps. Three kinds of axis are
told apart, because a sample interval means something else in each:

``regular``
    Most steps are alike (or whole multiples of one step where samples were lost). The nominal interval is
    the median step, which neither gaps nor single bad stamps move.
``bursts``
    Steps differ, yet as many samples come in each stretch of time: the stamps say when a packet arrived,
    not when it was sampled, or they are coarser than the interval. The nominal interval is the mean step;
    single steps say nothing about gaps. (Where mean and median over blocks disagree, something else is
    wrong too, and the median stands.)
``single``
    All stamps are equal, so that there is no interval.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isqrt
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND, Times

Indices = NDArray[np.int64]

BLOCK_AGREES = 1.25  # block mean over median step up to which steps count as alike
MEAN_AGREES = 0.1  # relative difference from the median over blocks up to which the mean step stands
ON_GRID = 0.1  # largest distance from a whole multiple of the median step, in median steps
ON_GRID_SHARE = 0.9  # share of steps that must lie on that grid where samples were lost
MOST_LOST = 2.5  # block mean over median step up to which it can be losses: 60 % of the samples
GAP_EXCESS = 0.4  # excess over the interval, in intervals, from which a step is a gap ...
GAP_SIGMA = 6.0  # ... and in robust standard deviations of the steps
MAD_TO_SIGMA = 1.4826  # median absolute deviation to standard deviation, normal distribution
QUARTER = 4  # the table of steps counts them to a quarter of the interval
TABLE_LINES = 12  # longest table of steps
AGAIN = "Cut the record there; sort its rows if they are in another order; or give --sample-rate if its clock was set"
WIDEST = float(np.iinfo(np.int64).max)  # [ns]


@dataclass(frozen=True, eq=False)
class Gaps:
    """Stretches without samples."""

    after: Indices  # index of the last sample before each gap, shape (k,)
    length: Array  # step across the gap [s], shape (k,)
    # samples that are missing in each, at the nominal interval; 0 where a sample came late, shape (k,)
    missing: Indices

    def __len__(self) -> int:
        return len(self.after)


@dataclass(frozen=True, eq=False)
class TimeAxis:
    """What the stamps of a recording say."""

    n: int  # number of stamps
    duration: float  # from the earliest to the latest stamp [s]
    pattern: Literal["regular", "bursts", "single"]  # see the module head
    interval: float | None  # nominal sample interval [s]; None where all stamps are equal
    # median_step, longest_step: of the forward steps [s]; 0 where there is none
    median_step: float
    longest_step: float
    # jitter_rms, jitter_max: deviation of a step that is no gap from the interval (bursts), or from its nearest whole
    # multiple (regular) [s]
    jitter_rms: float
    jitter_max: float
    gaps: Gaps  # empty where the pattern is not regular
    # forward step [s] to a quarter of the interval, and how often it occurs; the most frequent first, at most 12. Empty
    # where the pattern is not regular
    steps: tuple[tuple[float, int], ...]
    # repeated, backward: index of each stamp that equals the one before it, or is earlier
    repeated: Indices
    backward: Indices
    averaging: float | None = None  # length of the window that each sample is the mean of [s]; None when nobody said

    @property
    def dead_time(self) -> float | None:
        """Time between two averaging windows [s], negative where windows overlap; None when not known."""
        if self.averaging is None or self.interval is None:
            return None
        return self.interval - self.averaging

    @property
    def lost(self) -> int:
        """Samples missing in all gaps together."""
        return int(self.gaps.missing.sum())


def analyse(time_ns: Times, averaging: float | None = None) -> TimeAxis:
    """Return what the stamps say about interval, jitter, gaps and order.

    Parameters
    ----------
    time_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    averaging : float, optional
        Length of the window that each sample is the mean of [s].

    Raises
    ------
    DataError
        If there are fewer than two stamps, or they span more than int64 nanoseconds hold (292 years).
    """
    if len(time_ns) < 2:
        raise DataError(f"a time axis of {len(time_ns)} stamp(s), need 2 or more", code="too_short")
    first, last = int(time_ns.min()), int(time_ns.max())
    if last - first > WIDEST:
        raise DataError(f"stamps span {(last - first) / SECOND:.3g} s, more than 292 years", code="time_range")
    steps = np.diff(time_ns)
    forward = steps[steps > 0].astype(np.float64)
    repeated, backward = np.flatnonzero(steps == 0) + 1, np.flatnonzero(steps < 0) + 1
    median = float(np.median(forward)) if len(forward) else 0.0
    pattern, interval = _pattern(time_ns, forward, median)
    regular = pattern == "regular"
    gaps = _gaps(steps, interval) if regular else _gaps(steps[:0], 1.0)
    rms, worst = _jitter(np.delete(steps, gaps.after) if len(gaps) else steps, interval, regular)
    return TimeAxis(
        n=len(time_ns),
        duration=(last - first) / SECOND,
        pattern=pattern,
        interval=interval / SECOND if interval else None,
        median_step=median / SECOND,
        longest_step=float(forward.max()) / SECOND if len(forward) else 0.0,
        jitter_rms=rms / SECOND,
        jitter_max=worst / SECOND,
        gaps=gaps,
        steps=_table(forward, interval) if regular else (),
        repeated=repeated,
        backward=backward,
        averaging=averaging,
    )


def backward_steps(time_ns: Times, at: Indices | None = None) -> str:
    """Return how often time goes back, and the first such step since the first stamp, in words.

    Parameters
    ----------
    time_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    at : ndarray of int64, optional
        Stamps that are earlier than the one before; all of them by default.
    """
    at = np.flatnonzero(np.diff(time_ns) < 0) + 1 if at is None else at
    before, after = ((int(time_ns[i]) - int(time_ns[0])) / SECOND for i in (at[0] - 1, at[0]))
    times = f"{len(at)} times, first" if len(at) > 1 else f"by {before - after:.4g} s,"
    return f"time goes back {times} from {before:.9g} s to {after:.9g} s after the first stamp"


def _pattern(time_ns: Times, forward: Array, median: float) -> tuple[Literal["regular", "bursts", "single"], float]:
    """Kind of axis and its nominal interval [ns]."""
    if not len(forward):
        return "single", 0.0
    block = _block_interval(time_ns) or median
    alike = 1.0 / BLOCK_AGREES <= block / median <= BLOCK_AGREES
    off_grid = np.abs(forward - np.rint(forward / median) * median) > ON_GRID * median
    samples_lost = median < block <= MOST_LOST * median and np.mean(off_grid) <= 1.0 - ON_GRID_SHARE
    if alike or samples_lost:
        return "regular", median
    mean = float(forward.sum()) / np.count_nonzero(np.diff(time_ns) >= 0)
    return "bursts", mean if abs(mean - block) < MEAN_AGREES * block else block


def _block_interval(time_ns: Times) -> float:
    """Median over blocks of about sqrt(n) samples of the mean step [ns]; 0 where none goes forward."""
    size = max(isqrt(len(time_ns)), min(10, len(time_ns) - 1))
    ends = time_ns[::size]
    means = np.diff(ends).astype(np.float64) / size
    means = means[means > 0.0]
    return float(np.median(means)) if len(means) else 0.0


def _jitter(steps: Times, interval: float, regular: bool) -> tuple[float, float]:
    """Rms and largest deviation of the forward steps [ns]."""
    forward = steps[steps > 0].astype(np.float64)
    if not len(forward):
        return 0.0, 0.0
    multiples = np.maximum(np.rint(forward / interval), 1.0) if regular else 1.0
    deviation = np.abs(forward - multiples * interval)
    return float(np.sqrt(np.mean(deviation**2))), float(deviation.max())


def _gaps(steps: Times, interval: float) -> Gaps:
    """Find the steps that are longer than jitter explains."""
    forward = steps[steps > 0].astype(np.float64)
    sigma = MAD_TO_SIGMA * float(np.median(np.abs(forward - interval))) if len(forward) else 0.0
    threshold = interval + max(GAP_EXCESS * interval, GAP_SIGMA * sigma)
    after = np.flatnonzero(steps > threshold)
    length = steps[after].astype(np.float64)
    missing = np.floor(length / interval + GAP_EXCESS).astype(np.int64) - 1
    return Gaps(after, length / SECOND, missing)


def _table(forward: Array, interval: float) -> tuple[tuple[float, int], ...]:
    """Step lengths to a quarter of the interval and how often each occurs."""
    quarters, counts = np.unique(np.rint(forward / interval * QUARTER), return_counts=True)
    order = np.argsort(-counts, kind="stable")[:TABLE_LINES]
    lengths = quarters[order] / QUARTER * interval / SECOND
    return tuple((float(length), int(count)) for length, count in zip(lengths, counts[order], strict=True))
