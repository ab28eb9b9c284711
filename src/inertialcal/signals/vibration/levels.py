"""Level of a random vibration over time: its steps, the part at full level, whether that stays.

The record is cut into windows of equal length; the level of a window is its mean square about its own mean, over the
control channels. Windows are long enough for some hundred degrees of freedom, so that chance moves a level by 0.3 dB.

*Full level* is the highest level that lasts: at least a second, and a tenth of the time of the longest level of the
record, window after window. A window belongs to it within 1.5 dB of the median of its windows, or four deviations by
chance where that is more (a narrow spectrum). A single window that strays is chance and is filled in. Windows beside a
change of level hold a part of it and are not used for spectra, but count in the duration, whose error is that of two
ends inside a window.

Whether the full level stays is judged by its windows against each other: chance alone gives the sum of their squared
deviations, over the variance that the degrees of freedom ask for, a chi-square distribution; and a slope over time the
t distribution of a fitted line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from .profile import decibels

Flags = NDArray[np.bool_]

DOF = 300.0  # of a window
SHORTEST, FEWEST, MANY = 0.1, 20, 50  # of a window [s]; windows of a record, and so many where it can be
ALIKE, BY_CHANCE = 1.5, 4.0  # windows of one level lie so near its median [dB], [deviations by chance]
FAR = 3.0  # a single window may stray so far from its level [dB]
LASTS, PART = 1.0, 0.1  # of a level: so long at least [s]; so much of the longest one
OFF = 30.0  # below the highest window, from which the table stands still [dB]
STEP = 0.25  # between levels that are tried [dB]
RUN = 3  # windows that make a level of their own


@dataclass(frozen=True)
class Stretch:
    """Windows of one level, one after another."""

    start: float  # Since the first sample [s]
    stop: float
    level: float  # Median, against full level [dB]
    full: bool  # Whether it is full level


@dataclass(frozen=True, eq=False)
class Levels:
    """Level of a record over time.

    Parameters
    ----------
    time, level : ndarray, shape (w,)
        Middle of each window since the first sample [s], and its level against full level [dB]; NaN where samples are
        missing.
    full, inner : ndarray of bool, shape (w,)
        Windows at full level, and those of them that are beside no change.
    mean_square : float
        Of full level [unit^2].
    window : float
        Length of a window [s].
    size : int
        The same in samples.
    dof : float
        Of the mean square of a window.
    alike : float
        Windows of one level lie so near its median [dB].
    stretches : tuple of Stretch
        All levels, in order of time; where the table stands still there is none.
    """

    time: Array
    level: Array
    full: Flags
    inner: Flags
    mean_square: float
    window: float
    size: int
    dof: float
    alike: float
    stretches: tuple[Stretch, ...]

    @property
    def duration(self) -> float:
        """Time at full level [s]."""
        return self.window * int(np.count_nonzero(self.full))

    @property
    def u_duration(self) -> float:
        """Standard uncertainty of it: each end lies anywhere in a window [s]."""
        edges = int(np.count_nonzero(np.diff(self.full.astype(int), prepend=0, append=0)))
        return self.window * math.sqrt(max(edges, 1) / 12.0)

    @property
    def interruptions(self) -> int:
        """How often full level was left and reached again."""
        return max(0, sum(one.full for one in self.stretches) - 1)

    @property
    def above(self) -> float:
        """Time above full level [s]."""
        return self.window * int(np.count_nonzero(~self.full & (self.level > self.alike)))

    @property
    def deviation(self) -> float:
        """Standard deviation of the level of a window by chance [dB]."""
        return deviation_of(self.dof)

    def samples(self, n: int) -> Flags:
        """Return the samples at full level that are used for spectra, shape (n,)."""
        found = np.zeros(n, dtype=bool)
        inside = np.repeat(self.inner, self.size)
        found[: len(inside)] = inside
        if len(self.inner) and self.inner[-1]:
            found[len(inside) :] = True  # the rest of the record, shorter than a window
        return found

    def stationarity(self) -> tuple[float, float, float]:
        """Return the chance of so much scatter at full level, that of its slope, and the slope [dB over its length]."""
        use = self.inner & np.isfinite(self.level)
        level, time = self.level[use], self.time[use]
        if len(level) < RUN:
            return 1.0, 1.0, 0.0
        away = level - level.mean()
        scatter = float(special.chdtrc(len(level) - 1.0, np.sum(away**2) / self.deviation**2))
        about = time - time.mean()
        slope = float(about @ away / (about @ about))
        u = self.deviation / math.sqrt(float(about @ about))
        return scatter, float(2.0 * special.ndtr(-abs(slope / u))), slope * float(np.ptp(time))


def find_levels(x: Array, interval: float, width: float) -> Levels:
    """Return the level of a record over time, and where it is at full level.

    Parameters
    ----------
    x : ndarray, shape (n, c)
        Control channels; NaN where a sample is missing [unit].
    interval : float
        From sample to sample [s].
    width : float
        Statistical bandwidth of the vibration (``Profile.width``) [Hz].

    Raises
    ------
    DataError
        ``too_short`` for a record of fewer than 20 windows; ``no_vibration`` where nothing moves.
    """
    n = len(x)
    least = max(8, math.ceil(SHORTEST / interval))
    wanted = math.ceil(DOF / (2.0 * width) / interval)
    size = max(least, min(wanted, n // MANY))  # of a narrow spectrum windows have fewer degrees of freedom
    count = n // size
    if count < FEWEST:
        what = f"{n * interval:.4g} s of vibration: its level over time takes {FEWEST * size * interval:.4g} s"
        raise DataError(what, do="Record longer", code="too_short")
    power = mean_squares(x, size)
    if not np.nanmax(power, initial=0.0) > 0.0:
        raise DataError(
            "the control channels do not move",
            do="Check cables and range of the control accelerometers",
            code="no_vibration",
        )
    raw = decibels(power)
    dof = 2.0 * width * size * interval
    alike = max(ALIKE, BY_CHANCE * deviation_of(dof))
    top = _full_level(raw, size * interval, alike)
    level = raw - top
    time = (np.arange(count, dtype=np.float64) + 0.5) * (size * interval)
    full = _filled(_bridged(np.abs(level) <= alike, np.isnan(level)), level, FAR + alike - ALIKE)
    stretches, edges = _stretches(level, full, size * interval, alike)
    inner = full & ~edges
    inner = inner if inner.any() else full
    return Levels(time, level, full, inner, float(10.0 ** (top / 10.0)), size * interval, size, dof, alike, stretches)


def mean_squares(x: Array, size: int) -> Array:
    """Return the mean square of each window about its own mean, over the channels.

    Parameters
    ----------
    x : ndarray, shape (n,) or (n, c)
        Channels; NaN where a sample is missing [unit].
    size : int
        Samples of a window.

    Returns
    -------
    ndarray, shape (n // size,)
        [unit^2]; NaN where over half of the samples of a channel are missing.
    """
    count = len(x) // size
    parts = x[: count * size].reshape(count, size, -1)
    known = np.isfinite(parts)
    count = np.count_nonzero(known, axis=1)
    there = np.where(known, parts, 0.0)
    mean = there.sum(axis=1) / np.maximum(count, 1)
    squares = np.where(known, (there - mean[:, np.newaxis]) ** 2, 0.0).sum(axis=1)
    variance: Array = squares / np.where(2 * count >= parts.shape[1], count, np.nan)
    power: Array = variance.mean(axis=1)
    return power


def pieces(level: Array, apart: float) -> list[tuple[int, int]]:
    """Return the windows of each level, first and one past the last, one after another.

    A new one begins where a window, and the median of three from it on, are further away than ``apart`` from the median
    of the piece so far [dB].
    """
    found, start = [], 0
    for i in range(1, len(level) + 1):
        middle = np.median(level[start:i])
        if i == len(level) or min(abs(level[i] - middle), abs(np.median(level[i : i + 3]) - middle)) > apart:
            found.append((start, i))
            start = i
    return found


def _bridged(full: Flags, unknown: Flags) -> Flags:
    """Return the windows at full level, with those whose samples are missing between two of them."""
    known = np.flatnonzero(~unknown)
    found = full.copy()
    for i in np.flatnonzero(unknown).tolist():
        before, after = known[known < i], known[known > i]
        found[i] = len(before) > 0 and len(after) > 0 and bool(full[before[-1]] and full[after[0]])
    return found


def deviation_of(dof: float) -> float:
    """Return the standard deviation by chance of a level of so many degrees of freedom [dB]."""
    return float(decibels(math.e)) * math.sqrt(float(special.polygamma(1, 0.5 * dof)))


def _full_level(raw: Array, window: float, alike: float) -> float:
    """Return the highest level that lasts [dB]."""
    highest = float(np.nanmax(raw))
    on = raw[np.isfinite(raw) & (raw > highest - OFF)]
    candidates = np.arange(highest, float(on.min()) - STEP, -STEP)
    longest = [_longest_run(np.abs(raw - one) <= alike) for one in candidates.tolist()]
    needed = max(math.ceil(LASTS / window), math.ceil(PART * max(longest)), RUN)
    at = next(i for i, one in enumerate(longest) if one >= min(needed, max(longest)))
    best = float(candidates[at])
    for _ in range(20):  # to the middle of the level that it stands at the edge of
        near = on[np.abs(on - best) <= alike]
        middle = float(np.median(near))
        if middle == best:
            break
        best = middle
    return best


def _longest_run(marked: Flags) -> int:
    """Return the length of the longest stretch of marks."""
    edges = np.flatnonzero(np.diff(marked.astype(np.int8), prepend=0, append=0))
    return int(np.max(edges[1::2] - edges[0::2], initial=0))


def _filled(full: Flags, level: Array, far: float) -> Flags:
    """Return the windows at full level, with single ones filled in and single ones elsewhere left out."""
    found = full.copy()
    for i in range(1, len(full) - 1):
        if not full[i] and full[i - 1] and full[i + 1] and abs(level[i]) <= far:
            found[i] = True
    edges = np.flatnonzero(np.diff(found.astype(int), prepend=0, append=0))
    for a, b in zip(edges[0::2], edges[1::2], strict=True):
        if b - a < RUN:
            found[a:b] = False
    return found if found.any() else full


def _stretches(level: Array, full: Flags, window: float, alike: float) -> tuple[tuple[Stretch, ...], Flags]:
    """Return the levels one after another, and the windows beside a change from or to full level."""
    found: list[Stretch] = []
    edges = np.zeros(len(level), dtype=bool)
    n, i = len(level), 0
    while i < n:
        j, own = i + 1, [level[i]]
        while j < n and full[j] == full[i] and (full[i] or abs(level[j] - np.median(own[-20:])) <= alike):
            own.append(level[j])
            j += 1
        if full[i]:
            edges[i] |= i > 0
            edges[j - 1] |= j < n
        middle = float(np.nanmedian(own)) if np.isfinite(own).any() else math.nan
        if (full[i] or j - i >= RUN) and middle > -OFF:
            found.append(Stretch(i * window, j * window, middle, bool(full[i])))
        i = j
    return tuple(found), edges


__all__: Sequence[str] = ("Levels", "Stretch", "find_levels", "mean_squares", "pieces")
