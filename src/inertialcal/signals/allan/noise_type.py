"""Noise type at an averaging time, by the lag-1 autocorrelation of averages (see ``edf``)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array, Numbers
from .autocovariance import covariance_of_terms, weights_of
from .gaps import FILL
from .loops import exponent_between, loops_for
from .prefix import Phase

Whole = NDArray[np.int64]
LOOKED_AT = 2048  # averages that identify a noise type, to 0.02 in the lag-1 autocorrelation
STRETCH = 64  # neighbouring averages looked at together where there are more
STARTS = 4  # starting points that averages are taken from where there are few
LINE = 2.0  # by how much over their number a line lowers the lag-1 autocorrelation of white averages
SMALL_ENOUGH = 0.2  # lag-1 autocorrelation below which averages need no (further) difference
FEWEST = 30  # averages that identify a noise type (Riley and Greenhall)


def places(points: int, m: int) -> Whole:
    """Return the points at which averages of m samples begin, and the last of them ends, shape (stretches, n + 1).

    Of few averages the same again from other starting points, one average less each.
    """
    many, size, apart = _stretches(points, m)
    return np.arange(many)[:, None] * apart + np.arange(size + 1) * m


def _stretches(points: int, m: int) -> tuple[int, int, int]:
    """Return the number of stretches, averages in each, and points from the first of one to that of the next."""
    averages = (points - 1) // m
    if averages > LOOKED_AT:
        many, size = LOOKED_AT // STRETCH, STRETCH
        return many, size, (averages - STRETCH) // (many - 1) * m
    many = min(STARTS, m, LOOKED_AT // max(1, averages))
    return (many, max(averages - 1, 0), m // many) if many > 1 else (1, averages, 0)


def identified(phase: Phase, factors: Whole, most: int) -> Array:
    """Return the exponent of the noise at averaging factors, shape (k,); NaN for too few averages.

    ``most`` is how often averages are differenced at most.
    """
    if not phase.complete:
        return np.array([_identified_with_gaps(phase, m, most) for m in factors.tolist()])
    where, lost, known = looked_at(len(phase.values), factors.tobytes(), most)
    found = np.empty(len(factors))
    loops_for(len(phase.values)).fill_exponents(phase.values, factors, where, lost, SMALL_ENOUGH, known, found)
    return found


@lru_cache(maxsize=8)
def looked_at(points: int, factors: bytes, most: int) -> tuple[Whole, Array, Array]:
    """Return which averages of a complete record are looked at, and what loops compare them with; not to be changed."""
    sizes = np.frombuffer(factors, np.int64).tolist()
    where, known = np.zeros((len(sizes), 3), np.int64), np.full((len(sizes), most + 1, 2 * most + 3), np.nan)
    for k, m in enumerate(sizes):
        many, size, apart = _stretches(points, m)
        shared = many if many > 1 and apart < m else 1
        if many * size + shared > FEWEST * shared:
            where[k] = many, size, apart
            for times in range(most + 1):
                known[k, times, : 2 * times + 3] = _autocorrelations(m, times)
    return where, LINE / ((points - 1) // np.array(sizes)), known


def _identified_with_gaps(phase: Phase, m: int, most: int) -> float:
    p, count = phase.values, phase.count
    at = places(len(p), m)
    y = 1.0 * np.diff(p[at], axis=1)
    if phase.pointwise:
        there = count[at + 1] > count[at]
        kept = there[:, :-1] & there[:, 1:]
    else:
        present = np.diff(count[at], axis=1)
        kept = present * FILL >= m
        y *= m / np.maximum(present, 1)
    return exponent_of(np.where(kept, y, 0.0), kept.astype(float), at, m, len(p), most)


def identified_at(at: Whole, values: Numbers, points: int, m: int, most: int) -> float:
    """Return the same of a complete record of which only ``values`` of the integrated signal at ``at`` are known."""
    where = places(points, m)
    y = 1.0 * np.diff(values[np.searchsorted(at, where)], axis=1)
    return exponent_of(y, np.ones(y.shape), where, m, points, most)


def exponent_of(y: Array, kept: Array, at: Whole, m: int, points: int, most: int) -> float:
    """Return the exponent that averages tell, side by side in each row, 0 where they are not ``kept``."""
    shared = len(at) if len(at) > 1 and at[1, 0] < m else 1  # starting points that the same averages were taken from
    if kept.sum() + shared <= FEWEST * shared:
        return np.nan
    time, level = kept * at[:, :-1], y.sum() / kept.sum()
    time = kept * (time - time.sum() / kept.sum())
    y = y - kept * level - (np.vdot(time, y - kept * level) / np.vdot(time, time)) * time
    lost, times = LINE / ((points - 1) // m), 0  # what taking a line off took from the autocorrelation
    while True:
        squares = np.vdot(y, y)
        r = np.vdot(y[:, 1:], y[:, :-1]) / squares + (lost if times == 0 else 0.0) if squares > 0.0 else np.nan
        if not r >= SMALL_ENOUGH or times >= most:
            break
        kept = kept[:, 1:] * kept[:, :-1]
        y, times = kept * np.diff(y, axis=1), times + 1
    return exponent_between(float(r), np.array(_autocorrelations(m, times)))


@lru_cache(maxsize=1024)
def _autocorrelations(m: int, times: int) -> tuple[float, ...]:
    """Return the lag-1 autocorrelation of averages differenced so often, of noise of exponent 2, 1, ... -2 times."""
    weights = weights_of(times + 1)
    both = [covariance_of_terms(np.array([1.0 * m, 0.0]), m, p, weights) for p in range(2 * times + 3)]
    return tuple(float(one / zero) for one, zero in both)
