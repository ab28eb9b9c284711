"""Jumps of a record from one sample to the next, each with a straight line through the stretch before and after it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.batches.summaries import medians
from ...core.estimate import Array
from ..at_hand import Choice
from ..time.samples import Indices

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
AROUND, BEFORE = np.arange(NEIGHBOURS), NEIGHBOURS // 2  # steps on a side; beside the ends are none
LEAST = 3.0  # times the typical step, that a jump stands out of the largest beside it
CANDIDATES = 12
LONGER = 8  # times as many samples of the next longer means
LONG, FEW = 100_000, 160  # samples, and calls, beyond which compiled loops pay
FEWEST_BLOCKS = 8  # on each side, that tell the level of all that lies there


class Loops:
    """The loops of ``_kernels`` where these take too long to load."""

    @staticmethod
    def fill_standing_out(
        means: Array, gap: int, around: int, few: int, abrupt: float, least: float, at: Indices
    ) -> int:  # fmt: skip
        """Return that there may be some: the search itself takes no longer."""
        return 1

    @staticmethod
    def may_change(columns: Array, block: int, sizes: NDArray[np.int64], rules: Array) -> bool:
        """Return True, too."""
        return True


def _compiled() -> object:
    from . import _kernels  # noqa: PLC0415 - starts slowly

    return _kernels


loops_for = Choice(Loops, _compiled, LONG, FEW)


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
    columns = np.ascontiguousarray(x.T)
    found = _jumps_at(columns, [place for place in candidates(x) if not cut[place]], cut)
    means = _block_means(columns, size) if found else columns
    found += [_whole(one, columns, size, means) for one in found]
    return [one for one in found if np.any(np.abs(one.step) > CLEAR * one.u)]


SIZES = np.array([FEWEST, LONGER, NEIGHBOURS, BEFORE])
RULES = ABRUPT, LEAST, CLEAR, FITS, BENT, PATIENCE, FEWEST_BLOCKS


def may_jump(x: Array, size: int, noise: float) -> bool:
    """Return whether a record may hold a clear jump, or a change of its noise by a factor of so much (logarithm).

    Parameters
    ----------
    x : ndarray, shape (n, channels)
        Without missing samples or gaps.
    size : int
        Samples of a block of noise.
    noise : float
        Logarithm of the least factor.
    """
    rules = np.array([noise, *RULES])
    return loops_for(len(x)).may_change(np.ascontiguousarray(x.T), size, SIZES, rules)


@lru_cache(maxsize=16)
def _shapes(size: int) -> tuple[Array, float, Array]:
    """Return a line through the middle of a stretch, its moment, and the two bends after it, of length 1."""
    t: Array = np.arange(size, dtype=np.float64) + 0.5 - 0.5 * size
    x1 = 2.0 * t / size
    bends: Array = np.stack([1.5 * x1**2 - 0.5, 2.5 * x1**3 - 1.5 * x1])
    bends /= np.sqrt(np.sum(bends**2, axis=1))[:, None]
    return t, float(np.sum(t**2)), bends


def _lines(columns: Array, first: Indices, way: Indices, room: Indices) -> list[Line | None]:
    """Return the levels at jumps from the samples beside them, each from the longest stretch a line fits.

    Parameters
    ----------
    columns : ndarray, shape (channels, n)
        The record.
    first, way, room : ndarray of int64, shape (k,)
        First sample of each stretch, 1 or -1 to where it goes on, and how many samples there are.
    """
    found: list[Line | None] = [None] * len(first)
    near = _near(columns, first, way, np.minimum(room, NEAR))
    size, failed = SIDE[0], np.zeros(len(first), dtype=np.int64)
    noises: dict[int, Array] = {}  # noise of the samples next to the jumps, by their number
    going = np.flatnonzero(room >= size)
    while len(going):
        part = columns[:, first[going, None] + way[going, None] * np.arange(size)]  # away from the jumps
        t, moment, bends = _shapes(size)
        mean = part.mean(axis=2)
        slope = part @ t / moment
        rest = part - mean[:, :, None] - slope[:, :, None] * t
        scatter = np.sqrt(np.sum(rest**2, axis=2) / (size - 2))
        noise = noises.setdefault(size, np.empty((len(columns), len(first))))
        noise[:, going] = own = _white(part)
        close = noises[max(SIDE[0], size // 4)][:, going]
        more = 1.0 + FITS / np.sqrt(size)
        alike = 1.5 + FITS / np.sqrt(0.5 * size)
        bent = np.abs(rest @ bends.T)
        fits = np.all(bent <= BENT * own[:, :, None], axis=(0, 2)) & np.all(scatter <= more * own, axis=0)
        fits &= np.all((close <= alike * own) & (own <= alike * close), axis=0)
        if size < NEAR:  # so few samples do not tell their scatter
            scatter = np.maximum(scatter, near[:, going])
        u = scatter * np.sqrt(1.0 / size + (0.5 * size) ** 2 / moment)
        level = mean - slope * 0.5 * size
        for at, one in enumerate(going.tolist()):
            if found[one] is None or fits[at]:
                found[one] = Line(level[:, at], u[:, at], scatter[:, at], size)
        failed[going] = np.where(fits, 0, failed[going] + 1)
        size *= 2
        going = going[(failed[going] < PATIENCE) & (room[going] >= size)] if size <= SIDE[1] else going[:0]
    return found


def _near(columns: Array, first: Indices, way: Indices, near: Indices) -> Array:
    """Return the white noise of so many samples next to jumps, shape (channels, k)."""
    found = np.zeros((len(columns), len(first)))
    for size in np.unique(near[near > 2]).tolist():
        own = np.flatnonzero(near == size)
        found[:, own] = _white(columns[:, first[own, None] + way[own, None] * np.arange(size)])
    return found


def _white(part: Array) -> Array:
    """Return the standard deviation of white noise with the second differences of stretches, along the last axis."""
    second = part[..., 2:] - 2.0 * part[..., 1:-1] + part[..., :-2]
    values: Array = np.sqrt(np.mean(second**2, axis=-1) / 6.0)
    return values


def jump_at(x: Array, index: int, cut: NDArray[np.bool_]) -> Jump | None:
    """Return the lines on both sides of a jump, within the stretch without a gap."""
    return next(iter(_jumps_at(np.ascontiguousarray(x.T), [index], cut)), None)


def _jumps_at(columns: Array, places: Sequence[int], cut: NDArray[np.bool_]) -> list[Jump]:
    """Return the lines on both sides of jumps, where there are enough samples without a gap."""
    if not len(places):
        return []
    at = np.array(places, dtype=np.int64)
    gaps = np.flatnonzero(cut)
    before = np.append(0, gaps)[np.searchsorted(gaps, at, side="left")]
    after = np.append(gaps, columns.shape[1])[np.searchsorted(gaps, at, side="right")]
    way = np.repeat([-1, 1], len(at))
    lines = _lines(columns, np.concatenate([at - 1, at]), way, np.concatenate([at - before, after - at]))
    sides = zip(places, lines[: len(at)], lines[len(at) :], strict=True)
    return [Jump(one, left, right) for one, left, right in sides if left is not None and right is not None]


def candidates(x: Array) -> list[int]:
    """Return the samples at which the record jumps: the step is far larger than those beside it."""
    found: dict[int, float] = {}  # how far each step stands out
    columns, first = np.ascontiguousarray(x.T), np.empty(1, dtype=np.int64)
    size = 1
    while len(x) // size >= FEWEST:
        gap = 1 if size == 1 else 2  # the block of the jump itself is a mixture
        means = _block_means(columns, size) if size > 1 else columns
        if not loops_for(len(x)).fill_standing_out(means, gap, NEIGHBOURS, BEFORE, ABRUPT, LEAST, first):
            size *= LONGER
            continue
        step = np.abs(means[:, gap:] - means[:, :-gap])
        typical = np.maximum(medians(step), 1e-9 * np.abs(means).max(axis=1))[:, None]
        some = np.flatnonzero((step > LEAST * typical).any(axis=0))
        own = step[:, some]
        at = some[:, None] + np.concatenate([-gap - 1 - AROUND, gap + AROUND])
        around = step[:, np.clip(at, 0, step.shape[1] - 1)].reshape(len(step), -1, 2, NEIGHBOURS).max(axis=3)
        inside = np.stack([some >= gap + BEFORE, some < step.shape[1] - gap - BEFORE], axis=1)
        beside = np.where(inside, around, 0.0).max(axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            excess = np.max(np.where(typical > 0.0, (own - ABRUPT * beside) / typical, 0.0), axis=0)
        for best in np.argsort(-excess, kind="stable")[:CANDIDATES].tolist():
            row = int(some[best])
            if excess[best] > LEAST:
                place = row + 1 if size == 1 else _best_split(x, row * size, (row + gap + 1) * size)
                near = [one for one in found if abs(place - one) <= SIDE[0]]  # shorter means tell the sample better
                place = min(near, key=lambda one: abs(place - one)) if near else place
                found[place] = max(found.get(place, 0.0), float(excess[best]))
        size *= LONGER
    return sorted(found, key=lambda one: -found[one])[: 2 * CANDIDATES]


def _best_split(x: Array, first: int, last: int) -> int:
    """Return the sample between which and the one before two levels explain a stretch best."""
    part = x[first:last] - x[first:last].mean(axis=0)
    part /= np.maximum(np.sqrt(np.sum(part * part, axis=0) / len(part)), 1e-300)
    count = np.arange(1, len(part))[:, None]
    total = np.cumsum(part, axis=0)[:-1]
    gain = total**2 / count + total**2 / (len(part) - count)
    return first + int(np.argmax(gain.sum(axis=1))) + 1


def _block_means(columns: Array, size: int) -> Array:
    """Return the means of whole blocks, shape (channels, blocks)."""
    n = columns.shape[1] // size
    means: Array = columns[:, : n * size].reshape(len(columns), n, size).mean(axis=2)
    return means


def _whole(jump: Jump, columns: Array, size: int, means: Array) -> Jump:
    """Return a jump with the levels of all that lies before and after, for records at rest; ``means`` of blocks."""
    lines, total = [], columns.shape[1]
    if min(jump.at, total - jump.at) < FEWEST_BLOCKS * size:
        return jump
    before, after = means[:, : jump.at // size], _block_means(columns[:, jump.at :], size)
    for part, n in ((before, jump.at), (after, total - jump.at)):
        level = medians(part)
        scatter = 1.4826 * medians(np.abs(part - level[:, None]))
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
