"""Rests and rotations of a stream, by the functions that cut a recording: ``procedures.positions.recordings``.

Only a window is kept: the end of the last position that is settled, the rotation after it, the position after that, and
what came since. It is cut anew as samples come, with the noise that the first rest showed; a position is settled once
another one follows it. What is kept of settled positions are their mean readings and the samples of the rotations, so
that memory grows with the number of positions and not with time. A position longer than ``LONGEST_REST`` counts by its
first part, and a rotation longer than ``LONGEST_MOVE`` is not used: the procedure uses both on the whole recording.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND, Channel, Recording, Times
from ...procedures.positions.plan import Plan
from ...procedures.positions.readings import Readings
from ...procedures.positions.recordings import ACC, GYRO, joined, readings_from
from ...signals.segmentation.segments import Detection, Segmentation, detect

FEWEST = 32  # samples in which rest is looked for
LATE = 0.15  # a stretch that was at rest so short a time ago is so now: the last samples are too few to judge [s]
MARGIN = 0.5  # that an open rest lasts beyond the shortest, until it counts: its ends may turn out to be moved [s]
TAIL = 2.0  # of a settled position that is kept, beyond the shortest rest [s]
HELD = 6.0  # time in which it is seen whether what moves also turns [s]
LONGEST_REST, LONGEST_MOVE = 25.0, 40.0  # [s]


@dataclass(frozen=True)
class Now:
    """What the sensor does now."""

    still: bool = False  # Whether it rests
    since: float = 0.0  # For how long it has rested, or not [s]
    # shape (3,): mean reading of the accelerometers in this rest, or in the last half second [m/s^2]; None: none yet
    level: Array | None = None
    broken: float = 0.0  # Length of the rest that has just ended [s]; 0 where none has
    counts: bool = False  # Whether this rest is a position already
    wanders: float = np.inf  # Largest angle of the means of half a second from that of the last ``HELD`` seconds [rad]


class LiveRests:
    """Positions and rotations so far, of samples as they come.

    Parameters
    ----------
    plan : Plan
        With the shortest rest.
    interval : float
        From sample to sample [s].
    gyros : bool
        Whether there are gyros.
    """

    def __init__(self, plan: Plan, interval: float, gyros: bool) -> None:
        self.plan, self.interval, self.gyros = plan, interval, gyros
        self.shortest = float(plan.shortest or 0.0)
        self.now = Now()
        self._settled: Readings | None = None
        self._open: Readings | None = None  # positions of the window that are not settled, without the anchor
        self._anchor_ns: int | None = None  # last stamp of the last settled position, where the window holds it
        self._noise: tuple[float, ...] | None = None
        self._times, self._values = np.zeros(0, dtype=np.int64), np.zeros((0, 6 if gyros else 3))
        self._seen: tuple[int, ...] = ()  # lasting rests of the window when it was cut last

    @property
    def readings(self) -> Readings | None:
        """All positions so far, that of now with them once it has lasted; None without one."""
        return _after(self._settled, self._open)

    @property
    def bytes_kept(self) -> int:
        """Memory that samples and rotations take."""
        kept = [self._values.nbytes, self._times.nbytes]
        for part in (self._settled, self._open):
            for one in () if part is None else part.rotations:
                kept += [one.gyro.nbytes, one.seconds.nbytes, 0 if one.acc is None else one.acc.nbytes]
        return sum(kept)

    def part(self) -> None:
        """Begin anew after a gap: what was measured stays, the rotation through the gap is not known."""
        if self._open is not None:
            self._settle(len(self._open))
        self._forget(len(self._times))
        self._anchor_ns, self.now = None, Now()

    def undo(self) -> int | None:
        """Forget the last position and what came since; return when it began [ns], None where there is none."""
        readings = self.readings
        if readings is None:
            return None
        assert readings.start_ns is not None  # noqa: S101 - of recordings with stamps
        self._settled, self._open = _rows(readings, 0, len(readings) - 1), None
        self._forget(len(self._times))
        self._anchor_ns, self._seen, self.now = None, (), Now()
        return int(readings.start_ns[-1])

    def add(self, times: Times, values: Array) -> bool:
        """Take samples (n,) [ns], (n, 3 or 6) [m/s^2, rad/s] that follow the ones before; say whether readings changed.

        Raises
        ------
        DataError
            As `readings_from`, but for ``no_rest``.
        """
        self._times, self._values = np.concatenate([self._times, times]), np.vstack([self._values, values])
        if len(self._times) < FEWEST:
            return False
        found = detect(self._values[:, :3], self._times, self.interval, Detection(noise=self._noise))
        times, half = self._times, max(round(0.5 / self.interval), 1)  # what is settled is forgotten when it is cut
        recent = np.nanmean(self._values[-half:, :3], axis=0)
        lasting = self._lasting(found)
        changed = lasting != self._seen and self._cut(found)
        self._seen = lasting
        self._look(found, times, recent)
        self._bound()
        return changed

    def _look(self, found: Segmentation, times: Times, recent: Array) -> None:
        """See what the sensor does now."""
        still, n = np.flatnonzero(found.still), len(times)
        if not len(still):
            self.now = Now(False, n * self.interval, recent, wanders=self._wanders())
            return
        k = still[-1]
        first, last = int(found.start[k]), int(found.stop[k])
        if n - last <= max(LATE / self.interval, found.plan.shortest):
            counted = self._anchor_ns if self._open is None or self._open.stop_ns is None else self._open.stop_ns[-1]
            counts = counted is not None and int(counted) > int(times[first])
            self.now = Now(True, (last - first) * self.interval, found.level[k], counts=counts)
            return
        broken = (last - first) * self.interval if self.now.still else 0.0
        self.now = Now(False, (n - last) * self.interval, recent, broken, wanders=self._wanders())

    def _wanders(self) -> float:
        """Return by how much the direction changes, over means of half a second; infinite of too few samples."""
        size, many = max(round(0.5 / self.interval), 1), round(2.0 * HELD)
        if len(self._times) < size * many:
            return float("inf")
        blocks = np.nanmean(self._values[-size * many :, :3].reshape(many, size, 3), axis=1)
        middle = blocks.mean(axis=0)
        cosine = blocks @ middle / np.maximum(np.linalg.norm(blocks, axis=1) * np.linalg.norm(middle), 1e-9)
        return float(np.arccos(np.clip(cosine.min(), -1.0, 1.0)))

    def _lasting(self, found: Segmentation) -> tuple[int, ...]:
        """Return when each rest after the anchor that has lasted began [s], and whether it is over."""
        length = (found.stop - found.start) * self.interval
        ends = np.where(found.stop < len(self._times) - LATE / self.interval, found.stop, 0)
        long = found.still & (length >= np.where(ends > 0, self.shortest, self.shortest + MARGIN))
        first = self._times[found.start]
        if self._anchor_ns is not None:
            long &= first > self._anchor_ns
        began = first // SECOND  # where a rest begins is seen a few samples sooner or later each time
        return tuple(np.column_stack([began, ends > 0])[long].ravel().tolist())

    def _cut(self, found: Segmentation) -> bool:
        """Cut the window into positions and rotations."""
        try:
            cut = readings_from(self.plan, [self._recording()], noise=self._noise)
        except DataError as error:
            if error.problems[0].code in {"no_rest", "no_values"}:
                return False
            raise
        if self._noise is None and np.all(found.noise.scale > 0.0):
            self._noise = tuple(map(float, found.noise.scale))
        cut = replace(cut, remarks=())
        assert cut.start_ns is not None  # noqa: S101 - of a recording with stamps
        known = self._anchor_ns is not None and int(cut.start_ns[0]) <= self._anchor_ns
        self._open = _rows(cut, 1, len(cut)) if known else cut
        many = 0 if self._open is None else len(self._open)
        if many > 1:
            self._settle(many - 1)
        return many > 0

    def _settle(self, many: int) -> None:
        """Settle the first positions of the window, and keep the end of the last of them."""
        if self._open is None:
            return
        stop_ns = self._open.stop_ns
        assert stop_ns is not None  # noqa: S101 - of a recording with stamps
        last = int(np.searchsorted(self._times, stop_ns[many - 1]))
        self._anchor_ns = int(stop_ns[many - 1])
        self._settled = _after(self._settled, _rows(self._open, 0, many))
        self._open = _rows(self._open, many, len(self._open)) if many < len(self._open) else None
        self._forget(max(last - round((self.shortest + TAIL) / self.interval), 0))

    def _forget(self, first: int) -> None:
        """Forget the first samples of the window."""
        self._times, self._values = self._times[first:], self._values[first:]

    def _bound(self) -> None:
        """Bound the window: a long rest is settled, what is long before anything rests is forgotten."""
        limit = self.shortest + TAIL + LONGEST_MOVE
        long = self.now.still and self.now.since > LONGEST_REST
        if (long or (not self.now.still and self.now.since > LONGEST_MOVE)) and self._open is not None:
            self._settle(len(self._open))
        if long:
            most = round((self.shortest + TAIL) / self.interval)
            self._forget(max(len(self._times) - most, 0))
            self._anchor_ns = int(self._times[-1])  # it is the same position for as long as it rests
        elif len(self._times) * self.interval > limit + LONGEST_REST:
            self._forget(len(self._times) - round(LONGEST_MOVE / self.interval))

    def _recording(self) -> Recording:
        names = (*ACC, *GYRO) if self.gyros else ACC
        units = {name: "m/s^2" if name in ACC else "rad/s" for name in names}
        channels = tuple(Channel(name, self._values[:, k], units[name]) for k, name in enumerate(names))
        return Recording(channels, self._times, self.interval)


def _rows(readings: Readings, first: int, stop: int) -> Readings | None:
    """Return some of the positions; a rotation from the one before them begins at -1."""
    if first >= stop:
        return None
    turned = tuple(
        replace(one, before=one.before - first, after=one.after - first)
        for one in readings.rotations if first <= one.after < stop and one.before >= first - 1
    )  # fmt: skip
    return replace(readings.take(first, stop), rotations=turned)


def _after(one: Readings | None, other: Readings | None) -> Readings | None:
    """Return the positions of both as those of one recording; a rotation from -1 begins at the last of the first."""
    if one is None or other is None:
        found = one if other is None else other
        return found and replace(found, rotations=tuple(each for each in found.rotations if each.before >= 0))
    both = joined(one, replace(other, rotations=()))
    shift = len(one)
    turned = [replace(each, before=each.before + shift, after=each.after + shift) for each in other.rotations]
    assert both.start_ns is not None and both.stop_ns is not None  # noqa: S101, PT018 - of recordings with stamps
    span = (int(both.start_ns[0]), int(both.stop_ns[-1]))
    return replace(both, rotations=(*one.rotations, *turned), recordings=(0,) * len(both), spans_ns=(span,))
