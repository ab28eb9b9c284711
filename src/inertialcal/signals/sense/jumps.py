"""Jumps of a record from one sample to the next, each with a straight line through the stretch before and after it."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from .noise import white_noise

FEWEST = 48  # samples of a record that is judged
SIDE = 8, 2048  # samples, fewest and most, of a line before and after a jump
CLEAR = 15.0  # standard deviations from which a jump is one
OFFSET = 0.3  # of a jump: what one of three axes may be off by, where the other two agree
FITS = 3.5  # over the square root of samples: by how much more than white noise they may scatter about a line
BENT = 3.5  # standard deviations of a curvature, up to which a line fits
PATIENCE = 2  # lengths in a row that do not fit
NEAR = 64  # samples that tell the noise of the shortest lines
ABRUPT = 2.0  # times the largest step among the neighbours
NEIGHBOURS = 4
CANDIDATES = 12
FEWEST_BLOCKS = 8  # on each side, that tell the level of all that lies there


class Line(NamedTuple):
    """Levels of all channels at a jump, from a line through one side."""

    level: Array
    u: Array
    scatter: Array
    size: int

    def mapped(self, gain: Array, zero: Array) -> Line:
        """Return the line of channels that are ``gain`` times these, plus ``zero``."""
        return Line(gain * self.level + zero, np.abs(gain) * self.u, np.abs(gain) * self.scatter, self.size)


class Jump(NamedTuple):
    """One jump with the lines before and after."""

    at: int
    before: Line
    after: Line

    def mapped(self, gain: Array, zero: Array) -> Jump:
        """Return the jump of channels that are ``gain`` times these, plus ``zero``."""
        return Jump(self.at, self.before.mapped(gain, zero), self.after.mapped(gain, zero))

    @property
    def step(self) -> Array:
        """Of each channel."""
        return self.after.level - self.before.level

    @property
    def u(self) -> Array:
        """Of each step."""
        return np.hypot(self.before.u, self.after.u)


def jumps(x: Array, cut: NDArray[np.bool_], size: int) -> list[Jump]:
    """Return the clear jumps of a record, each by the lines beside it and by all that lies before and after.

    Parameters
    ----------
    x : ndarray, shape (n, channels)
        Without missing samples.
    cut : ndarray of bool, shape (n,)
        Whether a gap lies before a sample.
    size : int
        Samples of a block of noise.
    """
    found = [one for place in candidates(x) if not cut[place] and (one := jump_at(x, place, cut)) is not None]
    means = _block_means(x, size)
    found += [_whole(one, x, size, means) for one in found]
    return [one for one in found if np.any(np.abs(one.step) > CLEAR * one.u)]


@lru_cache(maxsize=16)
def _shapes(size: int) -> tuple[Array, float, Array]:
    """Return a line through the middle of a stretch, its moment, and the two bends after it, of length 1."""
    t: Array = np.arange(size, dtype=np.float64) + 0.5 - 0.5 * size
    x1 = 2.0 * t / size
    bends: Array = np.stack([1.5 * x1**2 - 0.5, 2.5 * x1**3 - 1.5 * x1])
    bends /= np.sqrt(np.sum(bends**2, axis=1))[:, None]
    return t, float(np.sum(t**2)), bends


def _line(x: Array, index: int, side: int, room: int) -> Line | None:
    """Return the level at a jump from the samples before (side -1) or after (1), the longest stretch a line fits."""
    found: Line | None = None
    near = min(room, NEAR)
    around = x[index - near : index] if side < 0 else x[index : index + near]
    size, failed, noises = SIDE[0], 0, dict[int, Array]()  # noise of the samples next to the jump, by their number
    while size <= min(room, SIDE[1]) and failed < PATIENCE:
        part = x[index - size : index][::-1] if side < 0 else x[index : index + size]  # away from the jump
        t, moment, bends = _shapes(size)
        mean = part.mean(axis=0)
        slope = t @ part / moment
        rest = part - mean - np.outer(t, slope)
        scatter = np.sqrt(np.sum(rest**2, axis=0) / (size - 2))
        noise = noises[size] = white_noise(part)
        close = noises[max(SIDE[0], size // 4)]
        more = 1.0 + FITS / np.sqrt(size)
        alike = 1.5 + FITS / np.sqrt(0.5 * size)
        bent = np.abs(bends @ rest)
        fits = bool(np.all(bent <= BENT * noise) and np.all(scatter <= more * noise))
        fits = fits and bool(np.all((close <= alike * noise) & (noise <= alike * close)))
        if found is None or fits:
            if size < NEAR:  # so few samples do not tell their scatter
                scatter = np.maximum(scatter, white_noise(around))
            u = scatter * np.sqrt(1.0 / size + (0.5 * size) ** 2 / moment)
            found = Line(mean - slope * 0.5 * size, u, scatter, size)
        failed = 0 if fits else failed + 1
        size *= 2
    return found


def jump_at(x: Array, index: int, cut: NDArray[np.bool_]) -> Jump | None:
    """Return the lines on both sides of a jump, within the stretch without a gap."""
    gaps = np.flatnonzero(cut)
    first = int(gaps[gaps < index].max(initial=0))
    last = int(gaps[gaps > index].min(initial=len(x)))
    before, after = _line(x, index, -1, index - first), _line(x, index, 1, last - index)
    if before is None or after is None:
        return None
    return Jump(index, before, after)


def candidates(x: Array) -> list[int]:
    """Return the samples at which the record jumps: the step is far larger than those beside it."""
    found: dict[int, float] = {}  # how far each step stands out
    size = 1
    while len(x) // size >= FEWEST:
        means = x[: len(x) // size * size].reshape(-1, size, x.shape[1]).mean(axis=1) if size > 1 else x
        gap = 1 if size == 1 else 2  # the block of the jump itself is a mixture
        step = np.abs(means[gap:] - means[:-gap])
        typical = np.maximum(np.median(step, axis=0), 1e-9 * np.abs(means).max(axis=0))
        beside = np.zeros_like(step)
        width = NEIGHBOURS
        widest = _widest(step, width)
        shift = width // 2 + gap
        beside[shift:] = np.maximum(beside[shift:], widest[:-shift])
        beside[:-shift] = np.maximum(beside[:-shift], widest[shift:])
        with np.errstate(divide="ignore", invalid="ignore"):
            excess = np.max(np.where(typical > 0.0, (step - ABRUPT * beside) / typical, 0.0), axis=1)
        for row in np.argsort(excess)[: -CANDIDATES - 1 : -1].tolist():
            if excess[row] > 3.0:
                place = row + 1 if size == 1 else _best_split(x, row * size, (row + gap + 1) * size)
                near = [one for one in found if abs(place - one) <= SIDE[0]]  # shorter means tell the sample better
                place = min(near, key=lambda one: abs(place - one)) if near else place
                found[place] = max(found.get(place, 0.0), float(excess[row]))
        size *= 8
    return sorted(found, key=lambda one: -found[one])[: 2 * CANDIDATES]


def _widest(step: Array, width: int) -> Array:
    """Return the largest value of each column within a width about each row."""
    found = np.pad(step, ((width // 2, width - 1 - width // 2), (0, 0)), mode="edge")
    size = 1
    while size < width:  # of windows, twice as wide each time
        more = min(size, width - size)
        found, size = np.maximum(found[:-more], found[more:]), size + more
    return found


def _best_split(x: Array, first: int, last: int) -> int:
    """Return the sample between which and the one before two levels explain a stretch best."""
    part = x[first:last]
    spread = np.maximum(part.std(axis=0), 1e-300)
    part = (part - part.mean(axis=0)) / spread
    count = np.arange(1, len(part))[:, None]
    total = np.cumsum(part, axis=0)[:-1]
    gain = total**2 / count + total**2 / (len(part) - count)
    return first + int(np.argmax(gain.sum(axis=1))) + 1


def _block_means(x: Array, size: int) -> Array:
    """Return the means of whole blocks, shape (blocks, channels)."""
    n = len(x) // size
    means: Array = x[: n * size].reshape(n, size, -1).mean(axis=1)
    return means


def _whole(jump: Jump, x: Array, size: int, means: Array) -> Jump:
    """Return a jump with the levels of all that lies before and after, for records at rest; ``means`` of blocks."""
    lines = []
    if min(jump.at, len(x) - jump.at) < FEWEST_BLOCKS * size:
        return jump
    before, after = means[: jump.at // size], _block_means(x[jump.at :], size)
    for part, n in ((before, jump.at), (after, len(x) - jump.at)):
        level = np.median(part, axis=0)
        scatter = 1.4826 * np.median(np.abs(part - level), axis=0)
        lines.append(Line(level, 0.5 * scatter, scatter * np.sqrt(size), n))
    whole = Jump(jump.at, *lines)
    # The record has to jump there, too: what was laid on another side before or after is no jump
    apart = float(np.linalg.norm(whole.step - jump.step))
    return whole if apart < OFFSET * float(np.linalg.norm(whole.step)) else jump


def common_factor(jump: Jump) -> float:
    """Return the factor that takes the levels before a jump to those after it best; NaN where a level has no noise."""
    u, before, after = jump.u, jump.before.level, jump.after.level
    if not np.all(u > 0.0) or not np.any(before != 0.0):
        return float("nan")
    return float(np.sum(before / u * (after / u)) / np.sum((before / u) ** 2))
