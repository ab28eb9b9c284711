"""Gauge R&R: what the test itself scatters, from units tested again, against what it states.

A figure of unit i at station j, k-th time::

    y_ijk = mean + part_i + station_j + (part x station)_ij + repeat_ijk

all independent. Repeatability is the repeat, from all tests of one unit at one station; reproducibility station and
interaction, the gauge all three [1]_. These are told from the units that every station tested, by the analysis of
variance of the means of cells (unweighted means [2]_): with ``h`` the harmonic mean of the tests in a cell, P units
and ``SS`` the mean squares of stations and of what is left of the cells::

    both^2 = SS_left - repeat^2 / h      station^2 = (SS_station - SS_left) / P

Intervals are those of generalized pivots: each mean square over a chi-square with its degrees of freedom, their sum
cut at zero. What no unit repeats is not estimated: without repeats at one station repeat and interaction cannot be
told apart and are given together.

``stated`` is what the tests state of their own scatter, root mean square: ``ratio`` is repeatability over it, 1 where
the uncertainties are honest.

What breaks this: units that changed between their tests (their change counts as repeatability); fewer than five
repeated units or two stations (intervals are wide, as they should be); a repeat that is a copy of the first file.

References
----------
.. [1] AIAG, Measurement Systems Analysis, 4th edition, 2010, chapter III B; R. K. Burdick, C. M. Borror and
   D. C. Montgomery, Design and Analysis of Gauge R&R Studies, SIAM, 2005.
.. [2] R. K. Burdick, C. M. Borror and D. C. Montgomery, J. Quality Technology 35 (2003) 342-354.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.results import Interval
from .scatter import P, chi_squares

DISTINCT = math.sqrt(2.0)  # AIAG: 1.41 parts over the gauge


@dataclass(frozen=True)
class Size:
    """A standard deviation with its interval of 95 %; the low end is 0 where it may be none."""

    value: float
    interval: Interval


@dataclass(frozen=True)
class Gauge:
    """What a test scatters.

    Parameters
    ----------
    units, tests, stations : int
        Repeated units, their tests, and the stations of these.
    crossed : int
        Units that every station tested: reproducibility rests on them.
    repeatability : Size
        Of one test after another at one station; with the interaction, where ``apart`` is false.
    reproducibility : Size or None
        Between stations; None for one station, or without two units that all tested.
    gauge : Size
        Both together.
    part : float
        Scatter between the repeated units.
    apart : bool
        Whether any unit was tested twice at one station.
    stated : float
        Own uncertainty that the tests state, root mean square.
    ratio : Interval
        Repeatability over that, 95 %.
    excess, lack : float
        Probability of so large, and of so small, a repeatability if what the tests state were right.
    dof : int
        Degrees of freedom of the repeatability.
    """

    units: int
    tests: int
    stations: int
    crossed: int
    repeatability: Size
    reproducibility: Size | None
    gauge: Size
    part: float
    apart: bool
    stated: float
    ratio: Interval
    excess: float
    lack: float
    dof: int

    @property
    def distinct(self) -> int:
        """Number of distinct categories that the gauge tells apart in these units."""
        return int(DISTINCT * self.part / self.gauge.value) if self.gauge.value else 0

    def share_of(self, parts: float) -> float:
        """Return the gauge as a share of all that is seen of a population that scatters so."""
        whole = math.hypot(self.gauge.value, parts)
        return self.gauge.value / whole if whole else math.nan


def gauge(values: Array, own: Array, dof: Array, units: NDArray[np.intp], stations: NDArray[np.intp]) -> Gauge:
    """Return what a test scatters, from units that were tested several times.

    Parameters
    ----------
    values, own, dof : ndarray, shape (n,)
        Figures of tests, the standard uncertainty of each that its repeat draws anew, its degrees of freedom.
    units, stations : ndarray of int, shape (n,)
        Of each test; units that were tested once are left out.

    Raises
    ------
    DataError
        ``no_repeats`` for fewer than two repeated units; ``no_scatter`` for repeats that are equal.
    """
    times = np.bincount(units)
    order = np.argsort(units, kind="stable")
    repeated = order[times[units[order]] > 1]
    numbers = units[repeated]
    every = np.unique(numbers)
    if every.size < 2:
        raise DataError(
            f"{every.size} unit(s) tested more than once",
            why="what the test itself scatters is not known",
            do="Test some units again, at each station",
            code="no_repeats",
        )
    y, part, place = values[repeated], units[repeated], stations[repeated]
    part, place = (np.unique(one, return_inverse=True)[1].reshape(-1) for one in (part, place))
    counts = np.zeros((part.max() + 1, place.max() + 1))
    np.add.at(counts, (part, place), 1.0)
    sums = np.zeros(counts.shape)
    np.add.at(sums, (part, place), y)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = sums / counts
    rest = y - means[part, place]
    free = y.size - int(np.count_nonzero(counts))
    square = float(rest @ rest) / free if free else 0.0
    if free and not square:
        raise DataError("repeated tests give equal figures", do="Look for copied files", code="no_scatter")
    crossed = (counts > 0.0).all(axis=1)
    table, often = means[crossed], counts[crossed]
    p, s = table.shape
    stated = math.sqrt(float(np.mean(own[repeated] ** 2)))
    wide, narrow = _excess(square, free, own[repeated], dof[repeated])
    apart = free > 0
    middle = np.nanmean(means, axis=1)
    if s < 2 or p < 2:
        if not apart:
            what = "no unit was tested twice at one station, nor two at all stations"
            raise DataError(what, do="Test some units again, at each station", code="no_repeats")
        repeat = _size(square, square / chi_squares(free)[0])
        ratio, parts = _ratio(repeat, stated), float(np.var(middle, ddof=1)) - square / float(counts[counts > 0].mean())
        return Gauge(every.size, y.size, s, p if s > 1 else 0, repeat, None, repeat, math.sqrt(max(parts, 0.0)), apart,
                     stated, ratio, wide, narrow, free)  # fmt: skip
    harmonic = often.size / float(np.sum(1.0 / often))
    left = table - table.mean(axis=1, keepdims=True) - table.mean(axis=0) + table.mean()
    ms_left = float(np.sum(left**2)) / ((p - 1) * (s - 1))
    ms_station = p * float(np.var(table.mean(axis=0), ddof=1))
    ms_part = s * float(np.var(table.mean(axis=1), ddof=1))
    drawn = chi_squares(*([free] if apart else []), (p - 1) * (s - 1), s - 1)
    of_left, of_station = ms_left / drawn[-2], ms_station / drawn[-1]
    part_found = math.sqrt(max((ms_part - ms_left) / s, 0.0))
    repeats = square / drawn[0] if apart else of_left
    inner = harmonic if apart else 1.0  # without repeats the interaction stands for them
    square = square if apart else ms_left
    between = of_left + (of_station - of_left) / p - repeats / inner
    best = max(ms_left + (ms_station - ms_left) / p - square / inner, 0.0)
    repeat = _size(square, repeats)
    return Gauge(every.size, y.size, s, p, repeat, _size(best, between), _size(square + best, repeats + between),
                 part_found, apart, stated, _ratio(repeat, stated), wide, narrow,
                 free if apart else (p - 1) * (s - 1))  # fmt: skip


def _size(square: float, drawn: Array) -> Size:
    """Return the root of a variance, with the interval of its draws."""
    low, high = np.sqrt(np.maximum(np.quantile(drawn, [(1 - P) / 2, (1 + P) / 2]), 0.0))
    return Size(math.sqrt(square), Interval(float(low), float(high), P))


def _ratio(size: Size, stated: float) -> Interval:
    low, high = size.interval.lo, size.interval.hi
    if low is None or high is None or not stated:
        return Interval(None, None, P)
    return Interval(low / stated, high / stated, P)


def _excess(square: float, free: int, own: Array, dof: Array) -> tuple[float, float]:
    """Return the probability of so large, and of so small, a variance of repeats, for the dof of what is stated."""
    stated = float(np.mean(own**2))
    if not stated or not free:
        return 1.0, 1.0
    spread = float(np.sum(own**4 / dof)) / own.size**2
    known = min(stated**2 / spread, 1e9) if spread else 1e9
    return float(special.fdtrc(free, known, square / stated)), float(special.fdtr(free, known, square / stated))
