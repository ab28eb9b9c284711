"""Power of long segments: two real ones in one complex transform, and that in two steps that a cache holds.

A complex transform of ``a + i b`` has at k the power of a and b together, and twice their cross term, which at n - k
has the other sign: of a sum of powers only the mean of both is wanted, and nothing need be taken apart.

A transform of n = p q values is one of p values for each of q columns, a turn of each value, and one of q values for
each row [1]_: short transforms stay in the nearest cache, and eight are made at a time.

References
----------
.. [1] D. H. Bailey, J. Supercomputing 4 (1990) 23-35: FFTs in external or hierarchical memory (four steps).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...core.batches import release
from ...core.estimate import Array

Indices = NDArray[np.int64]

LONG = 2**15  # samples of a segment: a shorter one lies in the nearest cache, and gains less than loops take to compile
NARROW = 32  # columns, or rows, below which the steps gain nothing
FACTORS = (4, 2, 3, 5)  # of a length that is transformed in steps
APART = 8  # values between rows: 2 kB or 4 kB apart they would share lines of a cache


@lru_cache(64)
def columns_of(n: int) -> int:
    """Return a divisor of n near to its root, not above it; 1 where steps of it gain nothing."""
    if n < LONG or not _factors(n):
        return 1
    nearest = next(one for one in range(int(np.sqrt(n)), 0, -1) if n % one == 0)
    return nearest if nearest >= NARROW else 1


def _factors(n: int) -> list[int]:
    """Return the factors of a length; none where it has others."""
    found = []
    for factor in FACTORS:
        while n % factor == 0:
            found.append(factor)
            n //= factor
    return found if n == 1 else []


class Steps:
    """What the transforms of a length n = p q need: factors of both steps, turns of each pass, and between them."""

    def __init__(self, n: int) -> None:
        from .._kernels_lanes import LANES, aligned  # noqa: PLC0415 - numba starts slowly

        self.p = columns_of(n)
        self.q = n // self.p
        self.factors = np.array(_factors(self.p)), np.array(_factors(self.q))
        self.turns = _turns(self.p), _turns(self.q)
        row, column = np.arange(self.p)[:, None], np.minimum(np.arange(0, self.q, LANES), self.q - LANES)
        near, far = _turned(row * np.arange(LANES), n), _turned(row * column, n)
        self.between = aligned(2 * (near.size + far.size))
        self.between[: 2 * near.size] = np.stack((near.real, near.imag), axis=1).ravel()
        self.between[2 * near.size :] = np.ascontiguousarray(far.T).view(np.float64).ravel()


@lru_cache(2)
def steps_of(n: int) -> Steps:
    """Return the steps of a length."""
    return Steps(n)


def _turned(product: NDArray[np.int64], n: int) -> NDArray[np.complex128]:
    found: NDArray[np.complex128] = np.exp(-2j * np.pi / n * product)
    return found


def _turns(n: int) -> Array:
    """Return what each pass of a transform turns its values by, real and imaginary part in turn."""
    found, left = [], n
    for factor in _factors(n):
        found.append(_turned(np.arange(left // factor)[:, None] * np.arange(1, factor), left).ravel())
        left //= factor
    return np.concatenate(found).view(np.float64)


class Room:
    """Room for transforms of one length, one after the other: to touch fresh memory takes as long as a transform."""

    def __init__(self, steps: Steps) -> None:
        from .._kernels_lanes import aligned  # noqa: PLC0415 - numba starts slowly
        from ._kernels_transform import TOGETHER, WIDE  # noqa: PLC0415

        longest = max(TOGETHER * steps.p, steps.q)
        self.wide = steps.p + APART
        self.rooms = aligned(WIDE * longest), aligned(WIDE * longest)
        self.middle, self.nothing = aligned(2 * steps.q * self.wide), np.zeros(steps.p * steps.q)


def power_of(x: Array, starts: Indices, weights: Array, rooms: list[Room]) -> Array:
    """Return the sum of the squared magnitudes of the transforms of segments, as `folded` takes it, shape (q, p).

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
    from ._kernels_transform import add_rows, fill_columns  # noqa: PLC0415 - numba starts slowly

    n = weights.shape[1]
    steps = steps_of(n)
    try:
        room = rooms.pop()
    except IndexError:
        room = Room(steps)
    power = np.zeros((steps.q, room.wide))
    for i in range(0, len(starts), 2):
        two = [np.ascontiguousarray(x[first : first + n]) for first in starts[i : i + 2]]
        levels = np.array([one.mean() for one in two] + [0.0])
        other = two[1] if len(two) > 1 else room.nothing
        for taper in weights:
            fill_columns(
                two[0], other, levels, taper, steps.p, steps.q, steps.factors[0], steps.turns[0], steps.between,
                *room.rooms, room.middle, room.wide,
            )  # fmt: skip
            add_rows(
                room.middle, room.wide, steps.p, steps.q, steps.factors[1], steps.turns[1], *room.rooms, power.ravel()
            )
        release(x[starts[i] : starts[i] + n])
    rooms.append(room)
    return power[:, : steps.p]


def folded(power: Array) -> Array:
    """Return sums of squared magnitudes of pairs as those of real signals, in the order of frequency, (n // 2 + 1,)."""
    n, every = power.size, power.ravel()
    return np.asarray(0.5 * (every[: n // 2 + 1] + np.append(every[0], every[: (n - 1) // 2 : -1])))


def lanes_of(n: int) -> Lanes | None:
    """Return what transforms of a short length take, eight pairs at a time; None where it has other factors."""
    return _lanes(n) if n < LONG and _factors(n) else None


@lru_cache(4)
def _lanes(n: int) -> Lanes:
    return Lanes(n)


class Lanes:
    """Factors and turns of transforms of one length, and room for eight of them."""

    def __init__(self, n: int) -> None:
        from .._kernels_lanes import aligned  # noqa: PLC0415 - numba starts slowly
        from ._kernels_transform import WIDE  # noqa: PLC0415

        self.factors, self.turns, self.most = np.array(_factors(n)), _turns(n), WIDE
        self._size = WIDE * n
        self._aligned = aligned

    def rooms(self) -> tuple[Array, Array]:
        """Return room for two times eight transforms."""
        return self._aligned(self._size), self._aligned(self._size)

    def add_power(self, x: Array, starts: Indices, weights: Array, rooms: tuple[Array, Array], power: Array) -> None:
        """Add the squared magnitudes of the transforms of segments under one taper, shape (n // 2 + 1,)."""
        from ._kernels_transform import add_whole, fill_segments, transformed  # noqa: PLC0415 - numba starts slowly

        for first in range(0, len(starts), self.most):
            fill_segments(x, starts[first : first + self.most], weights, rooms[0])
            add_whole(transformed(*rooms, self.factors, self.turns), power)
