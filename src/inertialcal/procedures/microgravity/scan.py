"""One pass over records: intervals of time, spectra of blocks, means of blocks. Nothing goes across a gap.

A sample that stands alone far from both neighbours is a glitch (a bit, a telemetry error): no low pass lets such a
thing through. It stays in the display of least and largest values, and the blocks that hold it are left out of spectra
and means. Samples that stay at the end of the range are counted.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...core.batches import release
from ...core.estimate import Array
from .bands import share
from .readings import Readings, Track

CHUNK = 2**19  # samples of a piece of a stretch
FAR = 25.0  # robust standard deviations of a second difference, from which a sample alone is a glitch
ALIKE = 0.25  # part by which its neighbours may miss the pattern of one sample alone
CELLS = 64  # of frequency, of the spectrogram
ROBUST = 0.6745  # of a normal law: median of sizes over standard deviation


@dataclass(frozen=True, eq=False)
class Cut:
    """How records are cut."""

    interval: float  # from sample to sample [s]
    block: int  # samples, even
    samples: int  # of an interval of the display
    trim: float
    top: float  # up to which bands are looked at [Hz]
    edges: Array  # of bands, shape (bands, 2) [Hz]

    @property
    def step(self) -> float:
        """From line to line [Hz]."""
        return 1.0 / (self.block * self.interval)

    @property
    def lines(self) -> int:
        """Number of lines."""
        return self.block // 2 + 1


@dataclass(eq=False)
class Found:
    """What the pass brought up, of a axes."""

    lines: Array  # shape (lines, a): mean power of each line [(m/s^2)^2]
    cross: NDArray[np.complex128]  # shape (lines, pairs of axes)
    blocks: int = 0
    pairs: int = 0  # blocks half over the one before
    times: list[float] = field(default_factory=list[float])  # middle of each block [s]
    bands: list[Array] = field(default_factory=list[Array])  # of each block, shape (bands, a)
    cells: list[Array] = field(default_factory=list[Array])  # of each block, shape (cells, a)
    squares: list[Array] = field(default_factory=list[Array])  # mean square about the line of each block, shape (a,)
    slow_times: list[float] = field(default_factory=list[float])
    slow: list[Array] = field(default_factory=list[Array])  # trimmed mean of each block, not overlapping, shape (a,)
    follows: list[bool] = field(default_factory=list[bool])  # whether the one before ends where it begins
    at: list[Array] = field(default_factory=list[Array])  # middles of intervals [s]
    low: list[Array] = field(default_factory=list[Array])
    high: list[Array] = field(default_factory=list[Array])
    mean: list[Array] = field(default_factory=list[Array])
    square: list[Array] = field(default_factory=list[Array])  # mean square about the mean of the interval
    counts: list[Array] = field(default_factory=list[Array])  # finite samples of each interval and axis
    held: list[Array] = field(default_factory=list[Array])  # repeats at least and largest value, shape (i, 2, a)
    repeats: list[Array] = field(default_factory=list[Array])  # samples equal to the one before, shape (a,)
    glitches: list[float] = field(default_factory=list[float])  # times [s]
    missing: int = 0  # samples
    left_out: int = 0  # blocks
    short: int = 0  # samples in stretches that are shorter than a block


def scan(readings: Readings, cut: Cut, bias: Array) -> Found:
    """Return what one pass over all records brings up.

    Parameters
    ----------
    readings : Readings
        Records.
    cut : Cut
        How they are cut.
    bias : ndarray, shape (a,)
        To be taken off [m/s^2].
    """
    a = len(bias)
    many = a * (a - 1) // 2
    found = Found(np.zeros((cut.lines, a)), np.zeros((cut.lines, many), dtype=np.complex128))
    for track in readings.tracks:
        for (first, stop), start in zip(track.stretches, track.starts, strict=True):
            bad = _intervals(track, first, stop, start, cut, bias, found)
            _blocks(track, first, stop, start, cut, bias, bad, found)
    if found.blocks:
        found.lines /= found.blocks
        found.cross /= found.blocks
    return found


def _taken(track: Track, first: int, stop: int, bias: Array) -> Array:
    """Return samples, shape (a, n), bias taken off."""
    out = np.empty((len(bias), stop - first))
    for i, column in enumerate(track.values):
        np.subtract(column[first:stop], bias[i], out=out[i])
        release(column[first:stop])
    return out


def _intervals(
    track: Track, first: int, stop: int, start: float, cut: Cut, bias: Array, found: Found
) -> NDArray[np.int64]:
    """Add the intervals of a stretch; return its samples that are missing or glitches, since its first."""
    bad: list[NDArray[np.int64]] = []
    piece = max(1, CHUNK // cut.samples) * cut.samples
    for begin in range(first, stop, piece):
        end = min(begin + piece, stop)
        x = _taken(track, begin, end, bias)
        missing = np.flatnonzero(~np.isfinite(x).all(axis=0))
        found.missing += len(missing)
        alone = _glitches(x)
        found.glitches += [start + (begin - first + int(i)) * track.interval for i in alone]
        found.repeats.append((x[:, 1:] == x[:, :-1]).sum(axis=1).astype(float))
        bad += [missing + (begin - first), alone + (begin - first)]
        whole = (end - begin) // cut.samples * cut.samples
        rest = end - begin - whole
        even: tuple[Array, int, int] = (x[:, :whole].reshape(len(x), -1, cut.samples), 0, cut.samples)
        for part, offset, n in (even, (x[:, None, whole:], whole, rest)):
            if part.size:
                middles: Array = begin - first + offset + n * (0.5 + np.arange(part.shape[1], dtype=np.float64))
                _add_intervals(part, np.asarray(start + middles * track.interval), found)
    return np.unique(np.concatenate(bad))


def _add_intervals(part: Array, at: Array, found: Found) -> None:
    """Add intervals, shape (a, i, n)."""
    there = np.isfinite(part)
    if there.all():
        low, high, mean = part.min(axis=2), part.max(axis=2), part.mean(axis=2)
        counts = np.full(low.shape, float(part.shape[2]))
        square = np.maximum(np.einsum("ain,ain->ai", part, part) / counts - mean**2, 0.0)
    else:
        counts = there.sum(axis=2).astype(float)
        low = np.where(there, part, np.inf).min(axis=2)
        high = np.where(there, part, -np.inf).max(axis=2)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(there, part, 0.0).sum(axis=2) / counts
            square = np.where(there, (part - mean[..., None]) ** 2, 0.0).sum(axis=2) / counts
        low[counts == 0], high[counts == 0] = np.nan, np.nan
    held = np.zeros((part.shape[1], 2, len(part)))
    for side, end in enumerate((low, high)):
        i, k, n = np.nonzero(part == end[..., None])
        inside = n > 0
        i, k, n = i[inside], k[inside], n[inside]
        np.add.at(held[:, side], (k, i), part[i, k, n - 1] == part[i, k, n])
    found.at.append(at)
    for target, values in ((found.low, low), (found.high, high), (found.mean, mean), (found.square, square),
                           (found.counts, counts)):  # fmt: skip
        target.append(values.T)
    found.held.append(held)


def _glitches(x: Array) -> NDArray[np.int64]:
    """Return samples that stand alone far from both neighbours, on any axis."""
    if x.shape[1] < 16:  # too few to know the scatter
        return np.empty(0, dtype=np.int64)
    found = []
    for column in x:
        bend = column[1:-1] - 0.5 * (column[:-2] + column[2:])
        some = np.abs(bend[:: max(1, len(bend) // 20_000)])
        scale = float(np.nanmedian(some)) / ROBUST if np.isfinite(some).any() else math.nan
        if not scale > 0.0:
            continue
        for i in np.flatnonzero(np.abs(bend) > FAR * scale).tolist():
            beside = [bend[k] for k in (i - 1, i + 1) if 0 <= k < len(bend)]
            if all(abs(one + 0.5 * bend[i]) < ALIKE * abs(bend[i]) for one in beside):
                found.append(i + 1)
    return np.array(sorted(set(found)), dtype=np.int64)


def _blocks(
    track: Track, first: int, stop: int, start: float, cut: Cut, bias: Array, bad: NDArray[np.int64], found: Found
) -> None:
    """Add the spectra and means of the blocks of a stretch, each half over the one before."""
    n, half = cut.block, cut.block // 2
    if stop - first < n:
        found.short += stop - first
        return
    window = 0.5 - 0.5 * np.cos(2.0 * math.pi * np.arange(n) / n)
    scale = 2.0 / (n * float(np.sum(window**2)))  # of a squared transform: power of a line
    slope = np.arange(n) - 0.5 * (n - 1)
    slope /= math.sqrt(float(slope @ slope))
    ends = _sums(cut)
    pairs = [(p, q) for p in range(len(bias)) for q in range(p)]
    last_mean = last = -1
    for begin in range(0, stop - first - n + 1, half):
        i, k = np.searchsorted(bad, (begin, begin + n))
        if k > i:
            found.left_out += 1
            continue
        x = _taken(track, first + begin, first + begin + n, bias)
        middle = start + (begin + 0.5 * n) * track.interval
        if begin % n == 0:
            found.slow_times.append(middle)
            found.slow.append(_trimmed(x, cut.trim))
            found.follows.append(last_mean == begin)
            last_mean = begin + n
        x -= x.mean(axis=1, keepdims=True)
        x -= (x @ slope)[:, None] * slope
        found.squares.append(np.einsum("an,an->a", x, x) / n)
        x *= window
        spectrum = np.fft.rfft(x, axis=1)
        power = (spectrum.real**2 + spectrum.imag**2) * scale
        power[:, [0, -1]] *= 0.5
        found.lines += power.T
        for at, (p, q) in enumerate(pairs):
            found.cross[:, at] += scale * spectrum[p] * spectrum[q].conj()
        total = np.hstack([np.zeros((len(bias), 1)), np.cumsum(power, axis=1)]).T
        found.bands.append(_between(total, ends[0]))
        found.cells.append(_between(total, ends[1]))
        found.blocks += 1
        found.pairs += last == begin - half
        last = begin
        found.times.append(middle)


def _sums(cut: Cut) -> tuple[Array, Array]:
    """Return edges of bands and of cells in lines: edge e lies at (e - 1/2) lines."""
    ends = np.linspace(0.0, cut.top, CELLS + 1)
    cells = np.column_stack([ends[:-1], ends[1:]])
    cells[0, 0] = -0.5 * cut.step
    return cut.edges / cut.step + 0.5, cells / cut.step + 0.5


def _between(total: Array, ends: Array) -> Array:
    """Return power between edges, shape (b, a), by sums of power up to each line."""
    at = np.clip(ends, 0.0, len(total) - 1.0)
    low = np.floor(at).astype(int)
    high = np.minimum(low + 1, len(total) - 1)
    part = (at - low)[..., None]
    sums = total[low] * (1.0 - part) + total[high] * part
    return np.asarray(sums[:, 1] - sums[:, 0])


def _trimmed(x: Array, trim: float) -> Array:
    """Return the mean of each axis, shape (a, n), without a share of its samples at each end, shape (a,)."""
    n = x.shape[1]
    off = int(trim * n)
    if not off:
        return np.asarray(x.mean(axis=1))
    part = np.partition(x, (off, n - off - 1), axis=1)
    return np.asarray(part[:, off : n - off].mean(axis=1))


def weights_of(cut: Cut) -> Iterator[Array]:
    """Yield the shares of lines of each band, shape (lines,)."""
    for low, high in cut.edges.tolist():
        yield share(low, high, cut.lines, cut.step)
