"""Covariance of overlapping Allan variances of noise of known terms.

Assumed: normal noise of known terms (``terms``). For differences d_k(m) of neighbouring means, whose covariance s at
any distance follows from that of the running sum (``terms.Phase``), means of d^2 / 2 have the covariance [1]_::

    cov = sum over pairs of ( s^2 / 2 + mu mu' s ) / (number of pairs)

where mu is what is not noise, a ramp. The sum runs over the windows of the record; away from the distances where s has
kinks it is taken by panels of distances (to a thousandth of a correlation). For a line, whose mu mu' swings, the sum is
the spectrum of the noise there::

    cov = a P(f) h(m)^2 h(m')^2 / max(n, n'),    h(m) = (2 cos(2 pi f m T) - 2) / m

with P the density of the running sum and a the variance of the line in it. The Allan variance of a line itself swings
with its phase, by a share sin(2 pi f n T) / (n sin(2 pi f T)) of its size. Neighbouring octaves are correlated by 0.5
to 0.7.

With gaps the number of pairs is scaled to the number of terms present, as if gaps lay together, and the white part of s
is raised by the root of both ``inflation``: means of fewer samples scatter more, as in the expected variance. With
single missing samples the variance at two samples a window comes out 15 to 25 % low, that at one sample a few per cent
high; at all others, and in the size of white noise, 5 % remain.

References
----------
.. [1] L. Isserlis, Biometrika 12 (1918) 134: fourth moments of normal quantities; used for Allan variances in
   C. A. Greenhall and W. J. Riley, Proc. 35th PTTI (2003) 267.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from .._kernels import add_differences, lags_of
from ..expected import density_of_samples
from ..terms import SERIES_FROM, Phase, dead_time_part, exponential_gain

NO_BEAT = 1e-9  # sine of a frequency that is no beat: the sum of two lines at the sample rate
TAIL = 8.0  # of a correlation time, and of both averaging times, beyond which nothing is summed
ONE, NO_PARTS = np.ones(1), np.empty((0, 4))
LAGS = [(a, b, (2.0 - 3.0 * abs(a)) * (2.0 - 3.0 * abs(b))) for a in (-1, 0, 1) for b in (-1, 0, 1)]  # (1, -2, 1) twice


def covariance_of_allan(phase: Phase, m: Array, n: Array, inflation: Array | None = None) -> Array:
    """Return the covariance of overlapping Allan variances, shape (k, k) [unit^4]."""
    found = squares_of((phase,), m, n, inflation)
    out = np.empty((len(m), len(m)))
    out[found.row, found.column] = out[found.column, found.row] = found.values[0]
    return out


@dataclass(frozen=True, eq=False)
class Squares:
    """What noises give together: the covariance of their sum is quadratic in the sizes of their variances."""

    # Averaging times of each pair, shape (p,)
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    values: Array  # shape (q (q + 1) / 2, p): Of noises 0 0, 1 0, 1 1, 2 0, ... [unit^4]


def squares_of(phases: Sequence[Phase], m: Array, n: Array, inflation: Array | None = None) -> Squares:
    """Return what independent noises of known size give together."""
    parts = [u for one in phases for _, u in one.exponentials]
    wanders = TAIL * float(m[-1]) * any(one.flicker > 0.0 for one in phases)
    m, n = np.asarray(m, dtype=float), np.asarray(n, dtype=float)
    raised = None if inflation is None or np.all(inflation == 1.0) else inflation.tobytes()
    known = _design(m.tobytes(), n.tobytes(), raised, max(TAIL / min(parts, default=np.inf), wanders, 2.0))
    row, column = known.pairs
    noises = [Noise(known, one) for one in phases]
    found = [one.square(other) for i, one in enumerate(noises) for other in noises[: i + 1]]
    values = 2.0 * np.array(found) / (n[row] * n[column])  # t and -t are alike
    both = [(one, other) for i, one in enumerate(phases) for other in phases[: i + 1]]
    for i, (one, other) in enumerate(both):
        if one.cosines or other.cosines:
            values[i] += _with_lines(one, other, m, n)[row, column]
    return Squares(row, column, values)


def _with_lines(one: Phase, other: Phase, m: Array, n: Array) -> Array:
    """Return what lines of one noise and another add, shape (k, k)."""
    out = np.zeros((len(m), len(m)))
    for noise, lines in ((one, one),) if one is other else ((one, other), (other, one)):
        for line in lines.cosines:
            out += noise_on_line(noise, line, m, n)
    for i, line in enumerate(one.cosines):
        for second in one.cosines[: i + 1] if one is other else other.cosines:
            out += ends_of_lines(line, second, m, n)
    return out


@dataclass(frozen=True, eq=False)
class Design:
    """What the covariance takes of the averaging times alone, whatever the noise: the same of all records of a length.

    Where noise has no exponentials, its covariance is made of the powers of a lag.
    """

    pairs: tuple[NDArray[np.intp], NDArray[np.intp]]  # both averaging times of each pair, shape (p,)
    lags: Lags
    windows: Array  # weight of each lag, shape (t,)
    more: Array  # what missing samples multiply the linear part by, shape (t,); of one number where none is missing
    _squares: dict[tuple[int, int], Array] = field(default_factory=dict)  # sums of products of powers, shape (p,)

    def power(self, i: int) -> Array:
        """Return weighted second differences of a power: linear, none, cubic, flicker; shape (t,)."""
        if i == 0:
            return np.asarray(self.lags.linear * self.more)
        return (self.lags.none, self.lags.cubic, self.lags.flicker)[i - 1]

    def square(self, i: int, j: int) -> Array:
        """Return the weighted sum of the product of two powers over the lags of each pair; of one, where j is -1."""
        if (i, j) not in self._squares:
            size = self.lags.size
            terms = self.power(i) if j < 0 else self.power(i) * (self.power(j) / size) / size
            self._squares[i, j] = self.sum_of(terms)
        return self._squares[i, j]

    def sum_of(self, terms: Array) -> Array:
        """Return the weighted sum of something over the lags of each pair, shape (p,)."""
        return np.asarray(np.bincount(self.lags.pair, self.windows * terms, len(self.pairs[0])), dtype=np.float64)


class Noise:
    """A noise of known size, at the lags of a design."""

    def __init__(self, design: Design, phase: Phase) -> None:
        """Take what it has of each power of a lag."""
        # what dead time adds to flicker is short, taken as white
        linear = phase.linear + 2.0 * phase.flicker * _slope(phase.duty)
        self._design, self._ramp = design, phase.ramp**2
        self._sizes = (-0.5 * linear, phase.point, phase.cubic / 12.0, 0.5 * phase.flicker)
        self._parts = phase.exponentials

    @cached_property
    def _there(self) -> list[tuple[int, float]]:
        return [(i, size) for i, size in enumerate(self._sizes) if size]

    @cached_property
    def _lags(self) -> Array:
        """Covariance s at each lag, shape (t,); exponentials are no fixed powers."""
        lags, exponentials = self._design.lags, NO_PARTS
        if self._parts:
            parts = np.array(self._parts)
            exponentials = np.column_stack([parts, *exponential_gain(parts[:, 1])])
        found = lags.of(*self._sizes[:2], self._design.more, exponentials)
        for i, size in self._there:
            if i >= 2:
                found += size * self._design.power(i)
        return found / lags.size

    def square(self, other: Noise) -> Array:
        """Return the sum over the lags of each pair, shape (p,): of itself, or of what two add to those of each."""
        found, same = np.zeros(len(self._design.pairs[0])), self is other
        if self._parts or other._parts:
            found += self._design.sum_of(self._lags * other._lags)
        else:
            for i, one in self._there:
                for j, two in other._there:
                    found += one * two * self._design.square(i, j)
        if same:
            found *= 0.5
        for ramp, noise in ((self._ramp, self),) if same else ((self._ramp, other), (other._ramp, self)):
            if ramp and noise._parts:
                found += ramp * self._design.sum_of(noise._lags * self._design.lags.size)
            elif ramp:
                for i, size in noise._there:
                    found += ramp * size * self._design.square(i, -1)
        return found


@lru_cache(32)  # a fit asks for the same again and again, and fits of records of one length
def _design(m: bytes, n: bytes, inflation: bytes | None, reach: float) -> Design:
    """Return what all noise has in common that is summed up to a reach [samples], not to be changed."""
    sizes, numbers = np.frombuffer(m), np.frombuffer(n)
    row, column = np.triu_indices(len(sizes))
    m1, m2, n1, n2 = sizes[row], sizes[column], numbers[row], numbers[column]
    last = np.floor(np.maximum(np.minimum((n1 + n2) / 2.0 - 1.0, reach + m1 + m2), 0.0))
    lags = _lags(m1.tobytes(), m2.tobytes(), last.tobytes())
    there = np.minimum(np.minimum(n1, n2)[lags.pair], (n1 + n2)[lags.pair] / 2.0 - lags.distance)
    raised = np.ones(len(sizes)) if inflation is None else np.frombuffer(inflation)
    more = np.ones(1) if inflation is None else np.sqrt(raised[row] * raised[column])[lags.pair]
    return Design((row, column), lags, lags.weight * np.maximum(there, 0.0), more)


@dataclass(frozen=True, eq=False)
class Lags:
    """All that is summed, and second differences there of the powers of a lag: no phase is in them."""

    pair: NDArray[np.int64]  # which pair of averaging times, shape (t,)
    distance: Array  # of the differences, shape (t,) [samples]
    weight: Array  # shape (t,)
    m1: Array  # of the pair, shape (t,) [samples]
    m2: Array

    @cached_property
    def size(self) -> Array:
        """Of the pair: m1 m2, shape (t,)."""
        return self.m1 * self.m2

    @cached_property
    def none(self) -> Array:
        """Of 1 where the lag is zero, shape (t,)."""
        return self.of(0.0, 1.0)

    @cached_property
    def linear(self) -> Array:
        """Of the lag."""
        return self.of(1.0, 0.0)

    def of(self, linear: float, none: float, more: Array = ONE, exponentials: Array = NO_PARTS) -> Array:
        """Return those of a sum of these, the first raised, and of exponentials: see ``_kernels.add_differences``."""
        found = np.zeros(len(self.distance))
        add_differences(self.distance, self.m1, self.m2, more, linear, none, exponentials, found)
        return found

    @cached_property
    def cubic(self) -> Array:
        """Of its cube: of large ones little is left."""
        return self.differences(lambda j: j * j * j, extended=True)

    @cached_property
    def flicker(self) -> Array:
        """Of its square times its logarithm."""
        return self.differences(lambda j: j * j * np.log(np.where(j > 0.0, j, 1.0)))

    def differences(self, function: Callable[[Array], Array], extended: bool = False) -> Array:
        """Return the weighted sum of a function of the nine lags, shape (t,), in extended precision where wanted."""
        number: type[np.floating[Any]] = np.longdouble if extended else np.float64
        distance, m1, m2 = (one.astype(number) for one in (self.distance, self.m1, self.m2))
        total = np.zeros_like(distance)
        for a, b, factor in LAGS:
            total += number(factor) * function(np.abs(distance + b * m2 - a * m1))
        return total.astype(np.float64)


@lru_cache(32)  # records that differ in what is missing share them
def _lags(*given: bytes) -> Lags:
    """Return all that is summed, not to be changed.

    Distances of each pair go from 0 (half) to its ``last``; given are m1, m2 and last as bytes. A pair, m1 <= m2, has
    its kinks. Between them, and away from them, panels of distances are summed by the three
    nodes that are exact for polynomials of degree five.
    """
    m1, m2, last = (np.frombuffer(one).copy() for one in given)
    of, distance, weight = lags_of(m1, m2, last)
    return Lags(of, distance, weight, m1[of], m2[of])


@lru_cache(32)
def _slope(duty: float) -> float:
    """Return what dead time adds to the covariance of flicker at long lags, a sample."""
    lag = float(SERIES_FROM) * 100.0
    return float(dead_time_part(np.array([lag]), duty)[0] / lag)


def noise_on_line(phase: Phase, line: tuple[float, float], m: Array, n: Array) -> Array:
    """Return what noise times a line adds, shape (k, k) [unit^4]; a line as in ``phase``."""
    power = float(density_of_samples(phase, np.array([line[1]]))[0]) / (2.0 * np.sin(np.pi * line[1])) ** 2
    h = (2.0 * np.cos(2.0 * np.pi * line[1] * m) - 2.0) / m
    found = _root(line, m) * h
    return np.asarray(2.0 * power * np.outer(found, found) / np.maximum(n, n[:, None]))


def ends_of_lines(one: tuple[float, float], other: tuple[float, float], m: Array, n: Array) -> Array:
    """Return what it adds that a record holds no whole number of cycles, for lines of unknown phase, shape (k, k)."""
    total = np.zeros((len(m), len(m)))
    alike = one is other
    for cycles in (one[1] + other[1],) if alike else (one[1] + other[1], one[1] - other[1]):
        sine = np.sin(np.pi * cycles)
        share = np.sin(np.pi * cycles * n) / (n * sine) if abs(sine) > NO_BEAT else np.ones(len(n))
        swing = _root(one, m) * _root(other, m) * share
        total += (0.5 if alike else 2.0) * np.outer(swing, swing)
    return total


def _root(line: tuple[float, float], m: Array) -> Array:
    """Root of the Allan variance of a line, with the sign of its differences, shape (k,)."""
    variance, cycles = line
    h = (2.0 * np.cos(2.0 * np.pi * cycles * m) - 2.0) / m
    return np.asarray(np.sqrt(0.5 * variance) / (2.0 * np.sin(np.pi * cycles)) * h)


def model_edf(variance: Array, covariance: Array) -> Array:
    """Return the equivalent degrees of freedom 2 variance^2 / var of Allan variances, shape (k,)."""
    return np.asarray(2.0 * variance**2 / np.diag(covariance))
