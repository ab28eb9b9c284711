"""What positions and rotations held out say of a triad: errors as functions of its matrix, bias and g-sensitivity.

The numbers are those of ``procedures.positions.fit.linear_sensor``: A by rows, b, and G of gyros;
``reading = Ax + b + Gf`` where a reading is (output - zero) / ideal scale factor. So readings as they are have
A = 1, b = 0 and G = 0, and a model that is mixed up is another vector of the same numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import permutations

import numpy as np

from ....core.axes import AXES
from ....core.constants import EARTH_ROTATION_RATE
from ....core.estimate import Array
from .. import reduction as positions
from ..fit.earth_rate import earth_in_g
from ..fit.gyro import FittedGyro, problem_of
from ..fit.linear_sensor import LinearSensor
from ..fit.rotation_errors import errors
from ..gravity import local_gravity

Errors = Callable[[Array], Array]  # of the numbers of the model: one row a position or rotation


@dataclass(frozen=True, eq=False)
class Judge:
    """One way in which readings held out judge a triad.

    Parameters
    ----------
    name : str
        For the table of the closed loop.
    unit : str
        Of the errors.
    errors : callable
        From the numbers of a model to the errors of each position or rotation, shape (n, c).
    free : int
        Numbers of the model that a fit takes from such errors.
    by_matrix : bool
        Whether the matrix shows in them; at rest next to nothing turns, and only bias and g-sensitivity do.
    """

    name: str
    unit: str
    errors: Errors
    free: int
    by_matrix: bool = True

    def tells(self, values: Array, other: Array) -> bool:
        """Whether the errors can tell two models apart."""
        return self.by_matrix or bool(np.all(values[:9] == other[:9]))


def of_accelerometers(fitted: positions.Result, held: positions.Readings) -> tuple[Judge, ...]:
    """Return the length of gravity in each position; where its direction is known, each axis too [m/s^2]."""
    g, sensor = local_gravity(fitted.plan), fitted.acc.sensor
    reading = sensor.normalised(held.acc.mean)

    def length(values: Array) -> Array:
        return np.asarray(np.linalg.norm(_inputs(values, reading), axis=1) - g)[:, None]

    found = [Judge("accelerometer", "m/s^2", length, 9)]
    if held.direction is None or fitted.readings.direction is None:
        return tuple(found)
    known = np.isfinite(held.direction).all(axis=1)
    expected = g * held.direction[known]
    for k, axis in enumerate(AXES):
        found.append(Judge(f"accelerometer {axis}", "m/s^2", partial(_along, reading[known], expected, k), 4))
    return tuple(found)


def of_gyros(fitted: positions.Result, gyro: FittedGyro, held: positions.Readings) -> tuple[Judge, ...]:
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
    if gyro.rotated is not None and held.rotations:
        found.append(Judge("gyro, rotations", "rad", partial(_missed, fitted, gyro, held), 9))
    return tuple(found)


def _inputs(values: Array, reading: Array, force: Array | None = None) -> Array:
    """Return what a model finds from readings, shape (n, 3)."""
    without = reading - values[9:12]
    if force is not None and len(values) > 12:
        without = without - force @ values[12:].reshape(3, 3).T
    return np.asarray(without @ np.linalg.inv(values[:9].reshape(3, 3)).T)


def _along(reading: Array, expected: Array, k: int, values: Array, force: Array | None = None) -> Array:
    return (_inputs(values, reading, force) - expected)[:, [k]]


def _missed(fitted: positions.Result, gyro: FittedGyro, held: positions.Readings, values: Array) -> Array:
    """Return the errors of each rotation: two of a transition, three of a turn by a known angle, shape (n, 3)."""
    A, G = values[:9].reshape(3, 3), values[12:].reshape(3, 3)
    at_rest = None if gyro.rest.g_sensitivity is None else G + earth_in_g(fitted.plan, A)[0]
    rest = replace(gyro.rest, bias=values[9:12], g_sensitivity=at_rest)
    problem = problem_of(fitted.plan, held, fitted.acc, rest, gyro.sensor.ideal, gyro.sensor.zero)
    rows = errors(problem, np.asarray(np.linalg.inv(A))).e
    moves, turns = problem.sizes
    of_moves = np.column_stack([rows[: 2 * moves].reshape(-1, 2), np.zeros(moves)])
    return np.vstack([of_moves, rows[2 * moves :].reshape(turns, 3)])


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
