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

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from .._kernels import fill_covariance
from ..expected import density_of_samples
from ..terms import SERIES_FROM, Phase, dead_time_part, exponential_gain

NO_BEAT = 1e-9  # sine of a frequency that is no beat: the sum of two lines at the sample rate
TAIL = 8.0  # of a correlation time, and of both averaging times, beyond which nothing is summed
NEAR = 2  # distances from a kink that are summed one by one
GROWTH = 8.0  # lengths of neighbouring panels beyond
NONE = np.empty(0)
LAGS = [(a, b, (2.0 - 3.0 * abs(a)) * (2.0 - 3.0 * abs(b))) for a in (-1, 0, 1) for b in (-1, 0, 1)]  # (1, -2, 1) twice


def covariance_of_allan(phase: Phase, m: Array, n: Array, inflation: Array | None = None) -> Array:
    """Return the covariance of overlapping Allan variances, shape (k, k) [unit^4]."""
    linear = phase.linear + 2.0 * phase.flicker * _slope(phase.duty)  # what dead time adds is short, taken as white
    parts = np.array(phase.exponentials).reshape(-1, 2)
    slowest = float(parts[:, 1].min()) if len(parts) else np.inf
    wanders = TAIL * float(m[-1]) * (phase.flicker > 0.0)
    m, n = np.asarray(m, dtype=float), np.asarray(n, dtype=float)
    raised = None if inflation is None or np.all(inflation == 1.0) else inflation.tobytes()
    known = _design(m.tobytes(), n.tobytes(), raised, max(TAIL / slowest, wanders, 2.0))
    sizes = np.array([-0.5 * linear, phase.point, phase.cubic / 12.0, 0.5 * phase.flicker])
    row, column = known.pairs
    found = known.sums(sizes, phase.ramp) if not len(parts) else known.with_exponentials(sizes, parts, phase.ramp)
    out = np.empty((len(m), len(m)))
    out[row, column] = 2.0 * found / (n[row] * n[column])  # t and -t are alike
    out[column, row] = out[row, column]
    for line in phase.cosines:
        out += noise_on_line(phase, line, m, n)
    for i, line in enumerate(phase.cosines):
        out += ends_of_lines(line, line, m, n)
        for other in phase.cosines[:i]:
            out += ends_of_lines(line, other, m, n)
    return out


@dataclass(frozen=True, eq=False)
class Design:
    """What the covariance takes of the averaging times alone, whatever the noise: the same of all records of a length.

    Where noise has no exponentials, it is quadratic in the sizes of the powers of a lag.
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
            sums = np.bincount(self.lags.pair, self.windows * terms, len(self.pairs[0]))
            self._squares[i, j] = np.asarray(sums, dtype=np.float64)
        return self._squares[i, j]

    def sums(self, sizes: Array, ramp: float) -> Array:
        """Return the sum over the lags of each pair, shape (p,)."""
        found = np.zeros(len(self.pairs[0]))
        there = np.flatnonzero(sizes).tolist()
        for i in there:
            for j in there:
                if j <= i:
                    found += (0.5 if i == j else 1.0) * sizes[i] * sizes[j] * self.square(i, j)
            if ramp:
                found += ramp**2 * sizes[i] * self.square(i, -1)
        return found

    def with_exponentials(self, sizes: Array, parts: Array, ramp: float) -> Array:
        """Return the same of noise with exponentials, which are no fixed powers; rows of parts are size and u."""
        exponentials = np.column_stack([parts, *exponential_gain(parts[:, 1])])
        powers = tuple(self.power(i) if size else NONE for i, size in enumerate(sizes.tolist()))
        found, lags = np.zeros(len(self.pairs[0])), self.lags
        fill_covariance(
            lags.pair, self.windows, lags.size, lags.distance, lags.m1, lags.m2, powers, tuple(sizes.tolist()),
            exponentials, ramp, found,
        )  # fmt: skip
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
        return self.differences(lambda j: j == 0.0)

    @cached_property
    def linear(self) -> Array:
        """Of the lag."""
        return self.differences(lambda j: j)

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
    m1, m2, last = map(np.frombuffer, given)
    number = np.arange(len(m1))
    kinks = np.minimum([0.0 * m1, np.minimum(m1, m2 - m1), np.maximum(m1, m2 - m1), m2, m2 + m1, last], last)
    part, pair = np.nonzero(kinks[1:] > kinks[:-1])
    end = kinks[1:][part, pair]
    at, distance, weight = [number, pair], [0.0 * m1, end], [np.full(len(m1), 0.5), np.ones(len(pair))]
    both, lo, hi = part < len(kinks) - 2, kinks[part, pair] + 1.0, end - 1.0  # a kink at either end; what is left
    done, panels = 0, [(pair[:0], lo[:0], lo[:0])]
    while (left := lo <= hi).any():
        both, pair, lo, hi = both[left], pair[left], lo[left], hi[left]
        length = 1.0 if done < NEAR else NEAR * GROWTH ** (done - NEAR)
        size = np.minimum(length, np.where(both, np.maximum(np.ceil((hi - lo + 1.0) / 2.0), 1.0), hi - lo + 1.0))
        panels.append((pair, lo, size))
        lo = lo + size
        again = both & (lo <= hi)
        size = np.where(again, np.minimum(size, hi - lo + 1.0), 0.0)
        panels.append((pair[again], (hi - size + 1.0)[again], size[again]))
        hi, done = hi - size, done + 1
    pair, lo, size = (np.concatenate(each) for each in zip(*panels, strict=True))
    few, nodes = size <= NEAR, size > NEAR
    at += [pair[few], pair[size == NEAR]]
    distance += [lo[few], lo[size == NEAR] + 1.0]
    pair, size, middle = pair[nodes], size[nodes], (lo + 0.5 * (size - 1.0))[nodes]
    outer = (3.0 * size**2 - 7.0) / 20.0
    ends, by = size * (size**2 - 1.0) / (24.0 * outer), np.sqrt(outer)
    at += [pair, pair, pair]
    distance += [middle, middle - by, middle + by]
    weight += [np.ones(len(each)) for each in distance[2:4]] + [size - 2.0 * ends, ends, ends]
    of = np.concatenate(at)
    return Lags(of, np.concatenate(distance), np.concatenate(weight), m1[of], m2[of])


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
