"""Curves of a thermal result, SI: what its figures show.

``thermal_cells``
    Every cell: mean reading over temperature, and what the law with the paths and the offset of its run leaves of it.
``thermal_law``
    Bias over temperature with its 95 % interval at each, and what the paths differ by.
``thermal_order``
    Root mean square error on what was held out, order by order.
``start_up``
    Means after power-up, less the law and the settled level of their run, with the transient; used: after the cut.
``reference_voltage``
    Mean reference voltage over temperature, and its law.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ...statistics.intervals import coverage_factor
from .fit.law import Law
from .fit.quantities import bias_at, earth_along
from .fit.sensor import OfSensor

if TYPE_CHECKING:
    from .reduction import Result

GRID = 61  # temperatures of a law
WAYS = {1: "warming", -1: "cooling"}


def curves(result: Result) -> list[Curve]:
    """Return the curves of all sensors, SI."""
    found: list[Curve] = []
    for axis, one in result.sensors.items():
        found += [_cells(result, axis, one), _law(result, axis, one), _order(result, axis, one)]
        if len(one.start_up.time):
            found.append(_start_up(result, axis, one))
        found += _references(axis, one)
    return found


def _cells(result: Result, axis: str, one: OfSensor) -> Curve:
    cells, unit = one.cells, result.readings.unit
    number = np.unique(cells.run, return_inverse=True)[1]
    left = cells.reading - _fitted(one.law) - one.run_offsets[number]
    earth = _earth(result, axis)
    return Curve(
        "thermal_cells",
        axis,
        {
            "temperature": Column(cells.temperature, "degC"),
            "reading": Column(cells.reading - earth, unit),
            "residual": Column(left, unit),
            "path": Column([WAYS[int(way)] for way in cells.path]),
            "run": Column([result.readings.labels[run] for run in cells.run]),
        },
    )


def _fitted(law: Law) -> Array:
    """Return what the polynomial says of each cell: midway between the paths."""
    return np.asarray(np.einsum("ij,j->i", law.basis(law.cells.temperature), law.coefficients))


def _earth(result: Result, axis: str) -> float:
    if result.readings.unit != "rad/s":
        return 0.0
    return float(earth_along(result.plan)[0][AXES.index(axis)])


def _law(result: Result, axis: str, one: OfSensor) -> Curve:
    law, unit = one.law, result.readings.unit
    at = np.linspace(*law.domain, GRID)
    plan = replace(
        result.plan,
        standards={"sensor.hysteresis": Influence(0.0, unit), **result.plan.standards},
    )
    found = None if unit == "m/s^2" else bias_at(plan, law, axis, unit, at)
    value = law.basis(at) @ law.coefficients - _earth(result, axis)
    u, dof = (np.full(GRID, np.nan),) * 2 if found is None else (found.u, found.dof)
    half = np.array([factor * one_u for factor, one_u in zip(map(_factor, dof), u, strict=True)])
    columns = {
        "temperature": Column(at, "degC"),
        "bias": Column(value, unit),
        "u": Column(u, unit),
        "dof": Column(dof),
        "lo": Column(value - half, unit),
        "hi": Column(value + half, unit),
    }
    if law.midway:
        gap, covariance, free = law.path_contrasts(law.path_basis(at))
        gap_u = np.sqrt(np.diag(covariance))
        gap_half = np.array([_factor(d) * s for d, s in zip(free, gap_u, strict=True)])
        columns |= {
            "path_difference": Column(gap, unit),
            "path_lo": Column(gap - gap_half, unit),
            "path_hi": Column(gap + gap_half, unit),
        }
    return Curve("thermal_law", axis, columns)


def _factor(dof: float) -> float:
    return coverage_factor(float(dof)) if dof > 0.0 else np.nan


def _order(result: Result, axis: str, one: OfSensor) -> Curve:
    scores = one.choice.scores
    return Curve(
        "thermal_order",
        axis,
        {
            "order": Column(list(range(len(scores)))),
            "error": Column(scores, result.readings.unit),
            "chosen": Column([order == one.choice.order for order in range(len(scores))]),
        },
        of=one.choice.held_out,
    )


def _start_up(result: Result, axis: str, one: OfSensor) -> Curve:
    start, unit = one.start_up, result.readings.unit
    found = start.found
    fitted = np.zeros(len(start.time))
    if found is not None:
        fitted = found.change * np.exp(-start.time / found.time_constant)
    number = np.unique(start.run, return_inverse=True)[1]
    level = np.bincount(number, start.residual - fitted) / np.bincount(number)
    return Curve(
        "start_up",
        axis,
        {
            "time": Column(start.time, "s"),
            "residual": Column(start.residual - level[number], unit),
            "fitted": Column(fitted, unit),
            "run": Column([result.readings.labels[run] for run in start.run]),
            "used": Column([bool(t >= start.cut) for t in start.time]),
        },
    )


def _references(axis: str, one: OfSensor) -> Iterator[Curve]:
    for name, law in one.references.items():
        cells = law.cells
        yield Curve(
            "reference_voltage",
            axis,
            {
                "temperature": Column(cells.temperature, "degC"),
                "voltage": Column(cells.reading, "V"),
                "fitted": Column(_fitted(law), "V"),
            },
            of=name,
        )
