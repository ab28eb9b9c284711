"""Curves of a flip's result, SI: what its figures show.

``flip_dwells``
    Each dwell of an axis: position, time, reading, what the flip's result says it should read, and its residual.
``quiet``
    Of each recording: the block means of an axis that the noise was found from, with the position.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...core.axes import AXES
from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.key import Key
from .plan import Plan
from .readings import Quiet, Readings
from .separation.equations import AMBIENT, BIAS, CONTROL, QUADRATURE, READING, Separated
from .separation.positions import directions, rotation

if TYPE_CHECKING:
    from .reduction import Result

UNIT = "m/s^2"


def curves(result: Result) -> list[Curve]:
    """Return the curves of all axes and recordings."""
    found = [_dwells(result, axis) for axis in result.readings.axes]
    return found + [_quiet(one, axis) for one in result.readings.quiet for axis in one.means]


def _dwells(result: Result, axis: str) -> Curve:
    readings = result.readings
    reading = readings.outputs[axis]
    expected = _expected(result, axis)
    time = readings.time if readings.time is not None else np.full(len(readings), np.nan)
    return Curve(
        "flip_dwells",
        axis,
        {
            "flip": Column([str(label) for label in readings.flip]),
            "angle": Column(readings.angle, "rad"),
            "time": Column(time, "s"),
            "reading": Column(reading, UNIT),
            "expected": Column(expected, UNIT),
            "residual": Column(reading - expected, UNIT),
            "place": Column(list(readings.where) if readings.where else [""] * len(readings)),
        },
    )


def _expected(result: Result, axis: str) -> Array:
    """Return what a flip's own result makes of each dwell, drifts left out; NaN where it was not separated."""
    found = np.full(len(result.readings), np.nan)
    for one in result.flips:
        own = np.flatnonzero(result.readings.flip == one.label)
        found[own] = _model(result.plan, result.readings, one.separated[0], axis, own)
    return found


def _model(plan: Plan, readings: Readings, one: Separated, axis: str, own: NDArray[np.intp]) -> Array:
    angle = readings.angle[own]
    if axis == plan.axis:
        read = np.isfinite(readings.outputs[axis][own])
        told = directions(angle[read])
        parts = [one.value(Key(name, axis)) or 0.0 for name in (CONTROL, QUADRATURE)][: told.shape[1]]
        level = one.value(Key(READING, axis))
        found = np.full(len(own), np.nan)
        found[read] = (np.nan if level is None else level) + told @ np.array(parts)
        return found
    bias = one.value(Key(BIAS, axis))
    if bias is None:
        return np.full(len(own), np.nan)
    g = np.array([one.value(Key(AMBIENT, name)) or 0.0 for name in AXES])
    return np.asarray(bias + rotation(plan.axis, angle)[:, AXES.index(axis)] @ g)


def _quiet(one: Quiet, axis: str) -> Curve:
    one = one.of(axis)
    used = np.any(one.weights > 0.0, axis=0)
    columns = {
        "time": Column(one.times, "s"),
        "mean": Column(one.means[axis], UNIT),
        "angle": Column(one.angle, "rad"),
        "used": Column(used),
    }
    return Curve("quiet", axis, columns, recording=one.name)
