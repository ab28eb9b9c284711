"""Rows of a flip's result: every quantity with its uncertainty, or the reason why there is none.

Rows without method or member are the result, all flips pooled; ``Member("flip", "1")`` marks each of several; methods
``median`` and ``low_pass`` other statistics of the same windows. ``bias_next_record`` is the same bias as that of the
record that comes next: its u holds the slow noise of the head from one to the other. Where a ground model's prediction
is given there are ``predicted_bias`` with ``bias_shift`` or ``corrected_bias`` (``separation.orbit``).

The textbook rows follow TM-106980: half difference and half sum of a flip of two positions half a turn apart [1]_::

    G = (M_0 - M_pi) / 2        B = (M_0 + M_pi) / 2        accuracy: sum of the half widths of both intervals

The report states t-intervals of ten sub-means within a dwell; noise slower than a dwell is not in them, so the accuracy
of a single flip is not an uncertainty of its bias.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, eq. (1)-(7), Tables 3 to 6, 20 to 22; t-intervals in the text.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.key import Key, Member, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...statistics.intervals import t_interval
from .plan import Plan
from .readings import Readings
from .separation.equations import AMBIENT, BIAS, CONTROL, READING, SAME, directions
from .separation.orbit import CORRECTED, PREDICTED, SHIFT, Against, against_model
from .separation.pooling import Flip, units
from .separation.uncertainty import missing
from .terms import temperatures

if TYPE_CHECKING:
    from .reduction import Result

UNIT = "m/s^2"
NEXT = "_next_record"
AS_NEXT = "of the next record, as long as this one"
MODEL_BIAS = "model_bias_error"  # of a ground model
ALONG = Reason("along_turn", "not turned: bias and ambient acceleration along the turn are one (see reading)")
NO_STATISTIC = Reason("no_statistic", "no uncertainty for this statistic: see that of the mean")
DOUBTED = Reason(
    "magnitude", "readings too large or too small for a head in orbit (remark `magnitude`): check the unit"
)
PREDICTION = "prediction of the ground model, without its uncertainty: the readings do not contain it"
TEMPERATURE = "flip_temperature"
OF_DWELLS = Reason("taken_as_is", "mean of the dwells, as the thermometer reads")
ACCURACY = "accuracy"
REASON = Reason("limits", "accuracy as the sum of both half widths, noise taken as white within a dwell")
WIDTH = Reason("width", "the sum of both half widths itself")


def rows(result: Result) -> list[Row]:
    """Return all rows, SI."""
    bias = MODEL_BIAS if result.plan.corrected else BIAS
    found = _of_flip(result, result.whole)
    found += _next_rows(result)
    found += [Row(Key(TEMPERATURE, axis), value, None, "degC", status="not_estimated", reason=OF_DWELLS)
              for axis, value in temperatures(result).items()]  # fmt: skip
    several = len(result.flips) > 1
    for one in result.flips if several else ():
        found += _of_flip(result, one, member=Member("flip", one.label))
    found += _against_model(result)
    for name, other in result.others.items():
        found += _of_flip(result, other, Method(name))
    for name, why in result.readings.reasons.items():
        if name not in result.others:
            for axis in result.readings.axes:
                keys = (Key(CONTROL if axis == result.plan.axis else AMBIENT, axis), Key(bias, axis))
                found += [not_estimated(key, UNIT, Reason("no_window", why), Method(name)) for key in keys]
    for one in result.flips:
        member = Member("flip", one.label) if several else None
        found += [replace(row, member=member) for row in textbook_rows(result.plan, result.readings, one.label, bias)]
    if any(remark.code == "magnitude" for remark in result.remarks):  # in a wrong unit an uncertainty is wrong, too
        doubted = {"u": None, "dof": None, "interval": None, "status": "not_estimated", "reason": DOUBTED}
        found = [row if row.status == "not_estimated" else replace(row, **doubted) for row in found]  # type: ignore[arg-type]
    return found


def _of_flip(result: Result, one: Flip, method: Method = Method.RESULT, member: Member | None = None) -> list[Row]:
    found = [_row(result, one, i, method, member) for i in range(len(one.keys))]
    reasons = dict(one.reasons)
    if result.plan.axis in result.readings.axes:
        reasons[Key(BIAS, result.plan.axis)] = ALONG
    for key, why in reasons.items():
        own = key._replace(quantity=_called(result.plan, key.quantity))
        found.append(not_estimated(own, units([key])[0], why, method, member))
    return found


def _next_rows(result: Result) -> list[Row]:
    """Return each bias as that of the record that comes next."""
    found = []
    for key, (u, dof) in result.whole.next_record.items():
        value = float(result.whole.values[result.whole.keys.index(key)])
        own = key._replace(quantity=f"{_called(result.plan, key.quantity)}{NEXT}")
        interval = t_interval(value, u, dof)
        reason = Reason("limits", "; ".join([AS_NEXT, *_relative(result)]))
        found.append(Row(own, value, u, UNIT, dof if np.isfinite(dof) else None, interval, reason=reason))
    return found


def _relative(result: Result) -> list[str]:
    return ["relative to the fixture"] if missing(result.plan) else []


def _called(plan: Plan, quantity: str) -> str:
    return MODEL_BIAS if plan.corrected and quantity == BIAS else quantity


def _against_model(result: Result) -> list[Row]:
    """Return the prediction of a ground model, and the shift from it or the bias corrected by it."""

    def text(own: str, one: Against) -> str:  # with the flips that have a prediction, where not all of them have
        some = not one.label and len(one.flips) < len(result.flips)
        parts = (own, f"of flip {', '.join(one.flips)} alone: no prediction for the others" if some else "")
        return "; ".join(part for part in parts if part)

    found = []
    for one in against_model(result.plan, result.readings, result.flips):
        member = Member("flip", one.label) if one.label else None
        reason = Reason("taken_as_is", text(PREDICTION, one))
        found.append(Row(Key(PREDICTED, one.axis), one.predicted, None, UNIT, status="not_estimated",
                         reason=reason, member=member))  # fmt: skip
        if one.quantity:
            row = _row(result, one.flip, one.flip.keys.index(one.key), member=member, called=one.quantity)
            shared = {} if one.flip.estimate is None else one.flip.estimate.shared(one.key)
            found.append(replace(row, reason=Reason(row.reason.code, text(row.reason.text, one)), shared=shared))
        elif not one.label:
            key = Key(CORRECTED if result.plan.corrected else SHIFT, one.axis)
            found.append(not_estimated(key, UNIT, ALONG))
    return found


def _row(
    result: Result, one: Flip, at: int, method: Method = Method.RESULT, member: Member | None = None, called: str = ""
) -> Row:
    own, unit = one.keys[at], units([one.keys[at]])[0]
    key = own._replace(quantity=called or _called(result.plan, own.quantity))
    value = float(one.values[at])
    if one.estimate is None:
        reason = one.reason if method is Method.RESULT else NO_STATISTIC
        return Row(key, value, None, unit, status="not_estimated", reason=reason, method=method, member=member)
    u, dof = float(one.estimate.u[at]), float(one.estimate.dof[at])
    limits = ["bias and ambient acceleration together"] if own.quantity == READING else []
    limits += ["mean over the quiet record"] if own.quantity == BIAS and result.readings.quiet else []
    limits += _relative(result)
    return Row(
        key, value, u, unit, dof if np.isfinite(dof) else None, t_interval(value, u, dof),
        reason=Reason("limits", "; ".join(limits)), method=method, member=member,
    )  # fmt: skip


def textbook_rows(plan: Plan, readings: Readings, flip: str, bias: str) -> Iterator[Row]:
    """Yield half difference, half sum (called ``bias``) and accuracy of each axis of a flip of two positions.

    Only for positions half a turn apart whose half widths are given.
    """
    for axis in readings.axes:
        own = np.flatnonzero((readings.flip == flip) & np.isfinite(readings.outputs[axis]))
        angle = readings.angle[own]
        if len(own) != 2 or abs(float(np.ptp(angle)) - np.pi) >= SAME or directions(angle).shape[1] != 1:
            continue
        pair = own if np.cos(angle[0]) > 0.0 else own[::-1]
        m_0, m_pi = (float(readings.outputs[axis][k]) for k in pair)
        difference = CONTROL if axis == plan.axis else AMBIENT
        values = {difference: 0.5 * (m_0 - m_pi), bias: 0.5 * (m_0 + m_pi)}
        for one in readings.half_widths:
            half = float(one.values[axis][pair].sum())
            if not np.isfinite(half):
                continue
            for quantity, value in values.items():
                interval = Interval(value - half, value + half, one.p)
                yield Row(Key(quantity, axis), value, None, UNIT, interval=interval, reason=REASON,
                          method=Method.TEXTBOOK)  # fmt: skip
            values = {}
            key = Key(f"{ACCURACY}_{100.0 * one.p:g}", axis)
            yield Row(key, half, None, UNIT, status="not_estimated", reason=WIDTH, method=Method.TEXTBOOK)
