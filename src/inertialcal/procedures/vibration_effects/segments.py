"""Levels in a record: blocks of the control acceleration that belong together, rest among them.

The mean square of each block is compared with that of the segment so far; more than `STEP` away, both it and the median
of the three from it on, a new one begins. Blocks on either side of a change hold two levels and are left out; what then
has fewer than `FEWEST` blocks is a ramp or a transient. A segment is rest where its rms is below a share of the
highest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from ...signals.vibration.levels import pieces

STEP = 1.5  # dB by which levels differ
FEWEST = 4  # blocks of a segment
SAME = 0.75  # dB by which segments of one level may differ


@dataclass(frozen=True)
class Segment:
    """Blocks of one level: from the first up to, not with, the last."""

    first: int
    stop: int
    mean_square: float  # Of the control [(m/s^2)^2]
    rest: bool = False
    level: int = 0  # Among those that are not rest, from the lowest; 0 for rest


def segments_of(mean_squares: Array, quiet: float) -> tuple[list[Segment], int]:
    """Return the segments of a record, and how many blocks belong to none, those on either side of a change apart.

    Parameters
    ----------
    mean_squares : ndarray, shape (n,)
        Of the control in each block [(m/s^2)^2].
    quiet : float
        Share of the highest rms below which a segment is rest.
    """
    highest = float(np.max(_smoothed(mean_squares), initial=0.0))
    floor = max(quiet**2 * highest, np.finfo(float).tiny)
    decibel = 10.0 * np.log10(np.maximum(mean_squares, floor))  # rest is one level, however quiet
    found = []
    for first, stop in pieces(decibel, STEP):
        a, b = first + (first > 0), stop - (stop < len(decibel))
        if b - a >= FEWEST:
            found.append(Segment(a, b, float(np.mean(mean_squares[a:b]))))
    used = sum(one.stop - one.first for one in found)
    return _levelled(found, floor), max(len(decibel) - used - 2 * max(len(found) - 1, 0), 0)


def _smoothed(values: Array) -> Array:
    """Return medians of three, so that one loud block is no level."""
    if len(values) < 3:
        return values
    return np.median(np.column_stack([values[:-2], values[1:-1], values[2:]]), axis=1)


def _levelled(found: Sequence[Segment], floor: float) -> list[Segment]:
    """Return segments with their level: those less than `SAME` apart have one."""
    loud = sorted({one.mean_square for one in found if one.mean_square > floor})
    level, last, of = 0, 0.0, dict[float, int]()
    for one in loud:
        if not last or 10.0 * np.log10(one / last) > SAME:
            level, last = level + 1, one
        of[one] = level
    return [
        Segment(one.first, one.stop, one.mean_square, one.mean_square <= floor, of.get(one.mean_square, 0))
        for one in found
    ]
