"""Linear least squares that says what it cannot tell apart.

``readings = design @ coefficients + error``. Columns are scaled to unit length and the fit is made by
singular values, so that columns of very different size (a bias and a cube of a rate) do no harm. What the fit
leaves, taken in extended precision where the machine has it, corrects the coefficients once [3]_: NIST's certified sets
of lower and average difficulty come out to 13 digits.

Degrees of freedom belong to the covariance: ``n - p`` where the size of the errors comes from the
residuals (`fit`), infinite where the covariance of the readings was given (`fit_correlated`). With as many
coefficients as readings there is nothing to judge the scatter by: ``dof == 0`` and no covariance.

References
----------
.. [1] Golub and Van Loan, Matrix Computations, 4th ed., 2013, 5.3 and 5.5.
.. [2] Belsley, Kuh and Welsch, Regression Diagnostics, Wiley, 1980, ch. 2 (leverage, deletion residuals).
.. [3] Björck, BIT 7 (1967) 257-278: iterative refinement of coefficients and residuals together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ..core.errors import DataError
from ..core.estimate import Array

APART = 1e-6  # share of a column that others leave, below which its decomposition is made anew
NEGLIGIBLE = 1e-7  # share of a (unit length) column in a combination below which it is not named
ALIKE = 1e4  # over what columns at right angles have: from where on coefficients are refined


@dataclass(frozen=True, eq=False)
class Fit:
    """Coefficients with what is needed to judge them."""

    coefficients: Array  # in unit of reading over unit of column, (p,)
    dof: float  # degrees of freedom of the covariance
    residuals: Array  # reading less fitted value, (n,) [unit of the readings]
    # weighted sum of squared residuals over n - p; None when n is p. Near 1 expected where the covariance of the
    # readings was given.
    mean_square: float | None
    design: Array  # as given, (n, p)
    weights: Array | None  # as given, (n,)
    names: tuple[str, ...]  # of the coefficients
    basis: Array  # orthonormal basis of the whitened design, (n, p)
    transform: Array  # ``coefficients = transform @ basis.T @ whitened readings``, (p, p)
    root: Array | None = None  # lower Cholesky factor of the covariance of the readings, where it was given, (n, n)

    @property
    def given(self) -> bool:
        """Whether the covariance of the readings was given."""
        return self.root is not None

    @cached_property
    def covariance(self) -> Array | None:
        """Covariance of the coefficients, shape (p, p); None with no degrees of freedom."""
        size = 1.0 if self.given else self.mean_square
        return None if size is None else size * self.transform @ self.transform.T

    @cached_property
    def leverage(self) -> Array:
        """Change of the fitted value with its own reading, shape (n,); 1 where a reading alone decides."""
        if self.root is None:
            return np.asarray(np.sum(self.basis**2, axis=1))
        pull = linalg.solve_triangular(self.root, self.basis, lower=True, trans="T")  # rows of V^-1/2' Q
        return np.asarray(np.sum((self.design @ self.transform) * pull, axis=1))

    @property
    def u(self) -> Array:
        """Standard uncertainties of the coefficients, shape (p,).

        Raises
        ------
        DataError
            If there are no degrees of freedom.
        """
        return np.sqrt(np.diag(self.need_covariance()))

    @classmethod
    def of_own(cls, shared: Mapping[str, object], **fields: object) -> Fit:
        """Return a fit of all its fields; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(shared, **fields)
        return found

    @property
    def scatter(self) -> float:
        """Standard deviation of a reading of weight 1 about the fit [unit of the readings].

        Raises
        ------
        DataError
            If there are no degrees of freedom.
        """
        if self.mean_square is None:
            raise self._unjudged()
        return math.sqrt(self.mean_square)

    def need_covariance(self) -> Array:
        """Return the covariance of the coefficients, shape (p, p), or refuse.

        Raises
        ------
        DataError
            If there are no degrees of freedom.
        """
        if self.covariance is None:
            raise self._unjudged()
        return self.covariance

    def _unjudged(self) -> DataError:
        n, p = self.design.shape
        return DataError(
            f"{n} readings for {p} coefficients leave no scatter to judge them by",
            do="Take more readings, or fit fewer coefficients",
            code="no_dof",
        )


def fit(
    design: Array,
    readings: Array,
    weights: Array | None = None,
    names: Sequence[str] | None = None,
    decomposed: Decomposed | None = None,
) -> Fit:
    """Return the least-squares fit of readings.

    Parameters
    ----------
    design : ndarray, shape (n, p)
        A column a coefficient.
    readings : ndarray, shape (n,)
        In one unit.
    weights : ndarray, shape (n,), optional
        Relative: 1/variance up to a common factor, which the residuals decide. Equal by default.
    names : sequence of str, optional
        Of the columns, for messages.
    decomposed : Decomposed, optional
        The design, whitened, as `decompose` gives it, where it is known from other readings.

    Raises
    ------
    DataError
        If shapes disagree, a number is not finite, a weight is not positive, there are fewer readings
        than coefficients (code ``too_few_readings``), or the data cannot tell some coefficients apart
        (code ``rank_deficient``; the message gives the combination of columns that vanishes).

    Examples
    --------
    >>> line = fit(np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]), np.array([1.0, 3.0, 5.0]))
    >>> line.coefficients.round(12)
    array([1., 2.])
    """
    design, readings, labels = _checked(design, readings, names)
    root = np.sqrt(_checked_weights(weights, readings.size)) if weights is not None else None
    white = design if root is None else design * root[:, None]
    decomposed = decompose(white, labels) if decomposed is None else decomposed
    basis, transform = decomposed.basis, decomposed.transform
    coefficients = decomposed.coefficients(readings if root is None else readings * root, always=True)
    residuals = readings - design @ coefficients
    dof = readings.size - len(labels)
    mean_square = float(np.sum((residuals if root is None else residuals * root) ** 2)) / dof if dof else None
    return Fit(
        coefficients=coefficients,
        dof=float(dof),
        residuals=residuals,
        mean_square=mean_square,
        design=design,
        weights=None if weights is None else np.asarray(weights, dtype=float),
        names=labels,
        basis=basis,
        transform=transform,
    )


def fit_each(decomposed: Decomposed, of: NDArray[np.intp], readings: Array, names: Sequence[str]) -> list[Fit]:
    """Return the fits of sets of readings, each by one of several designs, as `fit` does without weights.

    Parameters
    ----------
    decomposed : Decomposed
        Of designs, shape (u, n, p).
    of : ndarray, shape (s,)
        Number of the design of each set.
    readings : ndarray, shape (s, n)
        Finite.
    names : sequence of str
        Of the columns.
    """
    from ._kernels_levels import fill_fits  # noqa: PLC0415 - numba starts slowly

    design, basis, transform = decomposed.design, decomposed.basis, decomposed.transform
    coefficients, residuals = np.empty((len(of), design.shape[2])), np.empty(readings.shape)
    fill_fits(basis, transform, of, readings, coefficients, residuals)
    alike = np.flatnonzero(decomposed.alike[of])
    if len(alike):
        own = decomposed.take(of[alike])
        coefficients[alike] = own.coefficients(readings[alike])
        residuals[alike] = readings[alike] - times(own.design, coefficients[alike])
    dof, labels = design.shape[1] - design.shape[2], tuple(names)
    square = np.sum(residuals**2, axis=1) / max(dof, 1)
    shared = {"dof": float(dof), "weights": None, "names": labels, "root": None}
    means = square.tolist() if dof else [None] * len(readings)
    each = zip(of.tolist(), coefficients, residuals, means, strict=True)
    return [
        Fit.of_own(shared, coefficients=one, residuals=left, mean_square=mean, design=design[u], basis=basis[u],
                   transform=transform[u])
        for u, one, left, mean in each
    ]  # fmt: skip


def fit_correlated(design: Array, readings: Array, covariance: Array, names: Sequence[str] | None = None) -> Fit:
    """Return the generalised least-squares fit of readings whose covariance is known.

    Parameters
    ----------
    design : ndarray, shape (n, p)
        A column a coefficient.
    readings : ndarray, shape (n,)
        In one unit.
    covariance : ndarray, shape (n, n)
        Of the readings, in their unit squared; taken as known, so that ``dof`` is infinite.
        ``mean_square`` is chi-square over n - p.
    names : sequence of str, optional
        Of the columns, for messages.

    Raises
    ------
    DataError
        As `fit`; and if the covariance does not fit or is not positive definite.
    """
    design, readings, labels = _checked(design, readings, names)
    root = _cholesky(covariance, readings.size)
    white = linalg.solve_triangular(root, np.column_stack([design, readings]), lower=True)
    decomposed = decompose(white[:, :-1], labels)
    basis, transform = decomposed.basis, decomposed.transform
    coefficients = decomposed.coefficients(white[:, -1], always=True)
    free = readings.size - len(labels)
    chi_square = float(np.sum((white[:, -1] - white[:, :-1] @ coefficients) ** 2))
    return Fit(
        coefficients=coefficients,
        dof=np.inf,
        residuals=readings - design @ coefficients,
        mean_square=chi_square / free if free else None,
        design=design,
        weights=None,
        names=labels,
        basis=basis,
        transform=transform,
        root=root,
    )


def symmetric_inverse(matrix: Array, least: float) -> Array:
    """Return the pseudo-inverse of symmetric matrices, shape (..., p, p).

    Directions are left out whose eigenvalue is not above ``least`` of the largest.
    """
    values, vectors = np.linalg.eigh(matrix)
    size = np.abs(values)
    inverse = np.zeros_like(values)
    np.divide(1.0, values, out=inverse, where=size > least * size.max(axis=-1, keepdims=True))
    return np.asarray((vectors * inverse[..., None, :]) @ vectors.swapaxes(-1, -2))


@dataclass(frozen=True, eq=False)
class Decomposed:
    """A whitened design, ready for any number of sets of readings: what a fit takes of the design alone; or several."""

    design: Array  # as given, (..., n, p)
    basis: Array  # orthonormal, of its columns, (..., n, p)
    transform: Array  # ``coefficients = transform @ basis.T @ readings``, (..., p, p)
    length: Array  # of its columns, (..., p)

    def with_columns(self, of: NDArray[np.intp], columns: Array) -> Decomposed:
        """Return those of several with a column more, shape (s, n), finite, by their numbers; raises as `decompose`."""
        from ._kernels_levels import fill_wider  # noqa: PLC0415 - numba starts slowly

        n, p = self.design.shape[1:]
        wide, turned = np.empty((len(of), n, p + 1)), np.empty((len(of), p + 1, p + 1))
        design = np.concatenate([self.design[of], columns[..., None]], axis=2)
        if n <= p or not fill_wider(self.basis, self.transform, of, columns, wide, turned) > APART:
            return decompose(design, [f"column {i}" for i in range(p + 1)])
        length = np.column_stack([self.length[of], np.sqrt(np.sum(columns**2, axis=1))])
        return Decomposed(design, wide, turned, length)

    def coefficients(self, readings: Array, always: bool = False) -> Array:
        """Return the coefficients of readings, shape (..., n), each set by itself: (..., p).

        After one refinement: always, or where the columns look alike, so that rounding would show.
        """
        back = self.basis.swapaxes(-1, -2)
        found = times(self.transform, times(back, readings))
        alike = np.ones(self.alike.shape, dtype=bool) if always else self.alike
        if not alike.any():
            return found
        if alike.ndim and not alike.all():
            found[alike] = self.take(np.flatnonzero(alike)).coefficients(readings[alike])
            return found
        wide = self.design.astype(np.longdouble)
        left = readings - times(self.design, found)
        missed: Array = (readings - np.matmul(wide, found[..., None])[..., 0] - left).astype(float)
        along: Array = np.matmul(wide.swapaxes(-1, -2), left[..., None])[..., 0].astype(float)
        turned = self.transform.swapaxes(-1, -2)
        return found + times(self.transform, times(back, missed) + times(turned, along))

    @cached_property
    def alike(self) -> NDArray[np.bool_]:
        """Whether a column is close to a combination of the others, shape (...)."""
        size = np.sqrt(np.sum((self.transform * self.length[..., None]) ** 2, axis=(-2, -1)))
        return np.asarray(size > ALIKE)

    def take(self, numbers: Sequence[int] | NDArray[np.intp]) -> Decomposed:
        """Return some of several, by number."""
        at = np.asarray(numbers)
        return Decomposed(self.design[at], self.basis[at], self.transform[at], self.length[at])


def times(matrix: Array, vectors: Array) -> Array:
    """Return products of matrices, (..., m, n), with vectors, (..., n), each by itself: to the bit as if alone."""
    product: Array = np.matmul(matrix, vectors[..., None])[..., 0]
    return product


def decompose(white: Array, names: Sequence[str]) -> Decomposed:
    """Return the decomposition of a whitened design, shape (..., n, p), finite and n >= p; or of several.

    Raises
    ------
    DataError
        ``rank_deficient``, as `fit`: of the first of several.
    """
    length = np.sqrt(np.sum(white**2, axis=-2))
    scale = np.where(length > 0.0, length, 1.0)
    basis, s, rows = np.linalg.svd(white / scale[..., None, :], full_matrices=False)
    lost = s <= s[..., :1] * max(white.shape[-2:]) * np.finfo(float).eps
    if lost.any():
        at = tuple(np.argwhere(lost)[0][:-1])
        raise _rank_deficient(rows[at][lost[at]].T, length[at], tuple(names))
    return Decomposed(white, basis, rows.swapaxes(-1, -2) / s[..., None, :] / scale[..., None], length)


def _checked(design: Array, readings: Array, names: Sequence[str] | None) -> tuple[Array, Array, tuple[str, ...]]:
    X, y = np.asarray(design, dtype=float), np.asarray(readings, dtype=float)
    if X.ndim != 2 or y.shape != X.shape[:1]:
        raise DataError(f"design of shape {X.shape} for readings of shape {y.shape}")
    n, p = X.shape
    labels = tuple(names) if names is not None else tuple(f"column {i}" for i in range(p))
    if len(labels) != p or p == 0:
        raise DataError(f"{len(labels)} names for {p} columns of the design")
    if not (np.isfinite(X).all() and np.isfinite(y).all()):
        bad = np.flatnonzero(~(np.isfinite(X).all(axis=1) & np.isfinite(y)))
        raise DataError(
            f"{bad.size} readings or rows of the design are not finite, the first is number {bad[0] + 1}",
            do="Leave out what is missing, and count it",
            code="not_finite",
        )
    if n < p:
        raise DataError(
            f"{n} readings for {p} coefficients ({', '.join(labels)})",
            do=f"Need {p} readings, and more than {p} for an uncertainty",
            code="too_few_readings",
        )
    return X, y, labels


def _checked_weights(weights: Array, n: int) -> Array:
    w = np.asarray(weights, dtype=float)
    if w.shape != (n,):
        raise DataError(f"weights of shape {w.shape} for {n} readings")
    bad = np.flatnonzero(~((w > 0.0) & np.isfinite(w)))
    if bad.size:
        raise DataError(
            f"weight {w[bad[0]]:g} of reading {bad[0] + 1}",
            do="Need positive numbers: leave out a reading that shall not count",
        )
    return w


def _cholesky(covariance: Array, n: int) -> Array:
    V = np.asarray(covariance, dtype=float)
    if V.shape != (n, n) or not np.all(np.isfinite(V)):
        raise DataError(f"covariance of shape {V.shape}, need finite numbers of shape ({n}, {n})")
    try:
        return np.asarray(np.linalg.cholesky(V), dtype=float)
    except np.linalg.LinAlgError:
        raise DataError(
            f"covariance of the {n} readings is not positive definite",
            why="some combination of them would be known exactly",
            do="Add the independent part of the uncertainty of each reading",
        ) from None


def _rank_deficient(null: Array, length: Array, names: tuple[str, ...]) -> DataError:
    """Error that gives each vanishing combination of columns, with as few columns in it as can be."""
    pivots = linalg.qr(null.T, mode="r", pivoting=True)[1][: null.shape[1]]
    simple = null @ np.linalg.inv(null[pivots])
    texts = []
    for vector in simple.T:
        named = np.flatnonzero(np.abs(vector) > NEGLIGIBLE)
        factors = vector[named] / np.where(length[named] > 0.0, length[named], 1.0)
        factors = factors / factors[0]
        terms = [f"{f:+.6g} * {names[i]}" for f, i in zip(factors, named, strict=True)]
        texts.append(" ".join(terms).removeprefix("+").replace("1 * ", "", 1) + " = 0")
    return DataError(
        f"the data cannot tell {len(names)} coefficients apart: their columns obey {' and '.join(texts)}",
        why="any amount of this combination fits as well",
        do="Add readings in which this is not zero, or leave one of these coefficients out",
        code="rank_deficient",
    )
