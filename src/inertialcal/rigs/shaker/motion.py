"""Motion of table and item: the drive in time, the item by its exact transmissibility in frequency.

The record is padded with zeros as long as the slowest mode swings, and multiplied by the closed form of its spectrum:
no filter bends the axis of frequency (a bilinear one shows a mode of 700 Hz at 688.5 Hz, sampled at 5 kHz).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...core.estimate import Array
from .setup import NODES, PLAIN, STEPS_DB, Bench

SWING = 12.0  # decay times for which a mode still swings
HARMONICS = (2, 3)
PASSED = 0.45  # of the sample rate, by the filter of the recorder


@dataclass(frozen=True, eq=False)
class Item:
    """Modes of an item: frequency [Hz], Q, part along and across the drive; shape (k, 4)."""

    modes: Array

    def transmissibility(self, frequency: Array, across: bool = False) -> NDArray[np.complex128]:
        """Return its acceleration over that of the table, along the drive or across it."""
        s = 1j * frequency
        gains = self.modes[:, 3 if across else 2]
        found = np.full(len(frequency), 0.0 if across else 1.0 - gains.sum(), dtype=complex)
        for (own, q, *_), gain in zip(self.modes, gains, strict=True):
            damped = s * (own / q)
            found += gain * (own**2 + damped) / (own**2 - frequency**2 + damped)
        return found


def fixture_ratio(bench: Bench, frequency: Array) -> NDArray[np.complex128]:
    """Return the second control accelerometer over the first: a mode of the fixture lies between them."""
    own, q = bench.fixture
    damped = 1j * frequency * (own / q)
    return (own**2 + damped) / (own**2 - frequency**2 + damped)


def duration(bench: Bench) -> float:
    """Return how long the sweep lasts [s]."""
    return float(60.0 * abs(np.log2(bench.stop / bench.start)) / (bench.per_minute * bench.speed))


def drive(bench: Bench, clock_error: float, rng: np.random.Generator) -> Array:
    """Return the acceleration of the table at the instants of the samples [g].

    Parameters
    ----------
    bench : Bench
        The sweep.
    clock_error : float
        Rate of the samples over that which is said, less one.
    rng : numpy.random.Generator
        For the ripple and the phase.
    """
    length = duration(bench)
    n = round((length + 2.0 * bench.quiet) * bench.sample_rate)
    t = np.arange(n) / (bench.sample_rate * (1.0 + clock_error)) - bench.quiet
    k = np.sign(bench.stop - bench.start) * bench.per_minute * bench.speed * np.log(2.0) / 60.0
    inside = np.clip(t, 0.0, length)
    cycles = bench.start * np.expm1(k * inside) / k
    on = np.clip(np.minimum(t, length - t) / bench.ramp, 0.0, 1.0)
    turns = rng.uniform(0.0, 2.0 * np.pi, 1 + len(HARMONICS))
    wave = np.sin(2.0 * np.pi * cycles + turns[0])
    for m, turn in zip(HARMONICS, turns[1:], strict=True):
        passed = m * bench.start * np.exp(k * inside) < PASSED * bench.sample_rate
        wave += bench.distortion * passed * np.sin(2.0 * np.pi * m * cycles + turn)
    if bench.clipped:
        wave = np.clip(wave, -bench.clipped, bench.clipped)
    octave = np.log2(bench.start) + k * inside / np.log(2.0)
    shape = sum(np.sin(2.0 * np.pi * (c * octave + p)) for c, p in zip((0.31, 0.74, 1.3), rng.random(3), strict=True))
    return np.asarray(bench.level * on * wave * (1.0 + bench.ripple * shape / np.sqrt(1.5)))


def random_drive(bench: Bench, rng: np.random.Generator) -> Array:
    """Return the acceleration of the table in the random run at the instants of the samples [g].

    Gaussian noise of the profile (straight in logarithms between its nodes) with what the controller leaves uneven; the
    level steps up, and the table rests before and after.
    """
    length = 2.0 * bench.rest + bench.full_level + bench.step * len(STEPS_DB)
    n = fft.next_fast_len(round(length * bench.sample_rate))
    f = np.arange(n // 2 + 1) * bench.sample_rate / n
    nodes = np.array(NODES if bench.notched else PLAIN)
    inside = (f >= nodes[0, 0]) & (f <= nodes[-1, 0])
    density = np.zeros(len(f))
    density[inside] = np.exp(np.interp(np.log(f[inside]), np.log(nodes[:, 0]), np.log(nodes[:, 1])))
    knots = np.arange(0.0, f[-1] + 25.0, 25.0)
    uneven = bench.random_db + bench.unevenness_db * np.interp(f, knots, rng.standard_normal(len(knots)))
    size = np.sqrt(density * 10.0 ** (uneven / 10.0) * bench.sample_rate * n / 4.0)
    lines = size * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f)))
    kept = round(length * bench.sample_rate)
    t = np.arange(kept) / bench.sample_rate - bench.rest
    steps = np.clip((t / bench.step).astype(np.int64), 0, len(STEPS_DB))
    gain = 10.0 ** (np.array([*STEPS_DB, 0.0]) / 20.0)
    shaken = (t >= 0.0) & (t < length - 2.0 * bench.rest)
    return np.asarray(fft.irfft(lines, n)[:kept] * np.where(shaken, gain[steps], 0.0))


def moved(bench: Bench, table: Array, item: Item, clock_error: float) -> dict[str, Array]:
    """Return what moves as the channels see it [g]: both control accelerometers, and the item along and across."""
    rate = bench.sample_rate * (1.0 + clock_error)
    slowest = float(np.max(item.modes[:, 1] / (np.pi * item.modes[:, 0])))
    n = fft.next_fast_len(len(table) + round(SWING * slowest * rate))
    lines, frequency = fft.rfft(table, n), np.arange(n // 2 + 1) * rate / n
    ways = {
        "control_2": fixture_ratio(bench, frequency),
        "x": item.transmissibility(frequency),
        "y": item.transmissibility(frequency, across=True),
    }
    found = {name: fft.irfft(lines * way, n)[: len(table)] for name, way in ways.items()}
    return {"control_1": table, **found}
