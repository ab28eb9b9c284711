"""Least squares with two levels of variance: what is known of each reading, and a scatter between readings beside it.

Readings have errors of a known covariance (the noise inside a static interval, a mounting tolerance) and a further
independent error of one unknown size (what differs between positions)::

    y = X b + known errors + between          V = sum of the known covariances + tau^2 I

tau is found by restricted maximum likelihood [1]_, by scoring [2]_. The degrees of freedom of a coefficient are those
of its variance, by Satterthwaite [3]_: tau^2 is uncertain, the known covariances are not. Without the second level an
uncertainty from the noise of the samples alone promises too much wherever positions do not repeat within it.

References
----------
.. [1] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320.
.. [2] S. R. Searle, G. Casella and C. E. McCulloch, Variance Components, Wiley, 1992, 8.2 and 8.3.
.. [3] A. Giesbrecht and J. C. Burns, Biometrics 41 (1985) 477.
.. [4] W. Viechtbauer, Stat. Med. 26 (2007) 37 (interval of tau by its weighted sum of squares).
.. [5] G. K. Robinson, Statistical Science 6 (1991) 15 (coefficients with a prior are random effects).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy import special

from ..core.errors import DataError
from ..core.estimate import Array
from ._kernels_levels import fill_contrasts, fill_scatters, solve_many_levels, square_at, weighted_squares


@dataclass(frozen=True, eq=False)
class TwoLevels:
    """Coefficients with what is needed to judge them."""

    coefficients: Array  # in unit of reading over unit of column, (p,)
    covariance: Array  # sum of the parts, (p, p)
    parts: Mapping[str, Array]  # what each known covariance contributes, by its name, (p, p)
    between_part: Array  # what the scatter between readings contributes, (p, p)
    # squares of the contrasts behind tau with their known variances, and the largest variance; None where tau was given
    contrasts: tuple[Array, Array, float] | None
    # of tau^2, twice Fisher's: its variance is 2 over this [1/unit of the readings^4]; infinite where tau was given
    information: float
    between: float  # tau, standard deviation between readings [unit of the readings]
    chi_square: float  # weighted by V; near ``free`` expected
    free: int  # n - p
    deletion: Array  # residual of each reading from the fit without it, (n,) [unit of the readings]
    deletion_u: Array  # standard uncertainty of that, (n,)
    residuals: Array  # reading less fitted value, (n,)
    gain: Array  # coefficients per reading, (p, n)
    projector: Array  # p of [2]_: ``P y`` are the residuals weighted by the inverse of V, (n, n)
    design: Array  # as given, (n, p)
    readings: Array  # as given, (n,)
    known: Mapping[str, Array]  # the known covariances, by name, (n, n)
    by_scatter: Array  # square root of what tau^2 does to the coefficients: the gain, if it counts in all, (p, k)

    @classmethod
    def of_own(cls, shared: Mapping[str, object], **fields: object) -> TwoLevels:
        """Return a fit of all its fields; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(shared, **fields)
        return found

    @cached_property
    def between_interval(self) -> tuple[float, float]:
        """Interval that holds tau with 95 %, from zero where none is seen; the given tau twice where it was given."""
        return (self.between, self.between) if self.contrasts is None else _interval(*self.contrasts)

    @cached_property
    def chi_square_known(self) -> float:
        """Weighted by the known covariances alone; NaN where these do not reach every reading."""
        n, p = self.design.shape
        fixed = sum(self.known.values(), np.zeros((n, n)))
        if n == p or not (fixed.diagonal() > 0.0).all():
            return float("nan")
        return weighted_squares(np.ascontiguousarray(self.design), np.ascontiguousarray(self.readings), fixed)

    @property
    def hidden(self) -> float:
        """Variance between readings that the residuals would hardly show: the standard uncertainty of tau^2."""
        return float(np.sqrt(2.0 / self.information))

    @property
    def between_dof(self) -> float:
        """Degrees of freedom of tau^2: twice its square over its variance; none where it is zero, or was given."""
        found = self.between**4 * self.information
        return found if np.isfinite(found) else 0.0

    def by_between(self, back: Array) -> Array:
        """Return the derivative by tau^2 of the covariance of ``back @ coefficients``, shape (q, q)."""
        moved = back @ self.by_scatter
        return np.asarray(moved @ moved.T)

    def dof_of(self, back: Array) -> Array:
        """Return the degrees of freedom of the variances of ``back @ coefficients``, shape (q,)."""
        slope = np.diag(self.by_between(back))
        variance = np.diag(back @ self.covariance @ back.T)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(slope > 0.0, (variance / slope) ** 2 * self.information, np.inf)


def fit_two_levels(
    design: Array, readings: Array, known: Mapping[str, Array], between: float | None = None
) -> TwoLevels:
    """Return the fit of readings with known errors and a scatter between them.

    Parameters
    ----------
    design : ndarray, shape (n, p)
        A column a coefficient, of full rank.
    readings : ndarray, shape (n,)
        In one unit.
    known : mapping of str to ndarray, shape (n,) or (n, n)
        Variances, or covariance, of each known source [unit of the readings squared].
    between : float, optional
        tau where it is known [unit of the readings]; found by default. Needed where n is p.

    Raises
    ------
    DataError
        ``no_dof`` where n is p and the scatter between readings is not given; ``no_scatter`` if nothing scatters at
        all, or some readings would be exact.
    """
    own = {name: part[None] for name, part in known.items()}
    (found,) = fit_many_levels(design[None], readings[None], own, between).fits([0])
    if isinstance(found, DataError):
        raise found
    return found


@dataclass(frozen=True, eq=False)
class Levels:
    """Fits of many sets of readings of one shape: what `TwoLevels` has of each, along the first axis."""

    coefficients: Array  # (sets, p)
    design: Array
    readings: Array
    known: Mapping[str, Array]  # (sets, n, n)
    fixed: Array  # sum of the known covariances, (sets, n, n)
    squares: Array  # tau^2, (sets,)
    # known variances and squares of the contrasts, and the largest variance, (sets,); None where tau was given
    contrasts: tuple[Array, Array, Array] | None
    parts: Mapping[str, Array]
    arrays: Mapping[str, Array]  # what else a fit has, by name
    judged: Array  # chi-square, information, (sets, 2)
    refused: Mapping[int, DataError]

    def fits(self, at: Iterable[int], with_scatter: bool = False) -> list[TwoLevels | DataError]:
        """Return the fits at some places, or why they are refused.

        Parameters
        ----------
        at : iterable of int
            Places.
        with_scatter : bool
            Work out the interval of tau and chi-square of the known covariances at once, which each else does when it
            is asked.
        """
        places = [*at]
        scatters = self._scatters(places).tolist() if with_scatter else [None] * len(places)
        n, p = self.design.shape[1:]
        contrasts, judged, tau = self.contrasts, self.judged.tolist(), np.sqrt(self.squares).tolist()
        found = list[TwoLevels | DataError]()
        for k, scatter in zip(places, scatters, strict=True):
            if k in self.refused:
                found.append(self.refused[k])
                continue
            chi_square, information = judged[k]
            one = TwoLevels.of_own(
                {name: own[k] for name, own in self.arrays.items()},
                coefficients=self.coefficients[k],
                design=self.design[k],
                readings=self.readings[k],
                parts={name: own[k] for name, own in self.parts.items()},
                known={name: own[k] for name, own in self.known.items()},
                contrasts=None if contrasts is None else (contrasts[0][k], contrasts[1][k], float(contrasts[2][k])),
                information=np.inf if contrasts is None else information,
                between=tau[k],
                chi_square=chi_square,
                free=n - p,
            )
            if scatter is not None:
                one.__dict__.update(chi_square_known=scatter[0], between_interval=(scatter[1], scatter[2]))
            found.append(one)
        return found

    def _scatters(self, places: Sequence[int]) -> Array:
        """Return chi-square of the known covariances and both ends of the interval of tau, (places, 3)."""
        none = np.zeros((len(self.design), 0))
        known, pull, largest = (none, none, self.squares) if self.contrasts is None else self.contrasts
        low, high = (0.0, 0.0) if self.contrasts is None else _quantiles(known.shape[1])
        found = np.empty((len(places), 3))
        design, readings, fixed = self.design[places], self.readings[places], self.fixed[places]
        fill_scatters(design, readings, fixed, known[places], pull[places], largest[places], low, high, found)
        if self.contrasts is None:
            found[:, 1:] = np.sqrt(self.squares[places])[:, None]
        return found


def fit_many_levels(design: Array, readings: Array, known: Mapping[str, Array], between: float | None = None) -> Levels:
    """Return the fits of many sets of readings: as `fit_two_levels` gives it of each.

    Parameters
    ----------
    design : ndarray, shape (sets, n, p)
        A column a coefficient, of full rank.
    readings : ndarray, shape (sets, n)
        In one unit.
    known : mapping of str to ndarray, shape (sets, n) or (sets, n, n)
        Variances, or covariance, of each known source [unit of the readings squared].
    between : float, optional
        tau of all, where it is known [unit of the readings].

    Raises
    ------
    DataError
        ``no_dof``, of all sets alike.
    """
    sets, n, p = design.shape
    if n < p or (n == p and between is None):
        raise DataError(
            f"{n} readings for {p} unknowns leave no scatter to judge them by",
            do="Take more readings",
            code="no_dof",
        )
    design, readings = np.ascontiguousarray(design), np.ascontiguousarray(readings)
    sources, diagonal = np.zeros((sets, len(known), n, n)), np.arange(n)
    for s, part in enumerate(known.values()):
        if part.ndim == 2:
            sources[:, s, diagonal, diagonal] = part
        else:
            sources[:, s] = part
    is_diagonal = all(part.ndim == 2 for part in known.values())
    fixed = sources.sum(axis=1)
    squares, contrasts = np.full(sets, 0.0 if between is None else between**2), None
    refused: dict[int, DataError] = {}
    if between is None:
        contrasts = _contrasts(design, readings, fixed, squares)
        for k in np.flatnonzero(contrasts[2] <= 0.0):
            what = "the readings do not scatter at all"
            refused[int(k)] = DataError(what, do="Check for copied or rounded readings", code="no_scatter")
    if is_diagonal:
        sizes = fixed[:, diagonal, diagonal] + squares[:, None]
        least, most = sizes.min(axis=1), sizes.max(axis=1)
    else:
        least, most = np.linalg.eigvalsh(fixed + squares[:, None, None] * np.eye(n))[:, [0, -1]].T
    for k in np.flatnonzero(~(least > n * np.finfo(float).eps * most)):
        what = f"some of the {n} readings have no scatter of their own, and they do not scatter about the fit"
        refused.setdefault(int(k), DataError(what, do="Check for copied or rounded readings", code="no_scatter"))
    coefficients, gain = np.empty((sets, p)), np.empty((sets, p, n))
    covariance, between_part, parts = np.empty((sets, p, p)), np.empty((sets, p, p)), np.empty((sets, len(known), p, p))
    projector, residuals = np.empty((sets, n, n)), np.empty((sets, n))
    deletion, judged = np.empty((sets, 2, n)), np.empty((sets, 2))
    solve_many_levels(
        design, readings, sources, is_diagonal, squares, coefficients, covariance, gain, projector, residuals, parts,
        between_part, deletion, judged,
    )  # fmt: skip
    if any(k not in refused for k in np.flatnonzero(judged[:, 1] < 0.0).tolist()):
        raise np.linalg.LinAlgError("Singular matrix")
    arrays = {"covariance": covariance, "between_part": between_part, "deletion": deletion[:, 0],
              "deletion_u": deletion[:, 1], "residuals": residuals, "gain": gain, "projector": projector,
              "by_scatter": gain}  # fmt: skip
    own = {name: sources[:, s] for s, name in enumerate(known)}
    each = {name: parts[:, s] for s, name in enumerate(known)}
    return Levels(coefficients, design, readings, own, fixed, squares, contrasts, each, arrays, judged, refused)


def fit_with_prior(
    design: Array,
    readings: Array,
    known: Mapping[str, Array],
    prior: Mapping[str, tuple[Array, Array]],
    most: float = np.inf,
) -> TwoLevels:
    """Return the fit of readings with known errors and a scatter between them, and a prior on the coefficients.

    Combinations with a prior are random effects [5]_: tau, its degrees of freedom and the deletion residuals follow
    from the readings with these integrated out, so that there may be fewer readings than coefficients.

    Parameters
    ----------
    design : ndarray, shape (n, p)
        A column a coefficient.
    readings : ndarray, shape (n,)
        In one unit.
    known : mapping of str to ndarray, shape (n,) or (n, n)
        As `fit_two_levels` takes it.
    prior : mapping of str to (ndarray, ndarray), shapes (k, p) and (k,)
        By the name of each source: combinations of coefficients, each over its prior standard uncertainty, and the
        values that these are expected to have. Together of full rank.
    most : float
        Largest scatter between readings that they show without the prior: a wrong prior is no scatter.

    Raises
    ------
    DataError
        ``no_dof`` where there are no more readings than combinations without a prior; ``no_scatter`` as there.
    """
    n = len(design)
    rows, expected = (np.concatenate([part[k] for part in prior.values()]) for k in range(2))
    flat = np.linalg.svd(rows)[2][len(rows) :].T  # combinations without a prior
    lift = np.linalg.pinv(rows)
    wide, at = dict(known), 0
    for name, (own, _) in prior.items():
        moved = design @ lift[:, at : at + len(own)]
        wide[name], at = moved @ moved.T, at + len(own)
    reduced = design @ flat, readings - design @ (lift @ expected), wide
    marginal = fit_two_levels(*reduced)
    if marginal.between > most:
        marginal = replace(fit_two_levels(*reduced, between=most), information=marginal.information)
    sources = {name: np.diag(part) if part.ndim == 1 else part for name, part in known.items()}
    fixed = sum(sources.values(), np.zeros((n, n)))
    if marginal.between == 0.0 and not np.any(
        fixed
    ):  # nothing says how far a reading may be off but what may be hidden
        marginal = replace(marginal, between=float(np.sqrt(marginal.hidden)))
    inverse = _inverse(fixed, marginal.between**2)
    bare = np.linalg.inv(design.T @ inverse @ design + rows.T @ rows)
    gain = bare @ design.T @ inverse
    coefficients = gain @ readings + bare @ (rows.T @ expected)
    parts = {name: _part(gain, part) for name, part in sources.items()}
    parts |= {name: _part(bare @ own.T, np.eye(len(own))) for name, (own, _) in prior.items()}
    residuals = readings - design @ coefficients
    return replace(
        marginal,
        coefficients=coefficients,
        covariance=0.5 * (bare + bare.T),
        parts=parts,
        between_part=marginal.between**2 * gain @ gain.T,
        residuals=residuals,
        gain=gain,
        by_scatter=gain,
    )


def with_gain(fit: TwoLevels, gain: Array, by_scatter: Array) -> TwoLevels:
    """Return a fit with other coefficients of the same readings.

    Parameters
    ----------
    fit : TwoLevels
        Of n readings.
    gain : ndarray, shape (p, n)
        Coefficients per reading.
    by_scatter : ndarray, shape (p, k)
        The same per draw of a scatter between readings of unit size.
    """
    parts = {name: _part(gain, known) for name, known in fit.known.items()}
    between = fit.between**2 * by_scatter @ by_scatter.T
    covariance = sum(parts.values(), between)
    coefficients = gain @ fit.readings
    residuals = fit.readings - fit.design @ coefficients
    return replace(
        fit, coefficients=coefficients, covariance=covariance, parts=parts, between_part=between, gain=gain,
        by_scatter=by_scatter, residuals=residuals,
    )  # fmt: skip


def _contrasts(design: Array, readings: Array, fixed: Array, squares: Array) -> tuple[Array, Array, Array]:
    """Fill the variances between readings by restricted maximum likelihood, never below zero.

    Return the contrasts behind each, shape (sets, n - p): their known variances and their squares; the largest
    variance, shape (sets,).
    """
    sets, n, p = design.shape
    known, pull, largest = np.empty((sets, n - p)), np.empty((sets, n - p)), np.empty(sets)
    fill_contrasts(design, readings, fixed, known, pull, largest, squares)
    if np.isnan(squares).any():
        raise np.linalg.LinAlgError("Eigenvalues did not converge")
    return known, pull, largest


def _interval(known: Array, pull: Array, largest: float) -> tuple[float, float]:
    """Interval of tau: at the true one the weighted sum of squares is a chi-square, and it falls with tau [4]_."""
    low, high = (float(np.sqrt(square_at(known, pull, largest, one))) for one in _quantiles(len(pull)))
    return low, high


@lru_cache
def _quantiles(dof: int) -> tuple[float, float]:
    """Return the values that chi-square does not exceed with 97.5 and 2.5 %."""
    low, high = special.chdtri(dof, [0.025, 0.975]).tolist()
    return low, high


def _inverse(fixed: Array, square: float) -> Array:
    return np.asarray(np.linalg.inv(fixed + square * np.eye(len(fixed))))


def _part(gain: Array, covariance: Array) -> Array:
    whole = gain @ covariance @ gain.T
    return np.asarray(0.5 * (whole + whole.T))
