"""What a pass over a long array leaves of it: number, extremes, mean and scatter; the exact median in a few passes.

Batches are merged in order, by the formula of Chan, Golub and LeVeque [1]_, so that a variance keeps its digits beside
a large level. The median is selected by the bits of the numbers, 16 at a time, until few enough are left that they are
held [2]_; nothing is sorted, and no number is rounded.

References
----------
.. [1] T. F. Chan, G. H. Golub and R. J. LeVeque, Am. Stat. 37 (1983) 242: eq. (2.1).
.. [2] D. E. Knuth, The Art of Computer Programming 3, 2nd ed. (1998), 5.2.5: sorting by distribution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import batches, is_stored, near

AT_ONCE = 2**20  # numbers that are held to take their median
SPARED = 2**16  # numbers from which a rank is looked for among those near to it alone
THINNED = 32  # of so many numbers one tells where a rank lies ...
WIDE = 3.0  # ... to so many times the most that one standard deviation of it may be
DIGIT = 16  # bits that are looked at in one pass
SIGN, ALL = np.uint64(2**63), np.uint64(2**64 - 1)


@dataclass(frozen=True)
class Moments:
    """Of the finite numbers of an array."""

    count: int = 0
    mean: float = np.nan
    squares: float = 0.0  # sum of the squared distances from the mean
    low: float = np.nan
    high: float = np.nan

    @property
    def std(self) -> float | None:
        """Standard deviation (n - 1); None of fewer than two."""
        return float(np.sqrt(self.squares / (self.count - 1))) if self.count > 1 else None

    def with_more(self, part: NDArray[Any]) -> Moments:
        """Return them with those of another batch, shape (k,)."""
        numbers = part.astype(np.float64, copy=False)
        with np.errstate(over="ignore", invalid="ignore"):  # values near the end of float64
            if not np.isfinite(numbers.sum()):
                numbers = numbers[np.isfinite(numbers)]
            if not len(numbers):
                return self
            mean = float(numbers.mean())
            deviation = numbers - mean
            squares = float(deviation @ deviation)
            low, high, n = float(numbers.min()), float(numbers.max()), len(numbers)
            if not self.count:
                return Moments(n, mean, squares, low, high)
            count, apart = self.count + n, mean - self.mean
            squares = self.squares + squares + apart**2 * (self.count * n / count)
            return Moments(count, self.mean + apart * (n / count), squares, min(low, self.low), max(high, self.high))


def moments(x: NDArray[Any]) -> Moments:
    """Return number, mean, scatter and extremes of the finite numbers of an array, shape (n,), in one pass."""
    found = Moments()
    for first, stop in batches(x, size=near()):
        found = found.with_more(x[first:stop])
    return found


def median(x: NDArray[Any]) -> float:
    """Return the median of an array, shape (n,), NaN left out; NaN where there is no other."""
    return median_made(lambda first, stop: x[first:stop], x)


def median_made(part: Callable[[int, int], NDArray[Any]], *read: NDArray[Any]) -> float:
    """Return the median of numbers that are made batch by batch, NaN left out; NaN where there is no other.

    Parameters
    ----------
    part : callable
        Gives numbers first to stop, the same in every pass.
    *read : ndarray, shape (n, ...)
        That it reads.
    """
    if len(read[0]) <= AT_ONCE:
        return _median_of(part(0, len(read[0])))
    count, low, high = 0, 2**64, 0
    for first, stop in batches(*read):
        keys = _keys(part(first, stop))
        if len(keys):
            count, low, high = count + len(keys), min(low, int(keys.min())), max(high, int(keys.max()))
    if not count:
        return float("nan")
    lower, after = _selected(part, read, (count - 1) // 2, low, high, count)
    if count % 2:
        return lower + 0.0  # no -0.0
    upper = _selected(part, read, count // 2, low, high, count)[0] if after is None else after
    with np.errstate(over="ignore"):
        return float(np.mean([lower, upper])) + 0.0


def _median_of(x: NDArray[Any]) -> float:
    numbers = np.array(x, dtype=np.float64)
    numbers = numbers[~np.isnan(numbers)]
    if not len(numbers):
        return float("nan")
    middle = len(numbers) // 2
    numbers.partition(middle)  # of two ranks it takes thrice as long
    both = numbers[middle] if len(numbers) % 2 else [numbers[:middle].max(), numbers[middle]]
    with np.errstate(over="ignore"):
        return float(np.mean(both)) + 0.0  # no -0.0; one number is not summed: it may be large


def medians(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median of each row, shape (k,), none of them empty; all are finite."""
    half = rows.shape[1] // 2
    parted = np.partition(rows, half, axis=1)  # of two ranks it takes thrice as long
    upper: NDArray[np.float64] = parted[:, half]
    return upper if rows.shape[1] % 2 else 0.5 * (parted[:, :half].max(axis=1) + upper)


def quantile(x: NDArray[Any], share: float) -> float:
    """Return the quantile of finite numbers, shape (n,), a straight line between the two nearest ranks."""
    rank = int(share * (len(x) - 1))
    if not is_stored(x):
        part, before = _about(x, rank)
        numbers = np.partition(part, rank - before)  # of several ranks it takes thrice as long
        one, above = numbers[rank - before], numbers[rank - before + 1 :]
        apart = above.min() - one if len(above) else 0.0
        return float(one + (share * (len(x) - 1) - rank) * apart)
    ends = moments(x)
    low, high = (int(_keys(np.array([one]))[0]) for one in (ends.low, ends.high))

    def at(k: int) -> tuple[float, float | None]:
        return _selected(lambda first, stop: x[first:stop], (x,), k, low, high, len(x))

    lower, after = at(rank)
    if rank + 1 == len(x):
        return lower
    return lower + (share * (len(x) - 1) - rank) * ((at(rank + 1)[0] if after is None else after) - lower)


def _about(x: NDArray[Any], rank: int) -> tuple[NDArray[Any], int]:
    """Return numbers among which a rank and the next one are, and how many are less than all of these."""
    if len(x) < SPARED:
        return x, 0
    some = np.sort(x[::THINNED])
    reach = int(WIDE * np.sqrt(len(some)))
    low, high = some[max(rank // THINNED - reach, 0)], some[min(rank // THINNED + reach, len(some) - 1)]
    before, near = int(np.count_nonzero(x < low)), x[(x >= low) & (x <= high)]
    return (near, before) if before <= rank < before + len(near) - 1 else (x, 0)


def _selected(
    part: Callable[[int, int], NDArray[Any]], read: Sequence[NDArray[Any]], rank: int, low: int, high: int, count: int
) -> tuple[float, float | None]:
    """Return the number of a rank, counted from 0, and the next one if it was held with it.

    ``count`` numbers have keys from low to high; ``rank`` is among them.
    """
    while count > AT_ONCE and high > low:
        shift = max((high - low).bit_length() - DIGIT, 0)
        counts = np.zeros(2**DIGIT, dtype=np.int64)
        for first, stop in batches(*read):
            digit = (_within(part(first, stop), low, high) - np.uint64(low)) >> np.uint64(shift)
            counts += np.bincount(digit.astype(np.int64), minlength=2**DIGIT)
        ends = np.cumsum(counts)
        at = int(np.searchsorted(ends, rank, side="right"))
        rank -= int(ends[at - 1]) if at else 0
        low, count = low + (at << shift), int(counts[at])
        high = min(high, low + (1 << shift) - 1)
    if high == low:
        return _number(low), _number(low) if rank + 1 < count else None
    held = np.concatenate([_within(part(first, stop), low, high) for first, stop in batches(*read)])
    last = min(rank + 1, len(held) - 1)
    held.partition((rank, last))
    return _number(int(held[rank])), _number(int(held[last])) if last > rank else None


def _keys(x: NDArray[Any]) -> NDArray[np.uint64]:
    """Return whole numbers in the order of the numbers, NaN left out."""
    numbers = np.ascontiguousarray(x, dtype=np.float64)
    missing = np.isnan(numbers)
    bits = (numbers[~missing] if missing.any() else numbers).view(np.uint64)
    return bits ^ np.where(bits >> np.uint64(63), ALL, SIGN)


def _within(x: NDArray[Any], low: int, high: int) -> NDArray[np.uint64]:
    keys = _keys(x)
    return keys[(keys >= np.uint64(low)) & (keys <= np.uint64(high))]


def _number(key: int) -> float:
    bits = np.array([key ^ (int(SIGN) if key & int(SIGN) else int(ALL))], dtype=np.uint64)
    return float(bits.view(np.float64)[0])
