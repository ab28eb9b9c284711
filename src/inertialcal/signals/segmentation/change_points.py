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

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...core.batches import batches, empty, is_stored, kept, near, release, rows_taken, taken, zeros
from ...core.batches.summaries import medians
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


def single_outliers(y: Array, noise: Noise, factor: float, apart: int) -> Indices:
    """Return the samples that stand alone, ascending: far from two neighbours that agree with each other.

    ``factor`` is in standard deviations of ``y`` (n, channels). Outliers nearer to each other than ``apart`` samples
    are motion or noise, and stay.
    """
    sigma = factor * noise.scale
    near, away = (np.sqrt(size) * sigma + noise.feigned for size in (2.0, 1.5))
    fill_far = loops_for(len(y)).fill_far

    def far(share: tuple[int, int, int]) -> Indices:
        channel, first, stop = share
        part = y[first : stop + 2, channel]
        at = _filled(lambda room: fill_far(part, float(away[channel]), room))
        release(part)
        return at + first

    at = _of_shares(far, len(y) - 2, y.shape[1])
    if at.size:
        at = at[(np.abs(rows_taken(y, at + 1) - rows_taken(y, at - 1)) <= near).all(axis=1)]
    if not at.size:
        return at
    distance = np.diff(at, prepend=at[0] - apart, append=at[-1] + apart)
    return at[(distance[:-1] >= apart) & (distance[1:] >= apart)]


def _filled(fill: Callable[[Indices], int]) -> Indices:
    """Return the places that a loop fills, which returns how many there are, room or not."""
    room = np.empty(ROOM, dtype=np.int64)
    while (count := fill(room)) > len(room):
        room = np.empty(count, dtype=np.int64)
    return room[:count]


def _of_shares(places: Callable[[tuple[int, int, int]], Indices], n: int, channels: int) -> Indices:
    """Return the places of all channels and shares of n samples, ascending, each once."""
    every = [(k, *share) for k in range(channels) for share in shares(n)]
    found = np.concatenate(each_of(places, every, channels * n))
    if channels == 1:
        return found
    found.sort(kind="stable")  # which merges what is in order, in a fifth of the time of np.unique
    return found[np.diff(found, prepend=-1) > 0]


def level_changes(
    y: Array, noise: Noise, scales: tuple[int, ...], quantile: Array, cuts: Indices
) -> tuple[Indices, Callable[[], Array]]:
    """Return where the level changes, with 0 and n, and by how much more than white noise the widest means scatter.

    That is measured where it is asked for.

    Parameters
    ----------
    y : ndarray, shape (n, channels)
        The samples.
    scales : tuple of int
        Widths of the windows, powers of two, ascending [samples].
    quantile : ndarray, shape (channels,)
        Threshold for the difference of two window means, in units of its standard deviation.
    cuts : ndarray of int, shape (k,)
        Changes that are known beforehand: 0, gaps, n.
    """
    scales = tuple(w for w in scales if len(y) >= 2 * w)
    limits = [_limit(noise, w, quantile) for w in scales]

    def widening() -> Array:
        return np.ones(y.shape[1])

    for w, some in zip(scales, _any_above(y, scales, limits), strict=True):
        cuts, widening = _changes_at_scale(Jumps(y, w), noise, w, quantile, cuts, widening, some)
    return cuts, widening


def _limit(noise: Noise, w: int, quantile: Array, wide: Array | float = 1.0) -> Array:
    """Return the threshold for the difference of two means of w samples, shape (channels,)."""
    limit: Array = np.maximum(quantile * (noise.scale * np.sqrt(2.0 / w)) * wide, noise.feigned)
    return limit


def _any_above(y: Array, scales: tuple[int, ...], limits: list[Array]) -> list[bool]:
    """Return at which scales any jump exceeds the limit of its channel, in one look at the samples."""
    if not scales:
        return []
    count_above, widest = loops_for(len(y)).count_above, scales[-1]
    wanted = np.full((y.shape[1], widest.bit_length()), np.inf)
    order = [w.bit_length() - 1 for w in scales]
    wanted[:, order] = np.stack(limits, axis=1)

    def counted(share: tuple[int, int, int]) -> Indices:
        channel, first, stop = share
        part, counts = y[first : stop + 2 * widest - 1, channel], np.zeros(wanted.shape[1], dtype=np.int64)
        count_above(part, wanted[channel], counts)
        release(part)
        return counts

    every = [(k, *share) for k in range(y.shape[1]) for share in shares(len(y))]
    counts = np.sum(each_of(counted, every, y.size), axis=0)
    return [bool(one) for one in counts[order]]


@dataclass(frozen=True, eq=False)
class Jumps:
    """Sizes of the difference of the means of w samples after and before samples w .. n - w, w a power of two.

    They are worked out where they are looked at: no scale keeps those of the whole record.
    """

    y: Array  # the samples, shape (n, channels)
    w: int

    def __len__(self) -> int:
        return len(self.y) - 2 * self.w + 1

    def at(self, places: Indices) -> Array:
        """Return the jumps at places counted from sample w, ascending, shape (channels, k)."""
        jumps, fill_jumps = np.empty((self.y.shape[1], len(places))), loops_for(len(self.y)).fill_jumps
        parts = shares(len(self))
        ends = np.searchsorted(places, [first for first, _ in parts[1:]])
        own = list(zip(parts, np.split(places, ends), np.split(jumps, ends, axis=1), strict=True))
        for (first, stop), some, out in own if len(places) else ():
            for x, jump in zip(self.y[first : stop + 2 * self.w - 1].T, out, strict=True):
                if len(some):
                    fill_jumps(x, self.w, some - first, jump)
                    release(x)
        return jumps

    def above(self, limit: Array) -> Indices:
        """Return the places at which the jump of any channel exceeds its limit, ascending."""
        fill_above = loops_for(len(self.y)).fill_above

        def places(share: tuple[int, int, int]) -> Indices:
            channel, first, stop = share
            part = self.y[first : stop + 2 * self.w - 1, channel]
            at = _filled(lambda room: fill_above(part, self.w, float(limit[channel]), room))
            release(part)
            return at + first

        return _of_shares(places, len(self), len(limit))


def _changes_at_scale(
    jumps: Jumps, noise: Noise, w: int, quantile: Array, cuts: Indices, widening: Callable[[], Array], some: bool
) -> tuple[Indices, Callable[[], Array]]:
    """Add the changes seen at one scale; carry the widening on where the scale cannot measure its own.

    ``some``: whether any jump exceeds the limit of white noise. The widening is measured where it is asked for.
    """
    white = noise.scale * np.sqrt(2.0 / w)
    found, wide = cuts, np.ones(len(white))
    if not some:  # limits only grow

        def own() -> Array:
            measured = _measured_widening(jumps, white, w, cuts)
            if measured is None:
                return widening()
            measured = np.minimum(measured, BLUE) if w == 1 else measured
            return wide if np.all(measured <= WIDEN) else np.maximum(wide, measured)

        return cuts, own
    at = jumps.above(_limit(noise, w, quantile))
    for _ in range(ROUNDS):
        found = _exceedances(jumps, at, _limit(noise, w, quantile, wide), w, cuts)
        measured = _measured_widening(jumps, white, w, found)
        if measured is None:
            limit = _limit(noise, w, quantile, np.maximum(wide, widening()))
            return _exceedances(jumps, at, limit, w, cuts), widening
        if w == 1:
            measured = np.minimum(measured, BLUE)
        if np.all(measured <= WIDEN * wide):
            break
        wide = np.maximum(wide, measured)
    return found, lambda: wide


def _exceedances(jumps: Jumps, at: Indices, limit: Array, w: int, cuts: Indices) -> Indices:
    """Cuts with those of places ``at`` added whose jump exceeds its limit and is the largest for w samples around."""
    if not len(at):
        return cuts
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
    ratio: Array = np.divide(medians(rows), HALF_NORMAL * white, out=np.zeros(len(white)), where=white > 0.0)
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


def loud(y: Array, noise: Noise, w: int, tail: float, start: Indices, stop: Indices) -> Indices:
    """Return the first samples, ascending, of windows of ``w`` samples that scatter more than noise in any channel.

    Windows lie inside the stretches at one level, ascending and disjoint; ``tail`` is the false-alarm probability of
    one.
    """
    cuts = np.concatenate(([0], np.cumsum(stop - start)))
    windows = np.maximum(stop - start - w + 1, 0)  # of each stretch
    ends = np.cumsum(windows)
    many, n = int(windows.sum()), int(cuts[-1])
    if not many:
        return start[:0]
    probes = np.arange(0, many, max(1, w // 2, many // PROBES))
    own = np.searchsorted(ends, probes, side="right")
    probes += (cuts[:-1] - ends + windows)[own]
    inside = None if n == len(y) else covered(start, stop, len(y))
    found, fill_loud = [], loops_for(len(y)).fill_loud
    for k in range(y.shape[1]):
        x = y[:, k] if inside is None else kept(y[:, k], inside)

        def above(limit: float, x: Array = x) -> Indices:
            def hot(share: tuple[int, int, int]) -> Indices:
                _, first, stop = share
                last = stop + w - 1
                part = x[first:last]
                at = _filled(lambda room: fill_loud(part, np.clip(cuts, first, last) - first, w, limit, room))
                release(part)
                return at + first

            return _of_shares(hot, n - w + 1, 1)

        at = above(float(f_upper(tail, w - 1.0, noise.dof[k])) * float(noise.scale[k]) ** 2)
        if len(at) and not noise.stated:  # of noise that is not white the limit is higher
            usual, dof = _usual_variance(_windows(x, probes, w).var(axis=1, ddof=1), w)
            at = above(float(f_upper(tail, dof, noise.dof[k])) * max(float(noise.scale[k]) ** 2, usual))
        found.append(at)
    at = np.unique(np.concatenate(found)) if len(found) > 1 else found[0]
    own = np.searchsorted(cuts, at, side="right") - 1
    at, own = at[at + w <= cuts[own + 1]], own[at + w <= cuts[own + 1]]
    return np.asarray(at + (start - cuts[:-1])[own])


def _windows(x: Array, first: Indices, w: int) -> Array:
    """Return w samples from each place on, shape (k, w)."""
    if not is_stored(x):
        return np.asarray(sliding_window_view(x, w)[first])
    return np.stack([taken(x, first + i) for i in range(w)], axis=1)


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


def _among(at: Indices, walls: Indices) -> Flags:
    """Return which places are walls; these are ascending, not none."""
    return np.asarray(walls[np.minimum(np.searchsorted(walls, at), len(walls) - 1)] == at)


def settled_ends(y: Array, noise: Noise, start: Indices, stop: Indices, walls: Indices) -> tuple[Indices, Indices]:
    """Return stretches whose ends lie where the samples settle at the level inside, three samples off at most.

    A sample at an end that does not fit the level just inside is given up; one before the end that does fit is taken
    in, if no other stretch holds it. No end moves across a wall (0, long gaps and n), and an end there stays.
    """
    if _among(start, walls).all() and _among(stop, walls).all():
        return start, stop
    first, last = (_means(y, at, at + LEVEL_SAMPLES) for at in (start + RAMP, stop - RAMP - LEVEL_SAMPLES))
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

    free = ~_among(edge, walls)
    giving, moved = free.copy(), edge
    for _ in range(RAMP):
        giving &= ~fits(moved + inner)
        moved = moved + inward * giving
    taking = free & (moved == edge)
    for _ in range(RAMP):
        taking &= ((moved - neighbour) * inward > 0) & ~_among(moved, walls) & fits(moved + outer)
        moved = moved - inward * taking
    return moved


def joined_where_equal(
    y: Array, noise: Noise, quantile: Array, start: Indices, stop: Indices, walls: Indices, longest: int
) -> tuple[Indices, Indices]:
    """Return stretches joined where they touch and their levels, over the widest windows, do not differ.

    A disturbance of a few samples makes a change on a fine scale that a wide one does not see. Stretches are not joined
    across a wall; ``quantile`` (channels,) is the threshold in standard deviations of the difference.
    """
    at = np.flatnonzero((start[1:] == stop[:-1]) & ~_among(start[1:], walls))
    if not len(at):
        return start, stop
    edge = stop[at]
    left = np.minimum(stop[at] - start[at], longest)
    right = np.minimum(stop[at + 1] - start[at + 1], longest)
    same = at[~_differ(y, noise, quantile, (edge - left, edge), (edge, edge + right))]
    return np.delete(start, same + 1), np.delete(stop, same)


def sloping(y: Array, noise: Noise, quantile: Array, start: Indices, stop: Indices) -> Flags:
    """Return which stretches, of two samples or more, have two halves at different levels, shape (k,)."""
    half = (stop - start) // 2
    return _differ(y, noise, quantile, (start, start + half), (stop - half, stop))


def _differ(
    y: Array,
    noise: Noise,
    quantile: Array,
    one: tuple[Indices, Indices],
    other: tuple[Indices, Indices],
) -> Flags:
    """Which pairs of stretches have different means in any channel, shape (k,)."""
    sizes = [(b - a)[:, None] for a, b in (one, other)]
    means = [_means(y, *stretch) for stretch in (one, other)]
    sigma = noise.scale * np.sqrt(1.0 / sizes[0] + 1.0 / sizes[1])
    return np.asarray((np.abs(means[0] - means[1]) > np.maximum(quantile * sigma, noise.feigned)).any(axis=1))


def _means(y: Array, start: Indices, stop: Indices) -> Array:
    """Return the means of short stretches [start, stop), shape (k, channels)."""
    means, size = np.empty((len(start), y.shape[1])), stop - start
    widest = int(size.max(initial=1))
    for first, last in batches(start, size=max(1, near() // widest)):
        at = start[first:last, None] + np.arange(widest)
        inside = at < stop[first:last, None]
        at = np.where(inside, at, start[first:last, None])
        for x, mean in zip(y.T, means.T, strict=True):
            mean[first:last] = np.sum(x[at], axis=1, where=inside) / size[first:last]
    release(y)
    return means


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
