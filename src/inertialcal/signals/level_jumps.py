"""Jumps of level that no turn explains: a gain or range that changes, a column that is exchanged inside a record.

A selection from what the one detector found in the blocks of a record (``turns``): two still stretches beside each
other whose levels differ by more than ``spike`` standard deviations of a quiet sample, away from every turn. Beside the
levels stands the scatter: a gain changes both by one factor, an acceleration only the level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.estimate import Array
from .samples import Flags
from .turns import Turns


@dataclass(frozen=True, eq=False)
class Jump:
    """One jump.

    Parameters
    ----------
    time_ns : int
        Where the level before it ends [ns].
    channels : ndarray of bool, shape (channels,)
        Which ones jump.
    before, after : ndarray, shape (channels,)
        Levels [unit of the signal].
    scatter_ratio : ndarray, shape (channels,)
        Standard deviation of a sample after it over that before it; NaN where there was none.
    """

    time_ns: int
    channels: Flags
    before: Array
    after: Array
    scatter_ratio: Array


def level_jumps(turns: Turns) -> tuple[Jump, ...]:
    """Return the jumps of a record, in order of time."""
    blocks, found, plan = turns.blocks, turns.segmentation, turns.plan
    k = blocks.mean.shape[1]
    full = np.flatnonzero(blocks.full)
    still = np.flatnonzero(found.still)
    if len(still) < 2:
        return ()
    sigma = np.sqrt(np.median(blocks.variance[turns.quiet], axis=0))
    stops, starts = full[found.stop[still[:-1]] - 1], full[found.start[still[1:]]]  # last and first block
    near = blocks.at[starts] - blocks.at[stops] <= plan.blocks(plan.settle)
    level = found.level[still, :k]
    jumped = np.abs(np.diff(level, axis=0)) > plan.spike * sigma
    jumps = []
    for i in np.flatnonzero(near & jumped.any(axis=1)):
        end_ns, begin_ns = (blocks.start_ns + int(blocks.at[b]) * blocks.length_ns for b in (stops[i] + 1, starts[i]))
        slack = plan.blocks(plan.settle) * blocks.length_ns
        if any(one.start_ns - slack <= begin_ns and end_ns <= one.stop_ns + slack for one in turns.turns):
            continue
        spread = found.level[still[i : i + 2], k:] ** 1.5  # cube root of a variance to standard deviation
        ratio = np.divide(spread[1], spread[0], out=np.full(k, np.nan), where=spread[0] > 0.0)
        jumps.append(Jump(end_ns, jumped[i], level[i], level[i + 1], ratio))
    return tuple(jumps)
