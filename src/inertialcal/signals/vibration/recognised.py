"""Whether a channel is vibration of a shaker: random at a steady level, or a swept sine.

Of a file of which nobody said anything, so that what is not clearly one is none.

*Random*: some windows in a row, a second at least, hold one level but for chance; there the channel is Gaussian by its
kurtosis, has a statistical bandwidth of at least `WIDTH`, and next to nothing below `LOW`, as everything has that is
turned, carried or driven. *Swept*: window after window one line holds nearly all of the mean square, and its frequency
goes over an octave or more, up, down, or up and down. Assumed: a level that a resting sensor never has, where the unit
is known (`RANDOM_LEVEL`, `SWEPT_LEVEL`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array

Kind = Literal["random", "swept", ""]

RANDOM_LEVEL, SWEPT_LEVEL = 0.5, 0.1  # rms [m/s^2]
SLOWEST, LONGEST = 200.0, 4_000_000  # samples a second; samples of a record that is looked at
MISSING = 0.01  # of the samples: a few are bridged
WINDOW, FEWEST = 0.25, 8  # [s]; windows
LOUD = 0.5  # of the high level, from which a window belongs to it (mean square)
ALIKE = 1.5  # windows of one level [dB]
PART = 0.1  # of the record, that it lasts
STEADY = 2.5, 0.25  # its scatter, over that by chance; and [dB]
KURTOSIS = 2.5, 3.7
WIDTH, LOW, BELOW = 40.0, 10.0, 0.03  # [Hz]; [Hz], and the share of the mean square below that
PURE, NEARLY, ALL = 0.8, 0.9, 3.0  # share of one line; share of the windows; lines on either side
SLIDE = 0.05  # of its frequency, that a line may move within a window
OCTAVES = 1.0


def recognised(x: Array, interval: float, known: bool = True) -> Kind:
    """Return what vibration a channel holds; empty where it is not clearly one.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Channel, NaN where a sample is missing [m/s^2].
    interval : float
        From sample to sample [s].
    known : bool
        The unit is known: levels below those of shakers are none.
    """
    size = max(round(WINDOW / interval), 64)
    count = len(x) // size
    if count < FEWEST or len(x) > LONGEST or interval * SLOWEST > 1.0:
        return ""
    there = np.isfinite(x)
    if np.count_nonzero(~there) > MISSING * len(x):
        return ""
    if not there.all():
        at = np.arange(len(x))
        x = np.interp(at, at[there], x[there])
    parts = x[: count * size].reshape(count, size)
    with np.errstate(over="ignore", invalid="ignore"):
        squares = np.var(parts, axis=1)
        high = float(np.percentile(squares, 90.0))
        level = np.sqrt(high)
        if not np.isfinite(high) or high <= 0.0 or (known and level < SWEPT_LEVEL):
            return ""
        if is_swept(parts, squares > 0.04 * high, interval):
            return "swept"
        return "random" if (not known or level >= RANDOM_LEVEL) and _is_random(parts, squares, interval) else ""


def _is_random(parts: Array, squares: Array, interval: float) -> bool:
    level = 10.0 * np.log10(np.maximum(squares, 1e-300))
    loud = squares > LOUD * float(np.percentile(squares, 90.0))
    middle = float(np.median(level[loud]))
    padded = np.concatenate([level[:1], level, level[-1:]])
    smooth = np.median([padded[:-2], padded[1:-1], padded[2:]], axis=0)  # one window that strays is chance
    first, stop = longest(np.abs(smooth - middle) < ALIKE)
    count, size = stop - first, parts.shape[1]
    if count < max(FEWEST // 2, 1.0 / (size * interval), PART * len(parts)):
        return False
    x = parts[first:stop].ravel()
    x = x - x.mean()
    kurtosis = float(np.mean(x**4) / np.mean(x**2) ** 2)
    if not KURTOSIS[0] < kurtosis < KURTOSIS[1]:
        return False
    frequency, density = spectrum(x, interval)
    spacing = float(frequency[1] - frequency[0])
    width = spacing * float(np.sum(density)) ** 2 / float(np.sum(density**2))
    low = float(np.sum(density[frequency < LOW])) / float(np.sum(density))
    chance = 10.0 / np.log(10.0) / np.sqrt(width * size * interval)
    return width > WIDTH and low < BELOW and float(np.std(level[first:stop])) < STEADY[0] * chance + STEADY[1]


def is_swept(parts: Array, loud: NDArray[np.bool_], interval: float) -> bool:
    """Return whether windows, shape (k, m), hold one line that goes over an octave or more, of those that are loud."""
    first, stop = longest(loud)
    if stop - first < FEWEST or stop - first < NEARLY * np.count_nonzero(loud):
        return False
    size = parts.shape[1]
    windows = parts[first:stop] - parts[first:stop].mean(axis=1, keepdims=True)
    power = np.abs(np.fft.rfft(windows * np.hanning(size), axis=1)) ** 2
    peak = np.argmax(power, axis=1)
    half = ALL + SLIDE * peak
    near = np.abs(np.arange(power.shape[1]) - peak[:, np.newaxis]) <= half[:, np.newaxis]
    pure = np.where(near, power, 0.0).sum(axis=1) / np.maximum(power.sum(axis=1), 1e-300)
    if np.count_nonzero(pure > PURE) < NEARLY * len(pure) or np.log2(max(peak.max(), 1) / max(peak.min(), 1)) < OCTAVES:
        return False
    return any(_turns_once(peak, int(turn)) for turn in (np.argmax(peak), np.argmin(peak)))


def _turns_once(peak: NDArray[np.integer], turn: int) -> bool:
    """Whether lines go one way up to a turn, and the other way from there on, but for one window in ten."""
    for sign in (1, -1):
        steps = np.concatenate([sign * np.diff(peak[: turn + 1]), -sign * np.diff(peak[turn:])])
        if np.count_nonzero(steps < -1) <= (1.0 - NEARLY) * len(steps):
            return True
    return False


def spectrum(x: Array, interval: float) -> tuple[Array, Array]:
    """Return frequencies [Hz] and density without scale of a record, by windows of about 2 Hz."""
    size = min(len(x), max(round(0.5 / interval), 64))
    windows = x[: len(x) // size * size].reshape(-1, size)
    power = np.mean(np.abs(np.fft.rfft(windows * np.hanning(size), axis=1)) ** 2, axis=0)
    return np.asarray(np.fft.rfftfreq(size, interval)), np.asarray(power)


def longest(marked: NDArray[np.bool_]) -> tuple[int, int]:
    """Return first and stop of the longest run of true values; (0, 0) where there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(int)))
    runs: Sequence[tuple[int, int]] = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    return max(runs, key=lambda run: run[1] - run[0], default=(0, 0))


__all__ = ["LONGEST", "Kind", "is_swept", "longest", "recognised", "spectrum"]
