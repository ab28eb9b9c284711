"""Placements of a sensor set down by hand: how long each must be, what is between them, whether one was disturbed.

The mean of a placement gains by its length until drift rules: the Allan deviation of the longest still stretch falls
while the noise is white and levels out after. A placement is long enough from where the deviation is within ``NEAR`` of
its lowest, and never shorter than ``LEAST``: a shorter rest is a hand that pauses.

A turn begins and ends more slowly than the noise of accelerometers lets it be seen: some tenths of a second into it a
smooth turn has gone by less than they can tell. What is used of a placement therefore begins later than it seems to
rest and ends before it seems to move, and what is between two placements reaches as far into both, so that the turn
lies wholly in it: until the means of the gyros over ``BLOCK`` are those of the middle, one block more, and at most
``EDGE``; as long as that where there are no gyros.

A placement that was touched shows as several still stretches at one level: the longest is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...core import batches
from ...core.batches.summaries import Moments
from ...core.errors import DataError
from ...core.estimate import Array
from ..time.samples import Indices, all_finite
from .segments import Segmentation, placement_groups

LEAST, MOST = 1.0, 10.0  # [s]
NEAR = 3.0  # times the lowest Allan deviation
FEWEST_BLOCKS = 9
DRIFTS = 10.0  # standard uncertainties between the halves of a placement, of its neighbours' size
LOUD = 2.0  # times the usual scatter
FEW = 20  # samples of a placement whose halves can be told
EDGE = 0.5  # most that is left out at each end of a placement, never more than a quarter of it [s]
BLOCK = 0.1  # [s]
MOVES = 3.0  # standard uncertainties by which the mean of a block differs from the middle where the unit turns
TOUCH = 2.0  # longest disturbance that a unit is touched by and not taken up [s]
BRIEF, SMALL = 0.75, 2.0  # touched for less [s], and its level moved by less [noise of a sample]: it lies as it lay
TURNED = 0.1  # part of the usual turn between placements, from which two stretches at one level are two placements
SAME_LEVEL = 5.0  # standard deviations of the noise, between still stretches of one placement
SIGMAS, FEWEST_TOUCHED = 5.0, 5  # samples so far from the level show that a placement was touched

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Placement:
    """Samples [start, stop) of a placement that are used, well inside it.

    ``touched`` counts the samples of the same placement that are left out because it was touched; ``inside`` says that
    it lay for long before and after, and was touched for long or lies differently since.
    """

    start: int
    stop: int
    touched: int = 0
    inside: bool = False


def shortest_placement(segmentation: Segmentation) -> float:
    """Return the length from which a placement is long enough [s].

    Raises
    ------
    DataError
        If no sample interval is known (``no_time``), or nothing is still (``no_rest``).
    """
    interval = segmentation.samples.sample_interval
    if not interval:
        raise DataError("no sample interval is known", do="Give the sample rate", code="no_time")
    still = np.flatnonzero(segmentation.still)
    if not len(still):
        raise DataError("the unit is never at rest", do="Leave it at rest in each position", code="no_rest")
    length = segmentation.stop[still] - segmentation.start[still]
    longest = still[int(np.argmax(length))]
    samples = segmentation.samples
    rows = slice(int(segmentation.start[longest]), int(segmentation.stop[longest]))
    finite, outlier = samples.finite[rows], samples.outlier[rows]
    good = batches.made(len(finite), bool, lambda a, b: finite[a:b] & ~outlier[a:b], finite, outlier)
    x = batches.stacked([batches.kept(own, good) for own in samples.values[rows].T])
    sizes, deviation = _allan(x)
    if not len(sizes):
        return LEAST
    near = np.all(deviation <= NEAR * np.maximum(deviation.min(axis=0), np.finfo(float).tiny), axis=1)
    return float(np.clip(sizes[int(np.argmax(near))] * interval, LEAST, MOST))


def _allan(x: Array) -> tuple[NDArray[np.int64], Array]:
    """Allan deviation of block means at octaves of their size, shapes (q,) and (q, channels)."""
    sizes, found = [], []
    size, means = 1, x
    while len(means) >= FEWEST_BLOCKS:
        sizes.append(size)
        found.append(np.sqrt(0.5 * np.array([_mean_square_step(own) for own in means.T])))
        size, halves = 2 * size, []
        for own in means.T:
            even, odd = own[: len(own) // 2 * 2 : 2], own[1::2]
            halves.append(batches.made(len(odd), float, lambda a, b, x=even, y=odd: 0.5 * (x[a:b] + y[a:b]), even, odd))  # type: ignore[misc]
        means = np.stack(halves).T if not batches.is_stored(halves[0]) else batches.stacked(halves)
    return np.array(sizes, dtype=np.int64), np.array(found)


def _mean_square_step(x: Array) -> float:
    total = sum(float(np.sum(np.diff(x[a : b + 1]) ** 2)) for a, b in batches.batches(x[:-1]))
    return total / (len(x) - 1)


def placements(segmentation: Segmentation, min_duration: float, rates: Array | None = None) -> tuple[Placement, ...]:
    """Return one stretch for each placement that lasts, its edges left out, in order of time.

    Parameters
    ----------
    segmentation : Segmentation
        Of a signal that shows how the unit lies.
    min_duration : float
        Shortest still stretch [s].
    rates : ndarray, shape (n, channels), optional
        What gyros read on the same clock, in any unit: two stretches at one level with a turn in between, about the
        vertical, are two placements.

    Raises
    ------
    PlanError
        If no sample interval is known.
    """
    if not segmentation.still.any():
        return ()
    samples = segmentation.samples
    shortest = samples.duration(None, min_duration, segmentation.plan.shortest)
    interval = samples.sample_interval or min_duration / shortest
    groups = placement_groups(segmentation, max(0.5 * shortest, TOUCH / interval), SAME_LEVEL)
    if rates is not None:
        rates = filled(rates)
        level = [batches.mean(own) for own in rates.T]
        rates = batches.stacked([batches.changed(own, lambda part, m=m: part - m)  # type: ignore[misc]
                                 for own, m in zip(rates.T, level, strict=True)])  # fmt: skip
        groups = _parted_by_turns(segmentation, groups, rates)
    longest = round(EDGE / interval)
    found = []
    for group in groups:
        own = _long(segmentation, group, longest)
        at = own[int(np.argmax(segmentation.stop[own] - segmentation.start[own]))]
        first, last = int(segmentation.start[at]), int(segmentation.stop[at])
        if last - first < shortest:
            continue
        head, tail = _margins(rates, first, last, min(longest, (last - first) // 4), interval)
        touched, inside = _touched(segmentation, own, shortest, BRIEF / interval)
        found.append(Placement(first + head, last - tail, touched, inside))
    return tuple(found)


def filled(values: Array) -> Array:
    """Return channels (n, k) with what is missing taken from its neighbours; zero where a channel holds nothing."""
    if batches.every(all_finite(values), lambda part: part.all()):
        return values
    at, found = np.arange(len(values)), np.zeros_like(values)
    for k, own in enumerate(values.T):
        good = np.isfinite(own)
        if good.any():
            found[:, k] = np.interp(at, at[good], own[good])
    return found


def _margins(rates: Array | None, first: int, last: int, most: int, interval: float) -> tuple[int, int]:
    """Return samples at both ends of a still stretch in which it may have moved."""
    from . import _kernels_levels as kernels  # noqa: PLC0415 - importing numba takes longer than most records

    size = max(round(BLOCK / interval), 1)
    if rates is None or most < size:
        return most, most
    return kernels.margin(rates, first, last, most, size, MOVES)


def _parted_by_turns(segmentation: Segmentation, groups: Sequence[Indices], rates: Array) -> list[Indices]:
    """Return the groups, parted where gyros turned by more than a small part of what is usual between groups."""
    length, still = segmentation.stop - segmentation.start, segmentation.still
    sums = np.column_stack([_sums(own, segmentation) for own in rates.T])  # of each stretch
    rest = np.median(sums[still] / length[still, None], axis=0)
    total = np.vstack([np.zeros(rates.shape[1]), np.cumsum(sums - rest * length[:, None], axis=0)])

    def turned(a: int, b: int) -> float:
        return float(np.linalg.norm(total[b] - total[a + 1]))

    usual = [turned(int(one[-1]), int(other[0])) for one, other in pairwise(groups)]
    most = TURNED * float(np.median(usual)) if usual else np.inf
    found = []
    for group in groups:
        apart = [turned(int(a), int(b)) > most for a, b in pairwise(group)]
        found += np.split(group, np.flatnonzero(apart) + 1)
    return found


def _sums(x: Array, segmentation: Segmentation) -> Array:
    """Return the sum of each stretch, shape (k,)."""
    if not batches.is_stored(x):
        return np.add.reduceat(x, segmentation.start)
    ends = zip(segmentation.start.tolist(), segmentation.stop.tolist(), strict=True)
    return np.array([batches.mean(x[a:b]) * (b - a) for a, b in ends])


def _long(segmentation: Segmentation, group: Indices, edge: int) -> Indices:
    """Return the still stretches from the first to the last longer than an edge: shorter ones beyond are a turn's."""
    length = segmentation.stop[group] - segmentation.start[group]
    lasting = np.flatnonzero(length >= min(edge, int(length.max())))
    return group[lasting[0] : lasting[-1] + 1]


def _touched(segmentation: Segmentation, group: Indices, shortest: int, brief: float) -> tuple[int, bool]:
    """Return samples of a placement beside its longest stretch, where it was touched; whether it lies differently."""
    if len(group) < 2:
        return 0, False
    start, stop = segmentation.start[group], segmentation.stop[group]
    length, scale = stop - start, segmentation.noise.scale
    best = int(np.argmax(length))
    rows = slice(int(start[0]), int(stop[-1]))
    x, level = segmentation.samples.values[rows], segmentation.level[group[best]]
    far = 0  # what is missing is not
    for a, b in batches.batches(x):
        off = np.abs(x[a:b] - level) > SIGMAS * scale
        far += int(np.count_nonzero(off.any(axis=1) & segmentation.samples.finite[rows][a:b]))
    if far < FEWEST_TOUCHED:
        return 0, False
    lasting = np.flatnonzero(length >= shortest)
    apart = (start[1:] - stop[:-1] > brief)[lasting[0] : lasting[-1]]
    step = (np.abs(np.diff(segmentation.level[group[lasting]], axis=0)) > SMALL * scale).any(axis=1)
    return int(stop[-1] - start[0] - length[best]), bool(apart.any() or step.any())


def between(placements: Sequence[Placement]) -> tuple[tuple[int, int], ...]:
    """Return the samples [start, stop) from the last one at rest in a placement to the first one in the next."""
    return tuple((one.stop - 1, other.start + 1) for one, other in pairwise(placements))


def disturbed_inside(values: Array, placements: Sequence[Placement]) -> Flags:
    """Return which placements are not at one level: their halves differ, or they scatter more, than is usual.

    Usual is what the other placements of the same record do, so that a sensor that drifts in every placement, or noise
    that is far from white, raises none.

    Parameters
    ----------
    values : ndarray, shape (n, channels)
        Signal, on the clock of the placements.
    placements : sequence of Placement
        Of it.

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    if len(placements) < 3:
        return np.zeros(len(placements), dtype=bool)
    half, mean, std, few = (_halves_by_batches if batches.is_stored(values) else _halves)(values, placements)
    if few.all():
        return np.zeros(len(placements), dtype=bool)
    scatter = 0.5 * (std[::2] + std[1::2])
    u = np.maximum(scatter, np.finfo(float).tiny) * np.sqrt(2.0 / half)[:, None]
    step = np.where(scatter > 0.0, np.abs(mean[::2] - mean[1::2]) / u, 0.0)
    usual_step = np.maximum(np.median(step[~few], axis=0), 1.0)
    usual_scatter = np.median(scatter[~few], axis=0)
    step[few], scatter[few] = np.nan, np.nan
    with np.errstate(invalid="ignore"):
        return np.asarray(((step > DRIFTS * usual_step) | (scatter > LOUD * usual_scatter)).any(axis=1))


Halves = tuple[NDArray[np.int64], Array, Array, Flags]


def _halves_by_batches(values: Array, placements: Sequence[Placement]) -> Halves:
    """Return what `_halves` does, of a record that is stored."""
    good = all_finite(values)
    sizes = np.array([batches.count(good[one.start : one.stop], lambda part: part) for one in placements])
    half = np.maximum(sizes // 2, 1)
    mean, std = np.empty((2, 2 * len(placements), values.shape[1]))
    for k, one in enumerate(placements):
        own, flags = values[one.start : one.stop], good[one.start : one.stop]
        found, seen = [[Moments() for _ in own.T] for _ in range(2)], 0
        for a, b in batches.batches(own, flags):
            x = own[a:b][flags[a:b]]
            for which, part in enumerate(found):
                inside = x[max(which * half[k] - seen, 0) : max((which + 1) * half[k] - seen, 0)]
                found[which] = [one.with_more(inside[:, c]) for c, one in enumerate(part)]
            seen += len(x)
        for which, part in enumerate(found if sizes[k] > 1 else [found[0], found[0]]):
            mean[2 * k + which] = [one.mean for one in part]
            std[2 * k + which] = [np.sqrt(one.squares / max(one.count, 1)) for one in part]
    return half, mean, std, sizes < FEW


def _halves(values: Array, placements: Sequence[Placement]) -> Halves:
    """Return size, mean and standard deviation of both halves of each placement, and which have few samples."""
    rows = [np.arange(one.start, one.stop) for one in placements]
    rows = [own[np.isfinite(values[own]).all(axis=1)] for own in rows]
    few = np.array([len(own) < FEW for own in rows])
    half = np.array([max(len(own) // 2, 1) for own in rows])
    x = values[
        np.concatenate([own[: 2 * n] if len(own) > 1 else own[[0, 0]] for own, n in zip(rows, half, strict=True)])
    ]
    at = np.concatenate([[0], np.cumsum(np.repeat(half, 2))[:-1]])
    size = np.repeat(half, 2)
    mean = np.add.reduceat(x, at, axis=0) / size[:, None]
    x = x - np.repeat(mean, size, axis=0)
    return half, mean, np.sqrt(np.add.reduceat(x * x, at, axis=0) / size[:, None]), few
