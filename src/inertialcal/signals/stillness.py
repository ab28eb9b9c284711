"""Disturbances in a recording of a sensor at rest: stretches that its own noise does not explain.

Level and scatter are taken per block (median and median absolute deviation), so that a slow drift is no
disturbance and a short disturbance does not hide itself. Samples further from the level than seven standard
deviations belong to a disturbance if at least five of them lie within a block length of each other; a
single spike is none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.estimate import Array

BLOCKS = 60
SMALLEST_BLOCK = 50  # samples
SIGMAS = 7.0
FEWEST = 5  # samples of a disturbance
MAD_TO_SIGMA = 1.4826
QUIET = 0.25  # quantile of the blocks' scatter that stands for the noise at rest
MOVING_SHARE = 0.25  # share of blocks off the common level or scatter from which nothing is at rest


@dataclass(frozen=True)
class Disturbance:
    """First and last sample, and the largest deviation in standard deviations of the noise."""

    first: int
    last: int
    peak: float


@dataclass(frozen=True)
class Stillness:
    """Whether a channel is at rest at all, and where it is disturbed."""

    at_rest: bool
    disturbances: tuple[Disturbance, ...]


def judge(values: Array, floor: float = 0.0) -> Stillness | None:
    """Return where a channel is disturbed, or None where it is too short to tell.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Finite, evenly sampled, in any unit.
    floor : float
        Smallest standard deviation that the noise may have: the resolution step.
    """
    size = max(SMALLEST_BLOCK, len(values) // BLOCKS)
    count = len(values) // size
    if count < 4:
        return None
    blocks = values[: count * size].reshape(count, size)
    level = np.median(blocks, axis=1)
    scatter = MAD_TO_SIGMA * np.median(np.abs(blocks - level[:, None]), axis=1)
    sigma = max(float(np.quantile(scatter, QUIET)), floor)
    if sigma == 0.0:
        return None
    residual = np.abs(values - np.interp(np.arange(len(values)), (np.arange(count) + 0.5) * size, level))
    stretches = _stretches(residual > SIGMAS * sigma, size)
    # A step of the level within one block is motion; a drift moves less than the noise from block to block.
    moved = (scatter > 3.0 * sigma) | (np.abs(np.diff(level, prepend=level[0])) > SIGMAS * sigma)
    found = tuple(Disturbance(a, b, float(residual[a : b + 1].max()) / sigma) for a, b in stretches)
    return Stillness(bool(moved.mean() < MOVING_SHARE), found)


def _stretches(outside: np.ndarray[tuple[int], np.dtype[np.bool_]], reach: int) -> list[tuple[int, int]]:
    """First and last index of each group of marked samples no further apart than ``reach``."""
    at = np.flatnonzero(outside)
    if not len(at):
        return []
    cuts = np.flatnonzero(np.diff(at) > reach) + 1
    groups = np.split(at, cuts)
    return [(int(group[0]), int(group[-1])) for group in groups if len(group) >= FEWEST]
