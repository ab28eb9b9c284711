"""Uncertainty of a function of an Estimate: by its slopes (GUM) and by Monte Carlo (Supplement 1).

`linear` sends every component of the estimate through the slopes on its own, so that the budget survives.
`monte_carlo` draws from the components: normal where their degrees of freedom are infinite, and where they
are not, Student's t with the standard uncertainty as its *scale*, so that its standard deviation is
``sqrt(dof / (dof - 2))`` times larger (JCGM 101, 6.4.9 [2]_). `compare` is the validation of the first by
the second (JCGM 101, clause 8).

A function takes the values, shape (k,), and returns what is wanted of them, shape (m,).

References
----------
.. [1] JCGM 100:2008, 5.1, 5.2, G.4.
.. [2] JCGM 101:2008, clauses 6, 7 and 8.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import special

from ..core.errors import DataError, PlanError
from ..core.estimate import Array, Component, Estimate
from ..core.results import Interval
from .intervals import ends, t_interval

Function = Callable[[Array], Array]

STEP = 0.01  # of a standard uncertainty: small, so that the slope is that at the estimate
SMALLEST_STEP = float(np.cbrt(np.finfo(float).eps))  # of a value: below it rounding spoils the slope
DRAWS = 200_000  # 1e4 / (1 - p) for p = 0.95 (JCGM 101, 7.2.2)
ROUNDING = 1e-9  # of a variance: a covariance this far from a covariance is taken as rounded


class MonteCarlo(NamedTuple):
    """What the draws gave.

    Parameters
    ----------
    estimate : Estimate
        Mean and covariance of the draws; dof infinite: the doubt about each u is in the draws.
    intervals : tuple of Interval
        One a value.
    samples : ndarray, shape (draws, m)
        The draws of the function.
    """

    estimate: Estimate
    intervals: tuple[Interval, ...]
    samples: Array


@dataclass(frozen=True)
class Comparison:
    """Validation of a linear propagation for one value (JCGM 101, 8.1).

    Parameters
    ----------
    name : str
        Which value.
    delta : float
        Numerical tolerance: half a unit of the last digit of u that counts.
    d_low, d_high : float
        Distance of the ends of the two intervals.
    end_u : float
        Standard uncertainty of the ends of the Monte Carlo interval from the number of draws (the larger).
    """

    name: str
    delta: float
    d_low: float
    d_high: float
    end_u: float

    @property
    def validated(self) -> bool:
        """Both ends agree within the tolerance."""
        return max(self.d_low, self.d_high) <= self.delta

    @property
    def resolved(self) -> bool:
        """There were draws enough for the question: twice ``end_u`` is within the tolerance (7.9.4)."""
        return 2.0 * self.end_u <= self.delta


def linear(
    function: Function,
    estimate: Estimate,
    names: Sequence[str],
    units: Sequence[str],
    jacobian: Array | None = None,
) -> Estimate:
    """Return a function of an estimate, linearised at its values (JCGM 100, 5.1.2 and 5.2.2).

    Every component keeps its source, kind and stated uncertainty. Its degrees of freedom stay where all values
    share them; else a result takes the fewest of the values that it depends on. So independent sources belong
    in components of their own: there Welch-Satterthwaite counts them in full.

    Parameters
    ----------
    function : callable
        (k,) -> (m,).
    estimate : Estimate
        k values.
    names, units : sequence of str
        One a result.
    jacobian : ndarray, shape (m, k), optional
        Slopes of the function; central differences by default.

    Raises
    ------
    DataError
        If the function or a slope is not finite, a shape does not fit, or a covariance is none.

    Examples
    --------
    >>> length = Estimate(("a",), np.array([3.0]), ("m",), (Component("rule", "B", np.array([[0.01]])),))
    >>> area = linear(lambda v: v**2, length, ("area",), ("m2",))
    >>> area.value("area"), area.u.round(9)
    (9.0, array([0.6]))
    """
    values = _evaluate(function, estimate.values, len(names))
    slopes = _slopes(function, estimate, values.size) if jacobian is None else np.asarray(jacobian, float)
    if slopes.shape != (values.size, estimate.values.size) or not np.all(np.isfinite(slopes)):
        raise DataError(
            f"slopes of shape {slopes.shape}, need finite numbers of shape ({values.size}, {estimate.values.size})",
            do="Give a jacobian, or use monte_carlo",
        )
    components = []
    for component in estimate.components:
        factor = slopes @ _factor(component)
        dof = _carried_dof(component, slopes)
        changes = None if component.changes is None else component.changes @ slopes.T
        components.append(replace(component, covariance=factor @ factor.T, dof=dof, changes=changes))
    return Estimate(tuple(names), values, tuple(units), tuple(components))


def monte_carlo(
    function: Function,
    estimate: Estimate,
    names: Sequence[str],
    units: Sequence[str],
    rng: np.random.Generator,
    draws: int = DRAWS,
    p: float = 0.95,
    vectorised: bool = False,
    shortest: bool = False,
) -> MonteCarlo:
    """Return a function of an estimate by drawing from its components (JCGM 101, clause 7).

    Parameters
    ----------
    function : callable
        (k,) -> (m,); with ``vectorised`` (draws, k) -> (draws, m).
    estimate : Estimate
        k values. A component that is ``"rectangular"``, ``"triangular"`` or ``"arcsine"`` is drawn so along each of the
        independent quantities behind it; its degrees of freedom are not used.
    names, units : sequence of str
        One a result.
    rng : numpy.random.Generator
        Where the draws come from.
    draws : int
        How many.
    p : float
        Probability of the intervals.
    vectorised : bool
        Call the function once, with all draws.
    shortest : bool
        Shortest intervals instead of those with equal tails (JCGM 101, 7.7).

    Raises
    ------
    DataError
        If a component has 2 degrees of freedom or fewer (Student's t has no standard deviation then), an
        unknown distribution, or the function is not finite for some draw.
    PlanError
        If there are too few draws for the interval.
    """
    if not 0.0 < p < 1.0 or round(draws * (1.0 - p)) < 100:
        raise PlanError(f"{draws} draws for an interval of probability {p}", do="Need 100 / (1 - p) or more")
    inputs = np.broadcast_to(estimate.values, (draws, estimate.values.size)).copy()
    for component in estimate.components:
        inputs += _draw(component, draws, rng)
    samples = _evaluate_all(function, inputs, len(names), vectorised)
    spread = np.cov(samples, rowvar=False).reshape(len(names), len(names))
    component = Component(f"Monte Carlo, {draws} draws", "B", spread, distribution="draws")
    result = Estimate(tuple(names), samples.mean(axis=0), tuple(units), (component,))
    interval = shortest_interval if shortest else equal_tails
    return MonteCarlo(result, tuple(interval(column, p) for column in samples.T), samples)


def equal_tails(samples: Array, p: float = 0.95) -> Interval:
    """Return the interval that leaves (1 - p)/2 of the samples on each side, shape (draws,)."""
    lo, hi = np.quantile(samples, [0.5 * (1.0 - p), 0.5 * (1.0 + p)])
    return Interval(float(lo), float(hi), p)


def shortest_interval(samples: Array, p: float = 0.95) -> Interval:
    """Return the shortest interval that holds the share p of the samples, shape (draws,)."""
    ordered = np.sort(samples)
    held = min(round(p * ordered.size), ordered.size - 1)
    widths = ordered[held:] - ordered[: ordered.size - held]
    first = int(np.argmin(widths))
    return Interval(float(ordered[first]), float(ordered[first + held]), p)


def compare(linear_estimate: Estimate, drawn: MonteCarlo, digits: int = 2, blocks: int = 20) -> tuple[Comparison, ...]:
    """Return the validation of a linear propagation by Monte Carlo, value by value (JCGM 101, clause 8).

    Parameters
    ----------
    linear_estimate : Estimate
        From `linear`.
    drawn : MonteCarlo
        Of the same function, with intervals of equal tails.
    digits : int
        Significant digits of u that count: 1 or 2.
    blocks : int
        Parts that the draws are cut into to see how well they fix the ends.

    Raises
    ------
    DataError
        If names differ, or an uncertainty is zero.
    """
    if linear_estimate.names != drawn.estimate.names:
        raise DataError(f"values {linear_estimate.names} compared with {drawn.estimate.names}")
    found = []
    for i, name in enumerate(linear_estimate.names):
        u = float(linear_estimate.u[i])
        mine = t_interval(float(linear_estimate.values[i]), u, float(linear_estimate.dof[i]), drawn.intervals[i].p)
        distance = np.abs(np.subtract(ends(drawn.intervals[i]), ends(mine)))
        parts = np.array_split(drawn.samples[:, i], blocks)
        tails = [0.5 * (1.0 - mine.p), 0.5 * (1.0 + mine.p)]
        scatter = np.std([np.quantile(part, tails) for part in parts], axis=0, ddof=1) / math.sqrt(blocks)
        found.append(
            Comparison(name, tolerance(u, digits), float(distance[0]), float(distance[1]), float(scatter.max()))
        )
    return tuple(found)


def tolerance(u: float, digits: int = 2) -> float:
    """Return half a unit of the last significant digit of a standard uncertainty (JCGM 101, 7.9.2).

    Raises
    ------
    DataError
        If the uncertainty is not a positive number.

    Examples
    --------
    >>> tolerance(0.00035, digits=2)
    5e-06
    """
    if not (u > 0.0 and math.isfinite(u)):
        raise DataError(f"numerical tolerance of a standard uncertainty {u:g}", do="Need a positive number")
    exponent = int(f"{u:.{digits - 1}e}".split("e")[1]) - digits + 1
    return float(f"5e{exponent - 1}")


def _slopes(function: Function, estimate: Estimate, m: int) -> Array:
    """Central differences, shape (m, k); 0 for a value without uncertainty, which moves nothing."""
    slopes = np.zeros((m, estimate.values.size))
    for i, u in enumerate(estimate.u):
        if u > 0.0:
            step = max(STEP * float(u), SMALLEST_STEP * abs(float(estimate.values[i])))
            above, below = estimate.values.copy(), estimate.values.copy()
            above[i] += step
            below[i] -= step
            change = _evaluate(function, above, m) - _evaluate(function, below, m)
            slopes[:, i] = change / (above[i] - below[i])
    return slopes


def _evaluate(function: Function, values: Array, m: int) -> Array:
    found = np.atleast_1d(np.asarray(function(values), dtype=float))
    if found.shape != (m,) or not np.all(np.isfinite(found)):
        raise DataError(
            f"function of {values.tolist()} is {found.tolist()}",
            do=f"Need {m} finite number(s), one a name",
            code="not_finite",
        )
    return found


def _evaluate_all(function: Function, inputs: Array, m: int, vectorised: bool) -> Array:
    rows = function(inputs) if vectorised else [np.atleast_1d(function(row)) for row in inputs]
    samples = np.asarray(rows, dtype=float)
    if samples.shape != (inputs.shape[0], m):
        raise DataError(f"function gives shape {samples.shape}, need ({inputs.shape[0]}, {m})")
    bad = int(np.count_nonzero(~np.isfinite(samples).all(axis=1)))
    if bad:
        raise DataError(
            f"function is not finite for {bad} of {inputs.shape[0]} draws",
            why="leaving them out would make the uncertainty too small",
            do="Keep the function's arguments where it is defined, or reduce their uncertainty",
            code="not_finite",
        )
    return samples


def _carried_dof(component: Component, slopes: Array) -> Array | float:
    dof = np.asarray(component.dof, dtype=float)
    if dof.ndim == 0 or np.all(dof == dof.flat[0]):
        return float(dof.flat[0])
    counts = (slopes != 0.0) & (np.diag(component.covariance) > 0.0)
    return np.asarray(np.min(np.where(counts, dof, np.inf), axis=1), dtype=float)


def _factor(component: Component) -> Array:
    """Matrix L with L L' the covariance, a column an independent quantity (Cholesky, zeros allowed)."""
    u = component.u
    scale = np.where(u > 0.0, u, 1.0)
    rest = component.covariance / np.outer(scale, scale)
    factor = np.zeros_like(rest)
    for j in range(u.size):
        pivot = rest[j, j]
        if pivot > ROUNDING:
            factor[:, j] = rest[:, j] / math.sqrt(pivot)
            rest = rest - np.outer(factor[:, j], factor[:, j])
    if np.max(np.abs(rest), initial=0.0) > math.sqrt(ROUNDING):
        raise DataError(
            f"{component.source}: covariance is not positive semi-definite",
            why="some combination of the values would have a negative variance",
            do="Look at the correlations: one of them is too large",
        )
    return np.asarray(scale[:, None] * factor, dtype=float)


def _draw(component: Component, draws: int, rng: np.random.Generator) -> Array:
    """Errors of one component, shape (draws, k)."""
    factor = _factor(component)
    errors = _standard(component, (draws, factor.shape[1]), rng) @ factor.T
    dof = np.broadcast_to(np.asarray(component.dof, dtype=float), component.u.shape)
    finite = np.isfinite(dof) & (component.u > 0.0)
    if component.distribution in ("rectangular", "triangular", "arcsine") or not finite.any():
        return np.asarray(errors, dtype=float)
    if not np.all(dof[finite] > 2.0):
        raise DataError(
            f"{component.source}: {np.min(dof[finite]):g} degrees of freedom",
            why="Student's t has no standard deviation with 2 or fewer",
            do="Use linear propagation, or repeat the measurement more often",
            code="few_dof",
        )
    # One chance for all values: scatter that was estimated too small is so for all at once.
    distinct, which = np.unique(dof[finite], return_inverse=True)
    ratio = np.sqrt(special.chdtri(distinct, rng.uniform(size=(draws, 1))) / distinct)
    errors[:, finite] /= ratio[:, which]
    return np.asarray(errors, dtype=float)


def _standard(component: Component, shape: tuple[int, int], rng: np.random.Generator) -> Array:
    """Independent draws with mean 0 and variance 1."""
    if component.distribution in ("normal", "t"):
        return rng.standard_normal(shape)
    if component.distribution == "rectangular":
        return rng.uniform(-math.sqrt(3.0), math.sqrt(3.0), shape)
    if component.distribution == "triangular":
        return rng.triangular(-math.sqrt(6.0), 0.0, math.sqrt(6.0), shape)
    if component.distribution == "arcsine":  # the cosine of an unknown angle
        return math.sqrt(2.0) * np.cos(rng.uniform(0.0, 2.0 * math.pi, shape))
    raise DataError(
        f"{component.source}: distribution {component.distribution!r}",
        do="Known are: normal, t, rectangular, triangular, arcsine",
    )
