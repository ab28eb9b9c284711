"""What a quantity scatters from unit to unit, with the measurement's own scatter taken off; its capability.

A figure ``v_i`` of unit i, tested at station g, is::

    v_i = mean + d_i + b_g + e_i        d ~ N(0, s^2)   e_i ~ N(0, o_i^2)   b_g ~ N(0, c^2 + t^2)

d is what the population scatters; e the part of the test's error that is drawn anew for each unit (its ``own``
standard uncertainty ``o_i``, known by ``dof_i``); b what all units of a station share: the errors of its standards,
of the stated size c, and anything more (t, found from the stations). Inside stations ``S^2``, the pooled variance, is
expected to be ``s^2 + mean of o_i^2``, so that::

    s^2 = S^2 - mean of o_i^2

Intervals are those of generalized pivots [1]_, [2]_: ``S^2`` over a chi-square with ``n`` degrees of freedom, less
the mean of ``o_i^2`` over one with its own (Welch-Satterthwaite of the ``dof_i``). From ``KURTOSIS_FROM`` units on
the degrees of freedom of ``S^2`` hold the kurtosis that the units show [3]_, so that the interval of s is right for
populations that are not normal. Capability and conforming share follow from the same draws of mean and s; they are
those of a normal population, and ``normal_p`` tells how well one fits.

What breaks this: own uncertainties that are not what repeats show (``excess`` tells when S is smaller than they
allow; larger ones count as population: see ``gauge``); a mean that wanders inside a station (see ``factors``); a few
units of another kind, which widen s (see ``outliers``).

References
----------
.. [1] S. Weerahandi, J. Am. Stat. Assoc. 88 (1993) 899-905: generalized confidence intervals.
.. [2] T. Mathew and D. G. Webb, Technometrics 47 (2005) 487: with measurement error.
.. [3] D. G. Bonett, Comput. Stat. Data Anal. 50 (2006) 775-782: interval of a standard deviation that is not normal.
.. [4] S. Kotz and N. L. Johnson, Process Capability Indices, 1993, chapter 2.
.. [5] R. B. D'Agostino and E. S. Pearson, Biometrika 60 (1973) 613-622: skewness and kurtosis as a test.
.. [6] H. Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods, SIAM, 1992, chapter 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.results import Interval

KURTOSIS_FROM = 30  # units from which their kurtosis counts
DRAWS = 4096  # of the pivots
ROOT = 1.2207440846057596  # of x^4 = x + 1: its inverse powers fill three dimensions most evenly
P = 0.95
SIGMAS = 3.0  # from the mean to a limit where a capability is one
LEAST = 1e-12  # of the own variance: a population that scatters less is none


@dataclass(frozen=True, eq=False)
class Population:
    """Mean and scatter of a quantity over units.

    Parameters
    ----------
    n, stations : int
        Units, and stations that tested them.
    mean, mean_u, mean_dof : float
        Of the population, with what stations share.
    observed : float
        Standard deviation inside stations, the tests' own scatter in it.
    own : float
        Root mean square of the own uncertainties.
    scatter : float
        What the population scatters; 0 where the tests explain all that is seen.
    scatter_interval : Interval
        95 %; its low end is 0 where the tests may explain all.
    observed_dof, own_dof : float
        Effective degrees of freedom of the squares of ``observed`` and of ``own``.
    between : float
        Standard deviation between stations beyond the stated uncertainty of their standards.
    excess : float
        Probability of so small an ``observed`` if the own uncertainties were right; tiny: they are stated too large.
    normal_p : float
        Probability of such skewness and kurtosis from normal units; NaN below ``KURTOSIS_FROM``.
    """

    n: int
    stations: int
    mean: float
    mean_u: float
    mean_dof: float
    observed: float
    own: float
    scatter: float
    scatter_interval: Interval
    observed_dof: float
    own_dof: float
    between: float
    excess: float
    normal_p: float

    @property
    def seen(self) -> bool:
        """Whether the population is known to scatter at all."""
        return bool(self.scatter_interval.lo)

    def draws(self) -> tuple[Array, Array]:
        """Return mean and scatter as they may be, ``DRAWS`` of each: scatters may be 0."""
        normal, first, second = _pivots(self.mean_dof, self.observed_dof, self.own_dof)
        square = self.observed**2 / first - self.own**2 / second
        return self.mean + self.mean_u * normal, np.sqrt(np.maximum(square, 0.0))

    def capability(self, lower: float | None, upper: float | None) -> Capability:
        """Return how well the population stays inside limits.

        Raises
        ------
        DataError
            ``bad_limits`` without a limit, or with limits the wrong way round.
        """
        low, high = _checked_limits(lower, upper)
        mean, scatter = self.draws()
        ratio, share = _index(mean, scatter, low, high), _share(mean, scatter, low, high)
        ends = np.quantile(ratio, [(1 - P) / 2, (1 + P) / 2], method="inverted_cdf")
        shares = np.quantile(share, [(1 - P) / 2, (1 + P) / 2])
        at, s = np.array([self.mean]), np.array([self.scatter])
        index = float(_index(at, s, low, high)[0]) if self.seen else math.nan
        both = lower is not None and upper is not None
        width = (high - low) / (2 * SIGMAS * self.scatter) if both and self.seen else math.nan
        top = float(ends[1]) if math.isfinite(ends[1]) and self.seen else None
        return Capability(
            index, Interval(float(ends[0]), top, P), width,
            float(_share(at, s, low, high)[0]), Interval(float(shares[0]), float(shares[1]), P),
        )  # fmt: skip


@dataclass(frozen=True)
class Capability:
    """Capability index and conforming share of a normal population.

    Parameters
    ----------
    cpk : float
        Distance of the mean to the nearer limit over three standard deviations of the population; NaN where the
        population is not known to scatter.
    cpk_interval : Interval
        95 %; without a high end where the scatter may be 0.
    cp : float
        The same if the mean were in the middle; NaN for one limit.
    conforming : float
        Share of the population whose true values lie inside.
    conforming_interval : Interval
        95 %.
    """

    cpk: float
    cpk_interval: Interval
    cp: float
    conforming: float
    conforming_interval: Interval


def population(
    values: Array, own: Array, dof: Array, common: float = 0.0, stations: NDArray[np.intp] | None = None
) -> Population:
    """Return mean and scatter of a population.

    Parameters
    ----------
    values, own, dof : ndarray, shape (n,)
        Of each unit: figure, standard uncertainty that is drawn anew for each unit, its degrees of freedom.
    common : float
        Standard uncertainty of what all units of one station share by its standards.
    stations : ndarray of int, shape (n,), optional
        Station of each, from 0 on; by default one for all.

    Raises
    ------
    DataError
        ``few_units`` where no station has two, or values that are not finite.
    """
    at = np.zeros(values.size, dtype=np.intp) if stations is None else stations
    if not (np.isfinite(values).all() and np.isfinite(own).all() and np.all(own >= 0.0)):
        raise DataError("a figure or its uncertainty is not finite", code="bad_figure")
    sizes = np.bincount(at)
    groups = int(np.count_nonzero(sizes))
    free = values.size - groups
    if free < 1:
        what = f"{values.size} unit(s) at {groups} station(s) leave no scatter from unit to unit"
        raise DataError(what, do="Two units at one station are the least", code="few_units")
    known = sizes > 0
    means = np.bincount(at, values)[known] / sizes[known]
    number = np.cumsum(known) - 1
    rest = values - means[number[at]]
    observed = float(rest @ rest) / free
    share = 1.0 - 1.0 / sizes[at]  # of an own variance that shows inside its station
    squares = own**2
    mine = float(share @ squares) / free
    spread = float(np.sum((share * squares) ** 2 / dof)) / free**2 if mine else 0.0
    own_dof = math.inf if not spread else mine**2 / spread
    observed_dof, normal_p = _shape(rest, free, sizes[at])
    mean, mean_u, mean_dof, between = _centre(means, sizes[known].astype(np.float64), observed, free, common)
    square = observed - mine
    scatter = math.sqrt(square) if square > LEAST * mine else 0.0
    _, first, second = _pivots(mean_dof, observed_dof, own_dof)
    low, high = np.quantile(observed / first - mine / second, [(1 - P) / 2, (1 + P) / 2])
    interval = Interval(math.sqrt(max(float(low), 0.0)), math.sqrt(max(float(high), 0.0)), P)
    excess = 1.0 if not mine else float(special.fdtr(observed_dof, min(own_dof, 1e9), observed / mine))
    return Population(
        values.size, groups, mean, mean_u, mean_dof, math.sqrt(observed), math.sqrt(mine), scatter, interval,
        observed_dof, own_dof, between, excess, normal_p,
    )  # fmt: skip


def _shape(rest: Array, free: int, sizes: NDArray[np.intp]) -> tuple[float, float]:
    """Return the degrees of freedom that the pooled variance has with this kurtosis, and how normal the units are."""
    n = rest.size
    square = float(rest @ rest)
    if n < KURTOSIS_FROM or not square:
        return float(free), math.nan
    scaled = rest * np.sqrt(sizes / np.maximum(sizes - 1, 1))  # as wide as without the mean of its station
    cut = 1.0 / (2.0 * math.sqrt(n - 4))  # Bonett's share trimmed from the mean
    ordered = np.sort(scaled)[int(cut * n) : n - int(cut * n)]
    second = float(scaled @ scaled) / n
    kurtosis = float(np.mean((scaled - ordered.mean()) ** 4)) / second**2
    shrink = n / (n - special.ndtri((1 + P) / 2))
    relative = shrink * (kurtosis - (n - 3) / n) / (n - 1)  # variance of the variance, relative
    dof = min(max(2.0 / relative, 1.0), 20.0 * free) if relative > 0.0 else 20.0 * free
    return dof * free / (n - 1), _normal_p(scaled)


def _normal_p(x: Array) -> float:
    """Return the probability of such skewness and kurtosis, each turned into a normal deviate.

    D'Agostino (1970) for skewness, Anscombe and Glynn (1983) for kurtosis, as [5]_ joins them; ``scipy.stats`` has the
    same and takes half a second to load.
    """
    n, away = x.size, x - x.mean()
    second = float(np.mean(away**2))
    skewness, kurtosis = float(np.mean(away**3)) / second**1.5, float(np.mean(away**4)) / second**2
    y = skewness * math.sqrt((n + 1) * (n + 3) / (6.0 * (n - 2)))
    heavy = 3.0 * (n**2 + 27 * n - 70) * (n + 1) * (n + 3) / ((n - 2.0) * (n + 5) * (n + 7) * (n + 9))
    width = math.sqrt(2.0 * (heavy - 1.0)) - 1.0
    skewed = math.asinh(y / math.sqrt(2.0 / (width - 1.0))) / math.sqrt(0.5 * math.log(width))
    spread = 24.0 * n * (n - 2) * (n - 3) / ((n + 1) ** 2 * (n + 3) * (n + 5))
    peaked = (kurtosis - 3.0 * (n - 1) / (n + 1)) / math.sqrt(spread)
    odd = 6.0 * (n**2 - 5 * n + 2) / ((n + 7) * (n + 9)) * math.sqrt(6.0 * (n + 3) * (n + 5) / (n * (n - 2) * (n - 3)))
    a = 6.0 + 8.0 / odd * (2.0 / odd + math.sqrt(1.0 + 4.0 / odd**2))
    below = 1.0 + peaked * math.sqrt(2.0 / (a - 4.0))
    root = math.copysign(((1.0 - 2.0 / a) / abs(below)) ** (1.0 / 3.0), below) if below else math.nan
    tailed = (1.0 - 2.0 / (9.0 * a) - root) / math.sqrt(2.0 / (9.0 * a))
    return math.exp(-0.5 * (skewed**2 + tailed**2))


def _centre(means: Array, sizes: Array, observed: float, free: int, common: float) -> tuple[float, float, float, float]:
    """Return mean, its uncertainty and degrees of freedom, and what stations differ by beyond their standards."""
    if means.size == 1:
        u = math.sqrt(observed / sizes[0] + common**2)
        dof = math.inf if not observed else free * (u**2 / (observed / sizes[0])) ** 2
        return float(means[0]), u, dof, 0.0
    fixed = observed / sizes + common**2

    def q(extra: float) -> float:
        weights = 1.0 / (fixed + extra)
        middle = float(weights @ means) / float(weights.sum())
        return float(weights @ (means - middle) ** 2)

    extra, groups = 0.0, means.size - 1
    if observed and q(0.0) > groups:  # Paule and Mandel
        low, high = 0.0, float(np.ptp(means)) ** 2 + float(fixed.max())
        for _ in range(80):
            extra = 0.5 * (low + high)
            low, high = (extra, high) if q(extra) > groups else (low, extra)
    weights = 1.0 / (fixed + extra) if fixed.all() or extra else sizes
    total = float(weights.sum())
    mean = float(weights @ means) / total
    if not (fixed.all() or extra):
        return mean, 0.0, math.inf, 0.0
    return mean, math.sqrt(1.0 / total), float(groups) if extra else math.inf, math.sqrt(extra)


@cache
def _uniform() -> Array:
    """Return the draws behind all pivots: three columns of an additive recurrence [6]_, even and the same each time."""
    steps = ROOT ** -np.arange(1.0, 4.0)
    return np.asarray((0.5 + np.arange(1, DRAWS + 1)[:, np.newaxis] * steps) % 1.0)


def _pivots(mean_dof: float, first: float, second: float) -> tuple[Array, Array, Array]:
    """Return draws of Student's t, and of two chi-squares over their degrees of freedom."""
    column = _uniform()[:, 0]
    t = special.ndtri(column) if math.isinf(mean_dof) else special.stdtrit(mean_dof, column)
    one, other = chi_squares(first, second)
    return np.asarray(t), one, other


def chi_squares(*dofs: float) -> list[Array]:
    """Return draws of independent chi-squares over their degrees of freedom, at most three; the same each time."""
    return [_chi_square(dof, 2 - i) for i, dof in enumerate(dofs)]


@lru_cache(maxsize=256)
def _chi_square(dof: float, column: int) -> Array:
    draws = _uniform()[:, column]
    return np.ones(DRAWS) if math.isinf(dof) else np.asarray(special.chdtri(dof, 1.0 - draws) / dof)


def _checked_limits(lower: float | None, upper: float | None) -> tuple[float, float]:
    low, high = -math.inf if lower is None else lower, math.inf if upper is None else upper
    if (lower is None and upper is None) or not low < high:
        raise DataError(f"limits {lower} and {upper}: a lower one below an upper one", code="bad_limits")
    return low, high


def _index(mean: Array, scatter: Array, low: float, high: float) -> Array:
    """Return the capability index; infinite of its sign where nothing scatters."""
    room = np.minimum(mean - low, high - mean)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(scatter > 0.0, room / (SIGMAS * scatter), np.copysign(np.inf, room))


def _share(mean: Array, scatter: Array, low: float, high: float) -> Array:
    """Return the share of a normal population inside limits."""
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = special.ndtr((high - mean) / scatter) - special.ndtr((low - mean) / scatter)
    return np.where(scatter > 0.0, inside, ((mean >= low) & (mean <= high)).astype(np.float64))
