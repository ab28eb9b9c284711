"""A three-axis gyro on the axis of a table, from the motion to the codes that a logger saves.

Frames: body axes are those of the unit's marks. While body axis i is turned, i lies along the table's z, the next
axis (cyclic) along its x and the one after along its y, but for the small rotation of the mounting. ``mounting``
takes body to sensor axes: a sensor that is mounted inverted has -1 there, and its bias is stated in the sense of the
body. The true input is the rate against inertial space: table and earth.

A saved code is the mean of ``averaged`` conversions, a multiple of 1 / averaged of a step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from ...core.campaign_text import Noted
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ...physics.earth import earth_rate_in_dwell, level_to_table
from ...sensors.chain.conversion import to_counts
from ...sensors.chain.converter import Chain
from ...sensors.model.equation import predict
from ...sensors.model.sensor_model import SensorModel
from ..twin import Drawn, DrawnError
from .campaign import Content, drawn_error, drawn_errors
from .noise import random_walk, white

INVERTED = (-1, 1, -1)  # x and z sensors are mounted against the body axes
STEP = 5.0 / 4095.0  # [V]
CODES = (0, 4095)
REFERENCE = 2.5  # [V]
SCALE_FACTOR_V_PER_DEG_S = 0.5
VOLTS_PER_RAD_S = float(SCALE_FACTOR_V_PER_DEG_S / np.radians(1.0))
VALID_VOLTS = 2.4  # of the built-in test
STANDARDS = {
    "rate_table.rate": Influence(3e-4, "1", certificate="simulated"),
    "rate_table.mounting": Influence(1e-3, "rad", certificate="simulated"),
    "converter.reference": Influence(1e-4, "1", certificate="simulated"),
    "site.latitude": Influence(1e-4, "rad", certificate="simulated"),
}
Stand = tuple[float, float, float, float]  # tilt, u, azimuth, u [deg]


def suite_table(averaged: int, **chain: object) -> Content:
    """Return the table of the sensors in campaign.toml, with more settings of their chain."""
    settings = {
        "kind": "adc",
        "lsb": "5 V / 4095",
        "counts": list(CODES),
        "reference": "channel",
        "scale_factor": f"{SCALE_FACTOR_V_PER_DEG_S:g} V/(deg/s)",
        "validity_minimum": f"{VALID_VOLTS:g} V",
        **chain,
    }
    mounting = [[sign if i == j else 0 for j in range(3)] for i, sign in enumerate(INVERTED)]
    codes = f"Codes are means of {averaged} conversions. A reading is valid while its built-in test is high."
    return {
        "kind": "gyro",
        "axes": list(AXES),
        "unit": "deg/s",
        "range": ["-5 deg/s", "5 deg/s"],
        "mounting": Noted(mounting, "sensor from body: x and z are mounted inverted"),
        "chain": Noted(settings, above=codes),
    }


@dataclass(frozen=True, eq=False)
class World:
    """What the engineer does not know of his bench: one unknown each for the whole campaign."""

    # true over nominal
    table_gain: float
    converter_gain: float
    thermometer: float  # error of the temperature channels [degC]
    latitude: float  # [rad]
    levels: dict[str, Array]  # from level to each place: ``"table"`` and others, (3, 3)
    C_body_table: dict[str, Array]  # for each turned axis, (3, 3)
    phase: dict[str, float]  # table angle of the index mark for each turned axis [rad]

    def body_rate(self, motion: Motion, axis: str) -> Array:
        """Return the rate of the unit while an axis is turned, as `body_rate`."""
        C_body_table, C_table_level = self.C_body_table[axis], self.levels["table"]
        return body_rate(motion, self.table_gain, C_body_table, self.latitude, C_table_level, self.phase[axis])


def draw_world(
    standards: Mapping[str, Influence],
    latitude_deg: float,
    table_gain: float,
    stands: Mapping[str, Stand],
    rng: np.random.Generator,
) -> tuple[World, Drawn]:
    """Return how the bench really is, and the same for the file of the truth; ``stands``: attitude of each place."""
    rate, converter, thermometer = (
        drawn_error(standards.get(name), rng)
        for name in ("rate_table.rate", "converter.reference", "thermometer.temperature")
    )
    latitude = float(np.radians(latitude_deg)) + drawn_error(standards.get("site.latitude"), rng)
    angles = {
        place: np.radians([rng.normal(tilt, u_tilt), rng.normal(azimuth, u_azimuth)])
        for place, (tilt, u_tilt, azimuth, u_azimuth) in stands.items()
    }
    mounting = standards.get("rate_table.mounting")
    pairs = {axis: (drawn_error(mounting, rng), drawn_error(mounting, rng)) for axis in AXES}
    phase = {axis: float(rng.uniform(0.0, 2.0 * np.pi)) for axis in AXES}
    levels = {place: level_to_table(float(tilt), float(azimuth)) for place, (tilt, azimuth) in angles.items()}
    C_body_table = {axis: mounted(i, pairs[axis]) for i, axis in enumerate(AXES)}
    world = World(table_gain * (1.0 + rate), 1.0 + converter, thermometer, latitude, levels, C_body_table, phase)
    drawn: dict[str, float | list[float] | list[list[float]]] = {
        "table_rate_error": rate,
        "converter_reference_error": converter,
        "thermometer_error": thermometer,
        "latitude": latitude,
        **{f"tilt_and_azimuth_of_{place}": pair.tolist() for place, pair in angles.items()},
        **{f"mounting_{axis}_turned": list(pair) for axis, pair in pairs.items()},
        **{f"phase_{axis}_turned": angle for axis, angle in phase.items()},
    }
    return world, drawn


def table_errors(standards: Mapping[str, Influence], drawn: Drawn, latitude_deg: float) -> tuple[DrawnError, ...]:
    """Return the errors of the standards that outlive a campaign, as `draw_world` drew them."""
    names = ("table_rate_error", "converter_reference_error", "thermometer_error", "latitude")
    rate, converter, thermometer, latitude = (float(str(drawn[name])) for name in names)
    errors = {
        "rate_table.rate": -rate,
        "converter.reference": converter,
        "thermometer.temperature": thermometer,
        "site.latitude": float(np.radians(latitude_deg)) - latitude,
    }
    return drawn_errors(standards, errors)


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
        Reference voltage of each signal [V].
    averaged : int
        Conversions that a saved code is the mean of.
    """
    lo, hi = chain.codes or (0, 0)
    fine = replace(chain, step=chain.step / averaged, codes=(lo * averaged, hi * averaged))
    reference_codes = np.clip(np.rint(reference / fine.step), lo * averaged, hi * averaged)
    return to_counts(fine, values, reference=reference_codes) / averaged, reference_codes / averaged


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
