"""Noise of a record in blocks, from second differences: what a change of unit multiplies in every channel alike."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...core.batches.summaries import medians
from ...core.estimate import Array
from ..time.samples import Flags

BLOCKS = 400  # of which the noise is taken
BLOCK = 8  # fewest samples of a block
SAME_NOISE = 0.35  # of the logarithm of a factor
LEAST_NOISE = np.log(3.0)  # least change of the noise that can be a unit


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of blocks from second differences, natural logarithm, shape (blocks, channels); which channels have any."""

    size: int
    log: Array
    informative: Flags

    @classmethod
    def of(cls, x: Array) -> Noise:
        """Return the noise of a record, shape (n, channels)."""
        size = block_of(len(x))
        n = (len(x) - 2) // size
        second = np.abs(np.diff(np.ascontiguousarray(x.T), 2, axis=1))[:, : n * size].reshape(-1, n, size)
        with np.errstate(divide="ignore"):
            logs = np.log(second.mean(axis=2).T * np.sqrt(np.pi / 2.0 / 6.0))
        return cls(size, logs, np.mean(np.isfinite(logs), axis=0) > 0.9)

    def mapped(self, gain: Array) -> Noise:
        """Return the noise of channels that are ``gain`` times these."""
        return replace(self, log=self.log + np.log(np.abs(gain)))

    def rounding(self, x: Array, at: int) -> Array:
        """Return the standard deviation of rounding, over that of the noise before block ``at``."""
        apart = np.abs(np.diff(x, axis=0))
        least = 1e-9 * np.abs(x).max(axis=0)  # below it, two equal codes were rounded apart
        step = np.array([np.min(d[d > one], initial=np.inf) for d, one in zip(apart.T, least, strict=True)])
        step = np.where(np.isfinite(step), step, 0.0)
        ratio: Array = step / np.sqrt(6.0) / np.exp(middle_of(self.log[:at]))
        return ratio

    def ratio(self, at: int) -> Array:
        """Return the logarithm of the noise after over before block ``at``.

        NaN where a channel has no noise before or after.
        """
        return middle_of(self.log[at:]) - middle_of(self.log[:at])

    def u_ratio(self, at: int) -> Array:
        """Return the standard uncertainty of that logarithm."""
        parts = [self.log[:at], self.log[at:]]
        scatter = [np.median(np.abs(part - middle_of(part)), axis=0) for part in parts]
        before, after = ((1.4826 * 1.2533 * one) ** 2 / len(part) for one, part in zip(scatter, parts, strict=True))
        return np.asarray(np.sqrt(before + after))


def block_of(n: int) -> int:
    """Return the samples of a block of a record of so many."""
    return max(BLOCK, n // BLOCKS)


def middle_of(logs: Array) -> Array:
    """Return the median of each channel's finite logarithms; NaN where there are none."""
    if len(logs) and np.isfinite(logs.sum()):
        return medians(logs.T)
    finite = [column[np.isfinite(column)] for column in logs.T]
    return np.array([medians(column[None])[0] if len(column) else np.nan for column in finite])


def refined(x: Array, at: int, size: int, noise: Noise) -> int:
    """Return the sample at which the noise changes, near block ``at``: the most likely of two normal scales."""
    first, last = max(0, (at - 2) * size), min(len(x), (at + 2) * size)
    second = np.diff(x[first:last], 2, axis=0)
    a = middle_of(noise.log[:at]) + 0.5 * np.log(6.0)
    b = middle_of(noise.log[at:]) + 0.5 * np.log(6.0)
    gain = np.sum(0.5 * second**2 * (np.exp(-2.0 * b) - np.exp(-2.0 * a)) + b - a, axis=1)
    walk = np.concatenate([[0.0], np.cumsum(gain)])  # after is likelier where it falls
    quiet = bool(np.sum(b - a) < 0.0)
    # Second differences across the change are as large as the louder side's
    return first + int(np.argmax(walk)) + (0 if quiet else 2)
