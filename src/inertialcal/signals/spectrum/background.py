"""Level of the noise around each frequency of a spectrum, and how well it is known.

The level is the geometric mean over equally many values on both sides, corrected for its bias: it follows any power law
without a model, since the slopes of both sides cancel on logarithmic axes. Values marked as no noise are bridged. At
the upper end the spectrum of a sampled signal is mirrored at half of the sampling frequency; at the lower end values
with too few neighbours have no level.

The geometric mean of chi-square variables is taken as chi-square itself, with the degrees of freedom that its variance
asks for.

References
----------
.. [1] M. S. Bartlett and D. G. Kendall, Suppl. J. Royal Statistical Society 8 (1946) 128-138: mean and variance of the
   logarithm of a chi-square variable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array
from .density import Spectrum

Flags = NDArray[np.bool_]

WIDEST = 64  # neighbours on each side
FEWEST = 12  # neighbours on each side that make a level
PART = 0.5  # of the distance from zero frequency, that the neighbours may reach


@dataclass(frozen=True, eq=False)
class Background:
    """Level of the noise of one axis.

    Parameters
    ----------
    level : ndarray, shape (k,)
        NaN where there are too few neighbours [unit^2/Hz].
    dof : ndarray, shape (k,)
        Degrees of freedom of the level.
    """

    level: Array
    dof: Array


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
    logs = np.log(spectrum.density[:, axis])
    place = np.log(spectrum.frequency)
    if marked.any():
        logs[marked] = np.interp(place[marked], place[~marked], logs[~marked])
    n, guard = len(logs), spectrum.lobe
    order = np.round(spectrum.frequency / spectrum.spacing)
    half = np.minimum(np.minimum((PART * order).astype(np.int64), order.astype(np.int64) - round(order[0])), WIDEST)
    mirrored = np.concatenate((logs, logs[::-1][:WIDEST]))
    free = np.concatenate((~marked, (~marked)[::-1][:WIDEST])).astype(float)
    total, count = _both_sides(mirrored, half, guard, n), _both_sides(free, half, guard, n)
    size = 2.0 * (half - guard)
    known = (half - guard >= FEWEST) & (count >= FEWEST) & (half <= len(logs) - 1)
    mean = np.where(known, total / np.where(known, size, 1.0), np.nan)
    own = 0.5 * spectrum.edf
    spread = special.polygamma(1, own) * (1.0 + 2.0 * float(np.sum(spectrum.neighbours[1:])))
    sizes, at = np.unique(np.where(known, count, 1.0), return_inverse=True)
    dof = 2.0 * _inverse_trigamma(spread / sizes)[at]
    return Background(np.exp(mean - (special.digamma(own) - np.log(own))), np.where(known, dof, np.nan))


def _both_sides(values: Array, half: NDArray[np.int64], guard: int, n: int) -> Array:
    """Sum of the values at distances guard + 1 ... half on both sides of each of the first n."""
    running = np.concatenate(([0.0], np.cumsum(values)))
    at, last = np.arange(n), len(values)

    def reach(distance: NDArray[np.int64] | int) -> Array:
        low, high = np.clip(at - distance, 0, last), np.clip(at + distance + 1, 0, last)
        return np.asarray(running[high] - running[low])

    return reach(half) - reach(np.minimum(half, guard))


def _inverse_trigamma(value: Array) -> Array:
    """Return x with trigamma(x) = value, by Newton's method on 1 / trigamma, which is nearly a straight line."""
    x = 0.5 + 1.0 / value
    for _ in range(6):
        now = special.polygamma(1, x)
        x = x + now * (1.0 - now / value) / special.polygamma(2, x)
    return np.asarray(x)
