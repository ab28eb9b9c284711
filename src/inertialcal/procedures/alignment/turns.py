"""By how much the heading grew from position to position: as stated, as the gyros measured it, and whether both agree.

Refused is what contradicts itself: another angle, another sense, a turn that is not about the vertical, gyros that turn
about another axis than the one along which gravity stays.
"""

from __future__ import annotations

import math

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import items, number
from ...core.units import parse_quantity
from .plan import Plan
from .readings import Readings
from .solving import FLIP, Inputs, levelled

DIFFERS = math.radians(5.0)  # a measured turn from the stated one
TILTED = math.radians(3.0)  # of a turn that is said to be about the vertical: by which the direction of gravity moves
LEAST = math.radians(10.0)  # turn by which positions differ
POWERS = (1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9)  # of a clock in another unit


def per_hour(rate: float) -> str:
    """Return a rate [rad/s] as text."""
    return f"{number(math.degrees(rate) * 3600.0, 3)} deg/h"


def degrees(angle: float) -> str:
    """Return an angle [rad] as text."""
    return f"{number(math.degrees(angle), 4)} deg"


def said_turns(plan: Plan, positions: int) -> Array | None:
    """Return the stated angle of each turn, shape (positions - 1,); None where none is stated [rad].

    Raises
    ------
    UsageError
        ``wrong_value``.
    """
    if plan.turns is None:
        return None
    try:
        each = [parse_quantity(one.strip()).to("rad") for one in plan.turns.split(",")]
    except Exception as error:
        what = f"turns {plan.turns!r}: {error}"
        raise UsageError(what, do='Give angles with a unit, like "180 deg" or "90 deg, 90 deg"',
                         code="wrong_value") from None  # fmt: skip
    if len(each) == 1:
        each *= max(positions - 1, 1)
    if len(each) != positions - 1 and positions > 1:
        what = f"{items(len(each), 'turn')} for {items(positions, 'position')}"
        raise UsageError(what, do="Give one angle for all turns, or one for each", code="wrong_value")
    return np.array(each[: positions - 1])


def turns_of(plan: Plan, readings: Readings, flat: Inputs) -> tuple[Array, bool, list[Remark]]:
    """Return by how much the heading of each position is larger than that of the first, shape (m,) [rad].

    Returns
    -------
    turns : ndarray
        As stated, else as measured.
    measured : bool
        Whether they are those that the gyros measured.
    remarks : list of Remark
        What there is to say of them.

    Raises
    ------
    UsageError, DataError
        ``wrong_value``, ``no_turn``, ``turn_differs``, ``clock_unit``, ``wrong_unit``, ``wrong_sense``,
        ``not_about_vertical``, ``axes_disagree``, ``not_turned``.
    """
    positions = readings.positions
    said, m = said_turns(plan, len(positions)), len(positions)
    if m == 1:
        return np.zeros(1), False, []
    seen = [_measured(flat, readings, at) for at in range(1, m)]
    if said is None and any(one is None for one in seen):
        what = f"{items(m, 'position')} in several recordings, and by how much the unit was turned is not said"
        do = "State how much the heading grew from each to the next, clockwise seen from above"
        raise DataError(what, positions[-1].file, "the bias is told from the heading by the turn", do, "no_turn")
    for at, one in enumerate(seen, 1):
        _check_vertical(readings, at, measured=one is not None)
        if one is not None and said is not None:
            _check_stated(readings, at, float(said[at - 1]), positions[at].angle)
    each = said if said is not None else np.array([one for one in seen if one is not None])
    turns = np.concatenate([[0.0], np.cumsum(each)])
    apart = np.abs(np.remainder(turns[:, None] - turns + math.pi, 2.0 * math.pi) - math.pi)
    if float(apart.max()) < LEAST:
        what = f"the headings of {m} positions differ by {degrees(float(apart.max()))} at most"
        do = "Turn the unit half round about the vertical; or give one position, with the uncertainty of the bias"
        where = positions[-1].file
        raise DataError(what, where, "a turn tells the bias from the rate of the earth", do, "not_turned")
    return turns, said is None, []


def _measured(flat: Inputs, readings: Readings, at: int) -> float | None:
    """Return by how much the heading grew up to a position, as the gyros tell [rad]."""
    turned = readings.positions[at].turned
    if turned is None:
        return None
    from ...physics.attitude import from_roll_pitch_yaw  # noqa: PLC0415 - as in `solving`

    flip = FLIP if flat.up else np.ones(3)
    own = flip[:, None] * turned * flip
    before = from_roll_pitch_yaw(*levelled(flat.acc[at - 1] * flip), 0.0)
    after = from_roll_pitch_yaw(*levelled(flat.acc[at] * flip), 0.0)
    both = before @ own @ after.T  # level axes of the later position in those of the earlier
    return math.atan2(both[1, 0] - both[0, 1], both[0, 0] + both[1, 1])


def _check_vertical(readings: Readings, at: int, measured: bool) -> None:
    """Refuse a turn about another axis than the vertical where it is stated, or gyros whose axes are not gravity's."""
    before, after = readings.positions[at - 1], readings.positions[at]
    one, other = (force / np.linalg.norm(force) for force in (before.mean_acc, after.mean_acc))
    if measured and after.turned is not None:
        carried = after.turned.T @ one
        off = float(np.arccos(np.clip(carried @ other, -1.0, 1.0)))
        if off > TILTED:
            what = f"by the gyros gravity turned by {degrees(off)} from where the accelerometers find it after the turn"
            what += f" to position {at + 1}"
            do = "Check axes and signs of both triads: both must be one right-handed set; and the unit of the rates"
            raise DataError(what, after.file, "both are on one body", do, "axes_disagree")
        return
    moved = float(np.arccos(np.clip(one @ other, -1.0, 1.0)))
    if moved > TILTED:
        what = f"the direction of gravity in the unit moved by {degrees(moved)} on the way to position {at + 1}"
        why = "the turn is not about the vertical, and its angle is not by how much the heading grew"
        do = "Level the table, or record the turn in one recording with both rests"
        raise DataError(what, after.file, why, do, "not_about_vertical")


def _check_stated(readings: Readings, at: int, said: float, seen: float) -> None:
    """Refuse a stated turn that is not the one that the gyros measured."""
    off = math.remainder(seen - said, 2.0 * math.pi)
    whole = abs(seen - said) < DIFFERS or abs(seen) < 4.0 * math.pi
    if abs(off) < DIFFERS and whole:
        return
    ratio = abs(seen / said) if said else 0.0
    what = f"the turn to position {at + 1} is {degrees(seen)} by the gyros, {degrees(said)} as stated"
    code, do = "turn_differs", "Check the stated angle, and the scale factor of the gyros"
    if any(abs(ratio / power - 1.0) < 0.1 for power in POWERS):
        code, do = "clock_unit", "Check the unit of the time column: a rate over time is an angle"
    elif any(abs(ratio / one - 1.0) < 0.1 for one in (180.0 / math.pi, math.pi / 180.0)):
        code, do = "wrong_unit", "Check the unit of the rates: deg/s or rad/s"
    elif abs(math.remainder(seen + said, 2.0 * math.pi)) < DIFFERS:
        code, do = (
            "wrong_sense",
            "The heading grows clockwise seen from above: check the sign of the turn, and of gyros",
        )
    raise DataError(what, readings.positions[at].file, "one of them is wrong", do, code)
