"""Checks that the flip makes on itself: control axis, angle, axis of the turn, and size of the results.

The axis along the turn keeps its reading; any part that follows the turn is tested against zero at 1 % (Holm's rule
over several flips), by the white and 1/f noise of its record: a drift or a walk, which its interval allows for, is what
this test is to find. A control axis that fails is an error: no requirement on the flip can PASS.

The turned axes, where there are more dwells than unknowns, must follow cosine and sine of the stated angles: the
residual is tested against the record's noise, at 1 %, by an F-test that allows for how well that noise is known [1]_.
Half turns of two positions leave no residual, and do not show a turn by another angle than stated.

A control axis that moves clearly (0.1 %) while a turned one does not (5 %) says that another axis was turned about.

References
----------
.. [1] A. H.-T. Fai and P. L. Cornelius, J. Stat. Comput. Simul. 54 (1996) 363: several contrasts whose variances have
   different degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import special

from ....core.errors import DataError
from ....core.estimate import Estimate
from ....core.key import Key
from ....core.remarks import Remark
from ....core.show.rounding import uncertainty
from ....core.units import factor
from ....statistics.decision import holm
from ..plan import Plan
from ..readings import Readings
from .equations import AMBIENT, BIAS, CONTROL, QUADRATURE, READING, missing_position
from .pooling import Flip
from .uncertainty import independent, noise_components, record_of

RISK, FIT_RISK, CLEAR = 0.05, 0.01, 0.001
CONTROL_RISK = 0.01
LARGEST = 1e9  # degrees of freedom, as good as infinite
LEAST = 1e-8  # standard gravities: no head has so small a bias; ug were read as something smaller
UG = factor("m/s^2", "ug")


def checks(plan: Plan, readings: Readings, flips: Sequence[Flip], whole: Flip) -> list[Remark]:
    """Return the remarks of all checks."""
    return [
        *control_axis(plan, readings, flips, whole),
        *_other_axis(plan, readings, flips),
        *_angles(plan, readings, flips),
        *_positions(flips),
        *_magnitude(plan, whole),
    ]


def control_axis(plan: Plan, readings: Readings, flips: Sequence[Flip], whole: Flip) -> list[Remark]:
    """Return the remark on each flip whose control axis is not zero; on all pooled where single ones cannot tell."""
    judged = [(one, tested) for one in flips if (tested := _tested(plan, readings, one)) is not None]
    if not judged and (tested := _tested(plan, readings, whole)) is not None:
        judged = [(whole, tested)]
    remarks = []
    chances = [_zero(tested) for _, tested in judged]
    rejections = holm(chances, CONTROL_RISK) if judged else ()
    for (one, tested), p, rejected in zip(judged, chances, rejections, strict=True):
        if rejected:
            place = f"flip {one.label}" if one.label and len(flips) > 1 else ""
            known = f"zero has p = {p:.2g} in white and 1/f noise (u = {uncertainty(tested.u[0] * UG)} ug)"
            do = "Look for a disturbance, a drift (plan.drift), or another axis or angle; no requirement can PASS"
            what = f"{plan.axis} does not turn, but {_control(plan, one)}: {known}"
            remarks.append(Remark("control_axis_not_zero", "error", what, place, do=do, axis=plan.axis))
    return remarks


def _tested(plan: Plan, readings: Readings, one: Flip) -> Estimate | None:
    """Return the control error of a flip in white and 1/f noise; None where it has no uncertainty."""
    keys = [key for key in one.keys if key.quantity in (CONTROL, QUADRATURE)]
    if one.estimate is None or not keys:
        return None
    estimate = one.estimate
    if len(one.separated) == 1:
        noise, reason = noise_components(plan, readings, one.separated[0], without_drift=True)
        others = [part for part in estimate.components if part.kind != "A"]
        estimate = estimate if reason else replace(estimate, components=(*noise, *others))
    own = estimate.select(keys)
    return own if np.all(own.u > 0.0) else None


def _zero(own: Estimate) -> float:
    """Return the p value of zero."""
    square = float(own.values @ np.linalg.solve(own.covariance, own.values))
    count = len(own.values)
    return float(special.fdtrc(count, min(float(np.min(own.dof)), LARGEST), square / count))


def _p(one: Flip, key: Key) -> float | None:
    """Return the p value of zero; None without an uncertainty."""
    if one.estimate is None or key not in one.keys:
        return None
    own = one.estimate.select([key])
    dof, t = float(own.dof[0]), float(own.values[0]) / float(own.u[0]) if own.u[0] > 0.0 else np.inf
    return 2.0 * float(special.stdtr(min(dof, LARGEST), -abs(t)))


def _control(plan: Plan, one: Flip) -> str:
    """Say what the control axis reads of the turn [ug]."""
    return f"reads {one.values[one.keys.index(Key(CONTROL, plan.axis))] * UG:+.4g} ug of the turn"


def _other_axis(plan: Plan, readings: Readings, flips: Sequence[Flip]) -> list[Remark]:
    remarks = []
    for one in flips:
        tested = _tested(plan, readings, one)
        still = [axis for axis in plan.turned if (p := _p(one, Key(AMBIENT, axis))) is not None and p > RISK]
        if tested is not None and _zero(tested) < CLEAR and still:
            what = f"{plan.axis} {_control(plan, one)} while {' and '.join(still)} kept the reading"
            axis = " or ".join(still)
            do = f"The head may have been turned about {axis}: check plan.axis (--axis {axis}), columns and mounting"
            remarks.append(Remark("turned_about_other_axis", "warning", what, f"flip {one.label}", do=do))
    return remarks


def _angles(plan: Plan, readings: Readings, flips: Sequence[Flip]) -> list[Remark]:
    remarks = []
    for one in flips:
        test = _residual_test(plan, readings, one)
        if test is not None and test[2] < FIT_RISK:
            ratio, free, p = test
            what = f"{free} combinations that should be zero have F = {ratio:.3g} (p = {p:.2g})"
            what = f"{' and '.join(plan.turned)} do not follow the stated angles: {what}"
            do = "Check the positions and the sign of each axis; or fit a drift (plan.drift)"
            remarks.append(Remark("not_turned_by_angle", "warning", what, f"flip {one.label}", do=do))
    return remarks


def _residual_test(plan: Plan, readings: Readings, one: Flip) -> tuple[float, int, float] | None:
    """F of the residuals of the turned axes, their number, and the p value; None without residuals or noise."""
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
    if not np.all(variance > 0.0):  # a record without noise
        return None
    ratio = float(np.mean((ways @ rest) ** 2 / variance))
    behind = 2.0  # degrees of freedom of a mean of squared t, each with its own: those of the F that has its mean
    if np.all(dof > 2.0):
        excess = float(np.sum(2.0 / (dof - 2.0)))  # of the sum of their means, over their number
        behind = min(2.0 * (len(dof) + excess) / excess, LARGEST) if excess > 0.0 else LARGEST
    return ratio, free, float(special.fdtrc(free, behind, ratio))


def _positions(flips: Sequence[Flip]) -> list[Remark]:
    remarks = []
    for one in flips:
        lost = sorted({key.axis for key, why in one.reasons.items() if why.code == "missing_position"})
        if lost:
            places = [one.separated[0].single[axis] for axis in lost]
            what = missing_position(places[0], *lost)
            if len(set(places)) > 1:
                what = "; ".join(missing_position(place, axis) for place, axis in zip(places, lost, strict=True))
            do = "A single-sided flip gives bias and ambient acceleration together: read the other position"
            remarks.append(Remark("missing_position", "warning", what, f"flip {one.label}", do=do))
    return remarks


def _magnitude(plan: Plan, whole: Flip) -> list[Remark]:
    """Remark values too large, or too small, for orbit and this kind of head: g read as ug, or the other way round."""
    remarks = []
    limits = {AMBIENT: plan.largest_ambient, BIAS: plan.largest_bias, READING: plan.largest_bias}
    do = "Check the unit of the readings (g, mg, ug), the gain and the positions"
    for key, value in zip(whole.keys, whole.values, strict=True):
        limit = limits.get(key.quantity)
        if limit is not None and abs(value) > limit:
            what = f"{key} is {value * UG:.4g} ug, above the plan's limit of {limit * UG:.6g} ug"
            remarks.append(Remark("magnitude", "error", what, do=do, axis=key.axis))
    levels = [abs(v) for key, v in zip(whole.keys, whole.values, strict=True) if key.quantity in limits]
    if levels and max(levels) < LEAST * factor("g", "m/s^2"):
        what = f"all readings are below {max(levels) * UG:.2g} ug, less than the bias of any head"
        remarks.append(Remark("magnitude", "warning", what, do=do))
    return remarks
