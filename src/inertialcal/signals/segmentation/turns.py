"""Turns of a triaxial head found in its own record.

The record is reduced to blocks once (``block_statistics``). Turns are changes of level (``level_changes``): half a turn
changes an axis by twice the ambient acceleration, and each dwell counts with all of its length. How far the level
wanders by itself, by 1/f noise or a drift, is estimated with them. Block means, and the cube roots of block variances,
which are nearly normal [1]_, go through ``segments.detect`` as well: it says which blocks are quiet. Where it sees no
rest, and a sample lies further than ``spike`` standard deviations of the quiet samples from the levels around, is a
spike: whoever turns the head, or pushes at it, leaves one, and so does the head where it is not in the axis.

What counts as a turn:

- Two or more changes that go to and fro between two levels, with spikes or without.
- A change with a spike. Changes of level without one beside them are no turns (``shifts``): a bias that jumped, say.
- A single change without a spike may be either, and changes that do not go to and fro may be turns to other positions:
  ``doubt`` says so, and no turn is returned.
- A spike whose level stays is no turn where the ambient acceleration is seen at other turns, so that a change by it is
  excluded (``certain``); else nobody can tell from the record.

What is assumed: a dwell lasts 150 s or more (70 s between spikes), a turn 180 s or less, and the walk of the level is
normal. What breaks it: a bias that jumps there and back by the same amount, without a spike, looks like two turns;
noise that wanders by as much as the ambient acceleration within a turn hides it; shorter dwells are passed over, with
both their turns.

``turn_windows`` lays quiet windows before and after the turns.

References
----------
.. [1] E. B. Wilson and M. M. Hilferty, PNAS 17 (1931) 684: the cube root of a chi-square variable.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ..time.samples import Flags, Indices
from .block_statistics import Blocks, Signal, block_statistics
from .level_changes import (
    APART_AT_SPIKES,
    EDGE,
    LONGEST,
    Change,
    Fit,
    Series,
    at_spike,
    find_changes,
    likely_spikes,
    located,
    steps_at,
)
from .segments import Detection, Segmentation, detect

SAMPLES = 4  # of a block, at least
COARSE, MOST = 5.0, 4000  # least length [s] and most of the blocks in which levels are compared
CALM = 300.0  # length over which a block is compared with its neighbours [s]
FAR = 6.0  # standard deviations at which a block is off its neighbours
LOUD, LOUDER = 1.5, 2.0  # variance over the usual: from which a block weighs less, from which it is shaken
FEWEST, FLAT = 4, 2.5  # blocks of a short dwell, and most that they scatter in standard deviations
MARGIN = 20.0  # left out beside what is off [s]
OPPOSITE, ALIKE = 0.7, 2.0  # cosine, and ratio of sizes, of changes that go to and fro
CLEAR = 0.15  # of a turn's change: the uncertainty with which a change is excluded
# least sum of squares of a turn's steps over their uncertainties: without a spike, or alone; with one
SQUARE, SQUARE_FELT = 40.0, 20.0
SHARP = 45.0  # most uncertainty of the time of a turn without a spike [s]: a wave or a drift is no turn


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
    # most that a level may move inside a window, in standard deviations of such differences elsewhere
    step: float = 5.0
    settle: float = 10.0  # left out on both sides of a turn: the filter settles, hands let go [s]
    # length of the windows before and after a turn, the same for both [s]; as long as it is quiet by default
    window: float | None = None
    # shortest, widest: least and greatest length where none is stated [s]
    shortest: float = 30.0
    widest: float = 600.0
    # most by which the variance of one half of a window, or of one window, may exceed that of the other
    variance_ratio: float = 2.0
    temperature_slope: float = np.inf  # greatest slope of the temperature in a window [degC/s]

    def __post_init__(self) -> None:
        for name in ("block", "spike", "step", "shortest", "widest", "temperature_slope"):
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
    """A turn of the head, a change of level, or a spike."""

    start_ns: int  # half-open [ns]: all that the spike reaches; without one, between them with 95 %
    stop_ns: int
    middle_ns: int
    u: float  # standard uncertainty of the middle [s]
    peak: float  # furthest sample from the level around, in standard deviations of a quiet sample
    step: Array  # level after less level before [unit of the signal], shape (channels,); NaN where not compared
    u_step: Array  # standard uncertainty of it
    felt: bool  # whether a spike goes with it

    @property
    def clear(self) -> bool:
        """Whether the level changes by more than it wanders, and at once where there is no spike."""
        return self.square > SQUARE_FELT if self.felt else self.square > SQUARE and self.u < SHARP

    @property
    def square(self) -> float:
        """Sum of squares of the steps over their uncertainties."""
        return float(np.sum((self.step / np.where(self.u_step > 0.0, self.u_step, np.inf)) ** 2))

    @property
    def significance(self) -> float:
        """Largest step over its uncertainty; NaN where none is there."""
        ratio = np.abs(self.step) / np.where(self.u_step > 0.0, self.u_step, np.nan)
        return float(np.nanmax(ratio)) if np.isfinite(ratio).any() else float("nan")


@dataclass(frozen=True, eq=False)
class Turns:
    """Turns of a record."""

    turns: tuple[Turn, ...]  # in order of time
    others: tuple[Turn, ...]  # spikes that are not taken for turns
    shifts: tuple[Turn, ...]  # changes of level that are not taken for turns
    doubt: str  # why what changes cannot be said to be turns; empty where it is clear
    certain: bool  # whether all spikes without a change are known to be no turns
    blocks: Blocks  # the record
    quiet: Flags  # full blocks in which nothing moves, shape (b,)
    segmentation: Segmentation  # what the detector found in the full blocks
    plan: TurnPlan  # what it was found with
    series: Series  # means in which levels were compared
    fit: Fit  # changes of level

    def excludes(self, low: float, high: float) -> bool:
        """Whether the level excludes a turn from one time to another [s], as turns elsewhere show that one is seen."""
        if any(low - LONGEST < one.middle < high + LONGEST for one in self.fit.changes):
            return False
        return _no_turn(self.series, self.fit, self.turns, np.arange(low, high + 1.0, 60.0))

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Spikes that are no turns, as far as the record tells."""
        found = []
        if self.others:
            what = "spike with one level before and after: a disturbance"
            what += "" if self.certain else ", or a turn in almost no acceleration"
            do = "If the head was turned there, give the windows"
            found.append(Remark("spike_without_step", "info", what, self.clock(self.others[0]), len(self.others), do))
        return tuple(found)

    def clock(self, one: Turn) -> str:
        """Return when a turn is, since the start."""
        return f"{(one.middle_ns - self.blocks.start_ns) / SECOND:.0f} s after the start"


def find_turns(
    signal: Signal | Blocks,
    time_ns: Times | None = None,
    sample_interval: float | None = None,
    *,
    plan: TurnPlan | None = None,
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

    Raises
    ------
    DataError
        If the time does not fit, a channel has no values or the record is too short.
    """
    plan = plan or TurnPlan()
    if isinstance(signal, Blocks):
        blocks = signal
    else:
        blocks = block_statistics(signal, block_length(plan.block, time_ns, sample_interval), time_ns, sample_interval)
    full = np.flatnonzero(blocks.full)
    found = _moving(blocks, full)
    quiet = np.zeros(len(blocks), dtype=bool)
    quiet[full] = np.repeat(found.still, found.stop - found.start) & ~found.samples.outlier
    peak = peaks(blocks, full, found, quiet)
    hot = clusters(blocks, (peak >= plan.spike) & ~quiet, plan.blocks(plan.settle))
    spikes = [_spike(blocks, peak, *narrowed(peak, *one)) for one in hot]
    series, shaken = series_of(blocks, full)
    start = blocks.start_ns
    short = [Change((one.start_ns - start) / SECOND, (one.stop_ns - start) / SECOND) for one in spikes]
    places = [one for one in (*shaken, *short) if one.stop - one.start <= LONGEST + 2.0 * MARGIN]
    series = replace(series, spikes=tuple(joined(places)))
    fit = find_changes(series)
    changes = [_change(blocks, series, fit, i, spikes) for i in range(len(fit.changes))]
    turns, shifts, doubt = _taken(changes)
    taken = [one for one in changes if one.felt]
    others = [
        one for one in spikes if not any(t.start_ns <= one.middle_ns <= t.stop_ns for t in taken)
    ]  # fmt: skip
    # beside a turn the levels before and after both show that there is no other; at the ends there is no dwell beyond
    far = [
        at for at in ((one.middle_ns - start) / SECOND for one in others)
        if series.seconds[0] + EDGE < at < series.seconds[-1] - EDGE
        and all(abs(at - change.middle) >= LONGEST for change in fit.changes)
    ]  # fmt: skip
    certain = not far or _no_turn(series, fit, turns, far)
    return Turns(tuple(turns), tuple(others), tuple(shifts), doubt, certain, blocks, quiet, found, plan, series, fit)


def block_length(least: float, time_ns: Times | None, sample_interval: float | None) -> float:
    """Return the length of blocks that hold enough samples [s]."""
    interval = sample_interval or 0.0
    if time_ns is not None and len(time_ns) > 1:
        interval = (int(time_ns[-1]) - int(time_ns[0])) / SECOND / (len(time_ns) - 1)
    return max(least, SAMPLES * interval)


def _moving(blocks: Blocks, full: Indices) -> Segmentation:
    """Still and moving stretches of the block means and of the cube roots of the variances."""
    if not len(full):
        raise DataError("no block holds samples of every channel", code="too_short")
    signal = np.hstack([blocks.mean[full], np.cbrt(blocks.variance[full])])
    return detect(signal, blocks.time_ns[full], blocks.length, Detection())


def series_of(blocks: Blocks, full: Indices) -> tuple[Series, list[Change]]:
    """Return the means in which levels are compared, and where something shakes the head.

    A block that is off those around weighs nothing, a louder one less.
    """
    from scipy import ndimage  # noqa: PLC0415 - starts slowly

    span = float(blocks.at[-1] + 1) * blocks.length
    many = max(int(np.ceil(max(COARSE, span / MOST) / blocks.length)), 1)
    group = blocks.at[full] // many
    first = np.flatnonzero(np.concatenate(([True], np.diff(group) > 0)))
    at = group[first]
    count = np.add.reduceat(blocks.count[full], first, axis=0)
    means: Array = np.asarray(
        np.add.reduceat(blocks.count[full] * blocks.mean[full], first, axis=0) / count, dtype=float
    )
    variance = np.add.reduceat(blocks.count[full] * blocks.variance[full], first, axis=0) / count
    length = many * blocks.length
    size = 2 * int(0.5 * CALM / length) + 1
    off = np.zeros(len(at), dtype=bool)
    scatter = np.zeros(means.shape[1])
    weight: Array = np.asarray(np.median(count, axis=0) / count, dtype=np.float64)
    for k in range(means.shape[1]):
        away = np.abs(means[:, k] - ndimage.median_filter(means[:, k], size, mode="nearest"))
        scatter[k] = usual = float(np.median(away)) / MAD
        ratio = variance[:, k] / max(float(np.median(variance[:, k])), 1e-300)
        weight[:, k] *= np.where(ratio > LOUD, np.minimum(ratio, 100.0), 1.0)
        many_samples = FAR * np.sqrt(2.0 / np.maximum(count[:, k] - 1, 1))
        off |= (away > FAR * usual) & (usual > 0.0) | (ratio > LOUDER + many_samples)
    _keep_levels(means, off, scatter, int(np.ceil(0.5 * MARGIN / length)))
    lasting = ndimage.binary_opening(off, np.ones(2))
    wide = ndimage.binary_dilation(lasting, np.ones(2 * int(np.ceil(MARGIN / length)) + 1))
    # what is loud for longer than a turn is the cabin: it weighs less, and is kept
    edges = np.flatnonzero(np.diff(np.concatenate(([False], wide | off, [False])).astype(int)))
    seconds: Array = np.asarray((at + 0.5) * length, dtype=np.float64)
    shaken = []
    for a, b in edges.reshape(-1, 2):
        if (b - a) * length <= LONGEST + 2.0 * MARGIN:
            weight[a:b] = 0.0
            shaken.append(Change(float(seconds[a]) - 0.5 * length, float(seconds[b - 1]) + 0.5 * length))
    return Series(seconds, means, weight, length), shaken


def _keep_levels(means: Array, off: Flags, usual: Array, margin: int) -> None:
    """Take from what is off its inside where that is a level of its own: a short dwell."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], off, [False])).astype(int)))
    for a, b in edges.reshape(-1, 2):
        inside = means[a + margin : b - margin]
        if len(inside) >= FEWEST and np.all(inside.std(axis=0) < FLAT * usual):
            off[a + margin : b - margin] = False


def joined(places: Sequence[Change]) -> list[Change]:
    """Return stretches, those that touch as one, no longer than a turn."""
    found: list[Change] = []
    for one in sorted(places, key=lambda one: one.start):
        last = found[-1] if found else None
        if last and one.start <= last.stop and one.stop - last.start <= LONGEST + 2.0 * MARGIN:
            found[-1] = Change(last.start, max(last.stop, one.stop))
        else:
            found.append(one)
    return found


def _spike(blocks: Blocks, peak: Array, first: int, stop: int) -> Turn:
    """Return the blocks [first, stop) as a spike."""
    a, b = (blocks.start_ns + int(at) * blocks.length_ns for at in (blocks.at[first], blocks.at[stop - 1] + 1))
    none = np.full(blocks.mean.shape[1], np.nan)
    return Turn(a, b, (a + b) // 2, blocks.length, float(peak[first:stop].max()), none, none, felt=True)


def _change(blocks: Blocks, series: Series, fit: Fit, i: int, spikes: Sequence[Turn]) -> Turn:
    """Return a change of level as a turn: where it is by its spike, else by the level."""
    start = blocks.start_ns
    felt = at_spike(fit.changes[i], series.spikes)
    own: list[Turn] = []
    if felt is None:
        middle, u, low, high = located(series, fit, i)
        taken = [at_spike(other, series.spikes) for k, other in enumerate(fit.changes) if k != i]
        near = [one for one in series.spikes if one.start < high and one.stop > low and one not in taken]
        if near:  # it may be there, though the level puts it elsewhere
            low, high = min(low, near[0].start), max(high, near[-1].stop)
            middle, u = 0.5 * (low + high), max(u, (high - low) / np.sqrt(12.0))
    else:
        likely = likely_spikes(series, fit, i)
        low, high = (likely or [felt])[0].start, max(place.stop for place in likely or [felt])
        for place in (*series.spikes, *reversed(series.spikes)):  # no level between them: it may be in any
            if place.start < high + 3.0 * series.length and place.stop > low - 3.0 * series.length:
                low, high = min(low, place.start), max(high, place.stop)
        own = [
            spike for spike in spikes
            if spike.start_ns < start + round(high * SECOND) and spike.stop_ns > start + round(low * SECOND)
        ]  # fmt: skip
        if own and likely:
            first = min(spike.start_ns - start for spike in own) / SECOND
            last = max(spike.stop_ns - start for spike in own) / SECOND
            reach = MARGIN + 2.0 * series.length  # where more is shaken than the spikes explain, the turn may lie there
            low, high = first if first - low <= reach else low, last if high - last <= reach else high
        if not own:  # loud means alone show the middle of a smooth turn, not its ends
            low, high = low - MARGIN, high + MARGIN
        if not likely:  # the level changes elsewhere: beside a disturbance the record shows roughly where
            _, _, begin, end = located(series, fit, i)
            low, high = min(low, begin), max(high, end)
        middle, u = 0.5 * (low + high), max((high - low) / np.sqrt(12.0), blocks.length)
    first_ns, last_ns, middle_ns = (start + round(value * SECOND) for value in (low, high, middle))
    strongest = max((spike.peak for spike in own), default=0.0)
    return Turn(first_ns, last_ns, middle_ns, float(u), strongest, fit.size[i], fit.u[i], felt is not None)


def _to_and_fro(changes: Sequence[Turn]) -> bool:
    """Whether changes go to and fro between two levels."""
    for one, two in pairwise(changes):
        scale = np.where(one.u_step > 0.0, np.hypot(one.u_step, two.u_step), 1.0)
        a, b = one.step / scale, two.step / scale
        size = float(np.linalg.norm(a)), float(np.linalg.norm(b))
        if -float(a @ b) < OPPOSITE * size[0] * size[1] or max(size) > ALIKE * min(size):
            return False
    return True


def _taken(changes: list[Turn]) -> tuple[list[Turn], list[Turn], str]:
    """Return which changes are turns, which are none, and why it is not clear."""
    felt = [one for one in changes if one.felt]
    if any(two.middle_ns - one.middle_ns < APART_AT_SPIKES * SECOND for one, two in pairwise(changes)):
        return [], changes, "the level changes twice in less than a minute: a disturbance, or turns too near each other"
    if not all(one.clear for one in changes) or (len(changes) == 1 and changes[0].square < SQUARE):
        return [], changes, "the level changes, but not by so much more than it wanders that these are turns"
    if not changes or (_to_and_fro(changes) and (felt or len(changes) > 1)):
        return changes, [], ""
    if felt and _to_and_fro(felt):
        return felt, [one for one in changes if not one.felt], ""
    if len(changes) == 1:
        return [], changes, "the level changes once, without a spike: a turn, or a bias that jumped"
    return [], changes, "the level changes, but not to and fro between two levels"


def _no_turn(series: Series, fit: Fit, turns: Sequence[Turn], at: Sequence[float] | Array) -> bool:
    """Whether the record excludes a turn at each of some places [s], by the change of level at the others."""
    if not turns:
        return False
    signs = np.array([(-1.0) ** i for i in range(len(turns))])
    change = np.mean(signs[:, None] * np.array([one.step for one in turns]), axis=0)
    size, u = steps_at(series, fit, at)
    weight = np.where(np.isfinite(u) & (u > 0.0), 1.0 / np.maximum(u, 1e-300) ** 2, 0.0)
    information = np.sum(weight * change**2, axis=1)
    part = np.sum(weight * change * size, axis=1) / np.maximum(information, 1e-300)
    return bool(np.all((np.abs(part) < 0.5) & (information > CLEAR**-2)))


MAD = 0.6745  # median of |x| of unit normal x
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
