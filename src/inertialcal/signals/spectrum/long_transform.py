"""Power of long segments: two real ones in one complex transform, and that in two steps that a cache holds.

A complex transform of ``a + i b`` has at k the power of a and b together, and twice their cross term, which at n - k
has the other sign: of a sum of powers only the mean of both is wanted, and nothing need be taken apart.

A transform of n = p q values is one of p values for each of q columns, a turn of each value, and one of q values for
each row [1]_: short transforms stay in the nearest cache, and several are made at a time.

References
----------
.. [1] D. H. Bailey, J. Supercomputing 4 (1990) 23-35: FFTs in external or hierarchical memory (four steps).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...core.batches import release
from ...core.estimate import Array

Indices = NDArray[np.int64]

LONG = 2**15  # samples of a segment: a shorter one lies in the nearest cache
NARROW = 32  # columns, or rows, below which the steps gain nothing
APART = 8  # values between rows


@lru_cache(64)
def columns_of(n: int) -> int:
    """Return a divisor of n near to its root, not above it; 1 where steps of it gain nothing."""
    if n < LONG:
        return 1
    nearest = next(one for one in range(int(np.sqrt(n)), 0, -1) if n % one == 0)
    return nearest if nearest >= NARROW else 1


@lru_cache(2)
def turns_of(n: int) -> NDArray[np.complex128]:
    """Return exp(-2 pi i j k / n) for row j and column k of the two steps, shape (p, n / p)."""
    p = columns_of(n)
    product = np.arange(p)[:, None] * np.arange(n // p)
    found: NDArray[np.complex128] = np.exp(-2j * np.pi / n * product)
    return found


class Room:
    """Room for transforms of n samples, one after the other: to touch fresh memory takes as long as a transform."""

    def __init__(self, n: int) -> None:
        p = columns_of(n)
        rows = np.empty((p, n // p + APART), dtype=np.complex128)  # 8 or 16 kB apart they would share lines of a cache
        self.pair, self.parts = rows[:, : n // p], rows.view(np.float64)
        self.nothing = np.zeros(n)


def power_of(x: Array, starts: Indices, weights: Array, rooms: list[Room]) -> Array:
    """Return the sum of the squared magnitudes of the transforms of segments, as `folded` takes it, shape (p, n / p).

    Parameters
    ----------
    x : ndarray, shape (m,)
        Samples.
    starts : ndarray of int, shape (k,)
        First samples of the segments; each has its mean removed.
    weights : ndarray, shape (tapers, n)
        Tapers, all of each segment.
    rooms : list of Room
        That other calls of segments of this length have left; this one leaves its own.
    """
    from ._kernels import add_power, fill_pair  # noqa: PLC0415 - numba starts slowly

    n = weights.shape[1]
    try:
        room = rooms.pop()
    except IndexError:
        room = Room(n)
    turns, power = turns_of(n), np.zeros(room.pair.shape)
    for i in range(0, len(starts), 2):
        two = [x[first : first + n] for first in starts[i : i + 2]]
        levels = np.array([one.mean() for one in two] + [0.0])
        for taper in weights:
            fill_pair(two[0], two[1] if len(two) > 1 else room.nothing, levels, taper, room.parts)
            found = fft.fft(room.pair, axis=0, overwrite_x=True)
            found *= turns
            add_power(fft.fft(found, axis=1, overwrite_x=True), power)
        release(x[starts[i] : starts[i] + n])
    rooms.append(room)
    return power


def folded(power: Array) -> Array:
    """Return sums of squared magnitudes of pairs as those of real signals, in the order of frequency, (n // 2 + 1,)."""
    n, every = power.size, power.T.ravel()
    return np.asarray(0.5 * (every[: n // 2 + 1] + np.append(every[0], every[: (n - 1) // 2 : -1])))
