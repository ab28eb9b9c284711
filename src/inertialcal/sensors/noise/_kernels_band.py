"""Compiled search of a low pass: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import scored


@compiled
def cost_at(behind: Array, density: Array, weight: Array, costs: Array, i: int) -> float:
    """Return the least cost of columns behind a size of low pass, filled in where it is not known (NaN)."""
    if np.isnan(costs[i]):
        costs[i] = scored(behind[i], density, weight, -1, 0.0, np.zeros(behind.shape[2]), False)
    return float(costs[i])


@compiled
def cost_each(behind: Array, density: Array, weight: Array, costs: Array) -> None:
    """Fill the least cost behind each size, those that are not known (NaN)."""
    for i in range(len(costs)):
        cost_at(behind, density, weight, costs, i)


@compiled
def lowest(
    behind: Array, density: Array, weight: Array, none: int, coarse: int, plain: float, doubtful: float, costs: Array
) -> int:
    """Return the size of least cost, filling the costs of those that are tried, of the first ``none`` among them.

    Every ``coarse`` size is tried, then all about the best; all where twice the gain over ``plain`` is doubtful.
    """
    best = 0
    for i in range(len(costs)):
        if (i < none or i % coarse == 0) and cost_at(behind, density, weight, costs, i) < costs[best]:
            best = i
    while True:
        first, near = max(best - coarse, 0), max(best - coarse, 0)
        for i in range(first, min(best + coarse + 1, len(costs))):
            if cost_at(behind, density, weight, costs, i) < costs[near]:
                near = i
        if near == best:
            break
        best = near
    if 2.0 * (plain - costs[best]) >= doubtful:
        cost_each(behind, density, weight, costs)
        best = 0
        for i in range(len(costs)):
            if costs[i] < costs[best]:
                best = i
    return best
