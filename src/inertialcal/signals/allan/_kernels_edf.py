"""Compiled sums over lags behind the degrees of freedom: numbers in, a number out, no checks."""

from __future__ import annotations

import math

from ...core.estimate import Array
from ...statistics._kernels import compiled

LAGS = 32  # lags a window, of the autocorrelation behind the degrees of freedom ...
GRADE = 0.1  # ... and how much farther each from a whole window where it has logarithms there


@compiled
def _digamma_half(k: float) -> float:
    """Digamma function of k + 1/2, k >= 0: recurrence up to 8, then its asymptotic series."""
    total = 0.0
    while k < 8.0:
        total -= 1.0 / (k + 0.5)
        k += 1.0
    q = 1.0 / (k * k)
    return total + math.log(k) + q * (1.0 / 24.0 - q * (7.0 / 960.0 - q * 31.0 / 8064.0))


@compiled
def _covariance(k: float, p: int) -> float:
    """Generalised autocovariance at lag k of noise with spectrum |2 sin(pi f)|^-p, but for a factor."""
    k = abs(k)
    if p == 0:
        return 1.0 if k == 0.0 else 0.0
    found = k if p % 2 == 0 else _digamma_half(k)
    shift = 0.0 if p % 2 == 0 else 0.5
    for i in range(1, (p - 1) // 2 + 1):
        found *= k * k - (i - shift) ** 2
    return found


@compiled
def covariance_of_terms(lag: float, m: float, p: int, weights: Array) -> float:
    """Autocovariance of the terms at a lag, by the weights of the differences on both sides."""
    middle = len(weights) // 2
    total = 0.0
    for i in range(len(weights)):
        total += weights[i] * _covariance(lag + (i - middle) * m, p)
    return total


@compiled
def degrees_of_freedom(m: int, terms: float, stride: int, p: int, weights: Array, reach: int) -> float:
    """Return edf of the mean of squares of ``terms`` differences, ``stride`` samples apart.

    ``reach`` is how many windows apart differences still share noise. The sum over lags is a trapezoidal rule over
    1 / LAGS of a window, and finer beside whole windows where the autocovariance has logarithms there (p = 1).
    """
    at_0 = covariance_of_terms(0.0, m, p, weights)
    length = terms * stride
    span = min(1.0 * reach * m, length)
    total, lag, before, gap = 0.0, 0.0, 1.0, 1.0 * m
    if p == 0:  # only whole windows share noise
        total = 0.5 * stride
        while lag + gap < span:
            lag += gap
            total += stride * (1.0 - lag / length) * (covariance_of_terms(lag, m, p, weights) / at_0) ** 2
        return length / (2.0 * total)
    while lag < span:
        gap = max(1.0 * stride, m / LAGS)
        if p == 1:
            left = m - lag % m
            gap = max(1.0 * stride, min(left, math.floor(GRADE * min(lag % m, left))))
        lag += gap
        here = max(0.0, 1.0 - lag / length) * (covariance_of_terms(lag, m, p, weights) / at_0) ** 2
        total += 0.5 * gap * (before + here)
        before = here
    return length / (2.0 * total)
