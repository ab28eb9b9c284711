"""The recordings of the simulated campaign: thermal chamber, rate table, unit at rest.

Every chamber run is a power-up of its own and is recorded from it on. On the rate table one power-up holds a recording
for each axis; the walk of the bias goes on between them. At rest the unit lies as in the chamber.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Array
from ...core.recording import Recording
from ..parts.gyro_bench import body_rate
from ..parts.stepped_table import Motion, motion
from .climate import Climate, followed, knots, side_of_path
from .logger import APPLIED, BEGIN, DAY, PRESSURE, Sensed, save_starts, saved
from .reading import noise, readings
from .setup import AIR, AVERAGING, INTERVAL, VACUUM, Bench
from .tables import AIR_TORR
from .unit import Unit, powered_up
from .world import World

DIGITS = 6  # of the commanded rate [deg/s]
WARMER_DEGC = (0.3, 0.0, -0.2)  # the three sensors beside each other
SLOWER = (1.0, 1.05, 0.95)  # their time constants, over that of the unit
FIRST_DAY = {AIR: 0, VACUUM: 10, "table": 20, "static": 30}
GAUGE_STEPS = 60
WANDER_DEGC, WANDER_PERIOD = 0.02, 3000.0  # of the temperature in the laboratory


def chamber_recording(
    bench: Bench, unit: Unit, world: World, condition: str, number: int, rng: np.random.Generator
) -> Recording:
    """Return a run of the thermal chamber, its pressure [Torr] beside it."""
    chamber = bench.chambers[condition]
    times, points = knots(bench, chamber, bench.ramps[(number - 1) % len(bench.ramps)])
    starts = save_starts(bench, float(times[-1]), rng)
    middle = starts + 0.5 * AVERAGING
    constants = chamber.time_constant * np.array(SLOWER)
    temperature, felt = (
        np.column_stack([followed(times, points, tau, at) for tau in constants]) + np.array(WARMER_DEGC)
        for at in (middle, middle - unit.lag)
    )
    torr = _pressure(chamber.torr, len(starts))
    side = np.column_stack([side_of_path(path) for path in felt.T])
    climate = Climate(temperature, felt, side, torr)
    run = powered_up(unit, rng)
    read = readings(unit, run, world.earth_in_chamber[None, :], climate, middle)
    read = read + noise(unit, starts, np.zeros(3), rng).values
    begin = BEGIN + DAY * (FIRST_DAY[condition] + number - 1)
    sensed = Sensed(starts, read, temperature, 0.0, begin)
    return saved(bench, unit, world, sensed, {PRESSURE: torr}, rng)


def static_recording(bench: Bench, unit: Unit, world: World, number: int, rng: np.random.Generator) -> Recording:
    """Return a long record of the unit at rest, in air, at one temperature."""
    starts = save_starts(bench, 3600.0 * bench.static_hours, rng)
    powered = bench.warmed + starts + 0.5 * AVERAGING
    climate = _laboratory(bench, starts, rng)
    run = powered_up(unit, rng)
    read = readings(unit, run, world.earth_in_chamber[None, :], climate, powered)
    read = read + noise(unit, starts, np.zeros(3), rng).values
    sensed = Sensed(starts, read, climate.temperature, bench.warmed, BEGIN + DAY * (FIRST_DAY["static"] + number - 1))
    return saved(bench, unit, world, sensed, {}, rng)


def table_recordings(
    bench: Bench, unit: Unit, world: World, number: int, rng: np.random.Generator
) -> dict[str, Recording]:
    """Return the recordings of one power-up on the rate table, by the axis that is turned."""
    run, walked, found = powered_up(unit, rng), np.zeros(3), {}
    warm = rng.normal(bench.lab_degc, bench.u_lab_degc)
    at, powered = 0.0, bench.warmed
    for axis in AXES:
        walked = walked + rng.normal(0.0, np.sqrt(powered - at), 3) * unit.walk
        turning, starts = _turning(bench, rng)
        climate = _constant(warm + np.zeros(len(starts)))
        read = readings(unit, run, _rate(world, axis, turning), climate, powered + turning.start + 0.5 * AVERAGING)
        read += unit.installation + rng.normal(0.0, unit.dwell_std, (len(bench.rates_deg_s), 3))[turning.dwell]
        disturbed = noise(unit, turning.start, walked, rng)
        walked = disturbed.end
        begin = BEGIN + DAY * (FIRST_DAY["table"] + number - 1) + round(powered)
        sensed = Sensed(starts, read + disturbed.values, climate.temperature, powered, begin)
        applied: Array = np.asarray(np.round(np.degrees(turning.rate), DIGITS) + 0.0)  # no -0.0
        found[axis] = saved(bench, unit, world, sensed, {APPLIED: applied}, rng)
        at, powered = powered + float(starts[-1]) + AVERAGING, powered + bench.set_up
    return found


def _rate(world: World, axis: str, turning: Motion) -> Array:
    """Return the rate of the unit against inertial space along the body axes, shape (n, 3) [rad/s]."""
    return body_rate(
        turning, world.table_gain, world.C_body_table[axis], world.latitude, world.C_table_level, world.phase[axis]
    )


def _turning(bench: Bench, rng: np.random.Generator) -> tuple[Motion, Array]:
    """Return the motion of the table in the windows that are saved, and where these begin [s]."""
    ramps = INTERVAL * rng.integers(1, bench.longest_ramp + 1, len(bench.rates_deg_s) - 1)
    each = motion(np.radians(bench.rates_deg_s), bench.dwell, ramps, 1.0, AVERAGING)
    starts = save_starts(bench, float(each.start[-1]) + AVERAGING, rng)
    rows = starts.astype(np.int64)  # one a second
    kept = Motion(*(getattr(each, one.name)[rows] for one in fields(each)))
    return kept, starts


def _laboratory(bench: Bench, starts: Array, rng: np.random.Generator) -> Climate:
    """Return the conditions beside the chamber: one temperature, but for a small wave."""
    wave = WANDER_DEGC * np.sin(2.0 * np.pi * (starts / WANDER_PERIOD + rng.random()))
    return _constant(rng.normal(bench.lab_degc, bench.u_lab_degc) + wave)


def _constant(degrees: Array) -> Climate:
    """Return conditions in air at temperatures of the unit, shape (n,) [degC], with no path behind them."""
    temperature = degrees[:, None] + np.array(WARMER_DEGC)
    return Climate(temperature, temperature, np.zeros_like(temperature), np.full(len(degrees), AIR_TORR))


def _pressure(torr: tuple[float, float], n: int) -> Array:
    """Return the pressure from start to end of a run as a gauge of two digits shows it, shape (n,) [Torr]."""
    levels = np.array([float(f"{one:.2g}") for one in np.geomspace(*torr, GAUGE_STEPS)])
    return np.asarray(levels[np.arange(n) * GAUGE_STEPS // n])
