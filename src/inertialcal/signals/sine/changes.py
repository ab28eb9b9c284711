"""What changes inside a record of a driven sensor: jumps of the level, and a response that is not the same throughout.

*Jumps.* Means of four neighbouring windows of w readings, ``(m_3 - m_2) - (m_4 - m_1) / 3``: two thirds of a jump in
the middle, nothing of a steady drift. Judged against its own median along all records, for each w, so that white noise
and random walks set their own limits. What smooth drift leaves falls with the third power of w: windows half as long
must show the jump as well. What comes back soon is none: windows twice as long must show it too.

*Response.* The amplitude of each cycle, drift taken off: two parts of a record whose means differ, by the scatter of
cycles in each.

The chance of a false alarm holds for all records together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array
from ..threads import each_of
from . import _kernels

T = TypeVar("T", np.float64, np.int64)

MAD = 0.6745  # median of |x| of normal noise
STEP_PART = 2.0 / 3.0  # of a jump, that shows
WINDOWS = (1, 2, 4, 8)  # readings
ROOM = 12  # windows that a record must hold
INDEPENDENT = 0.25  # of the windows that there is room for: their median scatter counts so many
SMOOTH = 2.5  # standard deviations by which a jump may look smaller in windows half or twice as long
SHOWS = (
    0.35  # of a jump, that windows half as long show, also where it comes within a reading; of smooth drift, an eighth
)
CERTAIN = 10.0  # standard deviations that are a jump, wherever it comes
STAYS = 0.75  # of a jump, that windows twice as long show
FEWEST_CYCLES = 8  # of a record, in which a change of the response is looked for
FEW = 3  # cycles of a part


class Jump(NamedTuple):
    """The largest jump of a record: over the limit, reading that it comes before, size."""

    score: float
    at: int
    size: float


class ResponseChange(NamedTuple):
    """The largest change of a response: over the limit, first cycle of the second part, means of both parts."""

    score: float
    at: int
    before: float
    after: float


def critical(chance: float, dof: float) -> float:
    """Return what |t| exceeds with this chance."""
    return float(-special.stdtrit(dof, 0.5 * chance)) if np.isfinite(dof) else float(-special.ndtri(0.5 * chance))


def jumps(records: Sequence[Array], chance: float) -> list[Jump | None]:
    """Return the largest jump of each record that noise does not explain; None where there is none.

    Parameters
    ----------
    records : sequence of ndarray, shape (n,)
        Evenly spaced readings without the drive; NaN for a gap.
    chance : float
        Of any false one.
    """
    widths = (*WINDOWS, 2 * WINDOWS[-1])

    sums = [_sums_of(x) for x in records]

    def seen(w: int) -> tuple[list[Array], list[float]]:
        own = [_contrast_of(one, w) for one in sums]
        return own, [_scale(one) for one in own]

    every_width = each_of(seen, widths, len(widths) * sum(map(len, records)))
    contrasts = {w: own for w, (own, _) in zip(widths, every_width, strict=True)}
    scales = {w: own for w, (_, own) in zip(widths, every_width, strict=True)}
    found: list[Jump | None] = [None] * len(records)
    for w in WINDOWS:
        long_enough = [len(x) >= ROOM * w for x in records]
        room = sum(len(x) for x, there in zip(records, long_enough, strict=True) if there)
        every = [k for k, there in enumerate(long_enough) if there]
        scale = scales[w][every[0]] if len(every) == 1 else (
            _scale(np.concatenate([np.empty(0), *(contrasts[w][k] for k in every)])))  # fmt: skip
        if not scale > 0.0:
            continue
        limit = critical(chance / (len(WINDOWS) * room), max(INDEPENDENT * room / w, 2.0))
        for k, there in enumerate(long_enough):
            own = contrasts[w][k]
            at = _kernels.farthest_from_zero(own) if there else -1
            if at < 0:
                continue
            sign, size = float(np.sign(own[at])), abs(float(own[at]))
            score = size / (limit * max(scale, scales[w][k]))
            narrow, wide = (contrasts[v][k] if v in contrasts else None for v in (w // 2, 2 * w))
            smooth = narrow is not None and sign * narrow[at] < _shown(size, scales[w // 2][k])
            back = wide is not None and sign * wide[at] < STAYS * size - SMOOTH * scales[2 * w][k]
            one = found[k]
            if score > (1.0 if one is None else one.score) and not smooth and not back:
                found[k] = Jump(score, at, sign * size / STEP_PART)
    return found


def _shown(size: float, noise: float) -> float:
    """Return what windows half as long must show of a jump."""
    return min(size - SMOOTH * noise, max(SHOWS * size, CERTAIN * noise))


def contrast(x: Array, w: int) -> Array:
    """Return the contrast of four windows of w readings around the first of the third; NaN where some lack readings."""
    return _contrast_of(_sums_of(x), w)


def _sums_of(x: Array) -> tuple[Array, NDArray[np.int64] | None]:
    """Return the running sum of readings, and of how many there are; None where there are all."""
    good = np.isfinite(x)
    if good.all():
        return _running(x), None
    return _running(np.where(good, x, 0.0)), _running(good.astype(np.int64))


def _contrast_of(running: tuple[Array, NDArray[np.int64] | None], w: int) -> Array:
    sums, counts = running
    n = len(sums) - 1
    many = max(min(n - 2 * w, n - 4 * w + 1), 0)
    found = np.empty(n)
    found[: 2 * w] = found[2 * w + many :] = np.nan
    part = found[2 * w : 2 * w + many]
    if counts is None:
        _kernels.four_windows(sums, w, part)
    else:
        _kernels.four_windows_with_gaps(sums, counts, w, part)
    return found


def _running(values: NDArray[T]) -> NDArray[T]:
    """Return the running sum, with a zero before it."""
    found = np.zeros(len(values) + 1, values.dtype)
    np.cumsum(values, out=found[1:])
    return found


def _scale(values: Array) -> float:
    """Return the standard deviation of most values."""
    finite, below, sizes = _kernels.middle_sizes(values, np.zeros(_kernels.KEYS, np.int64))
    if not finite:
        return 0.0
    middle = np.array([(finite - 1) // 2, finite // 2]) - below
    return float(np.mean(np.partition(sizes, middle)[middle])) / MAD


def cycle_amplitudes(rest: Array, drive: Array, cycle: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Return the amplitude of each cycle that holds half of its drive or more, and the reading that it begins with.

    Parameters
    ----------
    rest, drive : ndarray, shape (n,)
        Readings without drift, NaN for a gap; what drives them.
    cycle : ndarray of int, shape (n,)
        Number of the cycle of each reading, ascending.
    """
    first = np.searchsorted(cycle, np.arange(int(cycle[-1]) + 1)).astype(np.int64)
    there = np.isfinite(rest)
    if not there.all():
        rest, drive = np.where(there, rest, 0.0), np.where(there, drive, 0.0)
    power, product = (_summed(values, first) for values in (drive**2, rest * drive))
    each = product / np.where(power > 0.0, power, 1.0)
    enough = power > 0.5 * np.median(power)
    return each[enough], first[enough]


def _summed(values: Array, first: NDArray[np.int64]) -> Array:
    """Return the sums of values from each of some places, ascending, to the next; 0 where they are one."""
    return np.where(np.diff(first, append=len(values)) > 0, np.add.reduceat(values, first), 0.0)


def response_changes(amplitudes: Sequence[Array], chance: float) -> list[ResponseChange | None]:
    """Return the largest change of each record's response that noise does not explain; None where there is none.

    Parameters
    ----------
    amplitudes : sequence of ndarray, shape (m,)
        Of the cycles of each record.
    chance : float
        Of any false one.
    """
    known = [each for each in amplitudes if len(each) >= FEWEST_CYCLES]
    if not known:
        return [None] * len(amplitudes)
    usual = float(np.median([0.5 * np.mean(np.diff(each) ** 2) for each in known]))
    dof = float(sum(len(each) - 2 for each in known))
    limit = critical(chance / dof, dof)
    found: list[ResponseChange | None] = []
    for each in amplitudes:
        m, best = len(each), None
        if m < FEWEST_CYCLES:
            found.append(None)
            continue
        k = np.arange(FEW, m - FEW + 1)
        sums, squares = np.cumsum(each), float(np.sum(each**2))
        before, after = sums[k - 1] / k, (sums[-1] - sums[k - 1]) / (m - k)
        inside = np.maximum(squares - k * before**2 - (m - k) * after**2, 0.0) / (m - 2.0)
        noise = np.sqrt(np.maximum(inside, usual) * (1.0 / k + 1.0 / (m - k)))
        t = np.abs(after - before) / np.where(noise > 0.0, noise, np.inf)
        j = int(np.argmax(t))
        if t[j] > limit:
            best = ResponseChange(float(t[j]) / limit, int(k[j]), float(before[j]), float(after[j]))
        found.append(best)
    return found
