"""Rows of a result of positions: every quantity with its uncertainty, or the reason why there is none.

The sensor of the key says whose: ``accelerometer`` or ``gyro``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy import linalg

from ...core.curve import Column, Curve
from ...core.errors import DataError
from ...core.estimate import Array, Estimate, Sources
from ...core.key import AXES, Key, Kind, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...core.units import normalise
from ...sensors.model.assemble import NOT_ESTIMATED, in_units, model_from, parameters_of
from ...sensors.model.sensor_model import SensorModel
from ...statistics.intervals import chi_square_interval, t_interval, t_intervals
from ...statistics.two_levels import TwoLevels
from .fit.accelerometer import OF_FRAME, Fitted
from .fit.fixture import FACE_FOUND, LAYING_FOUND
from .fit.gyro import NOTHING_LEFT, FittedGyro, angles_left
from .fit.linear_sensor import BIAS, FEWEST, G_SENSITIVITY, MATRIX, LinearSensor, OverTemperature, Source, with_ideal
from .fit.rotations import across
from .plan import INFLUENCES
from .published import published_rows
from .readings import local_gravity

if TYPE_CHECKING:
    from .reduction import Result

NO_LEVEL = Reason("not_repeated", "nothing was repeated")
NOT_SEEN = Reason("hardly_seen", "hardly larger than the known noise: less than one degree of freedom")
STATED = Reason("stated", "stated before any reading")
LEFT_OUT = Reason("left_out", "root mean square over the positions, each left out of the fit in turn")
SCALE = tuple(Key("scale_factor", a) for a in AXES)
ERROR = "scale_factor_error"
RELATIVE = {ERROR, "scale_factor_error_temperature", "cross_axis_sensitivity_temperature"}  # to a nominal scale factor
NEGLIGIBLE = 0.01  # of the largest part of a variance, below which a part's degrees of freedom do not matter
IN_REACH = 1e12  # of a parameter or input, up to which it is not looked at whether it can be
ROUNDING = 1e-12  # of the terms that make up a variance
UNIT: dict[str, str] = {"accelerometer": "m/s^2", "gyro": "rad/s"}


def rows(result: Result) -> list[Row]:
    """Return all rows, SI, accelerometers first."""
    found = _sensor_rows(
        result, "accelerometer", result.acc.sensor, result.readings.acc.unit, result.estimates.get("accelerometer")
    )
    found.append(_between(Key("scatter_position", "", "accelerometer"), "m/s^2", result.acc))
    laid = result.acc.laid
    if laid is not None:
        for quantity, name in (("face_error", FACE_FOUND), ("scatter_laying", LAYING_FOUND)):
            if name in laid.found.variances:
                key, dof = Key(quantity, "", "accelerometer"), laid.found.variance_dof(name)
                found.append(_scatter(key, "rad", float(np.sqrt(laid.found.variances[name])), dof))
    found += _prior_rows(result)
    gyro = result.gyro
    if gyro is not None and result.readings.gyro is not None:
        found += _sensor_rows(result, "gyro", gyro.sensor, result.readings.gyro.unit, result.estimates.get("gyro"))
        for axis, fit in zip(AXES, gyro.rest.fits or (None,) * 3, strict=True):
            found.append(_between(Key("scatter_position", axis, "gyro"), "rad/s", fit))
        fit = None if gyro.rotated is None or gyro.rotated.found is None else gyro.rotated.found
        repeated = fit if fit is not None and fit.free > 0 else None
        found.append(_between(Key("scatter_rotation", "", "gyro"), "rad", repeated))
        used = used_angles(result)
        if len(used):
            rms, free = float(np.sqrt(np.mean(used**2))), 2 * len(used) - 9
            found.append(_scatter(Key("transition_error", "", "gyro"), "rad", rms if free > 0 else None, free))
    return found + published_rows(result.readings, local_gravity(result.plan))


def _prior_rows(result: Result) -> list[Row]:
    """Return the prior, what the positions give without it, and the error of gravity in positions left out."""
    judged, unit = result.prior, result.readings.acc.unit
    if judged is None:
        return []
    alone = judged.without.sensor
    found = [
        replace(row, method=Method.WITHOUT_PRIOR)
        for row in _sensor_rows(result, "accelerometer", alone, unit, estimate(alone, "accelerometer", unit))
        if row.key.quantity in judged.stated and row.reason != OF_FRAME
    ]
    for row in list(found):
        u = judged.stated[row.key.quantity]
        ends = t_interval(0.0, u, np.inf)
        found.append(Row(row.key, 0.0, u, row.unit, None, ends, reason=STATED, method=Method.PRIOR))
    for name, errors in judged.left_out.items():
        key, size = Key("gravity_error_left_out", "", "accelerometer"), float(np.sqrt(np.mean(errors**2)))
        method = Method.RESULT if name == "prior" else Method(name)
        found.append(Row(key, float(f"{size:.3g}"), None, "m/s^2", reason=LEFT_OUT, method=method))
    return found


def _sensor_rows(result: Result, kind: Kind, sensor: LinearSensor, unit: str, estimate: Estimate | None) -> list[Row]:
    own, stated = sensor.temperature, result.plan.states_scale(kind)
    wanted = _wanted(kind, unit, len(sensor.values), () if own is None else (own.keys, own.units))
    why = reasons(sensor)
    if unit != UNIT[kind] and not stated:
        why = dict(why)
        for axis, size in zip(AXES, sensor.ideal, strict=True):
            what = f"no nominal scale factor was stated to differ from; errors of the model refer to {size:.4g} "
            reason = Reason("no_nominal", f"{what}{unit}/({UNIT[kind]})")
            for name, _, _ in wanted:
                if name.quantity in RELATIVE and name.axis[0] == axis:
                    why.setdefault(name, reason)
    limits = Reason("relative", "relative to the fixture") if missing(result) else Reason()
    figures: dict[Key, Row] = {}
    if estimate is not None:
        ends = t_intervals(estimate.values, estimate.u, estimate.dof)
        make = Row.of_own if np.isfinite(estimate.values).all() and np.isfinite(estimate.u).all() else Row
        numbers = zip(estimate.values.tolist(), estimate.u.tolist(), estimate.dof.tolist(), strict=True)
        keys = {name: key for name, key, _ in wanted}
        for name, one, (value, u, dof), between in zip(estimate.keys, estimate.units, numbers, ends, strict=True):
            finite = dof if math.isfinite(dof) else None
            figures[name] = make(keys[name], value, u, one, finite, between, reason=limits)
    found = [
        figures[name] if name in figures and not (name.quantity in RELATIVE and name in why)
        else _absent_row(key, of, why.get(name, NO_LEVEL))
        for name, key, of in wanted
    ]  # fmt: skip
    return found + _next_rows(result, [row for row in found if row.key.quantity == "bias"])


@lru_cache(maxsize=16)
def _wanted(
    kind: Kind, unit: str, count: int, over: tuple[()] | tuple[tuple[Key, ...], tuple[str, ...]]
) -> tuple[tuple[Key, Key, str], ...]:
    """Return the quantities of a sensor: as estimates name them, as rows do, and their units."""
    wanted = list(zip((*MATRIX, *BIAS, *G_SENSITIVITY)[:count], units_of(kind, count), strict=True))
    if over:
        wanted += list(zip(*over, strict=True))
    if unit != UNIT[kind]:
        wanted = [(name, f"{unit}/({UNIT[kind]})") for name in SCALE] + wanted
    return tuple((name, name._replace(sensor=kind), own) for name, own in wanted)


@lru_cache(maxsize=256)  # the same of all units whose figures are absent for the same reason
def _absent_row(key: Key, unit: str, reason: Reason) -> Row:
    return not_estimated(key, unit, reason)


@lru_cache(maxsize=16)
def _next_key(bias: Key) -> Key:
    return bias._replace(quantity="bias_next_record")


def _next_rows(result: Result, now: Sequence[Row]) -> list[Row]:
    """Return the bias of the record that comes next, by that of this one."""
    found = []
    for k, row in enumerate(now):
        key = _next_key(row.key)
        onward = result.next_record.get(row.key.sensor, NO_LEVEL)
        if row.value is None or isinstance(onward, Reason):
            why = row.reason if row.value is None else onward
            found.append(_absent_row(key, row.unit, why if isinstance(why, Reason) else NO_LEVEL))
            continue
        u, dof = float(onward.u[k]), float(onward.dof[k])
        found.append(row.changed(key=key, u=u, dof=dof, interval=t_interval(row.value, u, dof)))
    return found


def missing(result: Result) -> list[str]:
    """Return the standards that this test is subject to and that are not stated."""
    readings, wanted = result.readings, ["gravity.value"]
    if result.acc.known:
        wanted += ["fixture.mounting"]
        wanted += ["fixture.orientation"] if result.acc.laid is None else []  # else found from the readings
    if result.acc.sensor.temperature is not None:
        wanted.append("thermometer.temperature")
    if readings.turns:
        wanted += ["turn.angle", "fixture.orientation", "fixture.mounting"]
    if readings.rotations and readings.gyro is not None:
        wanted.append("clock.rate")
    return [name for name in INFLUENCES if name in wanted and name not in result.plan.standards]


def _scatter(key: Key, unit: str, std: float | None, dof: float) -> Row:
    if std is None:
        return _absent_row(key, unit, NO_LEVEL)
    if dof < FEWEST:
        return _absent_row(key, unit, NOT_SEEN)
    u = std / float(np.sqrt(2.0 * dof))
    return Row(key, std, u, unit, dof, chi_square_interval(std, dof))


def _between(key: Key, unit: str, fit: Fitted | TwoLevels | None) -> Row:
    """Return the row of a scatter between readings; what is hardly seen may be zero, and its interval says so."""
    if fit is None:
        return _absent_row(key, unit, NO_LEVEL)
    row = _scatter(key, unit, fit.between, fit.between_dof)
    return row if row.value is None else row.changed(interval=Interval(*fit.between_interval))


def used_angles(result: Result) -> Array:
    """Return the errors of the transitions that are in the fit [rad]."""
    gyro = result.gyro
    if gyro is None or gyro.rotated is None:
        return np.empty(0)
    return np.asarray(gyro.angles[~gyro.rotated.outliers[: len(gyro.angles)]])


@lru_cache(maxsize=16)
def units_of(kind: Kind, count: int) -> tuple[str, ...]:
    """Return the units of so many numbers, 12 or 21, in the order of ``linear_sensor``."""
    unit = UNIT[kind]
    matrix = tuple("1" if key.quantity == ERROR else "rad" for key in MATRIX)
    return (*matrix, *(unit,) * 3, *(normalise(f"({unit})/(m/s^2)"),) * 9)[:count]


def quantities(numbers: Array) -> tuple[Array, Array]:
    """Return the quantities of sensors, in the order of their numbers, and their derivatives by these.

    Parameters
    ----------
    numbers : ndarray, shape (..., q)
        Of each sensor.
    """
    values, derivative = numbers.copy(), np.empty((*numbers.shape, numbers.shape[-1]))
    derivative[:] = np.eye(numbers.shape[-1])
    for i in range(3):
        own = numbers[..., 4 * i]
        values[..., 4 * i] = own - 1.0
        for j in range(3):
            if j != i:
                at = 3 * i + j
                values[..., at] = numbers[..., at] / own
                derivative[..., at, at] = 1.0 / own
                derivative[..., at, 4 * i] = -values[..., at] / own
    return values, derivative


def estimate(sensor: LinearSensor, kind: Kind, output_unit: str) -> Estimate | None:
    """Return the estimate of a sensor; None where nothing is determined.

    Parameters
    ----------
    sensor : LinearSensor
        As it was fitted, relative to its ideal scale factor and zero.
    kind : {"accelerometer", "gyro"}
        What it senses.
    output_unit : str
        Of the readings; where they are not in SI, scale factors in it come first.
    """
    return estimate_many([(sensor, kind, output_unit)])[0]


def estimate_many(given: Sequence[tuple[LinearSensor, Kind, str]]) -> list[Estimate | None]:
    """Return what `estimate` gives of each of many sensors; those of which alike is known are worked out at once."""
    alike: dict[object, list[int]] = {}
    for k, (sensor, kind, unit) in enumerate(given):
        own = sensor.temperature
        sources = sensor.sources if own is None else own.sources
        alike.setdefault(
            (
                kind, unit, len(sensor.values), tuple(sensor.reasons.items()), None if own is None else own.keys,
                tuple((one.name, one.kind, one.level, id(one.influence), id(one.off), np.ndim(one.dof), one.unknowns,
                       None if one.changes is None else len(one.changes)) for one in sources),
            ),
            [],
        ).append(k)  # fmt: skip
    found: list[Estimate | None] = [None] * len(given)
    for at in alike.values():
        _, kind, unit = given[at[0]]
        for k, one in zip(at, _estimates([given[k][0] for k in at], kind, unit), strict=True):
            found[k] = one
    return found


def _estimates(sensors: Sequence[LinearSensor], kind: Kind, output_unit: str) -> Sequence[Estimate | None]:
    """Return the estimates of sensors of which the same is known, from the same sources."""
    first, count = sensors[0], len(sensors)
    values, derivative = quantities(np.array([one.values for one in sensors]))
    names = [*MATRIX, *BIAS, *G_SENSITIVITY][: values.shape[1]]
    units = list(units_of(kind, values.shape[1]))
    each = [one.sources for one in sensors]
    if first.temperature is not None:
        over = [one.temperature for one in sensors if one.temperature is not None]
        values = np.hstack([values, np.array([one.values.ravel() for one in over])])
        more = over[0].values.size
        derivative = np.array([linalg.block_diag(one, np.eye(more)) for one in derivative])
        names, units = [*names, *over[0].keys], [*units, *over[0].units]
        each = [one.sources for one in over]
    if output_unit != UNIT[kind]:
        rows = np.zeros((count, 3, derivative.shape[2]))
        ideal = np.array([one.ideal for one in sensors])
        rows[:, np.arange(3), 4 * np.arange(3)] = ideal
        values = np.hstack([ideal * np.array([np.diag(one.matrix) for one in sensors]), values])
        derivative = np.concatenate([rows, derivative], axis=1)
        names, units = [*SCALE, *names], [f"{output_unit}/({UNIT[kind]})"] * 3 + units
    why = reasons(first)
    determined = [k for k, name in enumerate(names) if not why.get(name)]
    if not determined or not each[0]:
        return [None] * count
    by_numbers = derivative[:, determined]
    sources = [_joint_source([own[s] for own in each], by_numbers) for s in range(len(each[0]))]
    keys, known_units = tuple(names[k] for k in determined), tuple(normalise(units[k]) for k in determined)
    made = []
    for one in Estimate.of_each([keys] * count, values[:, determined], [known_units] * count, sources):
        if isinstance(one, DataError):
            raise one
        made.append(one)
    return made


def _joint_source(sources: Sequence[Source], by_numbers: Array) -> Sources:
    """Return one source of the figures of many sensors, by its source of the numbers of each.

    Parameters
    ----------
    sources : sequence of Source
        Of each sensor.
    by_numbers : ndarray, shape (sensors, k, q)
        Derivatives of the figures by the numbers.
    """
    first, size_of = sources[0], np.abs(by_numbers)
    covariance, back = np.array([one.covariance for one in sources]), by_numbers.swapaxes(1, 2)
    whole = by_numbers @ covariance @ back
    size = np.sum((size_of @ np.abs(covariance)) * size_of, axis=2)
    moved = whole.diagonal(axis1=1, axis2=2) > ROUNDING * size  # else by rounding alone
    covariances = np.where(moved[:, :, None] & moved[:, None], 0.5 * (whole + whole.swapaxes(1, 2)), 0.0)
    own, least = {np.inf if np.ndim(one.dof) else float(one.dof) for one in sources}, np.empty(0)
    if np.ndim(first.dof):
        parts = by_numbers**2 * covariance.diagonal(axis1=1, axis2=2)[:, None]
        matters = (by_numbers != 0.0) & (parts >= NEGLIGIBLE * parts.max(axis=2, keepdims=True))
        dof = np.array([one.dof for one in sources], dtype=float)
        least = np.where(matters, dof[:, None], np.inf).min(axis=2)
    elif len(own) > 1:
        least = np.repeat([[float(one.dof)] for one in sources], by_numbers.shape[1], axis=1)
    known = first.off or first.influence
    stated = None if known is None else known.stated
    distribution = "t" if known is None else known.distribution
    kind: Literal["A", "B"] = "B" if first.kind == "B" else "A"
    origin = first.origin
    changes = None if first.changes is None else np.array([one.changes for one in sources]) @ back
    return Sources(origin, kind, covariances, least if least.size else own.pop(), distribution, stated, changes,
                   first.unknowns)  # fmt: skip


def reasons(sensor: LinearSensor) -> Mapping[Key, Reason]:
    """Return why a quantity is not estimated, by its key."""
    own = sensor.temperature
    return _reasons(tuple(sensor.reasons.items()), () if own is None else own.keys)


@lru_cache(maxsize=64)
def _reasons(given: tuple[tuple[int, Reason], ...], over: tuple[Key, ...]) -> Mapping[Key, Reason]:
    names, own = (*MATRIX, *BIAS, *G_SENSITIVITY), dict(given)
    found = {names[k]: reason for k, reason in given}
    found |= {key: own[i % 12] for i, key in enumerate(over) if i % 12 in own}
    for axis in AXES:
        reason = found.get(Key(ERROR, axis))
        if reason:
            found[Key("scale_factor", axis)] = reason
            for other in AXES:
                if other != axis:
                    found.setdefault(Key("misalignment", axis + other), reason)
    return MappingProxyType(found)


@dataclass(frozen=True, eq=False)
class Terms:
    """Parameters of the model of a sensor, for readings as they were recorded: their zero is in the bias."""

    kind: Kind  # What it senses
    estimate: Estimate  # Parameters that are estimated
    scale_factor: Array  # shape (3,): the ideal one [output unit/input unit]
    output_unit: str  # Of the readings
    input_range: Array  # shape (3, 2): least and largest input that was seen [input unit]
    not_estimated: Mapping[str, str]  # Parameter without uncertainty -> why
    values: Mapping[str, float]  # Those of them that are not 0
    over: OverTemperature | None  # How they change with temperature

    @property
    def is_possible(self) -> bool:
        """Whether no number is larger than anything is, nor lost."""
        sizes = np.abs([*self.estimate.values, *self.values.values(), *self.input_range.flat, *self.scale_factor])
        return bool(sizes.max() < IN_REACH and np.abs(self.scale_factor).min() > 1.0 / IN_REACH)

    @property
    def model(self) -> SensorModel:
        """The model."""
        over: dict[str, Any] = {}
        if self.over is not None:
            over = {"reference_temperature": np.full(3, self.over.reference), "temperature_range": self.over.range}
        return model_from(
            self.estimate,
            self.kind,
            AXES,
            scale_factor=self.scale_factor,
            output_unit=self.output_unit,
            input_range=self.input_range,
            not_estimated=self.not_estimated,
            values=self.values,
            **over,
        )


def terms_many(
    given: Sequence[tuple[LinearSensor, Kind, str, Array]], of_zero: Sequence[Estimate | None]
) -> list[Terms | None]:
    """Return the parameters of the models of many sensors; None where nothing is determined.

    Parameters
    ----------
    given : sequence of (LinearSensor, kind, output unit, ndarray)
        As `estimate_many` takes them, with least and largest input that was seen, shape (3, 2) [input unit].
    of_zero : sequence of Estimate or None
        What `estimate_many` gives: those of the models, too, where the readings for no input are taken as zero.
    """
    raw = [with_ideal(one, one.ideal, np.zeros(3)) if one.zero.any() else one for one, *_ in given]
    moved = [k for k, one in enumerate(raw) if one is not given[k][0]]
    estimates = [*of_zero]
    for k, one in zip(moved, estimate_many([(raw[k], *given[k][1:3]) for k in moved]), strict=True):
        estimates[k] = one
    return [
        None if found is None else _terms(sensor, found, kind, unit, ends)
        for sensor, found, (_, kind, unit, ends) in zip(raw, estimates, given, strict=True)
    ]


def _terms(sensor: LinearSensor, found: Estimate, kind: Kind, output_unit: str, input_range: Array) -> Terms:
    kept = [key for key in found.keys if key not in SCALE]
    own = found.select(kept)
    over = sensor.temperature
    units, absent, free = _absent(own.names, kind, tuple(sensor.reasons.items()), () if over is None else over.keys)
    held: dict[str, float] = {}
    if free:
        names = (str(key) for key in (*MATRIX, *BIAS, *G_SENSITIVITY))
        numbers = zip(names, quantities(sensor.values)[0].tolist(), strict=False)
        held = {name: one for name, one in numbers if name in free and one != 0.0}
    return Terms(kind, in_units(own, units), sensor.ideal, output_unit, input_range, absent, held, over)


@lru_cache(maxsize=64)  # the same of all units of which the same is known
def _absent(
    names: tuple[str, ...], kind: Kind, given: tuple[tuple[int, Reason], ...], over: tuple[Key, ...]
) -> tuple[tuple[str, ...], Mapping[str, str], frozenset[str]]:
    """Return the units of some parameters, why others are not among them, and which of those have a value even so."""
    why = {str(key): reason for key, reason in _reasons(given, over).items() if key not in SCALE}
    known = {one.name: one.unit for one in parameters_of(names, kind, AXES)}
    texts = {name: why[name].text if name in why else NOT_ESTIMATED for name in known if name not in names}
    free = {name for name in texts if name not in why or why[name].code == NOTHING_LEFT.code}
    return tuple(known[name] for name in names), MappingProxyType(texts), frozenset(free)


def curves(result: Result) -> list[Curve]:
    """Return the curves of ``results.json``, SI.

    ``positions``, a row a static interval: the unit vector ``up_x``, ``up_y``, ``up_z`` of specific force in body axes,
    the ``residual`` along it with the position in the fit, ``deletion`` from the fit without it, positive where it
    reads too much; of known orientations also what is left across gravity. ``transitions``, a row a rotation between
    two of them: the angle from where the gyros carry gravity to where the accelerometers find it, and the same without
    g-sensitivity in the model.
    """
    found = [positions_curve(result)] if result.sensor in ("", "accelerometer") else []
    if result.sensor in ("", "gyro") and result.gyro is not None and len(result.gyro.angles):
        found.append(transitions_curve(result, result.gyro))
    return found


def positions_curve(result: Result) -> Curve:
    """Return what every position leaves."""
    fitted, readings = result.acc, result.readings
    force = fitted.sensor.applied(readings.acc.mean)
    up = force / np.linalg.norm(force, axis=1)[:, None]
    columns = {"position": Column(np.arange(1.0, len(readings) + 1.0))}
    columns |= {f"up_{axis}": Column(up[:, i]) for i, axis in enumerate("xyz")}
    for name, values in (("residual", fitted.residuals), ("deletion", fitted.deletion)):
        columns[name] = Column(along(values, up), "m/s^2")
    if fitted.residuals.shape[1] == 3:
        level = np.einsum("kai,ki->ka", across(up), fitted.residuals)
        columns |= {f"residual_across_{i + 1}": Column(level[:, i], "m/s^2") for i in range(2)}
    between = np.nan if fitted.between is None else fitted.between
    columns["between"] = Column(np.full(len(readings), between), "m/s^2")
    columns["left_out"] = Column([bool(one) for one in fitted.outliers])
    columns["where"] = Column(list(readings.where) or [""] * len(readings))
    return Curve("positions", "", columns, sensor="accelerometer")


def along(values: Array, up: Array) -> Array:
    """Return residuals along gravity, shape (m,): of three components the part along it."""
    return np.asarray(values[:, 0] if values.shape[1] == 1 else np.sum(values * up, axis=1))


def transitions_curve(result: Result, gyro: FittedGyro) -> Curve:
    """Return what every rotation between two positions leaves; where the model has it, without g-sensitivity too."""
    k, transitions = len(gyro.angles), result.readings.transitions
    columns = {
        "rotation": Column(np.arange(1.0, k + 1.0)),
        "before": Column(np.array([one.before + 1.0 for one in transitions])),
        "after": Column(np.array([one.after + 1.0 for one in transitions])),
        "error": Column(gyro.angles, "rad"),
    }
    if gyro.rest.g_sensitivity is not None and gyro.rotated is not None:
        plan, sensor = replace(result.plan, g_sensitivity=False), gyro.sensor
        without = angles_left(plan, result.readings, result.acc, sensor.ideal, sensor.zero, gyro.rotated.W)
        columns["error_without"] = Column(without, "rad")
    left_out = np.zeros(k, dtype=bool) if gyro.rotated is None else gyro.rotated.outliers[:k]
    columns["left_out"] = Column([bool(one) for one in left_out])
    return Curve("transitions", "", columns, sensor="gyro")
