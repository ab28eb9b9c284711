"""Least squares whose errors have several variances that nobody knows: each by restricted maximum likelihood.

Readings have errors of a known covariance and further errors of unknown sizes, each with a known pattern::

    y = X b + errors          V = known + sum of theta_j Q_j,  theta_j >= 0

The theta are found by restricted maximum likelihood [1]_, by scoring with all theta held at zero or above. A
coefficient's variance has the degrees of freedom that its own mixture of theta is known by (Satterthwaite [2]_), which
counts a theta of zero as uncertain too: a scatter that was not seen may have been missed.

References
----------
.. [1] S. R. Searle, G. Casella and C. E. McCulloch, Variance Components, Wiley, 1992, 6.6 and 8.3.
.. [2] A. Giesbrecht and J. C. Burns, Biometrics 41 (1985) 477.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import optimize
from scipy.linalg import lapack

from ..core.errors import DataError
from ..core.estimate import Array

ITERATIONS = 60
SETTLED = 1e-6  # change of a variance, of the largest reading's variance
LEAST = 1e-12  # of the largest variance: information below which a variance is not told


@dataclass(frozen=True, eq=False)
class Components:
    """Coefficients, and the variances behind them."""

    coefficients: Array  # in unit of reading over unit of column, (p,)
    covariance: Array  # (p, p)
    covariances: Mapping[str, Array]  # that were known, by name, (n, n)
    variances: Mapping[str, float]  # theta, by name
    patterns: Mapping[str, Array]  # Q, by name, (n, n)
    variances_covariance: Array  # of theta, in order, (k, k)
    residuals: Array  # reading less fitted value, (n,)
    gain: Array  # coefficients per reading, (p, n)
    projector: Array  # P: ``P y`` are the residuals weighted by the inverse of V, (n, n)
    chi_square: float  # weighted by V; near ``free`` expected
    free: int  # n - p
    design: Array  # as given, (n, p)
    readings: Array  # as given, (n,)

    @cached_property
    def known(self) -> Mapping[str, Array]:
        """What each known covariance contributes to that of the coefficients, by its name, (p, p)."""
        return {name: self._part(one) for name, one in self.covariances.items()}

    @cached_property
    def unknown(self) -> Mapping[str, Array]:
        """What each variance that was found contributes to it, (p, p)."""
        return {name: self.variances[name] * self._part(one) for name, one in self.patterns.items()}

    def _part(self, covariance: Array) -> Array:
        whole = self.gain @ covariance @ self.gain.T
        return np.asarray(0.5 * (whole + whole.T))

    @cached_property
    def deletion(self) -> Array:
        """Residual of each reading from the fit without it, NaN where it alone decides, (n,)."""
        n, diagonal = len(self.readings), np.diag(self.projector).copy()
        by_weight = np.diag(np.linalg.inv(self._covariance()))
        diagonal[diagonal <= n * np.finfo(float).eps * by_weight] = np.nan
        return np.asarray(self.projector @ self.readings / diagonal)

    @cached_property
    def likelihood(self) -> float:
        """Logarithm of the restricted likelihood, up to a constant of the design."""
        free = _contrasts(self.design)
        return -0.5 * float(np.linalg.slogdet(free.T @ self._covariance() @ free)[1] + self.chi_square)

    def _covariance(self) -> Array:
        return _whole(len(self.readings), self.covariances, self.patterns, self.variances.values())

    def variance_dof(self, name: str) -> float:
        """Return the degrees of freedom of one theta; 0 where it is zero."""
        at = list(self.variances).index(name)
        spread = float(self.variances_covariance[at, at])
        return 2.0 * self.variances[name] ** 2 / spread if spread > 0.0 else 0.0


def fit_components(
    design: Array,
    readings: Array,
    known: Mapping[str, Array],
    unknown: Mapping[str, Array],
    start: Mapping[str, float] | None = None,
) -> Components:
    """Return the fit of readings whose errors have known covariances and variances to be found.

    Parameters
    ----------
    design : ndarray, shape (n, p)
        A column a coefficient, of full rank.
    readings : ndarray, shape (n,)
        In one unit.
    known : mapping of str to ndarray, shape (n, n)
        Covariance of each known source [unit of the readings squared].
    unknown : mapping of str to ndarray, shape (n, n)
        Pattern of each variance that is found: V has theta times it.
    start : mapping of str to float, optional
        Theta to begin with; by default equal parts of what is seen.

    Raises
    ------
    DataError
        ``no_dof`` where n is p; ``no_scatter`` if some readings would be exact.
    """
    n, p = design.shape
    if n <= p:
        what = f"{n} readings for {p} unknowns leave no scatter to judge them by"
        raise DataError(what, do="Take more readings", code="no_dof")
    fixed = _whole(n, known, {}, ())
    patterns = list(unknown.values())
    free = _contrasts(design)
    if not fixed.any() and np.linalg.norm(free.T @ readings) <= n * np.finfo(float).eps * np.linalg.norm(readings):
        what = "the readings do not scatter at all"
        raise DataError(what, do="Check for copied or rounded readings", code="no_scatter")
    theta, information = _restricted(
        free.T @ readings,
        free.T @ fixed @ free,
        [free.T @ one @ free for one in patterns],
        np.array([start[name] for name in unknown]) if start else None,
    )
    V = _whole(n, known, unknown, theta)
    inverse = _inverse(V)
    if inverse is None:
        what = f"some of the {n} readings have no scatter of their own, and they do not scatter about the fit"
        raise DataError(what, do="Check for copied or rounded readings", code="no_scatter")
    weighted = inverse @ design
    bare = np.linalg.inv(design.T @ weighted)
    gain = bare @ weighted.T
    projector = inverse - weighted @ gain
    coefficients = gain @ readings
    return Components(
        coefficients,
        0.5 * (bare + bare.T),
        dict(known),
        dict(zip(unknown, theta.tolist(), strict=True)),
        dict(unknown),
        _covariance(information),
        readings - design @ coefficients,
        gain,
        np.asarray(0.5 * (projector + projector.T)),
        float(readings @ projector @ readings),
        n - p,
        design,
        readings,
    )


def _inverse(V: Array) -> Array | None:
    """Return the inverse of a covariance; None where its least eigenvalue is lost in rounding of the largest."""
    least = len(V) * np.finfo(float).eps
    try:
        inverse = np.asarray(np.linalg.inv(V))
        if 2.0 * least * float(np.trace(V)) * float(np.linalg.norm(inverse)) < 1.0:  # bounds of both eigenvalues
            return inverse
    except np.linalg.LinAlgError:
        return None
    size = np.linalg.eigvalsh(V)
    return inverse if size[0] > least * size[-1] else None


def _contrasts(design: Array) -> Array:
    """Return the combinations of readings that no coefficient moves, (n, n - p)."""
    return np.asarray(np.linalg.qr(design, mode="complete")[0][:, design.shape[1] :])


def _whole(n: int, known: Mapping[str, Array], patterns: Mapping[str, Array], theta: Iterable[float]) -> Array:
    """Return the covariance of n readings."""
    none = np.zeros((n, n))
    fixed = sum(known.values(), none)
    return np.asarray(fixed + sum((t * one for t, one in zip(theta, patterns.values(), strict=True)), none))


def _restricted(y: Array, fixed: Array, patterns: list[Array], start: Array | None) -> tuple[Array, Array]:
    """Return theta of greatest restricted likelihood, none below zero, and their information, of contrasts (q,)."""
    k, q = len(patterns), len(y)
    if not k:
        return np.zeros(0), np.zeros((0, 0))
    total = max(float(y @ y) / q, float(np.trace(fixed)) / q)
    sizes = np.array([max(float(np.trace(one)) / q, 1e-300) for one in patterns])
    scaled = [one * (total / size) for one, size in zip(patterns, sizes, strict=True)]  # theta near one
    theta = np.full(k, 1.0 / k) if start is None else start * sizes / total
    floor = LEAST * total * np.eye(q)  # keeps V regular where theta falls to zero

    def likelihood(at: Array) -> tuple[float, Array]:
        root = _root(fixed + floor + sum((t * one for t, one in zip(at, scaled, strict=True)), np.zeros((q, q))))
        white = _solved(root, y)
        return -float(np.sum(np.log(np.diag(root)))) - 0.5 * float(white @ white), root

    best, root = likelihood(theta)
    for _ in range(ITERATIONS):
        score, information = _score(root, y, scaled)
        lower = _root(information + LEAST * np.trace(information) * np.eye(k))
        target = optimize.nnls(lower.T, _solved(lower, information @ theta + score))[0]
        step, share = target - theta, 1.0
        while share > 1e-4:
            new, tried = likelihood(theta + share * step)
            if new >= best - 1e-12 * abs(best):
                break
            share *= 0.5
        else:
            break
        theta, root = theta + share * step, tried
        done = abs(new - best) <= SETTLED * max(1.0, abs(best)) and np.max(np.abs(share * step)) <= SETTLED * max(
            1.0, float(np.max(theta))
        )
        best = max(best, new)
        if done:
            break
    information = _score(root, y, scaled)[1]
    unit = total / sizes
    return theta * unit, information / np.outer(unit, unit)


def _score(root: Array, y: Array, patterns: list[Array]) -> tuple[Array, Array]:
    white = [_solved(root, _solved(root, one).T) for one in patterns]
    pull = _solved(root, y)
    score = np.array([0.5 * float(pull @ one @ pull - np.trace(one)) for one in white])
    information = np.array([[0.5 * float(np.sum(a * b)) for b in white] for a in white])
    return score, information


def _root(V: Array) -> Array:
    """Return the lower root of a covariance; scipy's own way takes three times as long for so few rows.

    Raises
    ------
    LinAlgError
        Where it has none.
    """
    root, failed = lapack.dpotrf(V, lower=1, clean=1)
    if failed:
        raise np.linalg.LinAlgError(f"the leading minor of order {failed} is not positive")
    return np.asarray(root)


def _solved(root: Array, columns: Array) -> Array:
    """Return what a lower root takes to columns."""
    return np.asarray(lapack.dtrtrs(root, columns, lower=1)[0])


def _covariance(information: Array) -> Array:
    """Return the inverse, in units in which its diagonal is one."""
    if not len(information):
        return information
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    return np.asarray(np.linalg.pinv(information / np.outer(size, size), rcond=LEAST) / np.outer(size, size))
