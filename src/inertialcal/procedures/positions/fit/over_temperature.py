"""Accelerometers over temperature: polynomials of matrix and offset, of positions recorded at several temperatures.

Each recording is one temperature, and holds all the positions that its matrix A_r and offset b_r need. Its twelve
numbers y_r come from the same fit as those of any recording; over the recordings::

    y_r = C_0 + C_1 (T_r - T_ref) + ... + C_p (T_r - T_ref)^p + e_r

by ordinary least squares, since the recordings are alike.

Assumed: e_r is independent from recording to recording, whatever it is made of: laying, mounting anew, the temperature
inside against that of the thermometer, its path. The order follows the curve, else ``temperature_order_low``.
What u means: the standard
deviation of the C if all recordings were made again, from the residuals, with n - p - 1 degrees of freedom; joined with
what is common to all recordings. That is the gravity, the mounting, the faces of the fixture: they move C_0, and the
powers only as far as the matrix changes; and an error of the thermometer, which shifts all temperatures alike. Each
recording's own scatter between positions is part of e_r and not counted again.

How real data break it: a unit that has not settled, or whose sensors are not at the temperature of the thermometer
(``temperature_not_steady``, else in e_r where recordings are reached from both sides); a unit that is mounted anew at
each temperature (in e_r); an offset of the thermometer (``thermometer.temperature``, else results are relative to it).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy import special

from ....core.errors import DataError, PlanError
from ....core.estimate import Array
from ....core.key import Key
from ....core.remarks import Remark
from ....core.units import normalise
from ..plan import Plan
from ..readings import Readings
from .accelerometer import NOT_TOLD, NOTHING_LEFT, OF_FRAME, Fitted
from .fixture import FACE_FOUND
from .linear_sensor import BIAS, PAIRS, LinearSensor, OverTemperature, Source, propagated

SCATTER = "scatter between recordings over temperature"
THERMOMETER = "thermometer.temperature"
RISK = 0.01  # that any of the numbers is said to bend which does not
STEADY = 0.1  # of the range of temperatures: a recording that changes by more is not at one temperature
LEAST_RANGE = 2.0  # [degC] between temperatures that count as two


@dataclass(frozen=True, eq=False)
class Level:
    """A recording at one temperature."""

    where: str
    temperature: float  # Mean over its positions [degC]
    spread: float  # From the coldest to the warmest of its positions [degC]
    sensor: LinearSensor


def keys_of(order: int) -> tuple[Key, ...]:
    """Return the names of the coefficients of each power from 1 on, in the order of the twelve numbers."""
    found: list[Key] = []
    for j in range(1, order + 1):
        found += [
            Key("scale_factor_error_temperature", pair[0], power=j)
            if pair[0] == pair[1]
            else Key("cross_axis_sensitivity_temperature", pair, power=j)
            for pair in PAIRS
        ]
        found += [Key("bias_temperature", key.axis, power=j) for key in BIAS]
    return tuple(found)


def units_of(order: int) -> tuple[str, ...]:
    """Return their units, SI and degC."""
    found: list[str] = []
    for j in range(1, order + 1):
        by = "degC" if j == 1 else f"degC^{j}"
        found += [normalise(f"1/{by}")] * 9 + [normalise(f"(m/s^2)/{by}")] * 3
    return tuple(found)


def over_temperature(
    plan: Plan, readings: Readings, fit: Callable[[Readings], Fitted]
) -> tuple[LinearSensor, list[Remark]]:
    """Return the accelerometers at the reference temperature, with their changes over temperature, and remarks.

    Parameters
    ----------
    plan : Plan
        Order and reference temperature.
    readings : Readings
        Of all recordings.
    fit : callable
        The accelerometers of one recording, relative to the same ideal scale factor and zero.

    Raises
    ------
    DataError
        ``no_temperature``; ``too_few_temperatures``; ``recording_incomplete`` where one does not carry all numbers.
    """
    order = plan.temperature_order
    levels = _levels(readings, fit)
    T = np.array([one.temperature for one in levels])
    _check(order, T, levels)
    n, size = len(levels), len(levels[0].sensor.values)
    design = np.vander(T - plan.reference_temperature, order + 1, increasing=True)
    back: Array = np.asarray(np.linalg.pinv(design), dtype=np.float64)  # (p + 1, n)
    y = np.array([one.sensor.values for one in levels])
    C = back @ y
    residuals = y - design @ C
    dof = float(n - order - 1)
    whole = np.kron(back @ back.T, residuals.T @ residuals / dof)
    sources = [Source(SCATTER, "A", 0.5 * (whole + whole.T), dof, level="recording")]
    sources += _common(levels, back)
    stated = plan.standards.get(THERMOMETER)
    if stated is not None:
        change = np.zeros((order + 1, size))
        change[:-1] = -stated.u * np.arange(1, order + 1)[:, None] * C[1:]
        flat = change.ravel()
        sources.append(Source(THERMOMETER, "B", np.outer(flat, flat), stated.dof, stated, changes=flat[None]))
    first = levels[0].sensor
    reasons = {k: reason for one in levels for k, reason in one.sensor.reasons.items() if _convention(one.sensor, k)}
    changes = OverTemperature(
        plan.reference_temperature, (float(T.min()), float(T.max())), C[1:], tuple(sources), keys_of(order),
        units_of(order),
    )  # fmt: skip
    at_reference = tuple(_at_reference(one, size) for one in sources)
    sensor = LinearSensor(C[0], at_reference, reasons, first.ideal, first.zero, first.named, changes)
    return sensor, [*_remarks(plan, levels, T), *_bent(plan, levels, T, y)]


def check_over_temperature(plan: Plan) -> None:
    """Refuse settings that do not go with terms over temperature.

    Raises
    ------
    PlanError
        ``wrong_value`` where a prior is stated: it would count once for each recording.
    """
    if plan.priors:
        what = f"temperature_order = {plan.temperature_order} and prior_{next(iter(plan.priors))}"
        why = "a prior would count once for each temperature"
        raise PlanError(what, why=why, do="Leave the prior out, or set temperature_order = 0", code="wrong_value")


def at_reference(sensor: LinearSensor, readings: Readings) -> Readings:
    """Return readings of accelerometers as they would be at the reference temperature.

    Raises
    ------
    DataError
        ``no_temperature``.
    """
    own = sensor.temperature
    if own is None:
        return readings
    away = _temperatures(readings) - own.reference
    mean = np.empty_like(readings.acc.mean)
    for k, (reading, by) in enumerate(zip(sensor.normalised(readings.acc.mean), away, strict=True)):
        numbers = sensor.values + by ** np.arange(1, len(own.values) + 1) @ own.values
        force = np.linalg.solve(numbers[:9].reshape(3, 3), reading - numbers[9:12])
        mean[k] = (sensor.matrix @ force + sensor.offset) * sensor.ideal + sensor.zero
    return replace(readings, acc=replace(readings.acc, mean=mean))


def _temperatures(readings: Readings) -> Array:
    found = readings.temperature
    if found is None or not np.isfinite(found).all():
        at = 0 if found is None else int(np.argmax(~np.isfinite(found)))
        do = "Name the channel temperature of each recording, with its unit (as in --unit temperature=degC)"
        raise DataError(f"{readings.place(at)}: no temperature", "", "terms over temperature need it", do,
                        "no_temperature")  # fmt: skip
    return found


def _levels(readings: Readings, fit: Callable[[Readings], Fitted]) -> list[Level]:
    """Return each recording with its temperature and its own fit."""
    T = _temperatures(readings)
    of = np.array(readings.recordings or (0,) * len(readings))
    ends = [0, *(np.flatnonzero(np.diff(of)) + 1).tolist(), len(of)]
    found = []
    for start, stop in pairwise(ends):
        part = readings.take(start, stop)
        where = part.where[0] if part.where else f"recording {int(of[start]) + 1}"
        sensor = fit(part).sensor
        lost = [str(sensor.named[k]) for k, reason in sensor.reasons.items() if reason in (NOT_TOLD, NOTHING_LEFT)]
        if lost:
            what = f"the positions at {np.mean(T[start:stop]):.4g} degC alone do not determine {', '.join(lost)}"
            do = "Lay the unit into all positions at each temperature, each a recording; or set temperature_order = 0"
            why = "each recording is one temperature, with a matrix of its own"
            raise DataError(what, where, why, do, "recording_incomplete")
        warm = T[start:stop]
        found.append(Level(where, float(np.mean(warm)), float(np.ptp(warm)), sensor))
    return found


def _check(order: int, T: Array, levels: Sequence[Level]) -> None:
    """Refuse temperatures that do not carry the order, or nothing to judge it by."""
    distinct = 1 + int(np.sum(np.diff(np.sort(T)) > LEAST_RANGE))
    if distinct > order and len(T) >= order + 2:
        return
    seen = ", ".join(f"{one:.3g}" for one in np.sort(T))
    what = (
        f"{len(T)} recording(s) at {seen} degC: {distinct} temperature(s) that differ by more than {LEAST_RANGE:g} degC"
    )
    why = f"order {order} needs {order + 1} temperatures, and a recording more to judge it by"
    raise DataError(what, levels[0].where, why, "Record at more temperatures, or lower temperature_order",
                    "too_few_temperatures")  # fmt: skip


def _convention(sensor: LinearSensor, k: int) -> bool:
    """Whether a number is one by definition, and not for want of readings to judge it by."""
    return sensor.reasons[k] == OF_FRAME


def _common(levels: Sequence[Level], back: Array) -> list[Source]:
    """Return what is common to all recordings: the same unknowns in each, or errors of the same faces."""
    found = []
    every = {one.origin: one for level in reversed(levels) for one in level.sensor.sources}
    for first in every.values():
        one, same = first, [[own for own in level.sensor.sources if own.origin == first.origin] for level in levels]
        if one.name != FACE_FOUND and one.influence is None and one.off is None:
            continue
        if one.off is not None and one.changes is not None:  # none where it is a change from this temperature
            nothing = replace(one, changes=np.zeros_like(one.changes), dof=np.full(one.changes.shape[1], np.inf))
            same = [own or [nothing] for own in same]
            free = [np.broadcast_to(own[0].dof, one.changes.shape[1]) for own in same]
            one = replace(one, dof=np.tile(np.min(free, axis=0), len(back)))
        each = [own[0] for own in same if own]
        if one.changes is not None and len(each) == len(levels) and _alike(each):
            changes = np.array([own.changes for own in each])  # (n, s, 12)
            flat = np.einsum("jr,rsk->sjk", back, changes).reshape(changes.shape[1], -1)
            found.append(replace(one, covariance=flat.T @ flat, changes=flat))
            continue
        size = one.covariance.shape[0]
        whole = np.zeros((len(back) * size,) * 2)
        whole[:size, :size] = np.mean([own.covariance for own in each], axis=0)
        dof = np.full(len(whole), np.inf)
        dof[:size] = one.dof
        found.append(replace(one, covariance=whole, dof=dof, changes=None))
    return found


def _alike(sources: Sequence[Source]) -> bool:
    """Whether each of these has the same unknowns."""
    shapes = {None if one.changes is None else one.changes.shape for one in sources}
    return len(shapes) == 1 and len({one.unknowns for one in sources}) == 1


def _at_reference(source: Source, size: int) -> Source:
    """Return a source of all coefficients as one of those at the reference temperature."""
    first = np.eye(size, source.covariance.shape[0])
    dof = np.asarray(source.dof)[:size] if np.ndim(source.dof) else source.dof
    changes = None if source.changes is None else source.changes[:, :size]
    return replace(source, covariance=propagated(first, source.covariance), dof=dof, changes=changes)


def _bent(plan: Plan, levels: Sequence[Level], T: Array, y: Array) -> list[Remark]:
    """Say which numbers need a higher order, where the temperatures carry one."""
    order = plan.temperature_order + 1
    dof = len(T) - order - 1
    if dof < 1 or int(np.sum(np.diff(np.sort(T)) > LEAST_RANGE)) < order:
        return []
    design = np.vander((T - T.mean()) / np.ptp(T), order + 1, increasing=True)
    C = np.linalg.lstsq(design, y, rcond=None)[0]
    scatter = np.sqrt(np.sum((y - design @ C) ** 2, axis=0) / dof)
    u = scatter * np.sqrt(np.linalg.inv(design.T @ design)[-1, -1])
    t = np.divide(np.abs(C[-1]), u, out=np.zeros_like(u), where=u > 0.0)
    p = 2.0 * special.stdtr(dof, -t)
    bent = [str(key) for key, one in zip(levels[0].sensor.named, p, strict=True) if one < RISK / len(p)]
    if not bent:
        return []
    what = f"{', '.join(bent)} bend(s) more over temperature than order {plan.temperature_order} follows"
    do = f"Set temperature_order = {order}"
    return [Remark("temperature_order_low", "warning", what, levels[0].where, len(bent), do)]


def _remarks(plan: Plan, levels: Sequence[Level], T: Array) -> list[Remark]:
    width = float(np.ptp(T))
    unsteady = [one for one in levels if one.spread > STEADY * width]
    if not unsteady:
        return []
    worst = max(unsteady, key=lambda one: one.spread)
    what = (
        f"the temperature changes by {worst.spread:.3g} degC while the unit is laid at {worst.temperature:.3g} degC, of"
        f" {width:.3g} degC between recordings: sensors may lag behind the thermometer"
    )
    do = "Let the unit settle, and reach each temperature from both sides"
    return [Remark("temperature_not_steady", "warning", what, worst.where, len(unsteady), do)]
