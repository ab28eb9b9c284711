"""The loops of ``_kernels`` and ``_kernels_missing`` for short records, in numpy.

A compiler takes longer to load than they take to run. They take and fill what those of their names there do; sums
differ by rounding.
"""

from __future__ import annotations

import sys
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from .gaps import COMPLETE, FILL

SHORT = 2**16  # points of a record with missing samples
FEW = 2**12  # points of one without: its noise terms are found by compiled loops in any case
PASCAL = {2: (1, -2, 1), 3: (-1, 3, -3, 1)}


def loops_for(points: int) -> ModuleType:
    """Return the module with the loops over an integrated signal of so many points: this one, or the kernels."""
    return sys.modules[__name__] if points <= FEW else _compiled()


@cache
def _compiled() -> ModuleType:
    from . import _kernels  # noqa: PLC0415 - starts slowly

    return _kernels


def loops_with_gaps(points: int) -> ModuleType:
    """Return the same for records with missing samples."""
    if points <= SHORT:
        return sys.modules[__name__]
    from . import _kernels_missing  # noqa: PLC0415 - starts slowly

    return _kernels_missing


def integrate(x: NDArray[Any], level: np.int64 | np.float64, phase: NDArray[Any]) -> None:
    """Fill ``phase``, one longer than ``x``, with the sums of all samples before each, less a level a sample."""
    phase[0] = 0
    with np.errstate(invalid="ignore", over="ignore"):
        phase[1:] = np.cumsum(
            x.astype(phase.dtype) - level, dtype=np.int64 if phase.dtype == np.int64 else np.longdouble
        )


def integrate_all(x: NDArray[Any], step: int, phase: NDArray[np.float64]) -> None:
    """Fill ``phase`` as `integrate` does, less the mean of every so manieth sample."""
    with np.errstate(invalid="ignore", over="ignore"):
        some = x[::step].astype(np.float64)
        integrate(x, np.float64(some[0] + (some - some[0]).sum() / len(some)), phase)


def integrate_present(
    x: NDArray[Any],
    present: NDArray[np.bool_],
    level: np.int64 | np.float64,
    phase: NDArray[Any],
    count: NDArray[np.int32],
) -> None:
    """Fill ``phase`` and ``count`` with the sums and numbers of the samples that are present."""
    integrate(np.where(present, x, level), level, phase)
    count[0] = 0
    count[1:] = np.cumsum(present)


def largest_beside_line(p: NDArray[Any]) -> float:
    """Return the largest distance of P from the line through both of its ends."""
    return float(np.max(np.abs(_beside_line(p))))


def sum_again(p: NDArray[Any], scale: float, sums: NDArray[np.int64]) -> None:
    """Fill ``sums``, one longer, with the sums of P before each point, in whole numbers that may run over."""
    sums[0] = 0
    sums[1:] = np.cumsum(p if scale == 0.0 else np.floor(_beside_line(p) * scale).astype(np.int64), dtype=np.int64)


def _beside_line(p: NDArray[Any]) -> Array:
    slope = np.float64(p[-1] - p[0]) / max(1, len(p) - 1)
    return np.asarray((p - p[0]).astype(np.float64) - slope * np.arange(len(p)))


def sum_overlapping(p: NDArray[Any], factors: NDArray[np.int64], order: int, out: Array) -> None:
    """Fill ``out`` with the sums of squared differences of an order, 2 or 3, over all starting points."""
    room = np.empty_like(p)
    for k, m in enumerate(factors.tolist()):
        out[k] = _squares(p, m, len(p) - order * m, 1, order, room)


def sum_strides(p: NDArray[Any], factors: NDArray[np.int64], order: int, out: Array) -> None:
    """Fill ``out`` with the sums of squared differences of an order, 2 or 3, over windows that do not overlap."""
    for k, m in enumerate(factors.tolist()):
        out[k] = _squares(p, m, len(p) - order * m, m, order)


def _squares(p: NDArray[Any], m: int, terms: int, stride: int, order: int, room: NDArray[Any] | None = None) -> float:
    """Return the sum of squared differences that start every ``stride`` points."""
    d = _differences(p, m, terms, stride, order, room)
    return float(d @ d)


def _differences(
    p: NDArray[Any], m: int, terms: int, stride: int, order: int, room: NDArray[Any] | None = None
) -> Array:
    """Return differences of an order, in ``room`` where it is given."""
    first, second, *others = (p[i * m : i * m + terms : stride] for i in range(order + 1))
    d = np.multiply(second, PASCAL[order][1], out=None if room is None else room[: len(second)])
    d += first if order == 2 else -first
    for weight, one in zip(PASCAL[order][2:], others, strict=True):
        d += one if weight == 1 else weight * one
    return np.asarray(d).astype(np.float64, copy=False)


def lag_one(
    p: NDArray[Any], m: int, many: int, size: int, apart: int, lost: float, small: float, most: int
) -> tuple[float, int]:
    """Return the lag-1 autocorrelation of averages of m samples, and how often they were differenced to make it small.

    ``many`` stretches of ``size`` averages side by side, that begin ``apart`` points apart; a line is taken off, and
    what it took from the autocorrelation, ``lost``, given back.
    """
    at = np.arange(many)[:, None] * apart + np.arange(size + 1) * m
    y, time = 1.0 * np.diff(p[at], axis=1), at[:, :-1] - at[:, :-1].mean()
    y, times = y - y.mean() - (np.vdot(time, y) / np.vdot(time, time)) * time, 0
    while True:
        squares = np.vdot(y, y)
        r = float(np.vdot(y[:, 1:], y[:, :-1]) / squares) + (lost if times == 0 else 0.0) if squares > 0.0 else np.nan
        if not r >= small or times >= most:
            return r, times
        y, times = np.diff(y, axis=1), times + 1


def fill_exponents(
    p: NDArray[Any], factors: NDArray[np.int64], places: NDArray[np.int64], lost: Array, small: float, known: Array,
    out: Array,
) -> None:  # fmt: skip
    """Fill the exponent of the noise that averages tell at each factor; NaN where ``places`` (k, 3) are none."""
    for k, (m, place) in enumerate(zip(factors.tolist(), places.tolist(), strict=True)):
        out[k] = np.nan
        if place[0]:
            many, size, apart = place
            r, times = lag_one(p, m, many, size, apart, float(lost[k]), small, known.shape[1] - 1)
            out[k] = exponent_between(r, known[k, times, : 2 * times + 3])


def exponent_between(r: float, steps: Array) -> float:
    """Return the exponent of noise whose averages have a lag-1 autocorrelation, between those of whole exponents."""
    for i, here in enumerate(steps.tolist()):
        if r < here or np.isnan(r):
            return float(2.0 - i + (here - r) / (here - steps[i - 1]) if i else 2.0 + 0.0 * r)
    return 3.0 - len(steps)


def sum_present(
    p: NDArray[Any], count: NDArray[np.int32], pointwise: bool, factors: NDArray[np.int64], order: int,
    overlapping: bool, out: Array, terms: NDArray[np.int64], inflation: Array,
) -> None:  # fmt: skip
    """Fill sums of squares, the number of terms, and by how much missing samples raise the variance of white noise."""
    for k, m in enumerate(factors.tolist()):
        d, more = _present(p, count, pointwise, m, order, 1 if overlapping else m)
        there = np.isfinite(more)
        terms[k] = there.sum()
        out[k], inflation[k] = np.sum(d[there] ** 2), np.mean(more[there]) if terms[k] else 1.0


def sum_present_modified(
    p: NDArray[Any], count: NDArray[np.int32], pointwise: bool, factors: NDArray[np.int64], out: Array,
    terms: NDArray[np.int64], inflation: Array,
) -> None:  # fmt: skip
    """Fill the same for averages of m second differences, of which half must be there."""
    for k, m in enumerate(factors.tolist()):
        d, more = _present(p, count, pointwise, m, 2, 1)
        there = np.isfinite(more)
        running = np.zeros((3, len(d) + 1), dtype=np.longdouble)
        np.cumsum([np.where(there, d, 0.0), np.where(there, more, 0.0), there], axis=1, out=running[:, 1:])
        total, added, n = (running[:, m:] - running[:, :-m]).astype(np.float64)
        enough = (n > 0) & (n * FILL >= m)
        terms[k] = enough.sum()
        out[k] = np.sum((m * total[enough] / n[enough]) ** 2)
        inflation[k] = np.mean(added[enough] / n[enough]) if terms[k] else 1.0


def _present(
    p: NDArray[Any], count: NDArray[np.int32], pointwise: bool, m: int, order: int, stride: int
) -> tuple[Array, Array]:
    """Return differences, and how much white noise the missing samples add to each; infinite where it is not there."""
    terms = len(p) - order * m
    if pointwise:
        there = np.diff(count) > 0
        all_there = np.all([there[i * m : i * m + terms : stride] for i in range(order + 1)], axis=0)
        return _differences(p, m, terms, stride, order), np.where(all_there, 1.0, np.inf)
    starts, weights = np.arange(0, terms, stride), (-1, 1) if order == 2 else (1, -2, 1)
    d, more = np.zeros(len(starts)), np.zeros(len(starts))
    for i, weight in enumerate(weights):
        n = count[starts + (i + 1) * m] - count[starts + i * m]
        there = n * FILL >= m
        d += m * weight * (p[starts + (i + 1) * m] - p[starts + i * m]) / np.maximum(n, 1)
        more += np.where(there, m * weight**2 / np.maximum(n, 1), np.inf)
    return d, more / np.sum(np.square(weights))


def weights_of_ends(count: NDArray[np.int32], factors: NDArray[np.int64], overlapping: bool, ends: Array) -> None:
    """Fill m^2 / 2 of the mean of the squared weights that errors of the running sum have in a term of order 2."""
    there = np.concatenate(([False], np.diff(count) > 0, [False]))  # sample before each point, and after
    begins = np.concatenate(([0], np.cumsum(there[1:-1] & ~there[:-2])))
    goes_on = there[1:] & there[:-1]
    for k, m in enumerate(factors.tolist()):
        j = np.arange(0, len(count) - 2 * m, 1 if overlapping else m)
        a, b = count[j + m] - count[j], count[j + 2 * m] - count[j + m]
        used = (a * FILL >= m) & (b * FILL >= m)
        j, u, v = j[used], 1.0 / a[used], 1.0 / b[used]
        one, other = (begins[at + m] - begins[at] + goes_on[at] for at in (j, j + m))
        added = 2.0 * (one * u * u + other * v * v) + 2.0 * u * v * goes_on[j + m]
        ends[k] = 0.5 * m * m * np.mean(added) if len(j) else COMPLETE
