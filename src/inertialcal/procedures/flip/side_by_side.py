"""Two ground models side by side: what each leaves of the bias in the same flips, and what they differ by.

The same dwells, corrected by one model and by another, have the same noise: it is in the difference of their readings
only as far as the models make it. So the readings are subtracted dwell by dwell, and the differences are reduced as
readings are: noise from the difference of the quiet records, several flips by the scatter of their differences. The
uncertainties of the two errors, added as if they were independent, would hide a difference that is plain.

    other_model_bias_error       E_other               in the dwells that both have
    model_bias_error_change      E - E_other           of the same dwells
    model_bias_error_reduction   |E_other| - |E|       positive: nearer to zero than the other

The sizes are those of the flip, or of the mean of all flips; whether ``|E_other| - |E|`` is their difference or their
sum, depends on the signs of both errors. Where one of them is not known, its 95 % interval reaching over zero, the
reduction has no uncertainty. Of the standards only the scale factor acts on a difference of readings: the others are
the same in both. Where the two have no dwell in common, the change is that of the pooled errors, taken as independent.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
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
from .readings import Quiet, Readings
from .separation.equations import BIAS
from .separation.pooling import Flip, flips_of, pooled

if TYPE_CHECKING:
    from .reduction import Result

OTHER, CHANGE, REDUCTION = COMPARED.other, COMPARED.change, COMPARED.reduction
DIGITS = 6  # of an angle [rad], and of a time [s], by which dwells are told to be the same
UNIT = "m/s^2"
SIGN = Reason("sign_unknown", "the sign of an error is not known: its 95 % interval reaches over zero")

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
    for one, called in ((result, "this test"), (other, name)):
        if not one.plan.corrected:
            what = f"{called} has the bias in its readings: there is no error of a model to set beside another's"
            raise PlanError(
                what, do="Say plan.corrected = true where a model's bias was taken off", code="not_corrected"
            )
    if result.plan.axis != other.plan.axis:
        what = f"turned about {result.plan.axis}, {name} about {other.plan.axis}: their errors are of different axes"
        raise PlanError(what, do="Set tests of the same turn side by side", code="plans_differ")
    here, there = same_dwells(result.readings, other.readings)
    if not len(here):
        return _independent(result.whole, other.whole, name)
    pair = _Pair.of(result.plan, _taken(result.readings, here), _taken(other.readings, there))
    every = len(here) == len(result.readings) == len(other.readings)
    return pair.rows(name, "" if every else f", in the {len(here)} dwells that both have")


def same_dwells(one: Readings, other: Readings) -> tuple[Order, Order]:
    """Return the dwells that both have, by flip, position and their order at it, as rows of the one and the other."""
    keys, others = _keys(one), {key: i for i, key in enumerate(_keys(other))}
    pairs = [(i, others[key]) for i, key in enumerate(keys) if key in others]
    return np.array([i for i, _ in pairs], dtype=np.intp), np.array([k for _, k in pairs], dtype=np.intp)


def _keys(readings: Readings) -> list[tuple[str, float, int]]:
    seen: dict[tuple[str, float], int] = {}
    found = []
    for flip, angle in zip(readings.flip, np.round(readings.angle, DIGITS), strict=True):
        place = (str(flip), float(angle))
        seen[place] = seen.get(place, 0) + 1
        found.append((*place, seen[place]))
    return found


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

    quiet = tuple(
        replace(a, means=of(a.means, b.means))
        for a, b in zip(one.quiet, other.quiet, strict=False)
        if _same_record(a, b)
    )
    return replace(
        one, outputs=of(one.outputs, other.outputs), predicted=of(one.predicted, other.predicted), quiet=quiet
    )


def _same_record(one: Quiet, other: Quiet) -> bool:
    """Tell whether two records have their blocks at the same times."""
    same = one.times.shape == other.times.shape and one.weights.shape == other.weights.shape
    return bool(same and np.allclose(one.times, other.times, atol=10.0**-DIGITS, rtol=0.0))


@dataclass(frozen=True, eq=False)
class _Pair:
    """Flips of the one, the other, their difference (one less other) and their mean, the same dwells in all."""

    one: _Reduced
    other: _Reduced
    change: _Reduced
    middle: _Reduced

    @classmethod
    def of(cls, plan: Plan, one: Readings, other: Readings) -> _Pair:
        """Reduce readings of the same dwells, their differences and their means."""
        scale = {name: stated for name, stated in plan.standards.items() if name == "sensor.scale_factor"}
        relative = replace(plan, standards=scale, raw_bias=0.0)
        change, middle = _combined(one, other, 1.0, -1.0), _combined(one, other, 0.5, 0.5)
        one, other = _combined(middle, change, 1.0, 0.5), _combined(middle, change, 1.0, -0.5)  # where both were read
        return cls(*(_Reduced.of(p, r) for p, r in ((plan, one), (plan, other), (relative, change), (plan, middle))))

    def rows(self, name: str, where: str) -> list[Row]:
        """Return the error of the other, change and reduction: all flips pooled, then each of several."""
        told = (f"of {name}{where}", f"less {name}, dwell by dwell{where}")
        found = self._rows(None, None, told)
        for at, flip in enumerate(self.change.flips if len(self.change.flips) > 1 else ()):
            found += self._rows(at, Member("flip", flip.label), told)
        return found

    def _rows(self, at: int | None, member: Member | None, told: tuple[str, str]) -> list[Row]:
        change, middle = self.change.flip(at), self.middle.flip(at)
        one, other = self.one.flip(at), self.other.flip(at)
        found = []
        for key in change.keys:
            if key.quantity == BIAS and all(key in flip.keys for flip in (middle, one, other)):
                found += [
                    _row(OTHER, other, key, 1.0, told[0], member),
                    _row(CHANGE, change, key, 1.0, told[1], member),
                    _reduction(change, middle, (one, other), key, told[1], member),
                ]
        return found


@dataclass(frozen=True, eq=False)
class _Reduced:
    """Flips of a set of readings, each by its own, and pooled."""

    flips: tuple[Flip, ...]
    whole: Flip

    @classmethod
    def of(cls, plan: Plan, readings: Readings) -> _Reduced:
        flips = flips_of(plan, readings)
        return cls(flips, pooled(plan, readings, flips))

    def flip(self, at: int | None) -> Flip:
        return self.whole if at is None else self.flips[at]


def _reduction(
    change: Flip, middle: Flip, errors: tuple[Flip, Flip], key: Key, told: str, member: Member | None
) -> Row:
    """Return ``|E_other| - |E|``: plus or minus the difference, or twice the mean, by the signs of both."""
    own, other = (float(flip.values[flip.keys.index(key)]) for flip in errors)
    source, sign = (change, -np.sign(own)) if own * other > 0.0 else (middle, 2.0 * np.sign(other))
    row = _row(REDUCTION, source, key, float(sign), told, member)
    unknown = row.u is not None and any(_reaches_zero(flip, key) for flip in errors)
    if unknown:
        return replace(row, u=None, dof=None, interval=None, status="not_estimated", reason=SIGN)
    return row


def _reaches_zero(flip: Flip, key: Key) -> bool:
    if flip.estimate is None:
        return True
    at = flip.keys.index(key)
    lo, hi = ends(t_interval(float(flip.values[at]), float(flip.estimate.u[at]), float(flip.estimate.dof[at])))
    return lo <= 0.0 <= hi


def _row(quantity: str, flip: Flip, key: Key, sign: float, told: str, member: Member | None) -> Row:
    at = flip.keys.index(key)
    value = sign * float(flip.values[at])
    if flip.estimate is None:
        return Row(Key(quantity, key.axis), value, None, UNIT, status="not_estimated", reason=flip.reason,
                   member=member)  # fmt: skip
    u, dof = abs(sign) * float(flip.estimate.u[at]), float(flip.estimate.dof[at])
    interval = t_interval(value, u, dof)
    reason = Reason("limits", told)
    return Row(Key(quantity, key.axis), value, u, UNIT, _finite(dof), interval, reason=reason, member=member)


def _finite(dof: float) -> float | None:
    return dof if np.isfinite(dof) else None


def _independent(one: Flip, other: Flip, name: str) -> list[Row]:
    """Return the change of the pooled errors of flips that have nothing in common."""
    keys = [own for own in one.keys if own.quantity == BIAS and own in other.keys]
    told = f"less {name}, which has no dwell in common: taken as independent"
    return [
        row
        for own in keys
        for row in (
            _row(OTHER, other, own, 1.0, f"of {name}", None),
            _row(CHANGE, _difference(one, other, own), own, 1.0, told, None),
        )
    ]


def _difference(one: Flip, other: Flip, key: Key) -> Flip:
    """Return one less other, their variances added."""
    at: Mapping[str, int] = {side: flip.keys.index(key) for side, flip in (("one", one), ("other", other))}
    values: Array = np.array([one.values[at["one"]] - other.values[at["other"]]])
    reason = one.reason or other.reason
    if one.estimate is None or other.estimate is None:
        return Flip("", (key,), values, None, reason or Reason("no_uncertainty", "an error has no uncertainty"), ())
    parts = [
        Component(side, "A", np.array([[float(flip.u[at[side]]) ** 2]]), float(flip.dof[at[side]]), "t")
        for side, flip in (("one", one.estimate), ("other", other.estimate))
    ]
    return Flip("", (key,), values, Estimate((key,), values, (UNIT,), tuple(parts)), Reason(), ())
