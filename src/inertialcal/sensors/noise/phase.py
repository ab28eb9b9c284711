"""Sampled noise through the covariance of its running sum: one form for every term and every deviation.

A sample is the mean of the noise over ``averaging`` seconds, taken every ``interval``. Most terms have no variance,
but every contrast of the samples has one, and it follows from a generalised covariance ``C`` of their running sum
x_n = y_0 + ... + y_(n-1) [1]_: for weights w that sum to zero, and whose first moments do for rate noise that
wanders, ``var(sum w_i x_i) = sum w_i w_j C(i - j)``. Even polynomials of C drop out of it and are left away, so that
what remains has no more rounding than the answer. Here, at a lag of j samples::

    C(j) = point [j = 0] - linear |j| / 2 + cubic |j|^3 / 12 + flicker (j^2 ln|j| / 2 - dead-time part)
           - sum of g E(j; u) + sum of cosines

- ``linear`` is the variance of a sample where samples are independent, ``cubic`` that of a step from sample to sample
  of a random walk, ``point`` that of independent errors of the running sum itself;
- ``flicker`` is h of the one-sided spectrum h / f; with dead time its samples differ from those of neighbouring means
  by a summable covariance, added exactly;
- ``exponentials`` (g, u): covariance g exp(-u j) between samples.

A ramp is no noise: it adds the constant ``ramp`` times m to each second difference of means over m samples.

References
----------
.. [1] G. Matheron, Adv. Appl. Prob. 5 (1973) 439: generalised covariance of intrinsic random functions.
.. [2] IEEE Std 952-1997, Annex C; IEEE Std 1293-2018, Annex I: the continuous limits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array

SERIES_FROM = 30  # lag from which the dead-time part of flicker is summed as a series
_FACTORIALS = tuple(float(special.factorial(order)) for order in range(14, 2, -1))
SMALL = 0.5  # argument below which a series has more digits than differences have


@dataclass(frozen=True)
class Phase:
    """Covariance of the running sum of the samples, shape of C in the module head.

    Parameters
    ----------
    point, linear, cubic, flicker : float
        Sizes of the parts [unit^2], unit being that of a sample.
    duty : float
        Averaging time over interval; 1 without dead time.
    exponentials : tuple of (float, float)
        Covariance of neighbouring samples' common part [unit^2], and interval over correlation time.
    cosines : tuple of (float, float)
        Variance of the sampled sinusoid [unit^2], and cycles a sample.
    ramp : float
        Change from sample to sample [unit].
    """

    point: float = 0.0
    linear: float = 0.0
    cubic: float = 0.0
    flicker: float = 0.0
    duty: float = 1.0
    exponentials: tuple[tuple[float, float], ...] = ()
    cosines: tuple[tuple[float, float], ...] = ()
    ramp: float = 0.0

    def __add__(self, other: Phase) -> Phase:
        """Sum of independent noises sampled alike."""
        return Phase(
            self.point + other.point,
            self.linear + other.linear,
            self.cubic + other.cubic,
            self.flicker + other.flicker,
            other.duty if other.flicker else self.duty,
            self.exponentials + other.exponentials,
            self.cosines + other.cosines,
            float(np.hypot(self.ramp, other.ramp)),
        )

    def covariance(self, lags: Array | NDArray[np.int64]) -> Array:
        """Return C at lags in samples, of their shape [unit^2]."""
        j = np.abs(np.asarray(lags, dtype=float))
        found = self.point * (j == 0.0) - 0.5 * self.linear * j + self.cubic * j**3 / 12.0
        if self.flicker:
            logs = np.log(np.where(j > 0.0, j, 1.0))
            found = found + self.flicker * (0.5 * j**2 * logs - dead_time_part(j, self.duty))
        for size, u in self.exponentials:
            found = found - size * twice_summed_exponential(j, u)
        for variance, cycles in self.cosines:
            found = found + variance * np.cos(2.0 * np.pi * cycles * j) / (2.0 * np.sin(np.pi * cycles)) ** 2
        return np.asarray(found)


def twice_summed_exponential(lags: Array, u: float) -> Array:
    """Return E, whose second difference is exp(-u |j|) but for a constant, at lags j >= 0.

    It is ``(exp(-u j) - 1) a + (1/2 + a (1 - exp(-u))) j - a u^2 j^2 / 2`` with a = 1 / (4 sinh^2(u / 2)), arranged so
    that nothing cancels for correlation times much longer than a record; the even last part has no effect.
    """
    gain, excess = exponential_gain(np.array(u))
    return np.asarray(gain * remainder(u * lags) + excess * lags)


def exponential_gain(u: Array) -> tuple[Array, Array]:
    """Return a of `twice_summed_exponential`, and what stands before |j| beside the remainder, of the shape of u."""
    half = 0.5 * np.minimum(u, 300.0)
    gain = 0.25 / np.sinh(half) ** 2
    return gain, np.asarray(0.5 * _one_less_squared_ratio(half) - gain * remainder(u))


def remainder(x: Array) -> Array:
    """Return exp(-x) - 1 + x - x^2 / 2, x >= 0."""
    near = np.minimum(x, SMALL)
    series = np.zeros_like(near)
    for factorial in _FACTORIALS:  # Horner, x^3 taken out
        series = 1.0 / factorial - near * series
    return np.asarray(np.where(x < SMALL, -(near**3) * series, np.expm1(-x) + x - 0.5 * x**2))


def _one_less_squared_ratio(x: Array) -> Array:
    """Return 1 - (x / sinh x)^2."""
    series = x**2 / 3.0 - x**4 / 15.0 + 2.0 * x**6 / 189.0
    return np.asarray(np.where(x < 0.05, series, 1.0 - (x / np.sinh(x)) ** 2))


def flicker_covariance(lags: Array, duty: float) -> Array:
    """Return the covariance of samples of 1/f noise of h = 1, up to a constant, at lags j >= 0."""

    def twice(t: Array) -> Array:
        size = np.abs(t)
        return np.asarray(0.5 * size**2 * np.log(np.where(size > 0.0, size, 1.0)))

    near = np.minimum(lags, SERIES_FROM)
    exact = 1.5 - (twice(near + duty) - 2.0 * twice(near) + twice(near - duty)) / duty**2
    far = np.maximum(lags, SERIES_FROM)
    series = -np.log(far) + duty**2 / (12.0 * far**2) + duty**4 / (60.0 * far**4) + duty**6 / (168.0 * far**6)
    return np.asarray(np.where(lags < SERIES_FROM, exact, series))


def dead_time_part(lags: Array, duty: float) -> Array:
    """Return the twice summed difference between the covariances of flicker with and without dead time, h = 1."""
    if duty == 1.0:
        return np.zeros_like(lags)
    head, first, second = _heads(duty)
    n = np.maximum(lags, 1.0)
    near = np.minimum(n, SERIES_FROM).astype(np.int64)
    sums, moments = first[near], second[near]
    far = np.maximum(n, SERIES_FROM)
    for power, size in ((2, duty**2 - 1.0), (4, (duty**4 - 1.0) / 5.0), (6, (duty**6 - 1.0) / 14.0)):
        sums = sums + size / 12.0 * (special.zeta(power, SERIES_FROM) - special.zeta(power, far))
        if power == 2:
            moments = moments + size / 12.0 * (special.digamma(far) - special.digamma(SERIES_FROM))
        else:
            moments = moments + size / 12.0 * (special.zeta(power - 1, SERIES_FROM) - special.zeta(power - 1, far))
    return np.asarray(np.where(lags > 0.0, lags * (0.5 * head + sums) - moments, 0.0))


@lru_cache(32)
def _heads(duty: float) -> tuple[float, Array, Array]:
    """Difference at lag 0; its sums, and those of lag times difference, over lags 1 to n - 1, up to SERIES_FROM."""
    lags = np.arange(SERIES_FROM, dtype=float)
    difference = flicker_covariance(lags, duty) - flicker_covariance(lags, 1.0)
    first, second = np.zeros(SERIES_FROM + 1), np.zeros(SERIES_FROM + 1)
    first[2:] = np.cumsum(difference[1:])
    second[2:] = np.cumsum((lags * difference)[1:])
    return float(difference[0]), first, second
