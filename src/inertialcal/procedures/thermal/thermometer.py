"""Calibration of a unit's own temperature channel against a reference thermometer, from the sweeps of a thermal test.

The channel is converted by its nominal slope and voltage. In each power-up::

    channel = a + b (T - T_m) + c (T - T_m)^3 - tau d(channel)/dt           T: reference, T_m: middle of its range

Its error is ``channel - T``; a straight line (c = 0) gives slope and voltage, the cubic shows what a line leaves.

Assumed: the sensor follows the reference with one time constant tau, alike in warming and cooling, so that at rest
both are at one temperature. Where the temperature changed at one rate alone, tau cannot be told from a, which the
reason says.
What u means: the scatter from power-up to power-up (Student's t with one less than there are), joined with the
reference's ``thermometer.temperature``, one unknown for all. One power-up has no u.

How real data break it: a chamber that is ahead of the sensor (tau); a channel that is not linear (the cubic); a
reference that is off (stated, or the result is relative to it).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import Key, Reason
from ...core.results import Row, not_estimated
from ...statistics.intervals import t_interval
from .plan import Plan, Thermometer
from .recordings import Readings, Sweep

BLOCKS = 500  # of a recording, whose means are fitted
VARIES = 0.2  # standard deviation of the rates over the fastest, from which a delay shows
PLACES = 41  # temperatures at which the error is looked for
STANDARD = "thermometer.temperature"
ONE_RUN = Reason("one_run", "one power-up: not repeated")
ONE_RATE = Reason("one_rate", "one rate of change alone: a delay of the sensor is in it")
RELATIVE = Reason("relative", "relative to the reference thermometer")


@dataclass(frozen=True, eq=False)
class Line:
    """One power-up of one axis."""

    a: float
    b: float
    lag: float  # tau [s]; NaN where the temperature changed at one rate
    curve: Array  # shape (PLACES,): cubic less line [degC]


def thermometer_rows(plan: Plan, readings: Readings, axis: str) -> Iterator[Row]:
    """Yield what is known of the temperature channel of an axis; nothing where no reference was recorded."""
    by_run: dict[str, list[Sweep]] = {}
    for one in readings.sweeps:
        if one.reference is not None and axis in one.temperature:
            by_run.setdefault(one.run, []).append(one)
    if not by_run:
        return
    T = np.concatenate([_finite(one.reference) for own in by_run.values() for one in own])
    if len(T) < BLOCKS or np.ptp(T) < plan.least_range:
        what = f"the reference thermometer changes by {np.ptp(T) if len(T) else 0.0:.3g} degC"
        do = f"Ramp by {plan.least_range:g} degC or more"
        raise DataError(what, readings.where, "it calibrates the temperature channel", do, "no_temperature_change")
    low, high = float(T.min()), float(T.max())
    lines = [_line(own, axis, 0.5 * (low + high), np.linspace(low, high, PLACES)) for own in by_run.values()]
    yield from _rows(plan, axis, lines, (low, high))


def _finite(values: Array | None) -> Array:
    return np.zeros(0) if values is None else values[np.isfinite(values)]


def _line(sweeps: list[Sweep], axis: str, middle: float, places: Array) -> Line:
    """Fit means over blocks of one power-up."""
    parts = [_blocks(one, axis) for one in sweeps]
    T, channel, rate = (np.concatenate([part[i] for part in parts]) for i in range(3))
    told = bool(np.std(rate) > VARIES * np.max(np.abs(rate)))
    away = T - middle
    columns = [np.ones_like(T), away, *([-rate] if told else [])]
    line = np.linalg.lstsq(np.column_stack(columns), channel, rcond=None)[0]
    cubic = np.linalg.lstsq(np.column_stack([*columns, away**3]), channel, rcond=None)[0]
    x = places - middle
    curve = (cubic[0] + cubic[1] * x + cubic[-1] * x**3) - (line[0] + line[1] * x)
    return Line(float(line[0]), float(line[1]), float(line[2]) if told else np.nan, np.asarray(curve))


def _blocks(one: Sweep, axis: str) -> tuple[Array, Array, Array]:
    """Return means over blocks: of the reference, of the channel, and the rate of the channel [degC/s]."""
    assert one.reference is not None  # noqa: S101 - whoever chose the sweeps
    good = np.isfinite(one.reference) & np.isfinite(one.temperature[axis])
    size = max(1, int(good.sum()) // BLOCKS)
    count = int(good.sum()) // size
    seconds = np.zeros(len(good)) if one.time is None else one.time
    at, T, channel = (
        values[good][: count * size].reshape(count, size).mean(axis=1)
        for values in (seconds, one.reference, one.temperature[axis])
    )
    known = one.time is not None and count > 1
    return T, channel, np.gradient(channel, at) if known else np.zeros(count)


def _rows(plan: Plan, axis: str, lines: list[Line], span: tuple[float, float]) -> Iterator[Row]:
    n, middle = len(lines), 0.5 * (span[0] + span[1])
    stated = plan.standards.get(STANDARD)
    one_rate = any(np.isnan(one.lag) for one in lines)
    limits = ONE_RATE if one_rate else RELATIVE if stated is None else Reason()

    def row(quantity: str, values: Array, unit: str, by_reference: float, reason: Reason) -> Row:
        """Return the mean over power-ups; ``by_reference``: its change with the error of the reference [unit/degC]."""
        if n < 2:
            return not_estimated(Key(quantity, axis), unit, ONE_RUN)
        value, scatter = float(np.mean(values)), float(np.std(values, ddof=1)) / np.sqrt(n)
        common = 0.0 if stated is None else stated.u * by_reference
        u = float(np.hypot(scatter, common))
        dof = float((n - 1) * (u / scatter) ** 4) if scatter else np.inf
        known = {STANDARD: common} if common else {}
        finite = dof if np.isfinite(dof) else None
        return Row(Key(quantity, axis), value, u, unit, finite, t_interval(value, u, dof), reason=reason, shared=known)

    a, b = np.array([one.a for one in lines]), np.array([one.b for one in lines])
    own: Thermometer | None = (plan.thermometers or {}).get(axis)
    if own is not None:
        yield row("thermometer_slope", own.slope * b, "V/degC", 0.0, limits)
        there = own.voltage + own.slope * (a + b * (own.temperature - middle) - own.temperature)
        yield row("thermometer_voltage", there, "V", -own.slope * float(np.mean(b)), limits)
    ends = np.array([[one.a + one.b * (T - middle) - T for T in span] for one in lines])
    worst = int(np.argmax(np.abs(ends.mean(axis=0))))
    yield row("temperature_error", ends[:, worst], "degC", -float(np.mean(b)), limits)
    yield row("temperature_error_of_range", ends[:, worst] / (span[1] - span[0]), "1",
              -float(np.mean(b)) / (span[1] - span[0]), limits)  # fmt: skip
    curves = np.array([one.curve for one in lines])
    at = int(np.argmax(np.abs(curves.mean(axis=0))))
    yield row("thermometer_nonlinearity", curves[:, at], "degC", 0.0, Reason())
    if one_rate:
        yield not_estimated(Key("thermometer_lag", axis), "s", ONE_RATE)
    else:
        yield row("thermometer_lag", np.array([one.lag for one in lines]), "s", 0.0, Reason())
