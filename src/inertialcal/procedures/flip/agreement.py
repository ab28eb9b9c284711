"""Dwells of a flip against each other: a sign, a unit or axes that change, a position that is misnamed.

*Inside a record.* All axes step at one place of a quiet stretch, at one position: to the opposite level (a sign), or to
others (another sensor).

*From dwell to dwell.* With all readings from some dwell on inverted, the dwells follow the turn; as they stand, they do
not. Or all axes change between two dwells by far more than between any others.

*Positions.* The turned axes of one dwell fit another of the positions, and not the one stated.

*Flips.* One flip shows the ambient acceleration of the others with opposite sign.

Residuals are judged by how the two halves of each dwell differ, which neither the stated positions nor the steps
between dwells enter. A cause is named only where it leaves a ninth or less of the squared residuals.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import Key
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import factor
from ...signals.sine.changes import jumps
from ...statistics.agreement import FALSE_ALARM
from ..agreement import unit_mistaken
from .plan import Plan
from .readings import Quiet, Readings
from .separation.equations import AMBIENT, SAME, separate

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
        or [*_misnamed(plan, readings, scale), *_opposite_flips(plan, readings, scale)]
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


def _misnamed(plan: Plan, readings: Readings, scale: Mapping[str, tuple[float, float]]) -> Iterator[Remark]:
    """Yield the dwell that fits another position."""
    if not all(axis in scale and scale[axis][0] > 0.0 for axis in plan.turned if axis in readings.axes):
        return
    as_read = _tried(plan, readings, scale)
    places = np.unique(np.round(readings.angle, 6))
    if as_read is None or not _unlikely(*as_read, scale, 1):
        return
    best: tuple[float, int, float] | None = None
    for k in range(len(readings)):
        for place in places:
            if abs(place - readings.angle[k]) < SAME:
                continue
            angle = readings.angle.copy()
            angle[k] = place
            mended = _tried(plan, replace(readings, angle=angle), scale)
            if mended is None or mended[1] < 1 or mended[1] > as_read[1]:
                continue
            score = mended[0] / as_read[0]
            if score < EXPLAINED and (best is None or score < best[0]):
                best = score, k, float(place)
    if best is not None:
        _, k, angle_ = best
        axes, true = " and ".join(plan.turned), f"{math.degrees(angle_):.6g} deg"
        what = f"{axes} read in this dwell what they read at {true}, not at the position stated"
        yield Remark("not_turned_by_angle", "error", what, readings.place(k), do="Correct the position of this dwell")


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
