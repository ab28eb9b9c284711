"""Compiled loops: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.estimate import Array
from ..statistics._kernels import compiled


@compiled
def fill_first(time_ns: NDArray[np.int64], length: int, first: NDArray[np.int64], at: NDArray[np.int64]) -> int:
    """Fill the first sample of each block of time that holds any, and which block it is; return their number.

    Where time runs backwards the answer is negative: -1 less the sample.
    """
    found = 0
    before = end = time_ns[0]  # of the block: a division a block, not a sample
    for i in range(len(time_ns)):
        stamp = time_ns[i]
        if stamp < before:
            return -1 - i
        before = stamp
        if stamp >= end:
            block = (stamp - time_ns[0]) // length
            first[found], at[found] = i, block
            end = time_ns[0] + (block + 1) * length
            found += 1
    return found


@compiled
def count_marks(words: NDArray[np.uint64], room: int, fold: int, most: float, marks: NDArray[np.uint64]) -> int:
    """Mark a place of 2^room for words, by a hash of each; return how many are marked, once they are more than most.

    Equal words have one place, so that as many words differ at least. Of 2^fold different words one counts, by other
    bits of its hash. ``marks``: a bit a place, 0 at first.
    """
    found = 0
    shift, rest = np.uint64(64 - room - fold), np.uint64((1 << fold) - 1)
    for word in words:
        mixed = (word ^ (word >> np.uint64(32))) * np.uint64(0x9E3779B97F4A7C15)
        mixed = ((mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)) >> shift
        if mixed & rest:
            continue
        place = mixed >> np.uint64(fold)
        at, bit = place >> np.uint64(6), np.uint64(1) << (place & np.uint64(63))
        if not marks[at] & bit:
            marks[at] |= bit
            found += 1
            if found > most:
                break
    return found


@compiled
def fill_set(words: NDArray[np.uint64], room: int, table: NDArray[np.uint64], filled: int) -> int:
    """Put words that are not zero into a set; return how many it holds, ``filled`` of them before.

    ``table``, shape (2^room,): zero where a place is free; it must stay larger than the set.
    """
    last, shift = len(table) - 1, np.uint64(64 - room)
    for word in words:
        mixed = (word ^ (word >> np.uint64(32))) * np.uint64(0x9E3779B97F4A7C15)
        at = np.int64(((mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)) >> shift)
        while table[at] != 0 and table[at] != word:
            at = np.int64(at + 1 if at < last else 0)
        if table[at] == 0:
            table[at] = word
            filled += 1
    return filled


@compiled
def fill_sums_of_blocks(x: Array, size: int, sums: Array) -> bool:
    """Fill the sums of neighbouring blocks; return whether all of these are finite."""
    whole = True
    for b in range(len(sums)):
        c, d, e, f = 0.0, 0.0, 0.0, 0.0
        part = x[b * size : (b + 1) * size]
        fours = size // 4
        for i in range(fours):
            c, d, e, f = c + part[4 * i], d + part[4 * i + 1], e + part[4 * i + 2], f + part[4 * i + 3]
        for i in range(4 * fours, size):
            c += part[i]
        sums[b] = (c + d) + (e + f)
        whole &= np.isfinite(sums[b])
    return whole


@compiled
def fine_steps(x: Array, few: int, fine: float) -> bool:
    """Return whether the first samples show that the mean square of all is at least so many squared least steps."""
    step, squares = np.inf, 0.0
    for i in range(1, min(few, len(x))):
        difference = abs(x[i] - x[i - 1])
        squares += difference * difference
        if difference > 0.0 and difference < step:
            step = difference
    return squares / len(x) / 2.0 >= step * step * fine


@compiled
def explained(
    means: Array, modes: Array, shape: Array, logs: Array, rise: Array, possible: float
) -> tuple[float, float, float]:
    """Return the least cost of white noise with shares of slow noise, the scatter of the rise there, and its largest.

    ``modes`` (m, n) of the means (n,); ``shape`` (m, shares): what each scatters by, over one, and the same sum of
    logarithms ``logs`` and variance of the rise ``rise`` (shares,); largest of all shares that cost ``possible`` more.
    """
    level = np.zeros(shape.shape[1])
    for i in range(len(modes)):
        mode, own, total = modes[i], shape[i], 0.0
        for k in range(len(mode)):
            total += mode[k] * means[k]
        total *= total
        for j in range(len(level)):
            level[j] += total / own[j]
    cost, best, most = np.empty(len(level)), 0, 0.0
    for j in range(len(level)):
        level[j] /= len(modes)
        cost[j] = 0.5 * (logs[j] + len(modes) * np.log(level[j]))
        if cost[j] < cost[best]:
            best = j
    for j in range(len(level)):
        if cost[j] <= cost[best] + possible:
            most = max(most, level[j] * rise[j])
    return cost[best], np.sqrt(level[best] * rise[best]), np.sqrt(most)


@compiled
def fill_mixed(words: NDArray[np.uint64], lanes: NDArray[np.uint64]) -> bool:
    """Mix all words into eight, every eighth into the same one; any change of a word changes its lane."""
    for i in range(8):
        lanes[i] = np.uint64(i + 1) * np.uint64(0x9E3779B97F4A7C15)
    for first in range(0, len(words) // 8 * 8, 8):
        part = words[first : first + 8]
        for i in range(8):
            mixed = (lanes[i] ^ part[i]) * np.uint64(0xBF58476D1CE4E5B9)
            lanes[i] = mixed ^ (mixed >> np.uint64(32))
    rest = words[len(words) // 8 * 8 :]
    for i in range(len(rest)):
        mixed = (lanes[i] ^ rest[i]) * np.uint64(0xBF58476D1CE4E5B9)
        lanes[i] = mixed ^ (mixed >> np.uint64(32))
    return True


@compiled
def _whole_sums(x: NDArray[Any]) -> tuple[float, int, float, float]:
    """Return sum, number, least and largest of samples, four at a time; the sum is not finite where one of them is."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    least, low, lower, lowest = np.inf, np.inf, np.inf, np.inf
    largest, high, higher, highest = -np.inf, -np.inf, -np.inf, -np.inf
    fours = len(x) // 4
    for i in range(fours):
        e, f, g, h = (
            np.float64(x[4 * i]), np.float64(x[4 * i + 1]), np.float64(x[4 * i + 2]), np.float64(x[4 * i + 3])
        )  # fmt: skip
        a, b, c, d = a + e, b + f, c + g, d + h
        least, low, lower, lowest = min(least, e), min(low, f), min(lower, g), min(lowest, h)
        largest, high, higher, highest = max(largest, e), max(high, f), max(higher, g), max(highest, h)
    for i in range(4 * fours, len(x)):
        e = np.float64(x[i])
        a, least, largest = a + e, min(least, e), max(largest, e)
    return (a + b) + (c + d), len(x), min(least, low, lower, lowest), max(largest, high, higher, highest)


@compiled
def _squares_about(x: NDArray[Any], level: float) -> float:
    """Return the sum of the squares of samples less a level, four at a time."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    fours = len(x) // 4
    for i in range(fours):
        e, f = np.float64(x[4 * i]) - level, np.float64(x[4 * i + 1]) - level
        g, h = np.float64(x[4 * i + 2]) - level, np.float64(x[4 * i + 3]) - level
        a, b, c, d = a + e * e, b + f * f, c + g * g, d + h * h
    for i in range(4 * fours, len(x)):
        e = np.float64(x[i]) - level
        a += e * e
    return (a + b) + (c + d)


@compiled
def fill_moments(
    x: NDArray[Any],
    first: NDArray[np.int64],
    stop: NDArray[np.int64],
    mean: Array,
    variance: Array,
    lo: Array,
    hi: Array,
    count: NDArray[np.int64],
) -> None:
    """Fill number, mean, variance (n - 1), least and largest of the finite samples of each block.

    The second look at a block finds it in the cache; the mean is taken off first, so that a variance keeps its digits
    beside a large level.
    """
    for b in range(len(first)):
        part = x[first[b] : stop[b]]
        total, n, least, largest = _whole_sums(part)
        if not np.isfinite(total):  # not all are finite
            total, n, least, largest = 0.0, 0, np.inf, -np.inf
            for i in range(len(part)):
                value = np.float64(part[i])
                if np.isfinite(value):
                    total += value
                    n += 1
                    least = min(least, value)
                    largest = max(largest, value)
        level = total / n if n > 0 else np.nan
        squares = _squares_about(part, level) if n == len(part) else 0.0
        for i in range(0 if n == len(part) else len(part)):
            value = np.float64(part[i]) - level
            if np.isfinite(value):
                squares += value * value
        count[b], mean[b] = n, level
        variance[b] = squares / (n - 1) if n > 1 else np.nan
        lo[b], hi[b] = (least, largest) if n > 0 else (np.nan, np.nan)
