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
        total, n, least, largest = 0.0, 0, np.inf, -np.inf
        for i in range(first[b], stop[b]):
            value = np.float64(x[i])
            if np.isfinite(value):
                total += value
                n += 1
                least = min(least, value)
                largest = max(largest, value)
        level, squares = total / n if n > 0 else np.nan, 0.0
        for i in range(first[b], stop[b]):
            value = np.float64(x[i]) - level
            if np.isfinite(value):
                squares += value * value
        count[b], mean[b] = n, level
        variance[b] = squares / (n - 1) if n > 1 else np.nan
        lo[b], hi[b] = (least, largest) if n > 0 else (np.nan, np.nan)
