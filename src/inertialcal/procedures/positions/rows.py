"""Rows of a result of positions: every quantity with its uncertainty, or the reason why there is none.

The sensor of the key says whose: ``accelerometer`` or ``gyro``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy import linalg

from ...core.curve import Column, Curve
from ...core.estimate import Array, Component, Estimate
from ...core.key import AXES, Key, Kind, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...core.units import normalise
from ...sensors.model.assemble import model_from
from ...sensors.model.sensor_model import SensorModel
from ...statistics.intervals import chi_square_interval, t_interval
from ...statistics.two_levels import TwoLevels
from .fit.accelerometer import OF_FRAME, Fitted
from .fit.fixture import FACE_FOUND, LAYING_FOUND
from .fit.gyro import NOTHING_LEFT, FittedGyro, angles_left
from .fit.linear_sensor import BIAS, FEWEST, G_SENSITIVITY, MATRIX, LinearSensor, with_ideal
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
    count = len(sensor.values)
    wanted = list(zip((*MATRIX, *BIAS, *G_SENSITIVITY)[:count], units_of(kind, count), strict=True))
    if sensor.temperature is not None:
        wanted += list(zip(sensor.temperature.keys, sensor.temperature.units, strict=True))
    if unit != UNIT[kind]:
        wanted = [(name, f"{unit}/({UNIT[kind]})") for name in SCALE] + wanted
    why = {**reasons(sensor)}
    if unit != UNIT[kind] and not result.plan.states_scale(kind):
        for axis, size in zip(AXES, sensor.ideal, strict=True):
            what = f"no nominal scale factor was stated to differ from; errors of the model refer to {size:.4g} "
            reason = Reason("no_nominal", f"{what}{unit}/({UNIT[kind]})")
            for key, _ in wanted:
                if key.quantity in RELATIVE and key.axis[0] == axis:
                    why.setdefault(key, reason)
    limits = Reason("relative", "relative to the fixture") if missing(result) else Reason()
    found = []
    for name, own in wanted:
        key = name._replace(sensor=kind)
        if (name.quantity in RELATIVE and name in why) or estimate is None or name not in estimate.keys:
            found.append(not_estimated(key, own, why.get(name, NO_LEVEL)))
            continue
        k = estimate.index(name)
        value, u, dof = float(estimate.values[k]), float(estimate.u[k]), float(estimate.dof[k])
        finite = dof if np.isfinite(dof) else None
        found.append(Row(key, value, u, estimate.units[k], finite, t_interval(value, u, dof), reason=limits))
    return found + _next_rows(result, [row for row in found if row.key.quantity == "bias"])


def _next_rows(result: Result, now: Sequence[Row]) -> list[Row]:
    """Return the bias of the record that comes next, by that of this one."""
    found = []
    for k, row in enumerate(now):
        key = row.key._replace(quantity="bias_next_record")
        onward = result.next_record.get(row.key.sensor, NO_LEVEL)
        if row.value is None or isinstance(onward, Reason):
            why = row.reason if row.value is None else onward
            found.append(not_estimated(key, row.unit, why if isinstance(why, Reason) else NO_LEVEL))
            continue
        u, dof = float(onward.u[k]), float(onward.dof[k])
        found.append(replace(row, key=key, u=u, dof=dof, interval=t_interval(row.value, u, dof)))
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
        return not_estimated(key, unit, NO_LEVEL)
    if dof < FEWEST:
        return not_estimated(key, unit, NOT_SEEN)
    u = std / float(np.sqrt(2.0 * dof))
    return Row(key, std, u, unit, dof, chi_square_interval(std, dof))


def _between(key: Key, unit: str, fit: Fitted | TwoLevels | None) -> Row:
    """Return the row of a scatter between readings; what is hardly seen may be zero, and its interval says so."""
    if fit is None:
        return not_estimated(key, unit, NO_LEVEL)
    row = _scatter(key, unit, fit.between, fit.between_dof)
    return row if row.value is None else replace(row, interval=Interval(*fit.between_interval))


def used_angles(result: Result) -> Array:
    """Return the errors of the transitions that are in the fit [rad]."""
    gyro = result.gyro
    if gyro is None or gyro.rotated is None:
        return np.empty(0)
    return np.asarray(gyro.angles[~gyro.rotated.outliers[: len(gyro.angles)]])


def units_of(kind: Kind, count: int) -> tuple[str, ...]:
    """Return the units of so many numbers, 12 or 21, in the order of ``linear_sensor``."""
    unit = UNIT[kind]
    matrix = tuple("1" if key.quantity == ERROR else "rad" for key in MATRIX)
    return (*matrix, *(unit,) * 3, *(normalise(f"({unit})/(m/s^2)"),) * 9)[:count]


def quantities(sensor: LinearSensor) -> tuple[Array, Array]:
    """Return the quantities, in the order of the numbers, and their derivatives by these."""
    values, derivative = sensor.values.copy(), np.eye(len(sensor.values))
    for i in range(3):
        own = sensor.values[4 * i]
        values[4 * i] = own - 1.0
        for j in range(3):
            if j != i:
                at = 3 * i + j
                values[at] = sensor.values[at] / own
                derivative[at, at] = 1.0 / own
                derivative[at, 4 * i] = -values[at] / own
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
    values, derivative = quantities(sensor)
    names = [*MATRIX, *BIAS, *G_SENSITIVITY][: len(values)]
    units = list(units_of(kind, len(values)))
    own, sources = sensor.temperature, sensor.sources
    if own is not None:
        values, sources = np.concatenate([values, own.values.ravel()]), own.sources
        derivative = linalg.block_diag(derivative, np.eye(own.values.size))
        names, units = [*names, *own.keys], [*units, *own.units]
    if output_unit != UNIT[kind]:
        rows = np.zeros((3, len(values)))
        rows[np.arange(3), 4 * np.arange(3)] = sensor.ideal
        values = np.concatenate([sensor.ideal * np.diag(sensor.matrix), values])
        derivative = np.vstack([rows, derivative])
        names, units = [*SCALE, *names], [f"{output_unit}/({UNIT[kind]})"] * 3 + units
    why = reasons(sensor)
    determined = [k for k, name in enumerate(names) if not why.get(name)]
    if not determined or not sources:
        return None
    by_numbers = derivative[determined]
    components = []
    for one in sources:
        whole = by_numbers @ one.covariance @ by_numbers.T
        size = np.diag(np.abs(by_numbers) @ np.abs(one.covariance) @ np.abs(by_numbers).T)
        moved = np.diag(whole) > ROUNDING * size  # else by rounding alone
        covariance = np.asarray(np.where(np.outer(moved, moved), 0.5 * (whole + whole.T), 0.0))
        dof = np.asarray(one.dof, dtype=float)
        parts = by_numbers**2 * np.diag(one.covariance)
        matters = (by_numbers != 0.0) & (parts >= NEGLIGIBLE * parts.max(axis=1, keepdims=True))
        least: Array | float = (
            float(dof) if not dof.ndim else np.array([dof[row].min(initial=np.inf) for row in matters])
        )
        known = one.off or one.influence
        stated = None if known is None else known.stated
        distribution = "t" if known is None else known.distribution
        kind_of: Literal["A", "B"] = "B" if one.kind == "B" else "A"
        changes = None if one.changes is None else one.changes @ by_numbers.T
        components.append(
            Component(one.origin, kind_of, covariance, least, distribution, stated, changes, one.unknowns)
        )
    known_units = tuple(normalise(units[k]) for k in determined)
    return Estimate(tuple(names[k] for k in determined), values[determined], known_units, tuple(components))


def reasons(sensor: LinearSensor) -> Mapping[Key, Reason]:
    """Return why a quantity is not estimated, by its key."""
    names = (*MATRIX, *BIAS, *G_SENSITIVITY)
    found = {names[k]: reason for k, reason in sensor.reasons.items()}
    if sensor.temperature is not None:
        keys = sensor.temperature.keys
        found |= {key: sensor.reasons[i % 12] for i, key in enumerate(keys) if i % 12 in sensor.reasons}
    for axis in AXES:
        reason = found.get(Key(ERROR, axis))
        if reason:
            found[Key("scale_factor", axis)] = reason
            for other in AXES:
                if other != axis:
                    found.setdefault(Key("misalignment", axis + other), reason)
    return found


def model(
    sensor: LinearSensor, kind: Kind, output_unit: str, input_range: Array, of_zero: Estimate | None
) -> SensorModel | None:
    """Return the model for readings as they were recorded, their zero in the bias; None where nothing is determined.

    Parameters
    ----------
    sensor, kind, output_unit
        As `estimate` takes them.
    input_range : ndarray, shape (3, 2)
        Least and largest input that was seen [input unit].
    of_zero : Estimate or None
        What `estimate` gives: that of the model, too, where the readings for no input are taken as zero.
    """
    raw = with_ideal(sensor, sensor.ideal, np.zeros(3)) if np.any(sensor.zero) else sensor
    found = of_zero if raw is sensor else estimate(raw, kind, output_unit)
    if found is None:
        return None
    kept = [key for key in found.keys if key not in SCALE]
    why = {str(key): reason.text for key, reason in reasons(raw).items() if key not in SCALE}
    judged = {key for key, reason in reasons(raw).items() if reason.code != NOTHING_LEFT.code}
    names, numbers = (*MATRIX, *BIAS, *G_SENSITIVITY), quantities(raw)[0]
    own = sensor.temperature
    over: dict[str, Any] = {}
    if own is not None:
        over = {"reference_temperature": np.full(3, own.reference), "temperature_range": own.range}
    values = {str(key): float(one) for key, one in zip(names, numbers, strict=False) if key not in {*kept, *judged}}
    return model_from(
        found.select(kept),
        kind,
        AXES,
        scale_factor=raw.ideal,
        output_unit=output_unit,
        input_range=input_range,
        not_estimated=why,
        values=values,
        **over,
    )


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
