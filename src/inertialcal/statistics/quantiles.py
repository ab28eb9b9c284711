"""Quantiles of normal, t, chi-square and F, exact in the far tail, by special functions.

``scipy.stats`` has the same and takes most of a second to import, of which every command would have its share.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from ..core.estimate import Array

MANY = 1e10  # degrees of freedom: infinite ones, for functions that do not take infinity


def normal_quantile(p: float) -> float:
    """Return the value that a standard normal variable does not exceed with probability p."""
    return float(special.ndtri(p))


def t_upper(p: ArrayLike, dof: ArrayLike) -> Array:
    """Return the value that Student's t exceeds with probability p; degrees of freedom may be infinite."""
    return np.asarray(-special.stdtrit(np.minimum(dof, MANY), p), dtype=np.float64)


def chi_square_quantile(p: ArrayLike, dof: ArrayLike) -> Array:
    """Return the value that chi-square does not exceed with probability p."""
    return np.asarray(2.0 * special.gammaincinv(np.asarray(dof) / 2.0, p), dtype=np.float64)


def chi_square_upper(p: ArrayLike, dof: ArrayLike) -> Array:
    """Return the value that chi-square exceeds with probability p."""
    return np.asarray(2.0 * special.gammainccinv(np.asarray(dof) / 2.0, p), dtype=np.float64)


def f_upper(p: ArrayLike, numerator: ArrayLike, denominator: ArrayLike) -> Array:
    """Return the value that F exceeds with probability p; degrees of freedom may be infinite."""
    a, b = np.minimum(numerator, MANY), np.minimum(denominator, MANY)
    part = special.betaincinv(b / 2.0, a / 2.0, p)  # b / (b + a F)
    return np.asarray(b * (1.0 - part) / (a * part), dtype=np.float64)
