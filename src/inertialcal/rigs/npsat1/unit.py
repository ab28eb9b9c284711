"""The unit of the simulated campaign: three rate sensors whose terms scatter about the published ones.

All terms are along the body axes: a sensor that is mounted inverted reads the negative of all of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...core.axes import AXES
from ...core.estimate import Array
from ...sensors.catalogue import B_CONS_DEG_S
from ...sensors.model.sensor_model import SensorModel
from .setup import AIR, SCALE_FACTOR_V_PER_DEG_S, VACUUM, VOLTS_PER_RAD_S
from .tables import (
    AMBIENT_VOLTS,
    LARGEST_HYSTERESIS_DEG_S,
    NOISE_DEG_S,
    NOMINAL_SCATTER_V,
    SETTLED_AIR,
    SETTLED_VACUUM,
    SLOPES,
    START_UP_AIR_DEG_S,
    START_UP_VACUUM_DEG_S,
    VACUUM_VOLTS,
    WALK_DEG_H_SQRT_H,
)

DEG = float(np.radians(1.0))
TIME_CONSTANTS = 3.0  # that a start-up takes to be settled
WALK_UNIT = DEG / 3600.0 / 60.0  # deg/h/sqrt(h) [rad/s/sqrt(s)]
REFERENCE_DEGC = 25.0  # of the reference voltages


@dataclass(frozen=True, eq=False)
class Unit:
    """A unit with its scatter; all along the body axes.

    Parameters
    ----------
    model : SensorModel
        Scale factors, cross-axis sensitivity and asymmetry.
    bias_volts : mapping of str to ndarray, shape (4, 3)
        In air and in vacuum, bias [V] in powers of the volts of the temperature channel.
    installation : ndarray, shape (3,)
        Of the bias, on the rate table over that in the chamber [rad/s].
    start_up : mapping of str to ndarray, shape (3,)
        What the bias has more at power-up, in air and in vacuum [rad/s].
    start_up_time : mapping of str to float
        Its time constant [s].
    hysteresis : ndarray, shape (3,)
        Half of what the bias has more on a path of warming than of cooling [rad/s].
    lag : float
        By which the bias is behind the temperature channel [s].
    run_bias_std, run_slope_std, run_scale_std : float
        From power-up to power-up: of the bias [rad/s], of its slope [rad/s/degC], of each scale factor (1).
    dwell_std : float
        Of the bias, from dwell to dwell on the rate table [rad/s].
    white, walk : ndarray, shape (3,)
        Of an average [rad/s]; rate random walk [rad/s/sqrt(s)].
    temperature_std, reference_std : float
        Of an average of a temperature channel, and of a reference voltage [V].
    reference_volts : ndarray, shape (2, 3, 3)
        Reference voltage of the rate and of the temperature of each sensor [V], in powers of the distance from
        ``REFERENCE_DEGC``: [which, power, sensor].
    """

    model: SensorModel
    bias_volts: Mapping[str, Array]
    installation: Array
    start_up: Mapping[str, Array]
    start_up_time: Mapping[str, float]
    hysteresis: Array
    lag: float
    run_bias_std: float
    run_slope_std: float
    run_scale_std: float
    dwell_std: float
    white: Array
    walk: Array
    temperature_std: float
    reference_std: float
    reference_volts: Array


@dataclass(frozen=True, eq=False)
class Run:
    """What one power-up has of its own: bias [rad/s], slope of it [rad/s/degC], factor of each scale factor; (3,)."""

    bias: Array
    slope: Array
    scale: Array


def draw_unit(rng: np.random.Generator) -> Unit:
    """Return a unit of the family of the published one."""
    polynomials = _draw_polynomials(rng)
    matrix = SLOPES / SCALE_FACTOR_V_PER_DEG_S + rng.normal(0.0, 3e-3, (3, 3))
    model = SensorModel(
        kind="gyro",
        axes=AXES,
        scale_factor=np.full(3, VOLTS_PER_RAD_S),
        output_unit="V",
        matrix=matrix,
        bias=np.zeros(3),
        scale_factor_asymmetry=rng.normal(0.0, 5e-4, 3),
    )
    slow = TIME_CONSTANTS * rng.uniform(0.9, 1.1, 2)
    return Unit(
        model,
        polynomials,
        installation=DEG * (np.array(B_CONS_DEG_S) + rng.normal(0.0, 0.003, 3)),
        start_up={
            AIR: DEG * np.array(START_UP_AIR_DEG_S) * rng.uniform(0.7, 1.3, 3),
            VACUUM: DEG * np.array(START_UP_VACUUM_DEG_S) * rng.uniform(0.7, 1.3, 3),
        },
        start_up_time={AIR: SETTLED_AIR / slow[0], VACUUM: SETTLED_VACUUM / slow[1]},
        hysteresis=0.5 * DEG * LARGEST_HYSTERESIS_DEG_S * rng.uniform(0.0, 1.0, 3),
        lag=float(rng.uniform(5.0, 20.0)),
        run_bias_std=0.006 * DEG,
        run_slope_std=1e-5 * DEG,
        run_scale_std=1e-4,
        dwell_std=2e-4 * DEG,
        white=NOISE_DEG_S * DEG * rng.uniform(0.9, 1.1, 3),
        walk=np.array(WALK_DEG_H_SQRT_H) * WALK_UNIT * rng.uniform(0.7, 1.3, 3),
        temperature_std=NOMINAL_SCATTER_V,
        reference_std=5e-5,
        reference_volts=_draw_references(rng),
    )


def _draw_polynomials(rng: np.random.Generator) -> dict[str, Array]:
    """Return Tables 3 and 7, each coefficient and each difference of both 10 % off, the constant 0.02 deg/s."""
    some = 1.0 + 0.1 * rng.standard_normal((4, 3))
    air = AMBIENT_VOLTS * some
    air[0] = AMBIENT_VOLTS[0] + rng.normal(0.0, 0.01, 3)
    step = (VACUUM_VOLTS - AMBIENT_VOLTS) * (1.0 + 0.1 * rng.standard_normal((4, 3)))
    return {AIR: air, VACUUM: air + step}


def _draw_references(rng: np.random.Generator) -> Array:
    """Return reference voltages of 2.5 V within some mV that change by some 0.1 mV/degC; Figure 23 has no table."""
    sizes = np.array([5e-3, 1e-4, 5e-7])[:, None]
    drawn = rng.standard_normal((2, 3, 3)) * sizes
    drawn[:, 0] += 2.5
    return np.asarray(drawn)


def reference_volts(unit: Unit, which: int, degrees: ArrayLike) -> Array:
    """Return the reference voltage of the rate (0) or of the temperature (1) of each sensor, shape (..., 3) [V].

    Parameters
    ----------
    unit : Unit
        Whose references.
    which : int
        Of rate or temperature.
    degrees : array_like, shape (..., 3) or ()
        Temperature of the sensors [degC].
    """
    away = np.asarray(degrees, dtype=float) - REFERENCE_DEGC
    constant, slope, bend = unit.reference_volts[which]
    return np.asarray(constant + (slope + bend * away) * away)


def powered_up(unit: Unit, rng: np.random.Generator) -> Run:
    """Return what one power-up has of its own."""
    return Run(
        rng.normal(0.0, unit.run_bias_std, 3),
        rng.normal(0.0, unit.run_slope_std, 3),
        1.0 + rng.normal(0.0, unit.run_scale_std, 3),
    )
