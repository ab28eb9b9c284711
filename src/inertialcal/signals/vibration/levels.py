"""Level of a random vibration over time: its steps, the part at full level, whether that stays.

The record is cut into windows of equal length; the level of a window is its mean square about its own mean, over the
control channels. Windows are long enough for some hundred degrees of freedom, so that chance moves a level by 0.3 dB.

*Full level* is the highest level that lasts: at least a second, and a tenth of the time of the longest level of the
record, window after window. A level above the one that the run was meant to have is none where a lower one is nearer to
that, and has lasted four times as long, or twice as long on both sides of it: it is a step upwards that was not meant.
A window belongs to full level within 1.5 dB of the median of its windows, or four deviations by chance where that is
more (a narrow spectrum). A single window that strays is chance and is filled in. What is lower than the rest at an end,
within these 1.5 dB, is the end of a ramp and does not belong to it: a slope, or a step, that lowers the sum of squares
by `RAMP` variances by chance. Windows beside a change of level hold a part of it and are not used for spectra, but
count in the duration, whose error is that of two ends inside a window.

Whether the full level stays is judged by its windows against each other: chance alone gives the sum of their squared
deviations, over the variance that the degrees of freedom ask for, a chi-square distribution; and a slope over time the
t distribution of a fitted line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

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
REMEMBERED = 500  # windows of a level that the next one is compared with
BRIEF, AMID = 0.25, 0.5  # of the time of a lower level, that a step upwards lasts; that one amid it lasts
RAMP, DEEP, END = 30.0, 1.0, 4  # variances by chance; dB at its end; parts of a stretch, of which it is one at most


@dataclass(frozen=True)
class Stretch:
    """Windows of one level, one after another."""

    start: float  # Since the first sample [s]
    stop: float
    level: float  # Median, against full level [dB]; minus infinity where the table stands still
    full: bool  # Whether it is full level
    dof: float = 0.0  # Of its mean square
    ends: tuple[float, float] | None = None  # Levels at both ends of a ramp [dB]; None where it is none


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
    rest : float
        What lies behind the last window, shorter than one: of the level of that [s].
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
    rest: float
    stretches: tuple[Stretch, ...]

    @property
    def duration(self) -> float:
        """Time at full level [s]."""
        return self.window * int(np.count_nonzero(self.full)) + (self.rest if self.full[-1] else 0.0)

    @property
    def u_duration(self) -> float:
        """Standard uncertainty of it: each end lies anywhere in a window [s]."""
        edges = int(np.count_nonzero(np.diff(self.full.astype(int), prepend=0, append=0)))
        return self.window * math.sqrt(max(edges, 1) / 12.0)

    @property
    def above(self) -> tuple[Stretch, ...]:
        """Steps upwards from full level: stretches above it, those that follow each other as one."""
        found: list[list[Stretch]] = []
        for one in self.stretches:
            if one.full or not one.level > self.alike:
                continue
            if found and one.start - found[-1][-1].stop < 0.5 * self.window:
                found[-1].append(one)
            else:
                found.append([one])
        longest = [max(each, key=lambda one: (one.dof, one.level)) for each in found]
        return tuple(
            replace(one, start=each[0].start, stop=each[-1].stop) for each, one in zip(found, longest, strict=True)
        )

    @property
    def left(self) -> tuple[Stretch, ...]:
        """Where full level was left and reached again, with the level in between."""
        full = [one for one in self.stretches if one.full]
        found = []
        for before, after in pairwise(full):
            inside = (self.time > before.stop) & (self.time < after.start)
            level = self.level[inside & np.isfinite(self.level)]
            middle = float(np.median(level)) if len(level) else math.nan
            still = len(level) > 0 and float(level.min()) <= -OFF
            found.append(Stretch(before.stop, after.start, -math.inf if still else middle, full=False))
        return tuple(found)

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

    def step(self) -> tuple[float, float, float]:
        """Return time [s] and size [dB] of the step that explains most of the scatter at full level, and its chance.

        The chance is 1 where a slope explains more.
        """
        use = self.inner & np.isfinite(self.level)
        level, time = self.level[use], self.time[use]
        n = len(level)
        if n < 2 * RUN:
            return 0.0, 0.0, 1.0
        before = np.arange(RUN, n - RUN + 1)
        sums = np.cumsum(level)
        sizes = (sums[-1] - sums[before - 1]) / (n - before) - sums[before - 1] / before
        gains = sizes**2 * before * (n - before) / n
        i = int(np.argmax(gains))
        about = time - time.mean()
        if float(about @ level) ** 2 / float(about @ about) > gains[i]:
            return 0.0, 0.0, 1.0
        at = 0.5 * float(time[before[i] - 1] + time[before[i]])
        return at, float(sizes[i]), min(1.0, 2.0 * n * float(special.ndtr(-math.sqrt(gains[i]) / self.deviation)))


def find_levels(x: Array, interval: float, width: float, meant: float) -> Levels:
    """Return the level of a record over time, and where it is at full level.

    Parameters
    ----------
    x : ndarray, shape (n, c)
        Control channels; NaN where a sample is missing [unit].
    interval : float
        From sample to sample [s].
    width : float
        Statistical bandwidth of the vibration (``Profile.width``) [Hz].
    meant : float
        Mean square that the run was meant to have [unit^2].

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
    top = _full_level(raw, size * interval, alike, float(decibels(meant)))
    level = raw - top
    time = (np.arange(count, dtype=np.float64) + 0.5) * (size * interval)
    full = _filled(_bridged(np.abs(level) <= alike, np.isnan(level)), level, FAR + alike - ALIKE)
    full = _without_ramps(full, level, deviation_of(dof))
    stretches, edges = _stretches(level, full, size * interval, alike, dof)
    inner = full & ~edges
    inner = inner if inner.any() else full
    window, rest = size * interval, (n - count * size) * interval
    return Levels(time, level, full, inner, float(10.0 ** (top / 10.0)), window, size, dof, alike, rest, stretches)


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

    A new one begins where a window, and the median of three from it on, are further away than ``apart`` [dB] from the
    median of the piece so far (of its last 500 windows).
    """
    found, start = [], 0
    for i in range(1, len(level) + 1):
        middle = np.median(level[max(start, i - REMEMBERED) : i])
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


def _full_level(raw: Array, window: float, alike: float, meant: float) -> float:
    """Return the highest level that lasts, and is no step upwards that was not meant [dB]."""
    levels = _lasting(raw, window, alike)
    for i, one in enumerate(levels):
        if not any(_stray(raw, one, lower, alike, meant) for lower in levels[i + 1 :]):
            return one
    return levels[-1]


def _lasting(raw: Array, window: float, alike: float) -> list[float]:
    """Return all levels that last, the highest first [dB]."""
    highest = float(np.nanmax(raw))
    on = raw[np.isfinite(raw) & (raw > highest - OFF)]
    candidates = np.arange(highest, float(on.min()) - STEP, -STEP)
    longest = [_longest_run(np.abs(raw - one) <= alike) for one in candidates.tolist()]
    needed = min(max(math.ceil(LASTS / window), math.ceil(PART * max(longest)), RUN), max(longest))
    found: list[float] = []
    for one, run in zip(candidates.tolist(), longest, strict=True):
        if run < needed or (found and one > found[-1] - 2.0 * alike):
            continue
        best = one
        for _ in range(20):  # to the middle of the level that it stands at the edge of
            near = on[np.abs(on - best) <= alike]
            middle = float(np.median(near))
            if middle == best:
                break
            best = middle
        if not found or best < found[-1] - alike:
            found.append(best)
    return found


def _stray(raw: Array, level: float, lower: float, alike: float, meant: float) -> bool:
    """Whether a level is a step upwards from a lower one, which is nearer to what was meant."""
    if abs(level - meant) <= abs(lower - meant):
        return False
    own, base = (np.flatnonzero(np.abs(raw - one) <= alike) for one in (level, lower))
    amid = base[0] < own[0] and own[-1] < base[-1]
    return len(own) <= (AMID if amid else BRIEF) * len(base)


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


def _without_ramps(full: Flags, level: Array, deviation: float) -> Flags:
    """Return the windows at full level without the ends of ramps that lead to it, or away from it."""
    found = full.copy()
    edges = np.flatnonzero(np.diff(full.astype(int), prepend=0, append=0))
    for a, b in zip(edges[0::2].tolist(), edges[1::2].tolist(), strict=True):
        own = level[a:b]
        found[a : a + _ramp(own, deviation)] = False
        found[b - _ramp(own[::-1], deviation) : b] = False
    return found


def _ramp(level: Array, deviation: float) -> int:
    """Return how many windows at the beginning of a stretch lie below the rest, as a slope or a step."""
    most = len(level) // END
    if most < RUN:
        return 0
    away = np.nan_to_num(level - np.nanmedian(level[most:]))
    found, best = 0, RAMP * deviation**2
    for n in range(RUN, most + 1):
        for shape in (np.ones(n), np.arange(n, 0.0, -1.0)):
            size = float(shape @ away[:n]) / float(shape @ shape)
            less = size**2 * float(shape @ shape)
            if size * float(shape[0]) < -DEEP and less > best:
                found, best = n, less
    return found


def _stretches(level: Array, full: Flags, window: float, alike: float, dof: float) -> tuple[tuple[Stretch, ...], Flags]:
    """Return the levels one after another, and the windows beside a change from or to full level."""
    found: list[Stretch] = []
    edges = np.zeros(len(level), dtype=bool)
    cuts = [0, *(np.flatnonzero(np.diff(full.astype(int))) + 1).tolist(), len(level)]
    for a, b in pairwise(cuts):
        if full[a]:
            edges[a] |= a > 0
            edges[b - 1] |= b < len(level)
            found.append(Stretch(a * window, b * window, float(np.nanmedian(level[a:b])), full=True, dof=(b - a) * dof))
        else:
            known = np.where(np.isfinite(level[a:b]), np.maximum(level[a:b], -2.0 * OFF), -2.0 * OFF)
            found += _others(known, a, window, alike, dof)
    return tuple(found), edges


def _others(level: Array, first: int, window: float, alike: float, dof: float) -> list[Stretch]:
    """Return the levels that are not full, and ramps, of windows that follow each other."""
    parts = pieces(level, alike)
    middle = [float(np.median(level[a:b])) for a, b in parts]
    found: list[Stretch] = []
    i = 0
    while i < len(parts):
        j = i + 1
        while j + 1 < len(parts) and (middle[j] - middle[i]) * (middle[j + 1] - middle[j]) > 0.0:
            j += 1
        a, b = parts[i][0], parts[min(j, len(parts) - 1)][1]
        if j < len(parts) and (ends := _sloping(level, parts[i : j + 1])):
            at = (first + a) * window, (first + b) * window
            found.append(Stretch(*at, float(np.median(level[a:b])), full=False, dof=(b - a) * dof, ends=ends))
            i = j + 1
            continue
        a, b = parts[i]
        lasts = b - a >= RUN or middle[i] > alike  # a step upwards counts however brief it is
        if lasts and middle[i] > -OFF:
            at = (first + a) * window, (first + b) * window
            found.append(Stretch(*at, middle[i], full=False, dof=(b - a) * dof))
        i += 1
    return found


def _sloping(level: Array, parts: Sequence[tuple[int, int]]) -> tuple[float, float] | None:
    """Return the ends of the line that pieces follow better than levels of their own; None where they do not."""
    a, b = parts[0][0], parts[-1][1]
    t, own = np.arange(a, b), level[a:b]
    slope, start = np.polyfit(t, own, 1)
    of_line = float(np.sum((own - start - slope * t) ** 2))
    of_levels = sum(float(np.sum((level[i:j] - np.mean(level[i:j])) ** 2)) for i, j in parts)
    return (float(start + slope * a), float(start + slope * (b - 1))) if of_line < of_levels else None


__all__: Sequence[str] = ("Levels", "Stretch", "find_levels", "mean_squares", "pieces")
