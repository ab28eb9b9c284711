"""Positions that do not agree with the others: found by a robust fit, confirmed by leaving them out.

A fit with Tukey's weights [1]_ is little moved by a few wrong positions, so that they stand out in it. Each one that
stands out is then judged by the residual that it has from the fit without all that stand out: it is left out only if
chance explains that at less than the risk, shared among all positions. The others count fully, so that on clean data
the fit is the plain one and its uncertainty is right.

References
----------
.. [1] P. W. Holland and R. E. Welsch, Communications in Statistics A6 (1977) 813-827.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ....core.estimate import Array
from ....statistics.two_levels import fit_two_levels
from ._kernels_sphere import fill_tukey, robust_scale

STANDS_OUT = 3.5  # robust standard deviations
FREE = 4  # least degrees of freedom of a fit that can judge a position

Flags = NDArray[np.bool_]


def found_outliers(
    design: Array, readings: Array, known: Mapping[str, Array], group: NDArray[np.int64], risk: float
) -> Flags:
    """Return which groups of readings do not agree with the others.

    Parameters
    ----------
    design : ndarray, shape (n, p)
        A column a coefficient.
    readings : ndarray, shape (n,)
        In one unit.
    known : mapping of str to ndarray, shape (n,) or (n, n)
        As `fit_two_levels` takes it.
    group : ndarray of int, shape (n,)
        Number of the position that a reading belongs to, from 0.
    risk : float
        Probability that any of a clean set is called an outlier.

    Returns
    -------
    ndarray of bool, shape (groups,)
        None where too few positions would be left to judge by.
    """
    n, p = design.shape
    count = int(group.max()) + 1
    nobody = np.zeros(count, dtype=bool)
    if n - p < FREE:
        return nobody
    found, residuals = np.empty(p), np.empty(n)
    fill_tukey(np.ascontiguousarray(design), np.ascontiguousarray(readings), found, residuals)
    scale = robust_scale(residuals, n - p)
    suspect = np.zeros(count, dtype=bool)
    suspect[group[np.abs(residuals) > STANDS_OUT * scale]] = True
    kept = ~suspect[group]
    if scale == 0.0 or not suspect.any() or np.sum(kept) - p < FREE:
        return nobody
    if np.linalg.matrix_rank(design[kept]) < p:
        return nobody
    fitted = fit_two_levels(design[kept], readings[kept], {name: _some(part, kept) for name, part in known.items()})
    for k in np.flatnonzero(suspect):
        rows = group == k
        away = readings[rows] - design[rows] @ fitted.coefficients
        spread = design[rows] @ fitted.covariance @ design[rows].T + fitted.between**2 * np.eye(len(away))
        for part in known.values():
            own = _some(part, rows)
            spread = spread + (np.diag(own) if own.ndim == 1 else own)
        ratio = float(away @ np.linalg.solve(spread, away)) / len(away)
        suspect[k] = special.fdtrc(len(away), fitted.free, ratio) < risk / count
    return suspect


def _some(part: Array, rows: Flags) -> Array:
    return part[rows] if part.ndim == 1 else part[np.ix_(rows, rows)]
