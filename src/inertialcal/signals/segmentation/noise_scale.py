"""Scatter of a sample where nothing happens, measured on a record in which much may happen.

The variance of blocks of eight samples is pooled over those blocks that agree with the quietest fifth.
So a record that moves half of its time does not raise the noise, and a sensor that is stuck for a while
does not lower it. Where the converter's step hides the noise, half a step stands in for it: a level
between two codes scatters that much.

Arrays are time-first, (n, channels), finite; column-major order is fastest.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, changed, count, empty, kept, near, release
from ...core.batches.summaries import quantile
from ...core.errors import PlanError
from ...core.estimate import Array
from ...statistics.quantiles import chi_square_quantile, chi_square_upper
from ..threads import each_of, shares
from .loops import loops_for

BLOCK = 8  # samples: long enough for a variance, short enough to lie inside a dwell of 30
QUIET = 0.2  # quantile of block variances that is taken as quiet at first: 4 of 5 blocks may move
QUIET_TAIL = 1e-3  # part of the quiet blocks that clipping leaves out
LIVE = 5  # of the 7 differences in a block are not zero, or the converter's step hides the noise
LIVE_BLOCKS = 0.05  # part of the blocks that must be live
ROUNDS = 50
KNOWN = 1e6  # degrees of freedom of what is stated


@dataclass(frozen=True, eq=False)
class Noise:
    """Scatter per channel where nothing happens."""

    scale: Array  # standard deviation of a sample, at least half a step [unit of the signal], shape (channels,)
    dof: Array  # degrees of freedom of ``scale``, shape (channels,)
    # smallest difference, other than zero, between two neighbouring samples [unit of the signal], shape (channels,)
    step: Array
    # whether the noise is larger than half a step, so that many equal neighbours mean a stuck sensor, shape (channels,)
    live: NDArray[np.bool_]
    stated: bool = False  # whether it was stated, not measured

    @property
    def feigned(self) -> Array:
        """Difference of two levels that quantisation can feign, shape (channels,): a step, or 0 where live."""
        return np.where(self.live, 0.0, self.step)


def noise_scale(y: Array, stated: tuple[float, ...] | None = None) -> Noise:
    """Return the scatter of the quiet part of a signal (n, channels), n >= 16, or the stated one.

    Raises
    ------
    PlanError
        If another number of values is stated than there are channels.
    """
    if stated is not None and len(stated) != y.shape[1]:
        raise PlanError(f"{len(stated)} value(s) of noise stated for {y.shape[1]} channel(s)")
    scale, step = np.empty((2, y.shape[1]))
    dof, live = np.full(y.shape[1], KNOWN), np.ones(y.shape[1], dtype=bool)
    for k in range(y.shape[1]):
        variance, different, step[k] = _blocks(y[:, k])
        alive = changed(different, lambda part: part >= LIVE, bool)
        living = count(alive, lambda part: part)
        if stated is not None:
            scale[k] = stated[k]
        elif living < max(2.0, LIVE_BLOCKS * len(alive)):
            scale[k], dof[k], live[k] = 0.0, (BLOCK - 1) * len(alive), False
        else:
            pooled, quiet = _pool_quiet(kept(variance, alive))
            scale[k], dof[k] = np.sqrt(pooled), quiet * (BLOCK - 1)
    return Noise(np.maximum(scale, 0.5 * step), dof, step, live & (scale >= 0.5 * step), stated is not None)


def _blocks(y: Array) -> tuple[Array, NDArray[np.int64], float]:
    """Variances of blocks, differences in each that are not zero, smallest of all that is not; 0 if all are."""
    size = len(y) // BLOCK
    variance, different = empty(size, np.float64), empty(size, np.int64)
    fill_blocks = loops_for(len(y)).fill_blocks

    def step_of(share: tuple[int, int]) -> float:
        first, stop = share
        own = slice(first // BLOCK, stop // BLOCK)
        step = float(fill_blocks(y[first : stop + 1], BLOCK, variance[own], different[own]))
        for one in (y[first:stop], variance[own], different[own]):
            release(one)
        return step

    steps = [step for step in each_of(step_of, shares(len(y)), len(y)) if step > 0.0]
    return variance, different, min(steps, default=0.0)


@cache
def of_quiet_blocks() -> tuple[float, float]:
    """Return the largest variance of a block that counts as quiet, and the first quantile, of those of unit noise."""
    dof = BLOCK - 1
    return float(chi_square_upper(QUIET_TAIL, dof)) / dof, float(chi_square_quantile(QUIET, dof)) / dof


def _pool_quiet(variance: Array) -> tuple[float, int]:
    """Mean variance of the quiet blocks, and their number."""
    limit, usual = of_quiet_blocks()
    pooled = quantile(variance, QUIET) / usual
    many = 0
    for _ in range(ROUNDS):
        now, total = 0, 0.0
        for first, stop in batches(variance, size=near()):
            part = variance[first:stop]
            quiet = part <= limit * pooled
            now, total = now + int(np.count_nonzero(quiet)), total + float(np.sum(np.where(quiet, part, 0.0)))
        if now in (0, many):  # as many blocks are the same blocks: those below a limit
            break
        many, pooled = now, total / now
    return pooled, max(1, many)
