"""The loops of ``_kernels`` for short records, in numpy: a compiler takes longer to load than they take to run.

The functions take and fill what those of their names in ``_kernels`` do, to the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...core.estimate import Array
from ..at_hand import Choice
from ..time.samples import Flags, Indices

Whole = np.integer[Any]

SHORT = 2**17  # samples
FEW = 500  # calls, some 100 records: after so many compiled loops pay, however short the records
SUB, SIDE = 16, 15  # samples in which a glitch is looked for at once, and of a running median on each side
WINDOW = 2 * SIDE + 1
PRINT, CHANGES = 24, 6  # samples of a fingerprint, and changes of value that it needs
FIRST = 4  # part of the differences that is looked at first
CUT = 5.0  # times the level, to which single large values are cut
ODD = 0x9E3779B97F4A7C15
WORD = 0xFFFFFFFFFFFFFFFF


def _rows(values: NDArray[Any], size: int) -> NDArray[Any]:
    """Return blocks of samples as rows, shape (b, size); zeros after the end."""
    many = -(-len(values) // size)
    out = np.zeros(many * size, dtype=values.dtype)
    out[: len(values)] = values
    return out.reshape(many, size)


def _extremes(bits: NDArray[Any], flip: Whole, good: Flags) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the least and largest good sample of each row, as sorted bits."""
    info = np.iinfo(bits.dtype)
    key = bits ^ ((bits >> (8 * bits.itemsize - 1)) & flip)
    return np.where(good, key, info.max).min(axis=1), np.where(good, key, info.min).max(axis=1)


def _moments(x: NDArray[Any], good: Flags) -> tuple[Array, Array, NDArray[Any], NDArray[Any]]:
    """Return mean, half the mean squared step, equal steps and number of the good samples of each row."""
    count = np.count_nonzero(good, axis=1)
    values = np.where(good, x, 0.0).astype(np.float64)
    level = np.take_along_axis(values, np.argmax(good, axis=1)[:, None], axis=1)
    pair = good[:, 1:] & good[:, :-1]
    step = np.where(pair, np.diff(values, axis=1), 0.0)
    pairs = np.count_nonzero(pair, axis=1)
    mean = np.where(count > 0, level[:, 0] + _sums(np.where(good, values - level, 0.0)) / np.maximum(count, 1), np.nan)
    rough = np.where(pairs > 0, 0.5 * _sums(step * step) / np.maximum(pairs, 1), np.nan)
    return mean, rough, np.count_nonzero(pair & (step == 0.0), axis=1), count


def _sums(rows: Array) -> Array:
    """Return the sum of each row, every fourth value with the others of its place: as the compiled loop adds them."""
    padded = np.zeros((len(rows), -(-rows.shape[1] // 4), 4))
    padded.reshape(len(rows), -1)[:, : rows.shape[1]] = rows
    a, b, c, d = np.cumsum(padded, axis=1)[:, -1].T  # one after the other, as a loop adds them up
    return np.asarray((a + b) + (c + d))


def _around(x: NDArray[Any], first: Indices, count: int) -> Array:
    """Return rows of so many samples from ``first`` on, with 15 more on each side; NaN where there are none."""
    at = first[:, None] + np.arange(-SIDE, count + SIDE)
    values: Array = x[np.clip(at, 0, len(x) - 1)].astype(np.float64)
    values[(at < 0) | (at >= len(x)) | ~np.isfinite(values)] = np.nan
    return values


def _off_median(around: Array) -> Array:
    """Return rows of samples, without the 15 on each side, less the running median of 31 around each."""
    middle, windows = around[:, SIDE:-SIDE], sliding_window_view(around, WINDOW, axis=1).copy()
    windows.sort(axis=2)  # NaN last
    if not np.isnan(around).any():
        return np.asarray(middle - windows[:, :, SIDE])
    held = np.maximum(np.count_nonzero(~np.isnan(windows), axis=2), 1)[:, :, None]
    halves = [np.take_along_axis(windows, half, axis=2)[:, :, 0] for half in ((held - 1) // 2, held // 2)]
    return np.asarray(middle - 0.5 * (halves[0] + halves[1]))


def _runs(x: NDArray[Any]) -> tuple[Indices, Indices]:
    """Return start and stop of each run of equal samples."""
    starts = np.concatenate(([0], np.flatnonzero(x[1:] != x[:-1]) + 1))
    return starts, np.append(starts[1:], len(x))


class Loops:
    """The loops, called as those of the compiled module."""

    @staticmethod
    def fill_blocks(
        x: NDArray[Any], bits: NDArray[Any], size: int, flip: Whole, inf: Whole, lo: NDArray[Any], hi: NDArray[Any],
        mean: Array, rough: Array, same: NDArray[np.int32], count: NDArray[np.int32],
    ) -> int:  # fmt: skip
        """Fill what each block holds; 0 samples where some are not finite. Return how many blocks these are."""
        there, good = _rows(np.ones(len(x), dtype=bool), size), _rows(np.isfinite(x), size)
        lo[:], hi[:] = _extremes(_rows(bits, size), flip, there)
        whole = np.all(good | ~there, axis=1)
        found = _moments(_rows(x, size), good)
        outs: tuple[NDArray[Any], ...] = (mean, rough, same, count)
        for out, own in zip(outs, found, strict=True):
            out[whole] = own[whole]
        count[~whole] = 0
        rough[np.isnan(rough) & whole] = 0.0
        return int(np.count_nonzero(~whole))

    @staticmethod
    def fill_patched(
        x: NDArray[Any], bits: NDArray[Any], size: int, flip: Whole, which: Indices, skip: Indices, lo: NDArray[Any],
        hi: NDArray[Any], mean: Array, rough: Array, same: NDArray[np.int32], count: NDArray[np.int32],
    ) -> None:  # fmt: skip
        """Fill the blocks ``which`` anew, of their finite samples but those of ``skip``."""
        good = np.isfinite(x)
        good[skip] = False
        rows = [_rows(one, size)[which] for one in (x, bits, good)]
        outs: tuple[NDArray[Any], ...] = (lo, hi, mean, rough, same, count)
        found = (*_extremes(rows[1], flip, rows[2]), *_moments(rows[0], rows[2]))
        for out, own in zip(outs, found, strict=True):
            out[which] = own

    @staticmethod
    def fill_pieces(x: NDArray[Any], first: Indices, out: Array) -> None:
        """Fill rows of ``out`` with samples from ``first`` on, less the running median around each."""
        out[:] = _off_median(_around(x, first, out.shape[1]))

    @staticmethod
    def fill_ranked(x: NDArray[Any], m: int, ranks: Indices, out: Array) -> bool:
        """Return False: nothing is filled."""
        return False

    @staticmethod
    def fill_far(x: NDArray[Any], size: int, which: Indices, limit: float, low: float, at: Indices, off: Array) -> int:
        """Fill samples of the blocks ``which`` further than ``low`` from the running median."""
        first = (which[:, None] * size + np.arange(0, size, SUB)).ravel()
        first = first[first < len(x)]
        if not len(first):
            return 0
        around = _around(x, first, SUB)
        least = np.where(np.isnan(around), np.inf, around).min(axis=1)
        largest = np.where(np.isnan(around), -np.inf, around).max(axis=1)
        wide = largest - least > limit
        some = (first[wide][:, None] + np.arange(SUB)).ravel()
        d = _off_median(around[wide]).ravel()[some < len(x)]
        some = some[some < len(x)]
        far = np.abs(d) > low
        found = int(np.count_nonzero(far))
        room = min(found, len(at))
        at[:room], off[:room] = some[far][:room], d[far][:room]
        return found

    @staticmethod
    def fill_runs(x: NDArray[Any], size: int, which: Indices, value: float, starts: Indices, stops: Indices) -> int:
        """Fill the stretches of a value, which begin in the blocks ``which``; return their number, room or not."""
        first, stop = _runs(x)
        kept = (x[first] == value) & np.isin(first // size, which)
        found = int(np.count_nonzero(kept))
        room = min(found, len(starts))
        starts[:room], stops[:room] = first[kept][:room], stop[kept][:room]
        return found

    @staticmethod
    def longest_equal(bits: NDArray[Any], first: int, stop: int) -> tuple[int, int]:
        """Return start and stop of the longest stretch of equal samples that meets first .. stop."""
        starts, stops = _runs(bits)
        meets = np.flatnonzero((stops > first) & (starts < stop))
        best = meets[np.argmax(stops[meets] - starts[meets])]
        return int(starts[best]), int(stops[best])

    @staticmethod
    def squared_runs(x: NDArray[Any]) -> float:
        """Return the sum of the squared lengths of all runs of equal samples."""
        starts, stops = _runs(x)
        return float(np.sum((stops - starts).astype(np.float64) ** 2))

    @staticmethod
    def fill_prints(bits: NDArray[Any], size: int, prints: NDArray[np.uint64], at: NDArray[np.int32]) -> None:
        """Fill a fingerprint of each block, and where in the block it is."""
        n, starts = len(bits), np.arange(len(prints)) * size
        inside = min(n, len(prints) * size)  # beyond it lies what a fingerprint may reach into
        words = bits.astype(np.uint64)
        least = np.full(n, WORD, dtype=np.uint64)
        mixed = (words[:-2] + (words[1:-1] << np.uint64(7))) ^ (words[2:] << np.uint64(17))
        mixed = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(ODD)
        place = np.arange(n) % size
        stop = np.minimum(np.arange(n) - place + size, n)
        here = np.flatnonzero((np.arange(inside) < stop[:inside] - 2)[: len(mixed)])
        least[here] = (mixed[here] & np.uint64(WORD - 0xFFFF)) | place[here].astype(np.uint64)
        lowest = np.minimum.reduceat(least[:inside], starts)
        at[:] = (lowest & np.uint64(0xFFFF)).astype(np.int32)
        first = starts + at
        fits = (lowest < np.uint64(WORD)) & (first + PRINT <= n)
        prints[:] = 0
        v = words[first[fits][:, None] + np.arange(PRINT)]
        weights = np.uint64(ODD) * (2 * np.arange(PRINT, dtype=np.uint64) + np.uint64(1))
        digest = np.sum((v ^ (v >> np.uint64(32))) * weights, axis=1, dtype=np.uint64)
        many = np.count_nonzero(v[:, 1:] != v[:, :-1], axis=1) >= CHANGES
        prints[fits] = np.where(many, digest ^ (digest >> np.uint64(32)), np.uint64(0))

    @staticmethod
    def fit_powers(part: Array, values: Array, rounds: int, weight: Array) -> None:
        """Improve the weights (k,) of positive rows (k, n) whose sum is the mean of exponential values (n,)."""
        level = np.empty(len(values))
        for _ in range(rounds):
            level[:] = weight[0] * part[0]
            for own, row in zip(weight[1:], part[1:], strict=True):
                level += own * row
            share = 1.0 / level
            kept = np.minimum(values * share, CUT) * share
            weight *= np.sqrt(_sums(part * kept) / _sums(part * share))

    @staticmethod
    def fill_apart(sums: Array, w: int, out: Array) -> None:
        """Fill the mean of w values less that of the w before them."""
        n = len(out)
        out[:] = (1.0 / w) * (sums[2 * w : 2 * w + n] - 2.0 * sums[w : w + n] + sums[:n])

    @staticmethod
    def fill_bent(sums: Array, w: int, out: Array) -> None:
        """Fill the contrast of four windows of w values."""
        a, b, c, d, e = (sums[k * w : k * w + len(out)] for k in range(5))
        out[:] = (1.0 / (3.0 * w)) * (4.0 * (d + b) - 6.0 * c - e - a)

    @staticmethod
    def smallest_step(rows: Array) -> float:
        """Return the smallest difference of neighbours in rows that is not zero; 0 where there is none."""
        apart = np.abs(np.diff(rows, axis=1))
        apart = apart[np.isfinite(apart) & (apart > 0.0)]
        return float(apart.min()) if len(apart) else 0.0

    @staticmethod
    def look(x: NDArray[Any], bits: NDArray[Any], many: int, rank: int, mean: Array, rough: Array) -> bool:
        """Return that this is not all: the searches themselves take no longer here."""
        return False

    @staticmethod
    def resolved(rows: Array, times: float, off: float, most: float, converted: float) -> tuple[float, bool]:
        """Return the step of rows, 0 where their differences are no whole steps; whether they fit into 32 bits."""
        apart, stored = np.abs(np.diff(rows, axis=1)), rows * times
        apart = apart[apart > 0.0]
        step = float(apart.min()) if len(apart) else 0.0
        for some in (apart[: len(apart) // FIRST], apart) if step else ():  # a few tell that too many are not
            odd = np.count_nonzero(~(np.abs(some / step - np.rint(some / step)) < off))
            if (len(apart) - odd) / len(apart) < most:
                step = 0.0
                break
        with np.errstate(over="ignore", invalid="ignore"):  # beyond all numbers of 32 bits
            short = all(
                bool((np.abs(some - some.astype(np.float32)) <= converted * np.spacing(np.abs(some))).all())
                for some in (stored[:1], stored)
            )
        return step, short

    @staticmethod
    def may_differ(
        mean: Array, rough: Array, even: float, noise_limits: Array, widths: Indices, limits: Array, sampled: int
    ) -> bool:  # fmt: skip
        """Return True, as above."""
        return True

    @staticmethod
    def may_change(sums: Array, widths: Indices, limit: float) -> bool:
        """Return True, as above."""
        return True

    @staticmethod
    def may_step(sums: Array, widths: Indices, limits: Array, sampled: int) -> bool:
        """Return True, as above."""
        return True

    @staticmethod
    def may_wave(
        power: Array, basis: Array, first: int, lobe: int, beside: int, stands: float, rounds: int, rare: float,
        margin: float,
    ) -> bool:  # fmt: skip
        """Return True, as above."""
        return True


def _compiled() -> object:
    from . import _kernels  # noqa: PLC0415 - loads the compiler

    return _kernels


loops_for = Choice(Loops, _compiled, SHORT, FEW)
