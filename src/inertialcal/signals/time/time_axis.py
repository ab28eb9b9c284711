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

import weakref
from dataclasses import dataclass
from math import isqrt
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, near, taken, where_steps
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
FEW_STEPS = 2**16  # [ns]: steps that differ by less are counted in bins
FEW_AXES = 8  # of which what was found is kept
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


def analyse(time_ns: Times, averaging: float | None = None, steps: Steps | None = None) -> TimeAxis:
    """Return what the stamps say about interval, jitter, gaps and order.

    Parameters
    ----------
    time_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    averaging : float, optional
        Length of the window that each sample is the mean of [s].
    steps : Steps, optional
        Of the stamps (`steps_of`), where they are known.

    Raises
    ------
    DataError
        If there are fewer than two stamps, or they span more than int64 nanoseconds hold (292 years).
    """
    known = _analysed.get(id(time_ns))
    if known is not None and known[0]() is time_ns and known[1] == averaging and not time_ns.flags.writeable:
        return known[2]
    found = _analyse(time_ns, averaging, steps)
    if not time_ns.flags.writeable:
        _analysed[id(time_ns)] = weakref.ref(time_ns), averaging, found
        if len(_analysed) > FEW_AXES:
            del _analysed[next(iter(_analysed))]
    return found


_analysed: dict[int, tuple[weakref.ref[Times], float | None, TimeAxis]] = {}  # axes of the last stamps, not to change
_ends: dict[int, tuple[weakref.ref[Times], tuple[float, float]]] = {}  # of the steps of the last stamps


def step_ends(time_ns: Times) -> tuple[float, float]:
    """Return the shortest and the longest step from one stamp to the next [ns]; infinity, and minus that, without any.

    Those of stamps that are not to change are remembered, as `analyse` does: units of a lot share them.
    """
    known = _ends.get(id(time_ns))
    if known is not None and known[0]() is time_ns and not time_ns.flags.writeable:
        return known[1]
    shortest, longest = np.inf, -np.inf
    for first, stop in batches(time_ns[:-1], size=near()):
        step = np.diff(time_ns[first : stop + 1])
        shortest, longest = min(shortest, float(step.min())), max(longest, float(step.max()))
    if not time_ns.flags.writeable:
        _ends[id(time_ns)] = weakref.ref(time_ns), (shortest, longest)
        if len(_ends) > FEW_AXES:
            del _ends[next(iter(_ends))]
    return shortest, longest


def _analyse(time_ns: Times, averaging: float | None, steps: Steps | None) -> TimeAxis:
    if len(time_ns) < 2:
        raise DataError(f"a time axis of {len(time_ns)} stamp(s), need 2 or more", code="too_short")
    ends = [(int(part.min()), int(part.max())) for part in (time_ns[a:b] for a, b in batches(time_ns))]
    first, last = min(low for low, _ in ends), max(high for _, high in ends)
    if last - first > WIDEST:
        raise DataError(f"stamps span {(last - first) / SECOND:.3g} s, more than 292 years", code="time_range")
    steps = steps_of(time_ns) if steps is None else steps
    forward = steps.where(steps.length > 0)
    none = np.empty(0, dtype=np.int64)
    repeated = where_steps(time_ns, lambda step: step == 0) if np.any(steps.length == 0) else none
    backward = where_steps(time_ns, lambda step: step < 0) if np.any(steps.length < 0) else none
    median = forward.median()
    pattern, interval = _pattern(time_ns, steps, forward, median)
    regular = pattern == "regular"
    longest = _longest_step(forward, interval) if regular else np.inf
    gaps = _gaps(time_ns, forward, interval, longest)
    rms, worst = _jitter(forward.where(forward.length <= longest), interval, regular)
    return TimeAxis(
        n=len(time_ns),
        duration=(last - first) / SECOND,
        pattern=pattern,
        interval=interval / SECOND if interval else None,
        median_step=median / SECOND,
        longest_step=float(forward.length[-1]) / SECOND if len(forward) else 0.0,
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


@dataclass(frozen=True, eq=False)
class Steps:
    """Different steps of a time axis, and how often each occurs: few where a clock is even."""

    length: Times  # ascending [ns], shape (k,)
    count: Indices

    def __len__(self) -> int:
        return len(self.length)

    def where(self, kept: NDArray[np.bool_]) -> Steps:
        """Return some of them."""
        return Steps(self.length[kept], self.count[kept])

    def median(self, off: float | None = None) -> float:
        """Return the median step, or the median of how far steps are off a length [ns]; 0 where there is none."""
        if not len(self):
            return 0.0
        size = self.length.astype(np.float64)
        count = self.count
        if off is not None:
            size = np.abs(size - off)
            order = np.argsort(size, kind="stable")
            size, count = size[order], count[order]
        before = np.cumsum(count)
        low, high = (int(np.searchsorted(before, k, side="right")) for k in ((before[-1] - 1) // 2, before[-1] // 2))
        return float(0.5 * (size[low] + size[high]))


def steps_of(time_ns: Times) -> Steps:
    """Return the different steps of stamps, counted a batch at a time."""
    found = Steps(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))
    for first, stop in batches(time_ns[:-1], size=near()):
        steps = np.diff(time_ns[first : stop + 1])
        least, largest = int(steps.min()), int(steps.max())
        if least == largest:  # an even clock
            one = Steps(steps[:1], np.array([len(steps)]))
        elif largest - least < FEW_STEPS:
            counted = np.bincount(steps - least)
            length = np.flatnonzero(counted)
            one = Steps(length + least, counted[length])
        else:
            one = Steps(*np.unique(steps, return_counts=True))
        if np.array_equal(found.length, one.length):
            found = Steps(found.length, found.count + one.count)
            continue
        length, at = np.unique(np.concatenate((found.length, one.length)), return_inverse=True)
        count = np.zeros(len(length), dtype=np.int64)
        np.add.at(count, at, np.concatenate((found.count, one.count)))
        found = Steps(length, count)
    return found


def _pattern(
    time_ns: Times, steps: Steps, forward: Steps, median: float
) -> tuple[Literal["regular", "bursts", "single"], float]:
    """Kind of axis and its nominal interval [ns]."""
    if not len(forward):
        return "single", 0.0
    block = _block_interval(time_ns) or median
    alike = 1.0 / BLOCK_AGREES <= block / median <= BLOCK_AGREES
    length, count = forward.length.astype(np.float64), int(forward.count.sum())
    off_grid = np.abs(length - np.rint(length / median) * median) > ON_GRID * median
    samples_lost = median < block <= MOST_LOST * median and forward.count[off_grid].sum() / count <= 1.0 - ON_GRID_SHARE
    if alike or samples_lost:
        return "regular", median
    mean = float(length @ forward.count) / int(steps.count[steps.length >= 0].sum())
    return "bursts", mean if abs(mean - block) < MEAN_AGREES * block else block


def _block_interval(time_ns: Times) -> float:
    """Median over blocks of about sqrt(n) samples of the mean step [ns]; 0 where none goes forward."""
    size = max(isqrt(len(time_ns)), min(10, len(time_ns) - 1))
    ends = taken(time_ns, np.arange(0, len(time_ns), size))
    means = np.diff(ends).astype(np.float64) / size
    means = means[means > 0.0]
    return float(np.median(means)) if len(means) else 0.0


def _jitter(forward: Steps, interval: float, regular: bool) -> tuple[float, float]:
    """Rms and largest deviation of the forward steps [ns]."""
    if not len(forward):
        return 0.0, 0.0
    length = forward.length.astype(np.float64)
    multiples = np.maximum(np.rint(length / interval), 1.0) if regular else 1.0
    deviation = np.abs(length - multiples * interval)
    return float(np.sqrt(deviation**2 @ forward.count / forward.count.sum())), float(deviation.max())


def _longest_step(forward: Steps, interval: float) -> float:
    """Return the longest step that jitter explains [ns]."""
    return interval + max(GAP_EXCESS * interval, GAP_SIGMA * MAD_TO_SIGMA * forward.median(interval))


def _gaps(time_ns: Times, forward: Steps, interval: float, longest: float) -> Gaps:
    """Find the steps that are longer than jitter explains."""
    if not np.any(forward.length > longest):
        return Gaps(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0, dtype=np.int64))
    after = where_steps(time_ns, lambda step: step > longest) - 1
    length = (taken(time_ns, after + 1) - taken(time_ns, after)).astype(np.float64)
    missing = np.floor(length / interval + GAP_EXCESS).astype(np.int64) - 1
    return Gaps(after, length / SECOND, missing)


def _table(forward: Steps, interval: float) -> tuple[tuple[float, int], ...]:
    """Step lengths to a quarter of the interval and how often each occurs."""
    quarters, at = np.unique(np.rint(forward.length / interval * QUARTER), return_inverse=True)
    counts = np.zeros(len(quarters), dtype=np.int64)
    np.add.at(counts, at, forward.count)
    order = np.argsort(-counts, kind="stable")[:TABLE_LINES]
    lengths = quarters[order] / QUARTER * interval / SECOND
    return tuple((float(length), int(count)) for length, count in zip(lengths, counts[order], strict=True))
