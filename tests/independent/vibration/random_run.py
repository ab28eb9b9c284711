"""A random vibration run as a table would give it: Gaussian noise of a stated spectrum, several control channels.

Noise is made by random complex lines of the whole record, each with its own variance, and one inverse transform: its
density is the profile times the controller's error at every frequency. Control channels share a part of the noise
(``coherence``) and have a rest of their own. Levels are steps in time. Nothing of the product is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
G = 9.80665
TABLE_1 = ((20.0, 0.01), (80.0, 0.04), (500.0, 0.04), (2000.0, 0.01))  # g^2/Hz, with the knee where the slope is


@dataclass(frozen=True)
class Run:
    """What a run is."""

    nodes: tuple[tuple[float, float], ...] = TABLE_1
    rate: float = 5120.0  # [Hz]
    duration: float = 60.0  # at full level [s]
    level: float = 0.0  # of all of it [dB]
    error: float = 0.5  # standard deviation of the controller's error, smooth over frequency [dB]
    channels: int = 1
    coherence: float = 1.0  # of two control channels
    steps: tuple[tuple[float, float], ...] = ()  # (level [dB], time [s]) before full level
    clip: float = 0.0  # of the drive, in its own rms; 0 for none
    tones: tuple[tuple[float, float], ...] = ()  # (frequency [Hz], amplitude [g])
    floor: float = 1e-7  # outside of the profile [g^2/Hz]


def density(nodes: tuple[tuple[float, float], ...], frequency: Array, floor: float = 0.0) -> Array:
    """Return the density [g^2/Hz]."""
    f, s = np.array(nodes).T
    inside = (frequency >= f[0]) & (frequency <= f[-1])
    found = np.full(len(frequency), floor)
    found[inside] = np.exp(np.interp(np.log(frequency[inside]), np.log(f), np.log(s)))
    return found


def controller(frequency: Array, deviation: float, rng: np.random.Generator) -> Array:
    """Return the controller's error [dB]: a few waves over the logarithm of frequency."""
    if not deviation:
        return np.zeros(len(frequency))
    x = np.log(np.maximum(frequency, 1.0))
    found = np.zeros(len(frequency))
    for _ in range(6):
        found += rng.normal() * np.sin(rng.uniform(1.0, 6.0) * x + rng.uniform(0.0, 2.0 * np.pi))
    return np.asarray(found * deviation / np.sqrt(3.0))


def noise(spectrum: Array, rate: float, n: int, rng: np.random.Generator) -> Array:
    """Return n samples of Gaussian noise; ``spectrum`` at the lines of the whole record [unit^2/Hz]."""
    lines = rng.normal(size=(2, len(spectrum))) * np.sqrt(spectrum * rate * n / 4.0)
    return np.fft.irfft(lines[0] + 1j * lines[1], n)


def simulate(run: Run, seed: int) -> tuple[Array, Array, Array]:
    """Return control channels (n, c) [m/s^2], and frequency and true density of the controlled mean [g^2/Hz]."""
    rng = np.random.default_rng([seed, 29])
    total = run.duration + sum(time for _, time in run.steps)
    n = round(total * run.rate)
    n += n % 2
    frequency = np.arange(n // 2 + 1, dtype=np.float64) * (run.rate / n)
    true = density(run.nodes, frequency, run.floor) * 10.0 ** (
        0.1 * (run.level + controller(frequency, run.error, rng))
    )
    shared = np.sqrt(run.coherence)
    common = noise(true, run.rate, n, rng)
    if run.clip:
        limit = run.clip * common.std()
        common = np.clip(common, -limit, limit)
    time = np.arange(n) / run.rate
    gain, start = np.ones(n), 0.0
    for level, length in run.steps:
        gain[(time >= start) & (time < start + length)] = 10.0 ** (level / 20.0)
        start += length
    channels = []
    for _ in range(run.channels):
        own = noise(true, run.rate, n, rng) if run.coherence < 1.0 else np.zeros(n)
        # coherence is that of two channels with equal spectra: (shared share)^2
        mixed = np.sqrt(shared) * common + np.sqrt(1.0 - shared) * own if run.channels > 1 else common
        for f, amplitude in run.tones:
            mixed = mixed + amplitude * np.sin(2.0 * np.pi * f * time + 0.3)
        channels.append(gain * mixed * G)
    return np.column_stack(channels), frequency, true
