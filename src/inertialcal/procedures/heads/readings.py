"""Readings of heads on one body: each with its place, on the common clock; and a gyro's where one was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.show.rounding import items, number
from ...physics.motion.body import Body, Motion, Mounted, read_body
from ..protocol import Source
from .entry import HeadEntry

LEAST = 3  # heads
HELD, RAILED = 3, 5  # equal samples in a row, and in all, at the end of the range, by which a head is saturated
Flags = NDArray[np.bool_]
ALIKE = 1e-9  # of what two heads read, by which they differ at least


@dataclass(frozen=True, eq=False)
class Track:
    """What one head, or the gyro, read."""

    times: Array  # shape (n,): on the common clock [s]
    values: Array  # shape (n, 3): in its own axes, NaN where missing [m/s^2], [rad/s]
    interval: float  # of its samples [s]
    mounted: Mounted
    name: str = ""  # of its recording
    file: str = ""

    @property
    def body(self) -> Array:
        """The same in axes of the body."""
        return np.asarray(self.values @ self.mounted.orientation)


@dataclass(frozen=True, eq=False)
class Readings:
    """All heads of a test."""

    tracks: tuple[Track, ...]
    motion: Motion
    gyro: Track | None = None
    gyro_bias_u: float = 0.0
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one.times) for one in self.tracks)

    @property
    def runs(self) -> int:
        """Number of recordings."""
        return len(self.tracks)


def readings_from(sources: Sequence[Source]) -> Readings:
    """Return what all heads read, on one clock.

    Raises
    ------
    DataError
        ``too_few_heads``, ``not_calibrated``, ``nothing_to_calibrate``, ``no_head``, ``head_twice``, ``bodies_differ``,
        ``no_axes``, ``not_one_body``, ``no_time``, ``clocks_differ``, ``copied_recording``.
    """
    remarks: list[Remark] = []
    body: Body | None = None
    read: list[tuple[Source, Recording, Mounted | None]] = []
    for source in sources:
        recording = source.recordings()[0][1]
        remarks += list(recording.remarks)
        said = cast("HeadEntry", source.entry).head
        if source.facts.kind == "gyro" or said is None:
            read.append((source, recording, None))
            continue
        own = source.read_file(said.file, read_body)
        if body is not None and own.file != body.file:
            what = f"recordings.{source.name}: its body is that of {said.file}, not of the heads before"
            raise DataError(what, source.file, do="Describe all heads in one file", code="bodies_differ")
        body = own
        name = said.name or source.name
        if name not in own.heads:
            what = f"recordings.{source.name}: no head {name!r} in {said.file}"
            do = f"There are: {', '.join(own.heads)}. Name a file like its head, or give the head before it: HEAD=FILE"
            raise DataError(what, source.file, "its position and orientation are needed", do, "no_head")
        if any(mounted is not None and mounted.name == name for _, _, mounted in read):
            what = f"head {name} has two recordings"
            raise DataError(what, source.file, do="Make a test of each stretch of time", code="head_twice")
        read.append((source, recording, own.heads[name]))
    _check_clocks(read)
    first = min(int(one.time_ns[0]) for _, one, _ in read if one.time_ns is not None)
    tracks, gyro = [], None
    for source, recording, mounted in read:
        if mounted is None:
            assert body is not None or len(read) < LEAST  # noqa: S101 - heads are refused below
            of_gyro = Mounted("gyro", np.zeros(3), np.eye(3) if body is None else body.gyro_orientation,
                              clock=0.0 if body is None else body.gyro_clock)  # fmt: skip
            gyro = _track(source, recording, of_gyro, first)
        else:
            one, left = _unsaturated(_track(source, recording, mounted, first))
            tracks.append(one)
            remarks += left
    _check_heads(tracks)
    assert body is not None  # noqa: S101 - there are three heads
    return Readings(tuple(tracks), body.motion, gyro, body.gyro_bias_u, tuple(remarks))


def _track(source: Source, recording: Recording, mounted: Mounted, first: int) -> Track:
    if missing := [axis for axis in AXES if axis not in recording.names]:
        what = f"recordings.{source.name}: no channel {', '.join(missing)}"
        raise DataError(what, source.file, "a body moves in three axes", code="no_axes")
    assert recording.time_ns is not None  # noqa: S101 - checked with the clocks
    seconds = (recording.time_ns - first) / SECOND
    times = seconds - (mounted.clock or 0.0) - mounted.clock_rate * (seconds - seconds[0])
    interval = float(recording.sample_interval or np.median(np.diff(times)))
    values = recording.array(AXES)
    for axis, one in zip(AXES, values.T, strict=True):
        there = one[np.isfinite(one)]
        if not len(there) or np.ptp(there) == 0.0:
            what = f"{source.name}: {axis} never changes"
            do = "Leave this head out, or check its columns"
            raise DataError(what, source.file, "a body moves in three axes", do, "not_one_body")
    return Track(times, values, interval, mounted, source.name, source.file)


def _check_clocks(read: Sequence[tuple[Source, Recording, Mounted | None]]) -> None:
    """Refuse recordings without time, or on clocks that have no common zero."""
    for source, one, _ in read:
        if one.time_ns is None or len(one) < LEAST:
            what = f"recordings.{source.name}: no time"
            do = "Record the time of each sample"
            raise DataError(what, source.file, "heads are compared instant by instant", do, "no_time")
    if len({one.epoch for _, one, _ in read}) > 1:
        utc = next(source.name for source, one, _ in read if one.epoch == "utc")
        other = next(source for source, one, _ in read if one.epoch != "utc")
        what = f"recordings.{other.name} counts from a start of its own, recordings.{utc} is in UTC"
        raise DataError(what, other.file, "there is no common time", "Record all on one clock",
                        "clocks_differ")  # fmt: skip


def _check_heads(tracks: Sequence[Track]) -> None:
    if len(tracks) < LEAST:
        what = f"{items(len(tracks), 'head')}, need {LEAST}"
        why = "two that are calibrated tell what a third would read"
        raise DataError(what, why=why, do="Give a recording of each head", code="too_few_heads")
    known = [one for one in tracks if one.mounted.calibrated]
    if len(known) < LEAST - 1:
        what = f"{items(len(known), 'calibrated head')}, need {LEAST - 1}"
        do = "Give each its bias and bias_u; or calibrated = true, and the result is relative to it"
        raise DataError(what, do=do, code="not_calibrated")
    if len(known) == len(tracks):
        what = "all heads are calibrated: none is left to calibrate"
        raise DataError(what, do="Leave out the bias of the head that is to be calibrated", code="nothing_to_calibrate")
    for i, one in enumerate(tracks):
        for other in tracks[:i]:
            if len(one.values) == len(other.values):
                left = np.nanstd(one.values - other.values, axis=0)
                size = np.nanstd(other.values, axis=0)
                if (left <= ALIKE * size).all():
                    what = f"recordings {other.name} and {one.name} are the same readings"
                    why = "no two heads have the same noise"
                    raise DataError(what, one.file, why, "Check which file is of which head", "copied_recording")


def _unsaturated(track: Track) -> tuple[Track, list[Remark]]:
    """Return what a head read without the samples at the end of its range."""
    values, count = np.array(track.values), 0
    for axis in range(3):
        one = track.values[:, axis]
        for end in (float(np.nanmax(one)), float(np.nanmin(one))):
            at = one == end
            if np.count_nonzero(at) < RAILED or np.nanstd(one) == 0.0:
                continue
            runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], at.view(np.int8), [0]]))))[::2]
            inside = np.count_nonzero(np.abs(one - end) < 0.1 * np.nanstd(one))
            if int(runs.max()) >= HELD and np.count_nonzero(at) > 0.5 * inside:
                values[at] = np.nan
                count += int(np.count_nonzero(at))
    if not count:
        return track, []
    what = f"head {track.mounted.name} is saturated: {count} samples at the end of its range are left out"
    do = "Use the range that holds the motion"
    remark = Remark("saturated", "warning", what, track.file, count, do, recording=track.name)
    return replace(track, values=values), [remark]


def aligned(readings: Readings, late: dict[str, tuple[float, float]]) -> Readings:
    """Return readings with further clock offsets of heads taken off: by name, with what is not known of it [s]."""
    tracks = []
    for one in readings.tracks:
        offset, u = late.get(one.mounted.name, (0.0, one.mounted.clock_u))
        tracks.append(replace(one, times=one.times - offset, mounted=replace(one.mounted, clock_u=u)))
    return replace(readings, tracks=tuple(tracks))


def span(readings: Readings) -> tuple[float, float]:
    """Return when all heads were read [s].

    Raises
    ------
    DataError
        ``no_common_time``.
    """
    every = [*readings.tracks, *([readings.gyro] if readings.gyro is not None else [])]
    start = max(float(one.times[0]) - 0.5 * one.interval for one in every)
    stop = min(float(one.times[-1]) + 0.5 * one.interval for one in every)
    if stop <= start:
        late = max(every, key=lambda one: float(one.times[0]))
        what = f"recordings.{late.name} begins {number(start - stop, 3)} s after another one ended"
        do = "Give recordings of the same time; check their clocks"
        raise DataError(what, late.file, "heads are compared instant by instant", do, "no_common_time")
    return start, stop


def edges_of(start: float, stop: float, interval: float) -> Array:
    """Return the ends of intervals between two instants [s]."""
    count = max(int((stop - start) / interval + 1e-6), 0)
    return np.asarray(start + interval * np.arange(count + 1), dtype=np.float64)
