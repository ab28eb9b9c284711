"""Units that are of another kind than the rest: robust Mahalanobis distances on all parameters together.

Each parameter is centred and scaled robustly; their joint covariance is that of the orthogonalized Gnanadesikan-
Kettenring estimate [1]_, reweighted: mean and covariance of the units that are no outliers. A unit that was not among
these is as far off as a new observation would be, whose squared distance follows ``p (n^2 - 1) / (n (n - p)) F(p, n -
p)`` [2]_. A unit is an outlier beyond the quantile by which a lot of normal units has any in 5 %.

A unit may lack parameters: it is judged on those that it has. Parameters that are positive and skewed are taken as
logarithms; one of heavy tails is left out. What breaks this: heavy tails of several together, of which more than the
stated 5 % of lots have such units (``heavy``); two populations of about the same size, of which neither is an outlier;
fewer than ``PER_PARAMETER`` units a parameter, where the later parameters are left out. Of a unit that was tested
several times one test makes centre and covariance: all of them would make a cluster.

References
----------
.. [1] R. A. Maronna and R. H. Zamar, Technometrics 44 (2002) 307-317.
.. [2] J. Hardin and D. M. Rocke, J. Comput. Graph. Stat. 14 (2005) 928-946, section 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

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
        Each parameter of each unit, robustly standardized; NaN where it has none.
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


def outliers(values: Array, first: NDArray[np.bool_] | None = None) -> Outliers:
    """Return how far units lie from the rest.

    Parameters
    ----------
    values : ndarray, shape (n, p)
        Parameters of units, the most important first; NaN where a unit has none.
    first : ndarray of bool, shape (n,), optional
        Which rows are the one of their unit that the rest is known from; all if not given. Every row is judged.
    """
    first = np.ones(len(values), dtype=bool) if first is None else first
    n = int(first.sum())
    known = np.isfinite(values)
    scaled, logarithm = np.full(values.shape, np.nan), np.zeros(values.shape[1], dtype=bool)
    good: list[int] = []
    for j in range(values.shape[1]):
        own = values[known[:, j] & first, j]
        if own.size < max(KNOWN * n, 2 * PER_PARAMETER) or len(good) >= n // PER_PARAMETER:
            continue
        logarithm[j] = _skewed(own)
        x = np.log(own) if logarithm[j] else own
        middle = float(np.median(x))
        scale = MAD * float(np.median(np.abs(x - middle)))
        if not scale > 0.0:
            continue
        if (
            own.size >= TAILS
            and np.quantile(np.abs(x - middle), BULK) > HEAVY * -special.ndtri((1.0 - BULK) / 2.0) * scale
        ):
            continue
        every = values[known[:, j], j]
        if logarithm[j]:
            with np.errstate(invalid="ignore", divide="ignore"):
                every = np.log(every)
        scaled[known[:, j], j] = (every - middle) / scale
        good.append(j)
    used = np.array(good, dtype=np.intp)
    z = scaled[:, used]
    distance, heavy = np.full(len(values), np.nan), False
    limit = float(-special.ndtri(P / max(len(values), 1) / 2.0))
    if used.size:
        whole = np.isfinite(z).all(axis=1) & first
        centre, covariance, inside = _robust(z[whole])
        has, which = np.unique(np.isfinite(z), axis=0, return_inverse=True)
        for k, columns in enumerate(has):
            units = np.flatnonzero(which.reshape(-1) == k)
            if columns.any():
                part = covariance[np.ix_(columns, columns)]
                distance[units] = _deviates(z[np.ix_(units, columns)] - centre[columns], part, inside)
        heavy = _heavy(distance[whole])
    found = np.asarray(np.nan_to_num(distance, nan=0.0) > limit)
    return Outliers(used, logarithm[used], distance, limit, found, z, heavy)


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
