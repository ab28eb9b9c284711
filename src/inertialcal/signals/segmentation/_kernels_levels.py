"""Compiled loops of the search for changes of level: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from .._kernels import fill_moments

__all__ = [
    "count_above", "drop_lower", "fill_above", "fill_blocks", "fill_clear", "fill_far", "fill_jumps", "fill_loud",
    "fill_moments", "fill_peaks", "fill_sums", "is_still", "margin", "sum_of",
]  # fmt: skip

Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

SCANNED = 128  # places looked at together: few hold any
LOUD = 4096  # samples that windows move over at a time
COUNTED = 1024  # samples whose differences of means are counted at a time: with both sums they lie in the nearest cache
EIGHT = 8  # samples of a block whose loops are written out
DRAWN, NEAR_RANK = 128, 14  # numbers that tell about where a rank lies, and how far off in them it may lie
ROUNDED = 1.0 + 1e-9  # more than sums may differ by rounding


@compiled
def fill_far(x: Array, away: float, at: Indices) -> int:
    """Fill which samples, the first and the last left out, are off the mean of their neighbours by more than a limit.

    Returns how many there are, room or not.
    """
    found, n = 0, len(x) - 2
    for first in range(0, n, SCANNED):
        size, many = min(SCANNED, n - first), 0
        before, here, after = x[first:], x[first + 1 :], x[first + 2 :]
        for i in range(size):
            many += abs(here[i] - 0.5 * (before[i] + after[i])) > away
        if many > 0:
            for i in range(size):
                if abs(here[i] - 0.5 * (before[i] + after[i])) > away:
                    if found < len(at):
                        at[found] = first + i + 1
                    found += 1
    return found


@compiled
def count_above(x: Array, limits: Array, counts: Indices) -> None:
    """Count, for w = 1, 2, 4, ..., the samples w .. n - w with means of w samples after and before that differ by more.

    More than the limit of that w. Sums of 2 w samples are those of two sums of w: one look at ``x`` gives all.
    """
    widest = 1 << (len(limits) - 1)
    batch = max(COUNTED, 8 * widest)
    room, more = np.empty(batch + 2 * widest), np.empty(batch + 2 * widest)
    for begin in range(0, len(x), batch):
        there = min(len(room), len(x) - begin)
        sums, out, w = x[begin : begin + there], room, 1
        for k in range(len(limits)):
            left = max(there - 2 * w + 1, 0)
            size = min(batch, left)
            counts[k] += _far_apart(sums[:size], sums[w : w + size], limits[k] * w, out[:size])
            if k + 1 < len(limits):
                _add(sums[size:left], sums[w + size : w + left], out[size:left])
            sums, out, more = out, more, out
            w *= 2


@compiled
def _far_apart(here: Array, later: Array, limit: float, out: Array) -> int:
    """Fill the sums of samples; return how many samples are further apart than a limit."""
    many = 0
    for i in range(len(here)):
        a, b = here[i], later[i]
        out[i] = a + b
        many += abs(b - a) > limit
    return many


@compiled
def _add(here: Array, later: Array, out: Array) -> None:
    """Fill the sums of samples."""
    for i in range(len(out)):
        out[i] = here[i] + later[i]


@compiled
def fill_above(x: Array, w: int, limit: float, at: Indices) -> int:
    """Fill where the means of w samples after and before samples w .. n - w differ by more than a limit.

    Places are counted from sample w; w is a power of two. Returns how many there are, room or not.
    """
    found, share, batch = 0, 1.0 / w, max(LOUD, 8 * w)
    one, other = np.empty(batch + 2 * w), np.empty(batch + 2 * w)
    for begin in range(0, len(x) - 2 * w + 1, batch):
        there = min(len(one), len(x) - begin)
        sums, jumps = _sums(x[begin : begin + there], w, one, other)
        later, size = sums[w:], min(batch, there - 2 * w + 1)
        for i in range(size):
            jumps[i] = share * abs(later[i] - sums[i])
        found = _filled(jumps[:size], limit, begin, at, found)
    return found


@compiled
def fill_jumps(x: Array, w: int, at: Indices, jumps: Array) -> None:
    """Fill by how much the means of w samples after and before differ, at places counted from sample w, ascending."""
    batch, i, share = max(LOUD, 8 * w), 0, 1.0 / w
    one, other = np.empty(batch + 2 * w), np.empty(batch + 2 * w)
    while i < len(at):
        begin, stop = at[i], i + 1
        while stop < len(at) and at[stop] - begin < batch and at[stop] - at[stop - 1] < 2 * w:
            stop += 1
        there = at[stop - 1] - begin + 2 * w
        if stop == i + 1:  # alone: of the sums below, those that its two means are made of
            for k in range(there):
                one[k] = x[begin + k]
            while there > 2:
                there //= 2
                for k in range(there):
                    one[k] = one[2 * k] + one[2 * k + 1]
            jumps[i] = share * abs(one[1] - one[0])
            i = stop
            continue
        sums, _ = _sums(x[begin : begin + there], w, one, other)
        for j in range(i, stop):
            jumps[j] = share * abs(sums[at[j] - begin + w] - sums[at[j] - begin])
        i = stop


@compiled
def _filled(x: Array, limit: float, first: int, at: Indices, found: int) -> int:
    """Add the places of what exceeds a limit, counted on from ``first``, to those found before; return their number."""
    many = 0
    for i in range(len(x)):
        many += x[i] > limit
    if many > 0:
        for i in range(len(x)):
            if x[i] > limit:
                if found < len(at):
                    at[found] = first + i
                found += 1
    return found


@compiled
def _sums(x: Array, w: int, one: Array, other: Array) -> tuple[Array, Array]:
    """Return the sums of w samples from each on, and room for more: w a power of two, as `count_above` adds them."""
    for i in range(len(x)):
        one[i] = x[i]
    width = 1
    while width < w:
        left = max(len(x) - 2 * width + 1, 0)
        _add(one[:left], one[width : width + left], other[:left])
        one, other = other, one
        width *= 2
    return one, other


@compiled
def fill_clear(at: Indices, w: int, cuts: Indices, clear: Flags) -> None:
    """Fill which of the indices, ascending, are w samples or more from the nearest cut, ascending too."""
    after = 0
    for i in range(len(at)):
        while after < len(cuts) - 1 and cuts[after] < at[i]:
            after += 1
        before = max(after - 1, 0)
        clear[i] = abs(cuts[after] - at[i]) >= w and abs(at[i] - cuts[before]) >= w


@compiled
def fill_peaks(at: Indices, score: Array, peaks: Indices) -> int:
    """Fill which of the places ``at``, ascending, score higher than both neighbours; return their number.

    A place more than one sample from the next has nothing there; of neighbours that score alike the middle one counts.
    """
    found, n, i = 0, len(at), 0
    while i < n:
        alone = i == 0 or at[i] - at[i - 1] > 1
        last = i
        while last + 1 < n and at[last + 1] - at[last] == 1 and score[last + 1] == score[i]:
            last += 1
        ends = last + 1 == n or at[last + 1] - at[last] > 1
        above = score[i] > (0.0 if alone else score[i - 1])
        if above and score[i] > (0.0 if ends else score[last + 1]):
            peaks[found] = (i + last) // 2
            found += 1
        i = last + 1
    return found


@compiled
def drop_lower(at: Indices, order: Indices, w: int, kept: Flags) -> None:
    """Fill which peaks are the highest for w samples around; ``order``: of the peaks, the lowest first."""
    for i in range(len(at)):
        kept[i] = True
    for rank in range(len(at) - 1, -1, -1):
        i = order[rank]
        if not kept[i]:
            continue
        j = i - 1
        while j >= 0 and at[i] - at[j] < w:
            kept[j] = False
            j -= 1
        j = i + 1
        while j < len(at) and at[j] - at[i] < w:
            kept[j] = False
            j += 1


@compiled
def fill_loud(y: Array, cuts: Indices, w: int, limit: float, at: Indices) -> int:
    """Fill the windows i .. i + w whose variance (w - 1) exceeds a limit; levels between cuts keep its digits.

    Sums of w samples are those of 1, 2, 4, ... samples put together: none waits for the one before it. Returns how many
    there are, room or not.
    """
    found, room = 0, LOUD + w
    residual, squared, doubled, again = np.empty(room), np.empty(room), np.empty(room), np.empty(room)
    first, second, levels = np.empty(LOUD), np.empty(LOUD), np.empty(max(len(cuts) - 1, 1))
    for piece in range(len(cuts) - 1):
        levels[piece] = sum_of(y[cuts[piece] : cuts[piece + 1]]) / max(cuts[piece + 1] - cuts[piece], 1)
    limit *= w - 1
    share, piece = 1.0 / w, 0
    for begin in range(0, len(y) - w + 1, LOUD):
        stop = min(begin + LOUD + w - 1, len(y))
        while begin >= cuts[piece + 1]:
            piece += 1
        if stop <= cuts[piece + 1] and _none_above(y[begin:stop], levels[piece], w, limit):
            continue
        i, own = begin, piece
        while i < stop:
            while i >= cuts[own + 1]:
                own += 1
            end, level = min(stop, cuts[own + 1]), levels[own]
            to, source = residual[i - begin : end - begin], y[i:end]
            for j in range(len(to)):
                to[j] = source[j] - level
            i = end
        there = stop - begin
        _square(residual[:there], squared)
        size = there - w + 1
        fill_sums(residual[:there], w, doubled, again, first[:size])
        fill_sums(squared[:there], w, doubled, again, second[:size])
        for j in range(size):
            second[j] -= share * first[j] * first[j]
        found = _filled(second[:size], limit, begin, at, found)
    return found


@compiled
def _square(x: Array, out: Array) -> None:
    """Fill the squares of samples."""
    for i in range(len(x)):
        out[i] = x[i] * x[i]


@compiled
def _none_above(x: Array, level: float, w: int, limit: float) -> bool:
    """Return whether no w samples scatter more about a level: they lie in two neighbouring blocks of w samples."""
    before, most = 0.0, 0.0
    for first in range(0, len(x), w):
        part = x[first : first + w]
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        fours = len(part) // 4
        for i in range(fours):
            e, f, g, h = part[4 * i] - level, part[4 * i + 1] - level, part[4 * i + 2] - level, part[4 * i + 3] - level
            a, b, c, d = a + e * e, b + f * f, c + g * g, d + h * h
        for i in range(4 * fours, len(part)):
            a += (part[i] - level) ** 2
        total = (a + b) + (c + d)
        most = max(most, before + total)
        before = total
    return most * ROUNDED <= limit


@compiled
def _none_loud(x: Array, middle: float, level: Array, variance: Array, size: int, w: int, limit: float) -> bool:
    """Return whether no w samples scatter more: they lie in a few neighbouring blocks, looked at where these do.

    ``middle``: of all; ``level``, ``variance`` (size - 1): of the blocks of so many; samples behind them are one more.
    """
    n, many = len(x), len(level)
    around = (w - 2) // size + 2  # blocks that w samples lie in, at most
    squares, total, above = np.zeros(many + around), np.zeros(many + 1), 0
    for b in range(many):
        away = level[b] - middle
        squares[b] = (size - 1) * variance[b] + size * (away * away)
    for i in range(many * size, n):
        squares[many] += (x[i] - middle) ** 2
    for k in range(around):
        _add(total, squares[k:], total)
    for b in range(many + 1):
        above += not total[b] * ROUNDED <= limit
    for b in range(many + 1 if above > 0 else 0):
        if total[b] * ROUNDED <= limit:
            continue
        for first in range(b * size, min((b + around) * size, n) - w + 1):
            mean, own = sum_of(x[first : first + w]) / w, 0.0
            for i in range(first, first + w):
                own += (x[i] - mean) ** 2
            if not own * ROUNDED <= limit:
                return False
    return True


@compiled
def sum_of(x: Array) -> float:
    """Return the sum of samples, four at a time."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    fours = len(x) // 4
    for i in range(fours):
        a, b, c, d = a + x[4 * i], b + x[4 * i + 1], c + x[4 * i + 2], d + x[4 * i + 3]
    for i in range(4 * fours, len(x)):
        a += x[i]
    return (a + b) + (c + d)


@compiled
def fill_sums(x: Array, w: int, one: Array, other: Array, out: Array) -> None:
    """Fill the sums of w samples from each on; ``one`` and ``other`` are room for sums of 2, 4, ... samples."""
    n, width, done = len(out), 1, 0
    out[:] = 0.0
    while True:
        if w & width:
            part = x[done : done + n]
            for i in range(n):
                out[i] += part[i]
            done += width
        if done == w:
            return
        to = one[: len(x) - width]
        _add(x, x[width:], to)
        x, one, other = to, other, one
        width *= 2


@compiled
def _of_eight(
    a: float, b: float, c: float, d: float, e: float, f: float, g: float, h: float
) -> tuple[float, float, int]:  # fmt: skip
    """Return mean and variance of eight numbers, and how many differ from the one before: no sum waits for others."""
    unequal = int(b != a) + int(c != b) + int(d != c) + int(e != d) + int(f != e) + int(g != f) + int(h != g)
    level = 0.125 * (((a + b) + (c + d)) + ((e + f) + (g + h)))
    a, b, c, d, e, f, g, h = a - level, b - level, c - level, d - level, e - level, f - level, g - level, h - level
    return level, (((a * a + b * b) + (c * c + d * d)) + ((e * e + f * f) + (g * g + h * h))) / 7.0, unequal


@compiled
def _least_step(y: Array) -> float:
    """Return the least difference of neighbours that are not equal; 0 of none."""
    step = np.inf
    for first in range(0, len(y) - 1, SCANNED):
        here = y[first : min(first + SCANNED, len(y) - 1)]
        after, many = y[first + 1 :], 0
        for i in range(len(here)):
            difference = abs(after[i] - here[i])
            many += (difference > 0.0) & (difference < step)
        if many > 0:
            for i in range(len(here)):
                difference = abs(after[i] - here[i])
                if difference > 0.0:
                    step = min(step, difference)
    return step if np.isfinite(step) else 0.0


@compiled
def _fill_spreads(y: Array, size: int, level: Array, variance: Array, different: Indices) -> None:
    """Fill mean, variance (size - 1) and number of unequal neighbours of each block."""
    for block in range(len(variance)):
        x = y[block * size : (block + 1) * size]
        if size == EIGHT:
            level[block], variance[block], different[block] = _of_eight(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7])
            continue
        mean, squares, unequal = 0.0, 0.0, 0
        for i in range(size):
            mean += x[i]
        mean /= size
        for i in range(size):
            squares += (x[i] - mean) ** 2
        for i in range(1, size):
            unequal += x[i] != x[i - 1]
        level[block], variance[block], different[block] = mean, squares / (size - 1), unequal


@compiled
def fill_blocks(y: Array, size: int, variance: Array, different: Indices) -> float:
    """Fill variance (size - 1) and number of unequal neighbours of each block; return the least step, 0 of none."""
    _fill_spreads(y, size, np.empty(len(variance)), variance, different)
    return _least_step(y)


@compiled
def _of_rank(x: Array, rank: int) -> tuple[float, float]:
    """Return the number of a rank, from 0 on, and the next; of many those alone are put in order that may be these."""
    n, found = len(x), x
    if n >= 4 * DRAWN:
        drawn = np.sort(x[:: n // DRAWN].copy())
        at, room, below, count = rank * len(drawn) // n, np.empty(n), 0, 0
        lowest = drawn[at - NEAR_RANK] if at >= NEAR_RANK else -np.inf
        highest = drawn[at + NEAR_RANK] if at + NEAR_RANK < len(drawn) else np.inf
        for i in range(n):
            room[count] = x[i]
            below += x[i] < lowest
            count += (x[i] >= lowest) & (x[i] <= highest)
        if below <= rank < below + count - 1:
            found, rank = room[:count], rank - below
    numbers = np.partition(found, rank)
    return numbers[rank], numbers[rank + 1 :].min() if rank + 1 < len(numbers) else numbers[rank]


@compiled
def _quiet_variance(variance: Array, low: float, usual: float, limit: float, rounds: int) -> float:
    """Return the mean variance of the quiet blocks, as ``noise_scale`` has it."""
    rank, quiet = int(low * (len(variance) - 1)), np.empty(len(variance))
    here, after = _of_rank(variance, rank)
    pooled, many = (here + (low * (len(variance) - 1) - rank) * (after - here)) / usual, 0
    for _ in range(rounds):
        now, most = 0, limit * pooled
        for i in range(len(variance)):
            now += variance[i] <= most
            quiet[i] = variance[i] if variance[i] <= most else 0.0
        total = sum_of(quiet)
        if now in (0, many):
            break
        many, pooled = now, total / now
    return float(pooled)


@compiled
def is_still(
    x: Array, size: int, alive: int, most: tuple[float, float, float, float], rounds: int, away: float, widest: int,
    w: int, loud: float,
) -> bool:  # fmt: skip
    """Return whether samples show no change of level and no louder window, whatever the widest limits find.

    ``size``, ``alive``, ``rounds``: of the blocks that the noise is told from, as ``noise_scale`` has them; ``most``:
    part of them that must be live, quantile that is quiet and its usual value, largest variance of a quiet one.
    ``away``: standard deviations of the difference of two means, ``widest``: of their windows, all of these as known
    as can be; ``loud``: the same for the variance of ``w`` samples. True also where codes hide the noise, so that
    nothing can be told; never where a sample is missing.
    """
    many = len(x) // size
    level, variance, different = np.empty(many), np.empty(many), np.empty(many, dtype=np.int64)
    _fill_spreads(x, size, level, variance, different)
    middle = (size * sum_of(level) + sum_of(x[size * many :])) / len(x)
    if not np.isfinite(middle):
        return False
    living, many = np.empty(len(variance)), 0
    for i in range(len(variance)):
        living[many] = variance[i]
        many += different[i] >= alive
    living = living[:many]
    if many < max(2.0, most[0] * len(variance)):
        return True
    pooled = _quiet_variance(living, most[1], most[2], most[3], rounds)
    scale = np.sqrt(pooled)
    if scale < 0.5 * _least_step(x):
        return True
    at = np.empty(1, dtype=np.int64)
    if fill_far(x, np.sqrt(1.5) * away * scale, at) > 0:
        return False
    limits, width = np.empty(widest), 1
    for k in range(widest):
        limits[k] = away * (scale * np.sqrt(2.0 / width))
        width *= 2
    counts = np.zeros(widest, dtype=np.int64)
    count_above(x, limits, counts)
    return counts.sum() == 0 and (
        _none_loud(x, middle, level, variance, size, w, (w - 1) * (loud * pooled))
        or fill_loud(x, np.array([0, len(x)]), w, loud * pooled, at) == 0
    )


@compiled
def margin(rates: Array, first: int, last: int, most: int, size: int, moves: float) -> tuple[int, int]:
    """Return samples at both ends of a stretch in which block means are not those of its middle, and a block more.

    ``most``: at most so many at each end, ``size``: of a block, ``moves``: standard uncertainties of a block mean.
    """
    head, tail = size, size
    for k in range(rates.shape[1]):
        x = rates[first:last, k]
        level, squares, n = 0.0, 0.0, last - first - 2 * most
        for i in range(most, most + n):
            level += x[i]
            squares += x[i] * x[i]
        level /= n
        limit = moves * np.sqrt(max(squares / n - level * level, 0.0)) / np.sqrt(size)
        for block in range(most // size):
            at_head, at_tail = 0.0, 0.0
            for i in range(block * size, (block + 1) * size):
                at_head += x[i]
                at_tail += x[len(x) - 1 - i]
            if abs(at_head / size - level) > limit:
                head = max(head, size * (block + 2))
            if abs(at_tail / size - level) > limit:
                tail = max(tail, size * (block + 2))
    return min(head, most), min(tail, most)
