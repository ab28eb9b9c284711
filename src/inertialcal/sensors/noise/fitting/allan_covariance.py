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
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from .._kernels import lags_of
from .._kernels_squares import Lags as Summed
from .._kernels_squares import fill_pairs, fill_squares, fill_straight, fill_windows
from ..expected import density_of_samples
from ..terms import SERIES_FROM, Phase, dead_time_part, exponential_gain

NO_BEAT = 1e-9  # sine of a frequency that is no beat: the sum of two lines at the sample rate
TAIL = 8.0  # of a correlation time, and of both averaging times, beyond which nothing is summed
ONE = np.ones(1)
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
    row: NDArray[np.int64]
    column: NDArray[np.int64]
    values: Array  # shape (q (q + 1) / 2, p): Of noises 0 0, 1 0, 1 1, 2 0, ... [unit^4]


def squares_of(phases: Sequence[Phase], m: Array, n: Array, inflation: Array | None = None) -> Squares:
    """Return what independent noises of known size give together."""
    of = np.array([i for i, one in enumerate(phases) for _ in one.exponentials], dtype=np.int64)
    parts = np.array([part for one in phases for part in one.exponentials]).reshape(1, -1, 2)
    row, column, (values,) = squares_of_each(phases, np.array([sizes_of(phases)]), of, parts, m, n, inflation)
    if any(one.cosines for one in phases):
        both = [(one, other) for i, one in enumerate(phases) for other in phases[: i + 1]]
        for i, (one, other) in enumerate(both):
            if one.cosines or other.cosines:
                values[i] += _with_lines(one, other, np.asarray(m), np.asarray(n))[row, column]
    return Squares(row, column, values)


def sizes_of(phases: Sequence[Phase]) -> list[tuple[float, float, float, float, float]]:
    """Return sizes of noises as ``fill_squares`` takes them: lag, 1 at zero, cube, flicker, ramp squared."""
    # what dead time adds to flicker is short, taken as white
    linear = [one.linear + (2.0 * one.flicker * _slope(one.duty) if one.flicker else 0.0) for one in phases]
    return [
        (-0.5 * white, one.point, one.cubic / 12.0, 0.5 * one.flicker, one.ramp**2)
        for white, one in zip(linear, phases, strict=True)
    ]


def squares_of_each(
    phases: Sequence[Phase], sizes: Array, of: NDArray[np.int64], parts: Array, m: Array, n: Array,
    inflation: Array | None = None,
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:  # fmt: skip
    """Return pairs of averaging times and what noises of each series give together, shape (n, q (q + 1) / 2, p).

    Series are of one sampling, and of noises like ``phases``: with sizes (n, q, 5) of their own, and exponentials
    (n, e, 2) of the noise that each is ``of``.
    """
    m, n = np.array(m, dtype=float), np.array(n, dtype=float)
    raised = None if inflation is None or np.all(inflation == 1.0) else inflation.tobytes()
    exponentials = np.concatenate([parts, np.stack(exponential_gain(parts[..., 1]), axis=-1)], axis=-1)
    longest = TAIL / parts[..., 1].min(axis=1, initial=np.inf)
    wanders = TAIL * float(m[-1]) * any(one.flicker > 0.0 for one in phases)
    reach = np.minimum(np.maximum(longest, max(wanders, 2.0)), n.max())
    slow = any(one.cubic > 0.0 or one.flicker > 0.0 for one in phases)  # else nothing but exponentials is far away
    values = np.empty((len(sizes), sizes.shape[1] * (sizes.shape[1] + 1) // 2, len(m) * (len(m) + 1) // 2))
    for near in np.unique(reach).tolist() if slow else [0.0]:
        at = reach == near if slow else np.ones(len(sizes), np.bool_)
        known = _design(m.tobytes(), n.tobytes(), raised, near)
        cubic = known.lags.cubic if any(one.cubic > 0.0 for one in phases) else ONE
        flicker = known.lags.flicker if any(one.flicker > 0.0 for one in phases) else ONE
        found, beyond = np.empty((np.count_nonzero(at), *values.shape[1:])), np.zeros(len(at)) if slow else reach
        pairs = m, n, *known.pairs
        fill_squares(known.arrays, cubic, flicker, pairs, beyond, sizes[at], of, exponentials[at], found)
        values[at] = found
    return *known.pairs, values


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
    """What the covariance takes of the averaging times alone, whatever the noise: alike for records of a length."""

    pairs: tuple[NDArray[np.int64], NDArray[np.int64]]  # both averaging times of each pair, shape (p,)
    lags: Lags
    windows: Array  # weight of each lag, shape (t,)
    more: Array  # what missing samples multiply the linear part by, shape (t,); of one number where none is missing

    @property
    def arrays(self) -> Summed:
        """What ``_kernels_squares`` takes of it."""
        lags = self.lags
        return lags.pair, lags.distance, lags.m1, lags.m2, *lags.straight, self.windows, self.more


@lru_cache(32)  # a fit asks for the same again and again, and fits of records of one length
def _design(m: bytes, n: bytes, inflation: bytes | None, reach: float) -> Design:
    """Return what all noise has in common that is summed up to a reach [samples], not to be changed."""
    sizes, numbers = np.frombuffer(m).copy(), np.frombuffer(n).copy()
    count = len(sizes) * (len(sizes) + 1) // 2
    row, column, (m1, m2, last) = np.empty(count, np.int64), np.empty(count, np.int64), np.empty((3, count))
    fill_pairs(sizes, numbers, float(reach), row, column, m1, m2, last)
    lags = _lags(m1.tobytes(), m2.tobytes(), last.tobytes())
    windows = lags.weight.copy()
    fill_windows(numbers, row, column, lags.pair, lags.distance, windows)
    raised = np.ones(len(sizes)) if inflation is None else np.frombuffer(inflation)
    more = np.ones(1) if inflation is None else np.sqrt(raised[row] * raised[column])[lags.pair]
    return Design((row, column), lags, windows, more)


@dataclass(frozen=True, eq=False)
class Lags:
    """All that is summed, and second differences there of the powers of a lag: no phase is in them."""

    pair: NDArray[np.int64]  # which pair of averaging times, shape (t,)
    distance: Array  # of the differences, shape (t,) [samples]
    weight: Array  # shape (t,)
    m1: Array  # of the pair, shape (t,) [samples]
    m2: Array

    @cached_property
    def straight(self) -> tuple[Array, Array]:
        """Of itself, and of 1 where it is zero."""
        found = np.empty_like(self.distance), np.empty_like(self.distance)
        fill_straight(self.distance, self.m1, self.m2, *found)
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
