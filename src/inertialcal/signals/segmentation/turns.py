"""Turns of a triaxial head found in its own record, or given by the user: a selection from the one detector.

The record is reduced to blocks once (``block_statistics``). Block means, and the cube roots of block variances, which
are nearly normal [1]_, go through ``segments.detect``; a place where it sees no rest, and where a sample lies further
than ``spike`` standard deviations of the quiet samples from the levels around, is a spike. Whoever turns the head, or
pushes at it, leaves one.

A spike is a *turn* if the level after it differs from the level before it in some channel: half a turn changes an axis
by twice the ambient acceleration. How much means are apart that nothing parts is measured on the rest of the record,
slow noise included. A spike whose level returns is crew, or a turn where the ambient acceleration is too small to be
seen: nobody can tell from the record, so it is no turn here, and is remarked. A shift of level without a spike, or one
that takes longer than ``longest``, is no turn either. Turn times that are given settle all this: they are taken as
they are, and the record says only how far each spike reaches.

``turn_windows`` lays quiet windows before and after the turns.

References
----------
.. [1] E. B. Wilson and M. M. Hilferty, PNAS 17 (1931) 684: the cube root of a chi-square variable.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.recording import SECOND, Times
from ...core.remarks import Remark, Severity
from ..time.samples import Flags, Indices
from .block_statistics import Blocks, LevelScatter, Signal, block_statistics, quiet_level
from .segments import Detection, Segmentation, detect

SPIKES = {
    "spike_without_step": "spike with one level before and after: a disturbance, or a turn in almost no acceleration",
    "spike_undecided": "spike too close to other disturbances to read the level before and after",
    "disturbed": "spike with a change of level that is not a turn: too long, or not at the given turn times",
}

FEWEST = 8  # quiet blocks beside a spike from which a level is told

Instant = int | tuple[int, int]  # [ns]


@dataclass(frozen=True)
class TurnPlan:
    """How turns are found, and which windows beside them are quiet.

    Raises
    ------
    PlanError
        If a value is out of range.
    """

    block: float = 1.0  # length of a block [s]
    spike: float = 10.0  # least peak of a turn, in standard deviations of a quiet sample
    # least change of level of a turn, and most that a level may move inside a window, in standard deviations of such
    # differences elsewhere
    step: float = 5.0
    longest: float = 60.0  # longest turn [s]
    settle: float = 10.0  # left out on both sides of a turn: the filter settles, hands let go [s]
    # length of the windows before and after a turn, the same for both [s]; as long as it is quiet by default
    window: float | None = None
    # shortest, widest: least and greatest length where none is stated; levels beside a spike are means over the least
    # [s]
    shortest: float = 30.0
    widest: float = 600.0
    # most by which the variance of one half of a window, or of one window, may exceed that of the other
    variance_ratio: float = 2.0
    temperature_slope: float = np.inf  # greatest slope of the temperature in a window [degC/s]

    def __post_init__(self) -> None:
        for name in ("block", "spike", "step", "longest", "shortest", "widest", "temperature_slope"):
            if not getattr(self, name) > 0.0:
                raise PlanError(f"{name} {getattr(self, name):g}, need a positive number")
        if not self.settle >= 0.0:
            raise PlanError(f"settle {self.settle:g} s, need 0 or more")
        if not self.variance_ratio > 1.0:
            raise PlanError(f"variance_ratio {self.variance_ratio:g}, need more than 1")
        least = self.shortest if self.window is None else self.window
        if least < 2.0 * self.block or self.widest < self.shortest:
            text = f"windows of {least:g} s, {self.shortest:g} to {self.widest:g} s, of blocks of {self.block:g} s"
            raise PlanError(text, why="a window needs two blocks or more")

    def blocks(self, seconds: float) -> int:
        """Return a length in whole blocks, rounded up."""
        return int(np.ceil(seconds / self.block - 1e-9))


@dataclass(frozen=True, eq=False)
class Turn:
    """A turn of the head, or a spike that may be one."""

    # start_ns, stop_ns: first and last of the blocks that the spike reaches into, half-open [ns]; both the instant that
    # was given, where no spike is seen there
    start_ns: int
    stop_ns: int
    # first, stop: the same in blocks
    first: int
    stop: int
    peak: float  # furthest sample from the level around, in standard deviations of a quiet sample
    step: Array  # level after less level before [unit of the signal]; NaN where one is not there, shape (channels,)
    # largest of the steps, in standard deviations of such differences elsewhere; NaN where none is there
    significance: float
    given: bool = False  # whether the user said that it is one


@dataclass(frozen=True, eq=False)
class Turns:
    """Turns of a record."""

    turns: tuple[Turn, ...]  # in order of time
    others: tuple[Turn, ...]  # spikes that are not taken for turns
    blocks: Blocks  # the record
    quiet: Flags  # full blocks in which nothing moves, shape (b,)
    segmentation: Segmentation  # what the detector found in the full blocks
    plan: TurnPlan  # what it was found with

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Spikes that are no turns, as far as the record tells; turns that are given and leave none."""
        found = []
        groups: dict[str, list[Turn]] = {}
        for one in self.others:
            stepped = one.significance > self.plan.step
            kind = "disturbed" if stepped else "spike_without_step" if one.significance >= 0.0 else "spike_undecided"
            groups.setdefault(kind, []).append(one)
        do = "If the head was turned there, give the turn times"
        for kind, group in groups.items():
            severity: Severity = "warning" if kind == "disturbed" else "info"
            found.append(Remark(kind, severity, SPIKES[kind], _clock(group[0], self), len(group), do))
        missing = [one for one in self.turns if one.given and one.first == one.stop]
        if missing:
            text, do = "no spike where the head was turned", "Check that the turn times are on the clock of the record"
            found.append(Remark("turn_not_seen", "warning", text, _clock(missing[0], self), len(missing), do))
        return tuple(found)


def find_turns(
    signal: Signal | Blocks,
    time_ns: Times | None = None,
    sample_interval: float | None = None,
    *,
    plan: TurnPlan | None = None,
    given_ns: Sequence[Instant] | None = None,
) -> Turns:
    """Find the turns of a head in a record.

    Parameters
    ----------
    signal : ndarray, shape (n,) or (n, channels), a sequence of ndarray, shape (n,), or Blocks
        Readings of the axes in any unit, of any type of number; blocks of them as they are.
    time_ns : ndarray of int64, shape (n,), optional
        Stamps, not descending [ns].
    sample_interval : float, optional
        From sample to sample [s], where there are no stamps.
    plan : TurnPlan, optional
        Default settings if absent.
    given_ns : sequence of int or (int, int), optional
        When the head was turned: instants, or start and stop [ns]. Then no other place is a turn.

    Raises
    ------
    DataError
        If the time does not fit, a channel has no values or the record is too short, or a turn time lies outside.
    """
    plan = plan or TurnPlan()
    blocks = signal if isinstance(signal, Blocks) else block_statistics(signal, plan.block, time_ns, sample_interval)
    full = np.flatnonzero(blocks.full)
    found = _moving(blocks, full)
    quiet = np.zeros(len(blocks), dtype=bool)
    quiet[full] = np.repeat(found.still, found.stop - found.start) & ~found.samples.outlier
    peak = peaks(blocks, full, found, quiet)
    scatter = LevelScatter(blocks, quiet).of(plan.blocks(plan.shortest), 2 * plan.blocks(plan.settle))
    look = _Look(blocks, quiet, peak, scatter, plan)
    spikes = clusters(blocks, (peak >= plan.spike) & ~quiet, plan.blocks(plan.settle))
    every = [look.measured(*narrowed(peak, *one)) for one in spikes]
    if given_ns is None:
        turns = [one for one in every if one.significance > plan.step and one.stop - one.first <= look.longest]
    else:
        turns = sorted((look.given(one, every) for one in given_ns), key=lambda one: one.start_ns)
    taken = {(one.first, one.stop) for one in turns}
    others = tuple(one for one in every if (one.first, one.stop) not in taken)
    return Turns(tuple(turns), others, blocks, quiet, found, plan)


def _moving(blocks: Blocks, full: Indices) -> Segmentation:
    """Still and moving stretches of the block means and of the cube roots of the variances."""
    if not len(full):
        raise DataError("no block holds samples of every channel", code="too_short")
    signal = np.hstack([blocks.mean[full], np.cbrt(blocks.variance[full])])
    return detect(signal, blocks.time_ns[full], blocks.length, Detection())


@dataclass(frozen=True, eq=False)
class _Look:
    """What the blocks of a record tell of a place in it: `peaks`, and the scatter of levels beside each other."""

    blocks: Blocks
    quiet: Flags
    peak: Array
    scatter: Array
    plan: TurnPlan

    @property
    def longest(self) -> int:
        """Blocks that the longest turn reaches into."""
        return self.plan.blocks(self.plan.longest) + 1

    def measured(self, first: int, stop: int) -> Turn:
        """Return the blocks [first, stop) as a spike, with the levels on both sides of it."""
        blocks, plan = self.blocks, self.plan
        begin, end = int(blocks.at[first]), int(blocks.at[stop - 1]) + 1
        gap, w = plan.blocks(plan.settle), plan.blocks(plan.shortest)
        walls = (self.peak >= plan.spike) & ~self.quiet
        after, n = quiet_level(blocks, self.quiet, end + gap, 1, w, walls)
        before, m = quiet_level(blocks, self.quiet, begin - gap, -1, w, walls)
        step = after - before if min(n, m) >= FEWEST else np.full(len(before), np.nan)
        ratio = np.abs(step) / (self.scatter * np.sqrt(max(w / max(min(n, m), 1), 1.0)))
        significance = float(np.nanmax(ratio)) if np.isfinite(ratio).any() else float("nan")
        start_ns, stop_ns = (blocks.start_ns + at * blocks.length_ns for at in (begin, end))
        return Turn(start_ns, stop_ns, first, stop, float(self.peak[first:stop].max()), step, significance)

    def given(self, when: Instant, spikes: Sequence[Turn]) -> Turn:
        """Return the turn of a time that was given: of an instant, as long as the spike that is seen there."""
        start_ns, stop_ns = when if isinstance(when, tuple) else (when, when)
        first, stop = self._blocks(start_ns, stop_ns)
        slack = self.blocks.length_ns
        near = [one for one in spikes if one.start_ns <= stop_ns + slack and start_ns <= one.stop_ns + slack]
        if isinstance(when, tuple):
            stop = max(stop, first + 1)
            return replace(self.measured(first, stop), start_ns=start_ns, stop_ns=stop_ns, given=True)
        if near:
            return replace(max(near, key=lambda one: one.peak), given=True)
        spike = self.measured(first, first + 1)
        return replace(spike, start_ns=when, stop_ns=when, stop=first, given=True)

    def _blocks(self, start_ns: int, stop_ns: int) -> tuple[int, int]:
        """Blocks [first, stop) that a time reaches into."""
        blocks = self.blocks
        if stop_ns < start_ns:
            raise PlanError(f"turn from {start_ns} to {stop_ns} ns ends before it starts")
        end_ns = blocks.start_ns + int(blocks.at[-1] + 1) * blocks.length_ns
        if stop_ns <= blocks.start_ns or start_ns >= end_ns:
            why = f"the record runs from {blocks.start_ns} to {end_ns} ns"
            raise DataError(f"turn at {start_ns} ns lies outside the record", why=why, code="turn_outside")
        a, b = (stamp - blocks.start_ns for stamp in (start_ns, stop_ns))
        first, stop = np.searchsorted(blocks.at, (a // blocks.length_ns, -(-b // blocks.length_ns)))
        return min(int(first), len(blocks) - 1), int(stop)


def _clock(one: Turn, found: Turns) -> str:
    return f"{(one.start_ns - found.blocks.start_ns) / SECOND:.0f} s after the start"


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
