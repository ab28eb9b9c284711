"""Positions: accelerometers and gyros from static positions and the rotations between them, without a turntable.

What is fitted stands in ``accelerometer`` (known orientations, or |f| = g), ``prior`` (with a
stated prior), ``at_rest`` (bias and g-sensitivity of
gyros) and ``rotations`` (their matrix); what the positions cannot determine in ``linear_sensor``, which of them
disagree in ``outliers``, mistakes of unit, axis and time in ``checks``, the closed form of Ferraris in ``published``.

What is assumed: bias and matrix hold for the whole recording; what differs between positions beyond the noise is
independent from one to the next, and so is what differs between rotations. What the uncertainty means: the standard
deviation that the estimate would have if the positions were laid again, joined with the stated uncertainties of the
standards. The noise inside positions alone would promise several times too much.

References
----------
.. [1] D. Tedaldi, A. Pretto and E. Menegatti, IEEE ICRA 2014, 3042-3049 (static positions and gravity transitions).
.. [2] F. Ferraris, U. Grimaldi and M. Parvis, Sensors and Materials 7 (1995) 311-330.
.. [3] IEEE Std 1293, annex on multipoint tumble analysis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.curve import Curve
from ...core.errors import DataError, InertialcalError
from ...core.estimate import Array, Estimate
from ...core.key import AXES, Kind, Reason
from ...core.remarks import Remark, gather
from ...core.results import Row, by_quantity, changed
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import items
from ...core.show.tables import Block, html, text
from ...sensors.model.sensor_model import SensorModel
from ..corrections import TakenOff
from .checks import check_units, judged_scale, remarks_of, start_of
from .fit.accelerometer import FEWEST, Fitted, among, fit_known, fit_many_known, fit_many_unknown, fit_unknown
from .fit.at_rest import apart, at_rest, joined
from .fit.gyro import NO_SCALE, FittedGyro, fit_gyro, problem_of, without_scale
from .fit.linear_sensor import LinearSensor, after_corrections, ends_of, rounded_scale, with_ideal
from .fit.next_record import FEW, NO_TIME, UNJUDGED, NextRecord, rests_of, slow_noise_of
from .fit.over_temperature import at_reference, check_over_temperature, over_temperature
from .fit.prior import Judgement, check_prior, fit_prior
from .orientations import check_names, missing_faces
from .plan import INFLUENCES, Plan
from .published import Ferraris, ferraris
from .readings import Readings, Rotation, Triad, by_axis, local_gravity
from .recordings import Section, on_faces, readings_from
from .rows import Terms, curves, estimate_many, rows, terms_many, used_angles
from .simulation import Truth, simulate

__all__ = [
    "AXES",
    "INFLUENCES",
    "Ferraris",
    "Fitted",
    "FittedGyro",
    "Plan",
    "Readings",
    "Result",
    "Rotation",
    "Section",
    "Triad",
    "Truth",
    "ferraris",
    "local_gravity",
    "on_faces",
    "readings_from",
    "reduce",
    "rows",
    "simulate",
    "used_angles",
]


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives."""

    plan: Plan  # As given
    readings: Readings  # As given; at the reference temperature where that takes part
    acc: Fitted  # Accelerometers, and how each position agrees
    gyro: FittedGyro | None  # Gyros, and how each rotation agrees; None where there are none
    estimates: Mapping[str, Estimate]  # ``"accelerometer"``, ``"gyro"`` -> what is estimated, SI
    terms: Mapping[str, Terms]  # The same as parameters of a model, for readings as they were recorded
    remarks: tuple[Remark, ...]  # Findings
    # Of each sensor: bias of a record that comes next, or why nothing says it
    next_record: Mapping[str, NextRecord | Reason] = field(default_factory=dict)
    sensor: Kind | Literal[""] = ""  # Kind of sensor that this is the part of; empty for the whole
    prior: Judgement | None = None  # How a stated prior agrees and whether it helps; None without one

    @property
    def estimate(self) -> Estimate | None:
        """Estimate of the sensor that this is the part of; None for the whole, and where nothing was estimated."""
        return self.estimates.get(self.sensor)

    @cached_property
    def models(self) -> Mapping[str, SensorModel]:
        """``"accelerometer"``, ``"gyro"`` -> its model, for readings as they were recorded."""
        return {kind: one.model for kind, one in self.terms.items()}

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI: sensor by sensor, which their keys name."""
        every = rows(self)
        kinds = [self.sensor] if self.sensor else list(dict.fromkeys(row.key.sensor for row in every))
        return tuple(row for kind in kinds for row in by_quantity([row for row in every if row.key.sensor == kind]))

    def curves(self) -> list[Curve]:
        """Return the curves of ``results.json``, SI: those of the sensor, or of both."""
        return curves(self)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: how much went in, the figures in SI, how many remarks."""
        kind = "known orientations" if self.acc.known else "|f| = g"
        caption = f"positions: {items(len(self.readings), 'position')} ({kind}),"
        caption += f" {items(len(self.readings.rotations), 'rotation')}"
        return (
            *estimate_table([row.to_dict() for row in self.rows() if not row.case.beside], caption),
            *remarks_line(self.remarks),
        )

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Calibrate accelerometers and gyros from positions and rotations.

    Raises
    ------
    DataError
        ``too_few_positions``, ``unit_slip``, ``position_misnamed``, ``axes_disagree``, ``prior_without_ideal``.
    """
    found = reduce_many([(plan, readings)])[0]
    if isinstance(found, InertialcalError):
        raise found
    return found


@dataclass(eq=False)
class _Unit:
    """A unit at work: accelerometers fitted against a scale factor near enough, then referred to the ideal one."""

    plan: Plan
    readings: Readings  # At the reference temperature where that takes part
    ideal: Array  # shape (3,): near enough
    zero: Array  # shape (3,)
    warm: list[Remark] = field(default_factory=list[Remark])
    over: LinearSensor | None = None  # Over temperature
    fitted: Fitted | None = None
    prior: Judgement | None = None
    acc: Fitted | None = None
    gyro: FittedGyro | None = None
    found: list[Remark] = field(default_factory=list[Remark])


def reduce_many(tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
    """Return the result of each unit as `reduce` gives it, or its refusal; units alike are fitted at once."""
    results: list[Result | InertialcalError | None] = [None] * len(tests)
    working: dict[int, _Unit] = {}
    for k, (plan, readings) in enumerate(tests):
        try:
            working[k] = _begun(plan, readings)
        except InertialcalError as error:
            results[k] = error
    alike: dict[tuple[int, int], list[int]] = {}
    for k, unit in working.items():
        known = _is_known(unit.readings)
        simple = not (unit.plan.temperature_order or (unit.plan.priors and not known))
        alike.setdefault((id(unit.plan), -1 if known else len(unit.readings)) if simple else (-1, k), []).append(k)
    for at in alike.values():
        _fit([working[k] for k in at], at, results)
    for k, unit in working.items():
        try:
            if results[k] is None:
                _refer(unit)
        except InertialcalError as error:
            results[k] = error
    left = {k: unit for k, unit in working.items() if results[k] is None}
    for k, estimated in zip(left, _estimated([*left.values()]), strict=True):
        try:
            results[k] = _result(left[k], *estimated)
        except InertialcalError as error:
            results[k] = error
    return [one for one in results if one is not None]


def _begun(plan: Plan, readings: Readings) -> _Unit:
    """Look for mistakes of units and names; return what the readings are taken to.

    Raises
    ------
    DataError
        ``unit_slip``, ``position_misnamed``, ``axis_not_read``, ``too_few_positions``.
    """
    g, si = local_gravity(plan), readings.acc.unit == "m/s^2"
    check_units(readings, g)
    check_names(readings)
    near, middle = _start(readings.acc.mean, g)
    ideal = by_axis(plan.acc_scale_factor, 1.0) if si or plan.acc_scale_factor else near
    zero = by_axis(plan.acc_zero, 0.0) if si or plan.acc_zero else middle
    if not plan.temperature_order:
        return _Unit(plan, readings, ideal, zero)
    check_over_temperature(plan)
    over, warm = over_temperature(plan, readings, lambda part: _accelerometers(plan, part, ideal, zero)[0])
    return _Unit(plan, at_reference(over, readings), ideal, zero, warm, over)


def _fit(units: Sequence[_Unit], at: Sequence[int], results: list[Result | InertialcalError | None]) -> None:
    """Fit the accelerometers of units, at once where there are several; note who is refused."""
    if len(units) > 1:
        try:
            made = _fit_many(units[0].plan, units)
        except (InertialcalError, np.linalg.LinAlgError):  # of one of them: which, the units by themselves say
            for k, unit in zip(at, units, strict=True):
                _fit([unit], [k], results)
            return
        for k, unit, one in zip(at, units, made, strict=True):
            if isinstance(one, DataError):
                results[k] = one
            else:
                unit.fitted = _after_corrections(one, unit.readings.taken_off.get("accelerometer", {}))
        return
    unit = units[0]
    try:
        unit.fitted, unit.prior = _accelerometers(unit.plan, unit.readings, unit.ideal, unit.zero)
    except InertialcalError as error:
        results[at[0]] = error


def _fit_many(plan: Plan, units: Sequence[_Unit]) -> list[Fitted | DataError]:
    """Return the fits of units of one plan: all of known orientation, or all of as many positions of which none is."""
    ideals, zeros = [one.ideal for one in units], [one.zero for one in units]
    if not _is_known(units[0].readings):
        corrected = any(one.readings.taken_off for one in units)
        return fit_many_unknown(plan, [one.readings.acc for one in units], ideals, zeros, corrected)
    directions = [one.readings.direction for one in units]
    named = [(_named(one), one) for one in directions if one is not None]
    triads = [one.readings.acc.take(own) for one, (own, _) in zip(units, named, strict=True)]
    found = fit_many_known(plan, triads, [one[own] for own, one in named], ideals, zeros)
    return [one if isinstance(one, DataError) else among(one, own) for one, (own, _) in zip(found, named, strict=True)]


def _refer(unit: _Unit) -> None:
    """Refer accelerometers to their ideal scale factor, and fit gyros."""
    plan, readings, fitted = unit.plan, unit.readings, unit.fitted
    assert fitted is not None  # noqa: S101 - else it is refused
    if unit.over is not None:
        fitted = unit.fitted = replace(fitted, sensor=unit.over)
    sensor, known = fitted.sensor, readings.acc.unit == "m/s^2" or plan.acc_scale_factor
    final = unit.ideal if known else rounded_scale(sensor, np.ones(3, dtype=bool))
    zero = by_axis(plan.acc_zero, 0.0)
    unit.acc = changed(fitted, sensor=with_ideal(sensor, final, zero))
    if unit.prior is not None:
        alone = with_ideal(unit.prior.without.sensor, final, zero)
        unit.prior = replace(unit.prior, without=replace(unit.prior.without, sensor=alone))
    if readings.gyro is not None:
        unit.gyro, unit.found = _gyros(plan, readings, unit.acc)


def _estimated(units: Sequence[_Unit]) -> list[tuple[dict[str, Estimate], dict[str, Terms]]]:
    """Return estimates and parameters of models of all sensors of each unit, by their kind."""
    places: list[tuple[int, Kind]] = []
    seen, units_of = list[tuple[LinearSensor, Array]](), list[str]()
    for k, unit in enumerate(units):
        readings = unit.readings
        fits: tuple[tuple[Kind, Fitted | FittedGyro | None, Triad | None, list[Array]], ...] = (
            ("accelerometer", unit.acc, readings.acc, [readings.acc.mean]),
            ("gyro", unit.gyro, readings.gyro, [one.gyro for one in readings.rotations]),
        )
        for kind, fit, triad, outputs in fits:
            if fit is None or triad is None:
                continue
            places.append((k, kind))
            seen.append((fit.sensor, outputs[0] if len(outputs) == 1 else np.concatenate([np.empty((0, 3)), *outputs])))
            units_of.append(triad.unit)
    given = [(sensor, kind, unit, ends) for (sensor, _), (_, kind), unit, ends
             in zip(seen, places, units_of, ends_of(seen), strict=True)]  # fmt: skip
    estimates = estimate_many([one[:3] for one in given])
    found: list[tuple[dict[str, Estimate], dict[str, Terms]]] = [({}, {}) for _ in units]
    for (k, kind), estimated, terms in zip(places, estimates, terms_many(given, estimates), strict=True):
        if estimated is not None and terms is not None:
            found[k][0][kind], found[k][1][kind] = estimated, terms
    return found


def _result(unit: _Unit, estimates: Mapping[str, Estimate], terms: Mapping[str, Terms]) -> Result:
    """Return what was found of a unit.

    Raises
    ------
    DataError
        If a parameter can be that of no sensor.
    """
    readings, fitted, acc, gyro = unit.readings, unit.fitted, unit.acc, unit.gyro
    assert fitted is not None  # noqa: S101 - else it is refused
    assert acc is not None  # noqa: S101
    for one in terms.values():
        if not one.is_possible:
            _ = one.model  # refuses it, and says why
    bare = Result(unit.plan, readings, acc, gyro, estimates, terms, (), prior=unit.prior)
    remarks = gather([*readings.remarks, *missing_faces(readings), *unit.warm, *unit.found, *remarks_of(bare)])
    onward: dict[str, NextRecord | Reason] = {"accelerometer": _next_accelerometers(readings, fitted, acc)}
    if gyro is not None:
        unscaled = NO_SCALE in gyro.sensor.reasons.values()
        onward["gyro"] = NO_SCALE if unscaled else _next_gyros(readings, gyro)
    return changed(bare, remarks=remarks, next_record=onward)


def _is_known(readings: Readings) -> bool:
    """Return whether enough positions are of known orientation."""
    return readings.direction is not None and bool(np.sum(_named(readings.direction)) >= FEWEST)


def _named(direction: Array) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(direction).all(axis=-1), dtype=np.bool_)


def _accelerometers(plan: Plan, readings: Readings, ideal: Array, zero: Array) -> tuple[Fitted, Judgement | None]:
    """Return the accelerometers of positions at one temperature, and how a stated prior agrees."""
    direction, prior = readings.direction, None
    if direction is not None and _is_known(readings):
        named = _named(direction)
        fitted = among(fit_known(plan, readings.acc.take(named), direction[named], ideal, zero), named)
    else:
        check_prior(plan, readings.acc.unit == "m/s^2")
        fitted = fit_unknown(plan, readings.acc, ideal, zero)
        if plan.priors:
            fitted, prior = fit_prior(plan, readings.acc, ideal, zero, fitted)
    off = readings.taken_off.get("accelerometer", {})
    if prior is not None:
        prior = replace(prior, without=_after_corrections(prior.without, off))
    return _after_corrections(fitted, off), prior


def _after_corrections(fitted: Fitted, taken_off: TakenOff) -> Fitted:
    """Return a fit with what is not known of corrections among its sources."""
    gain = fitted.per_reading
    if gain is None or not taken_off:
        return fitted
    more = after_corrections(taken_off, gain / fitted.sensor.ideal)
    return replace(fitted, sensor=replace(fitted.sensor, sources=(*fitted.sensor.sources, *more)))


def _next_accelerometers(readings: Readings, fitted: Fitted, final: Fitted) -> NextRecord | Reason:
    """Return what the bias is in the next record; ``final`` is the fit relative to its ideal scale factor."""
    rests, own = rests_of(readings), fitted.wandering
    if rests is None:
        return NO_TIME
    if own is None:
        return UNJUDGED if fitted.free else FEW
    slow = slow_noise_of(own.seen, rests)
    if slow is None:
        return FEW
    u, dof = np.array([slow.next_record(own.gain[k], k, float(own.noise[k])) for k in range(3)]).T
    return NextRecord(u * fitted.sensor.ideal / final.sensor.ideal, dof)


def _next_gyros(readings: Readings, gyro: FittedGyro) -> NextRecord | Reason:
    """Return what the bias is in the next record."""
    if rests_of(readings) is None:
        return NO_TIME
    rest = gyro.rest
    if rest.fits is None or any(one is None for one in rest.slow):
        return FEW
    pairs = [
        slow.next_record(fit.gain[0], 0, float(sum(part[0, 0] for part in fit.parts.values())))
        for fit, slow in zip(rest.fits, rest.slow, strict=True)
        if slow
    ]
    return NextRecord(*np.array(pairs).T)


def _start(mean: Array, g: float) -> tuple[Array, Array]:
    """Return scale and zero of a sphere about the readings, each shape (3,)."""
    low, high = mean.min(axis=0), mean.max(axis=0)
    half = 0.5 * (high - low)
    if not np.all(half > 0.0):
        at = AXES[int(np.argmin(half))]
        raise DataError(
            f"accelerometer {at} reads the same in all positions",
            why="it does not work, or all positions are one",
            do="Check the channel; lay the unit into different orientations",
            code="too_few_positions",
        )
    return half / g, 0.5 * (high + low)


def _gyros(plan: Plan, readings: Readings, acc: Fitted) -> tuple[FittedGyro, list[Remark]]:
    """Look for mistakes of unit and axes, fit, and refer to the ideal scale factor."""
    assert readings.gyro is not None  # noqa: S101 - the caller has looked
    si = readings.gyro.unit == "rad/s"
    known = si or plan.gyro_scale_factor is not None
    ideal, zero = by_axis(plan.gyro_scale_factor, 1.0), by_axis(plan.gyro_zero, 0.0)
    start: Array = np.eye(3)
    force = acc.sensor.applied(readings.acc.mean)
    north = apart(force)
    if readings.transitions or readings.turns:
        rough = problem_of(plan, readings, acc, at_rest(plan, readings.gyro, force, ideal, zero), ideal, zero)
        start = start_of(rough, known, [one.where for one in readings.turns])
        north = joined(rough, force, start)
    if not known:  # the scale factor that is found, rounded, is what errors then refer to
        size = float(np.cbrt(abs(np.linalg.det(start))))
        first = fit_gyro(plan, readings, acc, ideal / size, zero, start / size, north)
        ideal = rounded_scale(first.sensor, np.ones(3, dtype=bool))
        start = np.asarray(np.linalg.inv(with_ideal(first.sensor, ideal, zero).matrix), dtype=np.float64)
    fitted = fit_gyro(plan, readings, acc, ideal, zero, start, north)
    if not known:
        fitted = without_scale(fitted)
    if fitted.rotated is None:
        return fitted, []
    determined = fitted.rotated.observed.determined[[0, 4, 8]]
    said = judged_scale(fitted.rotated.W, determined, readings.gyro.unit, known, next(iter(readings.where), ""))
    assumed = fitted.rotated.found is None and not readings.transitions and all(one.assumed for one in readings.turns)
    if assumed and np.all(np.diag(fitted.sensor.matrix) < 0.0):  # they turned the other way: the gyros say it
        values = fitted.sensor.values * np.repeat([-1.0, 1.0], [9, len(fitted.sensor.values) - 9])
        fitted = replace(fitted, sensor=replace(fitted.sensor, values=values))
    return fitted, said
