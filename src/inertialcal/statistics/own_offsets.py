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
from .clustered import Shares, members_of
from .least_squares import Decomposed, decompose, times
from .random_offsets import whitened

NEGLIGIBLE = 1e-9  # part of a column that varies within the groups, below which they cannot tell it
ROUNDING = 1e-12  # of the largest variance, added to all
STEPS = 60  # of Newton's method, at most
ROOT = 1e-14  # relative step of it, below which it has arrived
MANY = 100  # clusters, from which on their scatter alone is the uncertainty of their mean


@dataclass(frozen=True, eq=False)
class OwnOffsets:
    """Slopes from within the groups, and the mean intercept before them; of one set of readings, or of several."""

    coefficients: Array  # (..., p): mean intercept, slopes
    covariance: Array  # (..., p, p)
    dof: Array  # (p,)
    solve: Array  # (..., p, n): ``coefficients = solve @ readings``
    repeated: NDArray[np.bool_]  # (p,): whether two clusters or more decide it
    local: Array  # (..., n): residuals, the offset of their group taken off
    numbers: NDArray[np.intp]  # (n,): group of each
    basis: Array  # (n, q): orthonormal, of the slopes within the groups
    mean_square: Array  # (...): of readings of weight 1 within the groups
    spare: float  # its degrees of freedom


def fit_own_offsets(
    slopes: Array, readings: Array, groups: NDArray[Any], clusters: NDArray[Any], weights: Array | None = None
) -> OwnOffsets | None:
    """Return slopes and mean intercept; None where the groups cannot tell the slopes, or nothing is left to judge by.

    Parameters
    ----------
    slopes : ndarray, shape (n, q)
        Columns, without one for the intercept.
    readings : ndarray, shape (..., n)
        In one unit; each set by itself.
    groups, clusters : ndarray, shape (n,)
        Labels; a group lies in one cluster.
    weights : ndarray, shape (n,), optional
        Relative: 1/variance up to a common factor. Equal by default.
    """
    design = offset_design(slopes, groups, clusters, weights)
    return None if design is None else design.fit(readings)


@dataclass(frozen=True, eq=False)
class Within:
    """Slopes within groups, of the design alone."""

    decomposed: Decomposed  # of the columns less their means in the groups, weighted
    weights: Array  # (n,)
    numbers: NDArray[np.intp]  # (n,): group of each, from 0
    order: NDArray[np.intp]  # (n,): that brings groups together
    starts: NDArray[np.intp]  # (g,): where each starts in that order
    total: Array  # (g,): sum of the weights of each
    spare: int  # degrees of freedom of the residuals

    def means(self, readings: Array) -> Array:
        """Return the weighted mean of each group, that of equal readings to the bit: readings (..., n), (..., g)."""
        first = readings[..., self.order[self.starts]]
        away = (readings - first[..., self.numbers]) * self.weights
        sums: Array = np.add.reduceat(away[..., self.order], self.starts, axis=-1)
        return first + sums / self.total

    def fit(self, readings: Array) -> tuple[Array, Array, Array]:
        """Return slopes (..., q), weighted residuals (..., n) and their mean square (...), and the means (..., g)."""
        means = self.means(readings)
        white = np.sqrt(self.weights) * (readings - means[..., self.numbers])
        slopes = self.decomposed.coefficients(white)
        return slopes, white - times(self.decomposed.design, slopes), means


def slopes_within(slopes: Array, numbers: NDArray[np.intp], weights: Array) -> Within | None:
    """Return slopes within groups; None where they do not tell them apart, or no degree of freedom is left.

    Parameters
    ----------
    slopes : ndarray, shape (n, q)
        Columns, without one for the intercept.
    numbers : ndarray of int, shape (n,)
        Group of each, from 0; all numbers occur.
    weights : ndarray, shape (n,)
        Relative: 1/variance up to a common factor.
    """
    spare = len(numbers) - int(numbers.max()) - 1 - slopes.shape[1]
    white = whitened(slopes, weights, numbers, np.inf)
    if spare < 1 or not _told(white, slopes, weights):
        return None
    order = np.argsort(numbers, kind="stable")
    starts = np.flatnonzero(np.diff(numbers[order], prepend=-1))
    names = [f"column {i}" for i in range(slopes.shape[1])]
    total = np.add.reduceat(weights[order], starts)
    return Within(decompose(white, names), weights, numbers, order, starts, total, spare)


def mean_square_within(slopes: Array, readings: Array, numbers: NDArray[np.intp], weights: Array) -> float | None:
    """Return the mean square of readings of weight 1 about slopes within the groups, as `fit_own_offsets` does.

    Parameters
    ----------
    slopes, numbers, weights
        As `slopes_within` takes them.
    readings : ndarray, shape (n,)
        In one unit.
    """
    within = slopes_within(slopes, numbers, weights)
    if within is None:
        return None
    residuals = within.fit(readings)[1]
    return float(residuals @ residuals) / within.spare


def offset_design(
    slopes: Array, groups: NDArray[Any], clusters: NDArray[Any], weights: Array | None = None
) -> OffsetDesign | None:
    """Return what `fit_own_offsets` takes of the design alone, for any number of sets of readings."""
    weights = np.ones(len(groups)) if weights is None else weights
    first, numbers = np.unique(groups, return_index=True, return_inverse=True)[1:]
    within = slopes_within(slopes, numbers, weights)
    return None if within is None else OffsetDesign(within, slopes, clusters, first)


class OffsetDesign:
    """Slopes with an intercept of its own in each group: what depends on design, groups and clusters alone."""

    def __init__(self, within: Within, slopes: Array, clusters: NDArray[Any], first: NDArray[np.intp]) -> None:
        self.within = within
        transform, basis = within.decomposed.transform, within.decomposed.basis
        self.solve = transform @ basis.T * np.sqrt(within.weights)  # no mean of a group is in the basis
        self.unit = transform @ transform.T  # covariance of the slopes, of a mean square of 1
        self.place = within.means(slopes.T).T  # (g, q)
        self.at = np.unique(clusters[first], return_inverse=True)[1]  # cluster of each group
        self.by_cluster = members_of(self.at)
        members = members_of(clusters)
        self.shares = Shares(members, basis) if len(members.starts) > 1 else None
        dof, spare = np.zeros(len(transform)), float(within.spare)
        if self.shares is not None:
            dof = self.shares.dof(transform)
        self.repeated = dof > 0.0
        seen = len(self.by_cluster.starts) > 1
        first_dof = len(self.by_cluster.starts) - 1.0 if seen else spare
        self.dof = np.concatenate([[first_dof], np.where(self.repeated, dof, spare)])
        self.all_repeated = np.concatenate([[seen], self.repeated])

    def fit(self, readings: Array) -> OwnOffsets:
        """Return slopes and mean intercept of readings, shape (..., n), each set by itself."""
        within = self.within
        slopes, residuals, level = within.fit(readings)
        mean_square = np.asarray(np.sum(residuals**2, axis=-1) / within.spare)
        covariance = self._of_slopes(residuals, mean_square)
        # Intercepts of the groups, then of the clusters, as combinations of the readings
        own = mean_square[..., None] / within.total
        share = self._shares(own + np.sum(times(covariance[..., None, :, :], self.place) * self.place, axis=-1))
        joined = self._sums((share[..., None] * self.place).swapaxes(-1, -2)).swapaxes(-1, -2)
        weight, variance = _mean(
            self._sums(share * level) - times(joined, slopes), self._sums(share**2 * own), joined, covariance
        )
        of_groups = weight[..., self.at] * share
        place = times(self.place.T, of_groups)
        cross = -times(covariance, place)
        intercept = np.sum(of_groups * level, axis=-1) - np.sum(place * slopes, axis=-1)
        upper = np.concatenate([variance[..., None], cross], axis=-1)[..., None, :]
        lower = np.concatenate([cross[..., None], covariance], axis=-1)
        row = (of_groups / within.total)[..., within.numbers] * within.weights - times(self.solve.T, place)
        solve = np.broadcast_to(self.solve, (*row.shape[:-1], *self.solve.shape))
        return OwnOffsets(
            np.concatenate([intercept[..., None], slopes], axis=-1),
            np.concatenate([upper, lower], axis=-2),
            self.dof,
            np.concatenate([row[..., None, :], solve], axis=-2),
            self.all_repeated,
            residuals / np.sqrt(within.weights),
            within.numbers,
            within.decomposed.basis,
            mean_square,
            float(within.spare),
        )

    def _of_slopes(self, residuals: Array, mean_square: Array) -> Array:
        """Return the covariance of the slopes: of those that two clusters or more decide by what these disagree."""
        pooled = mean_square[..., None, None] * self.unit
        if self.shares is None:
            return pooled
        spread = times(self.within.decomposed.transform, self.shares.score(residuals)).swapaxes(-1, -2)
        between: Array = spread @ spread.swapaxes(-1, -2)
        if np.all(self.repeated):
            return between
        variance = np.where(self.repeated, _diagonal(between), _diagonal(pooled))
        size = np.sqrt(np.diag(self.unit))
        unit = self.unit / np.outer(size, size)
        return np.asarray(unit * np.sqrt(variance[..., :, None] * variance[..., None, :]))

    def _shares(self, variances: Array) -> Array:
        """Return the weight of each group in the mean of its cluster, shape (..., g)."""
        largest = np.max(variances, axis=-1, keepdims=True)
        scaled = np.divide(variances, largest, out=np.zeros_like(variances), where=largest > 0.0)
        weights = np.where(largest > 0.0, 1.0 / (scaled + ROUNDING), 1.0)
        return np.asarray(weights / self._sums(weights)[..., self.at])

    def _sums(self, values: Array) -> Array:
        """Return sums of values of groups, shape (..., g), by cluster."""
        order, starts = self.by_cluster
        return np.asarray(np.add.reduceat(values[..., order], starts, axis=-1))


def _diagonal(matrices: Array) -> Array:
    return np.asarray(np.diagonal(matrices, axis1=-2, axis2=-1))


def _told(within: Array, slopes: Array, weights: Array) -> bool:
    """Tell whether what varies within the groups tells all slopes apart."""
    sizes = np.linalg.norm(slopes * np.sqrt(weights)[:, None], axis=0)
    if not np.all(np.linalg.norm(within, axis=0) > NEGLIGIBLE * sizes) or len(within) < within.shape[1]:
        return False
    unit = within / np.linalg.norm(within, axis=0)
    return bool(np.linalg.svd(unit, compute_uv=False)[-1] > NEGLIGIBLE)


def _mean(values: Array, own: Array, place: Array, slopes: Array) -> tuple[Array, Array]:
    """Return the weights of the mean of values that scatter more than their errors say, and its variance.

    Their covariance is ``diag(own) + place @ slopes @ place.T``. Many weigh alike, with the scatter that they have.
    Shapes (..., K), (..., K), (..., K, q), (..., q, q); the results (..., K) and (...).

    The scatter t between them is where the weighed mean square F(t) is 1. By Newton's method on 1 / F, which is
    concave, t rises to it and never beyond.
    """
    count = values.shape[-1]
    middle = np.mean(place, axis=-2)
    shared = np.sum(middle * times(slopes, middle), axis=-1)
    scale = np.maximum(np.max(own, axis=-1), np.var(values, axis=-1))
    alike = np.full(values.shape, 1.0 / count)
    if count > MANY:
        return alike, shared + np.where(scale > 0.0, np.var(values, axis=-1, ddof=1), 0.0) / count
    plain = shared + np.mean(own, axis=-1) / count
    if count < 2 or not np.any(scale > 0.0):
        return alike, plain
    scatters = scale > 0.0
    scale = np.where(scatters, scale, 1.0)
    known = np.eye(count) * own[..., None, :] + place @ slopes @ place.swapaxes(-1, -2)
    size, turn = np.linalg.eigh(known / scale[..., None, None] + ROUNDING * np.eye(count))
    back = turn.swapaxes(-1, -2)
    ones, unit = np.sum(turn, axis=-2), times(back, values) / np.sqrt(scale)[..., None]
    between, rising = np.zeros_like(scale), np.ones(scale.shape, dtype=bool)
    for _ in range(STEPS):
        inverse = 1.0 / (size + between[..., None])
        total = np.sum(inverse * ones**2, axis=-1)
        left = unit - ones * (np.sum(ones * inverse * unit, axis=-1) / total)[..., None]
        square = inverse * left**2
        excess = np.sum(square, axis=-1) / (count - 1.0)
        falls = np.sum(square * inverse, axis=-1) / (count - 1.0)
        rising = rising & (excess > 1.0)
        gain = np.divide(excess * (excess - 1.0), falls, out=np.zeros_like(excess), where=rising)
        rising = gain > ROOT * between
        if not np.any(rising):
            break
        between = np.where(rising, between + gain, between)
    share = times(turn, inverse * ones) / total[..., None]
    return np.where(scatters[..., None], share, alike), np.where(scatters, scale / total, plain)
