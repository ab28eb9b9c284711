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

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ....core.estimate import Array
from ....statistics.least_squares import symmetric_inverse
from ._kernels_cells import LOST, fill_errors
from .cells import Cells, Indices
from .law import designs, gathered, path_order_of

BLOCKS = 3  # stretches up to which all of them are held out
STRETCHES = 10  # of the range of temperature, the inner ones of which are held out
RAMPS, RUNS = 5, 3  # that are enough to be held out
LEAST, SAFE = 1e-10, 1e6  # eigenvalue over the largest that counts; ratio up to which all do, by far
NO_BETTER = 1.02  # of the least score
HeldOut = Literal["runs", "ramps", "blocks", "given"]


class Choice(NamedTuple):
    """An order, and what it was chosen by."""

    order: int  # Of P
    held_out: HeldOut  # What each score was found on; given: the plan says the order
    # shape (largest + 1,): root mean square error of prediction of each order [unit of the readings]; NaN where
    # it was not fitted
    scores: Array


def choose_order(cells: Cells, largest: int, given: int | None = None) -> Choice:
    """Return the order of P, chosen on what is held out where none is given; the scores are found either way."""
    held_out, scores, lowest = cells.once(("held out", largest), lambda: _scores([cells], largest)[0])
    if given is not None:
        return Choice(given, "given", scores[cells.sensor])
    return Choice(lowest[cells.sensor], held_out, scores[cells.sensor])


def find_scores(cells: Sequence[Cells], largest: int) -> None:
    """Find the scores of several thermometers that `choose_order` wants, those of one shape at once."""
    own = [cells[at[0]] for at in gathered(id(one.once) for one in cells)]
    _find_groups(own)
    shapes = [(one.beside.shape, *_groups(one).shape) for one in own]
    for at in gathered(shapes):
        alike = [own[i] for i in at]
        try:
            found = _scores(alike, largest)
        except np.linalg.LinAlgError:  # of one of them: alone it is the trouble of its unit
            continue
        for one, scores in zip(alike, found, strict=True):
            one.once.keep(("held out", largest), scores)


@dataclass(frozen=True, eq=False)
class Groups:
    """What is held out of cells."""

    held_out: HeldOut
    number: Indices  # shape (c,): group of each cell
    count: int  # of groups
    offset: Indices  # shape (c,): number of what has an offset of its own
    offsets: int  # how many have one
    path_order: int  # Of D in the fits

    @property
    def shape(self) -> tuple[HeldOut, int, int, int]:
        """What groups of several thermometers must share to be held out at once."""
        return self.held_out, self.count, self.offsets, self.path_order


def _groups(cells: Cells) -> Groups:
    """Return what is held out."""
    if "groups" not in cells.once:
        _find_groups([cells])
    found: Groups = cells.once["groups"]
    return found


def _find_groups(cells: Sequence[Cells]) -> None:
    """Find what is held out of the cells of several thermometers."""
    short = []
    for one in cells:
        if one.runs >= RUNS:
            order = path_order_of(one) if one.paths_repeated else -1
            one.once.keep("groups", _numbered("runs", one.run, order))
        elif one.ramps >= RAMPS:
            one.once.keep("groups", _numbered("ramps", one.ramp, -1))
        else:
            short.append(one)
    if not short:
        return
    unit = np.repeat(np.arange(len(short)), [len(one) for one in short])
    lo, hi = np.array([one.range for one in short]).T
    at = (np.concatenate([one.temperature for one in short]) - lo[unit]) / (hi - lo)[unit]
    stretch = np.minimum((at * STRETCHES).astype(np.int64), STRETCHES - 1)
    held = np.zeros((len(short), STRETCHES), dtype=np.int64)
    held[unit, stretch] = 1
    rank = np.cumsum(held, axis=1) - 1
    number, none = rank[unit, stretch], np.zeros(len(unit), dtype=np.int64)
    start = 0
    for one, last in zip(short, rank[:, -1].tolist(), strict=True):
        own = slice(start, start := start + len(one))
        one.once.keep("groups", Groups("blocks", number[own], last + 1, none[own], 1, path_order_of(one)))


def _numbered(held_out: HeldOut, labels: Indices, path_order: int) -> Groups:
    number = np.unique(labels, return_inverse=True)[1]
    count = int(number.max()) + 1
    return Groups(held_out, number, count, number, count, path_order)


def _scores(cells: Sequence[Cells], largest: int) -> list[tuple[HeldOut, Array, list[int]]]:
    """Return what is held out, the scores of all sensors by it, (k, largest + 1), and the order that each goes for.

    That is the lowest order that predicts about as well as the best. Each group is predicted by the fit to the others,
    from the weighted moments of all groups. The cells of several thermometers, of one shape, are taken end to end.
    """
    groups = [_groups(one) for one in cells]
    each, first = groups[0].count, groups[0]
    number, weight = np.array([one.number for one in groups]), np.array([one.weight for one in cells])
    P, D = np.split(designs(cells, largest, first.path_order), [largest + 1], axis=2)
    columns = np.concatenate([D, P, np.array([one.beside for one in cells]).swapaxes(1, 2)], axis=2)
    if first.offsets > 1:  # less the weighted mean of each offset
        of = np.array([one.offset for one in groups])[..., None] == np.arange(first.offsets)
        own = (weight[..., None] * of).swapaxes(1, 2)
        columns = columns - of @ ((own @ columns) / own.sum(axis=2, keepdims=True))
    held = np.arange(1, each - 1) if first.held_out == "blocks" and each > BLOCKS else np.arange(each)
    k, width = len(cells[0].beside), columns.shape[2]
    moments, told = np.zeros((len(cells), each, width, width)), np.empty((len(cells), len(held)))
    errors = np.empty((*told.shape, largest + 1, k))
    fill_errors(columns, weight, number, held, moments, errors, told)
    for u, h in zip(*np.nonzero(~((width - k) * told < SAFE)), strict=True):  # bounds the ratio of the eigenvalues
        own = moments[u, held[h]]
        errors[u, h] = _missed(moments[u].sum(axis=0) - own, own, largest + 1, k)
    share = np.sum(weight[:, None] * (number[:, None] == held[:, None]), axis=2)
    errors = np.maximum(errors, 0.0).transpose(0, 3, 2, 1)
    scores = np.sqrt((errors / share[:, None, None]).mean(axis=3))
    lowest = np.argmax(scores <= NO_BETTER * scores.min(axis=2, keepdims=True), axis=2).tolist()
    return [(first.held_out, *one) for one in zip(scores, lowest, strict=True)]


def _missed(rest: Array, held: Array, orders: int, k: int) -> Array:
    """Return the sums of squares that fits miss what is held out by, of one order after the other, shape (orders, k).

    ``rest``, ``held``: products of columns and of k readings, shape (p + k, p + k). A direction that the cells hardly
    tell does not count; nor does a column of which they show nothing.
    """
    p = len(rest) - k
    left, whole = np.diagonal(rest)[:p], np.diagonal(rest + held)[:p]
    scale = np.where(left > LOST * whole, np.sqrt(np.maximum(left, 0.0)), np.inf)
    errors = np.empty((orders, k))
    for order in range(orders):
        own = slice(p - orders + order + 1)
        inverse = symmetric_inverse((rest[:p, :p] / np.outer(scale, scale))[own, own], LEAST)
        found = inverse @ (rest[own, p:] / scale[own, None]) / scale[own, None]
        bent = np.sum(found * (held[own, own] @ found - 2.0 * held[own, p:]), axis=0)
        errors[order] = np.diagonal(held)[p:] + bent
    return errors
