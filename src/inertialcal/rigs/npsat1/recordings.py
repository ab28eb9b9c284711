"""The recordings of the simulated campaign: thermal chamber, rate table, unit at rest.

Every chamber run is a power-up of its own and is recorded from it on. On the rate table one power-up holds a recording
for each axis; the walk of the bias goes on between them. At rest the unit lies as in the chamber.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...physics.earth import earth_rate
from ...sensors.chain.conversion import to_temperature_counts
from ..parts.gyro_bench import CODES, STEP, Motion, World, averaged_codes, motion
from .setup import (
    AIR,
    APPLIED,
    AVERAGED,
    AVERAGING,
    INTERVAL,
    PRESSURE,
    VACUUM,
    Bench,
    chain,
    thermometer,
)
from .unit import AIR_TORR, Climate, Unit, followed, knots, noise, powered_up, readings, reference_volts, side_of_path

DIGITS = 6  # of the commanded rate [deg/s]
WARMER_DEGC = (0.3, 0.0, -0.2)  # of the three sensors, relative to the unit
SLOWER = (1.0, 1.05, 0.95)  # their time constants, over that of the unit
FIRST_DAY = {AIR: 0, VACUUM: 10, "table": 20, "static": 30}
GAUGE_STEPS = 60
WANDER_DEGC, WANDER_PERIOD = 0.02, 3000.0  # of the temperature in the laboratory
BEGIN = 1_272_412_800  # 2010-04-28 00:00:00 UTC [s]
DAY = 86_400
TESTED_VOLTS = 4.2  # of the built-in test when all is well
STARTED = 0.6  # [s] after power-up; Table 14: less than 1 s


def chamber_recording(
    bench: Bench, unit: Unit, world: World, condition: str, number: int, rng: np.random.Generator
) -> Recording:
    """Return a run of the thermal chamber, with its pressure [Torr]."""
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
    read = readings(unit, run, _chamber_rate(world), climate, middle)
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
    read = readings(unit, run, _chamber_rate(world), climate, powered)
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
        read = readings(unit, run, world.body_rate(turning, axis), climate, powered + turning.start + 0.5 * AVERAGING)
        read += unit.installation + rng.normal(0.0, unit.dwell_std, (len(bench.rates_deg_s), 3))[turning.dwell]
        disturbed = noise(unit, turning.start, walked, rng)
        walked = disturbed.end
        begin = BEGIN + DAY * (FIRST_DAY["table"] + number - 1) + round(powered)
        sensed = Sensed(starts, read + disturbed.values, climate.temperature, powered, begin)
        applied: Array = np.asarray(np.round(np.degrees(turning.rate), DIGITS) + 0.0)  # no -0.0
        found[axis] = saved(bench, unit, world, sensed, {APPLIED: applied}, rng)
        at, powered = powered + float(starts[-1]) + AVERAGING, powered + bench.set_up
    return found


def _chamber_rate(world: World) -> Array:
    """Return the earth's rate along the body axes, in the chamber and at rest, shape (1, 3) [rad/s]."""
    return np.asarray(world.levels["chamber"] @ earth_rate(world.latitude))[None, :]


def _turning(bench: Bench, rng: np.random.Generator) -> tuple[Motion, Array]:
    """Return the motion of the table in the windows that are saved, and where these begin [s]."""
    ramps = INTERVAL * rng.integers(1, bench.longest_ramp + 1, len(bench.rates_deg_s) - 1)
    each = motion(np.radians(bench.rates_deg_s), bench.dwell, ramps, 1.0, AVERAGING)
    starts = save_starts(bench, float(each.start[-1]) + AVERAGING, rng)
    rows = starts.astype(np.int64)  # one a second
    kept = Motion(*(getattr(each, one.name)[rows] for one in fields(each)))
    return kept, starts


def _laboratory(bench: Bench, starts: Array, rng: np.random.Generator) -> Climate:
    """Return the conditions in the laboratory: one temperature with a small wave."""
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


def column(what: str, axis: str) -> str:
    """Return the name of a column: rate, temperature, built-in test or one of the references of a sensor."""
    return axis if what == "rate" else f"{axis}_{what}"


def save_starts(bench: Bench, duration: float, rng: np.random.Generator) -> Array:
    """Return where the averaging windows of a recording begin, whole seconds, shape (n,) [s]."""
    n = int(duration / INTERVAL) + 1
    steps = np.full(n, INTERVAL)
    pick = rng.random(n)
    for step, share in bench.steps.items():
        steps[(pick >= 0.0) & (pick < share)] = step
        pick -= share
    starts = np.concatenate([[0], np.cumsum(steps)])
    return np.asarray(starts[starts <= duration - AVERAGING], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Sensed:
    """What there is to be saved."""

    starts: Array  # starts of the averaging windows in the recording, (n,) [s]
    readings: Array  # along the body axes, (n, 3) [rad/s]
    temperature: Array  # temperature of the sensors, (n, 3) [degC]
    powered: float  # time from power-up to the start of the recording [s]
    begin: int  # start of the recording, UNIX time [s]


def saved(
    bench: Bench, unit: Unit, world: World, sensed: Sensed, others: dict[str, Array], rng: np.random.Generator
) -> Recording:
    """Return the recording, each average stamped at its end.

    Parameters
    ----------
    bench, unit, world : Bench, Unit, World
        As they are.
    sensed : Sensed
        Readings and temperatures.
    others : dict of str to ndarray, shape (n,)
        Columns that are not of a sensor; they come first.
    rng : numpy.random.Generator
        All draws come from it.
    """
    codes = _codes(bench, unit, world, sensed, rng)
    if not bench.reference_saved:
        del codes["ref"]
    real = {axis: AXES.index(sensor) for axis, sensor in zip(AXES, bench.wiring, strict=True)}
    columns = others | {column(what, axis): table[:, real[axis]] for what, table in codes.items() for axis in AXES}
    stamps = (sensed.begin + np.rint(sensed.starts + AVERAGING).astype(np.int64)) * SECOND
    channels = tuple(Channel(name, np.ascontiguousarray(values)) for name, values in columns.items())
    return Recording(channels, stamps, float(INTERVAL), AVERAGING, epoch="utc")


def _codes(bench: Bench, unit: Unit, world: World, sensed: Sensed, rng: np.random.Generator) -> dict[str, Array]:
    """Return mean codes of the five columns, shape (n, 3) each; the error of the converter is in all of them."""
    known, channel, gain = chain(bench), thermometer(bench), world.converter_gain
    references = gain * _references(unit, sensed.temperature, rng)
    along_sensors = sensed.readings * np.array(bench.inverted)
    rate, reference = averaged_codes(known, gain * along_sensors, references[0], AVERAGED)
    fine = replace(known, step=STEP / AVERAGED, codes=(CODES[0] * AVERAGED, CODES[1] * AVERAGED))
    reference_codes = np.clip(np.rint(references[1] / fine.step), CODES[0] * AVERAGED, CODES[1] * AVERAGED)
    volts = gain * channel.volts(sensed.temperature + world.thermometer)
    volts += rng.normal(0.0, unit.temperature_std, volts.shape)
    warm = to_temperature_counts(fine, channel.degrees(volts), reference=reference_codes)
    on = np.clip(sensed.powered + sensed.starts + AVERAGING - STARTED, 0.0, AVERAGING) / AVERAGING
    tested = np.rint(TESTED_VOLTS / STEP * on * AVERAGED) / AVERAGED
    return {
        "rate": rate,
        "temp": warm / AVERAGED,
        "bit": np.repeat(tested[:, None], 3, axis=1),
        "ref": reference,
        "temp_ref": reference_codes / AVERAGED,
    }


def _references(unit: Unit, temperature: Array, rng: np.random.Generator) -> Array:
    """Return the reference voltages of rate and temperature, shape (2, n, 3) [V]."""
    exact = np.stack([reference_volts(unit, which, temperature) for which in (0, 1)])
    return np.asarray(exact + rng.normal(0.0, unit.reference_std, exact.shape))
