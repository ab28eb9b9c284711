"""Levels of quiet blocks, and how much they differ where nothing happens between: what a step is held against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from ..time.samples import Flags
from .block_statistics import Blocks

FEWEST = 16  # places from which a scatter can be told
NORMAL = 0.6744897501960817  # median of |x| for unit normal x


@dataclass(frozen=True, eq=False)
class LevelScatter:
    """How much means of w blocks differ where nothing happens between, slow noise included."""

    blocks: Blocks
    quiet: Flags

    def of(self, w: int, gap: int) -> Array:
        """Return the standard deviation of the difference of two means of w blocks, ``gap`` blocks apart.

        From as many undisturbed places as the record has; where they are fewer than 16, of means over shorter windows,
        which is no smaller, down to single blocks; infinite where that fails too.

        Returns
        -------
        ndarray, shape (channels,)
        """
        rows = np.flatnonzero(self.quiet)
        mean = self.blocks.mean[rows]
        mean = mean - np.median(mean, axis=0) if len(rows) else mean
        total = np.vstack([np.zeros(mean.shape[1]), np.cumsum(mean, axis=0)])
        at = self.blocks.at[rows]
        while w >= 1:
            span = 2 * w + gap
            begin = np.arange(0, max(len(rows) - span + 1, 0), max(w // 2, 1))
            begin = begin[at[begin + span - 1] - at[begin] == span - 1] if len(begin) else begin
            if len(begin) >= FEWEST:
                left = total[begin + w] - total[begin]
                right = total[begin + span] - total[begin + w + gap]
                scatter = np.median(np.abs(right - left), axis=0) / (w * NORMAL)
                return np.where(scatter > 0.0, scatter, np.inf)
            w //= 2
        return np.full(self.blocks.mean.shape[1], np.inf)


def quiet_level(blocks: Blocks, quiet: Flags, at: int, way: int, w: int, walls: Flags) -> tuple[Array, int]:
    """Return the mean of the quiet blocks beside a place, shape (channels,), and their number.

    Looked at are ``w`` blocks of time from the block ``at`` on, to later (way 1) or to earlier ones (-1), not across
    walls.
    """
    a, b = (int(i) for i in np.searchsorted(blocks.at, (at, at + w) if way > 0 else (at - w, at)))
    hit = np.flatnonzero(walls[a:b])
    if len(hit):
        a, b = (a, a + int(hit[0])) if way > 0 else (a + int(hit[-1]) + 1, b)
    rows = a + np.flatnonzero(quiet[a:b])
    if not len(rows):
        return np.full(blocks.mean.shape[1], np.nan), 0
    return np.asarray(blocks.mean[rows].mean(axis=0)), len(rows)
