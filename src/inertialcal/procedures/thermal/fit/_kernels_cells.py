"""Sums of the samples of a ramp in bins of temperature: compiled loops.

Rows of ``columns`` are temperature, time, all readings, and the rate where there is one, shape (2 + k, n).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import compiled

NONE = -1  # in place of a bin


@compiled
def find_bins(
    columns: Array, readings: int, path: NDArray[np.int8], ends: Array, cut: float, bins: NDArray[np.int64],
    left: NDArray[np.int64],
) -> None:  # fmt: skip
    """Find the bin of each sample, the first one from ``ends[0]`` on and ``ends[1]`` wide; count those in none by rule.

    No reading or temperature, before a time, on no path.
    """
    for i in range(columns.shape[1]):
        valid = np.isfinite(columns[0, i])
        for j in range(2, 2 + readings):
            valid = valid and np.isfinite(columns[j, i])
        rule = -1
        if not valid:
            rule = 0
        elif columns[1, i] < cut:
            rule = 1
        elif path[i] == 0:
            rule = 2
        if rule >= 0:
            left[rule] += 1
            bins[i] = NONE
        else:
            bins[i] = int((columns[0, i] - ends[0]) / ends[1])


@compiled
def add_sums(columns: Array, bins: NDArray[np.int64], count: Array, sums: Array) -> None:
    """Add to the number of samples in each bin, shape (b,), and to the sums of all rows, shape (2 + k, b)."""
    for i in range(columns.shape[1]):
        at = min(bins[i], len(count) - 1)
        if at >= 0:
            count[at] += 1.0
            for j in range(columns.shape[0]):
                sums[j, at] += columns[j, i]


@compiled
def add_squares(columns: Array, readings: int, bins: NDArray[np.int64], means: Array, squares: Array) -> None:
    """Add to the sums of squares about the means, (2 + k, b), by bin: shape (3 + 2 readings, b).

    Of temperature, time, temperature with time, each reading, and temperature with each reading.
    """
    for i in range(columns.shape[1]):
        at = min(bins[i], means.shape[1] - 1)
        if at >= 0:
            warm, time = columns[0, i] - means[0, at], columns[1, i] - means[1, at]
            squares[0, at] += warm * warm
            squares[1, at] += time * time
            squares[2, at] += warm * time
            for j in range(readings):
                own = columns[2 + j, i] - means[2 + j, at]
                squares[3 + j, at] += own * own
                squares[3 + readings + j, at] += warm * own
