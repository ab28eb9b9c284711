"""Still and moving stretches of a signal: one detector, and three selections from what it finds.

*Still* means that the level is constant within the noise and the scatter is that of the noise: a table that
turns at a constant rate is still for a rate sensor, so is a sensor lying in any attitude for an
accelerometer. *Moving* is all that is not shown to be still: ramps, hands, shaking, stretches too short to
judge, samples that are missing for too long.

The detector is ``still_stretches``, the noise under it ``noise_scale``, its tests ``change_points``. What it
cannot do: tell a drift slower than its longest window from a constant level; find a step
smaller than the noise of two window means (0.006 deg/s at a noise of 0.004 deg/s in a dwell of 30 samples,
say); take a stretch for still whose noise is more than twice that of the quietest. Where a reference or a schedule
exists, cut by that (``dwells_by_reference``, ``dwells_by_windows``).

Selections: ``dwells`` (every still stretch long enough), ``static_intervals`` (one for each placement of a
sensor set down by hand). Both give Dwells. ``turns`` selects the turns of a head from a long record, by its block means
and variances.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...core import batches
from ...core.batches.summaries import moments
from ...core.errors import DataError
from ...core.estimate import Array, Numbers
from ...core.recording import Times
from ...core.remarks import Remark
from ..time.samples import Flags, Indices, Samples, samples_of
from ..time.schedule import dwells_by_reference, dwells_by_windows
from .dwells import Dwell, Tally, dwell_of, tally
from .loops import loops_for
from .noise_scale import BLOCK, Noise
from .still_stretches import Detection, Found, still_stretches

__all__ = [
    "Detection",
    "Dwell",
    "Interval",
    "Segmentation",
    "Tally",
    "detect",
    "dwells",
    "dwells_by_reference",
    "dwells_by_windows",
    "placement_groups",
    "static_intervals",
    "tally",
]

Kind = Literal["still", "moving"]

NOT_WHITE = 3.0  # widening from which it is remarked


@dataclass(frozen=True, eq=False)
class Interval:
    """One stretch: samples [start, stop), its kind, and level and scatter of each channel in it."""

    start: int
    stop: int
    kind: Kind
    level: Array
    scatter: Array


@dataclass(frozen=True, eq=False)
class Segmentation:
    """A record cut into still and moving stretches that together hold every sample once."""

    # start, stop: stretches in order, half-open; ``stop[i] == start[i + 1]``, shape (k,)
    start: Indices
    stop: Indices
    still: Flags  # still or moving, shape (k,)
    # level, scatter: mean and standard deviation (n - 1) of the good samples; NaN where there are none, or one, shape
    # (k, channels)
    level: Array
    scatter: Array
    noise: Noise  # scatter of a sample where nothing happens
    # by how much more than white noise the means of the widest windows scatter between changes, shape (channels,)
    widening: Array
    samples: Samples  # the signal with its single outliers marked
    stuck: Flags  # still stretches in which a channel that is noisy elsewhere does not vary at all, shape (k,)
    plan: Detection  # what it was found with

    def __len__(self) -> int:
        return len(self.start)

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """The stretches one by one."""
        kinds: tuple[Kind, Kind] = ("moving", "still")
        return tuple(
            Interval(int(self.start[i]), int(self.stop[i]), kinds[int(self.still[i])], level, scatter)
            for i, (level, scatter) in enumerate(zip(self.level, self.scatter, strict=True))
        )

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Samples missing, outliers set aside, noise far from white, stretches in which a channel is stuck."""
        missing = len(self.samples.finite) - batches.count(self.samples.finite, lambda part: part)
        outliers, stuck = batches.count(self.samples.outlier, lambda part: part), int(np.count_nonzero(self.stuck))
        found = []
        if missing:
            at = int(np.argmin(self.samples.finite))
            text = "sample without a value, left out"
            found.append(Remark("missing_samples", "info", text, f"sample {at}", missing, index=at))
        if outliers:
            at = int(np.argmax(self.samples.outlier))
            found.append(Remark("outliers", "warning", "single outlier, left out", f"sample {at}", outliers, index=at))
        if np.any(self.widening > NOT_WHITE):
            ratio = float(self.widening.max())
            text = f"window means scatter {ratio:.2g} times as much as white noise: there may be slow motion"
            do = "State the noise at rest, unless the output is filtered"
            found.append(Remark("noise_not_white", "warning", text, do=do))
        if stuck:
            at = int(self.start[np.flatnonzero(self.stuck)[0]])
            text = "a channel repeats one value for a whole stretch"
            found.append(Remark("stuck", "warning", text, f"sample {at}", stuck, "Check for saturation", index=at))
        return tuple(found)


def detect(
    signal: Numbers,
    time_ns: Times | None = None,
    sample_interval: float | None = None,
    plan: Detection | None = None,
    place: Callable[[int], str] = "sample {}".format,
) -> Segmentation:
    """Cut a signal into still and moving stretches.

    Parameters
    ----------
    signal : ndarray, shape (n,) or (n, channels)
        In any unit; a sample with a value that is not finite is left out. A stretch is still if every
        channel is.
    time_ns : ndarray of int64, shape (n,), optional
        Stamps, not descending [ns]; without them neighbouring samples count as one sample interval apart.
    sample_interval : float, optional
        Nominal time from sample to sample [s]; from the stamps by default.
    plan : Detection, optional
        Default settings if absent.
    place : callable
        Index of a sample -> its place, for messages.

    Returns
    -------
    Segmentation
        Every sample in one stretch.

    Raises
    ------
    DataError
        If a channel has no values, fewer than 16 good samples are left, or the time does not fit.
    """
    plan = plan or Detection()
    samples = samples_of(signal, time_ns, sample_interval, place)
    n, channels = samples.values.shape
    whole = batches.every(samples.finite, lambda part: part.all())
    rows = None if whole else _places(samples.finite)
    many = n if rows is None else len(rows)
    if not many and n:
        dead = [str(k) for k in range(channels) if not np.isfinite(samples.values[:, k]).any()]
        if dead:
            raise DataError(
                f"channel {', '.join(dead)} of {channels} holds no value",
                why="all channels must be still at once",
                do="Leave out the channel",
                code="no_values",
            )
    if many < 2 * BLOCK:
        raise DataError(
            f"{many} good sample(s) of {n}, need {2 * BLOCK} or more",
            why="the noise cannot be measured",
            code="too_short",
        )
    good, ticks = samples.values, None if whole and time_ns is None else samples.ticks
    if rows is not None and ticks is not None:
        good = batches.stacked([batches.kept(own, samples.finite) for own in good.T])
        ticks = batches.kept(ticks, samples.finite)
    return _segmentation(samples, rows, still_stretches(good, ticks, plan), plan)


def _segmentation(samples: Samples, rows: Indices | None, found: Found, plan: Detection) -> Segmentation:
    """Fill what lies between the still stretches with moving ones, and measure them all.

    ``rows`` are the good samples; None where all are good.
    """
    n = len(samples.values)
    first, after, outlier = found.start, found.stop, batches.zeros(n, bool)
    outlier[found.outlier if rows is None else rows[found.outlier]] = True
    if rows is not None:
        first, after = rows[found.start], rows[found.stop - 1] + 1
    samples = replace(samples, outlier=outlier)
    edges = np.unique(np.concatenate(([0, n], first, after)))
    start, stop = edges[:-1], edges[1:]
    still = np.isin(start, first)
    level, scatter, frozen = _measured(samples, edges, rows is None and not len(found.outlier))
    stuck = still & (frozen & found.noise.live).any(axis=1)
    return Segmentation(start, stop, still, level, scatter, found.noise, found.widening, samples, stuck, plan)


def _measured(samples: Samples, edges: Indices, whole: bool) -> tuple[Array, Array, Flags]:
    """Give mean and standard deviation of the good samples of each stretch, and whether all are equal.

    ``whole``: whether all samples are good.
    """
    finite, outlier = samples.finite, samples.outlier
    left_out = None
    if not whole:
        left_out = batches.made(len(finite), bool, lambda a, b: ~finite[a:b] | outlier[a:b], finite, outlier)
    shape = len(edges) - 1, samples.values.shape[1]
    level, variance, low, high = (np.empty(shape, order="F") for _ in range(4))
    count = np.empty(shape[0], dtype=np.int64)
    for k in range(shape[1]):
        x = samples.values[:, k]
        if left_out is not None:
            x = batches.made(len(x), float, lambda a, b, x=x: np.where(left_out[a:b], np.nan, x[a:b]), left_out, x)  # type: ignore[misc]
        for own in _together(edges, batches.SIZE if batches.is_stored(x) else len(x)):
            first, stop = int(edges[own.start]), int(edges[own.stop])
            if stop - first > batches.SIZE and batches.is_stored(x):
                one = moments(x[first:stop])
                level[own, k], low[own, k], high[own, k] = one.mean, one.low, one.high
                variance[own, k] = one.squares / (one.count - 1) if one.count > 1 else np.nan
                continue
            out = (level[own, k], variance[own, k], low[own, k], high[own, k], count[own])
            ends = edges[own.start : own.stop + 1] - first
            loops_for(len(x)).fill_moments(x[first:stop], ends[:-1], ends[1:], *out)
            batches.release(x[first:stop])
    return np.ascontiguousarray(level), np.sqrt(np.ascontiguousarray(variance)), low == high


def _together(edges: Indices, most: int) -> list[slice]:
    """Return neighbouring stretches that have no more samples together, or one alone that has more."""
    found, first, n = [], 0, len(edges) - 1
    while first < n:
        after = max(int(np.searchsorted(edges, edges[first] + most, side="right")) - 1, first + 1)
        found.append(slice(first, after))
        first = after
    return found


def _places(flags: Flags) -> Indices:
    """Return the samples that are flagged, ascending; stored where they are many."""
    every = batches.made(len(flags), np.int64, np.arange)
    return np.asarray(batches.kept(every, flags))


def _samples_like(segmentation: Segmentation, signal: Numbers | None) -> Samples:
    """Give the samples of a signal of the same clock, or of the segmented one where it is absent."""
    own = segmentation.samples
    if signal is None:
        return own
    other = samples_of(signal)
    if len(other.values) != len(own.values):
        raise DataError(f"{len(other.values)} samples, the segmented signal has {len(own.values)}")
    return replace(own, values=other.values, finite=other.finite)


def dwells(
    segmentation: Segmentation,
    signal: Numbers | None = None,
    *,
    min_samples: int | None = None,
    min_duration: float | None = None,
    drop_edge: int = 1,
) -> tuple[Dwell, ...]:
    """Reduce every still stretch that is long enough.

    Parameters
    ----------
    segmentation : Segmentation
        From ``detect``.
    signal : ndarray, shape (n,) or (n, channels), optional
        What to reduce, on the same clock; the segmented signal by default.
    min_samples, min_duration : int, float [s]
        Shortest stretch, before its edges are dropped; every still stretch by default.
    drop_edge : int
        Good samples to drop at each end, one by default.

    Returns
    -------
    tuple of Dwell
        In order of time; ``tally`` tells where the other samples went.

    Raises
    ------
    DataError
        If the signal has another length.
    PlanError
        If a duration is given and no sample interval is known.
    """
    samples = _samples_like(segmentation, signal)
    shortest = samples.duration(min_samples, min_duration, segmentation.plan.shortest)
    chosen = segmentation.still & (segmentation.stop - segmentation.start >= shortest)
    return _reduced(samples, segmentation.start[chosen], segmentation.stop[chosen], drop_edge)


def _reduced(samples: Samples, start: Indices, stop: Indices, drop_edge: int) -> tuple[Dwell, ...]:
    every = (dwell_of(samples, int(a), int(b), drop_edge) for a, b in zip(start, stop, strict=True))
    return tuple(dwell for dwell in every if dwell is not None)


def static_intervals(
    segmentation: Segmentation,
    signal: Numbers | None = None,
    *,
    min_samples: int | None = None,
    min_duration: float | None = None,
    longest_disturbance: float = 0.5,
    same_level: float = 5.0,
    drop_edge: int = 1,
) -> tuple[Dwell, ...]:
    """Reduce one still stretch for each placement of a sensor.

    A sensor set down by hand settles and is jogged: one placement can show several still stretches at nearly
    one level. Of each placement the longest is taken; the rest of it is counted as disturbed.

    Parameters
    ----------
    segmentation : Segmentation
        From ``detect``.
    signal : ndarray, shape (n,) or (n, channels), optional
        What to reduce, on the same clock; the segmented signal by default.
    min_samples, min_duration : int, float [s]
        Shortest stretch, before its edges are dropped; one second by default.
    longest_disturbance : float
        Longest moving stretch inside a placement, as a part of the shortest static interval.
    same_level : float
        Largest difference of level inside a placement, in standard deviations of the noise.
    drop_edge : int
        Good samples to drop at each end, one by default.

    Returns
    -------
    tuple of Dwell
        In order of time.

    Raises
    ------
    DataError
        If the signal has another length.
    PlanError
        If the length is in seconds and no sample interval is known.
    """
    samples = _samples_like(segmentation, signal)
    if min_samples is None and min_duration is None:
        min_duration = 1.0
    shortest = samples.duration(min_samples, min_duration, segmentation.plan.shortest)
    found = []
    for group in placement_groups(segmentation, longest_disturbance * shortest, same_level):
        length = segmentation.stop[group] - segmentation.start[group]
        best = group[int(np.argmax(length))]
        a, b = int(segmentation.start[best]), int(segmentation.stop[best])
        whole = int(segmentation.stop[group[-1]] - segmentation.start[group[0]])
        dwell = dwell_of(samples, a, b, drop_edge, whole - (b - a)) if b - a >= shortest else None
        if dwell is not None:
            found.append(dwell)
    return tuple(found)


def placement_groups(segmentation: Segmentation, longest: float, same_level: float) -> list[Indices]:
    """Still stretches, grouped where only a short disturbance parts them and the level stays."""
    at = np.flatnonzero(segmentation.still)
    if not len(at):
        return []
    finite = segmentation.samples.finite  # what is missing has not moved
    apart = batches.counts_before(finite, segmentation.start[at[1:]])
    apart -= batches.counts_before(finite, segmentation.stop[at[:-1]])
    step = np.abs(np.diff(segmentation.level[at], axis=0)) - same_level * segmentation.noise.scale
    new = (apart > longest) | (step > 0.0).any(axis=1)
    return np.split(at, np.flatnonzero(new) + 1)
