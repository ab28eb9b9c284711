"""The reduction of TM-106980, as published: half difference and half sum, accuracy the sum of two half widths.

Each position's mean has a t-interval from ten means of 6 s; the half widths of both positions are added and taken as
the accuracy of all results of the flip. It takes the noise as white within a dwell and says nothing of what wanders
between dwells: the control axis of Table 5 is out by three times the accuracy. It stands beside the default with
``Method.TEXTBOOK``. The axis along the turn has its half sum as bias, its ambient acceleration included.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, eq. (1)-(7), Tables 3 to 6, 20 to 22; t-intervals in the text.
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...core.key import Key, Method, Reason
from ...core.results import Interval, Row
from .plan import Plan
from .readings import Readings
from .separation.positions import SAME, directions

ACCURACY = "accuracy"
REASON = Reason("limits", "accuracy as the sum of both half widths, noise taken as white within a dwell")
WIDTH = Reason("width", "the sum of both half widths itself")


def published_rows(plan: Plan, readings: Readings, flip: str, bias: str) -> list[Row]:
    """Return half difference, half sum and accuracy of each axis of a flip of two positions half a turn apart.

    Parameters
    ----------
    plan, readings : Plan, Readings
        As given; no rows where no half widths are.
    flip : str
        Which.
    bias : str
        What the half sum is called.
    """
    found: list[Row] = []
    for axis in readings.axes:
        own = np.flatnonzero((readings.flip == flip) & np.isfinite(readings.outputs[axis]))
        if _is_half_turn(readings.angle[own]):
            first, second = own if np.cos(readings.angle[own[0]]) > 0.0 else own[::-1]
            found += _of_axis(plan, readings, axis, (int(first), int(second)), bias)
    return found


def _is_half_turn(angle: Array) -> bool:
    return len(angle) == 2 and abs(float(np.ptp(angle)) - np.pi) < SAME and directions(angle).shape[1] == 1


def _of_axis(plan: Plan, readings: Readings, axis: str, pair: tuple[int, int], bias: str) -> list[Row]:
    m_0, m_pi = (float(readings.outputs[axis][k]) for k in pair)
    difference = "control_error" if axis == plan.axis else "ambient_acceleration"
    values = {difference: 0.5 * (m_0 - m_pi), bias: 0.5 * (m_0 + m_pi)}
    found: list[Row] = []
    for one in readings.half_widths:
        half = float(one.values[axis][list(pair)].sum())
        if not np.isfinite(half):
            continue
        key = Key(f"{ACCURACY}_{100.0 * one.p:g}", axis)
        width = Row(key, half, None, "m/s^2", status="not_estimated", reason=WIDTH, method=Method.TEXTBOOK)
        if not found:
            found = [_row(Key(quantity, axis), value, half, one.p) for quantity, value in values.items()]
        found.append(width)
    return found


def _row(key: Key, value: float, half: float, p: float) -> Row:
    interval = Interval(value - half, value + half, p)
    return Row(key, value, None, "m/s^2", interval=interval, reason=REASON, method=Method.TEXTBOOK)
