"""Quantiles of F, t and chi-square, far into the tail, by quadrature of the density of ln F.

``scipy.special`` has them too, but importing it takes longer than ``info`` takes to survey a recording.

The density of u = ln F is highest at u = 0; what lies beyond u is a sum over double-exponential nodes [1]_, good to the
last digits for any degrees of freedom. Its logarithm is concave in u, so that Newton's method finds every quantile.

References
----------
.. [1] Takahasi and Mori, Publications of the RIMS 9 (1974) 721-741: x = exp(t - exp(-t)) on the half-line.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from ..core.estimate import Array

MANY = 1e15  # degrees of freedom: stands for infinitely many
ROUNDS = 60
STEP = 1.0 / 32.0
KEPT = 512  # calls: channels of one length ask for the same quantiles
_T = np.arange(-4.5, 5.5, STEP)
NODES = np.exp(_T - np.exp(-_T))
WEIGHTS = STEP * NODES * (1.0 + np.exp(-_T))


def t_upper(p: ArrayLike, dof: ArrayLike) -> Array:
    """Return the value that Student's t exceeds with probability p < 0.5; degrees of freedom may be infinite."""
    return np.sqrt(f_upper(2.0 * np.asarray(p), 1.0, dof))


def chi_square_quantile(p: ArrayLike, dof: ArrayLike) -> Array:
    """Return the value that chi-square does not exceed with probability p."""
    return chi_square_upper(1.0 - np.asarray(p), dof)


def chi_square_upper(p: ArrayLike, dof: ArrayLike) -> Array:
    """Return the value that chi-square exceeds with probability p."""
    return np.asarray(dof) * f_upper(p, dof, np.inf)


def f_upper(p: ArrayLike, numerator: ArrayLike, denominator: ArrayLike) -> Array:
    """Return the value that F exceeds with probability p; degrees of freedom may be infinite."""
    every = np.broadcast_arrays(p, np.minimum(numerator, MANY), np.minimum(denominator, MANY))
    tail, a, b = (np.ascontiguousarray(one, dtype=np.float64) for one in every)
    return np.frombuffer(_upper(tail.tobytes(), a.tobytes(), b.tobytes())).reshape(every[0].shape).copy()


@lru_cache(maxsize=KEPT)
def _upper(*given: bytes) -> bytes:
    """Return the values that F exceeds, of probabilities, numerators and denominators: all as bytes of numbers."""
    tail, a, b = (np.frombuffer(one)[:, np.newaxis] for one in given)
    sigma = np.sqrt(2.0 / a + 2.0 / b)

    def density(u: Array) -> Array:
        """Relative to that at 0."""
        with np.errstate(over="ignore"):
            found: Array = np.exp(0.5 * a * u - 0.5 * (a + b) * np.log1p(a / (a + b) * np.expm1(u)))
        return found

    def integral(u: Array, size: Array) -> Array:
        """From u upwards, or downwards where ``size`` is negative."""
        found: Array = (density(u + size * NODES) * np.abs(size) * WEIGHTS).sum(axis=-1, keepdims=True)
        return found

    u = np.zeros_like(sigma)
    whole = integral(u, sigma) + integral(u, -sigma)
    for _ in range(ROUNDS):
        slope = 0.5 * a * np.abs(np.expm1(u)) / (1.0 + a / b * np.exp(u))  # of the logarithm of the density
        above = integral(u, sigma / (1.0 + sigma * slope))
        step = np.log(above / (tail * whole)) * above / density(u)
        u = u + np.clip(step, -1.0, 1.0)
        if np.all(np.abs(step) < 1e-13):
            break
    return np.exp(u[:, 0]).tobytes()
