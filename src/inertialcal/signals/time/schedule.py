"""Dwells whose edges are known beforehand: from a commanded rate, or from a schedule.

Two neighbouring dwells at a low rate (0.006 deg/s beside 0, at a noise of 0.004 deg/s) cannot be told apart
from the signal alone; here the cut is exact, however small the step. ``segments`` finds the dwells of a
signal that stands alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Numbers
from ...core.recording import Times
from ..segmentation.dwells import Dwell, dwell_of
from .samples import LONGEST_GAP, Indices, samples_of

ROUNDING = 1e-9  # by which a stated tolerance may be exceeded
FIRST_PART = 64  # samples: a dwell is rarely shorter


def dwells_by_windows(
    windows_ns: Sequence[tuple[int, int]], signal: Numbers, time_ns: Times, *, drop_edge: int = 1
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
                why=f"need {2 + 2 * drop_edge} or more, as {drop_edge} are dropped at each end",
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
    applied: Numbers,
    signal: Numbers,
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
        Largest deviation of a held value from its middle [unit of ``applied``]; zero for a commanded one.
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
        If lengths differ, or the reference is never constant for long enough.
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
            whole = known[dwell.start : dwell.stop].all()
            found.append(replace(dwell, applied=held.mean(axis=0) if whole else np.nanmean(held, axis=0)))
    if not found:
        raise DataError(
            f"the reference is never constant (within {tolerance:g}) for {shortest} samples",
            do="Give its tolerance, or detect the dwells of the reference itself",
            code="no_dwells",
        )
    return tuple(found)


def _constant_runs(reference: Array, rows: Indices, ticks: Array, tolerance: float) -> list[tuple[int, int]]:
    """Stretches [start, stop) in which the reference spans no more than twice its tolerance, nor has a long gap."""
    if not len(rows):
        return []
    span = 2.0 * tolerance * (1.0 + ROUNDING)
    broken = np.diff(ticks[rows]) > LONGEST_GAP
    broken |= (np.abs(np.diff(reference[rows], axis=0)) > span).any(axis=1)
    edges = np.concatenate(([0], np.flatnonzero(broken) + 1, [len(rows)]))
    runs = []
    for first, after in pairwise(edges.tolist()):
        at = first
        while at < after:  # a slow ramp has no step: it is cut where it has gone too far
            held = at + _held(reference[rows[at:after]], span)
            runs.append((int(rows[at]), int(rows[held - 1]) + 1))
            at = held
    return runs


def _held(values: Array, span: float) -> int:
    """Count the first values that lie within a span, one or more; looked through in growing parts."""
    part = FIRST_PART
    while True:
        head = values[:part]
        wide = np.maximum.accumulate(head) - np.minimum.accumulate(head)
        gone = np.flatnonzero((wide > span).any(axis=1))
        if gone.size:
            return int(gone[0])
        if part >= len(values):
            return len(values)
        part *= 4
