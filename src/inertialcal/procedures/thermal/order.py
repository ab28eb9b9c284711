"""Order of the polynomial: the lowest that predicts what is held out as well as the best does.

Each run is held out in turn, P and D are fitted to the others, and the run is predicted but for its offset, which no
polynomial knows. With one run its ramps are held out (the paths differ then by no more than an offset), and with fewer
than three ramps stretches of temperature inside the range. The mean square of the errors is the score of an order.

The one-standard-error rule [1]_, made for few runs: the lowest order that is not shown to predict worse than the best,
by a paired t test of the squared errors of what was held out, one-sided at 90 % (1.53 standard errors with five runs).
Paired, because both orders meet the same noise. R2 of the fit itself always grows with the order and says nothing.

References
----------
.. [1] Hastie, Tibshirani and Friedman, The Elements of Statistical Learning, 2nd ed., 2009, 7.10.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core.estimate import Array
from ...statistics.intervals import t_quantile
from .cells import Cells, Indices
from .law import BLOCKS, design, path_order_of

SHOWN = 0.9  # one-sided probability of the test
HeldOut = Literal["runs", "ramps", "blocks", "given"]


@dataclass(frozen=True, eq=False)
class Choice:
    """An order, and what it was chosen by.

    Parameters
    ----------
    order : int
        Of P.
    held_out : {"runs", "ramps", "blocks", "given"}
        What each score was found on; given: the plan says the order.
    scores : ndarray, shape (largest + 1,)
        Root mean square error of prediction of each order [unit of the readings]; NaN where it was not fitted.
    """

    order: int
    held_out: HeldOut
    scores: Array


def choose_order(cells: Cells, largest: int, given: int | None = None) -> Choice:
    """Return the order of P, chosen on what is held out where none is given; the scores are found either way."""
    held_out, groups, offsets, path_order = _groups(cells)
    whole = design(cells, largest, path_order, cells.range)
    columns = np.column_stack([whole, cells.reading])
    squares, counts = _moments(columns, cells.weight, groups, offsets)
    tried = _tried(held_out, groups, cells)
    errors = np.full((largest + 1, len(tried)), np.nan)
    for order in range(largest + 1):
        keep = [*range(order + 1), *range(largest + 1, columns.shape[1] - 1)]
        errors[order] = _errors(squares, counts, keep, tried)
    scores = np.sqrt(np.mean(errors, axis=1))
    if given is not None:
        return Choice(given, "given", scores)
    return Choice(_lowest(errors), held_out, scores)


def _lowest(errors: Array) -> int:
    """Return the lowest order that is not shown to predict worse than the best."""
    means = np.where(np.isfinite(errors).all(axis=1), errors.mean(axis=1), np.inf)
    best = int(np.argmin(means))
    limit = t_quantile(errors.shape[1] - 1.0, SHOWN)
    for order in range(best):
        apart = errors[order] - errors[best]
        if np.isfinite(apart).all() and apart.mean() <= limit * apart.std(ddof=1) / np.sqrt(len(apart)):
            return order
    return best


def _groups(cells: Cells) -> tuple[HeldOut, Indices, Indices, int]:
    """Return what is held out, the group of each cell, whose offset is its own, and the order of D in the fits."""
    path_order = path_order_of(cells)
    if cells.runs >= 3:
        return "runs", cells.run, cells.run, path_order
    if len(np.unique(cells.ramp)) >= 3:
        return "ramps", cells.ramp, cells.ramp, -1
    lo, hi = cells.range
    stretch = np.minimum(((cells.temperature - lo) / (hi - lo) * BLOCKS).astype(np.int64), BLOCKS - 1)
    return "blocks", stretch, np.zeros(len(cells), dtype=np.int64), path_order


def _tried(held_out: HeldOut, groups: Indices, cells: Cells) -> Indices:
    """Return the numbers of the groups that are held out: of stretches of temperature the inner ones alone."""
    numbers = np.arange(len(np.unique(groups)))
    return numbers[1:-1] if held_out == "blocks" and len(numbers) > 3 else numbers


def _moments(columns: Array, weights: Array, groups: Indices, offsets: Indices) -> tuple[Array, Array]:
    """Weighted second moments of design and readings in each group, offsets taken away, (g, q, q), and its weight."""
    own = np.unique(offsets, return_inverse=True)[1]
    if own.any():
        total = np.bincount(own, weights)
        means = np.column_stack([np.bincount(own, column * weights) for column in columns.T]) / total[:, None]
        columns = columns - means[own]
    number = np.unique(groups, return_inverse=True)[1]
    order = np.argsort(number, kind="stable")
    starts = np.flatnonzero(np.diff(number[order], prepend=-1))
    sorted_columns, sorted_weights = columns[order], weights[order]
    products = sorted_columns[:, :, None] * sorted_columns[:, None, :] * sorted_weights[:, None, None]
    return np.add.reduceat(products, starts), np.add.reduceat(sorted_weights, starts)


def _errors(squares: Array, counts: Array, keep: list[int], tried: Indices) -> Array:
    """Mean square error of prediction of each group that is held out, fitted to the others."""
    rest = squares.sum(axis=0) - squares[tried]
    scale = np.sqrt(np.maximum(np.einsum("gii->gi", rest)[:, keep], np.finfo(float).tiny))
    grid = np.ix_(np.arange(len(tried)), keep, keep)
    inverse = np.linalg.pinv(rest[grid] / (scale[:, :, None] * scale[:, None, :]), rcond=1e-10, hermitian=True)
    found = np.einsum("gij,gj->gi", inverse, rest[:, keep, -1] / scale) / scale
    own = squares[tried]
    cross = np.einsum("gi,gi->g", found, own[:, keep, -1])
    bent = np.einsum("gi,gij,gj->g", found, own[grid], found)
    return np.asarray(np.maximum(own[:, -1, -1] - 2.0 * cross + bent, 0.0) / counts[tried])
