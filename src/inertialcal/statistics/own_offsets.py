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
from .random_offsets import whitened, whitening

NEGLIGIBLE = 1e-9  # part of a column that varies within the groups, below which they cannot tell it
ROUNDING = 1e-12  # of the largest variance, added to all
HALVINGS = 60


@dataclass(frozen=True, eq=False)
class OwnOffsets:
    """Slopes from within the groups, and the mean intercept before them."""

    coefficients: Array  # (p,): mean intercept, slopes
    covariance: Array  # (p, p)
    dof: Array  # (p,)
    solve: Array  # (p, n): ``coefficients = solve @ readings``
    repeated: NDArray[np.bool_]  # (p,): whether two clusters or more decide it
    local: Array  # (n,): residuals, the offset of their group taken off
    basis: Array  # (n, q): orthonormal, of all that was fitted to the (weighted) readings
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
    spare = len(readings) - len(first) - slopes.shape[1]
    white = whitened(np.column_stack([slopes, readings]), weights, numbers, np.inf)
    if spare < 1 or not _told(white[:, :-1], slopes, weights):
        return None
    within = fit(white[:, :-1], white[:, -1])
    mean_square = float(within.residuals @ within.residuals) / spare
    covariance, dof, repeated = _of_slopes(within, clusters, mean_square, float(spare))
    solve = whitening(within.transform @ within.basis.T, weights, numbers, np.inf)
    # Intercepts of the groups, then of the clusters, as combinations of the readings
    total = np.bincount(numbers, weights)
    average = np.zeros((len(first), len(readings)))
    average[numbers, np.arange(len(readings))] = weights / total[numbers]
    place = average @ slopes
    joined, unseen = _clusters(
        clusters[first], mean_square / total + np.einsum("gi,ij,gj->g", place, covariance, place)
    )
    share, variance = _mean(
        joined @ (average @ readings - place @ within.coefficients),
        joined @ (np.diag(mean_square / total) + place @ covariance @ place.T) @ joined.T,
    )
    of_groups = share @ joined
    cross = -of_groups @ place @ covariance
    groups_basis = np.sqrt(weights / total[numbers])[:, None] * np.eye(len(first))[numbers]
    return OwnOffsets(
        np.concatenate(
            [[of_groups @ average @ readings - of_groups @ place @ within.coefficients], within.coefficients]
        ),
        np.block([[np.array([[variance]]), cross[None]], [cross[:, None], covariance]]),
        np.concatenate([[float(spare) if unseen else len(joined) - 1.0], dof]),
        np.vstack([of_groups @ average - of_groups @ place @ solve, solve]),
        np.concatenate([[not unseen], repeated]),
        within.residuals / np.sqrt(weights),
        np.column_stack([groups_basis, within.basis]),
        mean_square,
        float(spare),
    )


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


def _clusters(labels: NDArray[Any], variances: Array) -> tuple[Array, bool]:
    """Return the weights of the groups in the mean of their cluster, (K, G), and whether there is one cluster only."""
    at = np.unique(labels, return_inverse=True)[1]
    joined = np.zeros((int(at.max()) + 1, len(at)))
    largest = float(np.max(variances))
    joined[at, np.arange(len(at))] = 1.0 / (variances / largest + ROUNDING) if largest > 0.0 else 1.0
    return joined / joined.sum(axis=1, keepdims=True), len(joined) < 2


def _mean(values: Array, covariance: Array) -> tuple[Array, float]:
    """Return the weights of the mean of values that scatter more than their covariance says, and its variance."""
    count = len(values)
    scale = max(float(np.max(np.diag(covariance))), float(np.var(values)))
    if count < 2 or scale == 0.0:
        return np.full(count, 1.0 / count), float(np.mean(covariance))
    unit, spread = values / np.sqrt(scale), covariance / scale + ROUNDING * np.eye(count)

    def weighed(between: float) -> tuple[float, Array, float]:
        inverse = np.linalg.inv(spread + between * np.eye(count))
        sums, total = inverse.sum(axis=0), float(inverse.sum())
        left = unit - sums @ unit / total
        return float(left @ inverse @ left) / (count - 1.0), sums / total, scale / total

    low, high = 0.0, 10.0 * count
    if weighed(0.0)[0] > 1.0:
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if weighed(middle)[0] > 1.0 else (low, middle)
    _, share, variance = weighed(low)
    return share, variance
