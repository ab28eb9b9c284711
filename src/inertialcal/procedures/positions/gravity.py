"""Gravity where a test of positions was made, and numbers by axis."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...core.axes import AXES
from ...core.constants import STANDARD_GRAVITY
from ...core.errors import Problem
from ...core.estimate import Array
from ...physics.earth import normal_gravity
from .plan import Plan


def local_gravity(plan: Plan) -> float:
    """Return the gravity that the plan gives, or that of its place, or the standard value [m/s^2]."""
    if plan.gravity is not None:
        return plan.gravity
    if plan.latitude is not None:
        return float(normal_gravity(plan.latitude, plan.height))
    return float(STANDARD_GRAVITY.value)


def by_axis(numbers: Mapping[str, float] | None, absent: float) -> Array:
    """Return one number an axis, shape (3,)."""
    return np.array([(numbers or {}).get(axis, absent) for axis in AXES], dtype=np.float64)


def site_problems(plan: Plan) -> list[Problem]:
    """Return what cannot be meant of gravity, latitude and the shortest rest.

    Parameters
    ----------
    plan : Plan
        With what the site says.
    """
    found = []
    if plan.gravity is not None and not 0.0 < plan.gravity < math.inf:
        do = "Give its size, like 9.8123 m/s2: the orientation carries the sign"
        found.append(Problem(f"gravity of {plan.gravity:g} m/s2: need more than 0", do=do, code="wrong_value"))
    if plan.latitude is not None and not abs(plan.latitude) <= 0.5 * math.pi:
        what = f"latitude of {math.degrees(plan.latitude):g} deg: need -90 to 90 deg"
        found.append(Problem(what, do="North is positive", code="wrong_value"))
    if plan.shortest is not None and not plan.shortest > 0.0:
        what = f"shortest rest of {plan.shortest:g} s: need more than 0"
        found.append(Problem(what, do="Leave it out: the noise then decides", code="wrong_value"))
    return found


def turn_problems(turn: float) -> list[Problem]:
    """Return what cannot be meant of a turn [rad]."""
    if turn != 0.0 and math.isfinite(turn):
        return []
    what = f"a turn by {math.degrees(turn):g} deg"
    return [Problem(what, "", "nothing was turned", "Give the angle of each turn, like 360 deg", "wrong_value")]
