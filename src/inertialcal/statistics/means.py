"""Means and their standard uncertainties, at every level that was repeated.

Readings come in levels: samples in a dwell, dwells in a power-up run, runs. What varies from run to run is
not made smaller by more samples, so the uncertainty of a mean comes from the scatter of the means of the
highest level that was repeated, with that level's degrees of freedom. A level that was not repeated is
named, and its part of the uncertainty is not in ``u``. Components of variance are never found as
differences of mean squares: those can be negative, and cut at zero they are too large on average.

A mean square here is that of the *means* of the groups of a level (of the readings themselves at the
innermost one), each group counted once. For readings per sample, dwell and run with variances
``s²``, ``d²`` and ``r²``, n samples a dwell and m dwells a run, its expectation is::

    sample: s²        dwell: d² + s²/n        run: r² + d²/m + s²/(n m)

and for a balanced layout the mean square of the textbooks (Searle [1]_, ch. 3) is n, or n m, times as
large. Each group counted once keeps ``mean_square / groups`` unbiased for the variance of the mean of
means also where the groups have unequal sizes; its degrees of freedom are then a little fewer than stated.

References
----------
.. [1] Searle, Casella and McCulloch, Variance Components, Wiley, 1992.
.. [2] JCGM 100:2008, 4.2 (mean), G.4 (Welch-Satterthwaite), H.5 (two-level analysis of variance).
.. [3] Birge, Phys. Rev. 40 (1932) 207-227.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.errors import DataError
from ..core.estimate import Array, Component, Estimate


@dataclass(frozen=True)
class Mean:
    """A mean, its standard uncertainty (same unit) and the degrees of freedom of that."""

    value: float
    u: float
    dof: float


@dataclass(frozen=True)
class Level:
    """What one level of repetition shows.

    Parameters
    ----------
    name : str
        ``"run"``, ``"dwell"``, ``"sample"``.
    groups : int
        How many there are in all.
    dof : int
        Groups less those of the level above.
    mean_square : float or None
        Of the means of the groups about the mean of the group above them [unit²]; None where no group
        above has two of them: not estimated.
    """

    name: str
    groups: int
    dof: int
    mean_square: float | None


@dataclass(frozen=True)
class NestedMean:
    """Mean of means of nested readings.

    Parameters
    ----------
    mean : Mean
        Each group counted once at its level.
    level : str
        The highest repeated level, whose mean square gives the uncertainty.
    not_repeated : tuple of str
        Levels above it: their scatter is in no figure here.
    levels : tuple of Level
        All, outermost first.
    """

    mean: Mean
    level: str
    not_repeated: tuple[str, ...]
    levels: tuple[Level, ...]


def mean(readings: ArrayLike, name: str = "readings") -> Mean:
    """Return the mean of independent readings, its standard uncertainty s/sqrt(n) and dof n - 1.

    Readings that are all equal give ``u == 0``: they are stuck, or vary by less than the converter's step.

    Parameters
    ----------
    readings : array_like, shape (n,)
        In any unit.
    name : str
        What they are, for messages.

    Raises
    ------
    DataError
        If there are fewer than two, or one is not finite.

    Examples
    --------
    >>> mean([1.0, 2.0, 3.0])
    Mean(value=2.0, u=0.577..., dof=2.0)
    """
    x = _finite(readings, name)
    _need_two(x, name)
    return Mean(float(x.mean()), float(x.std(ddof=1) / np.sqrt(x.size)), float(x.size - 1))


def weighted_mean(values: ArrayLike, u: ArrayLike, dof: ArrayLike = np.inf) -> Mean:
    """Return the mean of independent values weighted by 1/u², with u and dof from theirs.

    The uncertainties are believed; whether the scatter agrees with them, `birge_ratio` says. Those known
    to few degrees of freedom make the result look better than it is: below about 10 prefer `mean`.

    Parameters
    ----------
    values, u : array_like, shape (n,)
        In one unit.
    dof : array_like, shape (n,), or float
        Degrees of freedom of each u (Welch-Satterthwaite).

    Raises
    ------
    DataError
        If a value is not finite, or an uncertainty is not a positive number.
    """
    x, weights = _weights(values, u)
    share = weights / weights.sum()
    spent = float(np.sum(share**2 / np.broadcast_to(np.asarray(dof, dtype=float), x.shape)))
    return Mean(float(share @ x), float(weights.sum() ** -0.5), 1.0 / spent if spent > 0.0 else np.inf)


def birge_ratio(values: ArrayLike, u: ArrayLike) -> float:
    """Return the scatter of values about their weighted mean over the scatter their u promise [3]_.

    1 is expected; much more says that an uncertainty was left out.

    Raises
    ------
    DataError
        If there are fewer than two values, one is not finite, or an uncertainty is not positive.
    """
    x, weights = _weights(values, u)
    _need_two(x, "values")
    residuals = x - weights @ x / weights.sum()
    return float(np.sqrt(weights @ residuals**2 / (x.size - 1)))


def block_means(readings: ArrayLike, size: int) -> Array:
    """Return means over blocks of successive readings.

    The last ``n % size`` readings fill no block and are not used: the caller counts them.

    Parameters
    ----------
    readings : array_like, shape (n,) or (n, channels)
        Time-first.
    size : int
        Readings a block.

    Returns
    -------
    ndarray, shape (n // size,) or (n // size, channels)
        In the unit of the readings.

    Raises
    ------
    DataError
        If the size is below 1 or a reading is not finite.
    """
    x = _finite(readings, "readings")
    if size < 1:
        raise DataError(f"blocks of {size} readings", do="Need 1 or more: a longer block or a higher rate")
    blocks = x.shape[0] // size
    shaped: Array = x[: blocks * size].reshape(blocks, size, *x.shape[1:]).mean(axis=1)
    return shaped


def pooled_std(stds: ArrayLike, dofs: ArrayLike) -> tuple[float, float]:
    """Return the common standard deviation of several samples, and its degrees of freedom.

    Parameters
    ----------
    stds, dofs : array_like, shape (k,)
        Standard deviation of each sample (one unit) and its degrees of freedom (n - 1).

    Raises
    ------
    DataError
        If one is negative or not finite, or there are no degrees of freedom at all.
    """
    s, dof = np.broadcast_arrays(_finite(stds, "standard deviations"), _finite(dofs, "degrees of freedom"))
    if np.any(s < 0.0) or np.any(dof < 0.0) or dof.sum() <= 0.0:
        raise DataError(
            f"standard deviations from {s.min(initial=0.0):g} up with {dof.sum():g} degrees of freedom",
            do="Need none below zero, and one sample of two or more",
        )
    return float(np.sqrt(dof @ s**2 / dof.sum())), float(dof.sum())


def combine_means(
    blocks: Mapping[str, Array],
    matrix: Array,
    names: Sequence[str],
    unit: str = "",
    source: str = "scatter of block means",
) -> Estimate:
    """Return linear combinations of the means of independent dwells.

    Every dwell is a component of the estimate, with its own degrees of freedom: the scatter may differ
    from dwell to dwell (Welch-Satterthwaite).

    Parameters
    ----------
    blocks : mapping of str to ndarray, shape (n_i,)
        Independent readings (block means) of each dwell, in one unit.
    matrix : ndarray, shape (m, dwells)
        Row = value wanted, column = dwell, in the order of ``blocks``.
    names : sequence of str
        One a row.
    unit : str
        Of readings and values.
    source : str
        Name of the uncertainty in the budget; the dwell's name is added.

    Raises
    ------
    DataError
        If a dwell has fewer than two readings, one that is not finite, or readings that do not vary; or
        if the matrix does not fit.
    """
    matrix = np.asarray(matrix, dtype=float)
    if matrix.shape != (len(names), len(blocks)):
        raise DataError(f"matrix of shape {matrix.shape} for {len(names)} values of {len(blocks)} dwells")
    means = {name: mean(x, name) for name, x in blocks.items()}
    for name, found in means.items():
        if found.u == 0.0:
            raise DataError(
                f"{name}: all {int(found.dof) + 1} values are {found.value:g}",
                why="their scatter is the only measure of the uncertainty",
                do="Look for a stuck channel; or use longer blocks, if it varies less than its step",
                code="no_scatter",
            )
    components = tuple(
        Component(f"{source}, {name}", "A", np.outer(column, column) * found.u**2, found.dof)
        for (name, found), column in zip(means.items(), matrix.T, strict=True)
    )
    values = matrix @ np.array([found.value for found in means.values()])
    return Estimate(tuple(names), values, (unit,) * len(names), components)


def nested_mean(readings: ArrayLike, levels: Mapping[str, ArrayLike], innermost: str = "sample") -> NestedMean:
    """Return the mean of means of nested readings with the mean square of every level.

    Parameters
    ----------
    readings : array_like, shape (n,)
        Single readings, or the means of dwells where only these are known.
    levels : mapping of str to sequence, shape (n,)
        Label of each reading at each level, outermost first: ``{"run": ..., "dwell": ...}``. A label may
        be used again in another group above: dwell 1 of run A is not dwell 1 of run B.
    innermost : str
        What a single reading is called.

    Raises
    ------
    DataError
        If there are fewer than two readings, one is not finite, or labels do not fit.

    Examples
    --------
    >>> found = nested_mean([1.0, 1.2, 2.0, 2.2], {"run": ["a", "a", "b", "b"]})
    >>> found.level, found.mean.dof, [level.dof for level in found.levels]
    ('run', 1.0, [1, 2])
    """
    means = _finite(readings, "readings")
    _need_two(means, "readings")
    names = [*levels, innermost]
    numbers = [np.zeros(means.size, dtype=np.intp), *_group_numbers(levels, means.size), np.arange(means.size)]
    found: list[Level] = []
    for name, above, own in reversed(list(zip(names, numbers[:-1], numbers[1:], strict=True))):
        first = np.unique(own, return_index=True)[1]
        level, means = _level(name, means, above[first])
        found.insert(0, level)
    repeated = [(level, level.mean_square) for level in found if level.mean_square is not None]
    top, square = repeated[0]
    whole = Mean(float(means[0]), float(np.sqrt(square / top.groups)), float(top.dof))
    return NestedMean(whole, top.name, tuple(names[: found.index(top)]), tuple(found))


def _level(name: str, means: Array, above: NDArray[np.intp]) -> tuple[Level, Array]:
    """Mean square of a level, and the means of the groups above it."""
    sizes = np.bincount(above)
    parents = np.bincount(above, weights=means) / sizes
    dof = means.size - sizes.size
    square = float(np.sum((means - parents[above]) ** 2))
    return Level(name, means.size, dof, square / dof if dof else None), parents


def _group_numbers(levels: Mapping[str, ArrayLike], n: int) -> list[NDArray[np.intp]]:
    """Group number of each reading at each level; a label used in two groups above makes two."""
    numbers = []
    above = np.zeros(n, dtype=np.intp)
    for name, labels in levels.items():
        if np.shape(labels) != (n,):
            raise DataError(f"level {name!r}: labels of shape {np.shape(labels)} for {n} readings")
        own = np.unique(np.asarray(labels), return_inverse=True)[1]
        above = np.unique(above * (own.max() + 1) + own, return_inverse=True)[1]
        numbers.append(above)
    return numbers


def _weights(values: ArrayLike, u: ArrayLike) -> tuple[Array, Array]:
    x, sigma = np.broadcast_arrays(_finite(values, "values"), _finite(u, "standard uncertainties"))
    if x.size == 0 or np.any(sigma <= 0.0):
        raise DataError(
            f"{x.size} values, smallest standard uncertainty {sigma.min(initial=np.inf):g}",
            do="Need one or more, each with an uncertainty above zero",
        )
    return x, sigma**-2.0


def _finite(readings: ArrayLike, name: str) -> Array:
    x = np.atleast_1d(np.asarray(readings, dtype=float))
    bad = np.flatnonzero(~np.isfinite(x).all(axis=tuple(range(1, x.ndim))))
    if bad.size:
        raise DataError(
            f"{name}: {bad.size} not finite, the first is number {bad[0] + 1}",
            do="Leave out what is missing, and count it",
            code="not_finite",
        )
    return x


def _need_two(x: Array, name: str) -> None:
    if x.ndim != 1 or x.size < 2:
        raise DataError(f"{name}: {x.size} value(s), need 2 or more for an uncertainty", code="too_few")
