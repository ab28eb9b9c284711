"""Six faces and three turns in closed form, as Ferraris, Grimaldi and Parvis published it [1]_.

Every reading counts alike, nothing is left out, the earth's rotation is ignored and there is no uncertainty. It stands
next to the default with ``Method.TEXTBOOK``. In columns, one for each axis that points up, or is turned
about::

    b_a = diag(U_p + U_n) / 2     K_a R_a = (U_p - U_n) / (2 g)      K: scale factors, R: direction cosines (rows unit)
    K_ga = (U_g,p - U_g,n) / (2 g)       b_g = mean of all samples at rest
    K_g R_g = sums of (reading - b_g - K_ga f) over the sample rate, column k over the angle of turn k

References
----------
.. [1] F. Ferraris, U. Grimaldi and M. Parvis, Procedure for effortless in-field calibration of three-axis rate gyros
   and accelerometers, Sensors and Materials 7 (1995) 311-330, eq. (9) to (23).
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES, Key, Method, Reason
from ...core.results import Row
from ...core.units import normalise
from .readings import Readings

REASON = Reason("no_uncertainty", "the closed form has no uncertainty")
UNIT = {"accelerometer": "m/s^2", "gyro": "rad/s"}
ALONG = 0.999  # cosine of the angle from an axis


@dataclass(frozen=True, eq=False)
class Ferraris:
    """Scale factors K (diagonal, (3,)), direction cosines R (3, 3), biases b, g-sensitivity K_ga; gyros in radians.

    ``reading = K R x + b`` of the accelerometers, ``K R w + K_ga f + b`` of the gyros.
    """

    K_a: Array
    R_a: Array
    b_a: Array
    K_g: Array
    R_g: Array
    K_ga: Array
    b_g: Array


def ferraris(readings: Readings, gravity: float) -> Ferraris:
    """Return the closed form.

    Parameters
    ----------
    readings : Readings
        Six faces, each once, and three turns about the axes.
    gravity : float
        [m/s^2]

    Raises
    ------
    DataError
        ``not_ferraris`` if a face or a turn is missing.
    """
    if readings.gyro is None:
        raise _missing("gyros")
    K_a, R_a, b_a = six_faces(readings, gravity)
    gyro_up, gyro_down = _faces(readings, readings.gyro.mean)
    K_ga = (gyro_up - gyro_down) / (2.0 * gravity)
    b_g = np.average(readings.gyro.mean, axis=0, weights=readings.gyro.samples)
    inverse = np.linalg.inv(K_a[:, None] * R_a)
    sums = np.empty((3, 3))
    for k, axis in enumerate(AXES):
        about = [one for one in readings.turns if one.axis is not None and abs(one.axis[k]) > ALONG]
        if len(about) != 1:
            raise _missing(f"{len(about)} turn(s) about {axis}, need one")
        one, vector = about[0], np.asarray(about[0].axis)
        angle = float((one.angle or 0.0) * np.sign(vector[np.argmax(np.abs(vector))]))
        force = np.zeros_like(one.gyro) if one.acc is None else (one.acc - b_a) @ inverse.T
        interval = np.full(len(one.seconds), one.seconds[-1] / (len(one.seconds) - 1))
        if one.missing:  # a gap is bridged by the samples on both sides of it
            interval = np.gradient(one.seconds)
        sums[:, k] = interval @ (one.gyro - b_g - force @ K_ga.T) / angle
    K_g, R_g = _split(sums)
    return Ferraris(K_a, R_a, b_a, K_g, R_g, K_ga, b_g)


def six_faces(readings: Readings, gravity: float) -> tuple[Array, Array, Array]:
    """Return the part of the closed form that is about accelerometers: K, shape (3,), R, shape (3, 3), b, shape (3,).

    Parameters
    ----------
    readings : Readings
        Six faces, each once.
    gravity : float
        [m/s^2]

    Raises
    ------
    DataError
        ``not_ferraris`` if a face is missing, or laid twice.
    """
    if readings.direction is None:
        raise _missing("known positions")
    up, down = _faces(readings, readings.acc.mean)
    K_a, R_a = _split((up - down) / (2.0 * gravity))
    return K_a, R_a, 0.5 * np.diag(up + down)


def published_rows(readings: Readings, gravity: float) -> list[Row]:
    """Return the closed form as rows, in the unit of the readings; none without the faces or turns.

    ``scale_factor`` is K, ``direction_cosine`` R, ``bias`` b and ``g_sensitivity`` K_ga; the key has the sensor.
    Six faces are enough for the accelerometers.
    """
    found: list[Row] = []
    if readings.direction is None:
        return found
    with suppress(DataError):  # other positions than its six faces
        K, R, b = six_faces(readings, gravity)
        found += _form_rows("accelerometer", readings.acc.unit, {"scale_factor": K, "direction_cosine": R, "bias": b})
    with suppress(DataError):  # no gyros, or other turns
        form = ferraris(readings, gravity)
        unit = "" if readings.gyro is None else readings.gyro.unit
        found += _form_rows("gyro", unit, {"scale_factor": form.K_g, "direction_cosine": form.R_g, "bias": form.b_g})
        found += _form_rows("gyro", normalise(f"({unit})/(m/s^2)"), {"g_sensitivity": form.K_ga})
    return found


def _form_rows(kind: str, unit: str, values: dict[str, Array]) -> list[Row]:
    """Return the rows of one sensor, row by row of each matrix."""
    ratio = "1" if unit == UNIT[kind] else normalise(f"({unit})/({UNIT[kind]})")
    units = {"scale_factor": ratio, "direction_cosine": "1"}
    rows = []
    for quantity, numbers in values.items():
        axes = AXES if numbers.ndim == 1 else [a + b for a in AXES for b in AXES]
        rows += [
            Row(Key(quantity, axis, kind), float(value), None, units.get(quantity, unit), reason=REASON,
                method=Method.TEXTBOOK)
            for axis, value in zip(axes, numbers.ravel(), strict=True)
        ]  # fmt: skip
    return rows


def _split(matrix: Array) -> tuple[Array, Array]:
    """Return lengths of the rows, and the rows of length one."""
    K = np.sqrt(np.sum(matrix**2, axis=1))
    return K, matrix / K[:, None]


def _faces(readings: Readings, values: Array) -> tuple[Array, Array]:
    """Return means with each axis up, and down, in columns, each shape (3, 3)."""
    assert readings.direction is not None  # noqa: S101 - the caller has looked
    found = []
    for sign in (1.0, -1.0):
        columns = []
        for k, axis in enumerate(AXES):
            at = np.flatnonzero(sign * readings.direction[:, k] > ALONG)
            if len(at) != 1:
                raise _missing(f"{len(at)} position(s) with {axis} {'up' if sign > 0 else 'down'}, need one")
            columns.append(values[at[0]])
        found.append(np.column_stack(columns))
    return found[0], found[1]


def _missing(what: str) -> DataError:
    return DataError(what, why="the closed form takes six faces and three turns, each once", code="not_ferraris")
