"""Drift of a unit: the slope of its figures over time, where tests share errors of standards.

Figures ``y_i`` at times ``t_i`` are taken as ``y = a + b t + wander``: a straight line, and what the unit does between
tests beyond the stated uncertainties, independent from test to test with an unknown standard deviation. Their
covariance is::

    V = diag(own variance) + sum over shared unknowns of c c'      c: signed changes by one standard uncertainty

so that an error which all tests have in common, as that of one certificate, moves the line and not its slope, and one
that changed in between (another certificate) enters the slope. The line is that of generalised least squares [1]_.

The residuals say how far tests scatter, for it is the highest level that is repeated: a wander is added to V until they
fit (Paule and Mandel [2]_, with the whole V), and u is scaled by them (Hartung and Knapp [3]_, Student's t with as many
degrees of freedom as there are residuals to spare), but for the part of standards where tests share some, of which
residuals show little. Residuals smaller than in 5 of 100 are taken as large as that. The interval is then near exact,
with a wander and without. Stated uncertainties alone do not do: of three to five tests that wander by as much as a
power-up scatters, such intervals held the drift in 78 to 94 %. Of two tests, which show no wander, it is their
difference (``statistics.difference``) over the time between.

Where the unit was adjusted, each stretch between adjustments has a level of its own, and all have one slope.

Scatter of few degrees of freedom is one size for all tests where Bartlett's test does not reject that at 1 %: weights
by scatters that chance made small would give too small a u.

Real data break this where (1) the unit ages along a curve, jumps, or one test is of another unit, or in another unit of
measure: each of these, added to the line as one more unknown, is tested against the residuals (``Departure``;
Bonferroni over all places, the F test of one more column); (2) it wanders as a random walk: residuals follow each
other, and u is too small; (3) a standard was repaired under the same certificate, or tests were made each time after
another shock. A control chart (``control_charts``) shows (2).

References
----------
.. [1] A. C. Aitken, Proc. R. Soc. Edinburgh 55 (1935) 42-48.
.. [2] R. C. Paule and J. Mandel, J. Res. NBS 87 (1982) 377-385.
.. [3] G. Knapp and J. Hartung, Statistics in Medicine 22 (2003) 2693-2710.
.. [4] JCGM 100:2008, F.1.2.3 (correlated input quantities), G.4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, optimize, special

from ...core.errors import DataError
from ...core.estimate import Array
from ..difference import Figure, degrees_of_freedom, difference
from ..intervals import t_quantile

REJECTED = 0.05  # probability of residuals below which the stated uncertainties are contradicted
CHANCE = 0.05  # probability of residuals below which they are taken as large as that: rounded figures may lie on a line
SPARE = 2  # residuals to spare, with one unknown more than the line, from which a departure from it is looked for
UNEQUAL = 0.01  # of Bartlett's test, below which scatters are taken as different
SINGULAR = 1e-12  # of the largest variance, where a figure has none of its own
P = 0.95
Basis = Literal["difference", "stated", "residuals"]
Kind = Literal["bend", "jump", "odd"]


@dataclass(frozen=True)
class Departure:
    """What fits the figures best that is no line.

    Parameters
    ----------
    kind : {"bend", "jump", "odd"}
        A curve; a step between two tests; one test that is off.
    index : int
        By time, of the first test after the step, or of the odd one; 0 of a curve.
    size : float
        Of the step, or how far the odd test is off; of a curve its greatest distance from the line.
    p_value : float
        Probability of one as clear as this, of any kind and at any place, where there is none.
    """

    kind: Kind
    index: int
    size: float
    p_value: float


@dataclass(frozen=True, eq=False)
class Line:
    """A line through the figures of a unit.

    Parameters
    ----------
    slope, u : float
        Per unit of time.
    dof : float
        Degrees of freedom of ``u``; infinite where all of it is known.
    middle : float
        Time at which level and slope are independent of each other.
    level : float
        At the middle.
    covariance : ndarray, shape (2, 2)
        Of level and slope.
    wander : float
        Standard deviation between tests beyond the stated uncertainties; 0 where none shows.
    consistency : float
        Probability of residuals as large as these, were the stated uncertainties all there is; 1 for two tests.
    basis : {"difference", "stated", "residuals"}
        What ``u`` rests on; the stated uncertainties where adjustments leave no residual.
    common : float
        Standard uncertainty of the level by errors that all tests have alike: no part of any change.
    departure : Departure, optional
        The clearest one, however probable; None of fewer than five tests.
    """

    slope: float
    u: float
    dof: float
    middle: float
    level: float
    covariance: Array
    wander: float
    consistency: float
    basis: Basis
    common: float = 0.0
    departure: Departure | None = None

    @property
    def p_value(self) -> float:
        """Probability of a slope as large as this where there is none, two-sided."""
        if not self.u > 0.0:
            return 0.0 if self.slope else 1.0
        t = abs(self.slope) / self.u
        return 2.0 * float(special.ndtr(-t) if math.isinf(self.dof) else special.stdtr(self.dof, -t))

    def at(self, time: float) -> tuple[float, float]:
        """Return what the unit is at a time, and its standard uncertainty, wander included."""
        x = np.array([1.0, time - self.middle])
        return float(x @ [self.level, self.slope]), math.sqrt(float(x @ self.covariance @ x) + self.wander**2)


def line(times: ArrayLike, figures: Sequence[Figure], stretches: Sequence[int] | None = None) -> Line:
    """Return the line through figures of one unit; unknowns of one name have one value in all of them.

    Parameters
    ----------
    times : array_like, shape (n,)
        One a figure.
    figures : sequence of Figure
        In one unit.
    stretches : sequence of int, shape (n,), optional
        How often the unit had been adjusted by then; the line is that of the last stretch.

    Raises
    ------
    DataError
        ``one_time`` for fewer than two times; ``no_uncertainty`` where no figure has any.

    Examples
    --------
    >>> tests = [Figure(y, 0.05, changes={"table": 0.04}) for y in (1.00, 1.02, 1.06)]
    >>> found = line([0.0, 1.0, 2.0], tests)
    >>> round(found.slope, 4), round(found.u, 4)  # of three tests the residuals tell it: 0.0082 / sqrt(2)
    (0.03, 0.0058)
    """
    t = np.asarray(times, dtype=float)
    which = np.zeros(t.size, dtype=int) if stretches is None else np.asarray(stretches, dtype=int)
    levels = np.unique(which)
    if len(figures) != t.size or not any(np.unique(t[which == one]).size > 1 for one in levels):
        raise DataError("tests at one time show no drift", do="Add a test of another day", code="one_time")
    if not any(one.u > 0.0 for one in figures):
        raise DataError("no figure has an uncertainty: its drift has none", code="no_uncertainty")
    names = sorted({name for one in figures for name in (*one.changes, *one.curvature)})
    size = {name: max((one.curvature[name].size for one in figures if name in one.curvature), default=0.0)
            for name in names}  # fmt: skip
    shared = np.array([[_change(one, name, size[name]) for one in figures] for name in names]).reshape(-1, t.size)
    parts = [one.scatter(_names(one, names)) for one in figures]
    own = np.array([one.own(_names(one, names)) for one in figures])
    scatter = np.array([math.fsum(variance for variance, _ in each) for each in parts])
    known = np.maximum(own - scatter, 0.0)
    dofs = np.array([_joined(each) for each in parts])
    even = _evened(scatter, dofs)
    V = np.diag(known + even) + shared.T @ shared
    V += np.eye(t.size) * SINGULAR * V.diagonal().max()
    y = np.array([one.value for one in figures])
    X = np.column_stack([*(which == one for one in levels), t - t.mean()]).astype(float)
    left = t.size - X.shape[1]
    chi2, _, _ = _fit(X, y, V)
    consistency = float(special.chdtrc(left, chi2)) if left else 1.0
    wander2 = _wander(X, y, V) if left and chi2 > left else 0.0
    whole = V + wander2 * np.eye(t.size)
    chi2, coefficients, covariance = _fit(X, y, whole)
    basis: Basis = "residuals" if left else "stated"
    if left:
        several = (np.count_nonzero(shared, axis=1) > 1).any()  # then residuals hardly show the errors of standards
        fixed = covariance @ X.T @ np.linalg.solve(whole, shared.T) * several
        fixed = fixed @ fixed.T
        scaled = (covariance - fixed) * (max(chi2, float(special.chdtri(left, 1.0 - CHANCE))) / left)
        covariance = fixed + scaled
        u = math.sqrt(covariance[-1, -1])
        dof = float(left)
    elif t.size == 2:
        first, second = np.argsort(t)
        both = difference(figures[first], figures[second])
        apart = float(t[second] - t[first])
        u, dof, basis = both.u / apart, both.dof, "difference"
    else:
        weights = covariance[-1] @ X.T @ np.linalg.inv(whole)
        u = math.sqrt(covariance[-1, -1])
        varied = [(weights[i] ** 2 * even[i], dofs[i]) for i in np.flatnonzero(even) if math.isfinite(dofs[i])]
        dof = degrees_of_freedom(u**2, varied)
    slope, level = coefficients[-1], coefficients[-2]
    variance, both_vary, own_level = covariance[-1, -1], covariance[-2, -1], covariance[-2, -2]
    shift = float(both_vary / variance) if variance else 0.0  # to where they are independent
    spread = float(own_level - both_vary * shift)
    return Line(
        float(slope), u, dof, float(t.mean()) - shift, float(level - slope * shift),
        np.diag([max(spread, 0.0), u**2]), math.sqrt(wander2), consistency, basis,
        _common(shared), _departure(t, X, y, whole),
    )  # fmt: skip


def _departure(t: Array, X: Array, y: Array, V: Array) -> Departure | None:
    """Return the clearest departure from a line: a curve, a step or an odd test, as one more column."""
    n, spare = t.size, t.size - X.shape[1] - 1
    if spare < SPARE:
        return None
    rank = np.empty(n, dtype=int)
    rank[np.argsort(t, kind="stable")] = np.arange(n)
    tried: list[tuple[Kind, int]] = [("bend", 0), *(("jump", i) for i in range(2, n - 1))]
    tried += [("odd", i) for i in range(n)]
    columns = np.column_stack([
        ((t - t.mean()) / np.ptp(t)) ** 2, *(rank >= i for i in range(2, n - 1)), *(rank == i for i in range(n))
    ])  # fmt: skip
    lower = np.linalg.cholesky(V)
    A, C, z = (linalg.solve_triangular(lower, one, lower=True) for one in (X, columns, y))
    Q, _ = np.linalg.qr(A)
    C, z = C - Q @ (Q.T @ C), z - Q @ (Q.T @ z)  # what the line leaves of both
    length = np.sum(C**2, axis=0)
    there = length > SINGULAR * np.sum(linalg.solve_triangular(lower, columns, lower=True) ** 2, axis=0)
    size = np.divide(C.T @ z, length, out=np.zeros(len(tried)), where=there)
    found = size**2 * length  # of the sum of squares
    rest = np.maximum(float(z @ z) - found, SINGULAR * float(z @ z))
    ratio = np.divide(found, rest, out=np.zeros(len(tried)), where=rest > 0.0)
    best = int(np.argmax(ratio))
    p_value = 2.0 * float(special.stdtr(spare, -math.sqrt(ratio[best] * spare))) * int(there.sum())
    kind, index = tried[best]
    bow = columns[:, 0] - X @ np.linalg.lstsq(X, columns[:, 0], rcond=None)[0] if kind == "bend" else np.ones(1)
    return Departure(kind, index, float(size[best] * np.abs(bow).max()), min(p_value, 1.0))


def _names(one: Figure, names: Sequence[str]) -> list[str]:
    return [name for name in names if name in one.changes or name in one.curvature]


def _common(shared: Array) -> float:
    """Return what errors that all tests have move all of them by: the least that each moves one."""
    every = shared[np.abs(shared.sum(axis=1)) == np.abs(shared).sum(axis=1)]  # of one sign
    return math.sqrt(float(np.sum(np.min(np.abs(every), axis=1, initial=math.inf) ** 2))) if every.size else 0.0


def _change(one: Figure, name: str, size: float) -> float:
    """Return the change by an unknown; a curvature of the unit has one size in all figures, the largest."""
    return one.curvature[name].change * size if name in one.curvature else one.changes.get(name, 0.0)


def _joined(parts: Sequence[tuple[float, float]]) -> float:
    """Return the degrees of freedom of scatters together, by Welch and Satterthwaite."""
    whole = math.fsum(variance for variance, _ in parts)
    return whole**2 / math.fsum(variance**2 / dof for variance, dof in parts) if whole else math.inf


def _evened(scatter: Array, dofs: Array) -> Array:
    """Return scatters as one size for all where their differences may be chance."""
    there = (scatter > 0.0) & np.isfinite(dofs)
    if there.sum() < 2:
        return scatter
    variance, dof = scatter[there], dofs[there]
    pooled = float(dof @ variance / dof.sum())
    k = there.sum()
    bartlett = dof.sum() * math.log(pooled) - float(dof @ np.log(variance))
    bartlett /= 1.0 + (float(np.sum(1.0 / dof)) - 1.0 / dof.sum()) / (3.0 * (k - 1))
    if special.chdtrc(k - 1, bartlett) < UNEQUAL:
        return scatter
    return np.where(there, pooled, scatter)


def _fit(X: Array, y: Array, V: Array) -> tuple[float, Array, Array]:
    """Return the weighted sum of squares of residuals, the coefficients of the columns, and their covariance."""
    lower = np.linalg.cholesky(V)
    A, z = linalg.solve_triangular(lower, X, lower=True), linalg.solve_triangular(lower, y, lower=True)
    covariance = np.linalg.inv(A.T @ A)
    coefficients = covariance @ (A.T @ z)
    rest = z - A @ coefficients
    return float(rest @ rest), coefficients, covariance


def _wander(X: Array, y: Array, V: Array) -> float:
    """Return the variance between tests with which the residuals are as large as they should be."""
    left = y.size - X.shape[1]
    identity = np.eye(y.size)

    def excess(variance: float) -> float:
        return float(_fit(X, y, V + variance * identity)[0] - left)

    high = float(np.var(y)) or 1.0
    while excess(high) > 0.0:
        high *= 4.0
    return float(optimize.brentq(excess, 0.0, high, rtol=1e-6))


@dataclass(frozen=True)
class Due:
    """When a unit leaves a limit, counted from its last test.

    Parameters
    ----------
    first : float or None
        Time from which its 95 % interval no longer lies inside: recalibrate by then; None where that does not happen.
    expected : float or None
        Time at which the line itself leaves.
    last : float or None
        Time from which the interval lies wholly outside.
    """

    first: float | None
    expected: float | None
    last: float | None


def due(found: Line, last: float, value: float, limit: float, horizon: float) -> Due:
    """Return when a unit has changed by more than a limit since its last test.

    Parameters
    ----------
    found : Line
        Through its figures.
    last, value : float
        Time and figure of the last test, which is what users correct by.
    limit : float
        That the change may reach, in the unit of the figures.
    horizon : float
        Time after the last test up to which is looked.
    """

    def leaves(side: float) -> float | None:
        factor = 0.0 if not side else t_quantile(found.dof, 0.5 + 0.5 * P) * side

        def beyond(time: float) -> float:
            level, whole = found.at(time)
            u = math.sqrt(max(whole**2 - found.common**2, 0.0))
            return abs(level - value) + factor * u - limit

        steps = np.linspace(last, last + horizon, 512)
        signs = [beyond(float(step)) for step in steps]
        at = next((i for i, sign in enumerate(signs) if sign > 0.0), None)
        if at is None:
            return None
        return float(optimize.brentq(beyond, steps[at - 1], steps[at], xtol=1e-6 * horizon)) - last if at else 0.0

    return Due(leaves(1.0), leaves(0.0), leaves(-1.0))
