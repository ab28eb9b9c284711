"""A three-axis gyro on the axis of a table, from the motion to the codes that a logger saves.

Frames: body axes are those of the unit's marks. While body axis i is turned, i lies along the table's z, the next
axis (cyclic) along its x and the one after along its y, but for the small rotation of the mounting. ``mounting``
takes body to sensor axes: a sensor that is mounted inverted has -1 there, and its bias is told in the sense of the
body. The true input is the rate against inertial space: table and earth.

A saved code is the mean of ``averaged`` conversions, a multiple of 1 / averaged of a step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from ...core.estimate import Array
from ...physics.earth import earth_rate_in_dwell
from ...sensors.chain.conversion import to_counts
from ...sensors.chain.converter import Chain
from ...sensors.model.equation import predict
from ...sensors.model.sensor_model import SensorModel
from .noise import random_walk, white


@dataclass(frozen=True, eq=False)
class Gyro:
    """A unit with its scatter."""

    model: SensorModel  # sensor equation without scatter
    mounting: Array  # sensor from body, (3, 3)
    run_bias_std: float  # bias scatter from power-up to power-up [rad/s]
    run_scale_std: float  # scale-factor scatter from power-up to power-up (1)
    dwell_std: float  # bias scatter from dwell to dwell [rad/s]
    sample_std: float  # white noise of an average [rad/s]
    walk: float = 0.0  # rate random walk [rad/s/sqrt(s)]


def powered_up(gyro: Gyro, rng: np.random.Generator) -> Gyro:
    """Return the unit as it is in one run: with a bias and scale factors of its own."""
    model = gyro.model
    k = len(model.axes)
    bias = model.bias + rng.normal(0.0, gyro.run_bias_std, k)
    scale = 1.0 + rng.normal(0.0, gyro.run_scale_std, k)
    return replace(gyro, model=replace(model, bias=bias, matrix=scale[:, np.newaxis] * model.matrix))


def mounted(axis: int, angles: tuple[float, float]) -> Array:
    """Return ``C_body_table`` at table angle zero, with the two small angles of the mounting.

    Parameters
    ----------
    axis : int
        Body axis along the table axis: 0, 1, 2.
    angles : (float, float)
        What the table axis has of the next body axis, and of the one after [rad].

    Returns
    -------
    ndarray, shape (3, 3)
    """
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    nominal = np.zeros((3, 3))
    nominal[[i, j, k], [2, 0, 1]] = 1.0
    turn = np.zeros(3)
    turn[j], turn[k] = -angles[1], angles[0]  # about k from i to j, against j from i to k
    return np.asarray(Rotation.from_rotvec(turn).as_matrix() @ nominal)


def body_rate(
    motion: Motion, table_gain: float, C_body_table: Array, latitude: float, C_table_level: Array, phase: float
) -> Array:
    """Return the rate of the unit against inertial space, mean over each window, shape (n, 3) [rad/s].

    Parameters
    ----------
    motion : Motion
        As commanded.
    table_gain : float
        True rate of the table over the commanded one.
    C_body_table : ndarray, shape (3, 3)
        From `mounted`.
    latitude : float
        Geodetic [rad].
    C_table_level : ndarray, shape (3, 3)
        From ``physics.earth.level_to_table``.
    phase : float
        Table angle where the recording begins [rad].
    """
    table = earth_rate_in_dwell(latitude, C_table_level, phase + table_gain * motion.angle, table_gain * motion.turned)
    table[:, 2] += table_gain * motion.rate
    return np.asarray(table @ C_body_table.T)


def readings(
    gyro: Gyro, rate: Array, motion: Motion, interval: float, averaging: float, rng: np.random.Generator
) -> Array:
    """Return what the sensors read of a rate along the body axes, in body axes, shape (n, 3) [rad/s]."""
    n, k = rate.shape
    dwells = rng.normal(0.0, gyro.dwell_std, (int(motion.dwell[-1]) + 1, k))
    found = predict(gyro.model, rate) + dwells[motion.dwell] + white(gyro.sample_std, n, k, rng)
    if gyro.walk > 0.0:
        found = found + random_walk(gyro.walk, n, k, interval, averaging, rng)
    return found


def averaged_codes(chain: Chain, values: Array, reference: Array, averaged: int) -> tuple[Array, Array]:
    """Return mean codes of readings and of the reference voltage, each a multiple of 1 / averaged, shape (n, k).

    Parameters
    ----------
    chain : Chain
        With ends, a scale factor and a measured reference.
    values : ndarray, shape (n, k)
        Along the sensor axes [input unit].
    reference : ndarray, shape (n, k)
        Voltage beside each signal [V].
    averaged : int
        Conversions that a saved code is the mean of.
    """
    lo, hi = chain.codes or (0, 0)
    fine = replace(chain, step=chain.step / averaged, codes=(lo * averaged, hi * averaged))
    beside = np.clip(np.rint(reference / fine.step), lo * averaged, hi * averaged)
    return to_counts(fine, values, reference=beside) / averaged, beside / averaged


@dataclass(frozen=True, eq=False)
class Motion:
    """What the table does in each averaging window; all of shape (n,)."""

    start: Array  # start of the window, from the start of the recording [s]
    rate: Array  # mean rate over the window [rad/s]
    angle: Array  # at the start of the window [rad]
    turned: Array  # from start to end of the window [rad]
    dwell: NDArray[np.int64]  # dwell in which the window begins, or to which it ramps


def motion(rates: ArrayLike, dwell: float, ramps: ArrayLike, interval: float, averaging: float) -> Motion:
    """Return the motion of a table that goes through set rates.

    Parameters
    ----------
    rates : array_like, shape (d,)
        Of the dwells, in order [rad/s].
    dwell : float
        Length of each [s].
    ramps : array_like, shape (d - 1,)
        Time from each rate to the next [s].
    interval, averaging : float
        Time from save to save, and length of the window that is averaged [s].
    """
    held = np.repeat(np.asarray(rates, dtype=np.float64), 2)
    begin = np.concatenate([[0.0], np.cumsum(dwell + np.asarray(ramps, dtype=np.float64))])
    knots = np.column_stack([begin, begin + dwell]).ravel()  # start and end of each dwell in turn
    start = np.asarray(interval * np.arange(int((knots[-1] - averaging) / interval) + 1), dtype=np.float64)
    angle = _angle(knots, held, start)
    turned = _angle(knots, held, start + averaging) - angle
    within = np.searchsorted(knots[1::2], start, side="right")
    return Motion(start, turned / averaging, angle, turned, np.minimum(within, len(begin) - 1))


def _angle(knots: Array, rates: Array, at: Array) -> Array:
    """Angle at given times of a rate that is linear between knots, shape (n,) [rad]."""
    passed = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(knots))])
    before = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    since = at - knots[before]
    return np.asarray(passed[before] + 0.5 * (rates[before] + np.interp(at, knots, rates)) * since)
