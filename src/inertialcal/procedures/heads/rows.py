"""Rows and curves of a calibration of heads by others."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.key import AXES, NO_REASON, At, Key, Reason
from ...core.results import Row, not_estimated
from ...core.show.rounding import number
from ...statistics.intervals import t_interval
from .found import BIAS, RELATIVE, SCALE, Calibrated, known_heads

if TYPE_CHECKING:
    from ...core.estimate import Array
    from .reduction import Result

GROWTH, OFF, COST = "uncertainty_growth", "off_line_distance", "off_line_uncertainty"
MOTION = Reason("motion_unknown", (
    "the head lies off the line of the calibrated ones, and how the body turns is not known: record a gyro, or state"
    " rate_u and acceleration_u under [motion]"))  # fmt: skip
QUIET = Reason("quiet", "the motion is too small for it: needs 10 times the noise of an interval")
FLIP = Reason("needs_flip", "relative to the calibrated heads: flip them, and give bias and bias_u of each")


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI."""
    known = known_heads(result.readings)
    names = [result.readings.tracks[i].mounted.name for i in known]
    estimate = result.estimate
    if estimate is not None:
        for i, key in enumerate(estimate.keys):
            value, u, dof = (float(one[i]) for one in (estimate.values, estimate.u, estimate.dof))
            at = int(key.at.value) if key.at is not None else result.heads[0].number
            one = next(head for head in result.heads if head.number == at)
            reason = _meaning(one, names) if key.quantity == RELATIVE else NO_REASON
            yield Row(key, value, u, estimate.units[i], dof if math.isfinite(dof) else None,
                      t_interval(value, u, dof), reason=reason)  # fmt: skip
    for one in result.heads:
        place = At("head", float(one.number), "") if len(result.heads) > 1 else None
        for m, axis in enumerate(AXES):
            if not one.told:
                yield not_estimated(Key(RELATIVE, axis, at=place), "m/s^2", MOTION)
            if not one.told or not result.absolute:
                yield not_estimated(Key(BIAS, axis, at=place), "m/s^2", MOTION if not one.told else FLIP)
            if (not one.told or not one.carried[m]) and result.plan.scale_factor == "auto":
                yield not_estimated(Key(SCALE, axis, at=place), "1", QUIET if one.told else MOTION)
        said = Reason("geometry", f"the uncertainty of {', '.join(names)} grows by it")
        yield Row(Key(GROWTH, at=place), one.weights.growth, None, "1", reason=said)
        said = Reason("geometry", "from the line, plane or space through the calibrated heads")
        yield Row(Key(OFF, at=place), float(np.linalg.norm(one.weights.off)), None, "m", reason=said)
        if one.told:
            cost = float(np.sqrt(np.max(np.linalg.eigvalsh(result.off_line[one.name]))))
            said = Reason("geometry", "standard uncertainty by what is not known of the angular motion, the worst way")
            yield Row(Key(COST, at=place), cost, None, "m/s^2", reason=said)


def _meaning(one: Calibrated, names: list[str]) -> Reason:
    """Return what a relative bias is, as a formula."""
    terms = [f"{'-' if w > 0.0 else '+'} {number(abs(float(w)), 4)} b({name})"
             for w, name in zip(one.weights.weights, names, strict=True)]  # fmt: skip
    return Reason("relative", f"b({one.name}) {' '.join(terms)}")


def curves(result: Result) -> list[Curve]:
    """Return what each head reads beyond the others over time, and what its place costs."""
    return [_gap(result, one) for one in result.heads] + [_places(result, one) for one in result.heads if one.told]


def _gap(result: Result, one: Calibrated) -> Curve:
    time = result.times - result.times[0]
    columns = {"time": Column(time, "s")}
    for i, axis in enumerate(AXES):
        columns[axis] = Column(one.gap[:, i], "m/s^2", "ug")
        columns[f"fitted_{axis}"] = Column(one.gap[:, i] - one.line.rest[:, i], "m/s^2", "ug")
    return Curve("heads_gap", "", columns, of=one.name)


def _places(result: Result, one: Calibrated) -> Curve:
    """Return what the uncertainty of the bias would be at other places along the line of two heads, by their noise."""
    growth = one.weights.growth
    noise = float(np.sqrt(np.mean(np.var(one.line.rest, axis=0)) / (1.0 + growth**2) / len(one.gap)))
    along = np.linspace(-1.0, 2.5, 71)
    each: Array = noise * np.sqrt(1.0 + (1.0 - along) ** 2 + along**2)
    at = float(one.weights.weights[-1]) if len(one.weights.weights) == 2 else math.nan
    columns = {
        "along": Column(along),
        "u": Column(each, "m/s^2", "ug"),
        "head": Column(np.full(len(along), at)),
        "cost": Column(np.full(len(along), math.sqrt(max(float(np.trace(result.off_line[one.name])) / 3.0, 0.0))),
                       "m/s^2", "ug"),
    }  # fmt: skip
    return Curve("heads_places", "", columns, of=one.name)
