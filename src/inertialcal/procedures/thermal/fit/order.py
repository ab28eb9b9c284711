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
LEAST, SAFE = 1e-10, 1e6  # eigenvalue over the largest that counts; ratio up to which all do, by far
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
    held_out, found = cells.once(("held out", largest), lambda: _errors(cells, largest))
    errors = found[cells.sensor]
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


def _errors(cells: Cells, largest: int) -> tuple[HeldOut, Array]:
    """Return what is held out, and the mean square errors of prediction of it, (k, largest + 1, g), of all sensors.

    Each group is predicted by the fit to the others, from the weighted moments of all groups.
    """
    held_out, groups, offsets, path_order = _groups(cells)
    number = np.unique(groups, return_inverse=True)[1]
    order = np.argsort(number, kind="stable")
    starts, own = np.flatnonzero(np.diff(number[order], prepend=-1)), np.unique(offsets, return_inverse=True)[1]
    columns = np.hstack([design(cells, largest, path_order, cells.range), cells.beside.T])
    if own.any():  # less the weighted mean of each offset
        total = np.bincount(own, cells.weight)
        sums = [np.bincount(own, column * cells.weight) for column in columns.T]
        columns = columns - (np.column_stack(sums) / total[:, None])[own]
    columns, weights = columns[order], cells.weight[order]
    weighted, p = columns * weights[:, None], columns.shape[1] - len(cells.beside)
    moments = np.add.reduceat(columns[:, :p, None] * weighted[:, None, :], starts)
    squares = np.add.reduceat(columns[:, p:] * weighted[:, p:], starts)
    numbers = np.arange(len(starts))
    tried = numbers[1:-1] if held_out == "blocks" and len(numbers) > 3 else numbers
    left, rest = moments[tried], moments.sum(axis=0) - moments[tried]
    found = _solved(rest[:, :, :p], rest[:, :, p:], largest)
    bent = np.sum(found * (left[:, None, :, :p] @ found - 2.0 * left[:, None, :, p:]), axis=2)  # (groups, orders, k)
    errors = np.maximum(squares[tried, None] + bent, 0.0).transpose(2, 1, 0)
    return held_out, errors / np.add.reduceat(weights, starts)[tried]


def _solved(square: Array, along: Array, largest: int) -> Array:
    """Return the coefficients of each order of P with D, (g, largest + 1, p, k), of moments (g, p, p) and (g, p, k).

    Columns of higher orders have the coefficient 0; a direction that the cells hardly tell does not count.
    """
    p = square.shape[1]
    at = np.arange(p)
    taken = (at > largest) | (at <= np.arange(largest + 1)[:, None])  # a row an order
    scale = np.sqrt(np.maximum(np.diagonal(square, axis1=1, axis2=2), np.finfo(float).tiny))[:, :, None]
    square, along = square / (scale * scale.swapaxes(1, 2)), along / scale
    nested = np.roll(at, p - largest - 1)  # all of D first: those of an order are then the first ones
    try:
        root = np.linalg.inv(np.linalg.cholesky(square[:, nested[:, None], nested]))
    except np.linalg.LinAlgError:
        root = np.full_like(square, np.inf)
    if np.all(p * np.sum(root**2, axis=(1, 2)) < SAFE):  # bounds the ratio of the eigenvalues, of lower orders too
        part = (root @ along[:, nested])[:, None] * taken[:, nested, None]
        found = (root.swapaxes(1, 2)[:, None] @ part)[:, :, np.argsort(nested)]
    else:
        found = np.zeros((len(square), largest + 1, p, along.shape[2]))
        for order, own in enumerate(map(np.flatnonzero, taken)):
            found[:, order, own] = symmetric_inverse(square[:, own[:, None], own], LEAST) @ along[:, own]
    return np.asarray(found / scale[:, None])
