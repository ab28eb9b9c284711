"""Whether a vibration is Gaussian: kurtosis and crest with what chance does to them, values at rails.

For stationary Gaussian noise of autocorrelation ``r`` the kurtosis of n samples is 3 with the variance
``24/n sum r^4``: neighbours of a narrow band repeat each other. Its crest, the largest size over the standard
deviation, misses a level k with the probability that no crossing of it happens, ``exp(-N)``: N is the number expected
of both signs, by Rice ``2 nu_0 T exp(-k^2/2)`` with ``nu_0 = sqrt(m_2/m_0)`` the zero crossings upwards a second, and
never more than the samples themselves have there, ``2 n Q(k)``. Half of the lesser of both is taken, so that a true
Gaussian record is called clipped no more often than is said.

References
----------
.. [1] S. O. Rice, Bell System Technical Journal 23 (1944) 282-332, 24 (1945) 46-156.
.. [2] L. Isserlis, Biometrika 12 (1918) 134-139 (moments of Gaussian variables, of which the variance follows).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import fft, special

from ...core.estimate import Array
from .rails import Rails, rails_of

GAUSSIAN = 3.0  # kurtosis
HALF = 0.5  # of the crossings expected


@dataclass(frozen=True)
class Shape:
    """Distribution of a channel.

    Parameters
    ----------
    kurtosis, u_kurtosis : float
        3 for Gaussian noise; standard deviation by chance of that of Gaussian noise of this spectrum.
    crest : float
        Largest size over the standard deviation.
    chance : float
        That Gaussian noise of this spectrum stays below it, at most.
    rails : Rails
        Samples at the ends of its range.
    """

    kurtosis: float
    u_kurtosis: float
    crest: float
    chance: float
    rails: Rails


def shape_of(x: Array, frequency: Array, density: Array, interval: float) -> Shape:
    """Return kurtosis, crest and rails of a channel.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples that are used, in order; NaN are left out [unit].
    frequency, density : ndarray, shape (k,)
        Of its spectrum, equally spaced from the first line [Hz], [unit^2/Hz].
    interval : float
        From sample to sample [s].
    """
    there = x[np.isfinite(x)]
    n = len(there)
    away = there - there.mean()
    squares = away * away
    square = float(np.mean(squares))
    kurtosis = float(np.mean(squares * squares)) / square**2 if square > 0.0 else math.nan
    spectrum = np.concatenate([[0.0], density])
    correlation = fft.irfft(spectrum)
    correlation = correlation / correlation[0] if correlation[0] > 0.0 else correlation
    u = math.sqrt(24.0 / n * float(np.sum(np.square(np.square(correlation)))))
    crest = float(np.max(np.abs(away))) / math.sqrt(square) if square > 0.0 else math.nan
    crossings = crossing_rate(frequency, density) * n * interval
    return Shape(kurtosis, u, crest, math.exp(-HALF * _exceedances(crest, crossings, n)), rails_of(there))


def crossing_rate(frequency: Array, density: Array) -> float:
    """Return the zero crossings upwards a second of Gaussian noise."""
    total = float(density.sum())
    return math.sqrt(float(np.sum(frequency**2 * density)) / total) if total > 0.0 else 0.0


def crest_reached(crossings: float, n: int, chance: float) -> float:
    """Return the crest that Gaussian noise of so many crossings and samples exceeds but for a chance."""
    low, high = 0.0, 10.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = math.exp(-HALF * _exceedances(middle, crossings, n))
        low, high = (middle, high) if below < chance else (low, middle)
    return 0.5 * (low + high)


def _exceedances(k: float, crossings: float, n: int) -> float:
    if not math.isfinite(k):
        return 0.0
    return 2.0 * min(crossings * math.exp(-0.5 * k * k), n * float(special.ndtr(-k)))


__all__ = ["Shape", "crest_reached", "crossing_rate", "shape_of"]
