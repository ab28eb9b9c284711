"""Polynomial of one variable with its covariance and the range in which it holds.

Inside, it is a Chebyshev series of ``s = (2 x - lo - hi) / (hi - lo)``, which keeps the coefficients nearly
uncorrelated and of the size of the readings [1]_. For documents and flight code it is changed, exactly, into
powers of ``x - reference``. Outside lo to hi it says nothing and refuses.

References
----------
.. [1] Forsythe, J. SIAM 5 (1957) 74-88; Mason and Handscomb, Chebyshev Polynomials, 2003, ch. 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from ..core.errors import DataError, PlanError
from ..core.estimate import Array
from .least_squares import fit

EDGE = 1e-9  # share of the range by which rounding may carry a value outside it


@dataclass(frozen=True, eq=False)
class Polynomial:
    """Chebyshev series over its validity range."""

    coefficients: Array  # of T_0, T_1, ..., (order + 1,) [unit of the readings]
    covariance: Array | None  # of the coefficients; None where it was not estimated, (order + 1, order + 1)
    dof: float  # degrees of freedom of the covariance; 0 where there is none
    domain: tuple[float, float]  # lowest and highest x where it holds [unit of x]

    @property
    def order(self) -> int:
        """Highest power."""
        return self.coefficients.size - 1

    def values(self, x: ArrayLike) -> Array:
        """Return the values at x, in the shape of x.

        Raises
        ------
        DataError
            If an x is outside the validity range, or not finite (code ``outside_validity``).
        """
        return np.asarray(chebyshev.chebval(_scaled(x, self.domain), self.coefficients), dtype=float)

    def u(self, x: ArrayLike) -> Array:
        """Return the standard uncertainties of the values at x, in the shape of x.

        Raises
        ------
        DataError
            If an x is outside the validity range, or the covariance was not estimated.
        """
        if self.covariance is None:
            raise DataError(
                f"polynomial of order {self.order} without covariance",
                why=f"{self.order + 1} readings or a published table leave no scatter to judge it by",
                do="Fit more readings than coefficients",
                code="no_dof",
            )
        basis = chebyshev.chebvander(_scaled(x, self.domain), self.order)
        variance = np.einsum("...i,ij,...j->...", basis, self.covariance, basis)
        return np.asarray(np.sqrt(variance), dtype=float)

    def monomials(self, reference: float = 0.0) -> tuple[Array, Array | None]:
        """Return the same polynomial in powers of ``x - reference``.

        Parameters
        ----------
        reference : float
            Any x, inside or outside the range.

        Returns
        -------
        coefficients : ndarray, shape (order + 1,)
            Of 1, (x - reference), (x - reference)², ...
        covariance : ndarray, shape (order + 1, order + 1), or None
            Of these.
        """
        change = powers_from_series(self.order, self.domain, reference)
        covariance = None if self.covariance is None else change @ self.covariance @ change.T
        return change @ self.coefficients, covariance


def fit_polynomial(
    x: ArrayLike,
    readings: ArrayLike,
    order: int,
    weights: Array | None = None,
    domain: tuple[float, float] | None = None,
) -> Polynomial:
    """Return the least-squares polynomial through readings.

    Parameters
    ----------
    x, readings : array_like, shape (n,)
        Temperature, and what was read there.
    order : int
        Highest power.
    weights : ndarray, shape (n,), optional
        Relative: 1/variance up to a common factor.
    domain : tuple of float, optional
        Validity range; that of x by default.

    Raises
    ------
    DataError
        If there are fewer different x than coefficients, an x is outside the domain, or as
        ``least_squares.fit``.
    PlanError
        If the order is negative or the domain empty.

    Examples
    --------
    >>> fitted = fit_polynomial([0.0, 1.0, 2.0, 3.0], [1.0, 2.0, 5.0, 10.0], order=2)
    >>> fitted.monomials()[0].round(9) + 0.0
    array([1., 0., 1.])
    """
    if order < 0:
        raise PlanError(f"polynomial of order {order}", do="Need 0 or more")
    at = np.asarray(x, dtype=float)
    different = np.unique(at[np.isfinite(at)]).size
    if different <= order:
        raise DataError(
            f"{different} different values of x for a polynomial of order {order}",
            do=f"Need {order + 1} or more, or a lower order",
            code="too_few_readings",
        )
    valid = _checked_domain(domain if domain is not None else _span(at[np.isfinite(at)]))
    design = np.asarray(chebyshev.chebvander(_scaled(at, valid), order), dtype=np.float64)
    names = [f"T_{k}" for k in range(order + 1)]
    found = fit(design, np.asarray(readings, dtype=float), weights, names)
    return Polynomial(found.coefficients, found.covariance, found.dof, valid)


def from_monomials(
    coefficients: Sequence[float] | Array,
    domain: tuple[float, float],
    reference: float = 0.0,
    covariance: Array | None = None,
    dof: float = 0.0,
) -> Polynomial:
    """Return the polynomial of given powers of ``x - reference``, such as a published table's.

    Parameters
    ----------
    coefficients : sequence of float
        Of 1, (x - reference), (x - reference)², ...
    domain : tuple of float
        Validity range.
    reference : float
        In the unit of x.
    covariance : ndarray, shape (order + 1, order + 1), optional
        Of these coefficients.
    dof : float
        Degrees of freedom of the covariance.

    Raises
    ------
    DataError
        If there is no coefficient, or one is not finite.
    PlanError
        If the domain is empty.
    """
    powers = np.asarray(coefficients, dtype=float)
    if powers.ndim != 1 or powers.size == 0 or not np.all(np.isfinite(powers)):
        raise DataError(f"coefficients {powers.tolist()}", do="Need one or more finite numbers")
    lo, hi = _checked_domain(domain)
    change = np.linalg.inv(powers_from_series(powers.size - 1, (lo, hi), reference))
    series = None if covariance is None else change @ covariance @ change.T
    return Polynomial(change @ powers, series, dof if series is not None else 0.0, (lo, hi))


def _scaled(x: ArrayLike, domain: tuple[float, float]) -> Array:
    """Bring x from lo..hi to -1..1; refuse what lies outside."""
    at = np.asarray(x, dtype=float)
    lo, hi = domain
    s = (2.0 * at - lo - hi) / (hi - lo)
    outside = ~(np.abs(s) <= 1.0 + 2.0 * EDGE)
    if np.any(outside):
        worst = np.atleast_1d(at)[np.atleast_1d(outside)]
        raise DataError(
            f"{worst.size} value(s) outside the validity range {lo:g} to {hi:g}, the first is {worst[0]:g}",
            why="the polynomial holds in this range and says nothing outside",
            do="Leave these out, or calibrate over a wider range",
            code="outside_validity",
        )
    return np.asarray(s, dtype=float)


def _span(x: Array) -> tuple[float, float]:
    lo, hi = float(np.min(x)), float(np.max(x))
    return (lo, hi) if lo < hi else (lo - 0.5, hi + 0.5)  # one place, order 0: any width will do


def _checked_domain(domain: tuple[float, float]) -> tuple[float, float]:
    lo, hi = float(domain[0]), float(domain[1])
    if not (np.isfinite(lo) and np.isfinite(hi) and lo < hi):
        raise PlanError(f"validity range {lo:g} to {hi:g}", do="Need two finite numbers, the lower first")
    return lo, hi


@lru_cache(maxsize=256)
def powers_from_series(order: int, domain: tuple[float, float], reference: float) -> Array:
    """Return the matrix that takes a Chebyshev series to powers of ``x - reference``, read-only.

    Its column j holds T_j as such powers, by T_(j+1) = 2 s T_j - T_(j-1); shape (order + 1, order + 1).
    """
    change: Array = powers_from_series_each(order, [domain], [reference])[0]
    change.flags.writeable = False  # it is kept
    return change


def powers_from_series_each(order: int, domains: ArrayLike, references: ArrayLike) -> Array:
    """Return the same for several ranges, shape (u, 2), with a reference each: (u, order + 1, order + 1)."""
    lo, hi = np.asarray(domains, dtype=float).T
    at, slope = (2.0 * np.asarray(references, dtype=float) - lo - hi) / (hi - lo), 2.0 / (hi - lo)
    change = np.zeros((len(lo), order + 1, order + 1))
    change[:, 0, 0] = 1.0
    if order:
        change[:, 0, 1], change[:, 1, 1] = at, slope
    for j in range(2, order + 1):
        change[..., j] = 2.0 * at[:, None] * change[..., j - 1] - change[..., j - 2]
        change[:, 1:, j] += 2.0 * slope[:, None] * change[:, :-1, j - 1]
    return change
