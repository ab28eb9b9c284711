"""Closed loop of a test of positions: readings held out, as they are and compensated.

Accelerometers: in every position held out the length of the specific force must be gravity, and where its direction is
known each component too. Gyros: each axis at rest must read the earth rate that is known, and in every rotation held
out gravity, carried by them, must arrive where the accelerometers find it. Squares of errors are paired by position or
rotation; the scatter of their differences says how well the mean is known. The verdict is that of all models
(``statistics.closed_loop``); what is common to fit and judgement cancels, but not a stated prior. Where both state
another mounting, the fixture's mounting counts as uncertainty, once for each.

Positions of one record count as independent, also where they share a power-up: what differs from power-up to power-up
is judged by as many draws as there are records held out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import permutations

import numpy as np
from scipy import special

from ...core.constants import EARTH_ROTATION_RATE
from ...core.estimate import Array
from ...core.key import AXES, Kind
from ...statistics.closed_loop import AxisLoop
from . import reduction as positions
from .fit.accelerometer import NOT_DETERMINED
from .fit.at_rest import earth_in_g
from .fit.gyro import FittedGyro, problem_of
from .fit.linear_sensor import LinearSensor
from .fit.over_temperature import at_reference
from .fit.prior import PRIORS
from .fit.rotations import ends_missed
from .readings import local_gravity

MOUNTING = "fixture.mounting"
OF_THE_FIT = {NOT_DETERMINED, *PRIORS.values()}  # Type B, but readings held out do not share them
Errors = Callable[[Array], Array]  # of the numbers of k models, (k, 12) or (k, 21): (k, n, c), n positions or rotations


@dataclass(frozen=True, eq=False)
class Judge:
    """One way in which readings held out judge a triad."""

    name: str  # For the table of the closed loop
    unit: str  # Of the errors
    errors: Errors  # From the numbers of models to the errors of each position or rotation
    free: int  # Numbers of the model that a fit takes from such errors
    # Whether the matrix shows in them; at rest next to nothing turns, and only bias and g-sensitivity do
    by_matrix: bool = True

    def tells(self, values: Array, other: Array) -> bool:
        """Whether the errors can tell two models apart."""
        return self.by_matrix or bool(np.all(values[:9] == other[:9]))


def loops_of(
    fitted: positions.Result, held: Sequence[positions.Readings], kind: Kind, remounted: bool = False
) -> tuple[AxisLoop, ...]:
    """Return what readings held out say of one sensor, without verdicts; empty where they cannot judge it.

    Parameters
    ----------
    fitted : positions.Result
        Of the test for a fit.
    held : sequence of Readings
        Held out, in the same units; one a record.
    kind : {"accelerometer", "gyro"}
        Which.
    remounted : bool
        The unit was laid anew in between.
    """
    fit = fitted.acc if kind == "accelerometer" else fitted.gyro
    if fit is None:
        return ()
    if fitted.acc.sensor.temperature is not None:
        held = [at_reference(fitted.acc.sensor, one) for one in held]
    own = {one.name: one for one in judges_of(fitted, fitted.readings, kind)}
    by_name: dict[str, list[Judge]] = {}
    for one in (one for readings in held for one in judges_of(fitted, readings, kind)):
        by_name.setdefault(one.name, []).append(one)

    def over_all_records(parts: Sequence[Judge]) -> Errors:
        return lambda values: np.concatenate([part.errors(values) for part in parts], axis=1)

    pooled = [replace(parts[0], errors=over_all_records(parts)) for parts in by_name.values()]
    return before_and_after(fit.sensor, fit.sensor.values, pooled, own, len(held), remounted)


def judges_of(fitted: positions.Result, held: positions.Readings, kind: Kind) -> tuple[Judge, ...]:
    """Return the ways in which readings judge one sensor."""
    if kind == "accelerometer":
        return accelerometer_judges(fitted, held)
    return () if fitted.gyro is None else gyro_judges(fitted, fitted.gyro, held)


def before_and_after(
    sensor: LinearSensor,
    values: Array,
    judges: Sequence[Judge],
    own: Mapping[str, Judge],
    runs: int,
    remounted: bool = False,
) -> tuple[AxisLoop, ...]:
    """Return what the numbers of a model do to readings held out, with the uncertainty of the sensor that was fitted.

    A mixed-up model is judged by the probability that it would do so much better if the model were right. Its error is
    that of the model and a known change: what scatters is the error of the model, as in the fit; the uncertainty of
    the model counts as scatter.

    Parameters
    ----------
    sensor : LinearSensor
        As it was fitted.
    values : ndarray, shape (12,) or (21,)
        The numbers to be judged: those of the sensor.
    judges : sequence of Judge
        Ways to judge.
    own : mapping of str to Judge
        The same of the readings of the fit, by name: they say how errors scatter.
    runs : int
        Records behind them.
    remounted : bool
        The unit was laid anew in between.
    """
    own_ones = (one.covariance for one in sensor.sources if one.kind == "A" or one.name in OF_THE_FIT)
    covariance = sum(own_ones, np.zeros((len(values),) * 2))
    variances, directions = np.linalg.eigh(0.5 * (covariance + covariance.T))
    steps = (directions * np.sqrt(np.maximum(variances, 0.0))).T[variances > 0.0]  # one u along each
    mountings = [
        one.changes for one in sensor.sources if one.name == MOUNTING and one.changes is not None and remounted
    ]
    laid = np.sqrt(2.0) * np.concatenate([np.empty((0, len(values))), *mountings])  # of the fit, and of those held out
    rivals = mixed_up(values, not set(range(9)) & set(sensor.reasons))
    raw = as_read(sensor)
    found = (_loop(one, own.get(one.name), sensor, values, raw, (steps, laid), rivals, runs) for one in judges)
    return tuple(one for one in found if one is not None)


def _loop(
    judge: Judge,
    own: Judge | None,
    sensor: LinearSensor,
    values: Array,
    raw: Array,
    steps: tuple[Array, Array],
    rivals: Mapping[str, Array],
    runs: int,
) -> AxisLoop | None:
    """Return what one judge says; None of a single reading."""
    named = {name: rival for name, rival in rivals.items() if judge.tells(values, rival)}
    models = np.vstack([values, raw, *(values + one for one in steps), *named.values()])
    errors = judge.errors(models)
    error, n = errors[0], errors.shape[1]
    if n < 2:
        return None
    changes = errors[1:] - error
    sizes = [len(one) for one in steps]
    by_raw, moved, by_rival = changes[0], changes[1 : 1 + sum(sizes)], changes[1 + sum(sizes) :]
    residuals = np.empty((0, 1)) if own is None else own.errors(sensor.values[None])[0]
    rows = int(np.sum(np.any(residuals != 0.0, axis=0))) * len(residuals)
    dof = float(max(rows - judge.free, 0))
    variance = float(np.sum(residuals**2)) / dof if dof else 0.0

    better = np.mean(_squares(error + by_rival) - _squares(error), axis=1)
    shift = 2.0 * np.einsum("rnc,snc->rs", by_rival, moved) / n
    whole = 4.0 * variance * np.sum(by_rival**2, axis=(1, 2)) / n**2 + np.sum(shift**2, axis=1)
    known = np.isfinite(whole) & (whole > 0.0) & (dof > 0.0)
    p = np.where(known, special.stdtr(dof, better / np.sqrt(np.where(known, whole, 1.0))), 1.0)

    before, after = _squares(errors[1]), _squares(error)
    gain = before - after
    by_laying = 2.0 * np.einsum("nc,snc->s", by_raw, moved[sizes[0] :]) / n
    return AxisLoop(
        judge.name,
        n,
        runs,
        float(np.sqrt(np.mean(before))),
        float(np.sqrt(np.mean(after))),
        float(np.mean(gain)),
        float(np.hypot(np.std(gain, ddof=1) / np.sqrt(n), np.linalg.norm(by_laying))),
        float(n - 1),
        float(np.sum(np.mean(_squares(moved), axis=1))),
        judge.unit,
        dict(zip(named, p.tolist(), strict=True)),
    )


def _squares(errors: Array) -> Array:
    return np.asarray(np.sum(errors**2, axis=-1))


def accelerometer_judges(fitted: positions.Result, held: positions.Readings) -> tuple[Judge, ...]:
    """Return the length of gravity in each position; where its direction is known, each axis too [m/s^2]."""
    g, sensor = local_gravity(fitted.plan), fitted.acc.sensor
    reading = sensor.normalised(held.acc.mean)

    def length(values: Array) -> Array:
        return np.asarray(np.linalg.norm(_inputs(values, reading), axis=2) - g)[:, :, None]

    found = [Judge("accelerometer", "m/s^2", length, 9)]
    if held.direction is None or fitted.readings.direction is None:
        return tuple(found)
    known = np.isfinite(held.direction).all(axis=1)
    expected = g * held.direction[known]
    for k, axis in enumerate(AXES):
        found.append(Judge(f"accelerometer {axis}", "m/s^2", partial(_along, reading[known], expected, k), 4))
    return tuple(found)


def gyro_judges(fitted: positions.Result, gyro: FittedGyro, held: positions.Readings) -> tuple[Judge, ...]:
    """Return the rate of each axis at rest [rad/s], and of each rotation the angle that is missed [rad]."""
    if held.gyro is None:
        return ()
    force = fitted.acc.sensor.applied(held.acc.mean)
    reading = gyro.sensor.normalised(held.gyro.mean)
    latitude = fitted.plan.latitude
    rate = 0.0 if latitude is None else float(EARTH_ROTATION_RATE.value * np.sin(latitude))
    earth = rate * force / np.linalg.norm(force, axis=1)[:, None]
    found = [
        Judge(f"gyro {axis} at rest", "rad/s", partial(_along, reading, earth, k, force=force), 4, by_matrix=False)
        for k, axis in enumerate(AXES)
    ]

    plain = replace(gyro.rest, bias=np.zeros(3))
    if plain.g_sensitivity is not None:
        plain = replace(plain, g_sensitivity=np.zeros((3, 3)))

    def missed(values: Array) -> Array:
        """Return the errors of each rotation: two of a transition, three of a turn by a known angle."""
        problem = problem_of(fitted.plan, held, fitted.acc, plain, gyro.sensor.ideal, gyro.sensor.zero)
        A, G = values[:, :9].reshape(-1, 3, 3), np.zeros((len(values), 3, 3))
        if plain.g_sensitivity is not None:
            G = values[:, 12:].reshape(-1, 3, 3) + (0.0 if latitude is None else earth_in_g(fitted.plan, A)[0])
        of_moves, of_turns = ends_missed(problem, np.asarray(np.linalg.inv(A), dtype=np.float64), values[:, 9:12], G)
        return np.concatenate([np.pad(of_moves, ((0, 0), (0, 0), (0, 1))), of_turns], axis=1)

    if gyro.rotated is not None and held.rotations:
        found.append(Judge("gyro, rotations", "rad", missed, 9))
    return tuple(found)


def _inputs(values: Array, reading: Array, force: Array | None = None) -> Array:
    """Return what models find from readings, shape (k, n, 3)."""
    without = reading - values[:, None, 9:12]
    if force is not None and values.shape[1] > 12:
        without = without - force @ np.swapaxes(values[:, 12:].reshape(-1, 3, 3), 1, 2)
    return np.asarray(without @ np.swapaxes(np.linalg.inv(values[:, :9].reshape(-1, 3, 3)), 1, 2))


def _along(reading: Array, expected: Array, k: int, values: Array, force: Array | None = None) -> Array:
    return (_inputs(values, reading, force) - expected)[:, :, [k]]


def as_read(sensor: LinearSensor) -> Array:
    """Return the numbers of no compensation at all."""
    values = np.zeros_like(sensor.values)
    values[:9] = np.eye(3).ravel()
    return values


def mixed_up(values: Array, full: bool) -> Mapping[str, Array]:
    """Return the numbers of a model with one mistake in it, by the name of the mistake.

    Parameters
    ----------
    values : ndarray, shape (12,) or (21,)
        Of the model.
    full : bool
        Whether all nine entries of the matrix were estimated.
    """
    A, b, G = values[:9].reshape(3, 3), values[9:12], values[12:].reshape(-1, 3)

    def form(matrix: Array, bias: Array, sensitivity: Array) -> Array:
        return np.concatenate([matrix.ravel(), bias, sensitivity.ravel()])

    found = {"the matrix with its sign turned": form(2.0 * np.eye(3) - A, b, G)}
    found["the bias with its sign turned"] = form(A, -b, G)
    if full:
        found["the transposed matrix"] = form(A.T, b, G)
    if G.size:
        found["g-sensitivity with its sign turned"] = form(A, b, -G)
        found["the transposed g-sensitivity"] = form(A, b, G.T)
    for order in list(permutations(range(3)))[1:]:
        places = ", ".join(f"{AXES[i]} for {AXES[j]}" for j, i in enumerate(order) if i != j)
        found[f"the bias with {places}"] = form(A, b[list(order)], G)
        if full:
            found[f"the matrix with {places}"] = form(A[np.ix_(order, order)], b, G)
    return found
