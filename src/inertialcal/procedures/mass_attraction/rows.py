"""Rows of a mass-attraction calibration: the scale factor, what it is compared with, and each run by itself."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...core.results import Interval, Row, not_estimated
from ...statistics.intervals import t_interval
from .published import published_rows
from .response import Response
from .scale import SCALE, UNIT, estimate_of

if TYPE_CHECKING:
    from .reduction import Result


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI.

    Parameters
    ----------
    result : Result
        Of the test.
    """
    axis = result.plan.axis
    if result.estimate is None:
        yield not_estimated(SCALE, axis, UNIT, result.reason)
    else:
        for name, value, u, unit, dof in zip(
            result.estimate.names, result.estimate.values, result.estimate.u, result.estimate.units,
            result.estimate.dof, strict=True,
        ):  # fmt: skip
            quantity = name.rpartition("_")[0]
            yield _row(quantity, axis, float(value), float(u), unit, float(dof), reason=result.says.get(quantity, ""))
    yield from _other_scatter(result)
    yield from published_rows(result)
    for one in result.responses:
        yield from _of_run(result, one)


def _row(
    quantity: str, axis: str, value: float, u: float, unit: str, dof: float, condition: str = "", reason: str = ""
) -> Row:  # fmt: skip
    shown = dof if math.isfinite(dof) else None
    return Row(quantity, axis, value, u, unit, shown, t_interval(value, u, dof), reason=reason, condition=condition)


def _other_scatter(result: Result) -> Iterator[Row]:
    """Yield the scale factor with the uncertainty from the other scatter: within the runs, or between them."""
    if result.estimate is None or result.combined is None or result.combined.between is None:
        return
    other = "within_runs" if result.scatter == "between_runs" else "between_runs"
    found = estimate_of(result.plan, result.readings, result.responses, result.combined, other)
    value, u, dof = (float(one[0]) for one in (found.values, found.u, found.dof))
    reason = {
        "within_runs": "by the noise beside the line of each run: right if nothing differs from run to run",
        "between_runs": "by how the runs differ",
    }[other]
    yield _row(SCALE, result.plan.axis, value, u, UNIT, dof, other, reason)


def _of_run(result: Result, one: Response) -> Iterator[Row]:
    axis, condition = result.plan.axis, f"run {one.name} alone"
    noise = "its own noise alone: what is applied is uncertain besides"
    if not one.moved:
        if result.per_applied:
            size = result.per_applied
            yield _row("null_response", axis, one.amplitude / size, one.u / size, "m/s^2", one.dof, condition,
                       "the mass was not moved: zero is expected")  # fmt: skip
    elif one.found(result.plan.floor):
        yield _row("response_amplitude", axis, one.amplitude, one.u, "count/s", one.dof, condition)
        yield _row(SCALE, axis, one.scale_factor, one.u_scale_factor, UNIT, one.dof, condition, noise)
    else:
        limit = t_interval(abs(one.amplitude), one.u, one.dof, 0.9).hi
        reason = f"below {result.plan.floor:g} times the noise floor of {one.u:.3g} count/s: not told from noise"
        yield Row("response_amplitude", axis, limit, None, "count/s", None, Interval(0.0, limit), "upper_limit", reason,
                  condition=condition)  # fmt: skip
        yield not_estimated(SCALE, axis, UNIT, reason, condition)
    if math.isfinite(one.u_quadrature):
        yield _row("quadrature_amplitude", axis, one.quadrature, one.u_quadrature, "count/s", one.dof, condition,
                   "a quarter of a cycle ahead of the drive: zero is expected")  # fmt: skip
    if math.isfinite(one.tilt):
        yield _row("tilt_amplitude", axis, one.tilt, one.u_tilt, "rad", one.dof, condition,
                   "of the pad in phase with the drive, mercury taken off")  # fmt: skip
