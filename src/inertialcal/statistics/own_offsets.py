"""Least squares with an intercept of its own in each group, and the mean of these intercepts.

Recordings that begin with a power-up have offsets of their own. Slopes come from within the groups alone, so that no
offset, of whatever size or distribution, moves them::

    y = intercept of its group + X b + error

Their covariance is that of the scatter between clusters (runs; ``clustered``), coefficient by coefficient; what one
cluster alone decides has the residual mean square. The common intercept is the mean of the clusters' intercepts after
Mandel and Paule [1]_: weights 1 / (t + s^2), s from the fit, and t, the scatter between clusters, such that they
scatter as they should; K - 1 degrees of freedom for K clusters.

Assumed: errors of one size in a group (or of given weights); clusters independent. Not held: (1) slopes that differ
from cluster to cluster where each axis has one: not seen, the interval of a slope is too short; (2) a drift within a
group that goes with the input: hidden in the slope where the groups are few; (3) offsets far from normal in few groups:
the interval of the mean rests on Student's t.

References
----------
.. [1] R. C. Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377-385.
.. [2] R. DerSimonian and R. Kacker, Contemporary Clinical Trials 28 (2007) 105-114.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.estimate import Array
from .clustered import clustered_covariance
from .least_squares import Fit, fit
from .random_offsets import whitened

NEGLIGIBLE = 1e-9  # part of a column that varies within the groups, below which they cannot tell it
ROUNDING = 1e-12  # of the largest variance, added to all
HALVINGS = 60
MANY = 100  # clusters, from which on their scatter alone is the uncertainty of their mean


@dataclass(frozen=True, eq=False)
class OwnOffsets:
    """Slopes from within the groups, and the mean intercept before them."""

    coefficients: Array  # (p,): mean intercept, slopes
    covariance: Array  # (p, p)
    dof: Array  # (p,)
    solve: Array  # (p, n): ``coefficients = solve @ readings``
    repeated: NDArray[np.bool_]  # (p,): whether two clusters or more decide it
    local: Array  # (n,): residuals, the offset of their group taken off
    numbers: NDArray[np.intp]  # (n,): group of each
    basis: Array  # (n, q): orthonormal, of the slopes within the groups
    mean_square: float  # of readings of weight 1 within the groups
    spare: float  # its degrees of freedom


def fit_own_offsets(
    slopes: Array, readings: Array, groups: NDArray[Any], clusters: NDArray[Any], weights: Array | None = None
) -> OwnOffsets | None:
    """Return slopes and mean intercept; None where the groups cannot tell the slopes, or nothing is left to judge by.

    Parameters
    ----------
    slopes : ndarray, shape (n, q)
        Columns, without one for the intercept.
    readings : ndarray, shape (n,)
        In one unit.
    groups, clusters : ndarray, shape (n,)
        Labels; a group lies in one cluster.
    weights : ndarray, shape (n,), optional
        Relative: 1/variance up to a common factor. Equal by default.
    """
    weights = np.ones(len(readings)) if weights is None else weights
    first, numbers = np.unique(groups, return_index=True, return_inverse=True)[1:]
    found = _within(slopes, readings, numbers, weights)
    if found is None:
        return None
    within, spare = found
    mean_square = float(within.residuals @ within.residuals) / spare
    covariance, dof, repeated = _of_slopes(within, clusters, mean_square, float(spare))
    solve = within.transform @ within.basis.T * np.sqrt(weights)  # no mean of a group is in the basis
    # Intercepts of the groups, then of the clusters, as combinations of the readings
    total = np.bincount(numbers, weights)
    means = _averages(np.column_stack([slopes, readings]), weights, numbers)
    place, level = means[:, :-1], means[:, -1]
    at = np.unique(clusters[first], return_inverse=True)[1]
    share = _shares(mean_square / total + np.einsum("gi,ij,gj->g", place, covariance, place), at)
    joined = _sums(share[:, None] * place, at)
    weight, variance = _mean(
        np.bincount(at, share * level) - joined @ within.coefficients,
        np.asarray(np.bincount(at, share**2 * mean_square / total), dtype=np.float64),
        joined,
        covariance,
    )
    of_groups, seen = weight[at] * share, len(weight) > 1
    cross = -(of_groups @ place) @ covariance
    return OwnOffsets(
        np.concatenate([[of_groups @ level - of_groups @ place @ within.coefficients], within.coefficients]),
        np.block([[np.array([[variance]]), cross[None]], [cross[:, None], covariance]]),
        np.concatenate([[len(weight) - 1.0 if seen else float(spare)], dof]),
        np.vstack([(of_groups / total)[numbers] * weights - of_groups @ place @ solve, solve]),
        np.concatenate([[seen], repeated]),
        within.residuals / np.sqrt(weights),
        numbers,
        within.basis,
        mean_square,
        float(spare),
    )


def mean_square_within(slopes: Array, readings: Array, numbers: NDArray[np.intp], weights: Array) -> float | None:
    """Return the mean square of readings of weight 1 about slopes within the groups, as `fit_own_offsets` does.

    Parameters
    ----------
    slopes : ndarray, shape (n, q)
        Columns, without one for the intercept.
    readings, weights : ndarray, shape (n,)
        In one unit; relative weights.
    numbers : ndarray of int, shape (n,)
        Group of each, from 0.
    """
    found = _within(slopes, readings, numbers, weights)
    return None if found is None else float(found[0].residuals @ found[0].residuals) / found[1]


def _within(slopes: Array, readings: Array, numbers: NDArray[np.intp], weights: Array) -> tuple[Fit, int] | None:
    """Return the fit of slopes within the groups, and its degrees of freedom, where there are any."""
    spare = len(readings) - int(numbers.max()) - 1 - slopes.shape[1]
    white = whitened(np.column_stack([slopes, readings]), weights, numbers, np.inf)
    if spare < 1 or not _told(white[:, :-1], slopes, weights):
        return None
    return fit(white[:, :-1], white[:, -1]), spare


def _sums(columns: Array, numbers: NDArray[np.intp]) -> Array:
    return np.asarray(np.column_stack([np.bincount(numbers, column) for column in columns.T]), dtype=np.float64)


def _averages(columns: Array, weights: Array, numbers: NDArray[np.intp]) -> Array:
    return _sums(columns * weights[:, None], numbers) / np.bincount(numbers, weights)[:, None]


def _told(within: Array, slopes: Array, weights: Array) -> bool:
    """Tell whether what varies within the groups tells all slopes apart."""
    sizes = np.linalg.norm(slopes * np.sqrt(weights)[:, None], axis=0)
    if not np.all(np.linalg.norm(within, axis=0) > NEGLIGIBLE * sizes) or len(within) < within.shape[1]:
        return False
    unit = within / np.linalg.norm(within, axis=0)
    return bool(np.linalg.svd(unit, compute_uv=False)[-1] > NEGLIGIBLE)


def _of_slopes(
    within: Fit, clusters: NDArray[Any], mean_square: float, spare: float
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return covariance, degrees of freedom, and whether two clusters or more decide: coefficient by coefficient."""
    pooled = mean_square * within.transform @ within.transform.T
    dof = np.full(len(pooled), spare)
    if len(np.unique(clusters)) < 2:
        return pooled, dof, np.zeros(len(pooled), dtype=bool)
    between, freedom = clustered_covariance(within, clusters)
    repeated = freedom > 0.0
    if np.all(repeated):
        return between, freedom, repeated
    variance = np.where(repeated, np.diag(between), np.diag(pooled))
    size = np.sqrt(np.diag(pooled))
    unit = pooled / np.outer(np.where(size > 0.0, size, 1.0), np.where(size > 0.0, size, 1.0))
    return unit * np.sqrt(np.outer(variance, variance)), np.where(repeated, freedom, dof), repeated


def _shares(variances: Array, at: NDArray[np.intp]) -> Array:
    """Return the weight of each group in the mean of its cluster."""
    largest = float(np.max(variances))
    weights = 1.0 / (variances / largest + ROUNDING) if largest > 0.0 else np.ones(len(at))
    return np.asarray(weights / np.bincount(at, weights)[at])


def _mean(values: Array, own: Array, place: Array, slopes: Array) -> tuple[Array, float]:
    """Return the weights of the mean of values that scatter more than their errors say, and its variance.

    Their covariance is ``diag(own) + place @ slopes @ place.T``. Many weigh alike, with the scatter that they have.
    """
    count = len(values)
    middle = np.mean(place, axis=0)
    shared = float(middle @ slopes @ middle)
    scale = max(float(np.max(own)), float(np.var(values)))
    if count < 2 or scale == 0.0:
        return np.full(count, 1.0 / count), shared + float(np.mean(own)) / count
    if count > MANY:
        return np.full(count, 1.0 / count), shared + float(np.var(values, ddof=1)) / count
    spread = (np.diag(own) + place @ slopes @ place.T) / scale + ROUNDING * np.eye(count)
    size, turn = np.linalg.eigh(spread)
    ones, unit = turn.sum(axis=0), values @ turn / np.sqrt(scale)

    def weighed(between: float) -> tuple[float, Array, float]:
        inverse = 1.0 / (size + between)
        total = float(ones @ (inverse * ones))
        left = unit - ones * (ones @ (inverse * unit) / total)
        return float(left @ (inverse * left)) / (count - 1.0), turn @ (inverse * ones) / total, scale / total

    low, high = 0.0, 10.0 * count
    if weighed(0.0)[0] > 1.0:
        for _ in range(HALVINGS):
            half = 0.5 * (low + high)
            low, high = (half, high) if weighed(half)[0] > 1.0 else (low, half)
    _, share, variance = weighed(low)
    return share, variance
