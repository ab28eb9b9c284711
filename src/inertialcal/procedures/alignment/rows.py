"""Rows and curves of an alignment."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.key import NO_REASON, Key, Reason
from ...core.results import Interval, Row, not_estimated
from ...core.show.rounding import number
from ...physics.earth import OMEGA
from ...statistics.intervals import t_interval
from .keys import BIAS, HEADING, LATITUDE, ROLL, VERTICAL
from .solving import solve
from .turns import degrees, per_hour

if TYPE_CHECKING:
    from .reduction import Result

ONE = Reason("one_position", "one position does not tell it from the rate of the earth: turn the unit by 180 deg")
SEVERAL = Reason("latitude", "by the known rate of the earth about the vertical")
STEEP = Reason("x_vertical", "x stands within 10 deg of the vertical, and has no azimuth: mount the unit otherwise")
POINTS = 60  # of a heading over time


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI."""
    told = result.estimate
    one, whole = len(result.readings) == 1, result.whole
    for at, key in enumerate(whole.keys):
        unit, value, u, dof = whole.units[at], float(whole.values[at]), float(whole.u[at]), float(whole.dof[at])
        if str(key) not in told.names:
            if key.quantity == VERTICAL and not one:
                continue
            yield not_estimated(key, unit, _why(result, key))
            continue
        interval = t_interval(value, u, dof)
        if key.quantity == HEADING:
            half = math.asin(min(result.half_width(key), 1.0))
            interval = Interval(value - half, value + half)
        reason = NO_REASON
        if key.quantity == VERTICAL:
            reason = SEVERAL
        yield Row(key, value, u, unit, dof if math.isfinite(dof) else None, interval, reason=reason,
                  shared=told.shared(key))  # fmt: skip


def _why(result: Result, key: Key) -> Reason:
    """Return why a figure is not told."""
    if key.quantity == BIAS:
        return ONE
    if key.quantity in (HEADING, ROLL) and result.steep:
        return STEEP
    if key.quantity == LATITUDE:
        circular = len(result.readings) == 1 and not result.stated
        return Reason("bias_unknown", "the latitude is what tells the bias") if circular else (
            Reason("gyro_too_coarse", "the rates tell it no better than to 20 deg"))  # fmt: skip
    horizontal = OMEGA * math.cos(result.given.latitude)
    wide = number(math.degrees(result.forecast), 3)
    text = f"u of the heading is {wide} deg: {per_hour(result.bias_u)} of bias, drift and noise against "
    text += f"{per_hour(horizontal)} of the earth in level at {degrees(result.given.latitude)} of latitude"
    return Reason("gyro_too_coarse", text)


def curves(result: Result) -> list[Curve]:
    """Return the level rates of the positions with their circle, and the heading over the time that it takes."""
    return [_rates(result), *([_forming(result)] if result.told else [])]


def _rates(result: Result) -> Curve:
    """Return level rates in the axes of each position, forward and right, with that of the circle's middle."""
    from ...physics.attitude import from_roll_pitch_yaw  # noqa: PLC0415 - as in `solving`
    from .solving import FLIP  # noqa: PLC0415

    flip = FLIP if result.given.up else np.ones(3)
    found = result.solution
    bias = (found.bias if len(result.readings) > 1 else np.zeros(3)) * flip
    points = []
    for roll, pitch, rate in zip(found.roll, found.pitch, result.given.gyro, strict=True):
        level = from_roll_pitch_yaw(roll, pitch, 0.0)
        points.append([*(level @ (rate * flip))[:2], *(level @ bias)[:2]])
    wide = np.array(points).T
    circle = np.full(len(points), OMEGA * math.cos(result.given.latitude))
    columns = {"position": Column(np.arange(1.0, len(points) + 1.0))}
    for name, values in zip(("forward", "right", "bias_forward", "bias_right"), wide, strict=True):
        columns[name] = Column(values, "rad/s", "deg/h")
    columns["circle"] = Column(circle, "rad/s", "deg/h")
    columns["u"] = Column(np.full(len(points), result.bias_u), "rad/s", "deg/h")
    return Curve("alignment_rates", "", columns)


def _forming(result: Result) -> Curve:
    """Return the heading of the first position from the first part of each."""
    positions, shortest = result.readings.positions, min(one.seconds for one in result.readings.positions)
    parts, times, found = np.linspace(0.05, 1.0, POINTS), [], []
    last = float(result.solution.heading[0])
    for part in parts:
        force = np.array([one.acc[: max(int(part * shortest / one.seconds * len(one.acc)), 1)].mean(axis=0)
                          for one in positions])  # fmt: skip
        rates = np.array([one.gyro[: max(int(part * shortest / one.seconds * len(one.gyro)), 1)].mean(axis=0)
                          for one in positions])  # fmt: skip
        heading = float(solve(replace(result.given, acc=force, gyro=rates)).heading[0])
        found.append(last + math.remainder(heading - last, 2.0 * math.pi))
        times.append(part * shortest)
    key = next(one for one in result.whole.keys if one.quantity == HEADING)
    at = result.whole.index(key)
    shift = float(result.whole.values[at]) - last
    half = math.asin(min(result.half_width(key), 1.0))
    end = float(result.whole.values[at])
    return Curve("alignment_forming", "", {
        "time": Column(np.array(times), "s"),
        "heading": Column(np.array(found) + shift, "rad", "deg"),
        "lo": Column(np.full(POINTS, end - half), "rad", "deg"),
        "hi": Column(np.full(POINTS, end + half), "rad", "deg"),
    })  # fmt: skip
