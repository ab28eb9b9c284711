"""Curves of a flip's result, SI: the data of its figures.

``flip_dwells``
    Each dwell of an axis: position, time, reading, its value by the flip's result, and the residual.
``quiet``
    Of each recording: the block means of an axis behind its noise, with the position.
``turns``
    Of each recording: between which times each turn lies that it shows, with the axis of the turn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.key import AXES, Key
from .plan import Plan
from .readings import Quiet, Readings
from .separation.equations import AMBIENT, BIAS, CONTROL, QUADRATURE, READING, Separated, directions, rotation

if TYPE_CHECKING:
    from .reduction import Result

UNIT = "m/s^2"


def curves(result: Result) -> list[Curve]:
    """Return the curves of all axes and recordings."""
    found = [_dwells(result, axis) for axis in result.readings.axes]
    found += [_quiet(one, axis) for one in result.readings.quiet for axis in one.means]
    return found + [_turns(one, result.plan.axis) for one in result.readings.quiet if len(one.turns)]


def _dwells(result: Result, axis: str) -> Curve:
    readings = result.readings
    reading = readings.outputs[axis]
    expected = np.full(len(readings), np.nan)
    for one in result.flips:
        own = np.flatnonzero(readings.flip == one.label)
        expected[own] = _expected(result.plan, readings, one.separated[0], axis, own)
    columns = {
        "flip": Column([str(label) for label in readings.flip]),
        "angle": Column(readings.angle, "rad"),
        "time": Column(readings.time if readings.time is not None else np.full(len(readings), np.nan), "s"),
        "reading": Column(reading, UNIT),
        "expected": Column(expected, UNIT),
        "residual": Column(reading - expected, UNIT),
        "place": Column(list(readings.where) if readings.where else [""] * len(readings)),
    }
    return Curve("flip_dwells", axis, columns)


def _expected(plan: Plan, readings: Readings, one: Separated, axis: str, own: NDArray[np.intp]) -> Array:
    """Return the reading of each dwell by a flip's own result, drifts left out; NaN where it was not separated."""
    angle = readings.angle[own]
    if axis == plan.axis:
        read = np.isfinite(readings.outputs[axis][own])
        turned = directions(angle[read])
        parts = [one.value(Key(name, axis)) or 0.0 for name in (CONTROL, QUADRATURE)][: turned.shape[1]]
        level = one.value(Key(READING, axis))
        expected = np.full(len(own), np.nan)
        expected[read] = (np.nan if level is None else level) + turned @ np.array(parts)
        return expected
    bias = one.value(Key(BIAS, axis))
    if bias is None:
        return np.full(len(own), np.nan)
    g = np.array([one.value(Key(AMBIENT, name)) or 0.0 for name in AXES])
    return np.asarray(bias + rotation(plan.axis, angle)[:, AXES.index(axis)] @ g)


def _quiet(one: Quiet, axis: str) -> Curve:
    one = one.of(axis)
    columns = {
        "time": Column(one.times, "s"),
        "mean": Column(one.means[axis], UNIT),
        "angle": Column(one.angle, "rad"),
        "used": Column(np.any(one.weights > 0.0, axis=0)),
    }
    return Curve("quiet", axis, columns, recording=one.name)


def _turns(one: Quiet, axis: str) -> Curve:
    columns = {"start": Column(one.turns[:, 0], "s"), "stop": Column(one.turns[:, 1], "s")}
    return Curve("turns", axis, columns, recording=one.name)
