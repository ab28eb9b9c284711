"""Slow channels that are stuck: a temperature, a pressure or a supply that stays at one value while the record goes on.

A coarse thermometer in a thermostat stays at one value for hours and is right, so a long hold alone says nothing.
A hold is stuck where

1. the channel is noisy elsewhere, by more than a step of its codes: it cannot come back to one code that often; or
2. it ends, or begins, with a jump that is far larger than any other step of the channel; or
3. the readings follow the channel elsewhere, and go on changing through the hold as they would with it.

A channel that holds other values as long does so as a habit: dwells of a chamber. One that never changes is not judged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches
from ...core.batches.summaries import median_made, moments
from ...core.recording import Times
from ...core.remarks import Remark
from ..time.samples import Indices

SHORTEST = 20  # samples of a hold ...
PART = 0.05  # ... and its share of the record, from which it matters
WHOLE = 0.98  # share of the record from which the channel is constant
HABIT = 0.25  # length of a hold at another value, of the longest, that makes holds a habit
WINDOW, WINDOWS, ENOUGH = 16, 512, 8  # samples of a window for the noise, how many at most, and at least
ROUNDING = 1e-9  # of the largest value: less is no step of a code
NOISY = 0.6  # standard deviation of the noise, in steps, that a run of a code cannot come from
ALTERNATES = -0.4  # correlation of a third difference with the next one: -0.75 of noise, above 0 of curves
CHANCE = 1e-6  # of so long a hold in noise, a record
JUMP = 4.0  # largest other steps
LATE = 3.0  # sample intervals from which a step has a gap in it
LEAST, MOST = 1e-30, 1e30  # changes that a sensor has, in any unit
BLOCKS, OUTSIDE, INSIDE = 64, 16, 6  # of the record, for the response to the channel
FOLLOWS = 0.97  # share of the variance of the readings that the channel explains elsewhere
BEYOND = 5.0  # standard deviations of the rest by which readings leave what the held value explains
BACK = 0.5  # of its range that the channel must come back elsewhere
RANGE = 0.5  # of their range elsewhere by which they go on


@dataclass(frozen=True)
class Stuck:
    """A hold that is no reading of the channel."""

    first: int  # Samples, both included
    last: int  # Samples, both included
    value: float
    why: str  # What shows it, as a clause

    @property
    def length(self) -> int:
        """Samples of the hold."""
        return self.last - self.first + 1


@np.errstate(over="ignore", invalid="ignore")  # values near the end of float64
def stuck_slow(x: NDArray[Any], readings: Sequence[NDArray[Any]] = (), time_ns: Times | None = None) -> Stuck | None:
    """Return the longest hold of a slow channel where it is stuck; None elsewhere.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Temperature, pressure or voltage as stored, NaN where one is missing.
    readings : sequence of ndarray, shape (n,)
        Of the sensor, on the same samples.
    time_ns : ndarray of int64, shape (n,), optional
        Stamps [ns]: a step across a gap is no jump.
    """
    n = len(x)
    if n < 2 * SHORTEST:
        return None
    least = max(SHORTEST, round(PART * n))
    some = x[:: max(least // 3, 1)]
    if not np.any(some[1:] == some[:-1]):
        return None
    firsts, lasts = _holds(x, max(HABIT * least, SHORTEST))
    if not len(firsts):
        return None
    lengths = lasts - firsts + 1
    longest = int(np.argmax(lengths))
    first, last, length = int(firsts[longest]), int(lasts[longest]), int(lengths[longest])
    value = float(x[first])
    if length < least or length > WHOLE * n or not np.isfinite(value):
        return None
    others = (x[firsts] != value) & (lengths >= max(HABIT * length, SHORTEST))
    if others.any():
        return None
    usual = _largest_step(x, max(first - 1, 0), last + 1)  # but those into the hold and out of it
    why = usual > 0.0 and (
        _noise(x, first, last)
        or _jump(x, first, last, usual, time_ns)
        or next((one for y in readings if (one := _response(x, y, first, last))), "")
    )
    return Stuck(first, last, value, why) if why else None


def stuck_remark(
    found: Stuck, name: str, samples: int, place: Callable[[int], str], shown: Callable[[float], str] = "{:g}".format
) -> Remark:
    """Return what to say of a stuck channel.

    Parameters
    ----------
    found : Stuck
        The hold.
    name : str
        Of the channel.
    samples : int
        Of the record.
    place : callable
        Gives the place of a sample in words: row or time.
    shown : callable
        Gives a value of the channel with its unit.
    """
    what = f"{name} stays at {shown(found.value)} for {found.length} of {samples} samples: stuck? ({found.why})"
    do = "Look at the sensor of this channel, its wiring and the logger"
    return Remark("stuck", "warning", what, place(found.first), do=do, index=found.first)


def _noise(x: NDArray[Any], first: int, last: int) -> str:
    """Whether noise elsewhere leaves no room for the hold; third differences see no ramp."""
    starts = np.unique(np.linspace(0, len(x) - WINDOW, WINDOWS).astype(np.int64))
    starts = starts[(starts + WINDOW <= first) | (starts > last)]
    rows = x[starts[:, None] + np.arange(WINDOW)].astype(np.float64)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if len(rows) < ENOUGH:
        return ""
    apart = np.diff(np.unique(rows))
    apart = apart[apart > ROUNDING * np.abs(rows).max()]
    if not len(apart):
        return ""
    third, step = np.diff(rows, n=3, axis=1), float(apart.min())
    sigma = float(np.median(np.sqrt(np.mean(third**2, axis=1) / 20.0))) / step
    next_one = np.mean(third[:, 1:] * third[:, :-1], axis=1) / np.maximum(np.mean(third**2, axis=1), 1e-300)
    if sigma < NOISY or float(np.median(next_one)) > ALTERNATES:
        return ""
    # Chance of one code a sample, at most: step / (sqrt(2 pi) sigma)
    stays = float(np.clip(1.0 / (np.sqrt(2.0 * np.pi) * sigma), 1e-9, 0.9))
    enough = (last - first) * np.log(stays) < np.log(CHANCE / len(x))
    return "elsewhere it scatters by more than a step of its codes" if enough else ""


def _holds(x: NDArray[Any], least: float) -> tuple[Indices, Indices]:
    """Return first and last sample of each stretch of one value that has so many samples."""
    firsts, lasts, begun = [], [], 0
    for first, stop in batches(x):
        changed = max(first, 1) + np.flatnonzero(x[max(first, 1) : stop] != x[max(first - 1, 0) : stop - 1])
        starts = np.append(begun, changed)
        ends = np.append(changed, len(x)) if stop == len(x) else changed
        kept = ends - starts[: len(ends)] >= least
        firsts.append(starts[: len(ends)][kept])
        lasts.append(ends[kept] - 1)
        begun = int(starts[-1])
    return np.concatenate(firsts), np.concatenate(lasts)


def _largest_step(x: NDArray[Any], first: int, stop: int) -> float:
    """Return the largest step of the record but those from samples first to stop; NaN where there is none."""
    largest = np.nan
    for a, b in batches(x[:-1]):
        steps = np.abs(np.diff(x[a : b + 1].astype(np.float64)))
        steps[max(first - a, 0) : max(stop - a, 0)] = np.nan
        largest = np.fmax(largest, np.fmax.reduce(steps[~np.isinf(steps)], initial=np.nan))
    return float(largest)


def _jump(x: NDArray[Any], first: int, last: int, usual: float, time_ns: Times | None) -> str:
    """Whether the hold ends or begins with a jump."""
    for at in (last, first - 1):
        if not 0 <= at < len(x) - 1 or not abs(float(x[at + 1]) - float(x[at])) > JUMP * usual:
            continue
        if time_ns is not None and time_ns[at + 1] - time_ns[at] > LATE * _median_step(time_ns):
            continue
        return "it jumps at the end" if at == last else "it jumps there"
    return ""


def _median_step(time_ns: Times) -> float:
    return median_made(lambda first, stop: np.diff(time_ns[first : stop + 1]), time_ns[:-1])


def _response(x: NDArray[Any], y: NDArray[Any], first: int, last: int) -> str:
    """Whether readings that follow the channel elsewhere go on changing through the hold."""
    edges = np.linspace(0, len(x), BLOCKS + 1).astype(np.int64)
    blocks = [(int(a), int(b)) for a, b in pairwise(edges)]
    outside = [(a, b) for a, b in blocks if b <= first or a > last]
    within = [(a, b) for a, b in blocks if a >= first and b <= last + 1]
    if len(outside) < OUTSIDE or len(within) < INSIDE:
        return ""
    channel, there = (np.array([_mean(z[a:b]) for a, b in outside]) for z in (x, y))
    held = np.array([_mean(y[a:b]) for a, b in within])
    good = np.isfinite(channel) & np.isfinite(there)
    held = held[np.isfinite(held)]
    if np.count_nonzero(good) < OUTSIDE or len(held) < INSIDE or not np.ptp(channel[good]) > 0.0:
        return ""
    channel, there = channel[good], there[good]
    middle, swing, size = float(np.mean(channel)), float(np.ptp(channel)), float(np.ptp(there))
    if not (LEAST < swing < MOST and LEAST < size < MOST and abs(middle) < MOST):  # readings that nothing has
        return ""
    there, held = (there - there[0]) / size, (held - there[0]) / size
    up = float(np.max(channel - np.minimum.accumulate(channel)))
    down = float(np.max(np.maximum.accumulate(channel) - channel))
    if min(up, down) < BACK * swing:  # a drift of the readings cannot be told from a response to one ramp
        return ""
    powers = np.vander((channel - middle) / swing, 3)
    terms = np.linalg.lstsq(powers, there, rcond=None)[0]
    rms = float(np.sqrt(np.mean((there - powers @ terms) ** 2)))
    if rms**2 > (1.0 - FOLLOWS) * float(np.var(there)):
        return ""
    expected = float(np.polyval(terms, (float(x[first]) - middle) / swing))
    away = float(np.sqrt(np.mean((held - expected) ** 2)))
    goes_on = away > BEYOND * rms and float(np.ptp(held)) > RANGE
    return "the readings go on changing with it" if goes_on else ""


def _mean(values: NDArray[Any]) -> float:
    found = moments(values)
    return found.mean if 2 * found.count >= len(values) > 0 else float("nan")
