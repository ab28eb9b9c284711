"""Compiled loops of the search for changes of level: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from .._kernels import fill_moments

__all__ = [
    "drop_lower", "fill_above", "fill_blocks", "fill_clear", "fill_moments", "fill_peaks", "margin", "mark_alone",
    "mark_loud",
]  # fmt: skip

Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

SCANNED = 128  # places looked at together: few hold any
LOUD = 4096  # samples that windows move over at a time
LANES = 64  # samples looked at side by side


@compiled
def mark_alone(x: Array, near: float, away: float, calm: Flags, far: Flags) -> None:
    """Unmark as calm where the neighbours differ by more than ``near``; mark as far what is off their mean."""
    here, after = x[1:], x[2:]
    for i in range(len(calm)):
        calm[i] &= abs(after[i] - x[i]) <= near
        far[i] |= abs(here[i] - 0.5 * (x[i] + after[i])) > away


@compiled
def fill_above(running: Array, w: int, limit: float, at: Indices) -> int:
    """Fill where the means of w samples after and before samples w .. n - w differ by more than a limit.

    ``running`` (n + 1): sum of the samples before each; w a power of two. Returns how many there are, room or not.
    """
    found, n, share = 0, len(running) - 2 * w, 1.0 / w
    for first in range(0, n, SCANNED):
        size, many = min(SCANNED, n - first), 0
        before, middle, after = running[first:], running[first + w :], running[first + 2 * w :]
        for i in range(size):
            many += share * abs(after[i] - middle[i] - middle[i] + before[i]) > limit
        if many > 0:
            for i in range(size):
                if share * abs(after[i] - middle[i] - middle[i] + before[i]) > limit:
                    if found < len(at):
                        at[found] = first + i
                    found += 1
    return found


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
def mark_loud(y: Array, cuts: Indices, w: int, limit: float, hot: Flags) -> None:
    """Mark the windows i .. i + w whose variance (w - 1) exceeds a limit; levels between cuts keep its digits."""
    residual = np.empty(LOUD + w)
    limit *= w - 1
    piece, level, first, second = -1, 0.0, 0.0, 0.0
    for begin in range(0, len(y), LOUD):
        stop = min(begin + LOUD, len(y))
        for i in range(begin, stop):
            while piece < 0 or i >= cuts[piece + 1]:
                piece += 1
                level = 0.0
                for j in range(cuts[piece], cuts[piece + 1]):
                    level += y[j]
                level /= max(cuts[piece + 1] - cuts[piece], 1)
            residual[i - begin + w] = y[i] - level
        for i in range(begin, stop):
            new, old = residual[i - begin + w], residual[i - begin] if i >= w else 0.0
            first += new
            second += new * new
            if i >= w:
                first -= old
                second -= old * old
            if i >= w - 1:
                hot[i - w + 1] |= second - first * first / w > limit
        for i in range(w):
            residual[i] = residual[stop - begin + i]


@compiled
def fill_blocks(y: Array, size: int, variance: Array, different: Indices) -> float:
    """Fill variance (size - 1) and number of unequal neighbours of each block; return the least step, 0 of none."""
    least = np.full(LANES, np.inf)
    for start in range(0, len(y) - 1, LANES):
        for j in range(min(LANES, len(y) - 1 - start)):  # side by side, for the processor
            difference = abs(y[start + j + 1] - y[start + j])
            least[j] = difference if (difference > 0.0) & (difference < least[j]) else least[j]
    step = least.min()
    for block in range(len(variance)):
        level, squares, unequal = 0.0, 0.0, 0
        own = y[block * size : (block + 1) * size]
        for i in range(size):
            level += own[i]
        level /= size
        for i in range(size):
            squares += (own[i] - level) ** 2
        for i in range(1, size):
            unequal += own[i] != own[i - 1]
        variance[block], different[block] = squares / (size - 1), unequal
    return step if np.isfinite(step) else 0.0


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
