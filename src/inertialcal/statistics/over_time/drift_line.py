"""Drift of a unit: the slope of its figures over time, where tests share errors of standards.

Figures ``y_i`` at times ``t_i`` are taken as ``y = a + b t + wander``: a straight line, and what the unit does between
tests beyond the stated uncertainties, independent from test to test with an unknown standard deviation. Their
covariance is::

    V = diag(own variance) + sum over shared unknowns of c c'      c: signed changes by one standard uncertainty

so that an error which all tests have in common, as that of one certificate, moves the line and not its slope, and one
that changed in between (another certificate) enters the slope. The line is that of generalised least squares [1]_.

With ``ENOUGH`` tests or more, the residuals say how far tests scatter: a wander is added to V until the residuals fit
(Paule and Mandel [2]_, with the whole V), and u is scaled by them (Hartung and Knapp [3]_, Student's t with n - 2
degrees of freedom). The interval is then exact where V is right but for its size, and near that with a wander. Fewer
tests hardly show a wander: u is what the stated uncertainties give, with their degrees of freedom, unless the residuals
contradict them at 5 %. Of two tests it is their difference (``statistics.difference``) over the time between.

Scatter of few degrees of freedom is one size for all tests where Bartlett's test does not reject that at 1 %: weights
by scatters that chance made small would give too small a u.

Real data break this where (1) the unit wanders as a random walk, or jumps once: the residuals then follow each other,
and u is too small; (2) a standard was repaired under the same certificate; (3) tests were made each time after another
one, as a shock. A control chart (``control_charts``) shows (1).

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

ENOUGH = 6  # tests from which the residuals say how far tests scatter
REJECTED = 0.05  # probability of residuals, of fewer tests, below which the stated uncertainties are contradicted
UNEQUAL = 0.01  # of Bartlett's test, below which scatters are taken as different
SINGULAR = 1e-12  # of the largest variance, where a figure has none of its own
P = 0.95
Basis = Literal["difference", "stated", "residuals"]


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
        What ``u`` rests on.
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


def line(times: ArrayLike, figures: Sequence[Figure]) -> Line:
    """Return the line through figures of one unit; unknowns of one name have one value in all of them.

    Parameters
    ----------
    times : array_like, shape (n,)
        One a figure.
    figures : sequence of Figure
        In one unit.

    Raises
    ------
    DataError
        ``one_time`` for fewer than two times; ``no_uncertainty`` where no figure has any.

    Examples
    --------
    >>> tests = [Figure(y, 0.05, changes={"table": 0.04}) for y in (1.00, 1.02, 1.06)]
    >>> found = line([0.0, 1.0, 2.0], tests)
    >>> round(found.slope, 4), round(found.u, 4)  # the error of the table is not in it: 0.03 / sqrt(2)
    (0.03, 0.0212)
    """
    t = np.asarray(times, dtype=float)
    if len(figures) != t.size or np.unique(t).size < 2:
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
    n = t.size
    chi2, _, _ = _fit(t, y, V)
    left = n - 2
    consistency = float(special.chdtrc(left, chi2)) if left else 1.0
    judged = n >= ENOUGH or (left > 0 and consistency < REJECTED)
    wander2 = _wander(t, y, V) if judged and chi2 > left else 0.0
    whole = V + wander2 * np.eye(n)
    chi2, coefficients, covariance = _fit(t, y, whole)
    basis: Basis = "residuals" if judged else "stated"
    if judged:
        covariance = covariance * (chi2 / left)
        u, dof = math.sqrt(covariance[1, 1]), float(left)
    elif n == 2:
        first, second = np.argsort(t)
        both = difference(figures[first], figures[second])
        apart = float(t[second] - t[first])
        u, dof, basis = both.u / apart, both.dof, "difference"
    else:
        weights = covariance[1] @ np.vstack([np.ones(n), t - t.mean()]) @ np.linalg.inv(whole)
        u = math.sqrt(covariance[1, 1])
        varied = [(weights[i] ** 2 * even[i], dofs[i]) for i in range(n) if even[i] and math.isfinite(dofs[i])]
        dof = degrees_of_freedom(u**2, varied)
    shift = float(covariance[0, 1] / covariance[1, 1]) if covariance[1, 1] else 0.0  # to where they are independent
    level = float(coefficients[0] - coefficients[1] * shift)
    spread = float(covariance[0, 0] - covariance[0, 1] * shift)
    return Line(
        float(coefficients[1]), u, dof, float(t.mean()) - shift, level, np.diag([max(spread, 0.0), u**2]),
        math.sqrt(wander2), consistency, basis,
    )  # fmt: skip


def _names(one: Figure, names: Sequence[str]) -> list[str]:
    return [name for name in names if name in one.changes or name in one.curvature]


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


def _fit(t: Array, y: Array, V: Array) -> tuple[float, Array, Array]:
    """Return the weighted sum of squares of residuals, level at the mean time and slope, and their covariance."""
    X = np.column_stack([np.ones(t.size), t - t.mean()])
    lower = np.linalg.cholesky(V)
    A, z = linalg.solve_triangular(lower, X, lower=True), linalg.solve_triangular(lower, y, lower=True)
    covariance = np.linalg.inv(A.T @ A)
    coefficients = covariance @ (A.T @ z)
    rest = z - A @ coefficients
    return float(rest @ rest), coefficients, covariance


def _wander(t: Array, y: Array, V: Array) -> float:
    """Return the variance between tests with which the residuals are as large as they should be."""
    left = t.size - 2
    identity = np.eye(t.size)

    def excess(variance: float) -> float:
        return _fit(t, y, V + variance * identity)[0] - left

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
            level, u = found.at(time)
            return abs(level - value) + factor * u - limit

        steps = np.linspace(last, last + horizon, 512)
        signs = [beyond(float(step)) for step in steps]
        at = next((i for i, sign in enumerate(signs) if sign > 0.0), None)
        if at is None:
            return None
        return float(optimize.brentq(beyond, steps[at - 1], steps[at], xtol=1e-6 * horizon)) - last if at else 0.0

    return Due(leaves(1.0), leaves(0.0), leaves(-1.0))
