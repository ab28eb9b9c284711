"""Compiled loops over a part of the integrated signal at a time: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered
from ._kernels import BLOCK, _add
from ._kernels_noise_type import FEWEST, LINE, LOOKED_AT, _autocorrelation, _exponent, _remove_line, _stretches

Whole = NDArray[np.int64]


@compiled
def add_near(p: NDArray[Any], stop: int, factors: Whole, order: int, out: Array) -> None:
    """Add the squared differences of an order, 2 or 3, that start before ``stop``; windows lie inside of ``p``."""
    for start in range(0, stop, BLOCK):
        _add(p, start, min(start + BLOCK, stop), factors, order, out)


@reordered
def far_seconds(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], base: Any) -> float:
    """Return the sum of squares of (c - b) - (b - a) + base, of three streams that are each summed from 0 on."""
    total = 0.0
    for i in range(len(c)):
        d = np.float64(a[i] - 2 * b[i] + c[i] + base)
        total += d * d
    return total


@reordered
def far_thirds(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], e: NDArray[Any], base: Any) -> float:
    """Return the same for third differences, of four streams."""
    total = 0.0
    for i in range(len(e)):
        d = np.float64(e[i] - a[i] + 3 * (b[i] - c[i]) + base)
        total += d * d
    return total


@compiled
def places_looked_at(points: int, m: int, out: Whole) -> int:
    """Fill the points that the averages of m samples which identify a noise type begin and end at; return how many."""
    stretches, size, apart = _stretches((points - 1) // m, m)
    found = 0
    for stretch in range(stretches):
        for i in range(size + 1):
            out[found] = stretch * apart + i * m
            found += 1
    return found


@compiled
def identify_at(at: Whole, values: NDArray[Any], points: int, factors: Whole, most: int, out: Array) -> None:
    """Fill what ``identify`` does of a complete record of whose integrated signal ``values`` at ``at`` are known."""
    spare, spare_kept, spare_at = np.empty(2 * LOOKED_AT), np.empty(2 * LOOKED_AT), np.empty(2 * LOOKED_AT)
    for k in range(len(factors)):
        m = factors[k]
        stretches, size, apart = _stretches((points - 1) // m, m)
        n = stretches * (size + 1)
        y, kept, place = spare[:n], spare_kept[:n], spare_at[:n]
        y[:], kept[:], place[:] = 0.0, 0.0, 0.0
        for stretch in range(stretches):
            first = stretch * (size + 1)
            for i in range(size):
                j = stretch * apart + i * m
                place[first + i] = j
                y[first + i] = 1.0 * (values[np.searchsorted(at, j + m)] - values[np.searchsorted(at, j)])
                kept[first + i] = 1.0
        out[k] = np.nan
        shared = stretches if apart < m else 1
        if stretches * size + shared > FEWEST * shared:
            _remove_line(y, kept, place)
            d, r = _autocorrelation(y, kept, most, LINE / ((points - 1) // m))
            out[k] = _exponent(d, r, m)
