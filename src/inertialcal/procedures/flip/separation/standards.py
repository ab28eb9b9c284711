"""What standards that are not exact do to a flip (Type B): one unknown value each for the whole test.

turn angle
    Every position but 0 is off by the same angle u: a reading there changes by ``dC/dtheta g u``. A half turn so brings
    the other turned axis in: ``G_y`` and ``B_y`` take ``g_z u / 2``.
turn axis
    The axis really turned about is off the one named by two small angles, each with u: the readings change by
    ``([e] C - C [e]) g``. Ambient acceleration along the turn, which no flip tells from bias, is taken as large as
    that found across it.
converter zero
    An offset of the electronics of each axis, u in its bias.
scale factor
    A relative error of each axis: of its readings, and of the bias that was taken off before: ``plan.raw_bias``, or
    where that is 0 what the ground model predicts.

References
----------
.. [1] JCGM 100:2008 (GUM), 4.3 and 5.2.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ....core.axes import AXES
from ....core.estimate import Array, Component
from ....core.key import Key
from ..plan import INFLUENCES, Plan
from ..readings import Readings
from .equations import AMBIENT, Separated
from .positions import SAME, slope, tilted

Patterns = dict[str, Array]  # of each influence, shape (q, p): changes of the values, one standard uncertainty each

NAMES = {
    "turn.angle": "turn angle",
    "turn.axis": "axis of the turn",
    "converter.zero": "zero of the electronics",
    "sensor.scale_factor": "scale factor",
}


def missing(plan: Plan) -> list[str]:
    """Return the influences that have no stated uncertainty."""
    return [name for name in INFLUENCES if name not in plan.standards]


def patterns(plan: Plan, readings: Readings, found: Separated) -> Patterns:
    """Return the changes of the values of a flip that each stated influence makes.

    Returns
    -------
    dict of str to ndarray, shape (q, p)
        q independent unknowns, each one standard uncertainty; SI.
    """
    makers: dict[str, Callable[[Plan, Readings, Separated], Array]] = {
        "turn.angle": _angle, "turn.axis": _axis, "converter.zero": _zero, "sensor.scale_factor": _scale,
    }  # fmt: skip
    stated = {name: plan.standards[name].u for name in makers if name in plan.standards}
    return {name: u * makers[name](plan, readings, found) for name, u in stated.items()}


def components(plan: Plan, parts: Patterns) -> list[Component]:
    """Return the Type B components that patterns make."""
    made = []
    for name, pattern in parts.items():
        one = plan.standards[name]
        covariance = pattern.T @ pattern
        made.append(Component(one.origin(NAMES[name]), "B", covariance, one.dof, one.distribution, one.stated))
    return made


def _angle(plan: Plan, readings: Readings, found: Separated) -> Array:
    across, _ = _ambient(plan, found)
    moved = np.abs(readings.angle) > SAME
    return _changes(found, moved[:, None] * (slope(plan.axis, readings.angle) @ across))[None, :]


def _axis(plan: Plan, readings: Readings, found: Separated) -> Array:
    made = []
    for axis in plan.turned:
        change = tilted(plan.axis, readings.angle, np.eye(3)[AXES.index(axis)])
        made += [_changes(found, change @ one) for one in _ambient(plan, found)]
    return np.array(made)


def _zero(plan: Plan, readings: Readings, found: Separated) -> Array:
    return np.array([weights.sum(axis=1) for weights in found.weights.values()])


def _scale(plan: Plan, readings: Readings, found: Separated) -> Array:
    made = []
    for axis, weights in found.weights.items():
        made.append(weights @ (np.nan_to_num(readings.outputs[axis]) + _taken_off(plan, readings, axis)))
    return np.array(made)


def _taken_off(plan: Plan, readings: Readings, axis: str) -> Array | float:
    """Bias that is no longer in the readings of an axis: as the plan says, else what the model predicted [m/s^2]."""
    if plan.raw_bias != 0.0 or not plan.corrected or axis not in readings.predicted:
        return plan.raw_bias
    return np.nan_to_num(readings.predicted[axis])


def _changes(found: Separated, change: Array) -> Array:
    """Change of the values for changes of the readings, shape (n, 3)."""
    parts = [weights @ change[:, AXES.index(axis)] for axis, weights in found.weights.items()]
    return np.asarray(np.sum(parts, axis=0))


def _ambient(plan: Plan, found: Separated) -> tuple[Array, Array]:
    """Ambient acceleration across the turn as found, and along it of the same size, shape (3,) each [m/s^2]."""
    across, along = np.zeros(3), np.zeros(3)
    for axis in plan.turned:
        across[AXES.index(axis)] = found.value(Key(AMBIENT, axis)) or 0.0
    along[AXES.index(plan.axis)] = math.hypot(*across)
    return across, along
