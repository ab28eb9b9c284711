"""Units that are of another kind than the rest: robust Mahalanobis distances on all parameters together.

A parameter of a unit is ``mean + d + b + e``: d what the population scatters, b what its station shares, e what its
test draws anew. Each is standardized by what the unit's own test allows: by ``sqrt(s^2 + u^2)``, s robustly of the lot
and u that of the unit, and told as the normal deviate that is as rare as it is by Student's t with the degrees of
freedom of that sum (Welch-Satterthwaite). So a unit whose test is ten times as uncertain has to lie ten times as far
off. Uncertainties on few degrees of freedom are moderated by those of the other units [1]_, but for those that are
larger than that explains, and for units whose test chose other terms than most (``usual``): what was chosen by chance
has an uncertainty that is small by chance, and other units do not tell it. Of b the part that the units of a station
show is taken off, the rest is allowed for.

The joint covariance of what is so standardized is that of the orthogonalized Gnanadesikan-Kettenring estimate [2]_,
reweighted: mean and covariance of the units that are no outliers. A unit that was not among these is as far off as a
new observation would be, whose squared distance follows ``p (n^2 - 1) / (n (n - p)) F(p, n - p)`` [3]_. Parameters
with an uncertainty of their own correlate otherwise than those of most units: each is judged apart, with half of the
false alarms that are allowed. A unit is an outlier beyond the quantile by which a lot of normal units has any in 5 %.

A unit may lack parameters: it is judged on those that it has. Parameters that are positive and skewed are taken as
logarithms; one of heavy tails is left out. What breaks this: heavy tails of several together, of which more than the
stated 5 % of lots have such units (``heavy``); two populations of about the same size, of which neither is an outlier;
fewer than ``PER_PARAMETER`` units a parameter, where the later parameters are left out. Of a unit that was tested
several times one test makes centre and covariance: all of them would make a cluster.

References
----------
.. [1] G. K. Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004) 3, section 4.
.. [2] R. A. Maronna and R. H. Zamar, Technometrics 44 (2002) 307-317.
.. [3] J. Hardin and D. M. Rocke, J. Comput. Graph. Stat. 14 (2005) 928-946, section 2.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from ...core.estimate import Array

P = 0.05  # that a lot of normal units has any outlier
PER_PARAMETER = 10  # units that a parameter needs
INSIDE = 0.975  # of normal units that the covariance is taken of
MAD = 1.482602218505602  # standard deviations of a normal population in its median absolute deviation
LEAST = 1e-5  # eigenvalue of the correlation below which a direction is no information
BULK = 0.85  # of the units: a lot may hold as many as 15 % of another kind
HEAVY = 1.3  # times as far out as normal units, from which tails are heavy
ROUNDS = 10  # of the covariance
TAILS = 100  # units from which tails of one parameter are looked at
KNOWN = 0.5  # share of the units that must have a parameter
NORMAL = 0.6744897501960817  # median absolute deviate of a normal population
SURE = 1e6  # degrees of freedom that are as good as no end
PRIORS = (SURE, 200.0, 100.0, 50.0, 30.0, 20.0, 15.0, 10.0, 7.0, 5.0, 4.0, 3.0, 2.0, 1.0)  # degrees of freedom
NODES = 1000  # of a spline in place of a function that is slow
OWN = 0.01  # probability of so large an uncertainty from which it is the unit's own, whatever the others have
APART = 1.1  # times that a parameter may scatter wider than of most units, and correlate as theirs


@dataclass(frozen=True, eq=False)
class Outliers:
    """How far each unit lies from the rest.

    Parameters
    ----------
    used : ndarray of int
        Columns of the parameters that are judged.
    logarithm : ndarray of bool, shape of ``used``
        Which of these as logarithms.
    distance : ndarray, shape (n,)
        In standard deviations: the normal deviate that is as rare; NaN for a unit without parameters.
    limit : float
        From which a unit is an outlier.
    outlier : ndarray of bool, shape (n,)
        Which are.
    deviation : ndarray, shape (n, len(used))
        Each parameter of each unit, standardized by what its own test allows; NaN where it has none.
    heavy : bool
        Whether the rest has heavier tails than a normal population.
    """

    used: NDArray[np.intp]
    logarithm: NDArray[np.bool_]
    distance: Array
    limit: float
    outlier: NDArray[np.bool_]
    deviation: Array
    heavy: bool


@dataclass(frozen=True, eq=False)
class Uncertain:
    """How uncertain values are, each array of the shape of the values (n, p) but ``station``.

    Parameters
    ----------
    u : ndarray
        Standard uncertainty that is drawn anew for each unit.
    dof : ndarray
        Its degrees of freedom; may be infinite.
    common : ndarray
        Standard uncertainty that all units of a station share.
    station : ndarray of int, shape (n,)
        Of each unit.
    usual : ndarray of bool
        Which come of the same estimator as those of most units.
    """

    u: Array
    dof: Array
    common: Array
    station: NDArray[np.intp]
    usual: NDArray[np.bool_]


Found = tuple[bool, tuple[Array, NDArray[np.bool_]] | None]  # whether as logarithms; as `_standardized`


def outliers(
    values: Array,
    first: NDArray[np.bool_] | None = None,
    uncertain: Uncertain | None = None,
    each: Callable[[Callable[[int], Found], Sequence[int]], Iterable[Found]] = map,
) -> Outliers:
    """Return how far units lie from the rest.

    Parameters
    ----------
    values : ndarray, shape (n, p)
        Parameters of units, the most important first; NaN where a unit has none.
    first : ndarray of bool, shape (n,), optional
        Which rows are the one of their unit that the rest is known from; all if not given. Every row is judged.
    uncertain : Uncertain, optional
        Of the values; the units scatter all alike if not given.
    each : callable, optional
        As ``map``: that of a pool of threads looks at several parameters at a time.
    """
    first = np.ones(len(values), dtype=bool) if first is None else first
    n = int(first.sum())
    known = np.isfinite(values)
    z, wide = np.full(values.shape, np.nan), np.zeros(values.shape, dtype=bool)
    logarithm = np.zeros(values.shape[1], dtype=bool)

    def alone(j: int) -> Found:
        rows = known[:, j]
        of_rest = first[rows]
        x, one = values[rows, j], None if uncertain is None else _of_rows(uncertain, rows, j)
        skewed = _skewed(x[of_rest])
        if skewed:
            with np.errstate(invalid="ignore", divide="ignore"):
                one = None if one is None else replace(one, u=one.u / x, common=one.common / x)
                x = np.log(x)
        return skewed, _standardized(x, of_rest, one)

    good: list[int] = []
    often = np.flatnonzero((known & first[:, np.newaxis]).sum(axis=0) >= max(KNOWN * n, 2 * PER_PARAMETER)).tolist()
    for j, (skewed, found) in zip(often, each(alone, often), strict=True):
        logarithm[j] = skewed
        if found is not None and len(good) < n // PER_PARAMETER:
            z[known[:, j], j], wide[known[:, j], j] = found
            good.append(j)
    used = np.array(good, dtype=np.intp)
    z, wide = z[:, used], wide[:, used]
    distance, heavy = np.full(len(values), np.nan), False
    limit = float(-special.ndtri(P / max(len(values), 1) / 2.0))
    if used.size:
        complete = np.isfinite(z).all(axis=1) & first
        whole = complete & ~wide.any(axis=1)
        if whole.sum() < max(complete.sum() / 2, PER_PARAMETER):
            whole = complete
        centre, covariance, inside = _robust(z[whole])
        distance = _joint(z, wide, centre, covariance, inside)
        heavy = _heavy(distance[whole])
    found_odd = np.asarray(np.nan_to_num(distance, nan=0.0) > limit)
    return Outliers(used, logarithm[used], distance, limit, found_odd, z, heavy)


def _joint(z: Array, wide: NDArray[np.bool_], centre: Array, covariance: Array, inside: int) -> Array:
    """Return the distance of each unit: of what is usual in it together, and of all else one by one."""
    distance = np.full(len(z), np.nan)
    plain = np.isfinite(z) & ~wide
    has, which = np.unique(plain, axis=0, return_inverse=True)
    for k, columns in enumerate(has):
        units = np.flatnonzero(which.reshape(-1) == k)
        if columns.any():
            part = covariance[np.ix_(columns, columns)]
            distance[units] = _deviates(z[np.ix_(units, columns)] - centre[columns], part, inside)
    if not wide.any():
        return distance
    distance = _times(distance, 2)  # half of what may be named for nothing is left to the parameters one by one
    for j in np.flatnonzero(wide.any(axis=0)):
        units, own = np.flatnonzero(wide[:, j]), covariance[j : j + 1, j : j + 1]
        apart = _times(_deviates(z[units, j : j + 1] - centre[j], own, inside), 2 * z.shape[1])
        distance[units] = np.fmax(distance[units], apart)
    return distance


def _times(deviate: Array, tests: int) -> Array:
    """Return the deviates that are as rare as the farthest of so many."""
    rare = tests * special.ndtr(-deviate)
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(rare > 1e-280, -special.ndtri(np.minimum(rare, 0.5)), deviate))


def _of_rows(uncertain: Uncertain, rows: NDArray[np.bool_], j: int) -> Uncertain:
    u, dof, common, usual = (one[rows, j] for one in (uncertain.u, uncertain.dof, uncertain.common, uncertain.usual))
    return Uncertain(u, dof, common, uncertain.station[rows], usual)


def _standardized(
    x: Array, first: NDArray[np.bool_], uncertain: Uncertain | None
) -> tuple[Array, NDArray[np.bool_]] | None:
    """Return one parameter as normal deviates, and which are to be judged apart; None where it tells nothing."""
    shown, u2, dof, apart = x, np.zeros(x.size), np.full(x.size, np.inf), np.zeros(x.size, dtype=bool)
    if uncertain is not None:
        shift, left = _of_stations(x, first, uncertain)
        own, dof = _moderated(uncertain, first)
        shown, u2, apart = x - shift, own + left, ~uncertain.usual
        dof = _effective(own, dof, u2)
    off = shown - np.median(shown[first])
    most = (MAD * float(np.median(np.abs(off[first])))) ** 2
    if not most > 0.0:
        return None
    away = np.abs(off[first])

    def too_far(variance: float) -> float:
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.median(np.nan_to_num(away / np.sqrt(variance + u2[first]), posinf=1e300))) - NORMAL

    least, population = too_far(0.0), 0.0
    if least > 0.0:
        population = float(optimize.brentq(too_far, 0.0, 1.01 * most))
    else:  # tests scatter less than they state
        off = off * (NORMAL / (least + NORMAL))
    whole = population + u2
    z = _as_normal(off / np.sqrt(whole), _effective(u2, dof, whole))
    if first.sum() >= TAILS and np.quantile(np.abs(z[first]), BULK) > HEAVY * -special.ndtri((1.0 - BULK) / 2.0):
        return None
    return z, apart & (u2 > LEAST * whole) | (whole > APART**2 * np.median(whole[first]))


def _of_stations(x: Array, first: NDArray[np.bool_], uncertain: Uncertain) -> tuple[Array, Array]:
    """Return what units of a station share, as far as they show it, and the variance of what they do not show."""
    shift, left = np.zeros(x.size), np.nan_to_num(uncertain.common) ** 2
    middle, order = float(np.median(x[first])), np.argsort(uncertain.station, kind="stable")
    order = order[first[order]]
    steps = np.diff(x[order])[np.diff(uncertain.station[order]) == 0]  # between units of one station
    if not steps.size or not left.any():
        return shift, left
    inside = (MAD * float(np.median(np.abs(steps)))) ** 2 / 2.0
    for station in np.unique(uncertain.station):
        own = uncertain.station == station
        rest = own & first
        if rest.any():
            known = float(np.median(left[rest]))
            total = known + np.pi / 2.0 * inside / rest.sum()  # variance of a median
            weight = known / total if total > 0.0 else 0.0
            shift[own] = weight * (float(np.median(x[rest])) - middle)
            left[own] *= 1.0 - weight
    return shift, left


def _moderated(uncertain: Uncertain, first: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return squared uncertainties and their degrees of freedom, with what those of the other units tell.

    They are ``s^2 F(dof, d)``: the fewer degrees of freedom d, the more they differ from unit to unit. One that is too
    large for that is the unit's own.
    """
    u2, dof = np.nan_to_num(uncertain.u) ** 2, np.clip(np.nan_to_num(uncertain.dof, nan=SURE), 1.0, SURE)
    rest = first & uncertain.usual & (u2 > 0.0)
    if rest.sum() < PER_PARAMETER:
        return u2, dof

    def usual_for(prior: float) -> float:
        return float(np.median(u2[rest] / _middle_of_f(dof[rest], prior)))

    def is_enough(prior: float) -> bool:
        below = special.fdtr(dof[rest], prior, u2[rest] / usual_for(prior))
        return bool(np.median(np.abs(special.ndtri(np.clip(below, 1e-15, 1.0 - 1e-15)))) <= NORMAL)

    # The fewer they are, the wider is F: of the most that are enough
    prior = PRIORS[min(bisect_left(PRIORS, True, key=is_enough), len(PRIORS) - 1)]
    usual = usual_for(prior)
    moderated, more = (prior * usual + dof * u2) / (prior + dof), np.minimum(prior + dof, SURE)
    own = ~uncertain.usual | (special.fdtrc(dof, prior, u2 / usual) < OWN)
    return np.where(own, u2, moderated), np.where(own, dof, more)


def _middle_of_f(dof: Array, prior: float) -> Array:
    """Return the median of F(dof, prior): of many, a spline through some, which is off by less than 1e-9."""
    few, which = np.unique(dof, return_inverse=True)
    if few.size <= NODES:
        return np.asarray(special.fdtri(few, prior, 0.5)[which])
    from scipy import interpolate  # noqa: PLC0415 - starts slowly

    nodes = np.linspace(math.log(few[0]), math.log(few[-1]), NODES)
    spline = interpolate.CubicSpline(nodes, np.log(special.fdtri(np.exp(nodes), prior, 0.5)))
    return np.asarray(np.exp(spline(np.log(dof))))


def _effective(part: Array, dof: Array, whole: Array) -> Array:
    """Return the degrees of freedom of a variance of which a part has so many, and the rest no end (Satterthwaite)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(part > 0.0, dof * (whole / part) ** 2, np.inf))


def _as_normal(t: Array, dof: Array) -> Array:
    """Return values of Student's t as the normal deviates that are as rare."""
    z = t.copy()
    few = dof < SURE
    rare = special.stdtr(dof[few], -np.abs(t[few]))
    with np.errstate(divide="ignore"):
        deviate = np.where(rare > 1e-280, -special.ndtri(rare), np.maximum(np.abs(t[few]), 35.0))
    z[few] = np.copysign(deviate, t[few])
    return z


def _skewed(x: Array) -> bool:
    """Tell whether logarithms are nearer to symmetric."""
    if not (x > 0.0).all():
        return False
    low, middle, high = np.quantile(x, [0.1, 0.5, 0.9])
    plain, logs = (high - middle, middle - low), (math.log(high / middle), math.log(middle / low))
    return all(end > 0.0 for end in (*plain, *logs)) and abs(math.log(plain[0] / plain[1])) > abs(
        math.log(logs[0] / logs[1])
    )


def _robust(z: Array) -> tuple[Array, Array, int]:
    """Return centre, covariance and the number of units that they are of."""
    p = z.shape[1]
    if p == 1:
        plain, basis = z, np.eye(1)
    else:
        matrix = np.eye(p)
        for j in range(p):
            for k in range(j):
                plus, less = _scale(z[:, j] + z[:, k]), _scale(z[:, j] - z[:, k])
                total = plus**2 + less**2
                matrix[j, k] = matrix[k, j] = (plus**2 - less**2) / total if total else 0.0
        basis = np.linalg.eigh(matrix)[1]
        plain = z @ basis
    scales = np.array([_scale(one) for one in plain.T])
    scales = np.where(scales > 0.0, scales, np.inf)
    middles = np.median(plain, axis=0)
    squares = np.sum(((plain - middles) / scales) ** 2, axis=1)
    dims = int(np.isfinite(scales).sum())
    cut = special.chdtri(dims, 1.0 - INSIDE) * float(np.median(squares)) / special.chdtri(dims, 0.5)
    centre, covariance, n = _of(z, squares <= cut, dims)
    for _ in range(ROUNDS):  # the covariance of all but outliers: of normal units it loses next to none
        inside = _deviates(z - centre, covariance, n) <= -special.ndtri(P / len(z) / 2.0)
        if inside.sum() <= max(n, dims + 1):
            break
        centre, covariance, n = _of(z, inside, 0)
    return centre, covariance, n


def _of(z: Array, inside: NDArray[np.bool_], dims: int) -> tuple[Array, Array, int]:
    """Return centre and covariance of units, made wider where units of so many dimensions were cut at ``INSIDE``."""
    own = z[inside]
    shrink = special.chdtr(dims + 2, special.chdtri(dims, 1.0 - INSIDE)) / INSIDE if dims else 1.0
    return own.mean(axis=0), np.atleast_2d(np.cov(own, rowvar=False)) / shrink, int(inside.sum())


def _scale(x: Array) -> float:
    return MAD * float(np.median(np.abs(x - np.median(x))))


def _deviates(rest: Array, covariance: Array, n: int) -> Array:
    """Return distances as the normal deviates that are as rare."""
    width = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(width, width))
    keep = values > LEAST
    p = int(keep.sum())
    squares = np.sum(((rest / width) @ vectors[:, keep]) ** 2 / values[keep], axis=1)
    if n <= p + 1:
        return np.full(len(rest), np.nan)
    ratio = squares * (n * (n - p)) / (p * (n**2 - 1.0))
    rare = special.fdtrc(p, n - p, ratio)
    # where a probability is too small for a number, the distance itself is the deviate, as it is for one parameter
    far = np.sqrt(np.maximum(squares - (p - 1), 0.0))
    with np.errstate(divide="ignore"):
        deviate = -special.ndtri(rare / 2.0)
    return np.asarray(np.where(rare > 1e-280, deviate, np.maximum(far, 35.0)))


def _heavy(distance: Array) -> bool:
    """Tell whether the rest lies farther out than normal units: the bulk of it, which outliers do not move."""
    known = distance[np.isfinite(distance)]
    return known.size >= 500 and float(np.quantile(known, BULK)) > HEAVY * -special.ndtri((1.0 - BULK) / 2.0)
