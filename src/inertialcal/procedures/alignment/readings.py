"""Readings of an alignment: what accelerometers and gyros read in each position, and how the unit was turned between.

A position is a rest of the gyros, or all of a recording in which nothing turns. Rests are found by means over half a
second: what is 0.3 deg/s off the median of all, or 0.1 deg/s off that of the minute around, and 8 times the scatter, is
a turn; what is left of a turn at the ends of a rest is left out the same way. Two rests between which the unit turned
by less than 2 deg are one position, with the knock left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES, Kind, Origin
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.show.rounding import items, number
from ...core.unknowns import Unknowns
from ...core.unknowns import joined as unknowns_joined
from ..corrections import corrected
from ..protocol import Correction, Source
from .plan import Plan

KINDS: tuple[Kind, Kind] = ("accelerometer", "gyro")
STEP = 0.5  # time over which rates are averaged to see a turn [s]
TURNS, NEAR = math.radians(0.3), math.radians(0.1)  # mean rate that is a turn, off the median of all and around [rad/s]
AROUND = 60.0  # [s]
CLEAR = 8.0  # standard deviations of such a mean
KNOCK = math.radians(2.0)  # turn between two rests, below which they are one position
BLOCKS, LEAST = 240, 32  # means that a position is cut into, and that are needed
OVERLAP = 0.9  # of the shorter record, that both sensors must share
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Position:
    """What both triads read in one position, as block means over its time."""

    acc: Array  # shape (n, 3): [m/s^2]
    gyro: Array  # shape (n, 3): [rad/s]
    seconds: float  # length [s]
    start: float  # since the start of the first recording of the test [s]
    name: str = ""  # of its recording
    file: str = ""
    # shape (3, 3): body axes of this position in those of the one before, as the gyros measured; None: not recorded
    turned: Array | None = None
    angle: float = 0.0  # turned by in all since the one before, about the vertical, several turns counted [rad]
    raw: tuple[Array, Array] | None = None  # samples of the accelerometers and of the gyros, (n, 3) each

    @property
    def mean_acc(self) -> Array:
        """Mean specific force, shape (3,) [m/s^2]."""
        return np.asarray(self.acc.mean(axis=0))

    @property
    def mean_gyro(self) -> Array:
        """Mean rate, shape (3,) [rad/s]."""
        return np.asarray(self.gyro.mean(axis=0))


@dataclass(frozen=True, eq=False)
class Readings:
    """All positions of a test, in order."""

    positions: tuple[Position, ...]
    # Of each kind of sensor: what earlier tests found, that was taken off, a dwell a position
    taken_off: dict[Kind, dict[Origin, Unknowns]]
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of positions."""
        return len(self.positions)

    @property
    def runs(self) -> int:
        """Number of recordings."""
        return len({one.name for one in self.positions})


@dataclass(frozen=True, eq=False)
class Pair:
    """A recording of each triad, of the same time."""

    sources: tuple[Source, Source]
    recordings: tuple[Recording, Recording]

    @property
    def file(self) -> str:
        """Of the gyros."""
        return self.sources[1].file

    def seconds(self, which: Literal[0, 1]) -> Array:
        """Return the times of one triad, on their common clock [s]."""
        one, first = self.recordings[which], self.recordings[0]
        if one.time_ns is None:
            return np.asarray(np.arange(len(one)) * (one.sample_interval or 1.0))
        zero = one.time_ns[0] if first.time_ns is None else first.time_ns[0]
        return np.asarray((one.time_ns - zero) / SECOND)


def readings_from(plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
    """Return the positions of all recordings.

    Raises
    ------
    DataError
        ``no_accelerometers``, ``no_gyros``, ``no_axes``, ``no_time``, ``clocks_differ``, ``too_short``, ``no_values``,
        ``copied_recording``.
    """
    pairs = _pairs(sources)
    remarks = [one for pair in pairs for each in pair.recordings for one in each.remarks]
    found: list[Position] = []
    off: dict[Kind, list[dict[Origin, Unknowns]]] = {kind: [] for kind in KINDS}
    for pair in pairs:
        spans, said = _rests(plan, pair)
        remarks += said
        before: tuple[float, float, Flags] | None = None
        for first, stop, keep in spans:
            cut, unknown = _cut(pair, first, stop, keep, corrections)
            one = _position(pair, cut, first, stop, _origin(pairs, pair))
            if before is not None:
                turned, angle = _turn(pair, before[0], before[1], first, stop, found[-1], one)
                one = replace(one, turned=turned, angle=angle)
            found.append(one)
            before = (first, stop, keep)
            for kind, own in zip(KINDS, unknown, strict=True):
                off[kind].append(own)
    _check_copies(found)
    taken_off = {kind: dict(unknowns_joined(parts, [1] * len(parts))) for kind, parts in off.items()}
    return Readings(tuple(found), taken_off, tuple(dict.fromkeys(remarks)))


def _origin(pairs: Sequence[Pair], pair: Pair) -> float:
    """Return when a recording began, since the first one did; 0 where clocks do not tell [s]."""
    first, own = pairs[0].recordings[1], pair.recordings[1]
    if first.time_ns is None or own.time_ns is None or first.epoch != own.epoch:
        return 0.0
    return float(own.time_ns[0] - first.time_ns[0]) / SECOND


def _pairs(sources: Sequence[Source]) -> list[Pair]:
    by_kind: dict[str, list[tuple[Source, Recording]]] = {kind: [] for kind in KINDS}
    for source in sources:
        for _, recording in source.recordings():
            by_kind.setdefault(str(source.facts.kind), []).append((source, recording))
    for kind, code in zip(KINDS, ("no_accelerometers", "no_gyros"), strict=True):
        if not by_kind[kind]:
            why = "gravity tells the vertical, the rate of the earth tells north: both are needed"
            what, do = f"no recording of {kind}s", "Give a file, or a recording, of all six axes"
            raise DataError(what, sources[0].file, why, do, code)
    acc, gyro = by_kind["accelerometer"], by_kind["gyro"]
    if len(acc) != len(gyro):
        what = f"{items(len(acc), 'recording')} of accelerometers and {len(gyro)} of gyros"
        raise DataError(what, why="they are paired in their order", do="Give as many of both", code="wrong_value")
    pairs = [Pair((a[0], g[0]), (a[1], g[1])) for a, g in zip(acc, gyro, strict=True)]
    for pair in pairs:
        _check_pair(pair)
    return pairs


def _check_pair(pair: Pair) -> None:
    for source, one in zip(pair.sources, pair.recordings, strict=True):
        if missing := [axis for axis in AXES if axis not in one.names]:
            what = f"recordings.{source.name}: no channel {', '.join(missing)}"
            raise DataError(what, source.file, "an attitude needs all three axes of both triads", code="no_axes")
        if (one.time_ns is None and one.sample_interval is None) or len(one) < LEAST:
            what = f"recordings.{source.name}: no time" if len(one) >= LEAST else f"{items(len(one), 'sample')}"
            do = "Give the sample rate, or record the time of each sample" if len(one) >= LEAST else "Record longer"
            raise DataError(what, source.file, do=do, code="no_time" if len(one) >= LEAST else "too_short")
    acc, gyro = pair.seconds(0), pair.seconds(1)
    together = min(acc[-1], gyro[-1]) - max(acc[0], gyro[0])
    if together < OVERLAP * min(acc[-1] - acc[0], gyro[-1] - gyro[0]):
        what = f"recordings {pair.sources[0].name} and {pair.sources[1].name} are not of one time"
        do = "Give recordings of both triads on one clock"
        raise DataError(what, pair.file, "both must lie in the same position", do, "clocks_differ")


def _rests(plan: Plan, pair: Pair) -> tuple[list[tuple[float, float, Flags]], list[Remark]]:
    """Return the positions of a recording: first and last instant [s], and which samples of the gyros count.

    Raises
    ------
    DataError
        ``too_short``, ``no_rest``.
    """
    seconds, rates = pair.seconds(1), np.asarray(pair.recordings[1].array(AXES), dtype=float)
    length = float(seconds[-1] - seconds[0])
    if length < plan.shortest:
        what = f"the record lasts {number(length, 3)} s, need {number(plan.shortest, 3)} s"
        do = "Record longer, a quarter of an hour for each position; or check the unit of its time"
        raise DataError(what, pair.file, "the rate of the earth is small, and its mean takes time", do, "too_short")
    interval = length / (len(seconds) - 1)
    size = max(round(STEP / interval), 1)
    means = _block_means(rates, size)
    away, scale = _away(means)
    around = median_filter(away, (max(round(AROUND / (size * interval)), 1), 1), mode="nearest")
    moving = np.any((np.abs(away) > np.maximum(TURNS, CLEAR * scale))
                    | (np.abs(away - around) > np.maximum(NEAR, CLEAR * scale)), axis=1)  # fmt: skip
    runs = _runs(~moving)
    spans = [((first + (first > 0)) * size, (stop - (stop < len(means))) * size) for first, stop in runs]
    spans = [one for one in spans if one[1] > one[0]]
    spans = [_trimmed(rates, one, size) for one in spans]
    enough = [one for one in spans if (one[1] - one[0]) * interval >= plan.shortest]
    if not enough:
        longest = max(((b - a) * interval for a, b in spans), default=0.0)
        what = f"the unit never rests for {number(plan.shortest, 3)} s; the longest rest lasts {number(longest, 3)} s"
        do = "Let it rest on a base that does not move; or check the unit of the rates"
        raise DataError(what, pair.file, "an alignment averages over a rest", do, "no_rest")
    joined: list[tuple[int, int]] = []
    remarks: list[Remark] = []
    for one in enough:
        knock = joined and float(np.linalg.norm(_rotation(seconds, rates, joined[-1][1], one[0]))) < KNOCK
        joined = [*joined[:-1], (joined[-1][0], one[1])] if knock else [*joined, one]
        if knock:
            where = number(float(seconds[one[0]]), 4)
            what = f"the unit was knocked before {where} s and lies as it lay: the knock is left out"
            remarks.append(Remark("knocked", "warning", what, pair.file, do="Leave it alone while it aligns"))
    keep = np.zeros(len(seconds), dtype=bool)
    for first, stop in enough:
        keep[first:stop] = True
    spare = length - float(np.count_nonzero(keep)) * interval
    if len(spans) > len(enough) and spare > 0.0:
        short = len(spans) - len(enough)
        what = f"{items(short, 'rest')} shorter than {number(plan.shortest, 3)} s: left out"
        remarks.append(Remark("short_rest", "info", what, pair.file, short))
    return [(float(seconds[a]), float(seconds[b - 1]), keep) for a, b in joined], remarks


def _block_means(values: Array, size: int) -> Array:
    """Return means over blocks of samples, missing ones left out, shape (n, 3)."""
    count = max(len(values) // size, 1)
    blocks = values[: count * size].reshape(count, -1, 3) if count * size <= len(values) else values[None]
    there = np.isfinite(blocks)
    total = np.where(there, blocks, 0.0).sum(axis=1)
    return np.asarray(np.divide(total, there.sum(axis=1), out=np.full(total.shape, np.nan), where=there.any(axis=1)))


def _middle(values: Array) -> Array:
    """Return the median of each column without what is missing, 0 where all is, shape (3,)."""
    there = np.isfinite(values).any(axis=0)
    found = np.zeros(values.shape[1])
    found[there] = np.nanmedian(values[:, there], axis=0)
    return found


def _away(means: Array) -> tuple[Array, Array]:
    """Return how far means lie from the middle, shape (n, 3), and the scatter from one to the next, shape (3,)."""
    steps = np.diff(means, axis=0)
    scale = _middle(np.abs(steps)) * 1.4826 / math.sqrt(2.0) if len(steps) else np.zeros(3)
    return np.nan_to_num(means - _middle(means)), np.nan_to_num(scale)


def _runs(flags: Flags) -> list[tuple[int, int]]:
    """Return the stretches that are flagged, half-open."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.view(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _trimmed(rates: Array, span: tuple[int, int], size: int) -> tuple[int, int]:
    """Return a rest without the rest of a turn at its ends, which is too slow to show before it is known."""
    first, stop = span
    means = _block_means(rates[first:stop], size)
    if len(means) < LEAST:
        return span
    away, scale = _away(means)
    slow = np.any(np.abs(away) > CLEAR * np.maximum(scale, 1e-12), axis=1)
    quiet = np.flatnonzero(~slow)
    if not len(quiet):
        return span
    lead = int(np.argmax(~slow)) if slow[0] else 0
    tail = int(np.argmax(~slow[::-1])) if slow[-1] else 0
    return first + lead * size, stop - tail * size


def _rotation(seconds: Array, rates: Array, first: int, stop: int) -> Array:
    """Return the angles about each axis between two rests, less what is read at rest, shape (3,) [rad]."""
    if stop <= first:
        return np.zeros(3)
    part = np.nan_to_num(rates[first:stop] - _middle(rates))
    steps = np.gradient(seconds[first:stop]) if stop - first > 1 else np.array([0.0])
    return np.asarray(steps @ part)


def _cut(
    pair: Pair, first: float, stop: float, keep: Flags, corrections: Sequence[Correction]
) -> tuple[list[Recording], list[dict[Origin, Unknowns]]]:
    """Return the samples of both triads in a position, after corrections, and what is not known of these."""
    named = []
    kept = pair.seconds(1)[keep]
    for which in (0, 1):
        one, at = pair.recordings[which], pair.seconds(which)
        inside = (at >= first) & (at <= stop)
        if which == 1:
            inside &= keep
        elif len(kept):
            near = np.clip(np.searchsorted(kept, at), 1, len(kept) - 1)
            step = float(np.median(np.diff(kept)))
            inside &= np.minimum(np.abs(kept[near] - at), np.abs(kept[near - 1] - at)) <= max(step, STEP)
        channels = tuple(replace(c, data=c.data[inside]) for c in one.channels)
        times = None if one.time_ns is None else one.time_ns[inside]
        named.append((pair.sources[which].name, replace(one, channels=channels, time_ns=times)))
    if not corrections:
        return [one for _, one in named], [{}, {}]
    made, unknowns = corrected(corrections, named)
    return made, [dict(one) for one in unknowns]


def _position(pair: Pair, cut: Sequence[Recording], first: float, stop: float, origin: float) -> Position:
    values = [np.asarray(one.array(AXES), dtype=float) for one in cut]
    means = []
    for kind, own in zip(KINDS, values, strict=True):
        blocks = _block_means(own, max(len(own) // BLOCKS, 1))
        there = np.isfinite(blocks).all(axis=1)
        if np.count_nonzero(there) < LEAST or np.count_nonzero(there) < 0.5 * len(blocks):
            what = f"the {kind}s hold {items(int(np.isfinite(own).all(axis=1).sum()), 'reading')} in a rest of "
            what += f"{number(stop - first, 4)} s"
            do = "Record again, or longer"
            raise DataError(what, pair.file, "the uncertainty rests on their scatter", do, "too_short")
        means.append(blocks[there])
    return Position(means[0], means[1], stop - first, origin + first, pair.sources[1].name, pair.file,
                    raw=(values[0], values[1]))  # fmt: skip


def _turn(
    pair: Pair, before: float, left: float, first: float, stop: float, old: Position, new: Position
) -> tuple[Array, float]:
    """Return how the unit turned from one rest to the next by its gyros, and by how much about the vertical.

    What both rests read (bias, rate of the earth) is taken off. The angle is positive clockwise seen from above.
    """
    seconds = pair.seconds(1)
    inside = (seconds >= left) & (seconds <= first)
    rates = np.asarray(pair.recordings[1].array(AXES), dtype=float)
    at_rest = 0.5 * (_middle(rates[(seconds >= before) & (seconds <= left)])
                     + _middle(rates[(seconds >= first) & (seconds <= stop)]))  # fmt: skip
    part, times = rates[inside] - at_rest, seconds[inside]
    good = np.isfinite(part).all(axis=1)
    part, times = part[good], times[good]
    turned, angle, down = np.eye(3), 0.0, -old.mean_acc / np.linalg.norm(old.mean_acc)
    for step, one, other in zip(np.diff(times), part[:-1], part[1:], strict=True):
        small = 0.5 * (one + other) * step
        angle += float(small @ (turned.T @ down))
        turned = turned @ rotation_of(small)
    return turned, angle


def rotation_of(vector: Array) -> Array:
    """Return the matrix of a rotation by the length of a vector about it, shape (3, 3)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross)


def _check_copies(found: Sequence[Position]) -> None:
    for i, one in enumerate(found):
        for j, other in enumerate(found[:i]):
            if one.raw is None or other.raw is None:
                continue
            alike = [len(a) == len(b) and np.array_equal(a, b, equal_nan=True)
                     for a, b in zip(one.raw, other.raw, strict=True)]  # fmt: skip
            if any(alike):
                what = f"positions {j + 1} and {i + 1} hold the same readings"
                do = "Give the recording of each position"
                raise DataError(what, one.file, "no two records have the same noise", do, "copied_recording")
