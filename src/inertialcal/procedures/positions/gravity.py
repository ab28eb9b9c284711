"""Gravity where a test of positions was made, and numbers by axis."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.axes import AXES
from ...core.constants import STANDARD_GRAVITY
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
