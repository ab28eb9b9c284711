"""Noise of a rate sensor as a logger that averages sees it.

References
----------
.. [1] IEEE Std 952-1997, Annex C: rate white noise, rate random walk.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import fft

from ...core.estimate import Array

SERIES_FROM = 30  # lag from which a series has more digits than differences have


def white(std: float, n: int, k: int, rng: np.random.Generator) -> Array:
    """Return independent noise of n averages of k sensors, shape (n, k), with the standard deviation of one."""
    return rng.normal(0.0, std, (n, k))


def random_walk(
    coefficient: float, n: int, k: int, interval: float, averaging: float, rng: np.random.Generator
) -> Array:
    """Return averages of a random walk of the rate that starts at zero.

    Between two times the walk has the variance ``coefficient^2`` times what has passed. Its mean over a window is
    the mean of both ends and what the bridge between them adds, of variance ``coefficient^2 averaging / 12``.

    Parameters
    ----------
    coefficient : float
        K [unit/sqrt(s)].
    n, k : int
        Averages, and sensors.
    interval, averaging : float
        Time from average to average, and length of each [s].
    rng : numpy.random.Generator
        All draws come from it.

    Returns
    -------
    ndarray, shape (n, k)
    """
    inside = rng.normal(0.0, coefficient * np.sqrt(averaging), (n, k))
    between = rng.normal(0.0, coefficient * np.sqrt(max(interval - averaging, 0.0)), (n, k))
    start = np.cumsum(inside + between, axis=0) - inside - between
    bridge = rng.normal(0.0, coefficient * np.sqrt(averaging / 12.0), (n, k))
    return np.asarray(start + 0.5 * inside + bridge)


def flicker(h: float, n: int, k: int, rng: np.random.Generator) -> Array:
    """Return 1/f noise of k sensors as means over n steps of equal length, each with mean 0, shape (n, k).

    Parameters
    ----------
    h : float
        ``S(f) = h / f``, one-sided [unit^2]; the length of a step does not matter.
    n, k : int
        Steps, and sensors.
    rng : numpy.random.Generator
        All draws come from it.
    """
    if h == 0.0 or n < 2:
        return np.zeros((k, n)).T
    size, roots = _circle(n)
    draws = rng.standard_normal((k, size + 2)).view(np.complex128)
    draws[:, 0].imag = draws[:, -1].imag = 0.0
    draws *= roots * np.sqrt(h)
    steps = fft.irfft(draws, size, axis=1, overwrite_x=True)
    found = np.zeros((k, n))
    np.cumsum(steps[:, : n - 1], axis=1, out=found[:, 1:])
    found -= found.mean(axis=1, keepdims=True)
    return np.asarray(found.T)


def increment_covariance(lags: Array) -> Array:
    """Return the covariance of increments of means over neighbouring steps, for h = 1, at lags in steps, (m,)."""
    k = np.abs(np.asarray(lags, dtype=float))
    far = np.maximum(k, SERIES_FROM)
    near = np.minimum(k, SERIES_FROM)
    weights = ((-2, 1.0), (-1, -4.0), (0, 6.0), (1, -4.0), (2, 1.0))  # fourth difference
    exact = np.sum([weight * _twice_integrated_log(near + by) for by, weight in weights], axis=0)
    series = -(far**-2.0) - far**-4.0 - 1.5 * far**-6.0  # the same, of a smooth function
    return np.asarray(np.where(k < SERIES_FROM, exact, series))


def _twice_integrated_log(t: Array) -> Array:
    size = np.abs(t)
    return np.asarray(0.5 * size**2 * (np.log(np.where(size > 0.0, size, 1.0)) - 1.5))


@lru_cache(8)
def _circle(n: int) -> tuple[int, Array]:
    """Length of the circle, and the size of each of its Fourier coefficients, drawn with unit real and imaginary."""
    size = 2 * int(fft.next_fast_len(n - 1, real=True))
    half = size // 2
    around = increment_covariance(np.minimum(np.arange(size), size - np.arange(size)).astype(float))
    power = np.maximum(fft.rfft(around).real, 0.0) * size
    power[1:half] *= 0.5  # shared by real and imaginary part
    return size, np.sqrt(power)
