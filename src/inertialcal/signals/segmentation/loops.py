"""Loops of the detector for short records: the functions of the kernels in numpy, equal to the last bit.

Importing numba takes a quarter of a second; numpy takes less than that for a short record, the compiled loops a fifth
of it for a long one.
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ..at_hand import Choice
from ..time.samples import Flags, Indices

SHORT = 100_000  # samples
FEW = 2_000  # calls: after so many the kernels pay, however short the records
EIGHT = 8  # samples of a block that are summed in pairs


def _compiled() -> object:
    from . import _kernels_levels  # noqa: PLC0415 - starts slowly

    return _kernels_levels


loops_for = Choice(sys.modules[__name__], _compiled, SHORT, FEW)


def fill_far(x: Array, away: float, at: Indices) -> int:
    """Fill which samples are off the mean of their neighbours by more than a limit."""
    return _filled(np.abs(x[1:-1] - 0.5 * (x[:-2] + x[2:])) > away, at, 1)


def count_above(x: Array, limits: Array, counts: Indices) -> None:
    """Count, for w = 1, 2, 4, ..., the places at which the means of w samples after and before differ by more."""
    sums, w = x, 1
    for k, limit in enumerate(limits.tolist()):
        counts[k] += np.count_nonzero(np.abs(sums[w:] - sums[:-w]) > limit * w)
        sums, w = sums[:-w] + sums[w:], 2 * w


def fill_above(x: Array, w: int, limit: float, at: Indices) -> int:
    """Fill where the means of w samples after and before samples w .. n - w differ by more than a limit."""
    return _filled(_jumps(x, w) > limit, at)


def fill_jumps(x: Array, w: int, at: Indices, jumps: Array) -> None:
    """Fill by how much the means of w samples after and before differ, at places counted from sample w, ascending."""
    jumps[:] = _jumps(x, w)[at]


def _jumps(x: Array, w: int) -> Array:
    sums, width = x, 1
    while width < w:
        sums, width = sums[:-width] + sums[width:], 2 * width
    jumps: Array = np.abs(sums[w:] - sums[:-w]) * (1.0 / w)
    return jumps


def _filled(flags: Flags, at: Indices, first: int = 0) -> int:
    """Fill the places that are flagged, as far as there is room, counted from ``first``; return their number."""
    found = np.flatnonzero(flags)
    room = min(len(found), len(at))
    at[:room] = found[:room] + first
    return len(found)


def fill_clear(at: Indices, w: int, cuts: Indices, clear: Flags) -> None:
    """Fill which of the indices, ascending, are w samples or more from the nearest cut, ascending too."""
    following = np.searchsorted(cuts[:-1], at)
    clear[:] = (np.abs(cuts[following] - at) >= w) & (np.abs(at - cuts[np.maximum(following - 1, 0)]) >= w)


def fill_peaks(at: Indices, score: Array, peaks: Indices) -> int:
    """Fill which of the places ``at``, ascending, score higher than both neighbours; return their number."""
    begins = np.ones(len(at), dtype=bool)  # of a row of neighbours that score alike
    begins[1:] = (np.diff(at) > 1) | (np.diff(score) != 0.0)
    first = np.flatnonzero(begins)
    last = np.append(first[1:], len(at)) - 1
    level, alone = score[first], at[first[1:]] - at[last[:-1]] > 1
    left, right = np.zeros(len(first)), np.zeros(len(first))
    left[1:], right[:-1] = np.where(alone, 0.0, level[:-1]), np.where(alone, 0.0, level[1:])
    found = ((first + last) // 2)[(level > left) & (level > right)]
    peaks[: len(found)] = found
    return len(found)


def drop_lower(at: Indices, order: Indices, w: int, kept: Flags) -> None:
    """Fill which peaks are the highest for w samples around; ``order``: of the peaks, the lowest first."""
    kept[:] = True
    first, stop = np.searchsorted(at, at - w, side="right"), np.searchsorted(at, at + w)
    for i in order[::-1].tolist():
        if kept[i]:
            kept[first[i] : stop[i]] = False
            kept[i] = True


def fill_loud(y: Array, cuts: Indices, w: int, limit: float, at: Indices) -> int:
    """Fill the windows i .. i + w whose variance (w - 1) exceeds a limit; levels between cuts keep its digits."""
    residual = np.empty(len(y))
    for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        if b > a:
            np.subtract(y[a:b], np.cumsum(y[a:b])[-1] / (b - a), out=residual[a:b])

    def running(x: Array) -> Array:
        """Return the sums of w samples: each takes one in, then the oldest out."""
        steps = np.empty(2 * len(x) - w)
        steps[:w], steps[w::2], steps[w + 1 :: 2] = x[:w], x[w:], -x[:-w]
        return np.cumsum(steps)[w - 1 :: 2]

    first, second = running(residual), running(residual * residual)
    return _filled(second - first * first / w > limit * (w - 1), at)


def _sums_of(blocks: Array) -> Array:
    """Return the sum of each block in the order of the compiled loops: in pairs of eight samples, else in turn."""
    if blocks.shape[1] == EIGHT:
        pairs = blocks[:, ::2] + blocks[:, 1::2]
        return np.asarray((pairs[:, 0] + pairs[:, 1]) + (pairs[:, 2] + pairs[:, 3]))
    found = np.zeros(len(blocks))
    for own in blocks.T:
        found += own
    return found


def fill_blocks(y: Array, size: int, variance: Array, different: Indices) -> float:
    """Fill variance (size - 1) and number of unequal neighbours of each block; return the least step, 0 of none."""
    blocks = y[: len(variance) * size].reshape(-1, size)
    level = _sums_of(blocks) / size
    variance[:] = _sums_of((blocks - level[:, None]) ** 2) / (size - 1)
    different[:] = np.count_nonzero(np.diff(blocks, axis=1), axis=1)
    step = np.abs(np.diff(y))
    least = np.min(step[step > 0.0], initial=np.inf)
    return float(least) if np.isfinite(least) else 0.0


def fill_moments(
    x: NDArray[np.float64], first: Indices, stop: Indices, mean: Array, variance: Array, lo: Array, hi: Array,
    count: Indices,
) -> None:  # fmt: skip
    """Fill number, mean, variance (n - 1), least and largest of the finite samples of each block."""
    finite = np.isfinite(x)
    whole = finite.all()
    for block, (a, b) in enumerate(zip(first.tolist(), stop.tolist(), strict=True)):
        good = x[a:b] if whole else x[a:b][finite[a:b]]
        count[block] = n = len(good)
        if not n:
            mean[block] = variance[block] = lo[block] = hi[block] = np.nan
            continue
        add = _sum_of if n == b - a else _sum_in_turn
        mean[block] = level = add(good) / n
        lo[block], hi[block] = np.minimum.reduce(good), np.maximum.reduce(good)
        off = good - level
        off *= off
        variance[block] = add(off) / (n - 1) if n > 1 else np.nan


def _sum_in_turn(x: Array) -> float:
    return float(x.cumsum()[-1])


def _sum_of(x: Array) -> float:
    """Return the sum of samples, four at a time."""
    whole = len(x) // 4 * 4
    a, b, c, d = x[:whole].reshape(-1, 4).cumsum(axis=0)[-1].tolist() if whole else (0.0,) * 4
    a = float(np.append(a, x[whole:]).cumsum()[-1])
    return float((a + b) + (c + d))
