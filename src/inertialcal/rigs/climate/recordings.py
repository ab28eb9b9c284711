"""The recordings of the simulated test of sensitivities: one a power-up and, on the table, a turned axis.

A recording goes through visits: at each of them the supply, the pressure and the chamber stay, while the table goes
through its rates. Between two temperatures the table stands still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...physics.earth import earth_rate
from ..parts.gyro_bench import World, motion
from .setup import AIR_PA, AVERAGING, DEGREES, INTERVAL, VACUUM, VACUUM_PA, VOLTS, Bench
from .unit import Course, Unit, readings

BEGIN, DAY = 1_272_412_800, 86_400  # 2010-04-28 00:00:00 UTC [s]
SUPPLY_STD, THERMOMETER_STD, REFERENCE_STD, GAUGE = 2e-4, 0.02, 5e-5, 0.03  # [V], [degC], [V], part of the pressure
GROUPS = ("supply_air", "supply_vacuum", "scale", "table", "warm_up", "pressure")


@dataclass(frozen=True)
class Visit:
    """Conditions that stay while the table goes through some rates."""

    temperature: float
    volts: float
    pressure: float


def power_ups(bench: Bench, group: str) -> tuple[int, int]:
    """Return how many power-ups of a group are for the fit, and how many are held out."""
    if group == "warm_up":
        return len(bench.starts) * bench.warm_up_runs, len(bench.starts) * bench.warm_up_held_out
    if group == "table":
        return bench.table_runs, bench.table_held_out
    return bench.runs, 0 if group == "pressure" else bench.held_out


def names_of(bench: Bench, group: str) -> dict[str, tuple[int, str]]:
    """Return the recordings of a group: name -> power-up, axis that is turned or nothing."""
    runs = range(1, sum(power_ups(bench, group)) + 1)
    if group in ("scale", "table"):
        return {f"{group}_{axis}{run}": (run, axis) for run in runs for axis in AXES}
    return {f"{'warm' if group == 'warm_up' else group}_{run}": (run, "") for run in runs}


def file_of(name: str) -> str:
    """Return the file of a recording, in the campaign folder."""
    return f"recordings/{name}.csv"


def visits(bench: Bench, group: str, run: int) -> list[Visit]:
    """Return what a power-up goes through; every second one goes backward."""
    if group == "warm_up":
        return [Visit(bench.starts[(run - 1) % len(bench.starts)], VOLTS, AIR_PA)]
    if group == "table":
        return [Visit(DEGREES, VOLTS, AIR_PA)]
    supplies = (VOLTS,) * len(bench.supplies) if bench.unplugged else bench.supplies
    at = VACUUM_PA if group == f"supply_{VACUUM}" else AIR_PA
    each = [(VOLTS, level) for level in bench.levels] if group == "pressure" else [(one, at) for one in supplies]
    forward = [Visit(warmth, volts, level) for warmth in bench.temperatures for volts, level in each]
    return forward if run % 2 else forward[::-1]


def recording(
    bench: Bench, unit: Unit, world: World, group: str, run: int, axis: str, rng: np.random.Generator
) -> Recording:
    """Return one recording."""
    every = visits(bench, group, run)
    rates = {"scale": bench.rates_deg_s, "table": bench.table_deg_s}.get(group, (0.0, 0.0))
    long = {"warm_up": bench.warm_up_time, "pressure": bench.level_dwell}.get(group, bench.dwell)
    dwell = bench.turn if axis else 0.5 * (long - INTERVAL)
    waits = [
        60.0 * abs(b.temperature - a.temperature) / bench.ramp + bench.soak if a.temperature != b.temperature else 0.0
        for a, b in pairwise(every)
    ]
    ramps = [INTERVAL] * (len(rates) * len(every) - 1)
    for i, wait in enumerate(waits, 1):
        ramps[len(rates) * i - 1] += INTERVAL * round(wait / INTERVAL)
    turning = motion(np.radians(np.tile(rates, len(every))), dwell, ramps, INTERVAL, AVERAGING)
    begins = np.concatenate([[0.0], np.cumsum(dwell + np.array(ramps))])[:: len(rates)]
    middle = turning.start + 0.5 * AVERAGING
    powered = middle if group == "warm_up" else bench.warmed + middle
    one = _course(bench, every, begins, middle, powered)
    if axis:
        rate = world.body_rate(turning, axis)
    else:
        rate = np.asarray(world.levels["chamber"] @ earth_rate(world.latitude))[None, :]
    read = readings(unit, one, rate, every[0].temperature, rng)
    day = 100 * GROUPS.index(group) + run + 20 * (AXES.index(axis) if axis else 0)
    stamps = ((BEGIN + DAY * day) + np.rint(turning.start + AVERAGING).astype(np.int64)) * SECOND
    columns = {"supply": (bench.volts_per_unit * (one.volts + SUPPLY_STD * rng.standard_normal(len(middle))), 5)}
    columns["pressure"] = (one.pressure * np.exp(GAUGE * rng.standard_normal(len(middle))), 7)
    shown = one.temperature + world.thermometer + THERMOMETER_STD * rng.standard_normal(len(middle))
    columns["temperature"] = (shown, 3)
    if axis:
        columns["applied"] = (np.degrees(turning.rate) + 0.0, 6)
    away = np.column_stack([np.ones(len(middle)), one.volts - VOLTS, one.temperature - DEGREES])
    volts = away @ unit.references + REFERENCE_STD * rng.standard_normal((len(middle), 3))
    columns |= {f"{name}_ref": (volts[:, i], 5) for i, name in enumerate(AXES)}
    columns |= {name: (np.degrees(read[:, i]), 6) for i, name in enumerate(AXES)}
    channels = tuple(Channel(name, np.round(values, digits)) for name, (values, digits) in columns.items())
    return Recording(channels, stamps, INTERVAL, AVERAGING, epoch="utc")


def _course(bench: Bench, every: Sequence[Visit], begins: Array, middle: Array, powered: Array) -> Course:
    """Return the conditions of a power-up; the unit follows the chamber, which ramps before a visit begins."""
    here = np.searchsorted(begins, middle, side="right") - 1
    volts = np.array([one.volts for one in every])[here]
    pressure = np.array([one.pressure for one in every])[here]
    warmth = np.array([one.temperature for one in every])
    set_point = warmth[here]
    for i, begin in enumerate(begins[1:], 1):
        change = warmth[i] - warmth[i - 1]
        if change:
            wait = bench.soak + 60.0 * abs(change) / bench.ramp
            since = middle - (begin - wait)
            going = (since >= 0.0) & (since < wait)
            slope, tau = np.sign(change) * bench.ramp / 60.0, bench.time_constant
            end = wait - bench.soak
            up = np.minimum(since[going], end)
            lag = slope * tau * (1.0 - np.exp(-up / tau)) * np.exp(-np.maximum(since[going] - end, 0.0) / tau)
            set_point[going] = warmth[i - 1] + slope * up - lag
    return Course(powered, set_point, volts, pressure)
