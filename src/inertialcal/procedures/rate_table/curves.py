"""Curves of a rate-table result, SI: what its figures show.

``input_output``
    Every dwell about a sensor's own axis, left out or not: reading and residual over the applied rate. The residual
    is reading minus fitted line; of the rotation of the earth it has what the line expects to read.
``rate_error``
    The error in percent of the rate, with its own 95 % interval at each rate.
``linearity``
    Mean deviation at each rate from the best straight line, as a part of the largest rate, with the interval that
    holds for all rates together, and what the fitted line has of asymmetry and curvature there.
``trace``, ``dwells``
    Of each recording: least and largest value of each channel per bin, and the dwells that were cut from it, with
    the reading of the sensor about the axis that was turned. Dwells at rest that were subtracted count as used.

A dwell that was left out carries the code of the rule, the same as in the remarks: ``at_rail``, ``odd_scatter``,
``dwell_incomplete``; ``not_read`` where there is no reading.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.curve import Column, Curve
from ...statistics.intervals import band_factor, t_interval
from .exclusions import exclusions
from .fit.linearity import deviations
from .fit.rate_error import Of, RateError, rate_errors
from .fit.regression import reading_of_line
from .plan import Plan
from .readings import Readings, Trace

if TYPE_CHECKING:
    from .reduction import Result

NOT_READ = "not_read"
INCOMPLETE = "dwell_incomplete"
RATE = "rad/s"


def curves(result: Result, of: Of = "dwell_mean") -> list[Curve]:
    """Return the curves of all sensors that were turned about their own axis, and of all recordings, SI."""
    found: list[Curve] = []
    for sensor, one in result.lines.items():
        if sensor in one.axes:
            found += [input_output(result, sensor), rate_error(result, sensor, of), *linearity(result, sensor)]
    reasons = {sensor: left_out(result.plan, result.readings, sensor) for sensor in result.readings.outputs}
    for one_trace in result.readings.traces:
        found += [*channels(one_trace), dwells(one_trace, reasons[one_trace.sensor])]
    return found


def input_output(result: Result, sensor: str) -> Curve:
    """Return reading and residual of one sensor in every dwell about its own axis [rad/s], in the order given."""
    readings = result.readings
    reasons = left_out(result.plan, readings, sensor)
    own = np.flatnonzero(readings.axis == sensor)
    reading = readings.outputs[sensor]
    residual = reading - reading_of_line(result.lines[sensor], readings)
    return Curve(
        "input_output",
        sensor,
        {
            "applied": Column(readings.applied[own], RATE),
            "reading": Column(reading[own], RATE),
            "residual": Column(residual[own], RATE),
            "run": Column(_labels(readings.run, own)),
            "group": Column(_labels(readings.group, own)),
            "used": Column([not reasons[i] for i in own]),
            "reason": Column([reasons[i] for i in own]),
            "place": Column([readings.where[i] if readings.where else "" for i in own.tolist()]),
        },
    )


def left_out(plan: Plan, readings: Readings, sensor: str) -> list[str]:
    """Return by which rule each dwell of a sensor is left out, by its code; empty where it is used."""
    found = exclusions(plan, readings, sensor)
    codes = np.full(len(readings), "", dtype=object)
    codes[found.scatter] = "odd_scatter"
    codes[found.rail] = "at_rail"
    codes[~np.isfinite(readings.outputs[sensor])] = NOT_READ
    if readings.incomplete is not None:
        codes[readings.incomplete] = INCOMPLETE
    return [str(code) for code in codes]


def channels(one: Trace) -> list[Curve]:
    """Return each channel of a recording as least and largest value per bin [rad/s]; None in a gap."""
    return [
        Curve(
            "trace",
            name,
            {"time": Column(one.time, "s"), "lo": Column(one.lo[:, i], RATE), "hi": Column(one.hi[:, i], RATE)},
            recording=one.recording,
            picture=True,
        )
        for i, name in enumerate(one.names)
    ]


def dwells(one: Trace, reasons: Sequence[str]) -> Curve:
    """Return the dwells cut from a recording, with the mean reading of the sensor about the axis turned."""
    cut = one.dwells
    why = [reasons[row] if row >= 0 else "" for row in cut.row]
    return Curve(
        "dwells",
        one.sensor,
        {
            "start": Column(cut.start, "s"),
            "stop": Column(cut.stop, "s"),
            "level": Column(cut.level, RATE),
            "applied": Column(cut.applied, RATE),
            "used": Column([not reason for reason in why]),
            "reason": Column(why),
        },
        recording=one.recording,
    )


def _labels(labels: Any, at: Any) -> list[str]:
    return [""] * len(at) if labels is None else [str(label) for label in labels[at]]


def rate_error(result: Result, sensor: str, of: Of = "dwell_mean") -> Curve:
    """Return the relative error of one sensor at each rate of its own axis (1), with its 95 % interval."""
    errors = rate_errors(result.plan, result.readings, result.lines[sensor], of)
    ends = [_ends(one) for one in errors]
    return Curve(
        "rate_error",
        sensor,
        {
            "rate": Column([one.applied for one in errors], RATE),
            "error": Column([one.error for one in errors], "1"),
            "u": Column([one.u for one in errors], "1"),
            "dof": Column([one.dof for one in errors]),
            "lo": Column([lo for lo, _ in ends], "1"),
            "hi": Column([hi for _, hi in ends], "1"),
        },
        of=of,
    )


def linearity(result: Result, sensor: str) -> list[Curve]:
    """Return the deviations from the best straight line, over the largest rate (1); none without scatter."""
    straight, one = result.straight[sensor], result.lines[sensor]
    found = deviations(straight, result.full[sensor])
    if found is None:
        return []
    rates, means, sigmas, dof = found
    half = band_factor(len(rates), dof, 0.95) * sigmas
    own = straight.readings.axis == sensor
    bent = one.fit.design @ one.fit.coefficients - straight.fit.design @ straight.fit.coefficients
    bent = bent - np.mean(bent[own])
    fitted = np.array([np.mean(bent[own & (straight.readings.applied == rate)]) for rate in rates])
    scale = float(np.max(np.abs(rates)))
    parts = {"deviation": means, "lo": means - half, "hi": means + half, "fitted": fitted}
    columns = {name: Column(values / scale, "1") for name, values in parts.items()}
    return [Curve("linearity", sensor, {"rate": Column(rates, RATE), **columns})]


def _ends(one: RateError) -> tuple[float | None, float | None]:
    if one.error is None or one.u is None:
        return None, None
    interval = t_interval(one.error, one.u, one.dof)
    return interval.lo, interval.hi
