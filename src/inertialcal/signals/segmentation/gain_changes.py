"""Changes of gain inside a record: level and scatter of a channel change by one factor.

A selection from what the one detector finds in the logarithms of block means and block variances: there a gain is a
shift, whatever the noise on both sides. An acceleration changes the level and leaves the scatter; a vibration the other
way round; both are no change of gain. A channel can be judged only where it has a level: a block mean beyond its
standard deviation; near zero the factor of a level says little, so both have to be much the same. Of a stretch most
blocks must have a level: where few have one, as in a shaken turn, they are those whose level happens to be large.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .block_statistics import Blocks
from .noise_scale import BLOCK
from .segments import detect

LEAST = 1.5  # factor that is seen
ALIKE = 0.5  # of the logarithm of one factor, the other one
MOST = 0.5  # of the blocks of a stretch, that have a level
APART = 10  # blocks between two stretches that can still be neighbours


@dataclass(frozen=True)
class GainChange:
    """Where the gain of a channel changes [ns], and by which factor its level and its scatter do."""

    channel: int
    time_ns: int
    level: float
    scatter: float


def gain_changes(blocks: Blocks) -> tuple[GainChange, ...]:
    """Return the changes of gain in a record, channel by channel, in order of time."""
    full = np.flatnonzero(blocks.full)
    found = []
    for channel in range(blocks.mean.shape[1]):
        level, spread = np.abs(blocks.mean[full, channel]), np.sqrt(blocks.variance[full, channel])
        judged = (level > spread) & (spread > 0.0)
        if np.count_nonzero(judged) < 2 * BLOCK:
            continue
        rows = full[judged]
        seg = detect(np.log(np.column_stack([level, spread])[judged]), blocks.time_ns[rows], blocks.length)
        still = np.flatnonzero(seg.still)
        places = np.flatnonzero(judged)
        span = places[seg.stop[still] - 1] - places[seg.start[still]] + 1
        dense = seg.stop[still] - seg.start[still] >= MOST * span
        shift = np.diff(seg.level[still], axis=0)
        last, first = blocks.at[rows[seg.stop[still[:-1]] - 1]], blocks.at[rows[seg.start[still[1:]]]]
        size = np.sort(np.abs(shift), axis=1)
        both = (size[:, 0] > np.log(LEAST)) & (size[:, 0] > ALIKE * size[:, 1]) & (shift[:, 0] * shift[:, 1] > 0.0)
        found += [
            GainChange(channel, blocks.start_ns + int(last[i] + 1) * blocks.length_ns, *np.exp(shift[i]).tolist())
            for i in np.flatnonzero(both & dense[:-1] & dense[1:] & (first - last <= APART))
        ]
    return tuple(found)
