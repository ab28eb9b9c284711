"""Level of the noise around each frequency of a spectrum, and how well it is known.

The level is a straight line through the logarithms of the values on both sides, over ``ln sin(pi f dt)``, corrected for
the bias of a logarithm. Sampled noise is a power of that sine, or goes over smoothly from one power to another, so that
no model is needed. Values marked as no noise are left out. Near half of the sampling frequency the neighbours lie
below; near zero frequency values with too few neighbours have no level. The better the values are known, the nearer
the neighbours must be, or the bend of the spectrum between them would count as a line.

The level is taken as chi-square distributed itself, with the degrees of freedom that the variance of its logarithm asks
for.

References
----------
.. [1] M. S. Bartlett and D. G. Kendall, Suppl. J. Royal Statistical Society 8 (1946) 128-138: mean and variance of the
   logarithm of a chi-square variable.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array
from .density import Spectrum

Flags = NDArray[np.bool_]

WIDEST = 64  # neighbours on each side
FEWEST = 12  # neighbours on each side that make a level
PART = 0.5  # of the distance from zero frequency, that the neighbours may reach ...
KNOWN = 32.0  # ... up to so many degrees of freedom of a value; by their fourth root less beyond
ONE_SIDED = 32  # part of all values that lie on one side, at most
STRAIGHT = 1e-3  # standard deviation of the place, below which no slope is needed


@dataclass(frozen=True, eq=False)
class Background:
    """Level of the noise of one axis."""

    level: Array  # NaN where there are too few neighbours [unit^2/Hz], shape (k,)
    dof: Array  # degrees of freedom of the level, shape (k,)


def background_of(spectrum: Spectrum, axis: int, marked: Flags) -> Background:
    """Return the level of the noise around each value, the marked ones left out.

    Parameters
    ----------
    spectrum : Spectrum
        With positive density in this axis.
    axis : int
        Which.
    marked : ndarray of bool, shape (k,)
        Values that are no noise; not all.
    """
    logs, place = np.log(spectrum.density[:, axis]), np.log(np.sin(np.pi * spectrum.frequency * spectrum.interval))
    inside = _windows(spectrum)
    count = inside(np.where(marked, 0.0, 1.0))
    known = count >= 2 * FEWEST
    count = np.where(known, count, 1.0)
    mean_place, mean_log, square, product = (
        inside(np.where(marked, 0.0, values)) / count for values in (place, logs, place**2, place * logs)
    )
    width, off = square - mean_place**2, place - mean_place
    sloped = known & (width > STRAIGHT**2)
    slope = np.where(sloped, product - mean_place * mean_log, 0.0) / np.where(sloped, width, 1.0)
    own = 0.5 * spectrum.edf
    spread = special.polygamma(1, own) * (1.0 + 2.0 * float(np.sum(spectrum.neighbours[1:])))
    raised = np.where(sloped, 1.0 + off**2 / np.where(sloped, width, 1.0), 1.0)
    variance = np.where(known, spread * raised / count, 0.1)
    dof = 2.0 / variance + 1.0 - variance / 6.0  # trigamma(dof / 2) = variance, to 1e-3 below 0.2
    level = np.exp(mean_log + slope * off - (special.digamma(own) - np.log(own)))
    return Background(np.where(known, level, np.nan), np.where(known, dof, np.nan))


def _windows(spectrum: Spectrum) -> Callable[[Array], Array]:
    """Return a function that sums values over the neighbours of each, the peak of a line at its place left out."""
    n, guard = len(spectrum.frequency), spectrum.lobe
    at = np.arange(n)
    order = np.round(spectrum.frequency / spectrum.spacing).astype(np.int64)
    part, fewest = PART * min(1.0, (KNOWN / spectrum.edf) ** 0.25), FEWEST + guard
    half = np.minimum(np.minimum((part * order).astype(np.int64), at), min(WIDEST, max(n // ONE_SIDED, fewest)))
    half = np.where((half >= fewest) & (8 * fewest <= n), half, 0)  # half of a short spectrum is no neighbourhood
    high = np.minimum(at + half, n - 1)
    low = np.maximum(high - 2 * half, 0)

    def summed(values: Array) -> Array:
        running = np.concatenate(([0.0], np.cumsum(values)))
        own = running[np.minimum(at + guard, high) + 1] - running[np.maximum(at - guard, low)]
        return np.asarray(running[high + 1] - running[low] - own)

    return summed
