"""Dwells of a flip against each other: a sign, a unit or axes that change, a position that is misnamed.

*Inside a record.* All axes step at one place of a quiet stretch, at one position: to the opposite level (a sign), or to
others (another sensor).

*From dwell to dwell.* With all readings from some dwell on inverted, the dwells follow the turn; as they stand, they do
not. Or all axes change between two dwells by far more than between any others.

*Positions.* The dwells do not follow the stated positions, and do so with one change: another position of a dwell, two
dwells exchanged, the other sense, another axis of the turn, or an axis reversed. More than one may fit as well; all
are named then. Two positions that are half a turn apart and exchanged throughout fit as well as they stand, with the
opposite ambient acceleration: that cannot be told.

*Flips.* One flip shows the ambient acceleration of the others with opposite sign.

Residuals are judged by how the two halves of each dwell differ, which neither the stated positions nor the steps
between dwells enter. A cause is named only where it leaves a ninth or less of the squared residuals.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES, Key
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import factor
from ...signals.sine.changes import jumps
from ...statistics.agreement import FALSE_ALARM
from ..agreement import unit_mistaken
from .plan import Plan
from .readings import Quiet, Readings
from .separation.equations import AMBIENT, SAME, rotation, separate

PART = FALSE_ALARM / 4.0  # of each of the searches
EXPLAINED = 1.0 / 9.0  # of the squared residuals, that a cause may leave
NEAR = 2  # blocks between the steps of axes that step at once
OPPOSITE = 0.2  # of a level, by which it may miss the opposite one
SIDE = 6  # blocks of a level
STANDS = 4.0  # standard deviations of a block
MAD = 0.6745  # median of |x| of normal noise
ALIKE = 0.1  # relative difference of factors that are one
FAR = 5.0  # times any other change between dwells
PAUSE = 3.0  # times the usual time between dwells
CLOSE = 3.0  # times the squared residuals of the best cause, that another may leave and be as good
MOST = 4  # causes in a message
UG = factor("m/s^2", "ug")


def agreement(plan: Plan, readings: Readings) -> list[Remark]:
    """Return where dwells of a flip disagree with each other."""
    found = [*readings.disagreements, *(one for record in readings.quiet for one in _steps(record))]
    if found:
        return found
    scale = _scales(readings)
    return (
        list(_inverted(plan, readings, scale))
        or list(_other_levels(readings))
        or list(_opposite_flips(plan, readings, scale))
        or (list(readings.misplaced) if len(np.unique(np.round(readings.angle, 6))) == 2 else [])
        or list(_misnamed(plan, readings, scale))
        or list(readings.misplaced)
    )


# Inside a record


def _steps(record: Quiet) -> Iterator[Remark]:
    """Yield where all axes of a record step at once, at one position."""
    axes = [axis for axis, means in record.means.items() if np.isfinite(means).any()]
    if len(axes) < 2:
        return
    parted = (np.diff(record.times) > 1.5 * record.length) | (np.abs(np.diff(record.angle)) > SAME)
    pieces = np.split(np.arange(len(record.times)), np.flatnonzero(parted) + 1)
    found = [jumps([record.means[axis][rows] for rows in pieces], PART) for axis in axes]
    for rows, *steps in zip(pieces, *found, strict=True):
        at = [one.at for one in steps if one is not None]
        if len(at) < 2 or max(at) - min(at) > NEAR or min(at) - 1 < SIDE // 2 or len(rows) - max(at) - 1 < SIDE // 2:
            continue
        before = np.array([_level(record.means[axis][rows], min(at) - SIDE, min(at) - 1) for axis in axes])
        after = np.array([_level(record.means[axis][rows], max(at) + 1, max(at) + 1 + SIDE) for axis in axes])
        noise = np.array([_noise(record.means[axis][rows]) for axis in axes])
        if np.all(np.abs(after - before) > STANDS * noise):
            where = f"{record.times[rows[min(at)]]:.6g} s after the start"
            yield _changed(f"{record.name}: {where}" if record.name else where, axes, before, after, noise)


def _noise(means: Array) -> float:
    """Return the standard deviation of most blocks, by their neighbours."""
    steps = np.abs(np.diff(means[np.isfinite(means)]))
    return float(np.median(steps)) / MAD / math.sqrt(2.0) if len(steps) else 0.0


def _level(means: Array, start: int, stop: int) -> float:
    part = means[max(start, 0) : stop]
    return float(np.nanmedian(part)) if np.isfinite(part).any() else math.nan


def _changed(where: str, axes: Sequence[str], before: Array, after: Array, noise: Array) -> Remark:
    """Return what all axes do from a place on: their sign, unit or gain changes, or they are others."""
    if np.all(np.abs(after + before) < OPPOSITE * np.abs(before)):
        what = f"all axes read the opposite from here on: the sign of {', '.join(axes)} changes"
        return Remark("sign_changed", "error", what, where, do="Cut the recording there, and mend the sign of one part")
    square = float(before @ before)
    middle = float(after @ before) / square if square > 0.0 else 0.0
    if middle > 0.0 and np.all(np.abs(after - middle * before) < ALIKE * np.abs(middle * before) + 3.0 * noise):
        unit = unit_mistaken(middle, "acceleration") or unit_mistaken(middle, "angular_rate")
        what = f"all axes read {number(middle, 3)} times as much from here on{f': {unit}' if unit else ''}"
        do = "Cut the recording there, and state unit and range of each part"
        return Remark("unit_changed" if unit else "scale_changed", "error", what, where, do=do)
    changes = ", ".join(
        f"{axis} by {number(float(d) * UG, 3)} ug" for axis, d in zip(axes, after - before, strict=True)
    )
    what = f"all axes change at once, {changes}: other axes, or another sensor, are read from here on"
    return Remark("axes_changed", "error", what, where, do="Cut the recording there, and check its columns")


# From dwell to dwell


def _scales(readings: Readings) -> dict[str, tuple[float, float]]:
    """Return how far means of dwells wander, by their halves: of each axis [m/s^2], with its degrees of freedom."""
    found = {}
    for axis in readings.axes:
        apart = []
        for record in readings.quiet:
            means = record.means.get(axis)
            if means is None:
                continue
            for weights in record.weights:
                own = np.flatnonzero((weights > 0.0) & np.isfinite(means))
                half = len(own) // 2
                if half:
                    apart.append(float(means[own[:half]].mean() - means[own[-half:]].mean()))
        if apart:
            found[axis] = float(np.sqrt(0.5 * np.mean(np.square(apart)))), float(len(apart))
    return found


def _residual(plan: Plan, readings: Readings, scale: Mapping[str, tuple[float, float]]) -> tuple[float, int]:
    """Return the squared residuals of the turned axes over what dwells wander, of all flips, and how many there are.

    Raises
    ------
    DataError
        If the dwells do not determine a drift of the plan.
    """
    total, free = 0.0, 0
    turned = [scale[axis][0] for axis in plan.turned if axis in readings.axes]
    if not any(turned):
        return total, free
    most = float(np.sqrt(np.mean(np.square(turned))))
    unit = {axis: own / most for axis, own in readings.outputs.items()}
    scaled = replace(readings, outputs=unit)
    for label in readings.flips:
        lines = separate(plan, scaled, label).checks
        rest = sum(w @ np.nan_to_num(unit[axis]) for axis, w in lines.items())
        total, free = total + float(np.sum(np.square(rest))), free + np.size(rest) * bool(lines)
    return total, free


def _unlikely(square: float, free: int, scale: Mapping[str, tuple[float, float]], tried: int) -> bool:
    """Whether residuals are larger than dwells wander."""
    dof = sum(one[1] for one in scale.values()) * (2.0 / 3.0 if len(scale) > 2 else 1.0)  # of the turned axes
    return free > 0 and float(special.fdtrc(free, dof, square / free)) < PART / max(tried, 1)


def _tried(plan: Plan, readings: Readings, scale: Mapping[str, tuple[float, float]]) -> tuple[float, int] | None:
    try:
        return _residual(plan, readings, scale)
    except (DataError, np.linalg.LinAlgError):
        return None


def _in_time(readings: Readings) -> NDArray[np.intp]:
    return np.arange(len(readings)) if readings.time is None else np.argsort(readings.time, kind="stable")


def _inverted(plan: Plan, readings: Readings, scale: Mapping[str, tuple[float, float]]) -> Iterator[Remark]:
    """Yield from which dwell on all axes are inverted; the dwell before may hold the change."""
    order, n = _in_time(readings), len(readings)
    if n < 3 or not all(axis in scale and scale[axis][0] > 0.0 for axis in readings.axes):
        return
    as_read = _tried(plan, readings, scale)
    if as_read is None or not _unlikely(*as_read, scale, n):
        return
    best: tuple[float, int] | None = None
    for first in range(1, n):
        later = order[first:]
        outputs = {axis: own.copy() for axis, own in readings.outputs.items()}
        for own in outputs.values():
            own[later] *= -1.0
            own[order[first - 1]] = np.nan
        without = {axis: own.copy() for axis, own in readings.outputs.items()}
        for own in without.values():
            own[order[first - 1]] = np.nan
        mended = _tried(plan, replace(readings, outputs=outputs), scale)
        plain = _tried(plan, replace(readings, outputs=without), scale)
        if mended is None or plain is None or mended[1] < 1 or not _unlikely(*plain, scale, n):
            continue
        score = mended[0] / max(plain[0], 1e-300)
        if score < EXPLAINED and not _unlikely(*mended, scale, 1) and (best is None or score < best[0]):
            best = score, first
    if best is not None:
        place = readings.place(int(order[best[1]]))
        what = "from this dwell on all axes read the opposite: with their sign turned the dwells follow the positions"
        yield Remark("sign_changed", "error", what, place, do="Cut the recording there, and mend the sign of one part")


def _other_levels(readings: Readings) -> Iterator[Remark]:
    """Yield between which dwells all axes change by far more than between any others."""
    if readings.time is None or len(readings) < 4 or len(readings.axes) < 3:
        return
    order = _in_time(readings)
    y = np.array([readings.outputs[axis][order] for axis in readings.axes])
    if not np.isfinite(y).all():
        return
    change, pause = np.abs(np.diff(y, axis=1)), np.diff(readings.time[order])
    at = int(np.argmax(change.min(axis=0)))
    others = np.delete(change, at, axis=1).max(axis=1)
    if np.all(change[:, at] > FAR * others) and pause[at] < PAUSE * np.median(pause):
        place = readings.place(int(order[at + 1]))
        yield _changed(place, readings.axes, y[:, at], y[:, at + 1], others)


def _misfit(axis: str, readings: Readings, angle: Array, scale: Mapping[str, tuple[float, float]]) -> tuple[float, int]:
    """Return the squared residuals of all axes over what dwells wander, and how many are free.

    Bias and ambient acceleration of each flip are free; along the turn they are one, and the axis keeps its reading.
    """
    C = rotation(axis, angle)
    total, free = 0.0, 0
    for label in readings.flips:
        own = np.flatnonzero(readings.flip == label)
        rows, values = [], []
        for i, name in enumerate(AXES):
            read = own[np.isfinite(readings.outputs[name][own])] if name in readings.outputs else own[:0]
            B: Array = np.zeros((len(read), 3))
            B[:, i] = 1.0
            u = scale[name][0] if len(read) else 1.0
            rows.append(np.hstack([B, C[read, i]]) / u)
            values.append((readings.outputs[name][read] if len(read) else np.zeros(0)) / u)
        X, y = np.vstack(rows), np.concatenate(values)
        beta, _, rank, _ = np.linalg.lstsq(X, y, rcond=1e-9)
        total, free = total + float(np.sum((y - X @ beta) ** 2)), free + len(y) - int(rank)
    return total, free


@dataclass(frozen=True)
class _Cause:
    """What may be wrong: with this axis of the turn, these angles and this axis reversed the dwells would fit."""

    code: str
    what: str
    where: str
    do: str
    axis: str
    angle: Array
    reversed: str = ""


def _misnamed(plan: Plan, readings: Readings, scale: Mapping[str, tuple[float, float]]) -> Iterator[Remark]:
    """Yield what is wrong about the positions: the one cause that explains the dwells, or all that do as well."""
    if plan.drift != "none" or not all(axis in scale and scale[axis][0] > 0.0 for axis in readings.axes):
        return
    square, free = _misfit(plan.axis, readings, readings.angle, scale)
    if free < 1 or not _unlikely(square, free, scale, 1):
        return
    found: list[tuple[float, _Cause]] = []
    for one in (*_wrong_positions(plan, readings), *_wrong_axes(plan, readings)):
        outputs = {name: -own if name == one.reversed else own for name, own in readings.outputs.items()}
        mended, dof = _misfit(one.axis, replace(readings, outputs=outputs), one.angle, scale)
        if dof > 0 and mended < EXPLAINED * square:
            found.append((mended, one))
    least = min((mended for mended, _ in found), default=0.0)
    good = [one for mended, one in sorted(found, key=lambda pair: pair[0]) if mended < CLOSE * max(least, free)]
    if len(good) == 1:
        yield Remark(good[0].code, "error", good[0].what, good[0].where, do=good[0].do)
    elif good:
        causes = "; or ".join(f"{one.where}: {one.what}" if one.where else one.what for one in good[:MOST])
        do = "Each of these explains the dwells: check positions, signs and columns"
        yield Remark("not_turned_by_angle", "error", causes, do=do)


def _wrong_positions(plan: Plan, readings: Readings) -> Iterator[_Cause]:
    """Yield another position of each dwell, each two dwells exchanged, and the other sense of all turns."""
    angle, code = readings.angle, "not_turned_by_angle"
    places = np.unique(np.round(np.concatenate([angle, angle + np.pi]) % (2.0 * np.pi), 6))
    turned = " and ".join(plan.turned)
    for k in range(len(readings)):
        for place in places[np.abs(np.exp(1j * places) - np.exp(1j * angle[k])) > 10.0 * SAME]:
            other = angle.copy()
            other[k] = place
            there = f"{math.degrees(place):.6g} deg"
            what = f"{turned} read in this dwell what they read at {there}, not at the position stated"
            yield _Cause(code, what, readings.place(k), "Correct the position of this dwell", plan.axis, other)
    for k, m in combinations(range(len(readings)), 2):
        if abs(angle[k] - angle[m]) > SAME and readings.flip[k] == readings.flip[m]:
            other = angle.copy()
            other[[k, m]] = angle[[m, k]]
            what = f"the positions of two dwells are exchanged: this one and {readings.place(m)}"
            yield _Cause(code, what, readings.place(k), "Exchange them", plan.axis, other)
    what = "the dwells follow the angles in the other sense: the head was turned left-handed, or the axis points back"
    yield _Cause(code, what, "", "Give the angles with the opposite sign", plan.axis, -angle)


def _wrong_axes(plan: Plan, readings: Readings) -> Iterator[_Cause]:
    """Yield the other axes of the turn, and each turned axis reversed."""
    for axis in (one for one in AXES if one != plan.axis):
        if len(readings.axes) == len(AXES):
            what = f"the dwells follow a turn about {axis}, not about {plan.axis}"
            do = f"Check plan.axis, columns and mounting (--axis {axis})"
            yield _Cause("turned_about_other_axis", what, "", do, axis, readings.angle)
        if axis in readings.axes:
            what = f"the dwells follow the angles with {axis} reversed: its sign is wrong, or it is another axis"
            yield _Cause("not_turned_by_angle", what, "", f"Check the sign of {axis}", plan.axis, readings.angle, axis)


def _opposite_flips(plan: Plan, readings: Readings, scale: Mapping[str, tuple[float, float]]) -> Iterator[Remark]:
    """Yield flips that show the ambient acceleration of the others with opposite sign."""
    if len(readings.flips) < 3 or not all(axis in scale for axis in plan.turned if axis in readings.axes):
        return
    keys = [Key(AMBIENT, axis) for axis in plan.turned]
    try:
        parts = [separate(plan, readings, label) for label in readings.flips]
    except DataError:
        return
    values = np.array([[np.nan if (own := part.value(key)) is None else own for key in keys] for part in parts])
    if not np.isfinite(values).all():
        return
    u = np.array([scale[axis][0] for axis in plan.turned])
    dof = min(scale[axis][1] for axis in plan.turned)
    for k, label in enumerate(readings.flips):
        others = np.delete(values, k, axis=0)
        middle = np.median(others, axis=0)
        agree = np.all(np.sum(others * middle, axis=1) > 0.5 * float(middle @ middle))
        off = np.abs(values[k] - middle)
        away = np.divide(off, u, out=np.where(off > 0.0, np.inf, 0.0), where=u > 0.0)
        apart = float(np.mean(away**2))
        opposite = np.linalg.norm(values[k] + middle) < 0.3 * np.linalg.norm(middle)
        if agree and opposite and float(special.fdtrc(len(u), dof, apart / 2.0)) < PART / len(parts):
            what = (
                f"flip {label} shows the ambient acceleration of the others with opposite sign: positions are swapped"
            )
            place = readings.place(int(np.flatnonzero(readings.flip == label)[0]))
            yield Remark("not_turned_by_angle", "error", what, place, do="Correct the positions of this flip")
