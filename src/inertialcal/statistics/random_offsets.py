"""Least squares with an unknown offset in each group: power-up runs that start from levels of their own.

Readings of a group share an offset of mean zero; beside it each has an error of its own, of variance one over its
weight::

    y = X b + offset of its group + error          variance of the offset = ratio * that of an error of weight 1

The readings are whitened by group [1]_: from each, a part of the weighted mean of its group is taken, none where the
ratio is 0, all of it where the ratio is large. With equal designs in all groups this changes nothing; where groups
cover different parts of a range, it keeps their offsets from bending the curve. The ratio is found by restricted
maximum likelihood [2]_. It only decides how the readings are weighed: the uncertainty is taken from what the groups
disagree about (``clustered``), whatever the ratio.

References
----------
.. [1] W. A. Fuller and G. E. Battese, J. Am. Stat. Assoc. 68 (1973) 626.
.. [2] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize
from scipy.linalg import lapack

from ..core.errors import DataError
from ..core.estimate import Array
from .least_squares import Fit, fit

LOGS = (-4.0, 6.0)  # of ratio times the weight of a group, powers of ten that are searched
ROUNDING = 1e-14  # of the sum of squares, below which residuals are none
LARGEST = 1e300
TINY = float(np.finfo(float).tiny)
TOLERANCE = 0.1  # of the logarithm, in powers of ten


@dataclass(frozen=True, eq=False)
class Grouped:
    """Weighted moments of design and readings, whole and of each of g groups."""

    square: Array  # of design and readings side by side, about zero, (p + 1, p + 1)
    means: Array  # weighted means of each group, (g, p + 1)
    weights: Array  # sum of the weights of each, (g,)
    count: int  # readings


def fit_with_offsets(
    design: Array, readings: Array, weights: Array, groups: NDArray[Any], names: Sequence[str] | None = None
) -> Fit:
    """Return the fit of readings whose groups have offsets of their own.

    Parameters
    ----------
    design : ndarray, shape (n, p)
        A column a coefficient.
    readings : ndarray, shape (n,)
        In one unit.
    weights : ndarray, shape (n,)
        Relative: 1/variance up to a common factor.
    groups : ndarray, shape (n,)
        Label of the group of each reading.
    names : sequence of str, optional
        Of the columns, for messages.

    Returns
    -------
    Fit
        Of the whitened readings: its residuals are whitened ones. For `clustered_contrasts` with the same groups.

    Raises
    ------
    DataError
        As ``least_squares.fit``; or if a weight is not positive.
    """
    return fit_numbered(design, readings, weights, np.unique(groups, return_inverse=True)[1], names)


def fit_numbered(
    design: Array, readings: Array, weights: Array, numbers: NDArray[np.intp], names: Sequence[str] | None = None
) -> Fit:
    """Return the same for readings whose groups are numbered from 0, and all numbers occur."""
    if weights.shape != readings.shape or not np.all(weights > 0.0):
        raise DataError(f"weights of shape {weights.shape} for {readings.size} readings: need one above zero for each")
    columns = np.column_stack([design, readings])
    moments = _moments(columns, weights, numbers)
    white = _whitened(columns, weights, numbers, moments.means, moments.weights, offset_ratio(moments))
    return fit(white[:, :-1], white[:, -1], names=names)


def whitened(columns: Array, weights: Array, numbers: NDArray[np.intp], ratio: float) -> Array:
    """Return columns whose errors are independent and of one size, if the ratio is right, shape of ``columns``.

    Parameters
    ----------
    columns : ndarray, shape (n, m)
        Readings, or a design.
    weights : ndarray, shape (n,)
        Of the readings.
    numbers : ndarray of int, shape (n,)
        Number of the group of each, from 0.
    ratio : float
        Variance of an offset over that of a reading of weight 1; infinite takes all of the mean.
    """
    total = np.bincount(numbers, weights)
    means = _group_sums(columns * weights[:, None], numbers) / total[:, None]
    return _whitened(columns, weights, numbers, means, total, ratio)


def _whitened(
    columns: Array, weights: Array, numbers: NDArray[np.intp], means: Array, total: NDArray[Any], ratio: float
) -> Array:
    return np.asarray(np.sqrt(weights)[:, None] * (columns - (_part(total, ratio)[:, None] * means)[numbers]))


def whitening(rows: Array, weights: Array, numbers: NDArray[np.intp], ratio: float) -> Array:
    """Return rows that are applied to whitened readings as rows that are applied to the readings, shape of ``rows``.

    Parameters
    ----------
    rows : ndarray, shape (m, n)
        For readings as `whitened` returns them.
    weights, numbers, ratio
        As there.
    """
    total = np.bincount(numbers, weights)
    scaled = rows * np.sqrt(weights)
    sums = _group_sums(scaled.T, numbers)
    return np.asarray(scaled - ((_part(total, ratio) / total)[:, None] * sums)[numbers].T * weights)


def _part(total: NDArray[Any], ratio: float) -> Array:
    """Return the part of the mean of each group that is taken from its readings."""
    return np.asarray(1.0 - 1.0 / np.sqrt(1.0 + ratio * total))


def offset_ratio(moments: Grouped) -> float:
    """Return variance of the offsets over that of a reading of weight 1, of greatest restricted likelihood.

    0 where there are fewer than two groups, or no more readings than coefficients.
    """
    if len(moments.weights) < 2 or moments.count <= moments.square.shape[0] - 1:
        return 0.0
    scale, deviance = float(np.mean(moments.weights)), deviance_of(moments)
    found = optimize.minimize_scalar(
        lambda q: deviance(10.0**q / scale),
        bounds=LOGS,
        method="bounded",
        options={"xatol": TOLERANCE},
    )
    return float(10.0**found.x / scale)


def deviance_of(moments: Grouped) -> Callable[[float], float]:
    """Return `restricted_deviance` as a function of the ratio; of two groups by two determinants of 2 x 2.

    With the Cholesky factor L of the whole square and V = L^-1 (means)', the square of a ratio is
    ``L (I - V D V') L'``, and its determinant that of L squared times ``det(I - D V' V)``.
    """
    factor, failed = lapack.dpotrf(moments.square, lower=1)
    if len(moments.weights) != 2 or failed:
        return partial(restricted_deviance, moments)
    *root, last = factor.diagonal().tolist()
    p = len(root)
    V = lapack.dtrtrs(factor, moments.means.T, lower=1)[0]
    a, b, c = (V[:p].T @ V[:p])[[0, 0, 1], [0, 1, 1]].tolist()
    u, v = V[p].tolist()
    first, second = moments.weights.tolist()
    log_design, least = 2.0 * sum(map(log, root)), max(ROUNDING * float(moments.square[p, p]), TINY)

    def deviance(ratio: float) -> float:
        one, other = 1.0 + ratio * first, 1.0 + ratio * second
        d, e = ratio * first * first / one, ratio * second * second / other
        design = (1.0 - d * a) * (1.0 - e * c) - d * e * b * b
        whole = (1.0 - d * (a + u * u)) * (1.0 - e * (c + v * v)) - d * e * (b + u * v) ** 2
        if not design > 0.0:
            return restricted_deviance(moments, ratio)
        left = max(last * last * whole / design, least)
        return log(one) + log(other) + log_design + log(design) + (moments.count - p) * log(left)

    return deviance


def restricted_deviance(moments: Grouped, ratio: float) -> float:
    """Return twice the negative logarithm of the restricted likelihood [2]_ of a ratio, up to a constant."""
    of_groups = ratio * moments.weights
    grown = 1.0 + of_groups
    square = moments.square - (moments.means.T * (of_groups / grown * moments.weights)) @ moments.means
    p = len(square) - 1
    log_design, left = _factored(square)
    left = max(left, ROUNDING * float(moments.square[p, p]), TINY)
    if log_design is None:
        return LARGEST
    return sum(map(log, grown.tolist())) + log_design + (moments.count - p) * log(left)


def _factored(square: Array) -> tuple[float | None, float]:
    """Return the logarithm of the determinant of a square without its last row and column, and what these leave.

    No logarithm where it is not positive. Both stand on the diagonal of the Cholesky factor.
    """
    p = len(square) - 1
    factor, failed = lapack.dpotrf(square, lower=1)
    if not failed:
        *root, last = factor.diagonal().tolist()
        return 2.0 * sum(map(log, root)), float(last) ** 2
    sign, log_design = np.linalg.slogdet(square[:p, :p])  # nothing is left, or the design is singular
    if sign <= 0.0:
        return None, 0.0
    return float(log_design), float(square[p, p] - square[p, :p] @ np.linalg.solve(square[:p, :p], square[:p, p]))


def group_moments(design: Array, readings: Array, weights: Array, numbers: NDArray[np.intp]) -> Grouped:
    """Return the moments of readings, numbered by group from 0."""
    return _moments(np.column_stack([design, readings]), weights, numbers)


def _moments(columns: Array, weights: Array, numbers: NDArray[np.intp]) -> Grouped:
    total, weighted = np.asarray(np.bincount(numbers, weights), dtype=np.float64), columns * weights[:, None]
    means = _group_sums(weighted, numbers) / total[:, None]
    return Grouped(columns.T @ weighted, means, total, len(columns))


def _group_sums(columns: Array, numbers: NDArray[np.intp]) -> Array:
    return np.column_stack([np.bincount(numbers, column) for column in columns.T])
