"""Intervals with a stated probability: for a value, a standard deviation, a hit rate, a whole curve.

Values are taken as ``value + u * t`` with Student's t of ``dof`` degrees of freedom, normal where they are
infinite (JCGM 100, G.3). Degrees of freedom need not be whole numbers: Satterthwaite's [1]_, and those of joined parts
(``core.estimate.joined_dof``), are any positive number. Zero or NaN degrees of freedom mean that no scatter was
estimated, and no interval is made of them.

References
----------
.. [1] JCGM 100:2008, annex G.
.. [2] Clopper and Pearson, Biometrika 26 (1934) 404-413.
.. [3] Sidak, J. Am. Stat. Assoc. 62 (1967) 626-633; Scheffe, Biometrika 40 (1953) 87-104.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy import special

from ..core.errors import DataError, PlanError
from ..core.estimate import Array
from ..core.results import Interval
from ..core.show.rounding import freedom

FEW = 64  # values whose factors are remembered
ALIKE = 0.005  # of the logarithm of deviations that are taken together


def t_quantile(dof: float, p: float) -> float:
    """Return the value that Student's t stays below with probability ``p`` (one-sided).

    Parameters
    ----------
    dof : float
        Degrees of freedom; infinite gives the normal distribution.
    p : float
        Probability, between 0 and 1.

    Raises
    ------
    DataError
        If the degrees of freedom are zero, negative or NaN.
    PlanError
        If ``p`` is not between 0 and 1.
    """
    _check_probability(p)
    _check_dof(dof)
    return _t_quantile(float(dof), float(p))


@lru_cache(maxsize=4096)
def _t_quantile(dof: float, p: float) -> float:
    return float(special.ndtri(p) if math.isinf(dof) else special.stdtrit(dof, p))


def coverage_factor(dof: float, p: float = 0.95) -> float:
    """Return k: ``value ± k u`` is the two-sided interval of probability ``p`` (JCGM 100, G.3.2).

    Raises
    ------
    DataError
        If the degrees of freedom are zero, negative or NaN.
    PlanError
        If ``p`` is not between 0 and 1.
    """
    return _coverage_factor(float(dof), float(p))


@lru_cache(maxsize=4096)
def _coverage_factor(dof: float, p: float) -> float:
    _check_probability(p)
    return t_quantile(dof, 0.5 * (1.0 + p))


def t_interval(value: float, u: float, dof: float, p: float = 0.95) -> Interval:
    """Return the two-sided interval of a value, in its unit.

    Parameters
    ----------
    value, u : float
        Estimate and its standard uncertainty, in one unit.
    dof : float
        Degrees of freedom of ``u``; infinite where it is known.
    p : float
        Probability of the interval.

    Raises
    ------
    DataError
        If the value is not finite, ``u`` is negative or not finite, or there are no degrees of freedom.
    PlanError
        If ``p`` is not between 0 and 1.
    """
    _check_value(value, u)
    half = coverage_factor(dof, p) * u
    return Interval(value - half, value + half, p)


def t_intervals(values: Array, u: Array, dof: Array, p: float = 0.95) -> list[Interval]:
    """Return `t_interval` of each of several values, shapes (k,), and raise as that does."""
    if not (np.isfinite(values).all() and np.isfinite(u).all() and (u >= 0.0).all() and (dof > 0.0).all()):
        return [t_interval(*one, p) for one in zip(values.tolist(), u.tolist(), dof.tolist(), strict=True)]
    _check_probability(p)
    below = 0.5 * (1.0 + p)
    if len(dof) and np.all(dof == dof[0]):
        half = coverage_factor(float(dof[0]), p) * u
    else:
        half = (_known_factors(dof.tobytes(), below) if len(dof) <= FEW else _factors(dof, below)) * u
    return [
        Interval.of_own(lo, hi, p) for lo, hi in zip((values - half).tolist(), (values + half).tolist(), strict=True)
    ]


@lru_cache(maxsize=1024)  # a parameter stands among the figures of its test, and once more among those of the model
def _known_factors(dof: bytes, below: float) -> Array:
    return _factors(np.frombuffer(dof), below)


def _factors(dof: Array, below: float) -> Array:
    known = np.isinf(dof)
    return np.asarray(np.where(known, special.ndtri(below), special.stdtrit(np.where(known, 1.0, dof), below)))


def t_intervals_each(figures: Sequence[tuple[Array, Array, Array]], p: float = 0.95) -> list[list[Interval]]:
    """Return `t_intervals` of each of several sets of values, u and degrees of freedom, all at once."""
    if not figures:
        return []
    values, u, dof = (np.concatenate(column) for column in zip(*figures, strict=True))
    found = t_intervals(values, u, dof, p)
    stops = np.cumsum([len(one[0]) for one in figures]).tolist()
    return [found[start:stop] for start, stop in zip([0, *stops], stops, strict=False)]


def upper_bound(value: float, u: float, dof: float, p: float = 0.95) -> float:
    """Return the bound that the true value stays below with probability ``p`` (one-sided).

    Raises
    ------
    DataError, PlanError
        As `t_interval`.
    """
    _check_value(value, u)
    return value + t_quantile(dof, p) * u


def student_of_mixture(deviations: Array, probability: Array, dof: float = math.inf) -> tuple[float, float]:
    """Return the scale and the degrees of freedom of Student's t with the 95 % interval of a mixture.

    Parameters
    ----------
    deviations : ndarray, shape (n,)
        Standard deviations of an error.
    probability : ndarray, shape (n,)
        Of each; they add up to 1.
    dof : float
        Degrees of freedom of each; infinite: normal.

    Returns
    -------
    tuple of float
        The median deviation, and degrees of freedom, one at least. Where one would not do, the scale is larger.
    """
    from scipy import optimize  # noqa: PLC0415 - heavy import, which most commands need not wait for

    order = np.argsort(deviations)
    u = float(deviations[order][np.searchsorted(np.cumsum(probability[order]), 0.5)])
    bins, members = np.unique(np.round(np.log(deviations / u) / ALIKE), return_inverse=True)
    sizes, shares = np.exp(ALIKE * bins), np.bincount(members, weights=probability)

    def outside(half: float) -> float:
        t = -half / sizes
        return float(shares @ (2.0 * (special.ndtr(t) if math.isinf(dof) else special.stdtr(dof, t)))) - 0.05

    quantile = max(float(optimize.brentq(outside, 0.5, 60.0 * float(sizes.max()), xtol=1e-6)), 1.97)
    most = float(special.stdtrit(1.0, 0.975))
    if quantile > most:  # more than half of it is unseen
        return u * quantile / most, 1.0
    return u, float(optimize.brentq(lambda nu: special.stdtrit(nu, 0.975) - quantile, 1.0, 1e4))


def ends(interval: Interval) -> tuple[float, float]:
    """Return both ends of an interval as numbers; an open side is infinite."""
    lo = -math.inf if interval.lo is None else interval.lo
    return lo, math.inf if interval.hi is None else interval.hi


def contains(interval: Interval, value: float) -> bool:
    """Say whether a value lies in an interval, its ends included."""
    lo, hi = ends(interval)
    return lo <= value <= hi


def chi_square_interval(std: float, dof: float, p: float = 0.95) -> Interval:
    """Return the two-sided interval of a standard deviation of normal readings, equal tails.

    Parameters
    ----------
    std : float
        Standard deviation found.
    dof : float
        Degrees of freedom behind it; infinite gives the point itself.
    p : float
        Probability of the interval.

    Raises
    ------
    DataError
        If the standard deviation is negative or not finite, or there are no degrees of freedom.
    PlanError
        If ``p`` is not between 0 and 1.
    """
    _check_probability(p)
    _check_dof(dof)
    _check_value(std, std, name="standard deviation")
    if math.isinf(dof):
        return Interval(std, std, p)
    low, high = _chi_square_factors(dof, p)
    return Interval(std * low, std * high, p)


@lru_cache(maxsize=1024)  # the same of all units that are tested alike
def _chi_square_factors(dof: float, p: float) -> tuple[float, float]:
    tail = 0.5 * (1.0 - p)
    largest, smallest = special.chdtri(dof, tail), special.chdtri(dof, 1.0 - tail)
    return math.sqrt(dof / largest), math.sqrt(dof / smallest)


def binomial_interval(hits: int, n: int, p: float = 0.999) -> tuple[float, float]:
    """Return the exact two-sided interval of a hit rate (Clopper and Pearson [2]_).

    Parameters
    ----------
    hits, n : int
        Successes, and trials.
    p : float
        Probability that the interval holds the true rate: at least this much, for every true rate.

    Raises
    ------
    DataError
        If there is no trial, or more hits than trials.
    PlanError
        If ``p`` is not between 0 and 1.
    """
    _check_probability(p)
    if n < 1 or not 0 <= hits <= n:
        raise DataError(f"{hits} hits in {n} trials", do="Need one trial or more, and 0 <= hits <= trials")
    tail = 0.5 * (1.0 - p)
    low = special.betaincinv(hits, n - hits + 1, tail) if hits > 0 else 0.0
    high = special.betaincinv(hits + 1, n - hits, 1.0 - tail) if hits < n else 1.0
    return float(low), float(high)


def covers(hits: int, n: int, low: float = 0.95, high: float = 1.0, p: float = 0.999) -> bool:
    """Say whether a stated 95 % interval keeps its promise: the house's rule for coverage.

    True when the exact binomial interval (probability ``p``) of the hit rate holds 95 %, or lies above it: overlaps
    ``low`` to ``high``. A true coverage inside them fails the rule in at most ``1 - p`` of all such runs.

    Raises
    ------
    DataError, PlanError
        As `binomial_interval`.
    """
    lowest, highest = binomial_interval(hits, n, p)
    return lowest <= high and highest >= low


def band_factor(k: int, dof: float, p: float = 0.95, method: Literal["sidak", "scheffe"] = "sidak") -> float:
    """Return the factor of u that makes intervals hold for all of several values at once.

    Parameters
    ----------
    k : int
        ``"sidak"``: number of values judged. ``"scheffe"``: number of coefficients of the curve, whose
        every point is then held at once.
    dof : float
        Degrees of freedom of the common scatter; infinite where it is known.
    p : float
        Probability that all intervals hold.
    method : {"sidak", "scheffe"}
        Exact for independent values with known u, and never too narrow for correlated ones [3]_; or
        exact for all linear combinations of k coefficients together.

    Raises
    ------
    DataError
        If the degrees of freedom are zero, negative or NaN.
    PlanError
        If ``k`` is below 1 or ``p`` is not between 0 and 1.
    """
    _check_probability(p)
    _check_dof(dof)
    if k < 1:
        raise PlanError(f"simultaneous interval of {k} values", do="Need 1 or more")
    if method == "sidak":
        return coverage_factor(dof, p ** (1.0 / k))
    square = special.chdtri(k, 1.0 - p) if math.isinf(dof) else k * special.fdtri(k, dof, p)
    return math.sqrt(square)


def _check_probability(p: float) -> None:
    if not 0.0 < p < 1.0:
        raise PlanError(f"probability {p}", do="Need more than 0 and less than 1, such as 0.95")


def _check_dof(dof: float) -> None:
    if not dof > 0.0:
        raise DataError(
            freedom(dof),
            why="no scatter was estimated, so no interval can be stated",
            do="Repeat the measurement, at the level that was not repeated",
            code="no_dof",
        )


def _check_value(value: float, u: float, name: str = "value") -> None:
    if not (math.isfinite(value) and math.isfinite(u) and u >= 0.0):
        raise DataError(
            f"{name} {value:g} with standard uncertainty {u:g}",
            do="Need finite numbers and an uncertainty that is not negative",
            code="no_uncertainty",
        )
