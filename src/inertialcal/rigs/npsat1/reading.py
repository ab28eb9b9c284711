"""What the sensors of the simulated unit read: the sensor equation with all its terms, along the body axes.

The bias is the polynomial of Tables 3 and 7 in the volts that an exact temperature channel would show, between air and
vacuum by pressure; a start-up that dies away from power-up on; hysteresis by the side of the path; what the power-up
has of its own; what the installation on the rate table adds. Its *true value* at a temperature is the mean over many
power-ups, settled, midway between warming and cooling: the polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...core.estimate import Array
from ...sensors.catalogue import SLOPE, T_REFERENCE, V_NOMINAL
from ...sensors.model.equation import predict
from .climate import Climate, vacuum_part
from .setup import AIR, AVERAGING, VACUUM, VOLTS_PER_RAD_S
from .unit import Run, Unit

MIDDLE_DEGC = 20.0  # about which the slope of a power-up turns


def polynomial_bias(unit: Unit, condition: str, degrees: ArrayLike) -> Array:
    """Return the bias of each sensor in air or in vacuum, shape (n, 3) [rad/s].

    Parameters
    ----------
    unit : Unit
        Whose polynomials.
    condition : {"ambient", "vacuum"}
        Air or vacuum.
    degrees : array_like, shape (n,) or (n, 3)
        True temperature [degC].
    """
    given = np.asarray(degrees, dtype=float)
    volts = (given[:, None] if given.ndim < 2 else given) * SLOPE + (
        np.array(V_NOMINAL) - SLOPE * np.array(T_REFERENCE)
    )
    found = np.zeros_like(volts)
    for coefficient in unit.bias_volts[condition][::-1]:
        found = found * volts + coefficient
    return np.asarray(found / VOLTS_PER_RAD_S)


def settled_bias(unit: Unit, climate: Climate) -> Array:
    """Return the bias without start-up, power-up and noise, shape (n, 3) [rad/s]."""
    found = polynomial_bias(unit, AIR, climate.felt)
    part = vacuum_part(climate.torr)
    if part.any():
        found = found + part * (polynomial_bias(unit, VACUUM, climate.felt) - found)
    return np.asarray(found + unit.hysteresis * climate.side)


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of a recording, shape (n, 3), and how far the walk has gone at its end, shape (3,) [rad/s]."""

    values: Array
    end: Array


def noise(unit: Unit, starts: Array, walked: Array, rng: np.random.Generator) -> Noise:
    """Return white noise and a rate random walk of averages that are saved at uneven times.

    Parameters
    ----------
    unit : Unit
        Whose noise.
    starts : ndarray, shape (n,)
        Of the averaging windows [s].
    walked : ndarray, shape (3,)
        How far the walk has gone at the first of them [rad/s].
    rng : numpy.random.Generator
        All draws come from it.
    """
    n = len(starts)
    inside, between, white = rng.standard_normal((3, n, 3))
    inside *= np.sqrt(AVERAGING) * unit.walk
    between[:-1] *= np.sqrt(np.diff(starts) - AVERAGING)[:, None] * unit.walk
    between[-1] = 0.0
    after = walked + np.cumsum(inside + between, axis=0)
    white *= np.sqrt(unit.white**2 + unit.walk**2 * AVERAGING / 12.0)  # with what the mean has between both ends
    return Noise(after - between - 0.5 * inside + white, after[-1])


def readings(unit: Unit, run: Run, rate: Array, climate: Climate, powered: Array) -> Array:
    """Return what the sensors read, without noise, shape (n, 3) [rad/s].

    Parameters
    ----------
    unit, run : Unit, Run
        The unit, as it is in one power-up.
    rate : ndarray, shape (n, 3) or (1, 3)
        True input [rad/s].
    climate : Climate
        Conditions.
    powered : ndarray, shape (n,)
        Time since power-up [s].
    """
    model = replace(unit.model, matrix=run.scale[:, None] * unit.model.matrix)
    condition = AIR if climate.torr[0] > 1.0 else VACUUM
    start_up = np.exp(-powered / unit.start_up_time[condition])[:, None] * unit.start_up[condition]
    own = run.bias + run.slope * (climate.felt - MIDDLE_DEGC)
    return np.asarray(predict(model, rate) + settled_bias(unit, climate) + start_up + own)
