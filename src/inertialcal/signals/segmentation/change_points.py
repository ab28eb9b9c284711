"""Where the level or the scatter of a signal changes: the numerics under ``segments``.

Levels are compared in two windows of ``w`` samples, left and right of every sample (moving sums, [1]_),
for ``w`` = 1, 2, 4, ... from fine to coarse [2]_; what a fine scale has found, a coarse one does not look
across. A change is called where the two means differ by more than a quantile of Student's t, whose tail is
shared among all samples, scales and channels (Bonferroni): on white Gaussian noise the stated false-alarm
probability is an upper bound.

In noise that is not white, window means scatter more than white noise lets them. Each scale widens its
threshold by the ratio that it finds between its changes, so coloured noise is not taken for motion, and a
drift much slower than the longest window is not either.

Arrays are time-first, (n, channels), finite; column-major order is fastest.

References
----------
.. [1] Eichinger and Kirch, Bernoulli 24 (2018) 526-564: moving sums for several change points.
.. [2] Messer et al., Annals of Applied Statistics 8 (2014) 2027-2067: windows of several widths, the finest
   first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...core.batches import (
    batches,
    columns,
    count,
    empty,
    every,
    is_stored,
    kept,
    made,
    release,
    rows_taken,
    taken,
    zeros,
)
from ...core.estimate import Array
from ...statistics.quantiles import chi_square_quantile, f_upper
from ..threads import each_of, shares
from .loops import loops_for
from .noise_scale import Noise

Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

HALF_NORMAL = 0.6744897501960817  # median of |x| for unit normal x
WIDEN = 1.1  # a threshold too narrow by less than this is left as it is
BLUE = np.sqrt(2.0)  # most that single samples can differ more than white ones: neighbours opposed
ROUNDS = 10
FEW_STRETCHES = 1_000
ROOM = 2**12  # places at first
PROBES = 4_000  # places at which the usual scatter of a statistic is measured
FEWEST = 16  # places from which it can be
LOW = 0.1  # quantile of window variances that, with the median, tells their spread
RAMP = 3  # samples at each end of a stretch that may still belong to the ramp
EDGE = 3.5  # standard deviations at which they do
LEVEL_SAMPLES = 8  # samples after the ramp that give the level there
SHORTEST = RAMP + LEVEL_SAMPLES + 1  # samples that a stretch needs


def single_outliers(y: Array, noise: Noise, factor: float, apart: int) -> Flags:
    """Return which samples, shape (n,), stand alone: far from two neighbours that agree with each other.

    ``factor`` is in standard deviations of ``y`` (n, channels). Outliers nearer to each other than ``apart`` samples
    are motion or noise, and stay.
    """
    alone = zeros(len(y), bool)
    calm = made(len(y) - 2, bool, lambda first, stop: np.ones(stop - first, dtype=bool))
    far = zeros(len(y) - 2, bool)
    loops = loops_for(len(y))
    for k in range(y.shape[1]):
        sigma, feigned = factor * noise.scale[k], noise.feigned[k]
        limits = np.sqrt(2.0) * sigma + feigned, np.sqrt(1.5) * sigma + feigned

        def mark(share: tuple[int, int], x: Array = y[:, k], limits: tuple[float, float] = limits) -> None:
            first, stop = share
            loops.mark_alone(x[first : stop + 2], *limits, calm[first:stop], far[first:stop])
            for one in (x, calm, far):
                release(one[first:stop])

        each_of(mark, shares(len(calm)), len(calm))
    at = np.concatenate([first + np.flatnonzero(far[first:stop] & calm[first:stop])
                         for first, stop in batches(far, calm)]) + 1  # fmt: skip
    if at.size:
        distance = np.diff(at, prepend=at[0] - apart, append=at[-1] + apart)
        alone[at[(distance[:-1] >= apart) & (distance[1:] >= apart)]] = True
    return alone


def running_sum(y: Array) -> Array:
    """Return the sums of the samples before each, shape (n + 1, channels), from which means are differences."""
    total = columns(len(y) + 1, y.shape[1])
    total[0] = 0.0
    for x, own in zip(y.T, total.T, strict=True):
        for first, stop in batches(x, own[:-1]):
            np.add.accumulate(np.concatenate((own[first : first + 1], x[first:stop])), out=own[first : stop + 1])
    return total


def level_changes(
    total: Array, noise: Noise, scales: tuple[int, ...], quantile: Array, cuts: Indices
) -> tuple[Indices, Array]:
    """Return where the level changes, with 0 and n, and by how much more than white noise the widest means scatter.

    Parameters
    ----------
    total : ndarray, shape (n + 1, channels)
        Running sum of the samples.
    scales : tuple of int
        Widths of the windows, ascending [samples].
    quantile : ndarray, shape (channels,)
        Threshold for the difference of two window means, in units of its standard deviation.
    cuts : ndarray of int, shape (k,)
        Changes that are known beforehand: 0, gaps, n.
    """
    widening = np.ones(total.shape[1])
    for w in scales:
        if len(total) <= 2 * w:
            break
        cuts, widening = _changes_at_scale(Jumps(total, w), noise, w, quantile, cuts, widening)
    return cuts, widening


@dataclass(frozen=True, eq=False)
class Jumps:
    """Sizes of the difference of the means of w samples after and before samples w .. n - w, w a power of two.

    They are worked out where they are looked at: no scale keeps those of the whole record.
    """

    total: Array  # running sum of the samples, shape (n + 1, channels)
    w: int

    def __len__(self) -> int:
        return len(self.total) - 2 * self.w

    def at(self, places: Indices) -> Array:
        """Return the jumps at places counted from sample w, shape (channels, k)."""
        before, middle, after = (rows_taken(self.total, places + i * self.w) for i in range(3))
        jumps: Array = np.abs(after - middle - middle + before).T * (1.0 / self.w)
        return jumps

    def above(self, limit: Array) -> Indices:
        """Return the places at which the jump of any channel exceeds its limit, ascending."""
        fill_above = loops_for(len(self.total)).fill_above

        def places(share: tuple[int, int, int]) -> Indices:
            channel, first, stop = share
            part, room = self.total[first : stop + 2 * self.w, channel], np.empty(ROOM, dtype=np.int64)
            while (count := fill_above(part, self.w, float(limit[channel]), room)) > len(room):
                room = np.empty(count, dtype=np.int64)
            release(part)
            return room[:count] + first

        every = [(k, *share) for k in range(len(limit)) for share in shares(len(self))]
        found = np.concatenate(each_of(places, every, len(limit) * len(self)))
        return found if len(limit) == 1 else np.unique(found)


def _changes_at_scale(
    jumps: Jumps, noise: Noise, w: int, quantile: Array, cuts: Indices, widening: Array
) -> tuple[Indices, Array]:
    """Add the changes seen at one scale; carry the widening on where the scale cannot measure its own."""
    white = noise.scale * np.sqrt(2.0 / w)
    found, wide = cuts, np.ones(len(white))
    at = jumps.above(np.maximum(quantile * white, noise.feigned))  # limits only grow
    for _ in range(ROUNDS):
        found = _exceedances(jumps, at, np.maximum(quantile * white * wide, noise.feigned), w, cuts)
        measured = _measured_widening(jumps, white, w, found)
        if measured is None:
            limit = np.maximum(quantile * white * np.maximum(wide, widening), noise.feigned)
            return _exceedances(jumps, at, limit, w, cuts), widening
        if w == 1:
            measured = np.minimum(measured, BLUE)
        if np.all(measured <= WIDEN * wide):
            break
        wide = np.maximum(wide, measured)
    return found, wide


def _exceedances(jumps: Jumps, at: Indices, limit: Array, w: int, cuts: Indices) -> Indices:
    """Cuts with those of places ``at`` added whose jump exceeds its limit and is the largest for w samples around."""
    hits = at[(jumps.at(at) > limit[:, None]).any(axis=0)] + w
    if w == 1:
        return _joined(cuts, hits)
    for _ in range(ROUNDS):
        hits = hits[_clear(hits, w, cuts)]
        if not len(hits):
            break
        score = (jumps.at(hits - w) / np.where(limit > 0.0, limit, np.finfo(float).tiny)[:, None]).max(axis=0)
        cuts = _joined(cuts, hits[_highest(hits, score, w)])
    return cuts


def _highest(at: Indices, score: Array, w: int) -> Indices:
    """Which of the places ``at`` are the highest for w samples around, ascending."""
    room, kept = np.empty(len(at), dtype=np.int64), np.empty(len(at), dtype=bool)
    loops = loops_for(len(at))
    peaks = room[: loops.fill_peaks(at, score, room)]
    loops.drop_lower(at[peaks], np.argsort(score[peaks]), w, kept[: len(peaks)])
    return peaks[kept[: len(peaks)]]


def _joined(cuts: Indices, new: Indices) -> Indices:
    """Both, ascending, each once."""
    every = np.sort(np.concatenate((cuts, new)))
    return every[np.diff(every, prepend=-1) > 0]


def _clear(at: Indices, w: int, cuts: Indices) -> Flags:
    """Which of the indices are w samples or more from the nearest cut, shape of ``at``."""
    clear = np.empty(len(at), dtype=bool)
    loops_for(len(at)).fill_clear(at, w, cuts, clear)
    return clear


def _measured_widening(jumps: Jumps, white: Array, w: int, cuts: Indices) -> Array | None:
    """Ratio of the scatter of jumps between changes to that of white noise; None from too few."""
    every = np.arange(0, len(jumps), max(1, w // 2, len(jumps) // PROBES))
    free = every[_clear(every + w, w, cuts)]
    if len(free) < FEWEST:
        return None
    rows = jumps.at(free)
    half = rows.shape[1] // 2
    parted = np.partition(rows, half, axis=1)
    upper: Array = parted[:, half]
    median = upper if rows.shape[1] % 2 else 0.5 * (parted[:, :half].max(axis=1) + upper)
    ratio: Array = np.divide(median, HALF_NORMAL * white, out=np.zeros(len(white)), where=white > 0.0)
    return ratio


def covered(start: Indices, stop: Indices, n: int) -> Flags:
    """Return which of n samples lie in one of the stretches [start, stop), both ascending, shape (n,)."""
    start, stop = np.clip(start, 0, n), np.clip(stop, 0, n)
    if len(start) <= FEW_STRETCHES:
        few = zeros(n, bool)
        for a, b in zip(start.tolist(), stop.tolist(), strict=True):
            for first, last in batches(few[a:b]):
                few[a + first : a + last] = True
        return few
    flags = zeros(n + 1, np.int8)
    if len(start):
        apart = start[1:] > stop[:-1]
        flags[start[np.r_[True, apart]]] += 1
        flags[stop[np.r_[apart, True]]] -= 1
    inside, level = empty(n, bool), 0
    for one, last in batches(inside, flags[:n]):
        depth = np.cumsum(flags[one:last], dtype=np.int8) + np.int8(level)
        inside[one:last], level = depth > 0, int(depth[-1])
    return inside


def loud(y: Array, noise: Noise, w: int, tail: float, start: Indices, stop: Indices) -> Flags:
    """Return the samples, shape (n,), in windows of ``w`` samples that scatter more than noise does in any channel.

    Windows lie inside the stretches at one level, ascending and disjoint; ``tail`` is the false-alarm probability of
    one.
    """
    cuts = np.concatenate(([0], np.cumsum(stop - start)))
    size = max(0, int(cuts[-1]) - w + 1)
    ends = covered(cuts[1:-1] - w + 1, cuts[1:-1], size)
    whole = made(size, bool, lambda first, stop: ~ends[first:stop], ends)
    found = zeros(len(y), bool)
    if every(whole, lambda part: not part.any()):
        return found
    inside = covered(start, stop, len(y))
    hot, loops = zeros(size, bool), loops_for(len(y))
    many = count(whole, lambda part: part)
    apart = max(1, w // 2, many // PROBES)
    probes = np.arange(0, size, apart) if many == size else _thinned_places(whole, apart)
    for k in range(y.shape[1]):
        x = kept(y[:, k], inside)
        usual, dof = (0.0, w - 1.0)
        if not noise.stated:
            usual, dof = _usual_variance(_windows(x, probes, w).var(axis=1, ddof=1), w)
        limit = float(f_upper(tail, dof, noise.dof[k])) * max(float(noise.scale[k]) ** 2, usual)

        def mark(share: tuple[int, int], x: Array = x, limit: float = limit) -> None:
            first, stop = share
            last = stop + w - 1
            loops.mark_loud(x[first:last], np.clip(cuts, first, last) - first, w, limit, hot[first:stop])
            release(x[first:stop])
            release(hot[first:stop])

        each_of(mark, shares(size), size)
    at = np.concatenate([first + np.flatnonzero(hot[first:stop] & whole[first:stop])
                         for first, stop in batches(hot, whole)])  # fmt: skip
    if len(at):
        marked = covered(at, at + w, int(cuts[-1]))
        for a, b, own in zip(start.tolist(), stop.tolist(), cuts[:-1].tolist(), strict=True):
            for first, last in batches(found[a:b], marked[own : own + b - a]):
                found[a + first : a + last] = marked[own + first : own + last]
    return found


def _windows(x: Array, first: Indices, w: int) -> Array:
    """Return w samples from each place on, shape (k, w)."""
    if not is_stored(x):
        return np.asarray(sliding_window_view(x, w)[first])
    return np.stack([taken(x, first + i) for i in range(w)], axis=1)


def _thinned_places(flags: Flags, step: int) -> Indices:
    """Return every so manieth place that is flagged, ascending."""
    found, before = [], 0
    for first, stop in batches(flags):
        own = first + np.flatnonzero(flags[first:stop])
        found.append(own[-before % step :: step].copy())  # a part would hold all
        before += len(own)
    return np.concatenate(found)


def _usual_variance(variance: Array, w: int) -> tuple[float, float]:
    """Usual variance of windows of w samples, and its degrees of freedom: fewer where noise is not white."""
    low, median = np.quantile(variance, (LOW, 0.5))
    dof = float(w - 1)
    if len(variance) >= 2 * FEWEST and low > 0.0:
        dof = min(dof, float(np.interp(low / median, *_spread_of_variance())))
    return float(median / chi_square_quantile(0.5, dof) * dof), dof


@cache
def _spread_of_variance() -> tuple[Array, Array]:
    """Ratio of a low quantile to the median of chi-square, ascending, and the degrees of freedom for it."""
    dof = np.geomspace(0.5, 500.0, 100)
    return chi_square_quantile(LOW, dof) / chi_square_quantile(0.5, dof), dof


def settled_ends(
    y: Array, total: Array, noise: Noise, start: Indices, stop: Indices, walls: Indices
) -> tuple[Indices, Indices]:
    """Return stretches whose ends lie where the samples settle at the level inside, three samples off at most.

    A sample at an end that does not fit the level just inside is given up; one before the end that does fit is taken
    in, if no other stretch holds it. No end moves across a wall (0, long gaps and n), and an end there stays. ``total``
    (n + 1, channels) is the running sum of the samples.
    """
    first, last = (
        (rows_taken(total, at + LEVEL_SAMPLES) - rows_taken(total, at)) / LEVEL_SAMPLES
        for at in (start + RAMP, stop - RAMP - LEVEL_SAMPLES)
    )
    limit = EDGE * noise.scale * np.sqrt(1.0 + 1.0 / LEVEL_SAMPLES)
    start = _settled(start, 1, y, first, limit, walls, np.concatenate(([0], stop[:-1])))
    stop = _settled(stop, -1, y, last, limit, walls, np.concatenate((start[1:], [len(y)])))
    return start, stop


def _settled(
    edge: Indices, inward: int, y: Array, level: Array, limit: Array, walls: Indices, neighbour: Indices
) -> Indices:
    """Edges moved inward over samples that do not fit the level, or else outward over those that do."""
    inner, outer = (0, -1) if inward > 0 else (-1, 0)

    def fits(at: Indices) -> Flags:
        off = np.abs(rows_taken(y, np.clip(at, 0, len(y) - 1)) - level)
        return np.asarray((off <= limit).all(axis=1))

    free = ~np.isin(edge, walls)
    giving, moved = free.copy(), edge
    for _ in range(RAMP):
        giving &= ~fits(moved + inner)
        moved = moved + inward * giving
    taking = free & (moved == edge)
    for _ in range(RAMP):
        taking &= ((moved - neighbour) * inward > 0) & ~np.isin(moved, walls) & fits(moved + outer)
        moved = moved - inward * taking
    return moved


def joined_where_equal(
    total: Array, noise: Noise, quantile: Array, start: Indices, stop: Indices, walls: Indices, longest: int
) -> tuple[Indices, Indices]:
    """Return stretches joined where they touch and their levels, over the widest windows, do not differ.

    A disturbance of a few samples makes a change on a fine scale that a wide one does not see. Stretches are not joined
    across a wall; ``quantile`` (channels,) is the threshold in standard deviations of the difference.
    """
    at = np.flatnonzero((start[1:] == stop[:-1]) & ~np.isin(start[1:], walls))
    edge = stop[at]
    left = np.minimum(stop[at] - start[at], longest)
    right = np.minimum(stop[at + 1] - start[at + 1], longest)
    same = at[~_differ(total, noise, quantile, (edge - left, edge), (edge, edge + right))]
    return np.delete(start, same + 1), np.delete(stop, same)


def sloping(total: Array, noise: Noise, quantile: Array, start: Indices, stop: Indices) -> Flags:
    """Return which stretches, of two samples or more, have two halves at different levels, shape (k,)."""
    half = (stop - start) // 2
    return _differ(total, noise, quantile, (start, start + half), (stop - half, stop))


def _differ(
    total: Array,
    noise: Noise,
    quantile: Array,
    one: tuple[Indices, Indices],
    other: tuple[Indices, Indices],
) -> Flags:
    """Which pairs of stretches have different means in any channel, shape (k,)."""
    sizes = [(b - a)[:, None] for a, b in (one, other)]
    means = [
        (rows_taken(total, b) - rows_taken(total, a)) / size for (a, b), size in zip((one, other), sizes, strict=True)
    ]
    sigma = noise.scale * np.sqrt(1.0 / sizes[0] + 1.0 / sizes[1])
    far: Flags = (np.abs(means[0] - means[1]) > np.maximum(quantile * sigma, noise.feigned)).any(axis=1)
    return far


def stretches(start: Indices, stop: Indices, keep: Flags) -> tuple[Indices, Indices]:
    """Return the parts of ascending, disjoint stretches in which every sample is kept.

    Parameters
    ----------
    start, stop : ndarray of int, shape (k,)
        Half-open.
    keep : ndarray of bool, shape (n,)
        Samples to keep.

    Returns
    -------
    start, stop : ndarray of int
        Half-open, ascending.
    """
    inside = covered(start, stop, len(keep))
    begins, ends, before = [start[:0]], [start[:0]], False
    for first, last in batches(inside, keep):
        inside[first:last] &= keep[first:last]
        steps = np.diff(inside[first:last].astype(np.int8), prepend=np.int8(before))
        before = bool(inside[last - 1])
        begins.append(first + np.flatnonzero(steps > 0))
        ends.append(first + np.flatnonzero(steps < 0))
    ends.append(np.array([len(keep)] if before else [], dtype=np.int64))
    inner, outer = start[taken(inside, start)], stop[taken(inside, stop - 1)]
    return _joined(np.concatenate(begins), inner), _joined(np.concatenate(ends), outer)
