"""Rows of a mass-attraction calibration: the scale factor, what it is compared with, and each run by itself."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...core.key import NO_REASON, Key, Member, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...statistics.intervals import t_interval
from .published import published_rows
from .response.of_run import Response
from .response.scale import SCALE, UNIT, estimate_of

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
        yield not_estimated(Key(SCALE, axis), UNIT, Reason("not_told", result.reason))
    else:
        for key, value, u, unit, dof in zip(
            result.estimate.keys, result.estimate.values, result.estimate.u, result.estimate.units,
            result.estimate.dof, strict=True,
        ):  # fmt: skip
            said = Reason("limits", result.says.get(key.quantity, ""))
            yield _row(key, float(value), float(u), unit, float(dof), said)
    yield from _other_scatter(result)
    yield from published_rows(result)
    for one in result.responses:
        yield from _of_run(result, one)


def _row(
    key: Key, value: float, u: float, unit: str, dof: float, reason: Reason = NO_REASON,
    method: Method = Method.RESULT, member: Member | None = None,
) -> Row:  # fmt: skip
    shown = dof if math.isfinite(dof) else None
    return Row(key, value, u, unit, shown, t_interval(value, u, dof), reason=reason, method=method, member=member)


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
    yield _row(Key(SCALE, result.plan.axis), value, u, UNIT, dof, Reason("limits", reason), Method(other))


def _of_run(result: Result, one: Response) -> Iterator[Row]:
    axis, alone = result.plan.axis, Member("run", one.name)
    noise = Reason("limits", "its own noise alone: what is applied is uncertain besides")
    if not one.moved:
        if result.per_applied:
            size = result.per_applied
            still = Reason("zero_expected", "the mass was not moved: zero is expected")
            key = Key("null_response", axis)
            yield _row(key, one.amplitude / size, one.u / size, "m/s^2", one.dof, still, member=alone)
    elif one.found(result.plan.floor):
        yield _row(Key("response_amplitude", axis), one.amplitude, one.u, "count/s", one.dof, member=alone)
        yield _row(Key(SCALE, axis), one.scale_factor, one.u_scale_factor, UNIT, one.dof, noise, member=alone)
    else:
        limit = t_interval(abs(one.amplitude), one.u, one.dof, 0.9).hi
        below = f"below {result.plan.floor:g} times the noise floor of {one.u:.3g} count/s: not told from noise"
        reason = Reason("not_told", below)
        yield Row(Key("response_amplitude", axis), limit, None, "count/s", None, Interval(0.0, limit), "upper_limit",
                  reason, member=alone)  # fmt: skip
        yield not_estimated(Key(SCALE, axis), UNIT, reason, member=alone)
    if math.isfinite(one.u_quadrature):
        ahead = Reason("zero_expected", "a quarter of a cycle ahead of the drive: zero is expected")
        key = Key("quadrature_amplitude", axis)
        yield _row(key, one.quadrature, one.u_quadrature, "count/s", one.dof, ahead, member=alone)
    if math.isfinite(one.tilt):
        told = Reason("limits", "of the pad in phase with the drive, mercury taken off")
        yield _row(Key("tilt_amplitude", axis), one.tilt, one.u_tilt, "rad", one.dof, told, member=alone)
