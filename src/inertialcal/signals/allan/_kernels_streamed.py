"""Compiled loops over a part of the integrated signal at a time: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered
from ._kernels import BLOCK, _add

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
