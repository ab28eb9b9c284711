"""Compiled loops over a spectrum: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered

Whole = NDArray[np.int64]
NONE = 1e-20  # correlation that is rounding
PART = 2048  # frequencies whose products lie in the nearest cache


@compiled
def sums_of_windows(
    level: Array, fourth: Array, order: Whole, m: Whole, neighbours: Array, sums: Array, spread: Array
) -> None:
    """Fill the sum of level times sin^4(pi order m / n) / m^2 for each m, and the variance of such a sum, unscaled.

    ``fourth`` (n): of sin^4(pi k / n); ``neighbours``: correlation of values so many places apart, 1 first.
    """
    n, lags = len(fourth), min(len(neighbours), len(level))
    while lags > 1 and abs(neighbours[lags - 1]) < NONE:
        lags -= 1
    parts = np.empty(PART + lags)
    for i in range(len(m)):
        total, squares = 0.0, 0.0
        held = 0  # products of the frequencies before, that those of the next still meet
        share = 1.0 / (1.0 * m[i] * m[i])
        for first in range(0, len(level), PART):
            stop = min(first + PART, len(level))
            _fill_products(level[first:stop], fourth, order[first:stop], m[i] % n, share, parts[held:])
            own = parts[held : held + stop - first]
            total += _sum(own)
            squares += _product(own, own)
            for lag in range(1, lags):
                begin = max(held, lag)
                end = held + stop - first
                squares += 2.0 * neighbours[lag] * _product(parts[begin:end], parts[begin - lag : end - lag])
            kept = min(lags, held + stop - first)
            for j in range(kept):
                parts[j] = parts[held + stop - first - kept + j]
            held = kept
        sums[i], spread[i] = total, squares


@compiled
def _fill_products(level: Array, fourth: Array, order: Whole, step: int, share: float, out: Array) -> None:
    """Fill level times fourth at order times a step, modulo its length, times a share.

    Where orders follow each other, four places go ahead at a time: none waits for the one before it.
    """
    n, many = len(fourth), len(level)
    if many == 0 or order[many - 1] - order[0] != many - 1:
        for k in range(many):
            out[k] = level[k] * fourth[order[k] % n * step % n] * share
        return
    a = order[0] % n * step % n
    b, by = (a + step) % n, 4 * step % n
    c, d = (b + step) % n, (b + 2 * step) % n
    for i in range(many // 4):
        k = 4 * i  # the nearer half of the table is read alone: sines are alike from both ends
        out[k] = level[k] * fourth[min(a, n - a)] * share
        out[k + 1] = level[k + 1] * fourth[min(b, n - b)] * share
        out[k + 2] = level[k + 2] * fourth[min(c, n - c)] * share
        out[k + 3] = level[k + 3] * fourth[min(d, n - d)] * share
        a, b, c, d = a + by, b + by, c + by, d + by
        a -= n * (a >= n)
        b -= n * (b >= n)
        c -= n * (c >= n)
        d -= n * (d >= n)
    for k in range(many // 4 * 4, many):
        out[k] = level[k] * fourth[a] * share
        a = (a + step) % n


@reordered
def _sum(a: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i]
    return total


@reordered
def _product(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total
