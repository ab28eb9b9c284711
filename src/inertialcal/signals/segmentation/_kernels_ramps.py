"""Means of blocks of a temperature, and where these turn: compiled loops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled


@compiled
def add_levels(
    x: Array, first: int, size: int, held: NDArray[np.int64], level: Array, begins: NDArray[np.int64]
) -> None:  # fmt: skip
    """Fill in the means of blocks of so many finite samples, and the first sample of each, of a batch.

    ``held`` is how many blocks are full, and how many samples the next one has, whose sum its level is.
    """
    at, inside = held[0], held[1]
    for i in range(len(x)):
        if np.isfinite(x[i]):
            if inside == 0:
                begins[at] = first + i
                level[at] = 0.0
            level[at] += x[i]
            inside += 1
            if inside == size:
                level[at] /= size
                at += 1
                inside = 0
    held[0], held[1] = at, inside


@compiled
def fill_turns(
    level: Array, reversal: float, near: float, turns: NDArray[np.int64], ways: NDArray[np.int64]
) -> int:  # fmt: skip
    """Fill in where each ramp begins and which way it goes, 1 or -1; return how many there are.

    A ramp is seen where the level has moved by the reversal from its turn; it begins where the level was last near it.
    """
    count, at, way = 0, 0, 0
    while True:  # from where one ramp is seen to where the next one is
        low, high, seen = at, at, -1
        for i in range(at, len(level)):
            if level[i] < level[low]:
                low = i
            if level[i] > level[high]:
                high = i
            if way != 1 and level[i] - level[low] >= reversal:
                turn, way, seen = low, 1, i
                break
            if way != -1 and level[high] - level[i] >= reversal:
                turn, way, seen = high, -1, i
                break
        if seen < 0:
            return count
        begin = turn
        for i in range(turn, seen):
            if abs(level[i] - level[turn]) <= near:
                begin = i
        turns[count], ways[count] = begin, way
        count += 1
        at = seen


@compiled
def fill_path(x: Array, level: float, way: int, reversal: float, path: NDArray[np.int8]) -> None:
    """Fill in which samples of a ramp lie the reversal or more from the level of its turn: its way, else 0."""
    for i in range(len(x)):
        path[i] = way if way * (x[i] - level) >= reversal else 0
