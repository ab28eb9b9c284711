"""Codes of a channel: its resolution step, and steps that are coarse. No converter is assumed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ..core.batches import batches, count, extremes
from ..core.estimate import Array
from ..core.remarks import Remark
from ..core.show.rounding import number

REPEATS = 2.0  # a step is looked for where values occur at least this often on average
SORTED = 100_000  # values up to which they are sorted without a look whether they repeat
MARKED = 2**19  # values of which each different one is marked; of more one in 2, 4, ..., that a cache holds the marks
SURE = 1.05  # times the share of the values looked for: marks beyond it are no chance, by 6 deviations and more
CHUNK = 2**15  # samples looked at together
ENOUGH = 2**11  # samples of noise that show by themselves that steps are not coarse
FIRST = 2**13  # samples that are sorted first: of noise, some of so many lie closer together than codes
LEVELS = 2**24  # most levels that a converter has
JITTER = 1000.0  # last digits of the largest value: what is closer may be one level, rounded in several ways
OFF_STEP = 0.02  # largest distance from a whole number of steps, in steps
DIVIDERS = 10  # a gap between neighbouring levels may be this many steps
COARSE = 2.0  # steps over the scatter before rounding, from which rounding matters (N reads 15 % too large)
FINE = 1.0 / COARSE**2 + 1.0 / 12.0  # mean square of readings, in squared steps, from which they are not coarse
BLIND = 3.3  # the same, from which nobody can tell how much: it hangs on where the level lies between two codes


@dataclass(frozen=True, eq=False)
class Levels:
    """Different values of a channel, in order, and how often each occurs."""

    values: Array
    counts: NDArray[np.int64]


def levels_of(values: NDArray[np.generic]) -> Levels:
    """Return the different values of a channel.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Finite, in any unit.
    """
    return Levels(*np.unique(values.astype(np.float64), return_counts=True))


def resolution_of_values(values: NDArray[np.generic], finite: int | None = None) -> float | None:
    """Return the step of values, shape (n,), as `resolution` of their levels; None where there is none.

    Those that are not finite are left out. Of a long record nothing is sorted but its levels: a set holds them, unless
    marks, one for each value, show before that they are too many. ``finite``: how many are finite, where it is known.
    """
    if len(values) > FIRST and _finer_than_codes(values):
        return None
    if len(values) <= SORTED:
        return resolution(levels_of(values[np.isfinite(values)]))
    finite = count(values, np.isfinite) if finite is None else finite
    most = min(int(finite / REPEATS), LEVELS) + 1
    if finite < 2 or _hardly_repeats(values, most):
        return None
    levels = _levels_in(values, most)
    return None if levels is None or finite < REPEATS * len(levels) else _step(levels)


def _finer_than_codes(values: NDArray[np.generic]) -> bool:
    """Return whether the first values alone lie closer together than steps of the most levels that a converter has."""
    low, high = extremes(values, infinite=False)
    with np.errstate(over="ignore", invalid="ignore"):  # as in `_step`
        for few in (FIRST, CHUNK):
            some = values[:few].astype(np.float64)
            apart = np.diff(np.sort(some[np.isfinite(some)]))
            apart = apart[apart > JITTER * np.spacing(max(abs(low), abs(high)))]
            if len(apart) and (high - low) / apart.min() > 2.0 * LEVELS:
                return True
    return False


def _hardly_repeats(values: NDArray[np.generic], most: int) -> bool:
    """Return whether marks show more different values."""
    from ._kernels import count_marks  # noqa: PLC0415 - numba starts slowly

    fold = max((len(values) // MARKED).bit_length() - 1, 0)
    room, found, enough = (len(values) >> fold).bit_length() + 2, 0, most * (SURE if fold else 1.0) / 2**fold
    marks = np.zeros(2 ** max(room - 6, 0), dtype=np.uint64)
    for first, stop in batches(values, size=CHUNK):
        found += count_marks(_bits(values[first:stop]), room, fold, enough - found, marks)
        if found > enough:
            return True
    return False


def _levels_in(values: NDArray[np.generic], most: int) -> Array | None:
    """Return the different finite values in order; None where there are more."""
    from ._kernels import fill_set  # noqa: PLC0415 - numba starts slowly

    room, filled = CHUNK.bit_length() + 1, 0
    table = np.zeros(2**room, dtype=np.uint64)
    for first, stop in batches(values, size=CHUNK):
        if 2 * (filled + CHUNK) > len(table):
            known, room = table[table != 0], room + 1
            table = np.zeros(2**room, dtype=np.uint64)
            fill_set(known, room, table, 0)
        filled = int(fill_set(_bits(values[first:stop]), room, table, filled))
        if filled > most:
            return None
    return np.unique(table[table != 0].view(np.float64) + 0.0)


def _bits(part: NDArray[np.generic]) -> NDArray[np.uint64]:
    """Return the bits of finite values: -0.0 for 0.0, so that none are zero."""
    values = np.ascontiguousarray(part, dtype=np.float64)
    if not (good := np.isfinite(values)).all():
        values = values[good]
    if not values.all():
        values = np.where(values == 0.0, -0.0, values)
    return values.view(np.uint64)


def resolution(found: Levels) -> float | None:
    """Return the step of which all differences are whole multiples, or None where there is none.

    None also where values hardly repeat: then the step would be that of the printed digits.
    """
    return None if found.counts.sum() < REPEATS * len(found.values) else _step(found.values)


def _step(levels: Array) -> float | None:
    """Return the step of levels in order; None where there is none."""
    if len(levels) < 2:
        return None
    with np.errstate(over="ignore"):  # of the largest numbers, which have no step
        apart, rounding = np.diff(levels), 4.0 * np.spacing(np.abs(levels).max())
    apart = apart[apart > rounding]
    if not len(apart):
        return None
    for divider in range(1, DIVIDERS + 1):
        step = _refined(apart, float(apart.min()) / divider)
        if step is not None and (levels[-1] - levels[0]) / step <= LEVELS:
            return step
    return None


def _refined(apart: Array, step: float) -> float | None:
    """Mean step, where (nearly) every distance is a whole number of steps."""
    # Near levels first: their whole numbers are certain and give the step with which to count the far ones.
    near = apart[apart < 8.0 * apart.min()]
    step = float(near.sum() / np.rint(near / step).sum())
    whole = np.rint(apart / step)
    off = np.abs(apart / step - whole) > OFF_STEP * np.maximum(whole, 1.0) ** 0.5
    return float(apart.sum() / whole.sum()) if not off.any() else None


def surely_fine(values: Array) -> bool:
    """Return whether `coarse_steps` says nothing of samples, shape (n,), by one look at the first of them."""
    from ._kernels import fine_steps  # noqa: PLC0415 - numba starts slowly

    return bool(fine_steps(values, ENOUGH, FINE))


def coarse_steps(values: Array, name: str) -> tuple[Remark, ...]:
    """Return the remark on steps that are coarse against the scatter, with what they do to the size of white noise.

    Rounding to steps D adds D^2 / 12 to the variance of samples that scatter by more than about a third of a step
    (Sheppard); where they scatter less, it may add anything, and what is slow is rounded with the rest.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Samples, in any unit; those that are not finite are left out.
    name : str
        Of the channel.

    References
    ----------
    B. Widrow, I. Kollar and M.-C. Liu, IEEE Trans. Instrum. Meas. 45 (1996) 353: statistical theory of quantization.
    """
    step, squares, steps, last, rest = np.inf, 0.0, 0, np.empty(0), values[ENOUGH:]
    for part in chain([values[:ENOUGH]], (rest[first:stop] for first, stop in batches(rest, size=CHUNK))):
        there = np.concatenate((last, part[np.isfinite(part)]))
        difference, last = np.abs(np.diff(there)), there[-1:]
        squares, steps = squares + float(difference @ difference), steps + len(difference)
        step = float(np.min(difference, initial=step, where=difference > 0.0))
        if squares / len(values) / 2.0 >= step**2 * FINE:  # what follows can but add squares, and find smaller steps
            return ()
    if not np.isfinite(step):
        return ()
    read = squares / steps / 2.0
    before = read - step**2 / 12.0
    if read >= step**2 * FINE:
        return ()
    what = f"{name}: steps of the readings are {number(step / float(np.sqrt(read)), 2)} times their scatter: "
    if before < (step / BLIND) ** 2:
        what += "the error of the random walk cannot be estimated"
    else:
        more = 100.0 * (float(np.sqrt(read / before)) - 1.0)
        what += f"rounding makes the random walk about {number(more, 2)} % too large"
    do = "Use a finer range or more bits, or take the random walk as an upper bound"
    return (Remark("coarse_codes", "warning", what, do=do),)
