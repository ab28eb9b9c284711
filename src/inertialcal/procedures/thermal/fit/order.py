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
    held_out, groups, offsets, path_order = cells.once("held out", lambda: _groups(cells))
    without = cells.once(("moments", largest), lambda: _Moments(cells, largest, path_order, groups, offsets, held_out))
    tried, counts = without.tried, without.counts
    along, squares = without.of(cells.reading)
    errors = np.full((largest + 1, len(tried)), np.nan)
    for order in range(largest + 1):
        keep = without.columns(order)
        # Mean square error of prediction of each group that is held out, fitted to the others
        inverse, scale, own = without.solved(order)
        rest = along.sum(axis=0) - along[tried]
        found = np.einsum("gij,gj->gi", inverse, rest[:, keep] / scale) / scale
        cross = np.einsum("gi,gi->g", found, along[tried][:, keep])
        bent = np.einsum("gi,gij,gj->g", found, own, found)
        errors[order] = np.asarray(np.maximum(squares[tried] - 2.0 * cross + bent, 0.0) / counts[tried])
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
        return "runs", cells.run, cells.run, path_order if cells.paths_repeated else -1
    if len(np.unique(cells.ramp)) >= RAMPS:
        return "ramps", cells.ramp, cells.ramp, -1
    lo, hi = cells.range
    stretch = np.minimum(((cells.temperature - lo) / (hi - lo) * STRETCHES).astype(np.int64), STRETCHES - 1)
    return "blocks", stretch, np.zeros(len(cells), dtype=np.int64), path_order


class _Moments:
    """Weighted second moments of the design in each group, offsets taken away, and what else no reading changes."""

    def __init__(
        self, cells: Cells, largest: int, path_order: int, groups: Indices, offsets: Indices, held_out: HeldOut
    ) -> None:
        number = np.unique(groups, return_inverse=True)[1]
        self._order = np.argsort(number, kind="stable")
        self._starts = np.flatnonzero(np.diff(number[self._order], prepend=-1))
        self._own, self._weights, self._largest = np.unique(offsets, return_inverse=True)[1], cells.weight, largest
        self._design = self._sorted(design(cells, largest, path_order, cells.range))
        self._weighted = self._design * cells.weight[self._order][:, None]
        self._squares = np.add.reduceat(self._design[:, :, None] * self._weighted[:, None, :], self._starts)
        self._rest: dict[int, tuple[Array, Array, Array]] = {}
        self.counts = np.add.reduceat(cells.weight[self._order], self._starts)  # weight of each group, shape (g,)
        numbers = np.arange(len(self._starts))
        self.tried = numbers[1:-1] if held_out == "blocks" and len(numbers) > 3 else numbers  # groups held out

    def _sorted(self, columns: Array) -> Array:
        """Return columns (c, q) without the weighted mean of each offset, group after group."""
        if self._own.any():
            total = np.bincount(self._own, self._weights)
            sums = [np.bincount(self._own, column * self._weights) for column in columns.T]
            columns = columns - (np.column_stack(sums) / total[:, None])[self._own]
        return columns[self._order]

    def of(self, reading: Array) -> tuple[Array, Array]:
        """Return the moments of the design with a reading, (g, q), and those of the reading, (g,)."""
        y = self._sorted(reading[:, None])
        weighted = y[:, 0] * self._weights[self._order]
        return np.add.reduceat(self._weighted * y, self._starts), np.add.reduceat(y[:, 0] * weighted, self._starts)

    def columns(self, order: int) -> Indices:
        """Return the columns of an order: of P up to it, and all of D."""
        return np.asarray([*range(order + 1), *range(self._largest + 1, self._design.shape[1])])

    def solved(self, order: int) -> tuple[Array, Array, Array]:
        """Return of each group that is held out: inverse of the scaled moments of the others, scales, own moments."""
        if order not in self._rest:
            at = self.columns(order)
            rest = self._squares.sum(axis=0) - self._squares[self.tried]
            scale = np.sqrt(np.maximum(np.einsum("gii->gi", rest)[:, at], np.finfo(float).tiny))
            grid = np.ix_(np.arange(len(self.tried)), at, at)
            inverse = symmetric_inverse(rest[grid] / (scale[:, :, None] * scale[:, None, :]), 1e-10)
            self._rest[order] = inverse, scale, self._squares[self.tried][grid]
        return self._rest[order]
