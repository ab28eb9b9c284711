"""Still stretches of a signal: from good samples in a row to first and last sample of each.

The noise is measured, single outliers are set aside, the level changes cut the signal into pieces, and a
piece is still if it is long enough, its two halves agree, and it is not louder than the noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.batches import kept, made, release, rows_taken, stacked, where_steps
from ...core.errors import PlanError
from ...core.estimate import Array
from ...statistics.quantiles import t_upper
from ..remembered import remembered
from ..time.samples import LONGEST_GAP, Flags, Indices
from .change_points import (
    SHORTEST,
    covered,
    joined_where_equal,
    level_changes,
    loud,
    settled_ends,
    single_outliers,
    sloping,
    stretches,
)
from .noise_scale import Noise, noise_scale


@dataclass(frozen=True)
class Detection:
    """How still and moving are told apart.

    Raises
    ------
    PlanError
        If a value is out of range.
    """

    false_alarm: float = 0.01  # probability that a record of white noise at a constant level is found to move at all
    shortest: int = SHORTEST  # samples of the shortest still stretch, 12 or more
    # samples of the widest window in which a level is averaged; a change spread over more than twice this counts as
    # drift
    longest_window: int = 32
    # longest stretch without good samples that a still stretch may hold [sample intervals]
    longest_gap: float = LONGEST_GAP
    # standard deviation of a sample at rest, one a channel [unit of the signal]; measured by default. To be stated
    # where a record has no rest from which to measure it
    noise: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.false_alarm < 1.0:
            raise PlanError(f"false_alarm {self.false_alarm:g}, need a probability between 0 and 1")
        if self.shortest < SHORTEST:
            raise PlanError(f"shortest {self.shortest} samples, need {SHORTEST} or more")
        if self.longest_window < 1:
            raise PlanError(f"longest_window {self.longest_window} samples, need 1 or more")
        if not self.longest_gap >= 1.0:
            raise PlanError(f"longest_gap {self.longest_gap:g} sample intervals, need 1 or more")
        if self.noise is not None and not all(sigma > 0.0 for sigma in self.noise):
            raise PlanError(f"noise {self.noise}, need positive standard deviations")

    @property
    def scales(self) -> tuple[int, ...]:
        """Widths of the windows: 1, 2, 4, ... up to the widest [samples]."""
        return tuple(2**k for k in range(self.longest_window.bit_length()))


@dataclass(frozen=True, eq=False)
class Found:
    """What ``still_stretches`` gives, in good samples counted from 0."""

    # start, stop: still stretches, half-open, ascending, shape (k,)
    start: Indices
    stop: Indices
    outlier: Indices  # single outliers inside them, ascending
    noise: Noise  # scatter of a sample where nothing happens
    # by how much more than white noise the means of the widest windows scatter between changes, shape (channels,)
    widening: Array


@remembered
def still_stretches(x: Array, ticks: Array | None, plan: Detection) -> Found:
    """Return the still stretches of good samples (n, channels), n >= 16, at times counted in sample intervals.

    Without ``ticks`` they follow each other without a gap.

    Raises
    ------
    PlanError
        If the noise is stated for another number of channels.
    """
    y = x if x.T.flags.c_contiguous and x.flags.writeable else stacked(list(x.T))
    noise = noise_scale(y, plan.noise)
    # two-sided tail of one comparison of levels, and tail of one variance; each kind has half the risk
    variance_tail = 0.5 * plan.false_alarm / y.size
    quantile = t_upper(variance_tail / (2.0 * (len(plan.scales) + 1)), noise.dof)
    outlier = single_outliers(y, noise, float(quantile.max()), plan.shortest)
    if len(outlier):
        y = stacked(list(x.T)) if y is x else y
        y[outlier] = 0.5 * (rows_taken(y, outlier - 1) + rows_taken(y, outlier + 1))
        release(y)
    # first good sample after each long gap, with 0 and n
    walls = np.array([0, len(y)])
    if ticks is not None:
        walls = np.concatenate(([0], where_steps(ticks, lambda step: step > plan.longest_gap), [len(y)]))
    start, stop, widening = _level_pieces(y, noise, plan, quantile, walls)
    start, stop = _long(*settled_ends(y, noise, start, stop, walls), plan.shortest)
    quantile = quantile * np.maximum(widening, 1.0)
    start, stop = joined_where_equal(y, noise, quantile, start, stop, walls, plan.longest_window)
    short = stop - start < 2 * plan.longest_window  # a longer one would have shown its slope to the windows
    if short.any():
        slope = np.zeros(len(start), dtype=bool)
        slope[short] = sloping(y, noise, quantile, start[short], stop[short])
        start, stop = start[~slope], stop[~slope]
    noisy = loud(y, noise, plan.shortest, variance_tail, start, stop)
    if len(noisy):
        marked = covered(noisy, noisy + plan.shortest, len(y))
        quiet = made(len(y), bool, lambda one, last: ~marked[one:last], marked)
        start, stop = _long(*stretches(start, stop, quiet), plan.shortest)
    inside = np.searchsorted(start, outlier, side="right") > np.searchsorted(stop, outlier, side="right")
    return Found(start, stop, outlier[inside], noise, widening)


def _level_pieces(
    y: Array, noise: Noise, plan: Detection, quantile: Array, walls: Indices
) -> tuple[Indices, Indices, Array]:
    """Pieces between changes of level, long enough to be still; wide windows skip what is cut to shreds."""
    first, widening = level_changes(y, noise, plan.scales[:1], quantile, walls)
    size = np.diff(first)
    enough = size >= plan.shortest
    if not enough.any():
        return first[:0], first[:0], widening()
    begun = first[:-1][enough]
    first = np.concatenate(([0], np.cumsum(size[enough])))  # the cuts, counted in the samples kept
    skipped = begun - first[:-1]  # samples that are not kept before each of them
    cuts = first
    rest = y if enough.all() else _rows(y, covered(begun, begun + size[enough], len(y)))
    if len(plan.scales) > 1:
        first, widening = level_changes(rest, noise, plan.scales[1:], quantile, first)
    own = skipped[np.searchsorted(cuts, first[:-1], side="right") - 1]
    start, stop = _long(first[:-1] + own, first[1:] + own, plan.shortest)
    return start, stop, widening()


def _rows(y: Array, flags: Flags) -> Array:
    """Return the rows that are flagged, shape (k, channels)."""
    return stacked([kept(own, flags) for own in y.T])


def _long(start: Indices, stop: Indices, shortest: int) -> tuple[Indices, Indices]:
    enough = stop - start >= shortest
    return start[enough], stop[enough]
