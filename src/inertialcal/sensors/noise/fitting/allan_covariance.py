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
from ..expected import density_of_samples
from ..terms import SERIES_FROM, Phase, dead_time_part, exponential_gain

NO_BEAT = 1e-9  # sine of a frequency that is no beat: the sum of two lines at the sample rate
TAIL = 8.0  # of a correlation time, and of both averaging times, beyond which nothing is summed
NEAR = 2  # distances from a kink that are summed one by one
GROWTH = 8.0  # lengths of neighbouring panels beyond
SMALL = 0.05  # lag in correlation times below which an exponential less its first terms is summed as a series
LAGS = [(a, b, (2.0 - 3.0 * abs(a)) * (2.0 - 3.0 * abs(b))) for a in (-1, 0, 1) for b in (-1, 0, 1)]  # (1, -2, 1) twice


def covariance_of_allan(phase: Phase, m: Array, n: Array, inflation: Array | None = None) -> Array:
    """Return the covariance of overlapping Allan variances, shape (k, k) [unit^4]."""
    slope = dead_time_part(np.array([float(SERIES_FROM) * 100.0]), phase.duty)[0] / (SERIES_FROM * 100.0)
    linear = phase.linear + 2.0 * phase.flicker * slope  # what dead time adds to flicker is short, and taken as white
    sizes = np.array([phase.point, linear, phase.cubic, phase.flicker])
    parts = np.array(phase.exponentials).reshape(-1, 2)
    exponentials = np.column_stack([parts, *exponential_gain(parts[:, 1])])
    slowest = float(exponentials[:, 1].min()) if len(exponentials) else np.inf
    wanders = TAIL * float(m[-1]) * (phase.flicker > 0.0)
    reach = max(TAIL / slowest, wanders, 2.0)
    m, n = np.asarray(m, dtype=float), np.asarray(n, dtype=float)
    row, column = np.triu_indices(len(m))
    m1, m2, n1, n2 = m[row], m[column], n[row], n[column]
    last = np.floor(np.maximum(np.minimum((n1 + n2) / 2.0 - 1.0, reach + m1 + m2), 0.0))
    lags = _lags(m1.tobytes(), m2.tobytes(), last.tobytes())
    pair, size = lags.pair, lags.size
    even = inflation is None or bool(np.all(inflation == 1.0))
    more = 1.0 if inflation is None or even else np.sqrt(inflation[row] * inflation[column])[pair]
    s = _second_differences(lags, sizes, exponentials, more) / size
    squares = 0.5 * s * s
    if phase.ramp:
        squares += phase.ramp**2 * size * s
    squares *= lags.windows(n1.tobytes(), n2.tobytes())
    out = np.empty((len(m), len(m)))
    out[row, column] = 2.0 * np.bincount(pair, squares, len(m1)) / (n1 * n2)  # t and -t are alike
    out[column, row] = out[row, column]
    for line in phase.cosines:
        out += noise_on_line(phase, line, m, n)
    for i, line in enumerate(phase.cosines):
        out += ends_of_lines(line, line, m, n)
        for other in phase.cosines[:i]:
            out += ends_of_lines(line, other, m, n)
    return out


@dataclass(frozen=True, eq=False)
class Lags:
    """All that is summed, and second differences there of the powers of a lag: no phase is in them."""

    pair: NDArray[np.int64]  # which pair of averaging times, shape (t,)
    distance: Array  # of the differences, shape (t,) [samples]
    weight: Array  # shape (t,)
    m1: Array  # of the pair, shape (t,) [samples]
    m2: Array
    counted: dict[tuple[bytes, ...], Array] = field(default_factory=dict)  # of `windows`, what was asked for last

    @cached_property
    def size(self) -> Array:
        """Of the pair: m1 m2, shape (t,)."""
        return self.m1 * self.m2

    def windows(self, *n: bytes) -> Array:
        """Return how many pairs of differences there are so far apart, times the weight, shape (t,).

        Given are the numbers of differences of either averaging time of each pair, as bytes; not to be changed.
        """
        if n not in self.counted:
            n1, n2 = map(np.frombuffer, n)
            there = np.minimum(np.minimum(n1, n2)[self.pair], (n1 + n2)[self.pair] / 2.0 - self.distance)
            self.counted.clear()
            self.counted[n] = self.weight * np.maximum(there, 0.0)
        return self.counted[n]

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


@lru_cache(8)  # a fit asks for the same again and again
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


def _second_differences(lags: Lags, sizes: Array, exponentials: Array, more: Array | float) -> Array:
    """Return m1 m2 times the covariance of differences of neighbouring means over m1 and m2 samples, shape (t,).

    That is C of ``phase.Phase``, without lines, at nine lags; sizes are point, linear, cubic and flicker, ``more`` what
    missing samples multiply the linear one by. Rows of ``exponentials`` are size, u, gain and excess (see
    ``phase.twice_summed_exponential``).
    """
    point, linear, cubic, flicker = (sizes * (1.0, -0.5, 1.0 / 12.0, 0.5)).tolist()
    total: Array = linear * more * lags.linear
    if point:
        total += point * lags.none
    if cubic:
        total += cubic * lags.cubic
    if flicker:
        total += flicker * lags.flicker

    def exponential(j: Array) -> Array:
        found = np.zeros(len(j))
        for part, u, gain, excess in exponentials:
            x = u * j
            decay = np.exp(-x) - 1.0 + x - 0.5 * x * x
            small = np.flatnonzero(x < SMALL)
            x = x[small]
            decay[small] = -x * x * x * (1.0 - x * 0.25 * (1.0 - x * 0.2 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))) / 6.0
            found -= part * (gain * decay + excess * j)
        return found

    return total + lags.differences(exponential) if len(exponentials) else total


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
