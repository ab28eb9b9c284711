"""Pulses that the accelerometer of the mesa rig counts in the dwells of a run, and readings of its tilt meter.

Readings are whole pulses of a gate, the phase of the pulses running on through the moves::

    pulses/s = bias + S (applied + g tilt) + drift + noise        meter = tilt + mercury + noise

The drift is a cubic, the saw-tooth of a thermostat, flicker noise and a random walk. The pad tilts with the mass that
is moved on it: the accelerometer feels that as gravity, and the mercury of the meter is attracted by the mass besides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...core.constants import STANDARD_GRAVITY
from ...core.estimate import Array
from ...physics.motion.travel import ORDER, Travel, Window, drive, travel_of_table
from ..parts.noise import flicker
from ..twin import DrawnError
from .setup import GATE, MERCURY_AMPLITUDE, RANGES, STOPS, UG, WORK, Bench, Run

FLOOR = 1.3863  # 2 ln 2: Allan variance of flicker noise over its h
PERIOD = (25.0, 40.0)  # of the thermostat [dwells]
RISE = 0.85  # of its period in which it heats
DEGREES = 0.1  # swing of the temperature [degC]
RESOLUTION = 1e-10  # of the tilt meter [rad]
CM, NG = 0.01, 1e-3 * UG
# Vertical position [cm], attraction along the input axis [ng].
TABLE_3 = (
    (7.6, 71.280), (10.2, 69.623), (12.7, 67.571), (15.2, 65.103), (17.8, 62.196), (20.3, 58.823), (22.9, 54.970),
    (25.4, 50.658), (27.9, 45.979), (30.5, 41.127), (33.1, 36.372), (35.6, 31.954), (38.1, 28.003), (40.7, 24.548),
    (43.2, 21.562), (45.7, 18.994), (48.2, 16.788),
)  # fmt: skip


@dataclass(frozen=True)
class Drawn:
    """True values, unknown to the reduction."""

    scale_factor: float  # of the accelerometer [pulses/s/(m/s^2)]
    applied_error: float  # relative error of the applied input of the schedule (1)
    pad_tilt: float  # amplitude in phase with the attraction [rad]
    mercury: float  # amplitude of the mercury in phase with it [rad]
    errors: tuple[DrawnError, ...] = ()  # of the standards


@dataclass(frozen=True, eq=False)
class Record:
    """Rows that the logger saved: number of the dwell (n,), pulses (n,), tilt [rad], temperature [degC]."""

    dwell: NDArray[np.int64]
    pulses: NDArray[np.int64]
    tilt: Array
    temperature: Array


def nominal(bench: Bench) -> float:
    """Return the scale factor of the data sheet [pulses/s/(m/s^2)]."""
    return RANGES[bench.range] / UG


def record(bench: Bench, drawn: Drawn, run: Run, own_scale: float, rng: np.random.Generator) -> Record:
    """Return the record of a run.

    Parameters
    ----------
    bench : Bench
        The campaign.
    drawn : Drawn
        Its truth.
    run : Run
        Which.
    own_scale : float
        What the scale factor of this run differs by, relative (1).
    rng : numpy.random.Generator
        Of all draws.
    """
    n = bench.dwells
    _, position, planned = schedule_table(bench)
    felt = _felt(bench, drawn, run, position, rng)
    shape = (planned - 0.5 * (planned.max() + planned.min())) / (0.5 * np.ptp(planned))
    if run.moved:
        shape = _late(bench, run, shape)
    moving = shape if run.moved else np.zeros(n)
    noise = WORK if run.work else 1.0
    tilt = drawn.pad_tilt * moving + noise * _wandering(bench.pad_noise, n, rng)
    scale = drawn.scale_factor * (1.0 + own_scale)
    warm, drift = _drift(bench, noise, rng)
    rate = bench.bias_ug * UG * scale + scale * (felt + STANDARD_GRAVITY.value * tilt) + drift
    pulses = np.floor(rate * GATE + rng.random(n))
    meter = tilt + drawn.mercury * moving + bench.meter_noise * rng.standard_normal(n) + rng.normal(0.0, 1e-6)
    meter = np.round(meter / RESOLUTION) * RESOLUTION
    kept = _kept(bench, run, rng)
    return Record(kept, pulses[kept].astype(np.int64), meter[kept], np.round(warm[kept], 4))


def _felt(bench: Bench, drawn: Drawn, run: Run, position: Array, rng: np.random.Generator) -> Array:
    """Return what the mass applies in each dwell, about its middle [m/s^2]; a mass at rest applies nothing new."""
    at = position + bench.stop_scatter * rng.standard_normal(len(position))
    if not run.moved:
        return np.zeros(len(position))
    whole = bench.lighter * travel().at(_late(bench, run, at))
    return np.asarray((whole - whole.mean()) * (1.0 + drawn.applied_error))


def _late(bench: Bench, run: Run, values: Array) -> Array:
    """Return values of dwells of a mass that missed one move."""
    if bench.slipped is None or bench.slipped[0] != run.name:
        return values
    at = bench.slipped[1]
    return np.concatenate([values[:at], values[at - 1 : -1]])


def _wandering(size: float, n: int, rng: np.random.Generator) -> Array:
    """Return the tilt of the pad by itself: noise of a dwell, and a slow part [rad]."""
    return np.asarray(size * (rng.standard_normal(n) + 0.2 * np.cumsum(rng.standard_normal(n))))


def _drift(bench: Bench, noise: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return temperature [degC] and drift with noise [pulses/s]."""
    n = bench.dwells
    t = np.linspace(-1.0, 1.0, n)
    smooth = bench.cubic * np.polynomial.legendre.legval(t, [0.0, *rng.normal(0.0, 1.0, 3)])
    phase = (np.arange(n) / rng.uniform(*PERIOD) + rng.random()) % 1.0
    saw = np.where(phase < RISE, phase / RISE, (1.0 - phase) / (1.0 - RISE)) - 0.5
    slow = flicker(bench.flicker**2 / FLOOR, n, 1, rng)[:, 0] + np.cumsum(rng.normal(0.0, bench.walk, n))
    white = rng.normal(0.0, bench.white, n)
    return 22.0 + DEGREES * saw, smooth + bench.thermostat * saw + noise * (slow + white)


def _kept(bench: Bench, run: Run, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return the dwells whose reading is none of the errors of the counter."""
    good = rng.random(bench.dwells) >= bench.lost
    good[[0, -1]] = True
    kept = np.flatnonzero(good)
    if bench.cut is not None and bench.cut[0] == run.name:
        kept = kept[kept < bench.cut[1]]
    return kept


def amplitude_of_mercury(bench: Bench, error: float) -> float:
    """Return the true tilt of the mercury, with an error of what is computed [rad]; of a lighter mass less."""
    return bench.lighter * (MERCURY_AMPLITUDE + error)


@lru_cache(1)
def travel() -> Travel:
    """Return the field of the mass along its travel [m/s^2], upper stop first [m]."""
    position, field = np.array(TABLE_3).T
    return travel_of_table(CM * position, NG * field)


def cycle(bench: Bench) -> tuple[Array, Array]:
    """Return positions [m] and fields [m/s^2] of the dwells of one cycle."""
    positions, fields = _cycle(bench.drive)
    return positions, bench.lighter * fields


@lru_cache(2)
def _cycle(kind: str) -> tuple[Array, Array]:
    one = drive(travel(), Window(*STOPS, 0.0), "ABAB" if kind == "ABAB" else "sine")
    return one.positions, one.fields


def schedule_table(bench: Bench) -> tuple[Array, Array, Array]:
    """Return start [s], position [m] and field [m/s^2] of the dwells of a run, as they are planned."""
    positions, fields = cycle(bench)
    each = np.arange(bench.dwells) % len(positions)
    start: Array = np.arange(bench.dwells, dtype=np.float64) * (bench.dwell + bench.move)
    return start, positions[each], fields[each]


def dwells_a_cycle(bench: Bench) -> int:
    """Return how many."""
    return len(ORDER["ABAB" if bench.drive == "ABAB" else "sine"])
