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

from ....core.errors import DataError
from ....core.estimate import Array
from ._kernels_components import BROKEN, EXACT, LEAST, NO_SCATTER, blocks_of, find_components


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
    by_weight: Array  # diagonal of the inverse of V, (n,)
    likelihood: float  # logarithm of the restricted likelihood, up to a constant of the design

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
        diagonal[diagonal <= n * np.finfo(float).eps * self.by_weight] = np.nan
        return np.asarray(self.projector @ self.readings / diagonal)

    def variance_dof(self, name: str) -> float:
        """Return the degrees of freedom of one theta; 0 where it is zero."""
        at = list(self.variances).index(name)
        spread = float(self.variances_covariance[at, at])
        return 2.0 * self.variances[name] ** 2 / spread if spread > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class Shared:
    """A known covariance that is one of m places, of three readings each; all others are in blocks of places alike."""

    name: str  # Among the known ones
    same: Array  # shape (m, m): not zero where places are alike
    places: Array  # shape (m, m): covariance of the places
    by_place: Array  # shape (3 m,): of each reading by its place


def fit_components(
    design: Array,
    readings: Array,
    known: Mapping[str, Array],
    unknown: Mapping[str, Array],
    shared: Shared | None = None,
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
    shared : Shared, optional
        What is known of the structure of these: it makes the fit faster.

    Raises
    ------
    DataError
        ``no_dof`` where n is p; ``no_scatter`` if some readings would be exact.
    """
    n, p = design.shape
    if n <= p:
        what = f"{n} readings for {p} unknowns leave no scatter to judge them by"
        raise DataError(what, do="Take more readings", code="no_dof")
    k = len(unknown)
    patterns = np.array([*unknown.values()], dtype=np.float64).reshape(k, n, n)
    theta, information, inverse, weighted = np.empty(k), np.empty((k, k)), np.empty((n, n)), np.empty((n, p))
    bare, P, pull = np.empty((p, p)), np.empty((n, n)), np.empty(n)
    blocks, first, place = np.arange(n), np.array([0, n]), np.arange(n)
    by_place, places, fixed = np.zeros(n), np.zeros((0, 0)), _whole(n, known, {}, ())
    if shared is not None:
        by_place, places, place = shared.by_place, shared.places, np.repeat(np.arange(n // 3), 3)
        fixed = _whole(n, {name: one for name, one in known.items() if name != shared.name}, {}, ())
        first = np.empty(n // 3 + 1, dtype=np.int64)
        first = first[: blocks_of(shared.same, blocks, first) + 1]
    state, likely = find_components(
        np.ascontiguousarray(design, dtype=np.float64), np.ascontiguousarray(readings, dtype=np.float64),
        fixed, patterns, blocks, first, by_place, place, places, np.full(k, np.nan),
        theta, information, inverse, weighted, bare, P, pull,
    )  # fmt: skip
    gain = bare @ weighted.T
    return components_of(
        state, likely, design, readings, known, unknown, theta, information, inverse, gain, bare, P, gain @ readings
    )


def components_of(
    state: int,
    likely: float,
    design: Array,
    readings: Array,
    known: Mapping[str, Array],
    unknown: Mapping[str, Array],
    theta: Array,
    information: Array,
    inverse: Array,
    gain: Array,
    covariance: Array,
    projector: Array,
    coefficients: Array,
) -> Components:
    """Return what kernels have found.

    Raises
    ------
    DataError
        ``no_scatter``.
    LinAlgError
        Where a covariance is none.
    """
    n, p = design.shape
    if state == BROKEN:
        raise np.linalg.LinAlgError("a covariance is not positive")
    if state == EXACT:
        what = "the readings do not scatter at all"
        raise DataError(what, do="Check for copied or rounded readings", code="no_scatter")
    if state == NO_SCATTER or not _is_told(known, unknown, theta, inverse):
        what = f"some of the {n} readings have no scatter of their own, and they do not scatter about the fit"
        raise DataError(what, do="Check for copied or rounded readings", code="no_scatter")
    residuals = readings - design @ coefficients
    return Components(
        coefficients,
        covariance,
        dict(known),
        dict(zip(unknown, theta.tolist(), strict=True)),
        dict(unknown),
        _covariance(information),
        residuals,
        gain,
        projector,
        float(residuals @ projector @ residuals),
        n - p,
        design,
        readings,
        inverse.diagonal(),
        likely,
    )


def _is_told(known: Mapping[str, Array], unknown: Mapping[str, Array], theta: Array, inverse: Array) -> bool:
    """Return whether the least eigenvalue of a covariance is not lost in rounding of the largest."""
    n = len(inverse)
    least = n * np.finfo(float).eps
    trace = sum(float(one.trace()) for one in known.values())
    trace += sum(t * float(one.trace()) for t, one in zip(theta.tolist(), unknown.values(), strict=True))
    if 2.0 * least * trace * float(np.linalg.norm(inverse)) < 1.0:  # bounds of both
        return True
    size = np.linalg.eigvalsh(_whole(n, known, unknown, theta))
    return bool(size[0] > least * size[-1])


def _whole(n: int, known: Mapping[str, Array], patterns: Mapping[str, Array], theta: Iterable[float]) -> Array:
    """Return the covariance of n readings."""
    none = np.zeros((n, n))
    fixed = sum(known.values(), none)
    return np.asarray(fixed + sum((t * one for t, one in zip(theta, patterns.values(), strict=True)), none))


def _covariance(information: Array) -> Array:
    """Return the inverse, in units in which its diagonal is one."""
    if not len(information):
        return information
    size = np.sqrt(np.maximum(information.diagonal(), 1e-300))
    if len(size) == 1 and size[0] > 1e-100:
        return 1.0 / information
    return np.asarray(np.linalg.pinv(information / np.outer(size, size), rcond=LEAST) / np.outer(size, size))
