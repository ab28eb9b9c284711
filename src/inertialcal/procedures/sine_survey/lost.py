"""Samples that a recorder lost during a sweep, by the phase of the drive.

Behind a loss of d seconds the drive is ahead of its law by ``d f(t)`` cycles: it steps by the part of a cycle that
``d f`` is at the loss, and goes on apart as its frequency changes. The step alone may be next to nothing, where nearly
a whole cycle was lost; what grows behind it is not. A shaker turns the phase of its drive as well, as it passes a
resonance of its own; but there step and growth do not belong to one d.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.estimate import Array
from .sweep import Sweep

PLACES = 80  # that are tried first
FEWEST = 4  # sums of cycles before and behind
BETTER = 0.1  # sum of squares of the phase with a loss, over that without, at most
ALIKE = 0.06  # by which the step may differ from what the growth says [cycles]
LEAST = 0.5  # of a sample, that is a loss
APART = 0.02  # least range of the phase that a loss explains [cycles]


class Loss(NamedTuple):
    """When [s] after the first sample of the record, and how many samples; fewer than none were put in."""

    time: float
    samples: float


def lost_samples(one: Sweep, rate: float) -> Loss | None:
    """Return the loss that explains the phase of a sweep; None where none does.

    Parameters
    ----------
    one : Sweep
        With the phase beside its law.
    rate : float
        Samples a second [Hz].
    """
    n = len(one.times)
    if n < 4 * FEWEST or float(np.ptp(one.left)) < APART:
        return None
    frequency = one.frequency(one.times)
    t = (one.times - one.times[0]) / np.ptp(one.times)
    smooth = np.column_stack([np.ones(n), t, frequency / frequency.max() if one.law == "log" else t * t,
                              *([t * frequency / frequency.max()] if one.law == "log" else [])])  # fmt: skip
    basis = np.linalg.qr(smooth)[0]
    without = float(np.sum(_beside(one.left, basis) ** 2))

    def tried(at: int) -> tuple[float, float, float]:
        """Return the sum of squares, the step [cycles] and the loss [s] of a place."""
        behind = np.zeros((n, 2))
        behind[at:] = np.column_stack([np.ones(n - at), frequency[at:] - frequency[at]])
        moved, left = _beside(behind, basis), _beside(one.left, basis)
        found = np.linalg.lstsq(moved, left, rcond=None)[0]
        return float(np.sum((left - moved @ found) ** 2)), float(found[0]), float(found[1])

    inner = np.arange(FEWEST, n - FEWEST)
    coarse = inner[:: max(1, len(inner) // PLACES)]
    best = min(coarse.tolist(), key=lambda at: tried(at)[0])
    reach = int(coarse[1] - coarse[0]) if len(coarse) > 1 else 0
    near = [at for at in range(best - reach, best + reach + 1) if FEWEST <= at < n - FEWEST]
    at = min(near, key=lambda one: tried(one)[0])
    rest, step, ahead = tried(at)
    cycles = ahead * float(frequency[at])
    explained = max(abs(step), abs(ahead) * float(np.ptp(frequency[at:])))
    apart = abs(step - cycles - round(step - cycles))
    if rest > BETTER * without or abs(ahead) * rate < LEAST or apart > ALIKE or explained < APART:
        return None
    return Loss(float(0.5 * (one.times[at - 1] + one.times[at])), ahead * rate)


def _beside(values: Array, basis: Array) -> Array:
    return np.asarray(values - basis @ (basis.T @ values))
