"""Spikes of a record: blocks in which samples lie far from the levels that the one detector finds around them."""

from __future__ import annotations

import numpy as np

from ..core.estimate import Array
from .segmentation.block_statistics import Blocks
from .segmentation.segments import Segmentation
from .time.samples import Flags, Indices

INSIDE = 0.03  # of the peak of a spike: what is below is no part of it


def peaks(blocks: Blocks, full: Indices, found: Segmentation, quiet: Flags) -> Array:
    """Return the furthest sample of each block from the level around, (b,), in standard deviations of a quiet sample.

    In a stretch that is not still, the nearer one of the levels before and after counts: a step alone is no spike.
    """
    k = blocks.mean.shape[1]
    still = np.flatnonzero(found.still)
    peak = np.zeros(len(blocks))
    if not len(still):
        return peak
    sigma = np.sqrt(np.median(blocks.variance[quiet], axis=0)) if quiet.any() else np.zeros(k)
    sigma = np.where(sigma > 0.0, sigma, np.inf)
    number = np.repeat(np.arange(len(found)), found.stop - found.start)
    after = np.minimum(np.searchsorted(still, number), len(still) - 1)
    before = np.where(still[after] == number, after, np.maximum(after - 1, 0))
    nearest = np.full(len(full), np.inf)
    for level in (found.level[still[before], :k], found.level[still[after], :k]):
        off = np.maximum(blocks.hi[full] - level, level - blocks.lo[full]) / sigma
        nearest = np.minimum(nearest, off.max(axis=1))
    peak[full] = nearest
    return peak


def clusters(blocks: Blocks, hot: Flags, apart: int) -> list[tuple[int, int]]:
    """Return spikes [first, stop) in blocks; what is nearer together than ``apart`` blocks is one."""
    at = np.flatnonzero(hot)
    if not len(at):
        return []
    new = np.flatnonzero(np.diff(blocks.at[at]) > max(apart, 1))
    first, last = at[np.concatenate(([0], new + 1))], at[np.concatenate((new, [len(at) - 1]))]
    return [(int(a), int(b) + 1) for a, b in zip(first, last, strict=True)]


def narrowed(peak: Array, first: int, stop: int) -> tuple[int, int]:
    """Return the part of a spike that is above 3 % of its peak: a knock beside a turn does not make it longer."""
    strong = np.flatnonzero(peak[first:stop] >= INSIDE * peak[first:stop].max())
    return first + int(strong[0]), first + int(strong[-1]) + 1
