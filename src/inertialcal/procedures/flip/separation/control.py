"""Checks that the flip makes on itself: the control axis, the angle, the axis, and the size of what was found.

The axis along the turn keeps its reading; what it reads of the turn is tested against zero at 5 % with its own
uncertainty (Holm's rule over several flips). The turned axes, where there are more dwells than unknowns, must follow
cosine and sine of the stated angles: what is left against the record's noise, at 1 %, by an F-test that knows how well
that noise is known [1]_. Half turns of two positions leave nothing, and a turn by another angle than stated does not
show in them.

A control axis that moves clearly (0.1 %) while a turned one does not (5 %) says that another axis was turned about.

References
----------
.. [1] A. H.-T. Fai and P. L. Cornelius, J. Stat. Comput. Simul. 54 (1996) 363: several contrasts whose variances have
   different degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import special

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import Key
from ....core.remarks import Remark
from ....core.units import factor
from ....statistics.decision import holm
from ..plan import Plan
from ..readings import Readings
from .equations import AMBIENT, BIAS, CONTROL, QUADRATURE, READING, missing_position
from .pooling import Flip
from .uncertainty import independent, record_of

RISK, FIT_RISK, CLEAR = 0.05, 0.01, 0.001
LARGEST = 1e9  # degrees of freedom, as good as infinite
LEAST = 1e-8  # standard gravities: no head has a bias so small; ug were read as something smaller


def checks(plan: Plan, readings: Readings, flips: Sequence[Flip], whole: Flip) -> list[Remark]:
    """Return all that the checks bring up."""
    return [
        *control_axis(plan, flips, whole),
        *_other_axis(plan, flips),
        *_angles(plan, readings, flips),
        *_positions(flips),
        *_magnitude(plan, whole),
    ]


def control_axis(plan: Plan, flips: Sequence[Flip], whole: Flip) -> list[Remark]:
    """Return the remark on each flip whose control axis is not zero; on all pooled where single ones cannot tell."""
    judged = [(one, p) for one in flips if (p := not_zero(plan, one)) is not None]
    if not judged:
        p = not_zero(plan, whole)
        judged = [] if p is None else [(whole, p)]
    if not judged:
        return []
    found = []
    for (one, p), rejected in zip(judged, holm([p for _, p in judged], RISK), strict=True):
        if rejected:
            place = f"flip {one.label}" if one.label and len(flips) > 1 else ""
            what = f"{plan.axis} does not turn, but {_told(one, Key(CONTROL, plan.axis))}: zero has p = {p:.2g}"
            do = "Look for a disturbance, a drift, or another axis or angle; its size is the error of this test"
            found.append(Remark("control_axis_not_zero", "warning", what, place, do=do, axis=plan.axis))
    return found


def not_zero(plan: Plan, one: Flip) -> float | None:
    """Return the probability that the control axis is as far from zero, or farther, where it is zero.

    None where it has no uncertainty.
    """
    keys = [key for key in one.keys if key.quantity in (CONTROL, QUADRATURE)]
    if one.estimate is None or not keys:
        return None
    own = one.estimate.select(keys)
    if not np.all(own.u > 0.0):
        return None
    square = float(own.values @ np.linalg.solve(own.covariance, own.values))
    dof = min(float(np.min(own.dof)), 1e9)
    return float(special.fdtrc(len(keys), dof, square / len(keys)))


def _p(one: Flip, key: Key) -> float | None:
    if one.estimate is None or key not in one.keys:
        return None
    own = one.estimate.select([key])
    dof, t = float(own.dof[0]), float(own.values[0]) / float(own.u[0]) if own.u[0] > 0.0 else np.inf
    return 2.0 * float(special.stdtr(min(dof, 1e9), -abs(t)))


def _told(one: Flip, key: Key) -> str:
    """Return a value with its uncertainty in words [ug]."""
    scale = factor("m/s^2", "ug")
    value = one.values[one.keys.index(key)] * scale
    u = "" if one.estimate is None else f" (u = {one.estimate.select([key]).u[0] * scale:.3g} ug)"
    return f"reads {value:+.4g} ug of the turn{u}"


def _other_axis(plan: Plan, flips: Sequence[Flip]) -> list[Remark]:
    found = []
    for one in flips:
        moved = not_zero(plan, one)
        still = [axis for axis in plan.turned if (p := _p(one, Key(AMBIENT, axis))) is not None and p > RISK]
        if moved is not None and moved < CLEAR and still:
            what = f"{plan.axis} {_told(one, Key(CONTROL, plan.axis))} while {' and '.join(still)} kept the reading"
            do = f"The head may have been turned about {' or '.join(still)}: check plan.axis, columns and mounting"
            found.append(Remark("turned_about_other_axis", "warning", what, f"flip {one.label}", do=do))
    return found


def _angles(plan: Plan, readings: Readings, flips: Sequence[Flip]) -> list[Remark]:
    found = []
    for one in flips:
        told = _left(plan, readings, one)
        if told is not None and told[2] < FIT_RISK:
            ratio, free, p = told
            what = f"{free} combinations that should be zero have F = {ratio:.3g} (p = {p:.2g})"
            what = f"{' and '.join(plan.turned)} do not follow the stated angles: {what}"
            do = "Check the positions and the sign of each axis; or fit a drift (plan.drift)"
            found.append(Remark("not_turned_by_angle", "warning", what, f"flip {one.label}", do=do))
    return found


def _left(plan: Plan, readings: Readings, one: Flip) -> tuple[float, int, float] | None:
    """F of what the turned axes leave, how much is left, and its probability; None where nothing is."""
    lines = one.separated[0].checks
    free = len(next(iter(lines.values()))) if lines else 0
    record = record_of(readings, lines) if free else None
    if record is None:
        return None
    rest = sum(w @ np.nan_to_num(readings.outputs[axis]) for axis, w in lines.items())
    try:
        ways, variance, dof = independent(plan, record, lines)
    except DataError:
        return None
    if not np.all(variance > 0.0):  # a record without noise of its own
        return None
    ratio = float(np.mean((ways @ rest) ** 2 / variance))
    return ratio, free, float(special.fdtrc(free, _denominator(dof), ratio))


def _denominator(dof: Array) -> float:
    """Return the degrees of freedom of a mean of squared t, each with its own: those of the F that has its mean."""
    if not np.all(dof > 2.0):
        return 2.0
    excess = float(np.sum(2.0 / (dof - 2.0)))  # of the sum of their means, over their number
    return min(2.0 * (len(dof) + excess) / excess, LARGEST) if excess > 0.0 else LARGEST


def _positions(flips: Sequence[Flip]) -> list[Remark]:
    found = []
    for one in flips:
        lost = {key.axis: one.reasons[key] for key in one.reasons if one.reasons[key].code == "missing_position"}
        if lost:
            places = [one.separated[0].single[axis] for axis in sorted(lost)]
            what = missing_position(places[0], *sorted(lost))
            if len(set(places)) > 1:
                what = "; ".join(
                    missing_position(place, axis) for place, axis in zip(places, sorted(lost), strict=True)
                )
            do = "A single-sided flip gives bias and ambient acceleration together: read the other position"
            found.append(Remark("missing_position", "warning", what, f"flip {one.label}", do=do))
    return found


def _magnitude(plan: Plan, whole: Flip) -> list[Remark]:
    """Say what is too large, or too small, for orbit and this kind of head: g read as ug, or the other way round."""
    found = []
    limits = {AMBIENT: plan.largest_ambient, BIAS: plan.largest_bias, READING: plan.largest_bias}
    do = "Check the unit of the readings (g, mg, ug), the gain and the positions"
    scale = factor("m/s^2", "ug")
    for key, value in zip(whole.keys, whole.values, strict=True):
        limit = limits.get(key.quantity)
        if limit is not None and abs(value) > limit:
            what = f"{key} is {value * scale:.4g} ug, beyond the {limit * scale:.6g} ug that the plan has as largest"
            found.append(Remark("magnitude", "error", what, do=do, axis=key.axis))
    levels = [abs(v) for key, v in zip(whole.keys, whole.values, strict=True) if key.quantity in limits]
    if levels and max(levels) < LEAST * factor("g", "m/s^2"):
        what = f"all readings are below {max(levels) * scale:.2g} ug, less than the bias of any head"
        found.append(Remark("magnitude", "warning", what, do=do))
    return found
