"""Order of the polynomial: the lowest that predicts what is held out about as well as the best does.

Each run is held out in turn, P and D are fitted to the others, and the run is predicted but for its offset, which no
polynomial knows. With fewer than three runs each ramp is held out (the paths differ then by no more than an offset),
and with fewer than five ramps each of eight stretches of temperature inside the range, on all ramps at once. The root
mean square of the errors is the score of an order.

The order is the lowest whose score is within 2 % of the least: an order more that predicts no better is not taken, and
one that predicts better is. R2 of the fit itself always grows with the order and says nothing. (The rule of one
standard error [1]_ leaves the choice to the scatter of five numbers: chance, in one case of five.)

References
----------
.. [1] Hastie, Tibshirani and Friedman, The Elements of Statistical Learning, 2nd ed., 2009, 7.10.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ....core.estimate import Array
from ....statistics.least_squares import symmetric_inverse
from .cells import Cells, Indices
from .law import design, path_order_of

STRETCHES = 10  # of the range of temperature, the inner ones of which are held out
RAMPS, RUNS = 5, 3  # that are enough to be held out
NO_BETTER = 1.02  # of the least score
HeldOut = Literal["runs", "ramps", "blocks", "given"]


@dataclass(frozen=True, eq=False)
class Choice:
    """An order, and what it was chosen by."""

    order: int  # Of P
    held_out: HeldOut  # What each score was found on; given: the plan says the order
    # shape (largest + 1,): root mean square error of prediction of each order [unit of the readings]; NaN where
    # it was not fitted
    scores: Array


def choose_order(cells: Cells, largest: int, given: int | None = None) -> Choice:
    """Return the order of P, chosen on what is held out where none is given; the scores are found either way."""
    held_out, groups, offsets, path_order = _groups(cells)
    whole = design(cells, largest, path_order, cells.range)
    columns = np.column_stack([whole, cells.reading])
    squares, counts = _moments(columns, cells.weight, groups, offsets)
    numbers = np.arange(len(np.unique(groups)))
    tried = numbers[1:-1] if held_out == "blocks" and len(numbers) > 3 else numbers
    errors = np.full((largest + 1, len(tried)), np.nan)
    for order in range(largest + 1):
        keep = [*range(order + 1), *range(largest + 1, columns.shape[1] - 1)]
        # Mean square error of prediction of each group that is held out, fitted to the others
        rest = squares.sum(axis=0) - squares[tried]
        scale = np.sqrt(np.maximum(np.einsum("gii->gi", rest)[:, keep], np.finfo(float).tiny))
        at = np.asarray(keep)
        grid = np.ix_(np.arange(len(tried)), at, at)
        inverse = symmetric_inverse(rest[grid] / (scale[:, :, None] * scale[:, None, :]), 1e-10)
        found = np.einsum("gij,gj->gi", inverse, rest[:, keep, -1] / scale) / scale
        own = squares[tried]
        cross = np.einsum("gi,gi->g", found, own[:, keep, -1])
        bent = np.einsum("gi,gij,gj->g", found, own[grid], found)
        errors[order] = np.asarray(np.maximum(own[:, -1, -1] - 2.0 * cross + bent, 0.0) / counts[tried])
    scores = np.sqrt(np.mean(errors, axis=1))
    if given is not None:
        return Choice(given, "given", scores)
    return Choice(_lowest(errors), held_out, scores)


def _lowest(errors: Array) -> int:
    """Return the lowest order that predicts about as well as the best."""
    scores = np.sqrt(errors.mean(axis=1))
    return int(np.flatnonzero(scores <= NO_BETTER * scores.min())[0])


def _groups(cells: Cells) -> tuple[HeldOut, Indices, Indices, int]:
    """Return what is held out, the group of each cell, whose offset is its own, and the order of D in the fits."""
    path_order = path_order_of(cells)
    if cells.runs >= RUNS:
        return "runs", cells.run, cells.run, path_order
    if len(np.unique(cells.ramp)) >= RAMPS:
        return "ramps", cells.ramp, cells.ramp, -1
    lo, hi = cells.range
    stretch = np.minimum(((cells.temperature - lo) / (hi - lo) * STRETCHES).astype(np.int64), STRETCHES - 1)
    return "blocks", stretch, np.zeros(len(cells), dtype=np.int64), path_order


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
