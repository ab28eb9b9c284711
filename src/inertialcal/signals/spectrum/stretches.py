"""Segments of a record with gaps: equally long ones, laid into every stretch in which no sample is missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Stretches:
    """Runs of samples that all have a value."""

    # start, stop: half-open, ascending, shape (k,)
    start: Indices
    stop: Indices
    missing: int  # samples in none of them

    @property
    def longest(self) -> int:
        """Samples of the longest one; 0 where there is none."""
        return int((self.stop - self.start).max(initial=0))

    def held(self, segment: int) -> int:
        """Count samples in stretches that hold a segment of that length."""
        length = self.stop - self.start
        return int(length[length >= segment].sum())

    def starts(self, segment: int, step: int) -> list[Indices]:
        """First samples of the segments of each stretch that holds one, every ``step`` samples."""
        pairs = zip(self.start, self.stop, strict=True)
        return [np.arange(a, b - segment + 1, step, dtype=np.int64) for a, b in pairs if b - a >= segment]


def stretches_of(x: Array) -> Stretches:
    """Return the runs of samples that have a finite value in every axis.

    Parameters
    ----------
    x : ndarray, shape (n, axes)
        May hold NaN.
    """
    good = np.isfinite(x).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], good, [False])).astype(np.int8)))
    return Stretches(edges[0::2], edges[1::2], int(np.count_nonzero(~good)))
