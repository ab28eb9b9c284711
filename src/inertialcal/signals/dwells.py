"""Dwell: one stretch of a signal, reduced to a reading with its scatter, and every sample accounted for.

The first and last samples of a dwell may be averages that reach into the ramp; they are dropped and
counted. Samples that are not finite and single outliers are left out and counted too. The mean of n
samples of correlated noise is worth fewer than n: the effective size follows from the correlation of
neighbours as for a first-order autoregressive process [1]_, its estimate corrected for the bias of a
short series [2]_ and never below zero, so that it cannot promise more than n.

Dwells whose edges are known from elsewhere - a commanded rate, a schedule - are cut here; those that the
signal itself shows are found by ``segments``.

References
----------
.. [1] Bayley and Hammersley, Suppl. J. Royal Statistical Society 8 (1946) 184-197: effective number of
   independent observations.
.. [2] Marriott and Pope, Biometrika 41 (1954) 390-402: bias of an estimated autocorrelation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError, PlanError
from ..core.estimate import Array
from ..core.recording import SECOND, Times
from .time_axis import TimeAxis, analyse

Flags = NDArray[np.bool_]

LONGEST_GAP = 10.0  # sample intervals: what happened in a longer gap nobody knows
FEWEST = 8  # samples from which a correlation can be told
CORRELATED = 0.99  # largest correlation of neighbours that is told from drift


@dataclass(frozen=True, eq=False)
class Dwell:
    """A stretch at one level, as one reading.

    Parameters
    ----------
    start, stop : int
        Samples used, half-open; what was dropped at the edges lies outside.
    mean : ndarray, shape (channels,)
        Of the samples used [unit of the signal].
    scatter : ndarray, shape (channels,)
        Standard deviation of the samples used (n - 1) [unit of the signal].
    n : int
        Samples used.
    n_effective : ndarray, shape (channels,)
        Independent samples that they are worth for the mean.
    time_ns : tuple of int, or None
        First and last stamp used [ns].
    edge_dropped : int
        Samples dropped at the two edges.
    missing : int
        Samples inside that are not finite.
    outliers : int
        Single outliers inside, left out.
    gaps : int
        Gaps of the time axis inside.
    disturbed : int
        Samples of the same placement left out because of a disturbance.
    stuck : ndarray of bool, shape (channels,)
        Whether all samples used are equal.
    applied : ndarray, shape (applied channels,), or None
        Mean of the reference over the samples used, where the dwell was cut by one.
    """

    start: int
    stop: int
    mean: Array
    scatter: Array
    n: int
    n_effective: Array
    time_ns: tuple[int, int] | None
    edge_dropped: int
    missing: int
    outliers: int
    gaps: int
    stuck: Flags
    disturbed: int = 0
    applied: Array | None = None

    @property
    def u(self) -> Array:
        """Standard uncertainty of the mean from the scatter inside the dwell alone, shape (channels,)."""
        return self.scatter / np.sqrt(self.n_effective)


@dataclass(frozen=True)
class Tally:
    """Where every sample of a record went: the six parts add up to ``samples``."""

    samples: int
    used: int
    edge_dropped: int
    missing: int
    outliers: int
    disturbed: int
    outside: int


def tally(dwells: Sequence[Dwell], samples: int) -> Tally:
    """Count what of a record of so many samples its dwells use, and why not the rest.

    ``missing`` and ``outliers`` count inside the dwells; ``outside`` is all that belongs to no dwell.
    """
    parts = {
        name: sum(getattr(dwell, name) for dwell in dwells)
        for name in ("edge_dropped", "missing", "outliers", "disturbed")
    }
    used = sum(dwell.n for dwell in dwells)
    return Tally(samples, used, **parts, outside=samples - used - sum(parts.values()))


@dataclass(frozen=True, eq=False)
class Samples:
    """A signal with what is known of each sample, ready to be cut into dwells.

    Parameters
    ----------
    values : ndarray, shape (n, channels)
        May hold NaN; column-major, so that a channel lies in one piece.
    finite : ndarray of bool, shape (n,)
        Whether every channel has a value.
    outlier : ndarray of bool, shape (n,)
        Samples to leave out.
    gap : ndarray of bool, shape (n,)
        Whether a gap lies between a sample and the one before it.
    ticks : ndarray, shape (n,)
        Time since the first sample [sample intervals]; the index where there is no time.
    time_ns : ndarray of int64, shape (n,), or None
        Stamps [ns].
    sample_interval : float or None
        Nominal time from sample to sample [s].
    """

    values: Array
    finite: Flags
    outlier: Flags
    gap: Flags
    ticks: Array
    time_ns: Times | None = None
    sample_interval: float | None = None

    def duration(self, samples: int | None, seconds: float | None, default: int) -> int:
        """Return a length in samples from whichever of the two is given.

        Raises
        ------
        PlanError
            If both are given, or seconds where no sample interval is known.
        """
        if seconds is None:
            return default if samples is None else samples
        if samples is not None:
            raise PlanError(f"a length of {samples} samples and of {seconds:g} s given", do="Give one of them")
        if self.sample_interval is None:
            raise PlanError(
                f"a length of {seconds:g} s, but no sample interval",
                why="samples cannot be counted off",
                do="Give sample_interval, time_ns, or a number of samples",
            )
        return max(1, round(seconds / self.sample_interval))


def samples_of(
    signal: NDArray[Any],
    time_ns: Times | None = None,
    sample_interval: float | None = None,
    outlier: Flags | None = None,
) -> Samples:
    """Return a signal, (n,) or (n, channels), as Samples, its time looked through.

    Raises
    ------
    DataError
        If the signal has another shape, or the time another length, or it runs backwards.
    """
    values = np.asfortranarray(signal, dtype=np.float64)
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or not values.shape[1]:
        raise DataError(f"a signal of shape {np.shape(signal)}, need (n,) or (n, channels)")
    n = len(values)
    if sample_interval is not None and not sample_interval > 0.0:
        raise DataError(f"a sample interval of {sample_interval} s", do="It must be positive")
    flags = np.zeros(n, dtype=bool) if outlier is None else outlier
    gap, ticks = np.zeros(n, dtype=bool), np.arange(n, dtype=np.float64)
    if time_ns is not None:
        axis = _checked_axis(time_ns, n)
        gap[axis.gaps.after + 1] = True
        sample_interval = sample_interval or axis.interval
        if sample_interval is not None:
            ticks = (time_ns - time_ns[0]) / (sample_interval * SECOND)
    finite = np.ones(n, dtype=bool)
    for k in range(values.shape[1]):
        finite &= np.isfinite(values[:, k])
    return Samples(values, finite, flags, gap, ticks, time_ns, sample_interval)


def _checked_axis(time_ns: Times, n: int) -> TimeAxis:
    if time_ns.shape != (n,):
        raise DataError(f"{n} samples, time of shape {time_ns.shape}")
    axis = analyse(time_ns)
    if len(axis.backward):
        raise DataError(
            f"time runs backwards at {len(axis.backward)} place(s)",
            where=f"sample {axis.backward[0]}",
            why="a stretch across it has no length",
            do="Sort the record, or cut it there",
            code="time_backwards",
        )
    return axis


def dwell_of(samples: Samples, start: int, stop: int, drop_edge: int = 1, disturbed: int = 0) -> Dwell | None:
    """Reduce the stretch [start, stop) to a reading.

    Parameters
    ----------
    samples : Samples
        Of the whole record.
    start, stop : int
        Half-open.
    drop_edge : int
        Good samples to drop at each end.
    disturbed : int
        Samples of the same placement that the caller has left out.

    Returns
    -------
    Dwell or None
        None where fewer than two samples are left.
    """
    good = np.flatnonzero(samples.finite[start:stop] & ~samples.outlier[start:stop]) + start
    used = good[drop_edge : len(good) - drop_edge]
    if len(used) < 2:
        return None
    first, last = int(used[0]), int(used[-1])
    missing = int(np.count_nonzero(~samples.finite[first : last + 1]))
    times = None if samples.time_ns is None else (int(samples.time_ns[first]), int(samples.time_ns[last]))
    x = samples.values[first : last + 1]
    x = x if len(x) == len(used) else np.asfortranarray(x[used - first])
    return Dwell(
        start=first,
        stop=last + 1,
        mean=x.mean(axis=0),
        scatter=x.std(axis=0, ddof=1),
        n=len(used),
        n_effective=effective_size(x, (np.diff(used) == 1) & ~samples.gap[used[1:]]),
        time_ns=times,
        edge_dropped=2 * drop_edge,
        missing=missing,
        outliers=last + 1 - first - len(used) - missing,
        gaps=int(np.count_nonzero(samples.gap[first + 1 : last + 1])),
        stuck=x.max(axis=0) == x.min(axis=0),
        disturbed=disturbed,
    )


def effective_size(x: Array, neighbours: Flags | None = None) -> Array:
    """Independent samples that correlated ones are worth for their mean.

    Parameters
    ----------
    x : ndarray, shape (n, channels)
        One stretch.
    neighbours : ndarray of bool, shape (n - 1,), optional
        Which samples are followed by their neighbour; all by default.

    Returns
    -------
    ndarray, shape (channels,)
        Between 1 and n.
    """
    n = len(x)
    pairs = np.ones(n - 1, dtype=bool) if neighbours is None else neighbours
    residual = x - x.mean(axis=0)
    variance = np.einsum("ij,ij->j", residual, residual) / n
    if n < FEWEST or not pairs.any():
        return np.full(x.shape[1], float(n))
    products = np.einsum("ij,ij,i->j", residual[:-1], residual[1:], pairs.astype(np.float64)) / pairs.sum()
    raw = np.divide(products, variance, out=np.zeros_like(variance), where=variance > 0.0)
    rho = np.clip((n * raw + 1.0) / (n - 4.0), 0.0, CORRELATED)
    worth = n / (1.0 + 2.0 * rho / (1.0 - rho) * (1.0 - (1.0 - rho**n) / (n * (1.0 - rho))))
    return np.where(variance > 0.0, np.clip(worth, 1.0, n), float(n))


def dwells_by_windows(
    windows_ns: Sequence[tuple[int, int]], signal: NDArray[Any], time_ns: Times, *, drop_edge: int = 1
) -> tuple[Dwell, ...]:
    """Cut dwells at given times: from a schedule, or where the steps are too small to be seen.

    Parameters
    ----------
    windows_ns : sequence of (start, stop)
        Half-open, on the clock of ``time_ns`` [ns].
    signal : ndarray, shape (n,) or (n, channels)
        May hold NaN, which is left out and counted.
    time_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    drop_edge : int
        Samples to drop at each end, one by default.

    Returns
    -------
    tuple of Dwell
        One a window, in the order given.

    Raises
    ------
    PlanError
        If a window ends before it starts, or two overlap.
    DataError
        If a window holds too few samples, or the time does not fit.
    """
    _check_windows(windows_ns)
    samples = samples_of(signal, time_ns)
    found = []
    for start_ns, stop_ns in windows_ns:
        start, stop = np.searchsorted(time_ns, (start_ns, stop_ns))
        dwell = dwell_of(samples, int(start), int(stop), drop_edge)
        if dwell is None:
            raise DataError(
                f"window {start_ns} to {stop_ns} ns holds {stop - start} sample(s)",
                why=f"need {2 + 2 * drop_edge} or more, {drop_edge} being dropped at each end",
                do=f"The record runs from {time_ns[0]} to {time_ns[-1]} ns" if len(time_ns) else "",
                code="empty_window",
            )
        found.append(dwell)
    return tuple(found)


def _check_windows(windows_ns: Sequence[tuple[int, int]]) -> None:
    ordered = sorted(windows_ns)
    for start, stop in ordered:
        if stop <= start:
            raise PlanError(f"window {start} to {stop} ns ends before it starts")
    for one, other in pairwise(ordered):
        if other[0] < one[1]:
            raise PlanError(f"windows {one[0]} to {one[1]} and {other[0]} to {other[1]} ns overlap")


def dwells_by_reference(
    applied: NDArray[Any],
    signal: NDArray[Any],
    time_ns: Times | None = None,
    sample_interval: float | None = None,
    *,
    tolerance: float = 0.0,
    min_samples: int | None = None,
    min_duration: float | None = None,
    drop_edge: int = 1,
) -> tuple[Dwell, ...]:
    """Cut dwells where a commanded value steps; the cut is exact, however small the step.

    For an encoder that is noisy itself, ``segments.dwells(segments.detect(encoder), signal)`` is the way.

    Parameters
    ----------
    applied : ndarray, shape (n,) or (n, k)
        Commanded value of each sample; a sample where it is NaN is left out and counted as missing.
    signal : ndarray, shape (n,) or (n, channels)
        What to reduce.
    time_ns : ndarray of int64, shape (n,), optional
        Stamps [ns]; a gap of more than ten sample intervals ends a dwell.
    sample_interval : float, optional
        Nominal time from sample to sample [s]; from the time by default.
    tolerance : float
        Change from sample to sample that is no step [unit of ``applied``]; a stretch that wanders by more
        than twice this is not constant and makes no dwell.
    min_samples, min_duration : int, float [s]
        Shortest dwell before its edges are dropped; four samples and the edges by default.
    drop_edge : int
        Samples to drop at each end, one by default.

    Returns
    -------
    tuple of Dwell
        In order of time, with ``applied``.

    Raises
    ------
    DataError
        If lengths differ, or the reference is nowhere constant for long enough.
    """
    given = samples_of(applied)
    reference, known = given.values, given.finite
    samples = samples_of(signal, time_ns, sample_interval)
    if len(reference) != len(samples.values):
        raise DataError(f"{len(samples.values)} samples, {len(reference)} of the reference")
    masked = replace(samples, finite=samples.finite & known)
    shortest = samples.duration(min_samples, min_duration, 4 + 2 * drop_edge)
    found = []
    for start, stop in _constant_runs(reference, np.flatnonzero(known), samples.ticks, tolerance):
        dwell = dwell_of(masked, start, stop, drop_edge) if stop - start >= shortest else None
        if dwell is not None:
            held = reference[dwell.start : dwell.stop]
            found.append(replace(dwell, applied=np.nanmean(held, axis=0)))
    if not found:
        raise DataError(
            f"the reference is nowhere constant (within {tolerance:g}) for {shortest} samples",
            do="Give its tolerance, or detect the dwells of the reference itself",
            code="no_dwells",
        )
    return tuple(found)


def _constant_runs(reference: Array, rows: NDArray[np.int64], ticks: Array, tolerance: float) -> list[tuple[int, int]]:
    """Stretches [start, stop) in which the reference neither steps nor wanders nor has a long gap."""
    if not len(rows):
        return []
    values = reference[rows]
    broken = (np.abs(np.diff(values, axis=0)) > tolerance).any(axis=1) | (np.diff(ticks[rows]) > LONGEST_GAP)
    edges = np.r_[0, np.flatnonzero(broken) + 1, len(rows)]
    span = np.maximum.reduceat(values, edges[:-1]) - np.minimum.reduceat(values, edges[:-1])
    steady = (span <= 2.0 * tolerance).all(axis=1)
    runs = zip(edges[:-1][steady], edges[1:][steady], strict=True)
    return [(int(rows[a]), int(rows[b - 1]) + 1) for a, b in runs]
