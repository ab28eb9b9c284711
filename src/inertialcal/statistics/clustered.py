"""Covariance of fitted coefficients from the scatter between clusters: power-up runs, dwells, days.

Readings of one run share its errors, so their number says little about the uncertainty; the number of runs
does. The cluster-robust covariance CR2 takes what the runs disagree about as it is, without a model of it.
With the least-squares weights W, the hat matrix H of the whitened design X and residuals e::

    V = M { sum_g  X_g' A_g e_g e_g' A_g X_g } M        M = (X'X)^-1,  A_g = (I - H_gg)^(-1/2)

A_g makes V unbiased if the weights are right and the errors independent (the working model: identity), also
for few and unequal clusters [1]_. The degrees of freedom of each variance are Satterthwaite's under the same
working model [1]_ [2]_: they fall towards 1 for a coefficient that one cluster decides nearly alone. Where
every cluster has the same design, V is the sample covariance of the coefficients fitted to each cluster over
their number R, with R - 1 degrees of freedom, exactly.

Where a coefficient rests on something that only one cluster shows (I - H_gg is singular there), the others
cannot confirm it: part of its variance is not seen. Its ``dof`` is then 0, as everywhere here for "not
estimated", and its variance in V is only the part that was seen.

References
----------
.. [1] Bell and McCaffrey, Survey Methodology 28 (2002) 169-181.
.. [2] Pustejovsky and Tipton, J. Business and Economic Statistics 36 (2018) 672-683.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError
from ..core.estimate import Array
from .least_squares import Fit, times

ALONE = 1e-9  # 1 - share of a direction that one cluster decides, below which it decides it alone
ROUGH = 30.0  # largest inverse root of what others decide that an iteration is trusted with
FILLED = 3  # times the readings, up to which clusters are filled up to the size of the largest
UNRESOLVED = 1e-6  # part of a variance that may be unseen before its dof is called 0


def clustered_covariance(fit: Fit, clusters: NDArray[Any]) -> tuple[Array, Array]:
    """Return the CR2 covariance of the coefficients and the degrees of freedom of each.

    Parameters
    ----------
    fit : Fit
        Made by ``least_squares.fit``.
    clusters : ndarray, shape (n,)
        Label of the cluster of each reading.

    Returns
    -------
    covariance : ndarray, shape (p, p)
        In the units of the coefficients.
    dof : ndarray, shape (p,)
        1 or more; 0 where the variance is not estimated, because one cluster alone decides.

    Raises
    ------
    DataError
        If there are fewer than two clusters, labels do not fit, or the fit was made with a given
        covariance.
    """
    return clustered_contrasts(fit, clusters, np.eye(fit.coefficients.size))


class Members(NamedTuple):
    """Readings by their cluster."""

    order: NDArray[np.intp]  # that brings the readings of a cluster together, shape (n,)
    starts: NDArray[np.intp]  # where each cluster starts in that order


def members_of(labels: NDArray[Any]) -> Members:
    """Return the readings of labels, shape (n,), by cluster."""
    numbers = np.unique(labels, return_inverse=True)[1]
    order = np.argsort(numbers, kind="stable")
    return Members(order, np.flatnonzero(np.diff(numbers[order], prepend=-1)))


def clustered_contrasts(fit: Fit, clusters: NDArray[Any] | Members, contrasts: Array) -> tuple[Array, Array]:
    """Return the CR2 covariance of linear combinations of the coefficients, and the dof of each.

    Parameters
    ----------
    fit : Fit
        Made by ``least_squares.fit``.
    clusters : ndarray, shape (n,), or Members
        Label of the cluster of each reading, or what `members_of` gives for them.
    contrasts : ndarray, shape (m, p)
        Row = combination: the row of a design gives the fitted value there.

    Returns
    -------
    covariance : ndarray, shape (m, m)
        Of ``contrasts @ coefficients``.
    dof : ndarray, shape (m,)
        1 or more; 0 where not estimated.

    Raises
    ------
    DataError
        As `clustered_covariance`.
    """
    return clustered(fit, clusters).contrasts(contrasts)


class Clustered(NamedTuple):
    """A fit, and what its clusters disagree about: for several contrasts of one fit."""

    fit: Fit
    gram: Array  # Q_g' Q_g of its basis, shape (R, p, p)
    adjust: Array  # F_g of A_g Q_g = Q_g F_g, shape (R, p, p)
    score: Array  # what each moves the coefficients of the basis by, shape (R, p)

    def contrasts(self, rows: Array) -> tuple[Array, Array]:
        """Return covariance and degrees of freedom of combinations, rows (m, p), as `clustered_contrasts`."""
        covariance, dof = contrasts_each([self], rows[None])
        return covariance[0], dof[0]


def contrasts_each(found: Sequence[Clustered], rows: Array, free: int | None = None) -> tuple[Array, Array]:
    """Return the same of several fits of one shape with so many clusters each: rows (s, m, p); (s, m, m), (s, free).

    ``free``: of how many of the first rows the degrees of freedom are wanted; None for all.
    """
    to_contrast = rows @ np.array([one.fit.transform for one in found])
    spread = to_contrast @ np.array([one.score for one in found]).swapaxes(1, 2)
    gram, adjust = (np.array([getattr(one, name) for one in found]) for name in ("gram", "adjust"))
    return spread @ spread.swapaxes(1, 2), _satterthwaite(gram, adjust, to_contrast[:, :free])


def clustered(fit: Fit, clusters: NDArray[Any] | Members) -> Clustered:
    """Return a fit with what its clusters, labels (n,) or members, disagree about; raises as `clustered_covariance`."""
    return clustered_each([fit], [_clusters(fit, clusters)])[0]


def clustered_each(
    fits: Sequence[Fit], members: Sequence[Members], designs: Sequence[Hashable] | None = None
) -> list[Clustered]:
    """Return the same of several fits of one shape, whose readings are of two clusters or more, of one number.

    Fits of one design, by its name in ``designs``, have the same basis and members: what these share is found once.
    """
    from ._kernels_levels import fill_sums  # noqa: PLC0415 - numba starts slowly

    names = range(len(fits)) if designs is None else designs
    known = {name: i for i, name in reversed([*enumerate(names)])}
    own = sorted(known.values())
    order, starts = (np.array(column) for column in zip(*members, strict=True))
    roots = np.array([one.residuals if one.weights is None else one.residuals * np.sqrt(one.weights) for one in fits])
    basis = np.array([one.basis for one in fits])
    sums = np.zeros((*starts.shape, basis.shape[2]))
    gram = np.zeros((len(own), *sums.shape[1:], basis.shape[2]))
    fill_sums(basis, order, starts, roots, np.array(own), gram, sums)
    adjust = _inverse_root(gram.reshape(-1, *gram.shape[2:])).reshape(gram.shape)
    if len(own) < len(fits):
        place = {k: i for i, k in enumerate(own)}
        at = np.array([place[known[name]] for name in names])
        gram, adjust = gram[at], adjust[at]
    return [Clustered(fit, *own) for fit, *own in zip(fits, gram, adjust, times(adjust, sums), strict=True)]


class Shares:
    """What clusters have of a fit, by its orthonormal basis, shape (n, p), alone: the same whatever the readings."""

    def __init__(self, members: Members, basis: Array) -> None:
        self.members, self.basis = members, basis[members.order]
        self.gram = _grams(self.basis, members.starts)  # Q_g' Q_g
        self.adjust = _inverse_root(self.gram)  # F_g of A_g Q_g = Q_g F_g, shape (R, p, p)

    def score(self, residuals: Array) -> Array:
        """Return what each cluster moves the coefficients of the basis by: residuals (..., n), result (..., R, p)."""
        order, starts = self.members
        return times(self.adjust, np.add.reduceat(self.basis * residuals[..., order, None], starts, axis=-2))

    def dof(self, to_contrast: Array) -> Array:
        """Return Satterthwaite's degrees of freedom of combinations of the basis, rows (m, p)."""
        return np.asarray(_satterthwaite(self.gram[None], self.adjust[None], to_contrast[None])[0])


def _grams(basis: Array, starts: NDArray[np.intp]) -> Array:
    """Return what each cluster, from its start on, has of the products of columns, (n, p): shape (R, p, p)."""
    sizes = np.diff(starts, append=len(basis))
    most = int(sizes.max())
    if most * len(starts) > FILLED * len(basis):
        return np.asarray(np.add.reduceat(basis[:, :, None] * basis[:, None, :], starts))
    of = np.repeat(np.arange(len(starts)), sizes)
    own = np.zeros((len(starts), most, basis.shape[1]))
    own[of, np.arange(len(basis)) - starts[of]] = basis
    return np.asarray(own.swapaxes(1, 2) @ own)


def _clusters(fit: Fit, clusters: NDArray[Any] | Members) -> Members:
    """Return readings by their cluster, checked."""
    shape = clusters.order.shape if isinstance(clusters, Members) else np.shape(clusters)
    if fit.given:
        raise DataError("clusters of a fit with given covariance", do="Fit with weights instead")
    if shape != fit.residuals.shape:
        raise DataError(f"labels of shape {shape} for {fit.residuals.size} readings")
    found = clusters if isinstance(clusters, Members) else members_of(np.asarray(clusters))
    if found.starts.size < 2:
        raise DataError(
            f"{found.starts.size} cluster(s), need 2 or more for a scatter between clusters",
            do="Repeat the test (another power-up run), or state the scatter of the level below",
            code="few_clusters",
        )
    return found


def _inverse_root(gram: Array) -> Array:
    """Pseudo-inverse square roots of I - gram, shape (R, p, p)."""
    from ._kernels_levels import fill_inverse_roots  # noqa: PLC0415 - numba starts slowly

    found = np.empty(gram.shape)
    fill_inverse_roots(np.eye(gram.shape[-1]) - gram, found)
    hard = np.flatnonzero(~(np.abs(found).max(axis=(1, 2)) < ROUGH))
    if len(hard):
        share, vectors = np.linalg.eigh(gram[hard])
        left = 1.0 - share
        factor = np.where(left > ALONE, 1.0 / np.sqrt(np.maximum(left, ALONE)), 0.0)
        found[hard] = (vectors * factor[:, None, :]) @ vectors.transpose(0, 2, 1)
    return found


def _satterthwaite(gram: Array, adjust: Array, to_contrast: Array) -> Array:
    """Degrees of freedom of each variance, shape (s, m), of s fits: (s, R, p, p), (s, R, p, p), (s, m, p).

    Under the working model the variance is a quadratic form in independent errors, with the matrix
    ``B_gh = z_g' (I - H)_gh z_h`` between clusters, ``z_g = A_g X_g M c``; dof = (tr B)² / tr(B²).
    """
    from ._kernels_levels import fill_dof  # noqa: PLC0415 - numba starts slowly

    size = np.max(np.abs(to_contrast), axis=2, initial=0.0, keepdims=True)
    to_contrast = np.ldexp(to_contrast, -np.frexp(size)[1])  # no size of a contrast changes its dof, or underflows
    along = np.ascontiguousarray(to_contrast.swapaxes(1, 2))
    found = np.zeros((len(along), 2, along.shape[2]))
    fill_dof(gram, adjust, along, found)
    return np.where(found[:, 1] > (1.0 - UNRESOLVED) * np.sum(to_contrast**2, axis=2), found[:, 0], 0.0)
