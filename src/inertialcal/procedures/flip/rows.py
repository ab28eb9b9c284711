"""Rows of a flip's result: every quantity with its uncertainty, or the reason why there is none.

Where a ground model's prediction is given, ``predicted_bias`` with ``bias_shift`` or ``corrected_bias`` (``orbit``).

Conditions: none for the result, all flips pooled; ``"flip 1"`` for each of several; ``"median"`` and ``"low_pass"`` for
other statistics of the same windows; ``"as_published"`` for the document's own way (with several flips, of each:
``"as_published, flip 1"``).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.key import Key, Member, Method, Reason
from ...core.results import Row, not_estimated
from ...statistics.intervals import t_interval
from .plan import Plan
from .published import published_rows
from .separation.equations import AMBIENT, BIAS, CONTROL, READING
from .separation.orbit import CORRECTED, PREDICTED, SHIFT, Against, against_model
from .separation.pooling import Flip, units
from .separation.standards import missing

if TYPE_CHECKING:
    from .reduction import Result

MODEL_BIAS = "model_bias_error"  # what a ground model leaves of the bias
ALONG = Reason("along_turn", "not turned: bias and ambient acceleration along the turn are one (see reading)")
NO_STATISTIC = Reason("no_statistic", "its own uncertainty is not worked out: see that of the mean")
DOUBTED = Reason(
    "magnitude", "readings of a size that orbit and head cannot have (remark `magnitude`): their unit is in doubt"
)
PREDICTION = "of the ground model, taken as it is: the readings do not say how well it is known"


def rows(result: Result) -> list[Row]:
    """Return all rows, SI."""
    found = _of_flip(result, result.whole)
    several = len(result.flips) > 1
    for one in result.flips if several else ():
        found += _of_flip(result, one, member=Member("flip", one.label))
    found += _against_model(result)
    for name, other in result.others.items():
        found += _of_flip(result, other, Method(name))
    for name, why in result.readings.reasons.items():
        if name not in result.others:
            found += [not_estimated(key, "m/s^2", Reason("no_window", why), Method(name)) for key in _wanted(result)]
    for one in result.flips:
        own = published_rows(result.plan, result.readings, one.label, _called(result.plan, BIAS))
        found += [replace(row, member=Member("flip", one.label)) for row in own] if several else own
    doubted = any(remark.code == "magnitude" for remark in result.remarks)
    return [_doubted(row) for row in found] if doubted else found


def _doubted(row: Row) -> Row:
    """Return the row without its uncertainty: in a wrong unit it is wrong, too."""
    if row.status == "not_estimated":
        return row
    return replace(row, u=None, dof=None, interval=None, status="not_estimated", reason=DOUBTED)


def _wanted(result: Result) -> list[Key]:
    """Quantities that a flip should give of each axis that was read."""
    found = []
    for axis in result.readings.axes:
        first = CONTROL if axis == result.plan.axis else AMBIENT
        found += [Key(first, axis), Key(_called(result.plan, BIAS), axis)]
    return found


def _called(plan: Plan, quantity: str) -> str:
    return MODEL_BIAS if plan.corrected and quantity == BIAS else quantity


def _of_flip(result: Result, one: Flip, method: Method = Method.RESULT, member: Member | None = None) -> list[Row]:
    found = [_row(result, one, i, method, member) for i in range(len(one.keys))]
    reasons = dict(one.reasons)
    if result.plan.axis in result.readings.axes:
        reasons[Key(BIAS, result.plan.axis)] = ALONG
    for key, why in reasons.items():
        own = key._replace(quantity=_called(result.plan, key.quantity))
        found.append(not_estimated(own, units([key])[0], why, method, member))
    return found


def _against_model(result: Result) -> list[Row]:
    """Return what a ground model predicts, and how far the flip is off it, or what both make together."""
    found = []
    for one in against_model(result.plan, result.readings, result.flips):
        member = Member("flip", one.label) if one.label else None
        told = "; ".join(part for part in (PREDICTION, _some(result, one)) if part)
        found.append(Row(Key(PREDICTED, one.axis), one.predicted, None, "m/s^2", status="not_estimated",
                         reason=Reason("taken_as_is", told), member=member))  # fmt: skip
        if one.quantity:
            row = _row(result, one.flip, one.flip.keys.index(one.key), member=member, called=one.quantity)
            told = "; ".join(part for part in (row.reason.text, _some(result, one)) if part)
            found.append(replace(row, reason=Reason(row.reason.code, told)))
        elif not one.label:
            key = Key(CORRECTED if result.plan.corrected else SHIFT, one.axis)
            found.append(not_estimated(key, "m/s^2", ALONG))
    return found


def _some(result: Result, one: Against) -> str:
    """Name the flips that have a prediction, where not all of them have."""
    some = not one.label and len(one.flips) < len(result.flips)
    return f"of flip {', '.join(one.flips)} alone: no prediction for the others" if some else ""


def _row(
    result: Result, one: Flip, at: int, method: Method = Method.RESULT, member: Member | None = None, called: str = ""
) -> Row:
    key, unit = one.keys[at], units([one.keys[at]])[0]
    key = key._replace(quantity=called or _called(result.plan, key.quantity))
    value = float(one.values[at])
    if one.estimate is None:
        reason = one.reason if method is Method.RESULT else NO_STATISTIC
        return Row(key, value, None, unit, status="not_estimated", reason=reason, method=method, member=member)
    u, dof = float(one.estimate.u[at]), float(one.estimate.dof[at])
    return Row(
        key, value, u, unit, dof if np.isfinite(dof) else None, t_interval(value, u, dof),
        reason=_limits(result, one.keys[at]), method=method, member=member,
    )  # fmt: skip


def _limits(result: Result, key: Key) -> Reason:
    parts = ["bias and ambient acceleration together"] if key.quantity == READING else []
    parts += ["relative to the fixture"] if missing(result.plan) else []
    return Reason("limits", "; ".join(parts))


__all__ = ["MODEL_BIAS", "rows"]
