"""Isolated samples far from their neighbours: glitches, bursts of a few samples, and longer disturbances.

A sample is far where it differs from the median of the 31 around it by more than 7 times the largest of several scales
of such differences. These are quantiles, each over that of normal noise, so that a glitch does not widen them and a
heavy tail does; beyond the highest quantile the tail is continued as an exponential one, to where noise of this record
has one sample in 1,000 records. Coarse codes are allowed a few steps. Medians are taken only where the range of
the samples around allows such a difference at all.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import log, log10
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import release
from ...core.estimate import Array
from ..time.samples import Flags, Indices
from .blocks import SUBSAMPLE, Blocks, together
from .loops import loops_for

FEWEST = 64  # samples that a scale needs
FAR = 7.0  # scales
NORMAL = ((0.6827, 1.0), (0.9545, 2.0), (0.99, 2.5758))  # quantiles of |x|, and those of normal noise
TOP = 0.999  # highest quantile ...
ABOVE = 10.0  # ... with so many samples above it at least
HEAVY = 1.2  # of the tail of an exponential, at most: what is heavier is no noise
BODY, EXPONENTIAL = 0.95, log(20.0)  # quantile that a tail is measured by
RARE = 3.0  # decades: one record in 1,000
STEPS = 3.5  # of the codes
SKIRT = 0.5  # of the limit, that samples beside a glitch must exceed to be part of it
BURST = 10  # samples
APART = 5  # samples between the parts of one disturbance
JUMP = 0.25  # of the height of a glitch, from one sample to the next, up and down
ALONE = 3.0  # times the largest step of the samples around, where a sensor moves, and ...
TURNS = 1.5  # ... squared changes of its steps over the squared steps: 2 or more of a burst; 1 of a swing of 6 samples
SIDE, WINDOW = 15, 31  # of a running median
TOGETHER = 2**10  # places looked at together
ROOM = 2**14  # far samples at first


@dataclass(frozen=True)
class Scale:
    """How far samples lie from the median around."""

    sigma: float  # standard deviation of normal noise with the same middle two thirds; half a step at least
    step: float  # smallest difference of neighbours that is not zero; 0 of a constant record
    limit: float  # beyond which a sample is no noise


@dataclass(frozen=True, eq=False)
class Stretches:
    """Samples [first, last] of each place, shape (k, 2), and the largest deviation there."""

    places: Indices
    peak: Array


def scale_of(x: NDArray[Any], first: Indices, rows: Array, whole: bool = False) -> Scale:
    """Return the scale of a record with 64 samples or more, from its pieces, spread evenly over it.

    ``whole``: all samples are finite.
    """
    step = loops_for(len(x)).smallest_step(rows)
    many = rows.size if whole else int(np.count_nonzero(np.isfinite(rows)))
    return scale_from(len(x), many, step, _ranked(x, first, rows, many)) if many >= FEWEST else Scale(0.0, step, np.inf)


@lru_cache(32)
def ranks_of(many: int) -> tuple[Indices, list[int]]:
    """Return the ranks of so many distances that a scale is taken from, each once, not to be changed; and their order.

    Of the quantiles of the body, of a tail, and of both ends of what it is continued from.
    """
    at = [min(max(int(p * many), 0), many - 1) for p in (*(p for p, _ in NORMAL), BODY, *_tail(many))]
    ranks = sorted(set(at))
    return np.array(ranks), [ranks.index(rank) for rank in at]


def _tail(many: int) -> tuple[float, float]:
    """Return the two highest quantiles."""
    top = min(TOP, 1.0 - ABOVE / many)
    return 1.0 - 10.0 * (1.0 - top), top


def scale_from(n: int, many: int, step: float, ranked: Array) -> Scale:
    """Return the scale of a record of n samples.

    Parameters
    ----------
    n, many : int
        Samples of the record, and distances that are ranked.
    step : float
        Smallest difference of neighbours.
    ranked : ndarray, shape (r,)
        Distances at the ranks of `ranks_of`.
    """
    known = ranked.tolist()
    *body, middle, lower, upper = [known[k] for k in ranks_of(many)[1]]
    top = _tail(many)[1]
    scales = [quantile / normal for quantile, (_, normal) in zip(body, NORMAL, strict=True)]
    if body[0] > 2.0 * step:  # not of codes
        middle = min(middle, HEAVY * body[0] * (EXPONENTIAL / -log(1.0 - NORMAL[0][0])))
        scales[1] = min(scales[1], middle / 2.0)
    if middle > 0.0:
        scales[-1] = min(scales[-1], HEAVY * middle * log(100.0) / EXPONENTIAL / NORMAL[-1][1])
        upper = min(upper, HEAVY * middle * -log(1.0 - top) / EXPONENTIAL)
        lower = min(lower, upper)
    decades = log10(n * (1.0 - top)) + RARE
    limit = max(FAR * max(scales), upper + decades * (upper - lower), STEPS * step)
    return Scale(max(scales[0], 0.5 * step), step, limit)


def _ranked(x: NDArray[Any], first: Indices, rows: Array, many: int) -> Array:
    """Return the distances from the median around at their ranks, of the samples of the pieces."""
    ranks = ranks_of(many)[0]
    found = np.empty(len(ranks))
    beside = len(x) <= SUBSAMPLE  # pieces lie side by side
    if not (beside and loops_for(len(x)).fill_ranked(x, rows.size, ranks, found)):
        off = np.empty_like(rows)
        for own in together(x, len(first)):
            loops_for(len(x)).fill_pieces(x, first[own], off[own])
            release(x)
        size = np.abs(off[np.isfinite(off)])
        size.partition(ranks)
        found = size[ranks]
    return found


def far_samples(blocks: Blocks, scale: Scale, at_rest: bool) -> tuple[Stretches, Stretches]:
    """Return glitches (up to 10 samples), and longer disturbances of a sensor at rest."""
    none = Stretches(np.empty((0, 2), dtype=np.int64), np.empty(0))
    if not 0.0 < scale.limit < np.inf:
        return none, none
    hi, lo = _widest(blocks.hi, -np.inf), -_widest(-blocks.lo, -np.inf)
    which = np.flatnonzero(hi - lo > scale.limit)
    room = ROOM
    while True:
        at, off = np.empty(room, dtype=np.int64), np.empty(room)
        found = loops_for(len(blocks.x)).fill_far(
            blocks.x, blocks.size, which, scale.limit, SKIRT * scale.limit, at, off
        )
        release(blocks.x)
        if found <= room:
            break
        room = found
    at, size = at[:found], np.abs(off[:found])
    if not found:
        return none, none
    first = np.flatnonzero(np.diff(at, prepend=at[0] - APART - 1) > APART)
    last = np.append(first[1:], found) - 1
    places = np.column_stack((at[first], at[last]))
    peak = np.maximum.reduceat(size, first)
    if not at_rest:  # a turn is far from its median for long: of it, what stands out
        strong = size > 0.5 * np.repeat(peak, last - first + 1)
        begin, end = np.where(strong, at, len(blocks.x)), np.where(strong, at, -1)
        inner = np.column_stack((np.minimum.reduceat(begin, first), np.maximum.reduceat(end, first)))
        at_ends = (places[:, :1] < SIDE) | (places[:, 1:] >= len(blocks.x) - SIDE)  # medians there see one side
        places = np.where(at_ends, places, inner)
    kept, short = peak > scale.limit, places[:, 1] - places[:, 0] < BURST
    for part in np.array_split(np.flatnonzero(kept), len(kept) // TOGETHER + 1):
        kept[part] = np.where(short[part], _jumps(blocks.x, places[part], peak[part], at_rest), at_rest)
    for i in np.flatnonzero(kept & ((places[:, 0] < SIDE) | (places[:, 1] >= len(blocks.x) - SIDE))).tolist():
        kept[i] = _off_line(blocks.x, places[i], scale.limit)
    return tuple(Stretches(places[kept & one], peak[kept & one]) for one in (short, ~short))  # type: ignore[return-value]


def _jumps(x: NDArray[Any], places: Indices, peak: Array, at_rest: bool) -> Flags:
    """Whether samples jump up and down at a place, as a corner of a smooth motion does not.

    Of a sensor that moves, they must do so more than those around, and not swing as after a push.
    """
    reach = 2 * WINDOW
    at = places[:, :1] + np.arange(-reach, BURST + reach)
    values = x[np.clip(at, 0, len(x) - 1)].astype(np.float64)
    values[~np.isfinite(values)] = np.nan
    step = np.nan_to_num(np.diff(values, axis=1))
    inside = (at[:, :-1] >= places[:, :1] - 1) & (at[:, :-1] <= places[:, 1:])
    own, others = np.where(inside, step, 0.0), np.abs(np.where(inside, 0.0, step)).max(axis=1)
    up, down = own.max(axis=1), -own.min(axis=1)
    ends = (places[:, 0] == 0) | (places[:, 1] == len(x) - 1)
    least = np.maximum(JUMP * peak, 0.0 if at_rest else ALONE * others)
    jumps = np.where(ends, np.maximum(up, down), np.minimum(up, down)) > least
    if not at_rest:
        jumps &= np.sum(np.diff(own, axis=1) ** 2, axis=1) > TURNS * np.sum(own**2, axis=1)
    return np.asarray(jumps)


def _off_line(x: NDArray[Any], place: Indices, limit: float) -> bool:
    """Whether a place near an end is far from the line through its neighbours too: medians there do not see a slope."""
    first, last = int(place[0]), int(place[1])
    at = np.r_[max(first - WINDOW, 0) : first, last + 1 : min(last + 1 + WINDOW, len(x))]
    at = at[np.isfinite(x[at])]
    if len(at) < BURST:
        return True
    line = np.polynomial.Polynomial.fit(at, x[at].astype(np.float64), 1)
    own = np.arange(first, last + 1)
    return bool(np.nanmax(np.abs(x[own] - line(own))) > limit)


def _widest(x: Array, fill: float) -> Array:
    """Return the largest of each value and its two neighbours; missing ones count as ``fill``."""
    padded = np.full(len(x) + 2, fill)
    padded[1:-1] = np.where(np.isnan(x), fill, x)
    return np.asarray(np.maximum(padded[1:-1], np.maximum(padded[:-2], padded[2:])))
