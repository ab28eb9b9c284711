"""A shaker with an item on it, in time: exact steps of each mode, the drive as straight lines between fine samples.

It imports nothing of the package. A mode of the item, driven by the acceleration u of the table, has
``q'' + 2 z w q' + w^2 q = u`` and adds ``g (2 z w q' + w^2 q)`` to the response, whose rigid part is ``1 - sum g``.
The step of a mode over a sample is the matrix exponential of its state with the input as a straight line (first-order
hold). The drive is computed `FINE` times as often as the channels are sampled: a straight line between samples at
1/80 of the period acts as the sine itself to 5e-4, at every frequency alike to the sharpness of a resonance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

Array = NDArray[np.float64]
FINE = 8


@dataclass(frozen=True)
class Mode:
    """Natural frequency [Hz], amplification, and its part of the motion."""

    frequency: float
    q: float
    gain: float = 1.0


@dataclass(frozen=True)
class Run:
    """A swept sine: from, to [Hz], octaves (or hertz) a minute, amplitude, sampling."""

    start: float = 20.0
    stop: float = 1000.0
    per_minute: float = 4.0
    linear: bool = False
    level: float = 0.25
    sample_rate: float = 5000.0
    quiet: float = 1.0  # before and after [s]
    ramp: float = 0.1  # of the level at both ends [s]
    harmonics: tuple[float, ...] = ()  # of the drive, from the second
    ripple: float = 0.0  # of the level, over 10 s

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        span = abs(self.stop - self.start) if self.linear else abs(math.log2(self.stop / self.start))
        return 60.0 * span / self.per_minute


def drive(run: Run, rng: np.random.Generator | None = None) -> Array:
    """Return the acceleration of the table at the fine rate, shape (n FINE,)."""
    rate = FINE * run.sample_rate
    n = round((run.duration + 2.0 * run.quiet) * run.sample_rate) * FINE
    t = np.arange(n) / rate - run.quiet
    way = 1.0 if run.stop > run.start else -1.0
    if run.linear:
        k = way * run.per_minute / 60.0
        cycles = run.start * t + 0.5 * k * t * t
    else:
        k = way * run.per_minute * math.log(2.0) / 60.0
        cycles = run.start * np.expm1(k * np.clip(t, 0.0, run.duration)) / k
    on = np.clip(np.minimum(t, run.duration - t) / max(run.ramp, 1e-9), 0.0, 1.0)
    turn = 0.0 if rng is None else float(rng.uniform(0.0, 2.0 * np.pi))
    wave = np.sin(2.0 * np.pi * cycles + turn)
    for m, size in enumerate(run.harmonics, 2):
        wave += size * np.sin(2.0 * np.pi * m * cycles + m * turn + m)
    return run.level * on * wave * (1.0 + run.ripple * np.sin(2.0 * np.pi * t / 10.0))


def response(modes: tuple[Mode, ...], table: Array, rate: float) -> Array:
    """Return the response to the acceleration of the table, both at one rate."""
    out = (1.0 - sum(one.gain for one in modes)) * table
    for one in modes:
        w = 2.0 * np.pi * one.frequency
        damping = w / one.q
        a = np.array([[0.0, 1.0], [-w * w, -damping]])
        h = 1.0 / rate
        block = np.zeros((4, 4))  # state, input, its slope: exp of it is the step with a straight line as input
        block[:2, :2], block[1, 2], block[2, 3] = a * h, h, 1.0
        step = linalg.expm(block)
        ad, b0, b1 = step[:2, :2], step[:2, 2], step[:2, 3]
        now, later = b0 - b1, b1
        c = one.gain * np.array([w * w, damping])
        # x[n+1] = ad x[n] + now u[n] + later u[n+1]; as a filter with z = x - later u
        num, den = signal.ss2tf(ad, (now + ad @ later)[:, None], c[None], np.array([[c @ later]]))
        out = out + signal.lfilter(num[0], den, table)
    return out


def recorded(
    modes: tuple[Mode, ...],
    run: Run,
    rng: np.random.Generator,
    noise: tuple[float, float] = (0.002, 0.002),
    colour: float = 0.0,
) -> tuple[Array, Array]:
    """Return what control and response record, with noise of their own (of first order, where ``colour`` is not 0)."""
    table = drive(run, rng)
    moved = response(modes, table, FINE * run.sample_rate)
    found = []
    for values, size in zip((table, moved), noise, strict=True):
        own = rng.standard_normal(len(values) // FINE)
        if colour:
            own = signal.lfilter([math.sqrt(1.0 - colour**2)], [1.0, -colour], own)
        found.append(values[::FINE] + size * own)
    return found[0], found[1]


def transmissibility(modes: tuple[Mode, ...], frequency: Array) -> NDArray[np.complex128]:
    """Return the closed form at some frequencies [Hz]."""
    s = 1j * frequency
    found = np.full(len(frequency), 1.0 - sum(one.gain for one in modes), dtype=complex)
    for one in modes:
        damped = one.frequency / one.q
        found += one.gain * (one.frequency**2 + damped * s) / (one.frequency**2 - frequency**2 + damped * s)
    return found
