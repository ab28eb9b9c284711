"""The unit of the simulated test of sensitivities, and what it reads.

With ``d`` the supply less 5 V, ``e`` the temperature less 20 degC, t the time since power-up, all along the body axes::

    bias = b0 + b1 e + b2 e^2 + (s + c e) d + v(p) p0 (1 + r e) + sum_j w_j (1 + a e_0) exp(-t / tau_j) + run-to-run
    M_ii = m_ii + m1_i e + mV_i d

``e_0`` is ``e`` at power-up; ``v`` goes from 0 in air to 1 in vacuum with the logarithm of the pressure, where gas no
longer slips (a logistic curve about `KNEE`). Sizes: supply by IEEE Std 1431, 12.4, as 3 % of 5 V change the bias by
some 0.003 deg/s; scale factor off by 0.3 to 1 %, as of a unit that nobody has calibrated (assumed), over temperature
0.03 %/degC by the data sheet of [1]_; vacuum and warm-up as in [2]_.

References
----------
.. [1] Systron Donner, QRS11 data sheet.
.. [2] V. V. Badescu, NPS thesis, September 2011, section IV.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from .setup import AIR_PA, DEGREES, VOLTS

DEG = float(np.radians(1.0))
KNEE = 30.0  # [Pa]
STEEP = 1.5
WARM_UP_TIMES = (180.0, 1800.0)  # [s]


@dataclass(frozen=True, eq=False)
class Unit:
    """A unit with its scatter; (3,) along the body axes where nothing else is said."""

    bias: Array  # of e^0, e^1, e^2, (3, 3) [rad/s/degC^j]
    supply: Array  # s [rad/s/V]
    supply_temperature: Array  # c [rad/s/(V degC)]
    vacuum: Array  # p0 [rad/s]
    vacuum_temperature: Array  # r [1/degC]
    warm_up: Array  # w_j, (2, 3) [rad/s]
    warm_up_temperature: float  # a [1/degC]
    warm_up_time: Array  # (2,) [s]
    matrix: Array  # (3, 3)
    scale_temperature: Array  # m1 [1/degC]
    scale_supply: Array  # mV [1/V]
    references: Array  # reference voltages at 5 V and 20 degC, change with the supply, with temperature, (3, 3)
    run_bias_std: float = 0.006 * DEG
    run_slope_std: float = 1e-5 * DEG  # [rad/s/degC]
    run_supply_std: float = 5e-4 * DEG  # [rad/s/V]
    run_scale_std: float = 1e-4
    white: float = 0.002 * DEG  # of an average [rad/s]
    walk: float = 4e-6 * DEG  # [rad/s/sqrt(s)]
    pump: float = 2.0  # noise while the pump runs, over that in air


def draw_unit(rng: np.random.Generator) -> Unit:
    """Return a unit of the family."""
    some = rng.standard_normal
    bias = DEG * np.array([0.03, 3e-4, 5e-6])[:, None] * some((3, 3))
    return Unit(
        bias=bias,
        supply=DEG * rng.uniform(0.01, 0.03, 3) * rng.choice([-1.0, 1.0], 3),
        supply_temperature=DEG * 2e-4 * some(3),
        vacuum=DEG * rng.uniform(0.02, 0.05, 3),
        vacuum_temperature=8e-3 * (1.0 + 0.3 * some(3)),
        warm_up=DEG * np.array([[0.02], [0.012]]) * rng.uniform(0.7, 1.3, (2, 3)),
        warm_up_temperature=float(rng.uniform(-8e-3, 8e-3)),
        warm_up_time=np.array(WARM_UP_TIMES) * rng.uniform(0.8, 1.2, 2),
        matrix=_matrix(rng),
        scale_temperature=3e-4 * rng.uniform(0.3, 1.0, 3) * rng.choice([-1.0, 1.0], 3),
        scale_supply=3e-3 * some(3),
        references=np.array([2.5, 2e-3, 1e-4])[:, None] + np.array([5e-3, 1e-3, 5e-5])[:, None] * some((3, 3)),
    )


def _matrix(rng: np.random.Generator) -> Array:
    """Return what the axes read of each other: cross terms of 0.4 %, scale factors off by 0.3 % to 1 %."""
    matrix: Array = np.eye(3) + 4e-3 * rng.standard_normal((3, 3))
    matrix[np.diag_indices(3)] = 1.0 + 1e-2 * rng.uniform(0.3, 1.0, 3) * rng.choice([-1.0, 1.0], 3)
    return matrix


@dataclass(frozen=True, eq=False)
class Course:
    """Conditions of one power-up, at the middle of each average, (n,) each."""

    powered: Array  # time since power-up [s]
    temperature: Array  # [degC]
    volts: Array  # [V]
    pressure: Array  # [Pa]


def in_vacuum(pressure: Array) -> Array:
    """Return how much of the change from air to vacuum there is at a pressure [Pa]; 0 in air."""
    part = 1.0 / (1.0 + (pressure / KNEE) ** STEEP)
    air = 1.0 / (1.0 + (AIR_PA / KNEE) ** STEEP)
    return np.asarray((part - air) / (1.0 - air))


def readings(unit: Unit, one: Course, rate: Array, start: float, rng: np.random.Generator) -> Array:
    """Return what the sensors read in one power-up, shape (n, 3) [rad/s].

    Parameters
    ----------
    unit : Unit
        As drawn.
    one : Course
        Its conditions.
    rate : ndarray, shape (n, 3) or (1, 3)
        True input along the body axes [rad/s].
    start : float
        Temperature at power-up [degC].
    rng : numpy.random.Generator
        All draws come from it.
    """
    e, d = (one.temperature - DEGREES)[:, None], (one.volts - VOLTS)[:, None]
    n = len(e)
    part = in_vacuum(one.pressure)[:, None]
    own = rng.normal(0.0, [[unit.run_bias_std], [unit.run_slope_std], [unit.run_supply_std]], (3, 3))
    bias = unit.bias[0] + own[0] + (unit.bias[1] + own[1]) * e + unit.bias[2] * e**2
    bias = bias + (unit.supply + own[2] + unit.supply_temperature * e) * d
    bias = bias + part * unit.vacuum * (1.0 + unit.vacuum_temperature * e)
    falling = np.exp(-one.powered[:, None] / unit.warm_up_time)
    bias = bias + (1.0 + unit.warm_up_temperature * (start - DEGREES)) * falling @ unit.warm_up
    scale = unit.scale_temperature * e + unit.scale_supply * d
    read = rate @ unit.matrix.T * (1.0 + rng.normal(0.0, unit.run_scale_std, 3)) + scale * rate
    steps = np.sqrt(np.diff(one.powered, prepend=one.powered[0]))[:, None]
    walked = np.cumsum(unit.walk * steps * rng.standard_normal((n, 3)), axis=0)
    louder = np.where(part > 0.5, unit.pump, 1.0)
    return np.asarray(bias + read + walked + unit.white * louder * rng.standard_normal((n, 3)))
