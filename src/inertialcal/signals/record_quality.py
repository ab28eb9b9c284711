"""Whether a record at rest is fit for noise terms: stuck stretches, disturbances, motion, and drift beyond slow noise.

*Stuck* is one value repeated far longer than others (``codes``). *Disturbances* are what the one detector of still
and moving stretches takes for such (``stillness``). Noise terms fitted across either are wrong;
``RecordQuality.cleaned`` has NaN there, for estimators that allow gaps. Motion that never stops looks to that detector
like noise that is not white: it is remarked, as nobody can tell it from a filtered output without knowing the sensor.

*Drift* is what slow noise does not explain (``drift``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError
from ..core.estimate import Array, Numbers
from ..core.remarks import Remark
from ..core.show.rounding import number
from .allan.channel import checked_names, code_remarks
from .codes import is_stuck, longest_run
from .drift import Drift, drift_of
from .segmentation.segments import NOT_WHITE
from .segmentation.stillness import Disturbance, Stillness, judge

__all__ = ["BadSegment", "Drift", "RecordQuality", "record_quality", "stuck_stretches"]

MOST_STUCK = 20  # stuck stretches of an axis that are looked for


@dataclass(frozen=True)
class BadSegment:
    """A stretch of one axis that is disturbed or stuck."""

    axis: int  # which
    # first, last: samples of the record
    first: int
    last: int
    # start, stop: the same since the first sample [s]
    start: float
    stop: float
    peak: float  # largest deviation from the level around, in standard deviations of the noise; 0 where stuck


@dataclass(frozen=True, eq=False)
class RecordQuality:
    """What stands in the way of noise terms."""

    bad: tuple[BadSegment, ...]  # disturbances, by axis and time
    stuck: tuple[BadSegment, ...]  # stretches of one value, the longest of an axis first
    moving: tuple[int, ...]  # axes that are not at rest at all
    # by how much more than white noise the means of the widest windows scatter, for each axis; NaN where it is too
    # short to be judged
    widening: tuple[float, ...]
    drifts: tuple[Drift, ...]  # of the axes that could be tested
    values: Array  # the record, shape (n, axes)
    interval: float  # from sample to sample [s]
    names: tuple[str, ...]  # of the axes

    def cleaned(self) -> Array:
        """Return the record with NaN where it is disturbed or stuck, shape (n, axes)."""
        out = self.values.copy()
        for one in (*self.bad, *self.stuck):
            out[one.first : one.last + 1, one.axis] = np.nan
        return out

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """One remark an axis and kind, codes among them: constant, stuck, at the end of the range."""
        found: list[Remark] = []
        for axis, name in enumerate(self.names):
            found += [*_code_remarks(self.values[:, axis], name), *self._motion_remarks(axis)]
        return (*found, *(drift.remark(self.names[drift.axis]) for drift in self.drifts if drift.significant))

    def _motion_remarks(self, axis: int) -> list[Remark]:
        found, name = [], self.names[axis]
        bad = [one for one in self.bad if one.axis == axis]
        if axis in self.moving:
            do = "Noise terms need a record of a sensor at rest"
            found.append(Remark("not_at_rest", "warning", f"{name}: not at rest, or the level steps", do=do))
        elif self.widening[axis] > NOT_WHITE:
            what = (
                f"{name}: window means scatter {number(self.widening[axis], 2)} times as much as white noise: "
                "the output is filtered, or the sensor moves all the time"
            )
            found.append(Remark("noise_not_white", "warning", what, do="Check that the sensor was at rest"))
        if bad:
            worst = max(bad, key=lambda one: one.peak)
            lost = sum(one.last - one.first + 1 for one in bad) * self.interval
            what = (
                f"{name}: disturbed for {number(lost, 3)} s in all, by up to {number(worst.peak, 3)} "
                "standard deviations of the noise"
            )
            do = "Leave it out, or record again undisturbed"
            found.append(Remark("disturbed", "warning", what, f"{number(bad[0].start, 6)} s", len(bad), do))
        return found


def _code_remarks(x: Array, name: str) -> tuple[Remark, ...]:
    finite = x[np.isfinite(x)]
    if len(finite) > 1 and np.all(finite == finite[0]):
        do = "Check the wiring and the resolution"
        return (Remark("constant", "warning", f"{name}: all samples are equal", do=do),)
    return code_remarks(finite, name)


def record_quality(
    x: Numbers, interval: float, floor: float = 0.0, names: tuple[str, ...] | None = None
) -> RecordQuality:
    """Look a record at rest through for what its noise terms should not be fitted to.

    Parameters
    ----------
    x : ndarray, shape (n,) or (n, axes)
        Evenly spaced samples of a rate or acceleration, NaN where one is missing.
    interval : float
        From sample to sample [s].
    floor : float
        Smallest standard deviation that the noise may have: the resolution step.
    names : tuple of str, optional
        Of the axes, for remarks.

    Returns
    -------
    RecordQuality
        With remarks, and the record without its bad segments.

    Raises
    ------
    DataError
        If the record has another shape, or the interval is not positive.
    PlanError
        If there are more or fewer names than axes.
    """
    values = np.asarray(x, dtype=np.float64)
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or not values.shape[1]:
        raise DataError(f"a signal of shape {np.shape(x)}, need (n,) or (n, axes)", code="bad_shape")
    if not (np.isfinite(interval) and interval > 0.0):
        raise DataError(f"a sample interval of {interval} s", do="It must be positive", code="bad_interval")
    labels = checked_names(names, values.shape[1])
    each = [_looked_through(values[:, axis], axis, interval, floor) for axis in range(values.shape[1])]
    return RecordQuality(
        bad=tuple(bad for one in each for bad in one.bad),
        stuck=tuple(stuck for one in each for stuck in one.stuck),
        moving=tuple(axis for axis, one in enumerate(each) if one.rest is not None and not one.rest.at_rest),
        widening=tuple(np.nan if one.rest is None else one.rest.widening for one in each),
        drifts=tuple(drift for one in each for drift in one.drifts),
        values=values,
        interval=interval,
        names=labels,
    )


@dataclass(frozen=True)
class _Axis:
    """What is found of one axis; ``rest`` is None where it is too short to be judged."""

    rest: Stillness | None
    bad: tuple[BadSegment, ...]
    stuck: tuple[BadSegment, ...]
    drifts: tuple[Drift, ...]


def _looked_through(x: Array, axis: int, interval: float, floor: float) -> _Axis:
    stuck = stuck_stretches(x, interval, axis)
    left = _without(x, stuck)
    rows = np.flatnonzero(np.isfinite(left))
    rest = judge(left[rows], floor)
    bad = () if rest is None else tuple(_placed(one, axis, rows, interval) for one in rest.disturbances)
    return _Axis(rest, bad, stuck, drift_of(_without(left, bad), axis, interval))


def stuck_stretches(x: Array, interval: float, axis: int = 0) -> tuple[BadSegment, ...]:
    """Return the stretches in which one value is repeated far too long, the longest first; none if all are equal.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples of one axis, NaN where one is missing.
    interval : float
        From sample to sample [s].
    axis : int
        Number that the stretches get.
    """
    rows = np.flatnonzero(np.isfinite(x))
    found: list[BadSegment] = []
    while len(found) < MOST_STUCK and len(rows) > 1 and np.any(x[rows] != x[rows[0]]) and is_stuck(x[rows]):
        run = longest_run(x[rows])
        first, last = int(rows[run.start]), int(rows[run.start + run.length - 1])
        found.append(BadSegment(axis, first, last, first * interval, last * interval, 0.0))
        rows = np.delete(rows, slice(run.start, run.start + run.length))
    return tuple(found)


def _without(x: Array, segments: Sequence[BadSegment]) -> Array:
    """Return a copy of one axis with NaN in its segments."""
    out = x.copy()
    for one in segments:
        out[one.first : one.last + 1] = np.nan
    return out


def _placed(one: Disturbance, axis: int, rows: NDArray[np.int64], interval: float) -> BadSegment:
    first, last = int(rows[one.first]), int(rows[one.last])
    return BadSegment(axis, first, last, first * interval, last * interval, one.peak)
