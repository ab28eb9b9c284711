"""Codes of a channel: its resolution step, values that pile up at a rail, values that are stuck, steps that are coarse.

All judgements are against what the channel itself does elsewhere; no converter is assumed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..core.estimate import Array
from ..core.remarks import Remark
from ..core.show.rounding import number

REPEATS = 2.0  # a step is looked for where values occur at least this often on average
LEVELS = 2**24  # most levels that a converter has
OFF_STEP = 0.02  # largest distance from a whole number of steps, in steps
DIVIDERS = 10  # a gap between neighbouring levels may be this many steps
PILE = 5  # fewest samples at an extreme that are called a pile ...
PILE_RATIO = 3.0  # ... and how much more than at the next level
STEPS = 2  # levels inside that pile up: the channel is set in steps
FEW_LEVELS = 10  # with fewer levels (a switch, a flag) the extremes are no rails
RAIL_CODES = frozenset(
    {0, *(2**bits - 1 for bits in (8, 10, 12, 14, 16, 24, 32))}
    | {code for bits in (8, 10, 12, 14, 16, 24, 32) for code in (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)}
)  # ends of the usual converters, unsigned and two's complement
STUCK_CHANCE = 1e-6  # chance of a run so long, were neighbours independent
STUCK_RUN = 10  # shortest run that is called stuck ...
STUCK_RATIO = 5.0  # ... and how much longer than the run that a sample elsewhere lies in, on average
ALIKE = 10  # runs of the same value from which their own share of equal neighbours is known
COARSE = 2.0  # steps over the scatter before rounding, from which rounding matters (N reads 15 % too large)
BLIND = 3.3  # the same, from which nobody can tell how much: it hangs on where the level lies between two codes
CONSTANT_IN_COUNTS = 2  # a rail of a known converter shows from so many samples


@dataclass(frozen=True, eq=False)
class Levels:
    """Different values of a channel, in order, and how often each occurs."""

    values: Array
    counts: NDArray[np.int64]


@dataclass(frozen=True)
class Run:
    """Equal neighbouring values: index of the first, how many, and their value."""

    start: int
    length: int
    value: float


@dataclass(frozen=True)
class Rail:
    """Samples at an extreme: its value, how many, and whether it is the end of a usual converter."""

    value: float
    count: int
    is_code: bool


def levels_of(values: NDArray[np.generic]) -> Levels:
    """Return the different values of a channel.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Finite, in any unit.
    """
    return Levels(*np.unique(values.astype(np.float64), return_counts=True))


def resolution(found: Levels) -> float | None:
    """Return the step of which all differences are whole multiples, or None where there is none.

    None also where values hardly repeat: then the step would be that of the printed digits.
    """
    levels = found.values
    if len(levels) < 2 or found.counts.sum() < REPEATS * len(levels):
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


def rails(found: Levels) -> tuple[Rail, ...]:
    """Return the extremes at which values pile up: clipped samples.

    An extreme counts if at least five samples lie on it, three times as many as on the level beside it; or,
    for whole numbers, if two samples lie on the last code of a usual converter. Where levels inside pile up like
    that too, the channel goes in steps (the rate of a table), and its extremes are two of them.
    """
    levels, counts = found.values, found.counts
    if len(levels) < FEW_LEVELS:
        return ()
    steps = _goes_in_steps(counts)
    whole = bool(np.all(levels == np.rint(levels)))
    piles = []
    for end, inner in ((0, 1), (-1, -2)):
        count, is_code = int(counts[end]), whole and int(levels[end]) in RAIL_CODES
        piled = not steps and count >= PILE and count > PILE_RATIO * counts[inner]
        # Zero is the end of an unsigned converter only for channels that live far above it.
        at_code = is_code and count >= CONSTANT_IN_COUNTS and levels[end] != 0.0
        if piled or at_code:
            piles.append(Rail(float(levels[end]), count, is_code))
    return tuple(piles)


def _goes_in_steps(counts: NDArray[np.int64]) -> bool:
    """Whether two levels or more between the extremes stand out from both their neighbours as a pile does."""
    inside = counts[1:-1]
    inner = np.maximum(counts[:-2], counts[2:])
    return int(np.count_nonzero((inside >= PILE) & (inside > PILE_RATIO * inner))) >= STEPS


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
    difference = np.diff(values[np.isfinite(values)])
    sizes = np.abs(difference[difference != 0.0])
    if not len(sizes):
        return ()
    step, read = float(sizes.min()), float(np.mean(difference**2)) / 2.0
    before = read - step**2 / 12.0
    if read >= step**2 * (1.0 / COARSE**2 + 1.0 / 12.0):
        return ()
    what = f"{name}: steps of the readings are {number(step / float(np.sqrt(read)), 2)} times their scatter: "
    if before < (step / BLIND) ** 2:
        what += "the error of the random walk cannot be estimated"
    else:
        more = 100.0 * (float(np.sqrt(read / before)) - 1.0)
        what += f"rounding makes the random walk about {number(more, 2)} % too large"
    do = "Use a finer range or more bits, or take the random walk as an upper bound"
    return (Remark("coarse_codes", "warning", what, do=do),)


def longest_run(values: NDArray[np.generic]) -> Run:
    """Return the longest stretch of equal neighbouring values.

    Parameters
    ----------
    values : ndarray, shape (n,), n >= 1
        In any unit.
    """
    starts, lengths = _runs(values)
    at = int(np.argmax(lengths))
    return Run(int(starts[at]), int(lengths[at]), float(values[starts[at]]))


def is_stuck(values: NDArray[np.generic]) -> bool:
    """Whether the longest run of equal values is far longer than the channel's other runs explain.

    With p the share of equal neighbours outside that run (of all samples, or of those with its value where that is
    larger), n samples hold about n p**(k-1) runs of k; the run is stuck where this is below 1e-6, and it is also five
    times longer than the run that a sample elsewhere lies in, on average (slow channels repeat their codes).

    Parameters
    ----------
    values : ndarray, shape (n,), n >= 1
        In any unit. A constant channel is stuck.
    """
    starts, lengths = _runs(values)
    at = int(np.argmax(lengths))
    longest = int(lengths[at])
    if longest == len(values):
        return longest >= STUCK_RUN
    others = np.delete(lengths, at)
    same = values[starts] == values[starts[at]]
    same[at] = False
    alike = lengths[same]
    equal = (others - 1).sum() / max(others.sum() - 1, 1)
    if len(alike) >= ALIKE:
        equal = max(equal, (alike - 1).sum() / alike.sum())
    log_chance = np.log(len(values)) + (longest - 1) * np.log(max(equal, 1.0 / len(values)))
    usual = float((others.astype(np.float64) ** 2).sum() / others.sum())
    long = longest >= max(STUCK_RUN, STUCK_RATIO * usual)
    return bool(long and log_chance < np.log(STUCK_CHANCE))


def _runs(values: NDArray[np.generic]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Start and length of each stretch of equal values."""
    changes = np.flatnonzero(values[1:] != values[:-1]) + 1
    starts = np.concatenate([[0], changes])
    return starts, np.diff(np.concatenate([starts, [len(values)]]))
