"""Recordings of a unit that was laid into positions by hand, as static intervals and the rotations between them.

Static intervals are found by the accelerometers alone (``signals.segmentation.segments``): at rest
the level is that of gravity.
Where a protocol says which samples are which position or turn, sections are cut by it instead.
Gyros may have stamps of their own on the same clock: their means and rotations are then of their own samples.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, changed, count, made, zeros
from ...core.batches.summaries import moments
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark, gather
from ...signals.segmentation.dwells import moments_of
from ...signals.segmentation.placements import (
    Placement,
    between,
    disturbed_inside,
    filled,
    placements,
    shortest_placement,
)
from ...signals.segmentation.segments import Detection, detect
from ...signals.time.interpolation import interpolated
from ...signals.time.samples import LONGEST_GAP, Samples, all_finite, samples_of
from .orientations import check_sections, pointing
from .plan import Plan
from .readings import Readings, Rotation, Triad

ACC, GYRO = tuple(f"acc_{a}" for a in AXES), tuple(f"gyro_{a}" for a in AXES)
TEMPERATURE = "temperature"
FACE_WITHIN = 0.9  # cosine of the angle from a face, below which a position is none
HALF = 0.5  # of the samples of a position, that must be there
SMALL = 5e-4  # of all that a rotation turned: a gap that changes its angle by less is no matter


@dataclass(frozen=True)
class Section:
    """Samples [start, stop) that a protocol names: a position by its direction, or a turn by axis and angle [rad].

    ``direction`` is the specific force over gravity in body axes: (0, 0, 1) lies with z up. The angle is ``assumed``
    where nobody stated it.
    """

    start: int
    stop: int
    direction: tuple[float, float, float] | None = None
    axis: tuple[float, float, float] | None = None
    angle: float | None = None
    name: str = ""
    assumed: bool = False


def readings_from(
    plan: Plan,
    recordings: Sequence[Recording],
    sections: Sequence[Sequence[Section]] = (),
    faces: bool = False,
    saturated: Sequence[bool] = (),
    gyros: Sequence[Recording | None] = (),
    noise: tuple[float, ...] | None = None,
) -> Readings:
    """Return static intervals and rotations.

    Parameters
    ----------
    plan : Plan
        Shortest static interval.
    recordings : sequence of Recording
        Channels ``acc_x``, ``acc_y``, ``acc_z``, and ``gyro_x``, ... where there are gyros, in SI or in the unit of the
        output; ``temperature`` [degC] where it was read. All of one unit, in the order of time.
    sections : sequence of sequence of Section, optional
        For each recording what its protocol says; an empty one is cut by what the signal shows.
    faces : bool
        Each static interval lies on the face of the body that it is nearest to.
    saturated : sequence of bool, optional
        For each recording whether samples that are missing may be gyros at the end of their range.
    gyros : sequence of Recording or None, optional
        For each recording that of its gyros as it was, ``gyro_x``, ..., where its stamps are others: the recording then
        holds what was interpolated to its own stamps.
    noise : tuple of float, optional
        Standard deviation of a sample of each accelerometer at rest, in the unit of the output; by default the
        recording itself shows it. To be stated of a part of a recording that may have no rest.

    Raises
    ------
    DataError
        ``no_recordings``, ``duplicate_recording``, ``wrong_unit`` if recordings differ in unit, ``no_rest``,
        ``no_face`` if a position is on no face.
    """
    if not recordings:
        raise DataError("no recordings", code="no_recordings")
    known: dict[str, Any] = {}
    for k, one in enumerate(recordings if len(recordings) > 1 else ()):  # a copy is no repeat
        print_of = _print_of(one.array(ACC))
        name = one.source.path or f"recording {k + 1}"
        other = known.setdefault(print_of, name)
        if other is not name:
            what, why = f"{other} and {name} hold the same samples", "their positions would count twice"
            raise DataError(what, name, why, "Leave one of them out", "duplicate_recording")
    chosen = [*sections, *([()] * (len(recordings) - len(sections)))]
    ends = [*saturated, *([False] * (len(recordings) - len(saturated)))]
    others = [*gyros, *([None] * (len(recordings) - len(gyros)))]
    apart = [_own_gyros(one, other) for one, other in zip(recordings, others, strict=True)]
    parts = [_one(plan, noise, *one) for one in zip(recordings, chosen, ends, apart, strict=True)]
    if not any(len(part) for part in parts):
        do, why = "Name the parts in which it rests: x_p, x_a, ...", "gravity at rest calibrates the accelerometers"
        raise DataError("no section is a position", recordings[0].source.path, why, do, "wrong_section")
    readings = parts[0]
    for part in parts[1:]:
        readings = joined(readings, part)
    return on_faces(readings) if faces else readings


def _print_of(values: Array) -> str:
    found = hashlib.sha256()
    for first, stop in batches(values):
        found.update(np.ascontiguousarray(values[first:stop]).tobytes())
    return found.hexdigest()


@dataclass(frozen=True, eq=False)
class OwnGyros:
    """Samples of gyros with stamps of their own, cut by times of the accelerometers."""

    samples: Samples
    seconds: Array  # shape (n,): since the first sample of the accelerometers [s]
    acc: Array  # shape (n, 3): accelerometers at these times

    def span(self, start: float, last: float) -> tuple[int, int]:
        """Return the samples from one time to another, both included [s]."""
        return int(np.searchsorted(self.seconds, start)), int(np.searchsorted(self.seconds, last, side="right"))


def _own_gyros(recording: Recording, gyros: Recording | None) -> OwnGyros | None:
    if gyros is None or gyros.time_ns is None or recording.time_ns is None:
        return None
    samples = samples_of(gyros.array(GYRO), gyros.time_ns, gyros.sample_interval, gyros.place)
    seconds = np.asarray((gyros.time_ns - recording.time_ns[0]) / SECOND, dtype=np.float64)
    return OwnGyros(samples, seconds, interpolated(recording.array(ACC), recording.time_ns, gyros.time_ns))


def on_faces(readings: Readings) -> Readings:
    """Return readings whose positions are known to lie on the six faces, each on the nearest.

    Raises
    ------
    DataError
        ``no_face`` if a position lies between faces.
    """
    unit = pointing(readings.acc.mean)
    axis = np.argmax(np.abs(unit), axis=1)
    size = np.abs(unit[np.arange(len(unit)), axis])
    if np.any(size < FACE_WITHIN):
        k = int(np.argmin(size))
        raise DataError(
            f"{readings.place(k)} is {np.degrees(np.arccos(size[k])):.0f} deg away from any face",
            why="orientations = faces: each position lies on a face",
            do="Leave faces out: gravity alone then calibrates",
            code="no_face",
        )
    direction = np.zeros_like(unit)
    direction[np.arange(len(unit)), axis] = np.sign(unit[np.arange(len(unit)), axis])
    return replace(readings, direction=direction)


def _one(
    plan: Plan,
    noise: tuple[float, ...] | None,
    recording: Recording,
    sections: Sequence[Section],
    saturated: bool,
    own: OwnGyros | None,
) -> Readings:
    values = {"acc": np.asfortranarray(recording.array(ACC), dtype=np.float64)}  # a stored one is so already
    if all(name in recording.names for name in GYRO):
        values["gyro"] = np.asfortranarray(recording.array(GYRO), dtype=np.float64)
    seconds = _seconds(recording)
    if sections:
        return _by_sections(recording, values, seconds, sections, saturated, own)
    try:
        still = Detection(noise=noise)
        segmentation = detect(values["acc"], recording.time_ns, recording.sample_interval, still, recording.place)
    except DataError as error:
        raise DataError([replace(p, where=p.where or recording.source.path) for p in error.problems]) from None
    shortest = plan.shortest if plan.shortest is not None else shortest_placement(segmentation)
    placed: Sequence[Placement] = placements(segmentation, shortest, values.get("gyro"))
    if not placed:
        raise DataError(
            f"the unit never lies still for {shortest:.3g} s",
            recording.source.path,
            "a position is a rest",
            "Let it rest in each position, or state plan.shortest",
            "no_rest",
        )
    total = len(placed)
    placed, there, more = _there(recording, values, placed, [f"{seconds[one.start]:.6g} s" for one in placed])
    rotations = tuple(
        _rotation(values, seconds, a, b, k, k + 1, own)
        for k, (a, b) in enumerate(between(placed)) if there[k + 1] == there[k] + 1
    )  # fmt: skip
    found = _readings(recording, segmentation.samples, values, placed, rotations if "gyro" in values else (), own)
    found = _whole_rotations(found, recording.source.path, saturated)
    cut = [replace(one, where=one.where and recording.place(one.index)) for one in segmentation.remarks]
    remarks = [*recording.remarks, *cut, *more, *_disturbed(found, values, placed), *found.remarks]
    return replace(found, remarks=gather(remarks), left_out=tuple(sorted(set(range(total)) - set(there))))


def _by_sections(
    recording: Recording,
    values: Mapping[str, Array],
    seconds: Array,
    sections: Sequence[Section],
    saturated: bool,
    own: OwnGyros | None,
) -> Readings:
    """Cut by protocol; transitions are known between static sections that follow one another."""
    path = recording.source.path
    still = sorted((one for one in sections if one.angle is None), key=lambda one: one.start)
    for alike in (still, [one for one in sections if one.angle is not None]):
        check_sections(alike, len(seconds), path)
    placed = [Placement(one.start, one.stop) for one in still]
    placed, there, more = _there(recording, values, placed, [one.name for one in still])
    still = [still[k] for k in there]
    samples = samples_of(values["acc"], recording.time_ns, recording.sample_interval, recording.place)
    turns = tuple(
        replace(_rotation(values, seconds, one.start, one.stop, -1, -1, own), where=one.name,
                axis=np.array(one.axis, dtype=float), angle=one.angle, assumed=one.assumed)
        for one in sections if one.angle is not None and one.axis is not None and "gyro" in values
    )  # fmt: skip
    cut = _whole_rotations(_readings(recording, samples, values, placed, turns, own), path, saturated)
    nowhere = (np.nan, np.nan, np.nan)
    direction = np.array([one.direction or nowhere for one in still], dtype=float).reshape(-1, 3)
    named = tuple(f"{one.name}, {where}" if one.name else where for one, where in zip(still, cut.where, strict=True))
    given = direction if np.isfinite(direction).any() else None
    remarks = gather([*recording.remarks, *more, *_disturbed(cut, values, placed), *cut.remarks])
    return replace(cut, direction=given, where=named, remarks=remarks)


def _seconds(recording: Recording) -> Array:
    if recording.seconds is not None:
        return recording.seconds
    if recording.sample_interval is None:
        raise DataError(
            "no time", recording.source.path, "rotations are rates over time", "Give the sample rate", "no_time"
        )
    interval = recording.sample_interval
    return made(len(recording), float, lambda first, stop: np.arange(first, stop) * interval)


def _rotation(
    values: Mapping[str, Array], seconds: Array, a: int, b: int, before: int, after: int, own: OwnGyros | None
) -> Rotation:
    late = 0
    if own is None:
        at, acc, gyro = seconds[a:b], values["acc"][a:b], values.get("gyro", np.empty((len(seconds), 3)))[a:b]
        steps = np.diff(at)
        longest = float(steps.max())
        if longest > LONGEST_GAP * steps.min():  # else no step is that much longer than the usual one
            usual = float(np.median(steps))
            late = round(longest / usual) - 1 if longest > LONGEST_GAP * usual > 0.0 else 0
    else:
        first, stop = own.span(seconds[a], seconds[b - 1])
        at, acc, gyro = (one[first:stop] for one in (own.seconds, own.acc, own.samples.values))
        late = round(float(np.max(np.diff(own.samples.ticks[first:stop]), initial=1.0))) - 1 if len(at) else b - a
    good: NDArray[np.bool_] = np.asarray(np.isfinite(gyro).all(axis=1))
    if not np.isfinite(acc).all():  # what the gyros read of specific force is small: a neighbour will do
        acc = filled(acc)
    return Rotation(at[good] - at[:1], gyro[good], acc[good], before, after, where=f"{seconds[a]:.6g} s",
                    missing=max(_longest(~good), late))  # fmt: skip


def _longest(out: NDArray[np.bool_]) -> int:
    """Return the length of the longest run of samples that are out."""
    if not out.any():
        return 0
    edges = np.flatnonzero(np.diff(np.concatenate(([False], out, [False])).astype(np.int8)))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _there(
    recording: Recording, values: Mapping[str, Array], placed: Sequence[Placement], names: Sequence[str]
) -> tuple[list[Placement], list[int], list[Remark]]:
    """Return the positions of which at least half of the samples are there, their numbers, and what was left out.

    Raises
    ------
    DataError
        ``no_values`` if none is left.
    """
    there, remarks = [], []
    for k, one in enumerate(placed):
        size = one.stop - one.start
        parts = {name: all_finite(own[one.start : one.stop]) for name, own in values.items()}
        short = [name for name, good in parts.items() if count(good, lambda part: part) < max(HALF * size, 2)]
        if not short:
            there.append(k)
            continue
        what = f"more than half of the samples of {' and '.join(short)} are no readings: position left out"
        place = f"{recording.source.path}: {names[k]}" if recording.source.path else names[k]
        remarks.append(Remark("position_incomplete", "warning", what, place, do="Lay the unit there again"))
    if placed and not there:
        what = f"none of {len(placed)} positions holds readings in half of its samples"
        raise DataError(what, recording.source.path, do="Record again", code="no_values")
    return [placed[k] for k in there], there, remarks


def _whole_rotations(readings: Readings, path: str, saturated: bool) -> Readings:
    """Leave out rotations that hold saturated samples, or gaps that change their angle.

    What a gap does is seen from the same rotation: gaps as long elsewhere in it, bridged by a straight line. It may do
    as much as the noise of the gyros, or half a thousandth of all that was turned.
    """
    if readings.gyro is None or not any(one.missing for one in readings.rotations):
        return readings
    noise = float(np.median(readings.gyro.scatter))
    kept = [one for one in readings.rotations if not one.missing or not (saturated or _matters(one, noise))]
    lost = [one for one in readings.rotations if one not in kept]
    if not lost:
        return readings
    why = "saturated samples" if saturated else "gaps that change its angle by more than noise"
    what = f"{len(lost)} of {len(readings.rotations)} rotations hold {why}: left out of the gyros' matrix"
    do = "Turn more slowly, or use a wider range" if saturated else "Turn there again"
    place = f"{path}: {lost[0].where}" if path else lost[0].where
    remark = Remark("rotation_incomplete", "warning", what, place, len(lost), do)
    return replace(readings, rotations=tuple(kept), remarks=(*readings.remarks, remark))


def _matters(one: Rotation, noise: float) -> bool:
    """Whether a gap as long as the longest changes the angle by more than noise of the gyros does, and noticeably."""
    n, w = len(one.gyro), one.missing + 1
    if n < 2 * w + 2:
        return True
    h = float(np.median(np.diff(one.seconds)))
    total = np.vstack([np.zeros(3), np.cumsum(0.5 * h * (one.gyro[1:] + one.gyro[:-1]), axis=0)])
    line = 0.5 * w * h * (one.gyro[w:] + one.gyro[:-w])
    off = float(np.sqrt(np.mean(np.sum((total[w:] - total[:-w] - line) ** 2, axis=1))))
    turned = float(h * np.sum(np.linalg.norm(one.gyro, axis=1)))
    return bool(off > max(noise * h * np.sqrt(n), SMALL * turned))


def _readings(
    recording: Recording,
    samples: Samples,
    values: Mapping[str, Array],
    placed: Sequence[Placement],
    rotations: tuple[Rotation, ...],
    own: OwnGyros | None,
) -> Readings:
    """Return the mean readings; ``samples`` are those of the accelerometers, with the clock of all but ``own``."""
    triads = {"acc": _triad(recording, samples, "acc", placed)}
    seconds, temperature = _seconds(recording), None
    if own is not None:
        at = [Placement(*own.span(seconds[one.start], seconds[one.stop - 1])) for one in placed]
        triads["gyro"] = _triad(recording, own.samples, "gyro", at)
    elif "gyro" in values:
        gyro = values["gyro"]
        alike = replace(samples, values=gyro, finite=all_finite(gyro), outlier=zeros(len(gyro), bool))
        triads["gyro"] = _triad(recording, alike, "gyro", placed)
    path, stamps = recording.source.path, recording.time_ns
    if stamps is None:
        stamps = changed(seconds, lambda part: np.round(part * 1e9).astype(np.int64), np.int64)
    if TEMPERATURE in recording.names:
        degrees = recording.channel(TEMPERATURE).data
        temperature = np.array([moments(degrees[one.start : one.stop]).mean for one in placed])
    return Readings(
        acc=triads["acc"],
        gyro=triads.get("gyro"),
        rotations=rotations,
        start_ns=stamps[[one.start for one in placed]],
        stop_ns=stamps[[one.stop - 1 for one in placed]],
        temperature=temperature,
        where=tuple(f"{path + ': ' if path else ''}{seconds[one.start]:.6g} s" for one in placed),
        recordings=(0,) * len(placed),
        spans_ns=((int(stamps[0]), int(stamps[-1])),),
    )


def _triad(recording: Recording, samples: Samples, name: str, placed: Sequence[Placement]) -> Triad:
    found = moments_of(samples, *np.array([(one.start, one.stop) for one in placed], dtype=np.int64).reshape(-1, 2).T)
    if found is None:
        raise DataError(f"a static interval has no {name} readings", recording.source.path, code="no_values")
    units = {recording.channel(f"{name}_{axis}").unit or "count" for axis in AXES}
    if len(units) > 1:
        raise DataError(f"{name} channels are in {', '.join(sorted(units))}", recording.source.path, code="wrong_unit")
    mean, scatter, worth, n = found
    return Triad(mean, scatter, worth, units.pop(), n.astype(float))


def _disturbed(readings: Readings, values: Mapping[str, Array], placed: Sequence[Placement]) -> list[Remark]:
    """Say which static intervals were disturbed."""
    found = []
    moved = np.zeros(len(placed), dtype=bool)
    for one in values.values():
        moved |= disturbed_inside(one, placed)
    inside = np.array([one.inside for one in placed], dtype=bool)
    for k in np.flatnonzero(moved | inside):
        what = (
            "the unit was knocked in this position: the longer part is used, and the level may have changed"
            if inside[k]
            else "the level drifts, or the scatter grows, in this static interval: the unit was not at rest"
        )
        place = readings.place(int(k))
        found.append(Remark("disturbed_position", "warning", what, place, do="Check it, or leave it out"))
    touched = [one.touched for one in placed if one.touched and not one.inside]
    if touched:
        what = f"the unit was touched or settled when laid down: {sum(touched)} samples of these positions left out"
        found.append(Remark("placement_parted", "info", what, count=len(touched)))
    return found


def joined(one: Readings, other: Readings) -> Readings:
    """Return the positions of both; rotations lie inside each.

    Raises
    ------
    DataError
        ``wrong_unit`` if they differ in unit, or one has no gyros.
    """
    if (one.gyro is None) != (other.gyro is None) or one.acc.unit != other.acc.unit:
        raise DataError("recordings of one test differ in their channels or units", code="wrong_unit")
    shift = len(one)
    moved = tuple(
        replace(r, before=r.before + shift, after=r.after + shift) if r.before >= 0 else r for r in other.rotations
    )
    return Readings(
        acc=_stacked(one.acc, other.acc),
        gyro=None if one.gyro is None or other.gyro is None else _stacked(one.gyro, other.gyro),
        rotations=(*one.rotations, *moved),
        direction=_directions(one, other),
        start_ns=_both(one.start_ns, other.start_ns),
        stop_ns=_both(one.stop_ns, other.stop_ns),
        temperature=_both(one.temperature, other.temperature),
        left_out=(*one.left_out, *(k + shift + len(one.left_out) for k in other.left_out)),
        spans_ns=(*one.spans_ns, *other.spans_ns),
        recordings=(*one.recordings, *(k + len(one.spans_ns or set(one.recordings)) for k in other.recordings)),
        where=(*one.where, *other.where),
        remarks=gather([*one.remarks, *other.remarks]),
    )


def _stacked(one: Triad, other: Triad) -> Triad:
    return Triad(
        np.vstack([one.mean, other.mean]),
        np.vstack([one.scatter, other.scatter]),
        np.vstack([one.n_effective, other.n_effective]),
        one.unit,
        _both(one.samples, other.samples),
    )


def _directions(one: Readings, other: Readings) -> Array | None:
    """Return the directions of both, NaN where not known; None where none is."""
    each = [np.full((len(part), 3), np.nan) if part.direction is None else part.direction for part in (one, other)]
    found = np.concatenate(each)
    return found if np.isfinite(found).any() else None


def _both(one: Any, other: Any) -> Any:
    return None if one is None or other is None else np.concatenate([one, other])
