"""Spectral density by Welch's method or by several orthogonal tapers, of a record that may have gaps.

The record is cut into equally long segments, laid into the stretches without a missing sample; each segment has its
mean removed. What fits into no segment is counted and remarked. Nothing is interpolated or resampled.

``"welch"``: Hann window, segments overlapping by half. ``"multitaper"``: Slepian tapers, segments side by side, for
short records: a lower variance from one segment, at the price of broader lines.

Segments of a record with gaps: equally long ones, laid into every stretch in which no sample is missing.

References
----------
.. [1] P. D. Welch, IEEE Trans. Audio Electroacoustics AU-15 (1967) 70-73.
.. [2] D. J. Thomson, Proc. IEEE 70 (1982) 1055-1096.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...core.batches import batches, extremes, known_finite, near, release
from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Numbers
from ...core.remarks import Remark
from ..names import Method
from ..threads import each_of
from .density import Spectrum
from .long_transform import Room, columns_of, folded, lanes_of, power_of
from .tapers import Tapers, correlations, hann, slepian, usable

SHORTEST = 32  # samples of a segment; under several tapers by half the time bandwidth more
PARTS = 8  # of a record, in the length of a segment, by default
LONGEST_TAPER = 2**16  # samples of a segment under several tapers, by default
HELD = 0.75  # of the samples that are there, that lie in stretches as long as a segment, by default
AT_ONCE = 2**15  # samples transformed together: they lie in the nearest caches
FEW = 2**16  # so few at once
PAIRS = 2  # of long segments in a share, at least: to touch fresh memory for their sum takes a third of a transform
SHARES = 8  # of the segments, each summed by itself, and the sums in order: the same whatever the number of threads
LEAST = 8  # segments, of which sixteen are transformed together
MANY = 2**13  # samples of them, from which that gains more than its loops take to load
FIRST = 64  # samples that are looked at first, whether all are equal
CONSTANT = 8.0 * np.finfo(float).eps  # variation, relative to the largest value, that is rounding
Indices = NDArray[np.int64]


def psd(
    x: Numbers,
    interval: float,
    method: Method = "welch",
    *,
    segment: int | None = None,
    time_bandwidth: float = 4.0,
    p: float = 0.6827,
) -> Spectrum:
    """Return the one-sided spectral density of a sampled signal, with degrees of freedom and intervals.

    Parameters
    ----------
    x : ndarray, shape (n,) or (n, axes)
        Evenly spaced samples, NaN where one is missing [unit]. Angles or increments are to be made rates first.
    interval : float
        From sample to sample [s].
    method : {"welch", "multitaper"}
        See the module head.
    segment : int, optional
        Samples of each segment. By default an eighth of the record with Welch's method, the longest stretch
        without a gap up to 65,536 samples with several tapers; shorter if gaps leave too few segments so long.
    time_bandwidth : float
        Of the Slepian tapers: half their bandwidth times their length, 2 to 32; ``2 NW - 2`` of them are used.
    p : float
        Probability of the intervals.

    Returns
    -------
    Spectrum
        Density [unit^2/Hz] of each axis.

    Raises
    ------
    DataError
        ``bad_interval``, ``bad_shape``, ``too_short`` (fewer samples than a segment needs: 32, or 16 times
        the time bandwidth), ``gaps`` (no segment
        without a gap).
    PlanError
        If method, segment, time bandwidth or probability are out of range.
    """
    values = _checked(x, interval, method, time_bandwidth, p)
    whole = len(values) <= near() and bool(np.isfinite(values).all())
    gaps = _whole(len(values)) if whole else stretches_of(values)
    return _spectrum(list(values.T), gaps, whole, interval, method, segment, time_bandwidth, p)


def psd_alike(
    series: Sequence[Array],
    interval: float,
    method: Method = "welch",
    *,
    segment: int | None = None,
    time_bandwidth: float = 4.0,
    p: float = 0.6827,
) -> Spectrum:
    """Return the spectral densities of many records of one length, side by side: those of `psd`, of each by itself.

    Parameters
    ----------
    series : sequence of ndarray, shape (n,)
        Samples in float64, all of them finite [unit].
    interval, method, segment, time_bandwidth, p : as `psd` takes them

    Raises
    ------
    DataError, PlanError
        As `psd`.
    """
    _check_settings(interval, method, time_bandwidth, p)
    return _spectrum(series, _whole(len(series[0])), True, interval, method, segment, time_bandwidth, p)


def _spectrum(
    columns: Sequence[Array], gaps: Stretches, whole: bool, interval: float, method: Method, segment: int | None,
    time_bandwidth: float, p: float,
) -> Spectrum:  # fmt: skip
    """Return the spectrum of axes, each of shape (n,)."""
    n = len(columns[0])
    laid = (_laid_out_whole if whole else _laid_out)(gaps, n, method, segment, float(time_bandwidth))
    length, first, stop = laid.tapers.weights.shape[1], laid.first, laid.stop
    density = _averaged(columns, laid.starts, laid.tapers, interval)
    return Spectrum(
        np.arange(first, stop) / (length * interval), density[:, first:stop].T, laid.edf, laid.neighbours,
        laid.tapers.lobe, laid.enbw / (length * interval), interval, length, laid.segments, laid.used, gaps.missing,
        method, p, _remarks(columns, gaps, laid.used, length),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Layout:
    """Segments of a record, and what follows from where they lie."""

    tapers: Tapers
    starts: Indices  # first samples of all segments, ascending
    segments: int
    used: int  # samples that lie in one
    edf: float
    neighbours: Array
    first: int  # usable frequencies, as `usable` has them
    stop: int
    enbw: float


def _laid_out(gaps: Stretches, n: int, method: Method, segment: int | None, time_bandwidth: float) -> _Layout:
    shortest = SHORTEST if method == "welch" else int(np.ceil(0.5 * SHORTEST * time_bandwidth))
    length = _length(n, gaps, method, segment, shortest)
    tapers = hann(length) if method == "welch" else slepian(length, time_bandwidth)
    starts = gaps.starts(length, tapers.step)
    used = sum(int(one[-1] - one[0]) + length for one in starts)
    every, counted = np.concatenate(starts), correlations(tapers, tuple(map(len, starts)))
    return _Layout(tapers, every, len(every), used, *counted, *usable(tapers), tapers.enbw)


_laid_out_whole = lru_cache(8)(_laid_out)  # of records without a gap, which have one object of `_whole` by their length


@lru_cache(8)
def _whole(n: int) -> Stretches:
    """Return the one stretch of a record without a gap."""
    return Stretches(np.array([0]), np.array([n]), 0)


def _check_settings(interval: float, method: str, time_bandwidth: float, p: float) -> None:
    if method not in {"welch", "multitaper"}:
        raise PlanError(f"method {method!r}", do="There are 'welch' and 'multitaper'")
    if not 2.0 <= time_bandwidth <= 32.0:
        raise PlanError(f"time_bandwidth {time_bandwidth}, need 2 to 32")
    if not 0.0 < p < 1.0:
        raise PlanError(f"probability {p}", do="Need more than 0 and less than 1, such as 0.95")
    if not (np.isfinite(interval) and interval > 0.0):
        raise DataError(f"a sample interval of {interval} s", do="It must be positive", code="bad_interval")


def _checked(x: Numbers, interval: float, method: str, time_bandwidth: float, p: float) -> Array:
    _check_settings(interval, method, time_bandwidth, p)
    values = np.asarray(x, dtype=np.float64)
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or not values.shape[1]:
        raise DataError(f"a signal of shape {np.shape(x)}, need (n,) or (n, axes)", code="bad_shape")
    return values


def _length(n: int, gaps: Stretches, method: Method, segment: int | None, shortest: int) -> int:
    """Return the samples of a segment: the one asked for, or a default that fits, and is fast to transform."""
    longest = gaps.longest
    if longest < shortest:
        raise DataError(
            f"{n} samples, at most {longest} in a row without a gap: a spectrum needs {shortest}",
            why=f"{gaps.missing} sample(s) are missing" if gaps.missing else "",
            do="Record longer",
            code="gaps" if n >= shortest else "too_short",
        )
    if segment is None:
        return _fitting(n, gaps, n // PARTS if method == "welch" else LONGEST_TAPER, shortest)
    if segment < shortest:
        raise PlanError(f"segments of {segment} samples, need {shortest} or more")
    if segment > longest:
        raise DataError(
            f"segments of {segment} samples, but at most {longest} samples in a row without a gap",
            why="a segment across a gap has no spectrum",
            do=f"Give a segment of {longest} samples or fewer",
            code="gaps" if n >= segment else "too_short",
        )
    return segment


def _fitting(n: int, gaps: Stretches, wanted: int, shortest: int) -> int:
    """Halve the length wanted until most samples that are there lie in stretches that hold a segment."""
    length = max(shortest, min(wanted, gaps.longest))
    while length >= 2 * shortest and gaps.held(length) < HELD * (n - gaps.missing):
        length //= 2
    return max(shortest, int(fft.prev_fast_len(length, real=True)))


def _averaged(columns: Sequence[Array], every: Indices, tapers: Tapers, interval: float) -> Array:
    """Mean of the one-sided densities of all segments under all tapers, shape (axes, n // 2 + 1).

    Zero frequency and, of segments of even length, the highest one are doubled too: they are no part of a Spectrum.
    """
    count, length = tapers.weights.shape
    few = columns_of(length) == 1 and count * len(every) * length <= FEW
    total = (_summed_at_once if few else _summed_in_shares)(columns, every, tapers.weights)
    total *= 2.0 * interval / (count * len(every))
    return total


def _summed_at_once(columns: Sequence[Array], every: Indices, tapers: Array) -> Array:
    """Sum of squared magnitudes of the transforms of few segments, shape (axes, n // 2 + 1)."""
    from ._kernels import add_power, fill_tapered  # noqa: PLC0415 - numba starts slowly

    length, lanes = tapers.shape[1], lanes_of(tapers.shape[1])
    total = np.zeros((len(columns), length // 2 + 1))
    if lanes is not None and len(every) >= LEAST and len(every) * length >= MANY:
        rooms = lanes.rooms()
        for x, found in zip(columns, total, strict=True):
            for weights in tapers:
                lanes.add_power(x, every, weights, rooms, found)
            release(x)
        return total
    part = np.empty((len(every), length))
    turned = np.empty((len(every), length // 2 + 1), dtype=np.complex128)
    for x, found in zip(columns, total, strict=True):
        for weights in tapers:
            fill_tapered(x, every, weights, part)
            add_power(np.fft.rfft(part, axis=1, out=turned).view(np.float64), found)
        release(x)
    return total


def _summed_in_shares(columns: Sequence[Array], every: Indices, tapers: Array) -> Array:
    """Return the same of many segments, in shares: several at a time where there are many samples."""
    from ._kernels import add_power, fill_tapered  # noqa: PLC0415 - numba starts slowly

    count, length = tapers.shape
    in_steps = columns_of(length) > 1
    at_once = 2 * PAIRS if in_steps else max(1, AT_ONCE // length)
    whole = -(-len(every) // (at_once * SHARES)) * at_once  # segments of a share
    shares = [every[i : i + whole] for i in range(0, len(every), whole)]
    total, rooms = np.empty((len(columns), length // 2 + 1)), list[Room]()
    for axis, x in enumerate(columns):

        def power(share: Indices, x: Array = x) -> Array:
            """Sum of squared magnitudes of the transforms of the segments of a share."""
            if in_steps:
                return power_of(x, share, tapers, rooms)
            found = np.zeros(length // 2 + 1)
            for i in range(0, len(share), at_once):
                some = share[i : i + at_once]
                part = np.empty((len(some), length))
                for weights in tapers:
                    fill_tapered(x, some, weights, part)
                    add_power(np.fft.rfft(part, axis=1).view(np.float64), found)
                release(x[some[0] : some[-1] + length])
            return found

        found, *others = each_of(power, shares, count * len(every) * length)
        for other in others:
            found += other
        total[axis] = folded(found) if in_steps else found
    return total


def _remarks(columns: Sequence[Array], gaps: Stretches, used: int, length: int) -> tuple[Remark, ...]:
    found, n = [], len(columns[0])
    left = n - gaps.missing - used
    if gaps.missing:
        what = f"{gaps.missing} of {n} samples are missing: segments lie between the gaps"
        found.append(Remark("gaps", "info", what, count=max(1, len(gaps.start) - 1)))
    if gaps.missing and left > used:
        what = f"{left} samples between gaps are too short for a segment of {length}; {used} are used"
        found.append(Remark("few_segments", "warning", what, do="Give shorter segments"))
    for axis, x in enumerate(columns):
        if _is_constant(x):
            what = f"axis {axis} is constant: no spectrum"
            found.append(Remark("constant", "warning", what, do="Check for a stuck or disconnected channel"))
    return tuple(found)


def _is_constant(x: Array) -> bool:
    """Return whether the finite samples, shape (n,), differ by no more than rounding: what differs so far stays so."""
    few, low, high = x[:FIRST], np.inf, -np.inf
    least, largest = np.minimum.reduce(few, initial=np.inf), np.maximum.reduce(few, initial=-np.inf)
    if np.inf > largest - least > CONSTANT * max(abs(least), abs(largest)):
        return False
    for first, stop in batches(x, size=near()):
        least, largest = extremes(x[first:stop], infinite=False)
        low, high = float(np.fmin(low, least)), float(np.fmax(high, largest))
        if high - low > CONSTANT * max(abs(low), abs(high)):
            return False
    return True


@dataclass(frozen=True, eq=False)
class Stretches:
    """Runs of samples that all have a value."""

    # start, stop: half-open, ascending, shape (k,)
    start: Indices
    stop: Indices
    missing: int  # samples in none of them

    @property
    def longest(self) -> int:
        """Samples of the longest one; 0 where there is none."""
        return int((self.stop - self.start).max(initial=0))

    def held(self, segment: int) -> int:
        """Count samples in stretches that hold a segment of that length."""
        length = self.stop - self.start
        return int(length[length >= segment].sum())

    def starts(self, segment: int, step: int) -> list[Indices]:
        """First samples of the segments of each stretch that holds one, every ``step`` samples."""
        pairs = zip(self.start, self.stop, strict=True)
        return [np.arange(a, b - segment + 1, step, dtype=np.int64) for a, b in pairs if b - a >= segment]


def stretches_of(x: Array) -> Stretches:
    """Return the runs of samples (n, axes) that have a finite value in every axis."""
    if len(x) and all(known_finite(own) for own in x.T):
        return Stretches(np.array([0]), np.array([len(x)]), 0)
    found, before, there = [], False, 0
    for first, stop in batches(x):
        good: NDArray[np.bool_] = np.isfinite(x[first:stop, 0])
        for axis in range(1, x.shape[1]):
            good &= np.isfinite(x[first:stop, axis])
        if before and good.all():
            there += stop - first
            continue
        found.append(first + np.flatnonzero(good != np.append(before, good[:-1])))
        before, there = bool(good[-1]), there + int(np.count_nonzero(good))
    edges = np.concatenate([*found, [len(x)] if before else []]).astype(np.int64)
    return Stretches(edges[0::2], edges[1::2], len(x) - there)
