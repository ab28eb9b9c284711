"""Equivalent degrees of freedom of a variance, and the chi-square interval of the deviation that follows.

A variance is the mean of M squares of correlated normal terms z. It is spread like a chi-square variable of

    edf = M / (1 + 2 sum over j < M of (1 - j / M) r(j)^2)

degrees of freedom divided by edf, with r the autocorrelation of the terms: twice the square of the mean over its
variance [1]_, eq. (10) to (13). There, r is that of the continuous process behind the noise (with a table of constants
for long windows); here it is that of the sampled noise itself, with spectrum |2 sin(pi f)|^alpha, whose generalised
autocovariance is known in closed form [2]_: ``Gamma(k + q) / Gamma(k + 1 - q)`` with q = 1 - alpha / 2 for the
integrated signal, or its product with the digamma function of k + 1/2 where q is half an odd number. So white noise
has, at the shortest averaging time, 2/3 of a degree a term; the continuous form gives 17 % more there.

Assumed: stationary differences, normal noise of one type around each averaging time. Of non-normal noise the interval
is too narrow. Few squares that are strongly correlated are not quite chi-square: beyond an eighth of the record the
intervals are rather too wide.

Noise type at each averaging time, by the lag-1 autocorrelation of the averages.

Averages of m samples side by side, a line taken off, are differenced until their lag-1 autocorrelation r is below 0.2
(``rho = r / (1 + r)`` below about 1/4 [3]_, where after d differences alpha is -2 (rho + d)). That relation is of
fractionally differenced noise, which averages are not: averages of a random walk have r = 1/4 after one difference,
not 0. So alpha is interpolated between the values that averages of m samples of each noise have, by the
autocovariances of ``edf``, rounded to a whole number and cut to what the deviation converges for. The line lowers r of
n averages by 2 / n on average (white noise), which is given back.

Of a long record 2,048 averages are looked at, in 32 stretches spread evenly: they tell alpha to 0.05. Of a short
one the same averages are taken from up to four starting points. Fewer than 30 averages cannot tell the type [3]_:
there, of the types of the two longest averaging times that tell, the one stands that leaves fewer degrees of freedom.

Of two terms the bluer fades with longer averaging. So noise bluer than white is believed at an averaging time only
if it was found at all shorter ones; else few averages of white noise would pass for it by chance, and its
intervals would be far too narrow.

References
----------
.. [1] Greenhall and Riley, Uncertainty of stability variances based on finite differences, Proc. 35th PTTI, 2003,
   267-280.
.. [2] Kasdin, Discrete simulation of colored noise and stochastic processes, Proc. IEEE 83 (1995) 802-827.
.. [3] Riley and Greenhall, Power law noise identification using the lag 1 autocorrelation, Proc. 18th EFTF, 2004.
.. [4] Riley, Handbook of frequency stability analysis, NIST SP 1065, 2008, sections 5.2.11 to 5.2.14 and 5.4.
.. [5] Howe et al., A total estimator of the Hadamard function used for GPS operations, Proc. 32nd PTTI, 2000.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array
from .autocovariance import covariance_of_terms, weights_of
from .deviations import ALLAN, Kind, terms_of
from .noise_type import identified
from .prefix import Phase

BLUEST = 2  # exponent of the spectrum of the rate: quantisation of the integral
FIRST = -4  # exponent of the reddest noise that a deviation converges for
WHITE = 0.0
FEW = 3  # channels from which on degrees of freedom repeat
LAGS = 32  # lags a window, of the autocorrelation behind the degrees of freedom ...
GRADE = 0.1  # ... and how much farther each from a whole window where it has logarithms there
LONG = 8  # samples of a window from which published degrees of freedom of total variances hold
SETTLED = 32  # samples of a window from which the bias of mirrors no longer changes
# degrees of freedom of total variances by noise type: b, c of b T / tau - c ([4]_, tables 7 and 8), and of the Hadamard
# total variance b, c of (T / tau) / (b + c tau / T) ([5]_, table 1)
PUBLISHED: dict[str, dict[int, tuple[float, float]]] = {
    "total deviation": {0: (1.50, 0.0), -1: (1.17, 0.22), -2: (0.93, 0.36)},
    "modified total deviation": {2: (1.90, 2.10), 1: (1.20, 1.40), 0: (1.10, 1.20), -1: (0.85, 0.50), -2: (0.75, 0.31)},
    "Hadamard total deviation": {
        0: (0.559, 1.004), -1: (0.868, 1.140), -2: (0.938, 1.696), -3: (0.974, 2.554), -4: (1.276, 3.149)
    },
}  # fmt: skip
TOTAL_LOSS = {-1: 1.0 / (3.0 * np.log(2.0)), -2: 0.75}  # bias of the total variance: 1 less so many tau / T [4]_


def degrees_of_freedom(kind: Kind, m: int, terms: int, power: int) -> float:
    """Return the equivalent degrees of freedom of one variance of windows of m samples; NaN without terms.

    Of total deviations also NaN where none is published: in the noise of an angle (1, 2) that is not averaged twice.

    ``power`` is the exponent alpha of the spectrum of the rate: 2 quantisation, 0 white (random walk of the integral),
    -1 flicker (bias instability), -2 random walk of the rate, to -4 for the Hadamard deviations.
    """
    if terms <= 0:
        return np.nan
    return _total_edf(kind, m, terms, power) if kind.total else _plain_edf(kind, m, terms, power)


def _plain_edf(kind: Kind, m: int, terms: int, power: int) -> float:
    return _edf(kind.order, kind.overlapping, kind.modified, m, terms, power)


def _total_edf(kind: Kind, m: int, terms: int, power: int) -> float:
    """Return the degrees of freedom of a total variance: published for long windows, else by those without mirrors.

    Published ones hold from about `LONG` samples on. Below, the degrees of freedom without mirrors are raised by what
    mirrors add at `LONG` samples; windows of one sample have no mirrors that tell. Of the modified total variance
    beyond an eighth of the record, 2,000 simulated records have fewer than published (random walk at 3/16: 2.5, not
    3.7): a third is taken of what mirrors add to those without.
    """
    n = _samples(kind, m, terms)
    known = PUBLISHED[kind.words].get(power)
    if known is None:
        return np.nan

    def published(size: int) -> float:
        one, other = known
        ratio = n / size
        return one * ratio - other if kind.order == ALLAN else ratio / (one + other / ratio)

    def plain(size: int) -> float:
        return _plain_edf(kind, size, int(terms_of(replace(kind, total=False), n + 1, np.array([size]))[0]), power)

    if kind.modified and 8 * m > n:
        return plain(m) + (published(m) - plain(m)) / 3.0
    if m >= LONG:
        return published(m)
    return plain(m) * (published(LONG) / plain(LONG) if m > 1 and n >= 4 * LONG else 1.0)


def _samples(kind: Kind, m: int, terms: int) -> int:
    """Return how many samples a record has that gives so many terms of a total variance."""
    if kind.order == ALLAN and not kind.modified:
        return terms + 1
    return terms + 3 * m - 1 - kind.modified


def bias_of(kind: Kind, m: int, terms: int, power: int) -> float:
    """Return the mean of a total variance over that of the variance without mirrors, in noise of one type.

    Of the total variance by its limit for long windows [4]_, 1 where none is published. Of the others the mean of a
    quadratic form, by the autocovariance of the noise; beyond `SETTLED` samples it no longer changes.
    """
    if kind.order == ALLAN and not kind.modified:
        return float(1.0 - TOTAL_LOSS.get(power, 0.0) * m / _samples(kind, m, terms))
    return 1.0 if m == 1 and not kind.modified else _mirrored(kind.modified, min(m, SETTLED), power)


@lru_cache(maxsize=256)
def _mirrored(modified: bool, m: int, power: int) -> float:
    """Return the bias of the modified or the Hadamard total variance; weights are of the integrated signal."""
    n = 3 * m
    half = n // 2
    slope = np.zeros(n)
    slope[n - half :] += 1.0 / half / (n - half)
    slope[:half] -= 1.0 / half / (n - half)
    own = np.eye(n) - np.outer(np.arange(n), slope)
    whole = np.concatenate((own[::-1], own, own[::-1]))  # rows: points of the mirrored stretch
    sums = np.cumsum(np.concatenate((np.zeros((1, n)), whole)), axis=0)
    windows = sums[m:] - sums[:-m]
    z = windows[: 6 * m] - 2.0 * windows[m : 7 * m] + windows[2 * m : 8 * m]
    plain = np.repeat([1.0, -2.0, 1.0], m)
    if not modified:  # samples are differences of the integrated signal
        z, plain = (np.diff(one, prepend=0.0, append=0.0) * -1.0 for one in (z, plain))
    lags = np.arange(z.shape[1])
    table = covariance_of_terms(lags.astype(np.float64), 1, BLUEST - power, np.ones(1))
    covariance = table[np.abs(lags[:, None] - lags)]
    return float(np.mean(np.einsum("ij,jk,ik->i", z, covariance, z)) / (plain @ covariance @ plain))


@lru_cache(maxsize=4096)
def _edf(order: int, overlapping: bool, modified: bool, m: int, terms: int, power: int) -> float:
    differences = order + modified
    exponent = BLUEST - power + 2 * modified  # of the integrated signal, once more where windows are averaged
    weights, stride = weights_of(differences), 1 if overlapping else m
    length = float(terms) * stride
    lag = _lags(m, stride, min(1.0 * (differences + 1) * m, length), exponent)  # beyond, differences share no noise
    correlation = covariance_of_terms(lag, m, exponent, weights)
    squares = np.maximum(0.0, 1.0 - lag / length) * (correlation / correlation[0]) ** 2
    if exponent == 0:  # only whole windows share noise
        return float(length / (stride * (2.0 * squares.sum() - squares[0])))
    return float(length / (2.0 * np.sum(0.5 * np.diff(lag) * (squares[1:] + squares[:-1]))))


def _lags(m: int, stride: int, span: float, exponent: int) -> Array:
    """Return the lags of a trapezoidal rule, in steps of 1 / LAGS of a window or of ``stride`` samples.

    They are closer to whole windows where the autocovariance has logarithms there, and whole windows alone where only
    these share noise.
    """
    if exponent == 0:
        return np.asarray(np.arange(np.ceil(span / m)) * m, dtype=np.float64)
    if exponent > 1:
        gap = max(1.0 * stride, m / LAGS)
        return np.arange(np.ceil(span / gap) + 1.0) * gap
    found = [0.0]
    while found[-1] < span:
        passed = found[-1] % m
        found.append(found[-1] + max(1.0 * stride, min(m - passed, GRADE * min(passed, m - passed) // 1)))
    return np.array(found)


def interval(deviation: Array, edf: Array, p: float) -> tuple[Array, Array]:
    """Return both ends of the interval of a deviation, with equal tails; NaN where there are no degrees of freedom.

    Parameters
    ----------
    deviation, edf : ndarray, shape (k, axes)
        Deviation [its unit] and its equivalent degrees of freedom.
    p : float
        Probability of the interval.
    """
    tail = 0.5 * (1.0 - p)
    known, at = np.unique(edf, return_inverse=True) if edf.shape[1] > FEW else (edf, ...)
    lo, hi = (np.sqrt(known / special.chdtri(known, chance))[at] for chance in (tail, 1.0 - tail))
    return deviation * lo.reshape(edf.shape), deviation * hi.reshape(edf.shape)


def all_degrees(kind: Kind, factors: NDArray[np.int64], terms: NDArray[np.int64], power: Array) -> Array:
    """Return the degrees of freedom of whole powers, shape (k,) or (k, channels)."""
    known, found = _degrees(kind, factors.tobytes(), terms.tobytes())
    places = np.arange(len(factors))
    at = (power - FIRST).astype(np.int64), places if power.ndim == 1 else places[:, None]
    if not known[at].all():
        rows, columns = np.broadcast_arrays(*at)
        for row, k in {*zip(rows.ravel().tolist(), columns.ravel().tolist(), strict=True)}:
            if not known[row, k]:
                found[row, k] = degrees_of_freedom(kind, int(factors[k]), int(terms[k]), row + FIRST)
                known[row, k] = True
    return np.asarray(found[at])


@lru_cache(maxsize=8)
def _degrees(kind: Kind, factors: bytes, terms: bytes) -> tuple[NDArray[np.bool_], Array]:
    """Return room for the degrees of freedom by power and averaging factor, and which are known: none at first."""
    many = len(np.frombuffer(factors, np.int64))
    return np.zeros((BLUEST + 1 - FIRST, many), dtype=bool), np.empty((BLUEST + 1 - FIRST, many))


def identified_powers(phase: Phase, kind: Kind, factors: NDArray[np.int64]) -> Array:
    """Return the exponent at each averaging factor, rising, shape (k,); NaN where averages are too few."""
    return believed_powers(identified(phase, factors, -kind.reddest // 2), kind)


def believed_powers(found: Array, kind: Kind) -> Array:
    """Return whole exponents that a deviation converges for, and none bluer than those at shorter averaging times.

    Of shape (k,) or (k, channels), as they are given.
    """
    power = np.clip(np.rint(found), kind.reddest, BLUEST)
    bluest = np.fmin.accumulate(np.fmax(power, WHITE))
    return np.asarray(np.where(np.isnan(power), np.nan, np.fmin(power, bluest)))


def carried_on(power: Array, kind: Kind, factors: NDArray[np.int64], terms: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the exponent everywhere, and the degrees of freedom with it, both of shape (k,) or (k, channels).

    A power that is NaN is that of the last one known; white where none is. Of channels, the same ones are known.
    """
    known = power[np.isfinite(power).all(axis=1)] if power.ndim > 1 else power[np.isfinite(power)]
    last, before = (known[-1], known[-2:][0]) if len(known) else (WHITE, WHITE)
    one, other = (np.where(np.isnan(power), value, power) for value in (last, before))
    edf = all_degrees(kind, factors, terms, one)
    if np.all(last == before):
        return one, edf
    fewer = all_degrees(kind, factors, terms, other)
    lower = fewer < edf
    return np.where(lower, other, one), np.where(lower, fewer, edf)
