"""Loops over all readings of a driven sensor, without checks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled


@compiled
def four_windows(sums: Array, w: int, out: Array) -> None:
    """Fill the contrast of four windows of w readings each, from running sums over one more, at each first reading."""
    for i in range(len(out)):
        a, b = (sums[i + w] - sums[i]) / w, (sums[i + 2 * w] - sums[i + w]) / w
        c, d = (sums[i + 3 * w] - sums[i + 2 * w]) / w, (sums[i + 4 * w] - sums[i + 3 * w]) / w
        out[i] = (c - b) - (d - a) / 3.0


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
            out[i] = (c - b) - (d - a) / 3.0


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
