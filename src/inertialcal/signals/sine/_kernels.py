"""Loops over all readings of a driven sensor, without checks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, inlined

DROPPED = 49  # bits of a number, below three of its fraction
SIZE = 0x7FFFFFFFFFFFFFFF  # all bits but the sign
INFINITE = 0x7FF0000000000000 >> DROPPED  # leading bits of infinity; NaN has the same or more
KEYS = (SIZE >> DROPPED) + 1


@inlined
def _contrast(a: float, b: float, c: float, d: float) -> float:
    """Return two thirds of a jump from b to c, and nothing of a steady drift."""
    return (c - b) - (d - a) / 3.0


@compiled
def four_windows(sums: Array, w: int, out: Array) -> None:
    """Fill the contrast of four windows of w readings each, from running sums over one more, at each first reading."""
    for i in range(len(out)):
        a, b = (sums[i + w] - sums[i]) / w, (sums[i + 2 * w] - sums[i + w]) / w
        c, d = (sums[i + 3 * w] - sums[i + 2 * w]) / w, (sums[i + 4 * w] - sums[i + 3 * w]) / w
        out[i] = _contrast(a, b, c, d)


@compiled
def four_windows_with_gaps(sums: Array, counts: NDArray[np.int64], w: int, out: Array) -> None:
    """Fill the same from running sums and numbers of readings; NaN where a window lacks half of its readings."""
    least = max(0.5 * w, 1.0)
    for i in range(len(out)):
        k, m = counts[i + w] - counts[i], counts[i + 2 * w] - counts[i + w]
        p, q = counts[i + 3 * w] - counts[i + 2 * w], counts[i + 4 * w] - counts[i + 3 * w]
        out[i] = np.nan
        if min(k, m, p, q) >= least:
            a, b = (sums[i + w] - sums[i]) / k, (sums[i + 2 * w] - sums[i + w]) / m
            c, d = (sums[i + 3 * w] - sums[i + 2 * w]) / p, (sums[i + 4 * w] - sums[i + 3 * w]) / q
            out[i] = _contrast(a, b, c, d)


@compiled
def middle_sizes(values: Array, counts: NDArray[np.int64]) -> tuple[int, int, Array]:
    """Return how many numbers are finite, how many of their sizes are below the middle ones, and those about them.

    Sizes are told apart by their leading bits, whose order is theirs; ``counts`` is zeros, one for each.
    """
    bits = values.view(np.int64)
    finite = 0
    for i in range(len(bits)):
        key = (bits[i] & SIZE) >> DROPPED
        counts[key] += 1
    for key in range(INFINITE):
        finite += counts[key]
    first, below, held = -1, 0, 0
    for key in range(INFINITE):
        if below + held + counts[key] > (finite - 1) // 2 and first < 0:
            first, below = key, below + held
            held = 0
        held += counts[key]
        if first >= 0 and below + held > finite // 2:
            break
    sizes, n = np.empty(held if first >= 0 else 0), 0
    for i in range(len(bits)):
        place = (bits[i] & SIZE) >> DROPPED
        if first <= place <= key and n < len(sizes):
            sizes[n] = abs(values[i])
            n += 1
    return finite, below, sizes


@compiled
def farthest_from_zero(values: Array) -> int:
    """Return the first place of the largest size, NaN left out; -1 where nothing is finite."""
    place, largest, finite = -1, -1.0, False
    for i in range(len(values)):
        size = abs(values[i])
        if size > largest:
            place, largest = i, size
        finite |= math.isfinite(size)
    return place if finite else -1
