"""Curves of a sensitivity result: readings against each condition, with the fit; what is left, by power-up."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...statistics.intervals import coverage_factor
from .plan import TEMPERATURE
from .warm_up import warm_up_curves

if TYPE_CHECKING:
    from .fit import SensorFit
    from .reduction import Result

POINTS = 41  # of a line


def curves(result: Result) -> list[Curve]:
    """Return the curves of all sensors, SI."""
    found = []
    for axis, fit in result.sensors.items():
        if fit.own is None:
            continue
        for name in dict.fromkeys(one.condition for one in fit.columns if one.key in fit.keys and not one.scale):
            found += _against(result, fit, axis, name)
        found.append(_residuals(result, fit, axis))
    found += [] if result.warm_up is None else warm_up_curves(result.warm_up)
    return [*found, *([] if result.levels is None else result.levels.curves())]


def _against(result: Result, fit: SensorFit, axis: str, name: str) -> list[Curve]:
    """Return readings less everything but the plain terms of one condition, and these terms with their band."""
    own = fit.own
    assert own is not None  # noqa: S101 - the caller looked
    readings, chosen = result.readings, fit.design.chosen
    plain = [i for i, one in enumerate(fit.columns) if one.condition == name and not one.scale
             and (name == TEMPERATURE or not one.warm)]  # fmt: skip
    if not plain:
        return []  # Its plain terms are stated: only changes of them were fitted
    values = readings.conditions[name][axis][chosen]
    reference, unit = result.references[name], readings.units[name]
    terms = np.column_stack([fit.columns[i].values for i in plain]) @ own.coefficients[[1 + i for i in plain]]
    points = {
        "condition": Column(values, unit),
        "reading": Column(terms + own.local, readings.unit),
        "run": Column(fit.design.runs.tolist()),
    }
    at = np.linspace(values.min(), values.max(), POINTS)
    powers = [max(one.key.power, 1) if (one := fit.columns[i]).key else 1 for i in plain]
    design = np.column_stack([(at - reference) ** j for j in powers])
    index = [1 + i for i in plain]
    covariance = own.covariance[np.ix_(index, index)]
    line = design @ own.coefficients[index]
    half = _factor(own.dof[index]) * np.sqrt(np.einsum("ij,jk,ik->i", design, covariance, design))
    law = {
        "condition": Column(at, unit), "bias": Column(line, readings.unit), "lo": Column(line - half, readings.unit),
        "hi": Column(line + half, readings.unit),
    }  # fmt: skip
    return [Curve("sensitivity_levels", axis, points, of=name), Curve("sensitivity", axis, law, of=name)]


def _factor(dof: Array) -> float:
    return coverage_factor(float(np.min(dof)))


def _residuals(result: Result, fit: SensorFit, axis: str) -> Curve:
    own = fit.own
    assert own is not None  # noqa: S101 - the caller looked
    chosen = fit.design.chosen
    columns = {
        "level": Column(list(range(1, len(own.local) + 1))),
        "time": Column(result.readings.time[chosen], "s"),
        "residual": Column(own.local, result.readings.unit),
        "run": Column(fit.design.runs.tolist()),
    }
    return Curve("sensitivity_residuals", axis, columns)
