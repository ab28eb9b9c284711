"""Delays of links to a computer that is busy, as they are known from measurements; nothing of the estimator is used.

Each returns when rows came [s] that were made every ``interval`` by a clock that is slow by ``DRIFT``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

DRIFT = 37e-6
Array = NDArray[np.float64]
Delays = Callable[[np.random.Generator, Array], Array]


def exponential(rng: np.random.Generator, t: Array) -> Array:
    return rng.exponential(2e-3, len(t))


def gamma(rng: np.random.Generator, t: Array) -> Array:
    """Three stages one after the other: hardly any row is as quick as can be."""
    return rng.gamma(3.0, 1e-3, len(t))


def bursts(rng: np.random.Generator, t: Array) -> Array:
    """Every few seconds others want the computer for a while."""
    found = rng.exponential(5e-4, len(t))
    for begin in rng.uniform(0.0, t[-1], rng.poisson(t[-1] / 4.0)):
        hit = (t >= begin) & (t < begin + rng.exponential(0.6))
        found[hit] += rng.exponential(0.02) + rng.exponential(0.02, hit.sum())
    return found


def walk(rng: np.random.Generator, t: Array) -> Array:
    """Load that walks at random, and is never negative."""
    steps = 2e-3 * np.sqrt(np.diff(t, prepend=t[0])) * rng.standard_normal(len(t))
    found: Array = np.abs(rng.normal(0.0, 2e-3) + np.cumsum(steps)) + rng.exponential(2e-3, len(t))
    return found


def episode(rng: np.random.Generator, t: Array) -> Array:
    """One long job, at any part of the record."""
    begin, end = np.sort(rng.uniform(0.0, t[-1], 2))
    return rng.exponential(1e-3, len(t)) + np.where((t > begin) & (t < end), 3e-3 + rng.exponential(6e-3, len(t)), 0.0)


def swell(rng: np.random.Generator, t: Array) -> Array:
    """Load that comes and goes within some seconds and makes all delays longer in proportion."""
    keep = np.exp(-(t[1] - t[0]) / 5.0)
    level, levels = rng.standard_normal(), []
    for shock in np.sqrt(1.0 - keep**2) * rng.standard_normal(len(t)):
        level = keep * level + shock
        levels.append(level)
    found: Array = np.exp(np.array(levels)) * (5e-4 + rng.exponential(1e-3, len(t)))
    return found


def preempted(rng: np.random.Generator, t: Array, length: float = 0.1, a_second: float = 1.5) -> Array:
    """The process does not run for 100 ms: all that came meanwhile is read after that."""
    found = rng.exponential(3e-4, len(t))
    for begin in rng.uniform(0.0, t[-1], rng.poisson(t[-1] * a_second)):
        hit = (t >= begin) & (t < begin + length)
        found[hit] = np.maximum(found[hit], begin + length - t[hit])
    return found


def stalled(rng: np.random.Generator, t: Array) -> Array:
    """Once, for 1 s."""
    return preempted(rng, t, 1.0, 1.0 / t[-1])


def frames(rng: np.random.Generator, t: Array, tick: float = 1e-3) -> Array:
    """USB asks every 1 ms."""
    phase = rng.uniform(0.0, tick)
    made = (1.0 + DRIFT) * t
    ready = made + rng.exponential(3e-5, len(t))
    return np.ceil((ready - phase) / tick) * tick + phase - made


def batches(rng: np.random.Generator, t: Array) -> Array:
    """A driver hands over what it has every 16 ms."""
    return frames(rng, t, 16e-3) + rng.exponential(1e-4, len(t))


def queue(rng: np.random.Generator, t: Array) -> Array:
    """A buffer that fills and empties: one server at 85 % of its capacity (Lindley's recursion)."""
    step = float(t[1] - t[0])
    wait, found = 0.0, []
    for service in rng.exponential(0.85 * step, len(t)).tolist():
        found.append(wait + service)
        wait = max(0.0, wait + service - step)
    return np.array(found)


KINDS: dict[str, Delays] = {
    one.__name__: one
    for one in (exponential, gamma, bursts, walk, episode, swell, preempted, stalled, frames, batches, queue)
}


def link(kind: str, seed: int, rows: int, interval: float = 0.02) -> tuple[Array, Array]:
    """Return the instrument's time of the last row of each lot, and when that came, by the computer [s]."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind)])
    t = interval * np.arange(rows, dtype=np.float64)
    came = np.maximum.accumulate((1.0 + DRIFT) * t + 1e-3 + KINDS[kind](rng, t))  # in order
    last = np.append(np.diff(came) > 2e-5, True)  # what came together is one lot
    return t[last], came[last]
