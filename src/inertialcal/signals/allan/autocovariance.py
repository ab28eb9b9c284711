"""Autocovariance of differences of averages, of noise with spectrum |2 sin(pi f)|^-p of the integrated signal."""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np
from scipy import special

from ...core.estimate import Array


def covariance_of_terms(lag: Array, m: int, p: int, weights: Array) -> Array:
    """Return the autocovariance of differences at lags [samples], by their ``weights_of``, but for a factor."""
    windows = np.arange(len(weights)) - len(weights) // 2
    k = np.abs(lag[..., None] + 1.0 * m * windows)
    if p == 0:
        return np.asarray((k == 0.0) @ weights)
    found, shift = (k, 0.0) if p % 2 == 0 else (special.digamma(k + 0.5), 0.5)
    for i in range(1, (p - 1) // 2 + 1):
        found = found * (k * k - (i - shift) ** 2)
    return np.asarray(found @ weights)


@lru_cache(maxsize=8)
def weights_of(differences: int) -> Array:
    """Return the weights of the autocovariance of differences, of that of the signal at neighbouring windows."""
    d = differences
    return np.array([(-1.0) ** i * comb(2 * d, d + i) for i in range(-d, d + 1)])
