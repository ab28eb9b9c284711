"""What ``results.json`` says of models: rows of their parameters, and the closed loop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ...core.key import NO_REASON, Reason
from ...core.remarks import Remark
from ...core.results import Row, finite, not_estimated
from ...core.units import factor, kind
from ...procedures import procedure_of
from ...statistics.closed_loop import AxisLoop
from ...statistics.intervals import t_intervals
from ..file.load import Campaign
from .judged import NOT_RUN, JudgedModel, Modelled, ResidualLoop


def named_models(campaign: Campaign, modelled: Modelled | None) -> dict[str, tuple[str, JudgedModel]]:
    """Return unit and model of each sensor and condition that has one, by what its rows are named."""
    every = () if modelled is None else modelled.every
    return {one.name: (campaign.file.sensors[one.sensor].unit, one) for one in every if one.model is not None}


def parameter_rows(modelled: JudgedModel) -> list[Row]:
    """Return rows of the parameters of a model, what goes into model.json: first those of its estimate, in order."""
    if modelled.model is None:
        return []
    estimate = modelled.model.estimate
    rows: list[Row] = []
    if estimate is not None:
        numbers = estimate.values.tolist(), estimate.u.tolist(), estimate.dof.tolist()
        ends = t_intervals(estimate.values, estimate.u, estimate.dof)
        rows = [
            Row.of_own(key, value, u, unit, None if dof == math.inf else dof, each, NO_REASON)
            for key, unit, value, u, dof, each in zip(estimate.keys, estimate.units, *numbers, ends, strict=True)
        ]
    reasons = modelled.model.not_estimated
    return rows + [
        not_estimated(one.key, one.unit, Reason("not_estimated", reasons[one.name]))
        for one in modelled.model.parameters
        if one.name in reasons
    ]


def closed_loop_content(
    campaign: Campaign, modelled: Modelled | None, unit: str, errors: Sequence[Remark]
) -> dict[str, Any]:
    """Return what the closed loop gave, in the unit of the sensor; errors are those for which no model is made."""
    if modelled is None or not modelled.is_judged:
        reason = _not_run(campaign, modelled, errors)
        return {"verdict": NOT_RUN, "reason": reason, "axes": [], "over_temperature": []}
    return {
        "verdict": modelled.whole_verdict,
        "reason": "",
        "axes": [_loop_row(campaign, one.condition, loop, unit) for one in modelled.every for loop in one.loops],
        "over_temperature": [
            *(residual_row(one.condition, each, unit) for one in modelled.every for each in one.residuals),
            *(residual_row("", each, unit) for each in modelled.residuals),
        ],
    }


def _not_run(campaign: Campaign, modelled: Modelled | None, errors: Sequence[Remark]) -> str:
    """Say why there is no closed loop."""
    if modelled is None and errors:
        return f"no model: {errors[0].what}"
    if modelled is not None:
        return "no test is held out"
    procedures = [procedure_of(name) for name in dict.fromkeys(test.procedure for test in campaign.file.tests)]
    if any(one.makes_model for one in procedures):
        return "no model: no test for a fit gives a term of it"
    return (
        f"no model is made of a {' or a '.join(one.kind_of_test or one.name.replace('_', ' ') for one in procedures)}"
    )


def _loop_row(campaign: Campaign, condition: str, one: AxisLoop, unit: str) -> dict[str, Any]:
    shown = _loop_unit(campaign, one.unit, unit)
    scale = factor(one.unit, shown)
    return {
        "condition": condition, "axis": one.axis, "dwells": one.dwells, "runs": one.runs, "unit": shown,
        "raw_rms": one.raw * scale, "compensated_rms": one.compensated * scale,
        "mean_square_gain": one.gain * scale**2, "u": finite(one.u * scale**2), "dof": finite(one.dof),
        "allowed": one.allowed * scale**2, "verdict": one.verdict, "reason": one.reason,
    }  # fmt: skip


def _loop_unit(campaign: Campaign, own: str, unit: str) -> str:
    """Return the unit that a closed loop is told in: that of its sensor, degrees for angles."""
    if own == "rad":
        return "deg"
    units = [sensor.unit for sensor in campaign.file.sensors.values() if kind(sensor.unit) == kind(own)]
    return unit if kind(unit) == kind(own) else units[0]


def residual_row(condition: str, one: ResidualLoop, unit: str) -> dict[str, Any]:
    """Return a row of ``closed_loop.over_temperature``, in the unit of the sensor."""
    loop, scale = one.loop, factor(one.loop.unit, unit)
    return {
        "condition": condition, "test": one.test, "against": one.against, "axis": loop.axis, "cells": loop.dwells,
        "runs": loop.runs,
        "unit": unit, "raw_rms": loop.raw * scale, "compensated_rms": loop.compensated * scale,
        "verdict": loop.verdict, "reason": loop.reason,
    }  # fmt: skip
