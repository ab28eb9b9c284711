"""Values that are held: samples at the ends of the range, stuck stretches, and stretches that are stored twice.

All are judged against what the record does elsewhere: how often neighbours are equal, how many samples lie next to an
extreme, how often two distant samples are equal.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches
from ...core.estimate import Array
from ..time.samples import Indices
from .blocks import Blocks, pieces
from .loops import PRINT, loops_for

CHANCE = 1e-5  # of stuck stretches and copies each, a record
PILED = 4e-4  # of a pile at an end: four samples of noise lie on its last code by chance at times
HELD = 4  # samples at an extreme that saturation needs, in a row or not
OF_CONVERTER = 2  # samples at the end of a usual converter
CERTAIN = 1e-3  # chance that samples lie on such an end, from which they are no noise
SOME = 64  # samples that tell whether a channel has many values
FEW_LEVELS = 10  # with fewer levels (a switch, a flag) the extremes are no rails
PILE_RATIO = 3.0  # how much more samples lie at an end than noise puts there
STEPS = 2  # levels inside that pile up: the channel is set in steps
RAIL_CODES = frozenset(
    {0, *(2**bits - 1 for bits in (8, 10, 12, 14, 16, 24, 32))}
    | {code for bits in (8, 10, 12, 14, 16, 24, 32) for code in (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)}
)  # ends of the usual converters, unsigned and two's complement
TOP = 64  # blocks with the largest samples, which lead to those next to the extreme
EXACT = 30  # samples up to which their chance is summed
NEAREST = 8  # samples next to an extreme from which the number that noise puts there is known ...
PART = 8  # ... or a part of as many as there are at the extreme
MOST = 512  # blocks in which levels are counted
ROOM = 2**12  # places that are listed
FILLED_IN = 3  # stretches of zero that are gaps filled in, at most
JUMP = 2.0  # times the largest step elsewhere: a value that is reached so is a dropout, not an end of the range
ALIKE_PILE = 0.2  # of an extreme, that other levels must hold to be settings
FAR_LAGS = (17, 23, 31)  # samples apart, which tell how often samples are equal
PARTS = 8  # of a record
SURE = 7.0  # standard deviations
LEAST_SHARE = 0.003  # of the samples
STUCK = 10  # samples in a row
LONGER = 5.0  # times the run that a sample elsewhere lies in, on average, in lively parts and in all
NEVER_KNOWN = 0.9  # share of equal neighbours from which a channel hardly ever changes anyway
FULL = 0.9  # of a block that is equal neighbours
INSIDE = 0.1  # of the blocks that do not touch an extreme, from which these alone count
GROUP = 256  # samples over which that share is taken
TRIED = 64  # places that are looked at
HELD_ROWS = 2  # pieces that may hold part of a stuck stretch
ALIKE = 50  # cases from which a share is known
SHORTEST_COPY = 48  # samples
PRINTED = 128  # samples with one fingerprint, at most: a copy of three times as many is found, however long the record
SELDOM = 0.1  # chance that samples are equal, where nothing tells it
LAGS = 8  # at which a record is compared with itself
CHUNK = 2**16


@dataclass(frozen=True, eq=False)
class Held:
    """Stretches of one value: samples [first, last] of each, shape (k, 2), the value, and how many they are."""

    places: Indices
    value: float
    count: int


@dataclass(frozen=True)
class Copy:
    """Samples [first, last] that repeat those ``lag`` samples before."""

    first: int
    last: int
    lag: int


@dataclass(frozen=True, eq=False)
class Habits:
    """What a record does where nothing is held, from pieces spread evenly over it."""

    samples: Array  # those of the pieces that are there, shape (n,)
    rows: Array  # the pieces, shape (k, m)
    equal: float  # chance that a neighbour is equal, where it is most likely
    pairs: bool  # whether any neighbours are equal

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """How often each different value occurs, in order of the values."""
        return _counted(self.samples)[1]

    @cached_property
    def again(self) -> float:
        """Chance that distant samples are equal, where those before them are."""
        return _again(self.rows)

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Least and largest value."""
        return float(self.samples.min()), float(self.samples.max())

    def has_fewer(self, many: int) -> bool:
        """Whether there are fewer different values than so many; a few samples tell it most often."""
        return self._of_some < many and len(self.counts) < many

    @cached_property
    def _of_some(self) -> int:
        return len(_counted(self.samples[:SOME])[1])


def habits_of(blocks: Blocks, rows: Array | None = None) -> Habits:
    """Return the habits of a record; rows are its pieces, where they are known."""
    _, rows = pieces(blocks.x) if rows is None else (None, rows)
    same = rows[:, 1:] == rows[:, :-1]
    if not same.any() and not blocks.same.any():
        return Habits(rows[np.isfinite(rows)], rows, 0.0 if len(blocks) else 1.0, False)
    lively = same[same.mean(axis=1) < FULL]
    equal = [_group_share(blocks)]
    if lively.shape[1] > HELD and lively.any():
        three = lively[:, :-3] & lively[:, 1:-2] & lively[:, 2:-1]
        each, goes_on = three.sum(axis=1), (three & lively[:, 3:]).sum(axis=1)
        usual = np.argsort(each, kind="stable")[
            : len(each) - max(HELD_ROWS, len(each) // 50)
        ]  # what is held is no habit
        if each[usual].sum() >= ALIKE:
            equal.append(float(goes_on[usual].sum() / each[usual].sum()))
    return Habits(rows[np.isfinite(rows)], rows, max(equal), bool(same.any()))


def _counted(samples: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return the different values of finite samples, in order, and how often each occurs."""
    ordered = np.sort(samples)
    last = (
        np.append(np.flatnonzero(ordered[1:] != ordered[:-1]), len(ordered) - 1) if len(ordered) else np.empty(0, int)
    )
    return ordered[last], np.diff(last, prepend=-1)


def _group_share(blocks: Blocks) -> float:
    """Return the share of equal neighbours in groups of blocks that are not held, where it is large."""
    many = max(GROUP // blocks.size, 1)
    kept = blocks.same < FULL * (blocks.size - 1)
    inside = kept & (blocks.hi < np.nanmax(blocks.hi)) & (blocks.lo > np.nanmin(blocks.lo))
    kept = inside if np.count_nonzero(inside) >= INSIDE * len(kept) else kept
    pairs = np.maximum(blocks.count - 1, 0)[kept]
    same = blocks.same[kept]
    if not len(same):
        return 1.0
    at = np.arange(0, len(same), many)
    share = np.add.reduceat(same, at) / np.maximum(np.add.reduceat(pairs, at), 1)
    if np.count_nonzero(kept) < 0.5 * len(kept) and len(at) < ALIKE:
        return float(share.max())
    return float(np.quantile(share, 0.98))


def _again(rows: Array) -> float:
    """Return the chance that samples far apart go on being equal, once they are."""
    lively = rows[(rows != rows[:, :1]).any(axis=1)]
    counted = []
    for lag in range(1, min(LAGS, len(lively) - 1) + 1):
        equal = lively[lag:] == lively[:-lag]
        two = equal[:, :-2] & equal[:, 1:-1]
        if two.any():
            counted.append(np.column_stack((two.sum(axis=1), (two & equal[:, 2:]).sum(axis=1))))
        else:
            counted.append(np.zeros((len(two), 2), dtype=np.int64))
    if not counted:
        return SELDOM
    pairs, goes_on = np.concatenate(counted).T
    usual = np.argsort(pairs, kind="stable")[: len(pairs) - max(HELD_ROWS * LAGS, len(pairs) // 50)]
    return float(goes_on[usual].sum() + 1.0) / float(pairs[usual].sum() + 1.0 / SELDOM)


# Ends of the range


def rails(blocks: Blocks, habits: Habits, skip: Indices, step: float) -> tuple[Held, ...]:
    """Return the extremes at which samples pile up or are held, the lower one first.

    ``skip``: samples left out; ``step``: of the codes.
    """
    found = (_rail(blocks, habits, skip, step, sign) for sign in (-1.0, 1.0))
    return tuple(one for one in found if one is not None)


def _rail(blocks: Blocks, habits: Habits, skip: Indices, step: float, sign: float) -> Held | None:
    extreme = sign * (blocks.hi if sign > 0.0 else blocks.lo)
    extreme = np.where(blocks.count > 0, extreme, -np.inf)
    end = float(extreme.max())
    if not np.isfinite(end) or habits.has_fewer(2):
        return None
    whole = np.flatnonzero(extreme == end)
    if len(whole) < OF_CONVERTER and np.count_nonzero(blocks.rows(whole) == sign * end) < OF_CONVERTER:
        return None  # one sample is no end
    third, below = end, extreme
    for _ in range(2):
        below = below[below < third]
        third = float(below.max()) if len(below) else -np.inf
    most = min(TOP, len(extreme))
    least = min(third, float(np.partition(extreme, -most)[-most]))  # all samples above lie in these blocks
    near = np.flatnonzero(extreme >= least)
    some = near[:: max(-(-len(near) // MOST), 1)]
    inside = sign * blocks.rows(some).astype(np.float64)
    levels, counts = _counted(inside[(inside >= least) & (inside <= end)])
    if len(levels) < 2:
        return None
    starts, stops = np.empty((2, ROOM), dtype=np.int64)
    runs = int(loops_for(len(blocks.x)).fill_runs(blocks.x, blocks.size, whole, sign * end, starts, stops))
    starts, stops = starts[: min(runs, ROOM)], stops[: min(runs, ROOM)]
    kept = ~np.isin(starts, skip)
    starts, stops = starts[kept], stops[kept]
    if not len(starts):
        return None
    length = stops - starts
    count = int(length.sum() * max(runs / ROOM, 1.0))
    few = habits.has_fewer(FEW_LEVELS)
    longest = int(np.argmax(length))
    held = not few and length[longest] >= HELD and len(starts) * habits.equal ** (HELD - 1) < CERTAIN
    here, usual = int(counts[-1]), _usual(levels, counts, step)
    rare = _chance((1.0 - habits.equal) * here, (1.0 - habits.equal) * usual)
    piled = not few and count >= HELD and here > PILE_RATIO * usual and rare < PILED
    held, piled = (one and not _goes_in_steps(habits.counts, here) for one in (held, piled))
    value = sign * end
    code = (
        value == round(value) and int(value) in RAIL_CODES and value != 0.0 and bool(np.all(levels == np.rint(levels)))
    )
    of_converter = code and count >= OF_CONVERTER and rare < CERTAIN
    if not (held or piled or of_converter) or _dropout(blocks.x, starts, stops, longest, habits):
        return None
    return Held(np.column_stack((starts, stops - 1)), value, count)


def _usual(levels: Array, counts: NDArray[np.int64], step: float) -> float:
    """Return how many samples noise puts on the last level at most: as many a step as on those before it."""
    wanted = max(NEAREST, int(counts[-1]) // PART)
    running = np.cumsum(counts[-2::-1])
    last = min(int(np.searchsorted(running, wanted)), len(running) - 1)
    return float(running[last]) * step / float(levels[-1] - levels[-2 - last])


def _chance(count: float, mean: float) -> float:
    """Return the chance of so many or more in a Poisson distribution; far out a bound above it (Chernoff)."""
    if not 0.0 < mean < count:
        return float(not count > mean)
    bound = float(np.exp(count - mean - count * np.log(count / mean)))
    if count > EXACT:
        return bound
    more = np.arange(int(np.ceil(count)), int(np.ceil(count)) + 2 * EXACT)
    return min(float(np.exp(-mean) * np.sum(np.cumprod(mean / np.arange(1, more[-1] + 1))[more - 1])), bound)


def _goes_in_steps(counts: NDArray[np.int64], pile: int) -> bool:
    """Whether levels between the extremes pile up as much: the channel is set in steps."""
    inner = np.maximum(counts[:-2], counts[2:])
    middle = counts[1:-1]
    piles = np.flatnonzero((middle >= max(ALIKE_PILE * pile, HELD)) & (middle > PILE_RATIO * inner))
    sure = (i for i in piles.tolist() if _chance(float(middle[i]), float(max(inner[i], 1))) < CHANCE)
    return sum(1 for _ in itertools.islice(sure, STEPS)) == STEPS


def _dropout(x: NDArray[Any], starts: Indices, stops: Indices, longest: int, habits: Habits) -> bool:
    """Whether a value is no end of a range: filled in as zero, or reached by jumps as nowhere else."""
    start, stop = int(starts[longest]), int(stops[longest])
    value = float(x[start])
    if value == 0.0 and len(starts) <= FILLED_IN and stop - start >= STUCK:
        return True
    sides = [float(x[i]) for i in (start - 1, stop) if 0 <= i < len(x)]
    step = np.abs(np.diff(habits.rows, axis=1))
    step = step[(habits.rows[:, 1:] != value) & (habits.rows[:, :-1] != value) & np.isfinite(step)]
    return bool(len(step)) and bool(sides) and all(abs(side - value) > JUMP * step.max() for side in sides)


# Samples that are saved again in place of the next


def repeats(habits: Habits) -> float:
    """Return the share of samples that repeat the one before them beyond what noise does, or 0.

    Samples further apart tell how many neighbours noise makes equal: as many more as neighbours lie closer together.
    The record must do it all along.
    """
    if not habits.pairs:
        return 0.0
    low, high = habits.ends
    rows = np.where((habits.rows == low) | (habits.rows == high), np.nan, (habits.rows - low) / (high - low))
    near = np.diff(rows, axis=1)
    rows, near = (part[np.mean(near == 0.0, axis=1) < FULL] for part in (rows, near))
    if len(rows) < PARTS or rows.shape[1] <= max(FAR_LAGS):
        return 0.0
    size = _rms(near)
    if not size > 0.0:
        return 0.0
    usual = pairs = 0.0
    for lag in FAR_LAGS:
        far = rows[:, lag:] - rows[:, :-lag]
        there = float(np.sum(np.isfinite(far)))
        usual += float(np.sum(far == 0.0)) * _rms(far) / size
        pairs += there
    if not pairs:
        return 0.0
    usual /= pairs
    zero = np.sum(near == 0.0, axis=1, dtype=np.float64)
    n = float(np.sum(np.isfinite(near)))
    each = np.array([part.sum() for part in np.array_split(zero, PARTS)])
    along = np.count_nonzero(each > n * usual / PARTS) >= PARTS - 2
    excess = float(zero.sum()) - n * usual
    sure = excess > SURE * np.sqrt(max(n * usual, 1.0) * (1.0 + n / pairs))
    return excess / n if along and sure and excess > LEAST_SHARE * n else 0.0


def _rms(x: Array) -> float:
    there = np.isfinite(x)
    return float(np.sqrt(np.mean(x[there] ** 2))) if there.any() else 0.0


# Stuck stretches


def stuck(blocks: Blocks, habits: Habits, ends: tuple[float, ...]) -> tuple[Held, ...]:
    """Return stretches of one value that are far too long, the longest first; those at ``ends`` are saturation."""
    n, size = len(blocks.x), blocks.size
    if not len(habits.samples) or n < STUCK:
        return ()
    if habits.has_fewer(2) and np.nanmin(blocks.lo) == np.nanmax(blocks.hi):
        return (Held(np.array([[0, n - 1]]), habits.ends[0], n),)
    if habits.equal >= NEVER_KNOWN:
        return ()
    equal = max(habits.equal, 1.0 / n)
    mean_run = (1.0 + equal) / (1.0 - equal)
    least = max(STUCK, LONGER * mean_run, 1.0 + np.log(CHANCE / n) / np.log(equal))
    spread = size * equal + 6.0 * np.sqrt(size * equal)
    # a run of the least length has half of it in one of two neighbouring blocks
    likely = np.flatnonzero(blocks.same > min(spread + 0.25 * least, FULL * (size - 1)) if size > least else
                            blocks.same >= FULL * (size - 1))  # fmt: skip
    if not len(likely):
        return ()
    first = np.flatnonzero(np.diff(likely, prepend=likely[0] - 2) > 1)
    last = np.append(first[1:], len(likely)) - 1
    order = np.argsort(-(likely[last] - likely[first]), kind="stable")[:TRIED]
    runs = set()
    for i in order.tolist():
        a, b = int(likely[first[i]]) * size, min((int(likely[last[i]]) + 1) * size, n)
        runs.add(loops_for(n).longest_equal(blocks.bits, a, b))
    found = [
        Held(np.array([[a, b - 1]]), float(blocks.x[a]), b - a)
        for a, b in runs
        if b - a >= least and np.isfinite(float(blocks.x[a])) and float(blocks.x[a]) not in ends
    ]
    found.sort(key=lambda one: (-one.count, int(one.places[0, 0])))
    others, squares = float(n), float(loops_for(n).squared_runs(blocks.x)) if found else 0.0
    for i, one in enumerate(found):
        others, squares = others - one.count, squares - float(one.count) ** 2
        if one.count < LONGER * squares / max(others, 1.0):
            return tuple(found[:i])  # a channel that is slow, or set in steps
    return tuple(found)


# Stretches that are stored twice


def copies(blocks: Blocks, habits: Habits) -> tuple[Copy, ...]:
    """Return stretches that repeat an earlier one exactly, in order."""
    bits, n = blocks.bits, len(blocks.bits)
    if n < 2 * SHORTEST_COPY:
        return ()
    size = min(blocks.size, PRINTED)
    prints, place = np.empty(-(-n // size), dtype=np.uint64), np.empty(-(-n // size), dtype=np.int32)
    for first, stop in batches(bits, whole=size):
        own = slice(first // size, -(-stop // size))
        loops_for(n).fill_prints(bits[first : stop + PRINT], size, prints[own], place[own])
    ordered = np.sort(prints)
    twice = ordered[1:][(ordered[1:] == ordered[:-1]) & (ordered[1:] != 0)]
    if not len(twice):
        return ()
    which = np.flatnonzero(np.isin(prints, twice))
    at = which * size + place[which]
    earlier: dict[int, list[int]] = {}
    found: list[Copy] = []
    again = min(habits.again, 0.999)
    least = max(SHORTEST_COPY, 1.0 + (np.log(CHANCE) - 2.0 * np.log(n)) / np.log(max(again, 1.0 / n)))
    tried = 0
    for i, key in zip(at.tolist(), prints[which].tolist(), strict=True):
        before = earlier.setdefault(key, [])
        if found and i <= found[-1].last:
            before.append(i)
            continue
        for j in before[-2:] if tried < 8 * TRIED else ():
            tried += 1
            first, stop = _matching(bits, j, i)
            if stop - first >= least:
                found.append(Copy(first, stop - 1, i - j))
                break
        before.append(i)
        if len(found) >= TRIED:
            break
    return tuple(found)


def _matching(bits: NDArray[Any], early: int, late: int) -> tuple[int, int]:
    """Return the stretch around ``late`` that equals that around ``early``; it does not reach back into that one."""
    n, lag = len(bits), late - early
    stop = late
    while stop < n:
        end = min(stop + CHUNK, n)
        unequal = np.flatnonzero(bits[stop:end] != bits[stop - lag : end - lag])
        if len(unequal):
            stop += int(unequal[0])
            break
        stop = end
    first = late
    while first > lag:
        begin = max(first - CHUNK, lag)
        unequal = np.flatnonzero(bits[begin:first] != bits[begin - lag : first - lag])
        if len(unequal):
            first = begin + int(unequal[-1]) + 1
            break
        first = begin
    return first, stop
