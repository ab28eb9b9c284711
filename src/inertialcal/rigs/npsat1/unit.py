"""The unit of the simulated campaign: three rate sensors drawn about the published ones, and what they read.

All terms are along the body axes: a sensor that is mounted inverted reads the negative of all of them. The thesis gives
bias, start-up and matrix in one equation without a word on their sense; they are taken along the body axes, as that
equation adds them up. Corrections of misprints follow the source audit.

The bias is the polynomial of Tables 3 and 7 in the volts of an exact temperature channel, between air and vacuum by
pressure, plus a start-up that decays from power-up, hysteresis by the side of the path, the scatter of the power-up,
and what the installation on the rate table adds. Its *true value* at a temperature is the mean over many power-ups,
settled, midway between warming and cooling: the polynomial.

The chamber ramps from set-point to set-point; the unit follows it with one time constant. Hysteresis changes side as
the temperature does: s, -1 after long cooling and +1 after long warming, starts midway and turns over with the distance
in temperature from where the path turned.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ...core.estimate import Array
from ...core.key import AXES
from ...sensors.catalogue import B_CONS_DEG_S, B_IN_RUN, SLOPE, T_REFERENCE, V_NOMINAL
from ...sensors.model.equation import predict
from ...sensors.model.sensor_model import SensorModel
from ..parts.gyro_bench import SCALE_FACTOR_V_PER_DEG_S, VOLTS_PER_RAD_S
from .setup import AIR, AVERAGING, VACUUM, Bench, Chamber

# Figures of the published suite [1]_, columns x, y, z along the body; Tables 2 and 15 are in ``sensors.catalogue``.
# Table 3: bias in air [V] in powers of the temperature channel's volts; rows B, m1, m2, m3.
AMBIENT_VOLTS = np.array(
    [
        [-0.03562, -0.00295, 0.01428],
        [-0.05444, -0.01634, -0.01493],
        [-0.00816, -0.00622, -0.00899],
        [-0.00560, -0.00542, -0.00808],
    ]
)
# Table 7, repeated in Table 15: the same in vacuum.
VACUUM_VOLTS = np.array(B_IN_RUN).T
# Table 6: bias left after compensation with Table 3 [V], by region of pressure [Torr].
REGIONS_TORR = ((5.7e-7, 1.5e-6), (5.9e-6, 1e-5), (1e-5, 1e-4), (1e-4, 4e-4), (1e-3, 2e-3), (2e-3, 1e-2), (1e-2, 4e-2))
REGION_VOLTS = np.array(
    [
        [0.02221, 0.00327, 0.01893],
        [0.02808, 0.00209, 0.02039],
        [0.02211, 0.00297, 0.01949],
        [0.02091, 0.00291, 0.01834],
        [0.02899, 9.07e-04, 0.01942],
        [0.02921, 3.27e-04, 0.02141],
        [0.02821, 5.63e-04, 0.0218],
    ]
)
CONSTANT_BELOW_TORR = 4e-4  # section IV.C: constant from 1e-4 Torr down; the region above it reads the same
AIR_TORR = 760.0
# Appendices E to J: slopes [V/(deg/s)]; row = the sensor that reads, column = the axis that turns.
SLOPES = np.array(
    [
        [0.49979, -0.00115, -0.001],  # E1, F2, G2
        [5.08297e-4, 0.502, -6.93375e-4],  # E2, F1, J3 (G3 is a misprint of it)
        [0.00649, 6.37976e-4, 0.49747],  # E3, F3, G1
    ]
)
START_UP_AIR_DEG_S = (0.024, 0.017, 0.019)  # section IV.A: what is left out at the start, in air
START_UP_VACUUM_DEG_S = (0.02, 0.015, 0.016)  # section IV.C, in vacuum
LARGEST_HYSTERESIS_DEG_S = 0.004  # section IV.B
LARGEST_RUN_TO_RUN_DEG_S = 0.016  # Table 14: about the largest difference seen
NOISE_DEG_S = 0.004  # Table 5, Appendix A: of an average of 1 s
WALK_DEG_H_SQRT_H = (5.817, 2.71, 2.71)  # Table 13, with the unit that the printed one is of; z is not printed
NOMINAL_SCATTER_V = 0.0011  # Table 2: of the temperature channel
QUALIFICATION_DEGC = (-29.0, 66.0)  # section IV.B, TVAC2-1a
SETTLED_AIR, SETTLED_VACUUM = 300.0, 4500.0  # Table 14: 5 min, and 1 to 1.5 h [s]

DEG = float(np.radians(1.0))
TIME_CONSTANTS = 3.0  # that a start-up takes to be settled
WALK_UNIT = DEG / 3600.0 / 60.0  # deg/h/sqrt(h) [rad/s/sqrt(s)]
REFERENCE_DEGC = 25.0  # of the reference voltages
TURN_OVER = 3.0  # distance in which hysteresis goes to the other side [degC]
MIDDLE_DEGC = 20.0  # about which the slope of a power-up turns


@dataclass(frozen=True, eq=False)
class Unit:
    """A unit with its scatter; all along the body axes."""

    model: SensorModel  # scale factors, cross-axis sensitivity and asymmetry
    # in air and in vacuum, bias [V] in powers of the volts of the temperature channel, (4, 3)
    bias_volts: Mapping[str, Array]
    installation: Array  # bias on the rate table minus that in the chamber, (3,) [rad/s]
    start_up: Mapping[str, Array]  # extra bias at power-up, in air and in vacuum, (3,) [rad/s]
    start_up_time: Mapping[str, float]  # its time constant [s]
    hysteresis: Array  # half the bias difference between warming and cooling, (3,) [rad/s]
    lag: float  # delay of the bias behind the temperature channel [s]
    # scatter from power-up to power-up: bias [rad/s], its slope [rad/s/degC], scale factors (1)
    run_bias_std: float
    run_slope_std: float
    run_scale_std: float
    dwell_std: float  # bias scatter from dwell to dwell on the rate table [rad/s]
    # white noise of an average [rad/s]; rate random walk [rad/s/sqrt(s)]; (3,) each
    white: Array
    walk: Array
    # noise of an averaged temperature channel, and of a reference voltage [V]
    temperature_std: float
    reference_std: float
    # reference voltages [V] in powers of the distance from ``REFERENCE_DEGC``, (2, 3, 3): rate or temperature, power,
    # sensor
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


@dataclass(frozen=True, eq=False)
class Climate:
    """Conditions of three sensors at n times."""

    temperature: Array  # temperature of the temperature channels, (n, 3) [degC]
    felt: Array  # temperature that the bias follows: the same, some time before, (n, 3) [degC]
    side: Array  # side of the path, -1 to 1, (n, 3)
    torr: Array  # pressure, (n,) [Torr]


def knots(bench: Bench, chamber: Chamber, ramp: float) -> tuple[Array, Array]:
    """Return times [s] and set-points [degC] between which the chamber goes in straight lines.

    Parameters
    ----------
    bench, chamber : Bench, Chamber
        As they are run.
    ramp : float
        Of the set-point [degC/min].
    """
    times, points = [0.0, chamber.hold], [bench.set_points[0]] * 2
    for before, after in pairwise(bench.set_points):
        reached = times[-1] + 60.0 * abs(after - before) / ramp
        times += [reached, reached + chamber.soak]
        points += [after, after]
    return np.array(times), np.array(points)


def followed(times: Array, points: Array, time_constant: float, at: Array) -> Array:
    """Return what follows straight lines with one time constant, in closed form, shape of ``at``.

    Parameters
    ----------
    times, points : ndarray, shape (k,)
        Ends of the lines; before the first and after the last it is constant.
    time_constant : float
        [s]
    at : ndarray
        Times [s].
    """
    slopes = np.append(np.diff(points) / np.maximum(np.diff(times), 1e-9), 0.0)
    behind = np.zeros(len(times))  # behind[i]: output less input at times[i]
    for i, span in enumerate(np.diff(times)):
        rest = -slopes[i] * time_constant
        behind[i + 1] = rest + (behind[i] - rest) * np.exp(-span / time_constant)
    line = np.maximum(np.searchsorted(times, at, side="right") - 1, 0)
    since = np.maximum(at - times[line], 0.0)
    rests = -slopes[line] * time_constant
    gone = np.exp(-since / time_constant)
    return np.asarray(points[line] + slopes[line] * since + rests + (behind[line] - rests) * gone)


def side_of_path(temperature: Array) -> Array:
    """Return s of the module head along the path of one sensor, shape (n,)."""
    steps = np.sign(np.diff(temperature))
    moving = np.flatnonzero(steps)
    turns = moving[np.flatnonzero(np.diff(steps[moving])) + 1]  # steps at which it goes the other way
    edges = [0, *turns.tolist(), len(temperature) - 1]
    found, s = np.zeros(len(temperature)), 0.0
    for begin, end in pairwise(edges):
        part = temperature[begin : end + 1]
        way = np.sign(part[-1] - part[0])
        found[begin : end + 1] = way + (s - way) * np.exp(-np.abs(part - part[0]) / TURN_OVER)
        s = float(found[end])
    return found


def vacuum_part(torr: Array) -> Array:
    """Return how much of the change from air to vacuum there is at a pressure [Torr], by sensor, shape (n, 3).

    0 in air, 1 where the bias is constant; between them the regions of Table 6, each at its geometric middle, over the
    mean of those that are constant.
    """
    ends = np.array(REGIONS_TORR)
    constant = ends[:, 1] <= CONSTANT_BELOW_TORR
    level = REGION_VOLTS[constant].mean(axis=0)
    at = np.log10([CONSTANT_BELOW_TORR, *np.sqrt(ends[~constant, 0] * ends[~constant, 1]), AIR_TORR])
    parts = np.vstack([np.ones(3), REGION_VOLTS[~constant] / level, np.zeros(3)])
    return np.column_stack([np.interp(np.log10(torr), at, part) for part in parts.T])


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
