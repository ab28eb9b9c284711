"""Masses on springs and dampers on a shaker, in time: the exact steps of one state space.

It imports nothing of the package and shares nothing with ``shaker``: no modal sum is made here. With the positions z
relative to the table and its acceleration u::

    M z'' + C z' + K z = -M 1 u            reading of mass j: (z'' + u)_j = -(M^-1 (C z' + K z))_j

Natural frequencies and amplifications are those of the eigenvalues of the state matrix (f = |l| / 2 pi,
Q = |l| / (2 |Re l|)), transmissibilities its frequency response. The input is held over 1 / `FINE` of a sample, which
delays all alike and changes no eigenvalue; sizes by sinc(f / rate).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

Array = NDArray[np.float64]
FINE = 8  # steps a sample of the record


@dataclass(frozen=True, eq=False)
class Item:
    """Masses, dampers and springs, shape (n, n) each, and the mass that is read."""

    m: Array
    c: Array
    k: Array
    read: int = 0

    @property
    def states(self) -> tuple[Array, Array, Array]:
        """A, B, C of the state space."""
        n = len(self.m)
        inverse = linalg.inv(self.m)
        a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ self.k, -inverse @ self.c]])
        b = np.concatenate([np.zeros(n), -np.ones(n)])[:, None]
        return a, b, a[n + self.read][None]

    def modes(self) -> Array:
        """Natural frequency [Hz], Q and transmissibility of each mode, in order; shape (n, 3)."""
        values = linalg.eigvals(self.states[0])
        values = values[values.imag > 0.0]
        values = values[np.argsort(np.abs(values))]
        f = np.abs(values) / (2.0 * np.pi)
        return np.column_stack([f, np.abs(values) / (-2.0 * values.real), np.abs(self.ratio(f))])

    def ratio(self, frequency: Array) -> NDArray[np.complex128]:
        """Reading over the acceleration of the table."""
        a, b, c = self.states
        own = np.eye(len(a))
        return np.array([(c @ linalg.solve(2j * np.pi * f * own - a, b))[0, 0] for f in np.atleast_1d(frequency)])


def oscillators(frequency: list[float], q: list[float], mass: list[float]) -> Item:
    """The first mass stands on the table, the others on the first; what each alone would have on a rigid base."""
    n = len(frequency)
    w, m = 2.0 * np.pi * np.array(frequency), np.array(mass)
    k, c = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n):
        one = np.zeros(n)
        one[i] = 1.0
        if i:
            one[0] = -1.0
        k += m[i] * w[i] ** 2 * np.outer(one, one)
        c += m[i] * w[i] / q[i] * np.outer(one, one)
    return Item(np.diag(m), c, k)


def swept(
    start: float, stop: float, per_minute: float, rate: float, rng: np.random.Generator, *, level: float = 0.25,
    quiet: float = 0.5, ripple: float = 0.05, harmonic: float = 0.003,
) -> Array:  # fmt: skip
    """Acceleration of the table at `FINE` times the rate: a logarithmic sweep with ripple and a second harmonic."""
    length = 60.0 * abs(math.log2(stop / start)) / per_minute
    t = np.arange(round((length + 2.0 * quiet) * rate) * FINE) / (FINE * rate) - quiet
    octaves = np.clip(t, 0.0, length) * per_minute / 60.0 * (1.0 if stop > start else -1.0)
    f = start * 2.0**octaves
    phase = 2.0 * np.pi * np.cumsum(f) / (FINE * rate) + rng.uniform(0.0, 2.0 * np.pi)
    size = 1.0 + ripple * np.sin(2.0 * np.pi * (0.8 * octaves + rng.random()))
    on = np.clip(np.minimum(t, length - t) / 0.05, 0.0, 1.0)
    return np.asarray(level * on * size * (np.sin(phase) + harmonic * np.sin(2.0 * phase + 1.0)))


def read(item: Item, table: Array, rate: float, *later: tuple[int, Item]) -> Array:
    """Reading at the fine rate; of an item that becomes another one at some fine samples, with its positions."""
    out, state = [], np.zeros(2 * len(item.m))
    items, starts = [item, *(one for _, one in later)], [0, *(at for at, _ in later)]
    for one, first, last in zip(items, starts, [*starts[1:], len(table)], strict=True):
        a, b, c = one.states
        ad, bd, cd, _, _ = signal.cont2discrete((a, b, c, np.zeros((1, 1))), 1.0 / (FINE * rate), method="zoh")
        values, vectors = linalg.eig(ad)
        push = linalg.solve(vectors, bd[:, 0].astype(complex))
        now = linalg.solve(vectors, state.astype(complex))
        seen = np.zeros(last - first, dtype=complex)
        part = table[first:last]
        for j, pole in enumerate(values):  # x[n+1] = pole x[n] + push u[n]
            own = signal.lfilter([0.0, push[j]], [1.0, -pole], part.astype(complex), zi=[now[j]])[0]
            now[j] = pole * own[-1] + push[j] * part[-1]
            seen += (cd[0] @ vectors[:, j]) * own
        state = (vectors @ now).real
        out.append(seen.real)
    return np.concatenate(out)


def pink(n: int, rng: np.random.Generator) -> Array:
    """Noise of 1/f with a standard deviation of one."""
    lines = np.fft.rfft(rng.standard_normal(n))
    lines[1:] /= np.sqrt(np.arange(1, len(lines)))
    lines[0] = 0.0
    found = np.fft.irfft(lines, n)
    return np.asarray(found / np.std(found))


def sampled(values: Array, size: float, rng: np.random.Generator, colour: str = "white") -> Array:
    """Values at the rate of the record, with noise."""
    kept = values[::FINE]
    noise: Callable[[int], Array] = rng.standard_normal if colour == "white" else lambda n: pink(n, rng)
    return np.asarray(kept + size * noise(len(kept)))
