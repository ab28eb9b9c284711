"""Records with and without faults, made by numpy alone: nothing here comes from inertialcal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rng = np.random.Generator


def flicker(rng: Rng, n: int) -> Array:
    """Noise of a density that falls as 1/f, shaped in the frequency domain over four times the record."""
    m = 4 * n
    f = np.fft.rfftfreq(m)
    f[0] = f[1]
    spectrum = (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))) * f**-0.5
    x = np.fft.irfft(spectrum, m)[:n]
    return np.asarray(x / np.std(np.diff(x)))


def walk(rng: Rng, n: int) -> Array:
    return np.cumsum(rng.standard_normal(n))


def low_pass(x: Array, order: int, corner: float = 0.1) -> Array:
    """Filter of first order, so many times; corner over the sample rate: 5 Hz at 50 Hz."""
    a = float(np.exp(-2.0 * np.pi * corner))
    for _ in range(order):
        response = a ** np.arange(64)
        x = np.convolve(x, (1.0 - a) * response)[: len(x)]
    return x


def white(rng: Rng, n: int) -> Array:
    return rng.standard_normal(n)


def mixed(rng: Rng, n: int) -> Array:
    return rng.standard_normal(n) + 0.05 * flicker(rng, n) + 3e-3 * walk(rng, n)


def quantised(step: float) -> Callable[[Rng, int], Any]:
    def record(rng: Rng, n: int) -> Any:
        return np.rint((rng.standard_normal(n) + 1e-3 * walk(rng, n)) / step + rng.uniform(-100, 100)).astype(np.int32)

    return record


def filtered(order: int) -> Callable[[Rng, int], Any]:
    return lambda rng, n: low_pass(rng.standard_normal(n + 64), order)[64:]


def heavy(rng: Rng, n: int) -> Array:
    return rng.laplace(size=n)


def warming(rng: Rng, n: int) -> Array:
    """Warm-up and a temperature that falls again, of up to ten standard deviations."""
    t = np.arange(n) / n
    rise = rng.uniform(-10.0, 10.0) * np.exp(-t / rng.uniform(0.2, 1.0)) + rng.uniform(-10.0, 10.0) * t
    return rise + rng.standard_normal(n) + 0.02 * flicker(rng, n)


def earth(rng: Rng, n: int) -> Array:
    """A sine of 0.2 to 4 periods in the record, of up to ten standard deviations."""
    phase = 2.0 * np.pi * (rng.uniform(0.2, 4.0) * np.arange(n) / n + rng.uniform())
    return rng.uniform(0.0, 10.0) * np.sin(phase) + rng.standard_normal(n)


def coarse_drift(rng: Rng, n: int) -> Any:
    """Steps of three standard deviations, over a drift of ten steps."""
    return np.rint((mixed(rng, n) + 30.0 * np.arange(n) / n) / 3.0).astype(np.int16)


CLEAN: dict[str, Callable[[Rng, int], Any]] = {
    "white": white,
    "flicker": flicker,
    "walk": walk,
    "mixed": mixed,
    "fine": quantised(0.05),
    "step 0.5": quantised(0.5),
    "step 1": quantised(1.0),
    "step 3": quantised(3.0),
    "coarse drift": coarse_drift,
    "first order": filtered(1),
    "second order": filtered(2),
    "second order, coarse": lambda rng, n: np.rint(filtered(2)(rng, n) * 4.0).astype(np.int16),
    "heavy": heavy,
    "warming": warming,
    "earth": earth,
    "float32": lambda rng, n: (9.8 + 1e-3 * mixed(rng, n)).astype(np.float32),
    "printed": lambda rng, n: np.round(mixed(rng, n), 3),
    "unsigned": lambda rng, n: np.rint(32768.0 + 30.0 * mixed(rng, n)).astype(np.uint16),
}


def record(kind: str, seed: int, n: int) -> Any:
    """Return a clean record."""
    return CLEAN[kind](np.random.default_rng([seed, sorted(CLEAN).index(kind)]), n)


# Faults. A gyro at 50 Hz in deg/h: angle random walk .1 deg/sqrt(h), bias instability about 1 deg/h

SIGMA = 0.1 * 60.0 * float(np.sqrt(50.0))


def gyro(rng: Rng, n: int) -> Array:
    return SIGMA * rng.standard_normal(n) + 2.0 * flicker(rng, n)


def counts(x: Array) -> NDArray[np.int16]:
    return np.rint(x / 20.0).astype(np.int16)


def spikes(rng: Rng) -> Any:
    """One sample in 10,000 is off by 50 standard deviations."""
    x = gyro(rng, 100_000)
    at = rng.random(len(x)) < 1e-4
    x[at] += 50.0 * SIGMA * rng.choice([-1.0, 1.0], int(at.sum()))
    return x


def bursts(rng: Rng) -> Any:
    x = gyro(rng, 100_000)
    for i in rng.integers(0, len(x) - 3, 10):
        x[i : i + 3] += 50.0 * SIGMA * rng.choice([-1.0, 1.0])
    return x


def level_step(rng: Rng) -> Any:
    """A step of 72 deg/h in half an hour."""
    x = gyro(rng, 90_000)
    x[int(len(x) * rng.uniform(0.1, 0.9)) :] += 72.0 * rng.choice([-1.0, 1.0])
    return x


def noise_change(rng: Rng) -> Any:
    x = gyro(rng, 90_000)
    x[int(len(x) * rng.uniform(0.2, 0.8)) :] *= 1.5
    return x


def thermostat(rng: Rng, cycles: int = 6, walking: float = 0.02) -> Any:
    """A wave of 14 deg/h and 10 minutes over flicker and a random walk."""
    n = 30_000 * cycles
    wave = 14.0 * np.sin(2.0 * np.pi * (np.arange(n) / 30_000.0 + rng.uniform()))
    return gyro(rng, n) + walking * walk(rng, n) + wave


def clipped(rng: Rng) -> Any:
    """A gyro that is turned by hand, at 100 Hz; one sample in 20 is beyond its range of 2.2 rad/s."""
    t = np.arange(20_000) / 100.0
    x = 0.003 * rng.standard_normal(len(t))
    for size, shortest, longest in ((1.35, 8.0, 20.0), (0.9, 2.0, 5.0)):
        x += size * np.sin(2.0 * np.pi * (t / rng.uniform(shortest, longest) + rng.uniform()))
    x *= 2.2 / np.quantile(np.abs(x), 0.95)
    return np.clip(x, -2.2, 2.2)


def clipped_noise(rng: Rng) -> Any:
    """Noise of ten codes; one sample in 20 lies beyond the range."""
    limit = 16
    return np.clip(np.rint(10.0 * rng.standard_normal(20_000)), -limit - 4, limit + 4).astype(np.int16)


def four_held(rng: Rng) -> Any:
    """A knock that takes four samples to the end of the range."""
    x = gyro(rng, 20_000)
    i = int(rng.integers(100, 19_000))
    x[i : i + 40] += 30.0 * SIGMA * np.sin(np.pi * np.arange(40) / 40.0)
    return np.minimum(x, np.partition(x, -4)[-4])


def stuck_half(rng: Rng) -> Any:
    x = gyro(rng, 90_000)
    x[45_000:] = x[45_000]
    return x


def stuck_counts(rng: Rng) -> Any:
    x = counts(gyro(rng, 90_000))
    x[:45_000] = x[45_000]
    return x


def stuck_briefly(rng: Rng) -> Any:
    x = gyro(rng, 90_000)
    i = int(rng.integers(0, 80_000))
    x[i : i + 30] = x[i]
    return x


def filled_in(rng: Rng) -> Any:
    """A tenth of the record is zero at its end, as a buffer that was not filled."""
    x = gyro(rng, 20_000) + 50.0
    x[18_000:] = 0.0
    return x


def appended(rng: Rng) -> Any:
    return np.tile(gyro(rng, 50_000), 2)


def appended_counts(rng: Rng) -> Any:
    return np.tile(counts(gyro(rng, 30_000)), 4)


def block_twice(rng: Rng) -> Any:
    """A block of 512 samples is stored twice."""
    x = counts(gyro(rng, 100_000))
    i = int(rng.integers(0, 90_000))
    return np.insert(x, i + 512, x[i : i + 512])


def saved_twice(rng: Rng) -> Any:
    """One sample in 50 is saved again in place of the next."""
    x = counts(gyro(rng, 20_000) * 4.0)
    at = rng.choice(len(x) - 1, len(x) // 50, replace=False)
    x[at + 1] = x[at]
    return x


def lost(rng: Rng) -> Any:
    x = gyro(rng, 20_000)
    x[rng.integers(0, 20_000, 5)] = np.nan
    return x


FAULTS: dict[str, tuple[Callable[[Rng], Any], str, bool]] = {  # record, code, whether at rest
    "spikes": (spikes, "glitch", True),
    "bursts": (bursts, "glitch", True),
    "step": (level_step, "level_step", True),
    "noise": (noise_change, "noise_change", True),
    "thermostat": (thermostat, "slow_wave", True),
    "thermostat, 12 periods": (lambda rng: thermostat(rng, 12), "slow_wave", True),
    "clipped": (clipped, "saturated", False),
    "clipped counts": (lambda rng: np.rint(clipped(rng) * 6000.0).astype(np.int16), "saturated", False),
    "clipped noise": (clipped_noise, "saturated", True),
    "four held": (four_held, "saturated", False),
    "stuck half": (stuck_half, "stuck", True),
    "stuck counts": (stuck_counts, "stuck", True),
    "stuck briefly": (stuck_briefly, "stuck", True),
    "filled in": (filled_in, "stuck", True),
    "appended": (appended, "repeated", True),
    "appended counts": (appended_counts, "repeated", True),
    "block twice": (block_twice, "repeated", True),
    "saved twice": (saved_twice, "repeated_samples", True),
    "lost": (lost, "missing", True),
}
