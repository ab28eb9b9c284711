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
from ._kernels_sphere import fill_suspects

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
    own = {name: part[None] for name, part in known.items()}
    return np.asarray(many_outliers(design[None], readings[None], own, group, risk)[0])


def many_outliers(
    design: Array, readings: Array, known: Mapping[str, Array], group: NDArray[np.int64], risk: float
) -> Flags:
    """Return what `found_outliers` gives of each of many sets, along the first axis, shape (sets, groups)."""
    sets, n, p = design.shape
    count = int(group.max()) + 1
    found = np.zeros((sets, count), dtype=bool)
    if n - p < FREE:
        return found
    scales, beyond = np.empty(sets), np.empty((sets, n), dtype=bool)
    fill_suspects(np.ascontiguousarray(design), np.ascontiguousarray(readings), STANDS_OUT, scales, beyond)
    for k in np.flatnonzero(beyond.any(axis=1) & (scales != 0.0)):
        own = {name: part[k] for name, part in known.items()}
        suspect = np.zeros(count, dtype=bool)
        suspect[group[beyond[k]]] = True
        found[k] = _confirmed(design[k], readings[k], own, group, suspect, risk)
    return found


def _confirmed(
    design: Array, readings: Array, known: Mapping[str, Array], group: NDArray[np.int64], suspect: Flags, risk: float
) -> Flags:
    """Return which of the groups that stand out disagree with the fit of all others."""
    p, count = design.shape[1], len(suspect)
    nobody, kept = np.zeros(count, dtype=bool), ~suspect[group]
    if np.sum(kept) - p < FREE or np.linalg.matrix_rank(design[kept]) < p:
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
