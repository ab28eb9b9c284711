"""Sums over lags behind the degrees of freedom and the noise type: numbers in, a number out, no checks.

Few lags, in numpy: a compiler takes longer to start than all of them together.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ...core.estimate import Array

LAGS = 32  # lags a window, of the autocorrelation behind the degrees of freedom ...
GRADE = 0.1  # ... and how much farther each from a whole window where it has logarithms there


def _digamma_half(k: Array) -> Array:
    """Digamma function of k + 1/2, k >= 0: recurrence up to 8, then its asymptotic series."""
    total, k = np.zeros(k.shape), k.copy()
    while (low := k < 8.0).any():
        total[low] -= 1.0 / (k[low] + 0.5)
        k[low] += 1.0
    q = 1.0 / (k * k)
    return np.asarray(total + np.log(k) + q * (1.0 / 24.0 - q * (7.0 / 960.0 - q * 31.0 / 8064.0)))


def _covariance(k: Array, p: int) -> Array:
    """Generalised autocovariance at lags k of noise with spectrum |2 sin(pi f)|^-p, but for a factor."""
    k = np.abs(k)
    if p == 0:
        return np.where(k == 0.0, 1.0, 0.0)
    found = k if p % 2 == 0 else _digamma_half(k)
    shift = 0.0 if p % 2 == 0 else 0.5
    for i in range(1, (p - 1) // 2 + 1):
        found = found * (k * k - (i - shift) ** 2)
    return found


def covariance_of_terms(lag: Array, m: float, p: int, weights: Array) -> Array:
    """Autocovariance of the terms at lags, by the weights of the differences on both sides."""
    middle = len(weights) // 2
    total = np.zeros(len(lag))
    for i, weight in enumerate(weights.tolist()):
        total += weight * _covariance(lag + (i - middle) * m, p)
    return total


@lru_cache(maxsize=4096)
def neighbours(m: int, power: int, differences: int) -> float:
    """Return the autocorrelation of neighbouring averages of m samples, differenced, of noise of an exponent."""
    weights = np.ones(2 * differences + 3)
    for i in range(1, len(weights)):  # (-1)^i times the binomial coefficients
        weights[i] = -weights[i - 1] * (len(weights) - i) / i
    weights *= 1.0 if differences % 2 else -1.0
    at = covariance_of_terms(np.array([0.0, 1.0 * m]), m, 2 - power, weights)
    return float(at[1] / at[0])


def degrees_of_freedom(m: int, terms: float, stride: int, p: int, weights: Array, reach: int) -> float:
    """Return edf of the mean of squares of ``terms`` differences, ``stride`` samples apart.

    ``reach`` is how many windows apart differences still share noise. The sum over lags is a trapezoidal rule over
    1 / LAGS of a window, and finer beside whole windows where the autocovariance has logarithms there (p = 1).
    """
    length = terms * stride
    span = min(1.0 * reach * m, length)
    if p == 0:  # only whole windows share noise
        lags = m * np.arange(1.0, max(1.0, math.ceil(span / m)))
        gaps = np.full(len(lags), 1.0 * stride)
    else:
        lags, gaps = _graded(m, stride, span, p)
    r = covariance_of_terms(np.append(0.0, lags), m, p, weights)
    shared = np.maximum(0.0, 1.0 - lags / length) * (r[1:] / r[0]) ** 2
    if p == 0:
        return float(length / (stride + 2.0 * np.sum(gaps * shared)))
    return float(length / np.sum(gaps * (np.append(1.0, shared[:-1]) + shared)))


def _graded(m: int, stride: int, span: float, p: int) -> tuple[Array, Array]:
    """Return lags up to the first beyond a span, and the gap before each."""
    lag, lags, gaps = 0.0, [], []
    while lag < span:
        gap = max(1.0 * stride, m / LAGS)
        if p == 1:
            left = m - lag % m
            gap = max(1.0 * stride, min(left, math.floor(GRADE * min(lag % m, left))))
        lag += gap
        lags.append(lag)
        gaps.append(gap)
    return np.array(lags), np.array(gaps)
