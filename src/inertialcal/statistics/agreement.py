"""Which of several values disagree with the others, where some of them may be grossly wrong.

Values ``y_i`` of one quantity, from recordings made alike, scatter about a common mean with an unknown standard
deviation, and each with its own known one as well. A set S of m values is tried as m shifts of their own [1]_: the mean
and the variance come from the n - m values that are kept, which the shifted ones cannot inflate::

    F = d' (D + J / (n - m))^-1 d / (m s^2)      d: values of S less the mean of the kept

with D the identity where all are known equally well and J all ones. F has m and n - m - 1 degrees of freedom, for a
set named in advance; the one found is the worst of binomial(n, m), so its probability is multiplied by that number
(Bonferroni). Sets of m = 1, 2, ... get a half, a quarter, ... of the chance of a false alarm. That holds exactly for
normal values, however few.

The kept are a majority. Where half disagrees with half, or one of two with the other, nothing tells which are wrong:
all are named.

References
----------
.. [1] Barnett and Lewis, Outliers in Statistical Data, 3rd ed., Wiley 1994, sections 6.2 and 6.3.
.. [2] A. F. Siegel, Biometrika 69 (1982) 242-244: robust regression using repeated medians.
.. [3] Rousseeuw and Croux, J. Am. Stat. Assoc. 88 (1993) 1273-1283: the median absolute deviation, its efficiency 0.37.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from ..core.estimate import Array

FALSE_ALARM = 0.003  # chance that anything of a sound test is said to disagree
NORMAL = 1.482602218505602  # standard deviation of normal values over their median absolute deviation
EFFICIENCY = 0.37  # of the median absolute deviation, as an estimate of a standard deviation
FEW, MANY = 64, 32  # points of lines, and lines, that loops find side by side
MOST = 400  # points of a repeated median; of more, every k-th


def disagreeing(
    values: ArrayLike,
    u: ArrayLike = 0.0,
    alpha: float = FALSE_ALARM,
    scatter: float = 0.0,
    dof: float = 0.0,
) -> NDArray[np.bool_]:
    """Return which of several values disagree with the majority.

    Parameters
    ----------
    values : array_like, shape (n,)
        One of each recording; NaN where it has none.
    u : array_like, shape (n,)
        Known standard uncertainty of each, which they do not share; 0 where it is not known.
    alpha : float
        Chance that any of n values that agree is named.
    scatter, dof : float
        Standard deviation between such values as others show it, with its degrees of freedom: without it, three values
        hardly tell, and two nothing.

    Returns
    -------
    ndarray of bool, shape (n,)
        All True where half of them disagree with the other half.

    Examples
    --------
    >>> disagreeing([1.001, 1.002, 0.9995, 1.0005, 1.2]).tolist()
    [False, False, False, False, True]
    """
    y = np.asarray(values, dtype=float)
    own = np.broadcast_to(np.asarray(u, dtype=float), y.shape)
    named = np.zeros(y.shape, dtype=bool)
    while True:
        at = np.flatnonzero(np.isfinite(y) & ~named)
        found = at[_worst(y[at], own[at], alpha, scatter, dof)]
        if named.any() and 2 * (named.sum() + len(found)) >= np.isfinite(y).sum():
            return named  # what is kept stays a majority
        named[found] = True
        if not len(found) or len(found) == len(at):
            return named


def any_disagrees(values: Array, u: Array, alpha: Array) -> NDArray[np.bool_]:
    """Return of which rows `disagreeing` names something, shape (r,): values and u, (r, n), all known, alpha (r,)."""
    found = np.zeros(len(values), dtype=bool)
    for m in range(1, values.shape[1] // 2 + 1):
        found |= _log_chance(values, u, m, 0.0, 0.0)[0] < np.log(alpha) - m * np.log(2.0)
    return found


def _worst(y: Array, u: Array, alpha: float, scatter: float, dof: float) -> NDArray[np.intp]:
    """Return the smallest set of values that disagrees, as indices; all of them where it is a half."""
    n = len(y)
    for m in range(1, n // 2 + 1):
        chance, apart = _log_chance(y[None], u[None], m, scatter, dof)
        if chance[0] < np.log(alpha) - m * np.log(2.0):
            return np.arange(n) if 2 * m == n else apart[0]
    return np.zeros(0, dtype=np.intp)


def _log_chance(y: Array, u: Array, m: int, scatter: float, dof: float) -> tuple[Array, NDArray[np.intp]]:
    """Return the logarithm of the chance that the worst m of each row, shapes (r, n), are so far off, and which."""
    n, order = y.shape[1], np.argsort(y, axis=1, kind="stable")
    freedom = n - m - 1 + dof
    if freedom <= 0.0:
        return np.zeros(len(y)), order[:, :m]
    # The n - m values that lie closest together stand side by side in order of size
    rows = np.arange(len(y))[:, None]
    ordered, known_u = y[rows, order], u[rows, order]
    windows, others, sets = _windows(n, m)
    each = ordered[:, windows]  # (r, m + 1, n - m)
    middles = each.sum(axis=2) / (n - m)
    scatters = ((each - middles[..., None]) ** 2).sum(axis=2)
    first = scatters.argmin(axis=1)
    at = rows[:, 0]
    outside = others[first]
    middle, square = middles[at, first], (scatters[at, first] + dof * scatter**2) / freedom
    known = (known_u[rows, windows[first]] ** 2).sum(axis=1) / (n - m)
    variance = np.maximum(square, known)
    away, varies = ordered[rows, outside] - middle[:, None], variance > 0.0
    size = np.where(varies, variance, 1.0)
    beyond = np.maximum(known_u[rows, outside] ** 2 - known[:, None], 0.0)
    weight = 1.0 / (1.0 + beyond / size[:, None])
    shift = (weight * away**2).sum(axis=1) - (weight * away).sum(axis=1) ** 2 / (n - m + weight.sum(axis=1))
    chance = special.fdtrc(m, freedom, shift / (m * size))
    if not varies.all():
        chance = np.where(varies, chance, np.where((away != 0.0).any(axis=1), 0.0, 1.0))
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(chance) + sets), order[rows, outside]


@lru_cache(maxsize=64)
def _windows(n: int, m: int) -> tuple[NDArray[np.intp], NDArray[np.intp], float]:
    """Return places of n - m of n neighbours, (m + 1, n - m), of the others, (m + 1, m); log of the number of sets."""
    first = np.arange(m + 1)[:, None]
    others = np.arange(m) + np.where(np.arange(m) < first, 0, n - m)
    sets = special.gammaln(n + 1.0) - special.gammaln(m + 1.0) - special.gammaln(n - m + 1.0)
    return np.arange(n - m) + first, others, float(sets)


def repeated_median_line(x: ArrayLike, y: ArrayLike) -> tuple[float, float]:
    """Return slope and intercept that nearly half of the points may be wrong without harm to [2]_.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        Points; those with a NaN are left out.

    Returns
    -------
    (slope, intercept) : NaN where there are not two different x.
    """
    used = np.isfinite(x) & np.isfinite(y)
    every = int(np.ceil(np.count_nonzero(used) / MOST)) or 1
    slope, level = repeated_median_lines(*(np.asarray(values, dtype=float)[used][::every] for values in (x, y)))
    return float(slope), float(level)


def repeated_median_lines(x: Array, y: Array) -> tuple[Array, Array]:
    """Return slopes and intercepts of `repeated_median_line` for several sets of points, all of them used.

    Parameters
    ----------
    x, y : ndarray, shapes (..., n)
        Points, those with a NaN left out.
    """
    known, n = np.isfinite(x) & np.isfinite(y), x.shape[-1]
    if 1 < n <= FEW and known.size >= n * MANY and known.all():
        from ._kernels_levels import fill_lines  # noqa: PLC0415 - numba starts slowly

        shape = known.shape[:-1]
        places, values = (np.ascontiguousarray(np.broadcast_to(one, known.shape).reshape(-1, n).T) for one in (x, y))
        slope, level = np.empty((2, places.shape[1]))
        fill_lines(places, values, slope, level)
        return slope.reshape(shape), level.reshape(shape)
    run, rise = (values[..., :, None] - values[..., None, :] for values in (x, y))
    shape = np.broadcast_shapes(run.shape, rise.shape)
    slopes = np.divide(rise, run, out=np.full(shape, np.nan), where=run != 0.0)
    middle = medians(slopes)
    slope = medians(np.where(known, middle, np.nan))
    return slope, medians(y - slope[..., None] * x)


def medians(values: Array) -> Array:
    """Return the median of what is known of each row, shape (...); NaN where nothing is.

    Of few values many times as fast as ``np.nanmedian``.
    """
    if not values.shape[-1]:
        return np.full(values.shape[:-1], np.nan)
    ordered, n = np.sort(values, axis=-1), values.shape[-1]  # NaN last
    if not np.isnan(ordered[..., -1]).any():
        middle: Array = 0.5 * (ordered[..., (n - 1) // 2] + ordered[..., n // 2])
        return middle
    count = np.count_nonzero(~np.isnan(ordered), axis=-1)[..., None]
    halves = [np.take_along_axis(ordered, np.maximum(at, 0), axis=-1)[..., 0] for at in ((count - 1) // 2, count // 2)]
    found: Array = 0.5 * (halves[0] + halves[1])
    return np.where(count[..., 0] > 0, found, np.nan)


def robust_scale(residuals: ArrayLike, fitted: int) -> tuple[float, float]:
    """Return the standard deviation behind residuals by their median size, and its degrees of freedom [3]_.

    As many of the smallest as were fitted do not count: a line of medians runs through some of its points.

    Parameters
    ----------
    residuals : array_like, shape (n,)
        About medians and lines; NaN do not count.
    fitted : int
        How many levels and slopes were fitted to them.

    Returns
    -------
    (scale, dof) : 0 and 0 where nothing scatters, or more was fitted than there are readings.
    """
    known = np.asarray(residuals, dtype=float)
    scale, dof = robust_scales(known[np.isfinite(known)], fitted)
    return float(scale), float(dof)


def robust_scales(residuals: Array, fitted: int) -> tuple[Array, Array]:
    """Return the same of several sets of residuals, all known, shape (..., n): shapes (...)."""
    size = np.sort(np.abs(residuals), axis=-1)[..., fitted:]
    if not size.shape[-1]:
        return np.zeros(size.shape[:-1]), np.zeros(size.shape[:-1])
    scatters = size[..., -1] > 0.0
    return np.where(scatters, NORMAL * medians(size), 0.0), np.where(scatters, EFFICIENCY * size.shape[-1], 0.0)
