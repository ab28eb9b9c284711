"""Amplitude of a line of unknown phase: noise lengthens it, and is taken off in quadrature.

With both components normal of standard deviation s around the true ones, the length C found follows Rice's law:
``E[C^2] = A^2 + 2 s^2``. The most likely amplitude solves ``A = C I_1(C A / s^2) / I_0(C A / s^2)``: 0 where C^2 is
below 2 s^2, ``sqrt(C^2 - s^2)`` far above the noise, where that is without bias (``sqrt(C^2 - 2 s^2)`` would be as much
too small as C is too large). Never ``C`` less a mean of noise amplitudes, which is too little by far where there is a
signal. Where the phase is known, nothing is subtracted at all.

The interval holds every A under which neither so short nor so long a C would be a chance of 2.5 % or less. With a
standard deviation that is itself told by m degrees of freedom, the chance is averaged over what it may be, ``m s^2 /
chi-square``: far above the noise this gives Student's interval, and Rice's with many degrees. Where the chance of so
long a C from noise alone is above 5 %, nothing is found, and the upper limit is told: of a C below the median of noise,
that of the median, so that noise that happens to be small gives no limit below what can be seen.

References
----------
.. [1] S. O. Rice, Bell System Tech. J. 23 (1944) 282 (distribution of the length).
.. [2] G. Cowan et al., arXiv 1105.3166, 2011 (limits that are constrained by the power of the test).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from ...core.estimate import Array

NODES = 32  # of the mean over possible standard deviations
NORMAL_FROM = 25.0  # C over s, above which the length is normal
STEPS = 50  # of the bisection


@dataclass(frozen=True, eq=False)
class Amplitude:
    """Amplitudes of records of unknown phase, arrays of shape (k,) each."""

    value: Array  # most likely; 0 where noise alone is as long [unit]
    u: Array  # standard uncertainty of one component, which that of the length is above the noise [unit]
    # lo, hi: 95 % interval
    lo: Array
    hi: Array
    chance: Array  # of so long a line from noise alone
    limit: Array  # 95 % upper limit


def amplitude_of(in_phase: ArrayLike, quadrature: ArrayLike, u: ArrayLike, dof: float) -> Amplitude:
    """Return the amplitude of lines of unknown phase.

    Parameters
    ----------
    in_phase, quadrature : array_like, shape (k,)
        Components found, of equal uncertainty and not correlated [unit].
    u : array_like, shape (k,)
        Standard uncertainty of each component: the root mean square of both where they differ [unit].
    dof : float
        Its degrees of freedom.
    """
    a, b, s = (np.atleast_1d(np.asarray(one, dtype=np.float64)) for one in (in_phase, quadrature, u))
    C = np.hypot(a, b)
    ratio = C / s
    value = most_likely(ratio) * s
    chance = special.fdtrc(2.0, dof, 0.5 * ratio**2)
    median = np.sqrt(2.0 * special.fdtri(2.0, dof, 0.5))
    lo, hi = (_solved(ratio, dof, p) * s for p in (0.975, 0.025))
    limit = _solved(np.maximum(ratio, median), dof, 0.05) * s
    return Amplitude(value, s, lo, hi, chance, limit)


def most_likely(ratio: Array) -> Array:
    """Return the most likely amplitude of lengths, both over the standard deviation of a component, shape (k,)."""
    low, high = np.zeros_like(ratio), ratio.copy()
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        x = ratio * middle
        more = ratio * special.i1e(x) > middle * special.i0e(x)  # the likelihood still rises
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.where(ratio**2 > 2.0, 0.5 * (low + high), 0.0)


def _solved(ratio: Array, dof: float, p: float) -> Array:
    """Return the true amplitude over s under which a length as found or less has the probability p; else 0."""
    far = ratio + special.stdtrit(dof, 1.0 - p)
    low, high = np.zeros_like(ratio), ratio + 12.0 + special.stdtrit(dof, 0.9999)
    near = ratio < NORMAL_FROM
    found = np.where(near, 0.0, np.sqrt(np.maximum(far**2 - 1.0, 0.0)))  # Rice's length is longer by s^2 / 2 A
    if not near.any():
        return found
    r, low, high = ratio[near], low[near], high[near]
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        below = chance_of_less(r, middle, dof) > p  # a larger amplitude makes it less probable
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    found[near] = np.where(chance_of_less(r, np.zeros_like(r), dof) > p, 0.5 * (low + high), 0.0)
    return found


def chance_of_less(ratio: Array, amplitude: Array, dof: float) -> Array:
    """Return the probability of a length as found or less, averaged over what the standard deviation may be.

    Both lengths, found and true, are over the standard deviation that was found, with its degrees of freedom.
    """
    scale, weights = _scales(dof)
    return np.asarray(special.chndtr(np.outer(ratio**2, scale), 2.0, np.outer(amplitude**2, scale)) @ weights)


@lru_cache(maxsize=16)
def _scales(dof: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes of chi-square over its degrees of freedom, and their weights."""
    if np.isinf(dof):
        return np.ones(1), np.ones(1)
    edge, weight = np.polynomial.legendre.leggauss(NODES)
    p = 0.5 * (edge + 1.0)
    return np.asarray(special.chdtri(dof, 1.0 - p) / dof), 0.5 * weight
