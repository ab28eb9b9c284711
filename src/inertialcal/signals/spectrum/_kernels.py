"""Compiled loops of long transforms: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled


@compiled
def fill_pair(one: Array, other: Array, levels: Array, weights: Array, pair: Array) -> None:
    """Fill two real signals, each less its level and weighted, as real and imaginary parts in turn."""
    first, second = levels[0], levels[1]
    for i in range(len(weights)):
        pair[2 * i] = (one[i] - first) * weights[i]
        pair[2 * i + 1] = (other[i] - second) * weights[i]


@compiled
def add_power(values: NDArray[np.complex128], power: Array) -> None:
    """Add the squared magnitudes of complex values."""
    for i in range(len(values)):
        power[i] += values[i].real * values[i].real + values[i].imag * values[i].imag
