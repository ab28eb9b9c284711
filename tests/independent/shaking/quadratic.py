"""A sensor on a shaker: random vibration at levels between rests, read by a quadratic sensor, fast, then filtered.

The true reading at a fast rate, with the acceleration a::

    y = bias + drift t + k1 (h * a) + k2 a^2 + growth a_rms white + white

and, where they are asked for, hum of the mains in y, a bend in its drift, and a low pass of the sensor over all of it
but its noise. h is a first-order low pass; y and a are low-passed and decimated to the rate of the record, by plain
convolution with a windowed sinc. So the mean over a level is bias + k2 a_rms^2, with a_rms of the fast acceleration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import fftconvolve

from ..case import Array, Table

G = 9.80665
FAST = 4  # samples of the truth a sample of the record


@dataclass(frozen=True)
class Shaken:
    """Truth of the sensor and of the run, SI."""

    k2: float = 1e-7  # [rad/s/(m/s^2)^2]
    k1: float = 2e-6  # [rad/s/(m/s^2)]
    bias: float = 1e-3
    drift: float = 1e-7  # [rad/s / s]
    wander: float = 0.0  # standard deviation of the bias from stretch to stretch, and of its steps
    white: float = 1e-4  # of a sample of the record, at rest
    growth: float = 0.0  # of white noise with the level [rad/s/(m/s^2)]
    shift: float = 0.0  # of the bias where the vibration begins
    levels: tuple[float, ...] = (0.0, 10.0, 20.0, 30.0, 0.0)  # rms [m/s^2]
    seconds: float = 24.0  # of each
    rate: float = 400.0
    band: tuple[float, float] = (20.0, 120.0)  # of the vibration [Hz]; beyond half the rate it folds
    limit: float = np.inf
    axis: str = "x"
    filtered: bool = True
    hum: float = 0.0  # amplitude of 50.2 Hz in the reading
    bend: float = 0.0  # drift of the bias with the square of time, from the middle to an end of the record
    low_pass: float = 0.0  # cut-off of the sensor, first order; 0 for none [Hz]


def record(seed: int, truth: Shaken) -> Table:
    """Return the record: time, one axis, the control."""
    rng = np.random.default_rng([9, seed])
    fast = FAST * truth.rate
    parts, offsets = [], []
    n = round(truth.seconds * fast)
    shifted = 0.0
    for level in truth.levels:
        noise = np.fft.rfft(rng.standard_normal(n))
        frequency = np.fft.rfftfreq(n, 1.0 / fast)
        noise[(frequency < truth.band[0]) | (frequency > truth.band[1])] = 0.0
        x = np.fft.irfft(noise, n)
        parts.append(level * x / np.std(x))
        shifted = truth.shift if level else shifted
        offsets.append(np.full(n, shifted + truth.wander * rng.standard_normal()))
    a = np.concatenate(parts)
    time = np.arange(len(a)) / fast
    lag = np.exp(-np.arange(round(0.02 * fast)) * 2.0 * np.pi * 120.0 / fast)
    felt = fftconvolve(a, lag / lag.sum())[: len(a)]
    y = truth.bias + truth.drift * time + np.concatenate(offsets) + truth.k1 * felt + truth.k2 * a**2
    y = y + truth.bend * (2.0 * time / time[-1] - 1.0) ** 2
    if truth.low_pass:
        kernel = np.exp(-np.arange(round(3.0 / truth.low_pass * fast)) * 2.0 * np.pi * truth.low_pass / fast)
        kernel /= kernel.sum()
        y = fftconvolve(np.concatenate([np.full(len(kernel), y[0]), y]), kernel)[len(kernel) : len(kernel) + len(y)]
    y = y + truth.hum * np.sin(2.0 * np.pi * 50.2 * time + 2.0 * np.pi * rng.random()) if truth.hum else y
    a, y = (_decimated(one, truth.filtered) for one in (a, y))
    size = np.repeat(np.array(truth.levels), round(truth.seconds * truth.rate))[: len(a)]
    y = y + np.hypot(truth.white, truth.growth * size) * rng.standard_normal(len(y))
    y = np.clip(y, -truth.limit, truth.limit)
    a = a + 1e-3 * rng.standard_normal(len(a))
    columns = {"time [s]": np.arange(len(a)) / truth.rate, f"gyro_{truth.axis} [rad/s]": y, "control [g]": a / G}
    signals = (f"gyro_{truth.axis} [rad/s]",)
    return Table(columns, signals, "time [s]", form={"time [s]": "%.6f", "control [g]": "%.7g", signals[0]: "%.9e"})


def _decimated(values: Array, filtered: bool) -> Array:
    if not filtered:
        return values[::FAST]
    taps = np.arange(-64, 65)
    sinc = np.sinc(0.8 * taps / FAST) * np.hamming(len(taps))
    padded = np.concatenate([np.full(64, values[0]), values, np.full(64, values[-1])])
    low: Array = fftconvolve(padded, sinc / sinc.sum(), mode="valid")[::FAST]
    return low
