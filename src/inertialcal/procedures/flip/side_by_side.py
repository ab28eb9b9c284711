"""Two ground models side by side: the remaining bias of each in the same flips, and their difference.

The same dwells, corrected by one model and by another, have the same noise: it is in the difference of their readings
only as far as the models put it there. So the readings are subtracted dwell by dwell, and the differences are reduced
like readings: noise from the difference of the quiet records, several flips by the scatter of their differences. The
uncertainties of the two errors, added as if they were independent, would hide a clear difference.

    other_model_bias_error       E_other               in the common dwells
    model_bias_error_change      E - E_other           of the same dwells
    model_bias_error_reduction   |E_other| - |E|       positive: nearer to zero than the other

The sizes are those of the flip, or of the mean of all flips; the signs of both errors decide whether
``|E_other| - |E|`` is their difference or their sum. Where the 95 % interval of one of them includes zero, its sign is
not known and the reduction has no uncertainty. Of the standards only the scale factor acts on a difference of readings:
the others are the same in both. Without a common dwell, the change is that of the pooled errors, taken as independent.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...core.errors import PlanError
from ...core.estimate import Array, Component, Estimate
from ...core.key import Key, Member, Reason
from ...core.results import Row
from ...statistics.intervals import ends, t_interval
from .figures import COMPARED
from .plan import Plan
from .readings import Readings
from .separation.equations import BIAS
from .separation.pooling import Flip, flips_of, pooled

if TYPE_CHECKING:
    from .reduction import Result

OTHER, CHANGE, REDUCTION = COMPARED.other, COMPARED.change, COMPARED.reduction
DIGITS = 6  # of an angle [rad], and of a time [s], to which dwells are the same
UNIT = "m/s^2"
SIGN = Reason("sign_unknown", "the sign of an error is not known: its 95 % interval includes zero")

Order = NDArray[np.intp]


def side_by_side(result: Result, other: Result, name: str) -> list[Row]:
    """Return error of the other, change and reduction for each turned axis: pooled, then of each of several flips.

    Parameters
    ----------
    result, other : Result
        Of the flips after one model and after another, both ``corrected``.
    name : str
        Of the other, for the reasons.

    Raises
    ------
    PlanError
        ``plans_differ`` if the turn was about another axis; ``not_corrected`` if the bias is still in one of them.
    """
    plan = result.plan
    for one, called in ((result, "this test"), (other, name)):
        if not one.plan.corrected:
            what = f"{called} has the bias in its readings: there is no model error to compare"
            do = "Say plan.corrected = true where a model's bias was subtracted"
            raise PlanError(what, do=do, code="not_corrected")
    if plan.axis != other.plan.axis:
        what = f"turned about {plan.axis}, {name} about {other.plan.axis}: their errors are of different axes"
        raise PlanError(what, do="Compare tests of the same turn", code="plans_differ")
    here, there = same_dwells(result.readings, other.readings)
    if not len(here):
        return _independent(result.whole, other.whole, name)
    one_s, other_s = _taken(result.readings, here), _taken(other.readings, there)
    change, middle = _combined(one_s, other_s, 1.0, -1.0), _combined(one_s, other_s, 0.5, 0.5)
    both = [_combined(middle, change, 1.0, half) for half in (0.5, -0.5)]  # where both were read
    scale = {key: stated for key, stated in plan.standards.items() if key == "sensor.scale_factor"}
    relative = replace(plan, standards=scale, raw_bias=0.0)
    sets = [_flips(relative, change), _flips(plan, middle), *(_flips(plan, readings) for readings in both)]
    every = len(here) == len(result.readings) == len(other.readings)
    where = "" if every else f", in the {len(here)} common dwells"
    of, less = f"of {name}{where}", f"less {name}, dwell by dwell{where}"
    rows = []
    for flips in zip(*sets, strict=True):  # all pooled, then each of several
        own = flips[0]
        member = Member("flip", own.label) if own.label else None
        for key in own.keys:
            if key.quantity == BIAS and all(key in flip.keys for flip in flips):
                rows += [
                    _row(OTHER, flips[3], key, 1.0, of, member),
                    _row(CHANGE, own, key, 1.0, less, member),
                    _reduction(own, flips[1], flips[2:], key, less, member),
                ]
    return rows


def same_dwells(one: Readings, other: Readings) -> tuple[Order, Order]:
    """Return the dwells that both have, by flip, position and their order at it, as rows of the one and the other."""

    def keys(readings: Readings) -> list[tuple[str, float, int]]:
        count: dict[tuple[str, float], int] = {}
        found = []
        for flip, angle in zip(readings.flip, np.round(readings.angle, DIGITS), strict=True):
            place = (str(flip), float(angle))
            count[place] = count.get(place, 0) + 1
            found.append((*place, count[place]))
        return found

    others = {key: i for i, key in enumerate(keys(other))}
    pairs = [(i, others[key]) for i, key in enumerate(keys(one)) if key in others]
    return np.array([i for i, _ in pairs], dtype=np.intp), np.array([k for _, k in pairs], dtype=np.intp)


def _taken(readings: Readings, rows: Order) -> Readings:
    """Return some dwells, their means alone."""
    return Readings(
        readings.angle[rows],
        readings.flip[rows],
        {axis: one[rows] for axis, one in readings.outputs.items()},
        time=None if readings.time is None else readings.time[rows],
        temperature={axis: one[rows] for axis, one in readings.temperature.items()},
        quiet=tuple(replace(one, weights=one.weights[rows], spans=one.spans[rows]) for one in readings.quiet),
        where=tuple(readings.where[i] for i in rows) if readings.where else (),
        predicted={axis: one[rows] for axis, one in readings.predicted.items()},
    )


def _combined(one: Readings, other: Readings, own: float, others: float) -> Readings:
    """Return ``own`` times the readings of one and ``others`` times those of the other, and so their quiet records."""

    def of(a: Mapping[str, Array], b: Mapping[str, Array]) -> dict[str, Array]:
        return {axis: own * a[axis] + others * b[axis] for axis in a if axis in b}

    quiet = []
    for a, b in zip(one.quiet, other.quiet, strict=False):
        same = a.times.shape == b.times.shape and a.weights.shape == b.weights.shape
        if same and np.allclose(a.times, b.times, atol=10.0**-DIGITS, rtol=0.0):  # blocks at the same times
            quiet.append(replace(a, means=of(a.means, b.means)))
    outputs, predicted = of(one.outputs, other.outputs), of(one.predicted, other.predicted)
    return replace(one, outputs=outputs, predicted=predicted, quiet=tuple(quiet))


def _flips(plan: Plan, readings: Readings) -> list[Flip]:
    """Return all flips pooled, then each of several."""
    flips = flips_of(plan, readings)
    return [pooled(plan, readings, flips), *(flips if len(flips) > 1 else ())]


def _reduction(change: Flip, middle: Flip, errors: tuple[Flip, ...], key: Key, text: str, member: Member | None) -> Row:
    """Return ``|E_other| - |E|``: plus or minus the difference, or twice the mean, by the signs of both."""
    own, other = (float(flip.values[flip.keys.index(key)]) for flip in errors)
    source, sign = (change, -np.sign(own)) if own * other > 0.0 else (middle, 2.0 * np.sign(other))
    row = _row(REDUCTION, source, key, float(sign), text, member)
    if row.u is not None and any(_includes_zero(flip, key) for flip in errors):
        return replace(row, u=None, dof=None, interval=None, status="not_estimated", reason=SIGN)
    return row


def _includes_zero(flip: Flip, key: Key) -> bool:
    if flip.estimate is None:
        return True
    at = flip.keys.index(key)
    lo, hi = ends(t_interval(float(flip.values[at]), float(flip.estimate.u[at]), float(flip.estimate.dof[at])))
    return lo <= 0.0 <= hi


def _row(quantity: str, flip: Flip, key: Key, sign: float, text: str, member: Member | None) -> Row:
    at = flip.keys.index(key)
    value = sign * float(flip.values[at])
    if flip.estimate is None:
        return Row(Key(quantity, key.axis), value, None, UNIT, status="not_estimated", reason=flip.reason,
                   member=member)  # fmt: skip
    u, dof = abs(sign) * float(flip.estimate.u[at]), float(flip.estimate.dof[at])
    known, interval = (dof if np.isfinite(dof) else None), t_interval(value, u, dof)
    return Row(Key(quantity, key.axis), value, u, UNIT, known, interval, reason=Reason("limits", text), member=member)


def _independent(one: Flip, other: Flip, name: str) -> list[Row]:
    """Return the change of the pooled errors of flips that have no dwell in common, their variances added."""
    rows = []
    for key in (key for key in one.keys if key.quantity == BIAS and key in other.keys):
        places = ((one, one.keys.index(key)), (other, other.keys.index(key)))
        values = np.array([one.values[places[0][1]] - other.values[places[1][1]]])
        parts = [
            Component(side, "A", np.array([[float(flip.estimate.u[at]) ** 2]]), float(flip.estimate.dof[at]), "t")
            for side, (flip, at) in zip(("one", "other"), places, strict=True)
            if flip.estimate is not None
        ]
        known = len(parts) == len(places)
        estimate = Estimate((key,), values, (UNIT,), tuple(parts)) if known else None
        reason = one.reason or other.reason or Reason("no_uncertainty", "an error has no uncertainty")
        change = Flip("", (key,), values, estimate, Reason() if known else reason, ())
        less = f"less {name}, which has no dwell in common: taken as independent"
        rows += [_row(OTHER, other, key, 1.0, f"of {name}", None), _row(CHANGE, change, key, 1.0, less, None)]
    return rows
