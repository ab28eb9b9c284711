"""Records at rest: white noise, flicker, walks, ramps, rounding, filters, lines, drift of temperature.

Equations of the field, not of any package. Two-sided spectra of the rate (IEEE Std 952, annex C; 1293, annex)::

    white N                 N^2                            N in deg/s sqrt(s); deg/sqrt(h) = 1/60 of it
    flicker B               B^2 / (2 pi f)
    rate random walk K      K^2 / (2 pi f)^2
    rate ramp R             R t
    rounded angle Q         the angle is rounded to steps of sqrt(12) Q, a sample is its difference over the interval
    first order, corner c   N^2 / (1 + (f/c)^2)
    second order            N^2 / ((1 - (f/c)^2)^2 + (2 z f/c)^2)

Stationary noises are drawn exactly from their covariance (circulant embedding, Davies and Harte 1987), a walk exactly
with its averages, flicker by the fractional difference of order one half (Kasdin 1995) with a burn-in as long as the
record.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import fftconvolve

from .case import START, Array, Case, Table


@dataclass(frozen=True)
class Noise:
    """Terms of one axis, in the unit of the file and seconds; angles of ``lines`` in rad."""

    white: float = 0.0  # N [unit sqrt(s)]
    flicker: float = 0.0  # B [unit]
    walk: float = 0.0  # K [unit / sqrt(s)]
    ramp: float = 0.0  # R [unit / s]
    rounded_angle: float = 0.0  # Q [unit s]
    corner: float = 0.0  # of a low pass on the white noise [Hz]; 0: none
    order: int = 1  # of that low pass
    damping: float = np.sqrt(0.5)  # of the second order
    lines: tuple[tuple[float, float], ...] = ()  # (amplitude, frequency [Hz])
    temperature: float = 0.0  # [unit / degC]
    thermostat: tuple[float, float] = (0.0, 0.0)  # peak to peak [unit], period [s]; a sine
    bias: float = 0.0


GYRO = {
    "angle_random_walk": 60.0,
    "bias_instability": 3600.0,
    "rate_random_walk": 3600.0 * 60.0,
    "rate_ramp": 3600.0**2,
}
ACC = {
    "velocity_random_walk": 1e6,
    "bias_instability": 1e6,
    "acceleration_random_walk": 1e6,
    "acceleration_ramp": 3.6e9,
}


def still(
    seed: int,
    noises: dict[str, Noise] | Noise,
    n: int = 90_000,
    rate: float = 50.0,
    *,
    sensor: str = "gyro",
    counts: float = 0.0,
    step: float = 0.0,
    limit: float = np.inf,
    jitter: float = 0.0,
    lost: tuple[tuple[int, int], ...] = (),
    temperature: tuple[float, float] = (25.0, 25.0),
    pad: bool = False,
) -> Case:
    """Return a record of one sensor at rest, and its terms as the command prints them.

    ``counts``: units of the file a count, written as integers (``step`` rounds without counting). ``limit``: end of the
    range. ``jitter``: standard deviation of a time stamp in parts of the interval. ``lost``: (first, number) of samples
    that are missing. ``temperature``: first and last. ``pad``: an archive pair (accelerations in g) instead of CSV.
    """
    rng = np.random.default_rng([1, seed])
    axes = noises if isinstance(noises, dict) else dict.fromkeys("xyz", noises)
    unit, factors = ("deg/s", GYRO) if sensor == "gyro" else ("g", ACC)
    time = np.arange(n) / rate
    warmth = np.linspace(*temperature, n)
    stamps = START + time + (jitter / rate) * rng.uniform(-np.sqrt(3.0), np.sqrt(3.0), n) if jitter else START + time
    columns: dict[str, Array] = {"unix_s": stamps}
    signals: list[str] = []
    truth: dict[str, float] = {}
    for axis, noise in axes.items():
        values = np.clip(drawn(rng, noise, n, 1.0 / rate, warmth), -limit, limit)
        if step:
            values = step * np.rint(values / step)
        if counts:
            name, values = f"{sensor}_{axis} [count]", np.rint(values / counts).astype(np.int64)
        else:
            name = f"{sensor}_{axis} [{unit}]"
        columns[name] = values
        signals.append(name)
        sizes = (noise.white * aliased(noise, 1.0 / rate), noise.flicker, noise.walk, noise.ramp)
        truth |= {
            f"{key} {axis}": size * factor for (key, factor), size in zip(factors.items(), sizes, strict=True) if size
        }
        if noise.rounded_angle:
            truth[f"quantization {axis}"] = noise.rounded_angle * (3600.0 if sensor == "gyro" else 9.80665)
    table = Table(columns, tuple(signals), "unix_s", form={"unix_s": "%.6f"})
    if temperature[0] != temperature[1]:
        table.columns["temperature [degC]"], table.temperature = warmth, "temperature [degC]"
        table.form["temperature [degC]"] = "%.3f"
    keep = np.ones(n, dtype=bool)
    for first, number in lost:
        keep[first : first + number] = False
    table.taken(keep)
    words = ["allan", "@still.csv"]
    if counts:
        words += ["--scale-factor", f"{sensor}={1.0 / counts!r} count/({unit})"]
    if pad:
        table.kind, table.pad, words = "pad", {"rate": rate}, ["allan", "@"]
    first_noise = next(iter(axes.values()))
    spread = np.sqrt(first_noise.white**2 * rate) if not first_noise.corner else float(np.std(columns[signals[0]]))
    return Case("allan", {"still.csv": table}, words, truth, noise=float(spread), rate=rate, rng_seed=seed)


def drawn(rng: np.random.Generator, noise: Noise, n: int, dt: float, warmth: Array | None = None) -> Array:
    """Return n samples of one axis, each the mean over its interval (a low pass is sampled, not averaged)."""
    time: Array = dt * np.arange(n, dtype=float)
    values: Array = np.full(n, noise.bias) + noise.ramp * time
    if noise.white:
        values += low_passed(rng, noise, n, dt) if noise.corner else noise.white / np.sqrt(dt) * rng.standard_normal(n)
    if noise.flicker:
        values += flicker(rng, noise.flicker, n)
    if noise.walk:
        values += walk(rng, noise.walk, n, dt)
    if noise.rounded_angle:
        step = np.sqrt(12.0) * noise.rounded_angle
        angle = np.concatenate([[0.0], np.cumsum(values) * dt]) + rng.uniform(0.0, step)
        values = np.diff(step * np.rint(angle / step)) / dt
    for amplitude, frequency in noise.lines:
        values += amplitude * np.sin(2.0 * np.pi * frequency * time + rng.uniform(0.0, 2.0 * np.pi))
    size, period = noise.thermostat
    if size:
        values += 0.5 * size * np.sin(2.0 * np.pi * time / period + rng.uniform(0.0, 2.0 * np.pi))
    if warmth is not None and noise.temperature:
        values += noise.temperature * (warmth - warmth[0])
    return values


def flicker(rng: np.random.Generator, size: float, n: int) -> Array:
    """Return flicker of the one-sided spectrum size^2 / (pi f): white noise through (1 - 1/z)^(-1/2)."""
    total = 2 * n
    weights = np.cumprod(np.concatenate([[1.0], (np.arange(1, total) - 0.5) / np.arange(1, total)]))
    values: Array = size * fftconvolve(rng.standard_normal(total), weights)[n:total]
    return values


def walk(rng: np.random.Generator, size: float, n: int, dt: float) -> Array:
    """Return means over dt of a walk of size^2 a second: ends and means jointly, covariance dt (1, 1/2; 1/2, 1/3)."""
    ends = size * np.sqrt(dt) * rng.standard_normal(n)
    means = 0.5 * ends + size * np.sqrt(dt / 12.0) * rng.standard_normal(n)
    values: Array = np.concatenate([[0.0], np.cumsum(ends)[:-1]]) + means
    return values


def low_passed(rng: np.random.Generator, noise: Noise, n: int, dt: float) -> Array:
    """Return white noise after its low pass, sampled; exact by its covariance."""
    m = 1 << int(np.ceil(np.log2(2 * n)))
    lags = dt * np.minimum(np.arange(m), m - np.arange(m))
    power = np.clip(np.fft.rfft(covariance(noise, lags)).real, 0.0, None)
    spectrum = rng.standard_normal(len(power)) + 1j * rng.standard_normal(len(power))
    spectrum[[0, -1]] = spectrum[[0, -1]].real * np.sqrt(2.0)
    values: Array = np.fft.irfft(np.sqrt(power * m / 2.0) * spectrum, m)[:n]
    return values


def covariance(noise: Noise, lags: Array) -> Array:
    """Return the covariance of low-passed white noise at lags [s] (Papoulis, chapter on linear systems)."""
    w = 2.0 * np.pi * noise.corner
    if noise.order == 1:
        values: Array = noise.white**2 * w / 2.0 * np.exp(-w * lags)
        return values
    z = noise.damping
    v = w * np.sqrt(1.0 - z * z)
    shape = np.exp(-z * w * lags) * (np.cos(v * lags) + z * w / v * np.sin(v * lags))
    second: Array = noise.white**2 * w / (4.0 * z) * shape
    return second


def aliased(noise: Noise, dt: float) -> float:
    """Return by how much sampling raises the lowest level of low-passed white noise (folded spectrum at f = 0)."""
    if not noise.corner or not noise.white:
        return 1.0
    far = max(64, int(20.0 / (2.0 * np.pi * noise.corner * dt)))
    sums = covariance(noise, dt * np.arange(far, dtype=float))
    return float(np.sqrt(dt * (sums[0] + 2.0 * np.sum(sums[1:])))) / noise.white


def spectrum(noise: Noise, frequency: Array) -> Array:
    """Return the one-sided spectrum of the terms, before sampling."""
    shape = np.ones_like(frequency)
    if noise.corner:
        q = frequency / noise.corner
        shape = 1.0 / (1.0 + q**2) if noise.order == 1 else 1.0 / ((1.0 - q**2) ** 2 + (2.0 * noise.damping * q) ** 2)
    w = 2.0 * np.pi * frequency
    values: Array = 2.0 * noise.white**2 * shape + 2.0 * noise.flicker**2 / w + 2.0 * noise.walk**2 / w**2
    return values


def allan_variance(noise: Noise, tau: Array) -> Array:
    """Return the Allan variance of the terms without a filter, for tau well above the interval (IEEE 952, annex C)."""
    return np.asarray(
        noise.white**2 / tau
        + 2.0 * np.log(2.0) / np.pi * noise.flicker**2
        + noise.walk**2 * tau / 3.0
        + noise.ramp**2 * tau**2 / 2.0
        + 3.0 * noise.rounded_angle**2 / tau**2
    )


def deviation(values: Array, m: int) -> float:
    """Return the overlapping Allan deviation over m samples."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    second = total[2 * m :] - 2.0 * total[m:-m] + total[: -2 * m]
    return float(np.sqrt(0.5 * np.mean((second / m) ** 2)))
