"""Calibration of a unit's own temperature channel against a reference thermometer, from the sweeps of a thermal test.

The channel is converted by its nominal slope and voltage. In each power-up::

    channel = a + b t + c t^2 + d t^3 - tau d(channel)/dt       t = T - T_m, T: reference, T_m: middle of the range

A straight line (c = d = 0) gives slope and voltage. The error is ``channel - T`` by the cubic, over the range of
temperatures that all power-ups went through: its figure is that of the temperature where its interval reaches
farthest from zero, and a requirement is judged where it reaches highest and lowest, so that it PASSes only if it
does at every temperature.

Assumed: the sensor follows the reference with one time constant tau, alike in warming and cooling, so that at rest
both are at one temperature. Where the temperature changed at one rate alone, tau cannot be told from a, which the
reason says. A cubic follows the channel.
What u means: the scatter from power-up to power-up (Student's t with one less than there are), joined with the
reference's ``thermometer.temperature``, one unknown for all. One power-up has no u.

How real data break it: a chamber that is ahead of the sensor (tau); a channel that is not linear (the cubic); a
reference that is off (stated, or the result is relative to it).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...core.batches import count, extremes, kept, made
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.judging import Asked, Verdict
from ...core.key import Key, Reason
from ...core.results import Row, not_estimated
from ...statistics.decision import decide
from ...statistics.intervals import t_interval
from ..protocol import Tested
from .plan import Plan, Thermometer
from .recordings import Readings, Sweep, block_means

if TYPE_CHECKING:
    from .reduction import Result

BLOCKS = 500  # of a recording, whose means are fitted
VARIES = 0.2  # standard deviation of the rates over the fastest, from which a delay shows
PLACES = 41  # temperatures at which the error is looked for
STANDARD = "thermometer.temperature"
ONE_RUN = Reason("one_run", "one power-up: not repeated")
ONE_RATE = Reason("one_rate", "one rate of change alone: a delay of the sensor is in it")
RELATIVE = Reason("relative", "relative to the reference thermometer")
ERROR, ERROR_OF_RANGE = "temperature_error", "temperature_error_of_range"


@dataclass(frozen=True, eq=False)
class Line:
    """One power-up of one axis."""

    a: float
    b: float
    lag: float  # tau [s]; NaN where the temperature changed at one rate
    channel: Array  # shape (PLACES,): at rest, by the cubic [degC]


@dataclass(frozen=True, eq=False)
class Calibrated:
    """All power-ups of one axis, over the temperatures that all of them went through."""

    axis: str
    lines: tuple[Line, ...]
    places: Array  # shape (PLACES,) [degC]
    stated: Influence | None  # Error of the reference [degC]

    @property
    def middle(self) -> float:
        """Middle of the range [degC]."""
        return float(np.mean(self.places[[0, -1]]))

    @property
    def limits(self) -> Reason:
        """What the figures exclude."""
        one_rate = any(np.isnan(one.lag) for one in self.lines)
        return ONE_RATE if one_rate else RELATIVE if self.stated is None else Reason()

    def row(self, quantity: str, values: Array, unit: str, by_reference: float, reason: Reason) -> Row:
        """Return the mean over power-ups; ``by_reference``: its change with the error of the reference [unit/degC]."""
        key, n = Key(quantity, self.axis), len(self.lines)
        if n < 2:
            return not_estimated(key, unit, ONE_RUN)
        value, scatter = float(np.mean(values)), float(np.std(values, ddof=1)) / np.sqrt(n)
        common = 0.0 if self.stated is None else self.stated.u * by_reference
        u = float(np.hypot(scatter, common))
        dof = float((n - 1) * (u / scatter) ** 4) if scatter else np.inf
        known = {STANDARD: common} if common else {}
        finite = dof if np.isfinite(dof) else None
        return Row(key, value, u, unit, finite, t_interval(value, u, dof), reason=reason, shared=known)

    def errors(self, quantity: str) -> list[Row]:
        """Return the error at each of the places, in degC or as a part of the range."""
        unit, size = ("1", self.places[-1] - self.places[0]) if quantity == ERROR_OF_RANGE else ("degC", 1.0)
        channel = np.array([one.channel for one in self.lines])
        slope = np.gradient(channel.mean(axis=0), self.places)
        each = (channel - self.places) / size
        return [self.row(quantity, each[:, k], unit, -slope[k] / size, self.limits) for k in range(PLACES)]


def thermometer_rows(plan: Plan, readings: Readings, axis: str) -> Iterator[Row]:
    """Yield what is known of the temperature channel of an axis; nothing where no reference was recorded."""
    one = _calibrated(plan, readings, axis)
    if one is None:
        return
    a, b, lag = (np.array([getattr(line, name) for line in one.lines]) for name in ("a", "b", "lag"))
    own: Thermometer | None = (plan.thermometers or {}).get(axis)
    if own is not None:
        yield one.row("thermometer_slope", own.slope * b, "V/degC", 0.0, one.limits)
        there = own.voltage + own.slope * (a + b * (own.temperature - one.middle) - own.temperature)
        yield one.row("thermometer_voltage", there, "V", -own.slope * float(np.mean(b)), one.limits)
    yield from (max(one.errors(name), key=_reach) for name in (ERROR, ERROR_OF_RANGE))
    curves = np.array([line.channel - line.a - line.b * (one.places - one.middle) for line in one.lines])
    at = int(np.argmax(np.abs(curves.mean(axis=0))))
    yield one.row("thermometer_nonlinearity", curves[:, at], "degC", 0.0, Reason())
    if one.limits == ONE_RATE:
        yield not_estimated(Key("thermometer_lag", axis), "s", ONE_RATE)
    else:
        yield one.row("thermometer_lag", lag, "s", 0.0, Reason())


def judge_error(asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]) -> Iterator[Verdict]:
    """Yield the verdicts on the error of the temperature channel, where its interval reaches lowest and highest."""
    for test in tests:
        for axis in test.result.sensors:
            one = _calibrated(test.result.plan, test.result.readings, axis)
            if one is not None and asked.axis in (None, axis):
                rows = one.errors(asked.quantity)
                ends = [int(np.argmin([_end(row, -1) for row in rows])), int(np.argmax([_end(row, 1) for row in rows]))]
                for k in dict.fromkeys(ends):
                    yield _verdict(asked, test.id, rows[k], round(float(one.places[k]), 2))


def _verdict(asked: Asked, test: str, row: Row, at: float) -> Verdict:
    lower, upper = asked.limits(row.unit)
    head = (asked.id, test, row.axis, at, "expected", row.value, row.u, row.unit)
    if row.value is None or row.u is None:
        return Verdict(*head, None, lower, upper, "INCONCLUSIVE", row.reason.text, "degC")
    dof = np.inf if row.dof is None else row.dof
    found = decide(row.value, row.u, dof, lower, upper, rule=asked.rule.within(row.unit, lower, upper))
    return Verdict(*head, found.interval, lower, upper, found.status, found.reason, "degC", basis=found.basis)


def _end(row: Row, sign: int) -> float:
    """Return an end of the interval, the value where there is none."""
    ends = row.interval
    found = None if ends is None else ends.hi if sign > 0 else ends.lo
    return found if found is not None else row.value or 0.0


def _reach(row: Row) -> float:
    """Return how far the interval reaches from zero."""
    return max(_end(row, 1), -_end(row, -1))


def _calibrated(plan: Plan, readings: Readings, axis: str) -> Calibrated | None:
    """Return the calibration of an axis; None where no reference was recorded.

    Raises
    ------
    DataError
        ``no_temperature_change``.
    """
    by_run: dict[str, list[Sweep]] = {}
    for one in readings.sweeps:
        if one.reference is not None and axis in one.temperature:
            by_run.setdefault(one.run, []).append(one)
    if not by_run:
        return None
    of_run = [[one.reference for one in own if one.reference is not None] for own in by_run.values()]
    valid = [sum(count(T, np.isfinite) for T in own) for own in of_run]
    known = sum(valid) >= BLOCKS and all(valid)
    ends = [np.array([extremes(T, infinite=False) for T in own]) for own in of_run] if known else []
    low = max((float(np.nanmin(own[:, 0])) for own in ends), default=0.0)
    high = min((float(np.nanmax(own[:, 1])) for own in ends), default=0.0)
    if high - low < plan.least_range:
        what = f"the reference thermometer has a range of {max(high - low, 0.0):.3g} degC in all power-ups"
        do = f"Ramp by {plan.least_range:g} degC or more, in each power-up over the same range"
        raise DataError(what, readings.where, "it calibrates the temperature channel", do, "no_temperature_change")
    places = np.linspace(low, high, PLACES)
    lines = tuple(_line(own, axis, places) for own in by_run.values())
    return Calibrated(axis, lines, places, plan.standards.get(STANDARD))


def _line(sweeps: list[Sweep], axis: str, places: Array) -> Line:
    """Fit means over blocks of one power-up."""
    parts = [_blocks(one, axis) for one in sweeps]
    T, channel, rate = (np.concatenate([part[i] for part in parts]) for i in range(3))
    told = bool(np.std(rate) > VARIES * np.max(np.abs(rate)))
    middle = 0.5 * (places[0] + places[-1])
    columns = [np.ones_like(T), T - middle, *([-rate] if told else [])]
    line = np.linalg.lstsq(np.column_stack(columns), channel, rcond=None)[0]
    half = places[-1] - middle
    bends = [((T - middle) / half) ** k for k in (2, 3)]
    cubic = np.linalg.lstsq(np.column_stack([*columns, *bends]), channel, rcond=None)[0]
    x = places - middle
    curve = cubic[0] + cubic[1] * x + cubic[-2] * (x / half) ** 2 + cubic[-1] * (x / half) ** 3
    return Line(float(line[0]), float(line[1]), float(cubic[2]) if told else np.nan, np.asarray(curve))


def _blocks(one: Sweep, axis: str) -> tuple[Array, Array, Array]:
    """Return means over blocks: of the reference, of the channel, and the rate of the channel [degC/s]."""
    assert one.reference is not None  # noqa: S101 - whoever chose the sweeps
    reference, own = one.reference, one.temperature[axis]
    good = made(len(own), bool, lambda a, b: np.isfinite(reference[a:b]) & np.isfinite(own[a:b]), reference, own)
    size = max(1, count(good, lambda part: part) // BLOCKS)
    T, channel = (block_means(kept(values, good), size) for values in (reference, own))
    if one.time is None or len(T) < 2:
        return T, channel, np.zeros(len(T))
    time, first, block = np.unique(block_means(kept(one.time, good), size), return_index=True, return_inverse=True)
    return T, channel, np.gradient(channel[first], time)[block] if len(time) > 1 else np.zeros(len(T))
