"""Curves of a shifted ground model: the shift over flights with its prediction, and over temperature."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.recording import SECOND
from ...statistics.intervals import coverage_factor
from .later import Predicted, predicted
from .model import UNIT, AxisShift, bias_at
from .readings import ground_bias

if TYPE_CHECKING:
    from .reduction import Result

POINTS = 25
BEYOND = 0.15  # of the time between first and last flight, that the prediction goes on
YEAR = 365.25 * 86400.0


def curves(result: Result) -> list[Curve]:
    """Return the curves, SI."""
    found = []
    for axis, one in result.shifts.items():
        found += [_flights(result, axis, one), _trend(result, axis, one), _temperature(result, axis, one)]
    return found


def _begin(result: Result) -> int:
    return min(flip.time for one in result.shifts.values() for flip in one.flips)


def _flights(result: Result, axis: str, one: AxisShift) -> Curve:
    """Return the shift that each flip found, those of flights that were left out too."""
    begin = _begin(result)
    later = [each for each in predicted(result, result.later) if each.axis == axis]
    shifts = [*one.fit.shift.tolist(), *(each.measured - each.ground for each in later)]
    u = [*(flip.u * one.fit.widened for flip in one.flips), *(each.u_flips for each in later)]
    left = one.fit.shift - one.fit.design @ one.fit.coefficients
    half = 1.96 * np.array(u)
    times = [*(flip.time for flip in one.flips), *(each.time for each in later)]
    columns = {
        "flight": Column([*(flip.flight for flip in one.flips), *(each.flight for each in later)]),
        "age": Column([(time - begin) / SECOND for time in times], "s", shown="year"),
        "temperature": Column(
            [*(flip.temperature for flip in one.flips), *(each.temperature for each in later)], "degC"
        ),
        "used": Column([*([True] * len(one.flips)), *([False] * len(later))]),
        "shift": Column(np.array(shifts), UNIT),
        "left": Column(np.array([*left.tolist(), *(each.error for each in later)]), UNIT),
        "u": Column(np.array(u), UNIT),
        "lo": Column(np.array(shifts) - half, UNIT),
        "hi": Column(np.array(shifts) + half, UNIT),
    }
    return Curve("shifted_flights", axis, columns)


def predictions(flights: Sequence[Predicted]) -> tuple[Curve, ...]:
    """Return what flights that were left out measured, and what both models say of them, axis by axis."""
    found = []
    for axis in dict.fromkeys(one.axis for one in flights):
        own = [one for one in flights if one.axis == axis]
        columns = {
            "flight": Column([one.flight for one in own]),
            "temperature": Column([one.temperature for one in own], "degC"),
            "measured": Column([one.measured for one in own], UNIT),
            "ground": Column([one.ground for one in own], UNIT),
            "predicted": Column([one.predicted for one in own], UNIT),
            "error": Column([one.error for one in own], UNIT),
            "u": Column([one.u for one in own], UNIT),
            "dof": Column([one.dof for one in own]),
            "inside": Column([one.inside for one in own]),
        }
        found.append(Curve("shifted_predicted", axis, columns))
    return tuple(found)


def _band(result: Result, one: AxisShift, axis: str, time: int, temperatures: Array) -> tuple[Array, Array, Array]:
    """Return the shift of the new model at temperatures, and its 95 % interval for a flight to come."""
    model = result.model(time)
    ground = ground_bias(result.readings.ground, temperatures, result.plan.bias_of)[:, model.axes.index(axis)]
    middle, half = np.zeros(len(temperatures)), np.zeros(len(temperatures))
    for i, temperature in enumerate(temperatures):
        value, u, dof = bias_at(model, result, axis, np.array([temperature]))
        middle[i] = value - ground[i]
        half[i] = coverage_factor(min(dof, one.fit.dof or dof)) * math.hypot(u, one.launch(time, float(temperature)))
    return middle, middle - half, middle + half


def _trend(result: Result, axis: str, one: AxisShift) -> Curve:
    begin = _begin(result)
    times = [flip.time for flip in one.flips] + [flip.time for flip in result.later.flips] + [result.date]
    span = max((max(times) - begin) / SECOND, YEAR)
    ages = np.linspace(0.0, span * (1.0 + BEYOND), POINTS)
    bands = [_band(result, one, axis, begin + round(float(age) * SECOND), np.array([one.temperature])) for age in ages]
    shift, lo, hi = (np.array([band[i][0] for band in bands]) for i in range(3))
    columns = {
        "age": Column(ages, "s", shown="year"),
        "shift": Column(shift, UNIT),
        "lo": Column(lo, UNIT),
        "hi": Column(hi, UNIT),
    }
    return Curve("shifted_trend", axis, columns)


def _temperature(result: Result, axis: str, one: AxisShift) -> Curve:
    ends = result.readings.ground.temperature_range
    own = [flip.temperature for flip in (*one.flips, *result.later.flips)]
    low, high = ends if ends is not None else (min(own) - 5.0, max(own) + 5.0)
    temperatures = np.linspace(low, high, POINTS)
    shift, lo, hi = _band(result, one, axis, result.date, temperatures)
    columns = {
        "temperature": Column(temperatures, "degC"),
        "shift": Column(shift, UNIT),
        "lo": Column(lo, UNIT),
        "hi": Column(hi, UNIT),
    }
    return Curve("shifted_temperature", axis, columns)
