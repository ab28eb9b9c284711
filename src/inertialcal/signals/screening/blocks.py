"""A record in blocks: extremes, mean, roughness and equal neighbours of each, read in one pass.

Nothing else of the screening reads the whole record. Blocks have 16 samples or more, and so many that what is kept of
them is small beside the record (``SHARE``), or small at all (``FREE``).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, is_stored, known_finite, release
from ...core.errors import DataError
from ...core.estimate import Array
from ..time.samples import Indices
from .loops import Whole, loops_for

SMALLEST = 16  # samples of a block
FREE = 2**14  # blocks that any record may have
SHARE = 0.0125  # of the memory of the record, for its blocks
EACH = 44  # bytes kept of a block
SUBSAMPLE = 2**15  # samples that scales are taken from ...
PIECE = 64  # ... in pieces of so many neighbours
TOGETHER = 32  # pieces that are read at a time: a system may map 2 MiB of a file about each


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of a record; the last may be short. Arrays have shape (b,)."""

    x: NDArray[Any]  # the record, shape (n,), as stored
    bits: NDArray[Any]  # the same memory as integers
    size: int  # samples of a block
    # lo, hi, mean: of the finite samples; NaN where there is none
    lo: Array
    hi: Array
    mean: Array
    rough: Array  # half the mean square of the step to the next sample: variance of white noise, blind to drift
    same: NDArray[np.int32]  # samples that equal the one before them, inside the block
    count: NDArray[np.int32]  # finite samples

    def __len__(self) -> int:
        """Return the number of blocks."""
        return len(self.mean)

    def without(self, skip: Indices) -> Blocks:
        """Return the blocks with some samples, ascending, left out."""
        if not len(skip):
            return self
        which = np.unique(skip // self.size)
        mean, rough, same, count = self.mean.copy(), self.rough.copy(), self.same.copy(), self.count.copy()
        lo, hi = np.zeros((2, len(self)), dtype=self.bits.dtype)
        flip = _flip(self.x.dtype, self.bits.dtype)
        for first, stop in batches(self.x, whole=self.size):
            own = slice(first // self.size, -(-stop // self.size))
            some = which[slice(*np.searchsorted(which, (own.start, own.stop)))] - own.start
            left = skip[slice(*np.searchsorted(skip, (first, stop)))] - first
            if len(some):
                outs: tuple[Any, ...] = tuple(one[own] for one in (lo, hi, mean, rough, same, count))
                part = slice(first, stop)
                loops_for(len(self.x)).fill_patched(self.x[part], self.bits[part], self.size, flip, some, left, *outs)
        lowest, highest = self.lo.copy(), self.hi.copy()
        for every, part in ((lowest, lo), (highest, hi)):
            every[which] = np.where(count[which] == 0, np.nan, _values(part[which], self.x.dtype))
        return Blocks(self.x, self.bits, self.size, lowest, highest, mean, rough, same, count)

    def beside(self, places: Indices) -> Blocks:
        """Return the blocks with those that lie inside places [first, last] (k, 2) emptied."""
        inside = np.zeros(len(self), dtype=bool)
        for first, last in places.tolist():
            inside[-(-first // self.size) : (last + 1) // self.size] = True
        lo, hi, mean, rough = (np.where(inside, np.nan, part) for part in (self.lo, self.hi, self.mean, self.rough))
        same, count = (np.where(inside, 0, part).astype(np.int32) for part in (self.same, self.count))
        return Blocks(self.x, self.bits, self.size, lo, hi, mean, rough, same, count)

    def rows(self, which: Indices) -> NDArray[Any]:
        """Return the samples of some blocks, in order."""
        at = (which[:, None] * self.size + np.arange(self.size)).ravel()
        return np.asarray(self.x[at[at < len(self.x)]])


def blocks_of(x: NDArray[Any]) -> Blocks:
    """Return the blocks of a record.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Integers or floats as stored, NaN where a sample is missing; not copied where contiguous.

    Raises
    ------
    DataError
        If the record has another shape, or holds no numbers.
    """
    if np.ndim(x) != 1:
        raise DataError(f"a channel of shape {np.shape(x)}, need (n,)", code="bad_shape")
    if x.dtype.kind not in "iuf" or x.dtype.itemsize > np.dtype(np.float64).itemsize:
        raise DataError(f"a channel of {x.dtype}", do="Give integers or floats", code="bad_shape")
    known = np.dtype(np.float32) if x.dtype == np.float16 else x.dtype.newbyteorder("=")
    x = np.ascontiguousarray(x, dtype=known)
    own_bits, flip, inf = bits_of(known)
    bits, size = x.view(own_bits), size_of(len(x), x.nbytes)
    n = -(-len(x) // size)
    lo, hi = np.empty((2, n), dtype=bits.dtype)
    mean, rough = np.empty((2, n))
    same, count = np.empty((2, n), dtype=np.int32)
    for first, stop in batches(x, whole=size):
        own = slice(first // size, -(-stop // size))
        part = slice(first, stop)
        outs: tuple[Any, ...] = tuple(one[own] for one in (lo, hi, mean, rough, same, count))
        if loops_for(len(x)).fill_blocks(x[part], bits[part], size, flip, inf, *outs):
            odd = np.flatnonzero(count[own] == 0)
            none = np.empty(0, dtype=np.int64)
            loops_for(len(x)).fill_patched(x[part], bits[part], size, flip, odd, none, *outs)
    lowest, highest = _values(lo, x.dtype), _values(hi, x.dtype)
    empty = count == 0
    if empty.any():
        lowest[empty] = highest[empty] = np.nan
    return Blocks(x, bits, size, lowest, highest, mean, rough, same, count)


@cache
def bits_of(kind: np.dtype[np.generic]) -> tuple[np.dtype[np.generic], Whole, Whole]:
    """Return the type of the bits of samples, what they are turned by to be sorted, and those of infinity."""
    bits: Any = np.dtype(f"i{kind.itemsize}") if kind.kind == "f" else kind
    flip = _flip(kind, bits)
    return bits, flip, bits.type(np.array(np.inf, dtype=kind).view(bits).item() if flip else 0)


def size_of(n: int, nbytes: int) -> int:
    """Return the samples of a block of a record."""
    size, most = SMALLEST, max(FREE, int(SHARE * nbytes / EACH))
    while size * most < n:
        size *= 2
    return size


def pieces(x: NDArray[Any], whole: bool = False) -> tuple[Indices, Array]:
    """Return the first samples of pieces of neighbours, evenly spread, (k,), and the pieces, (k, 64 or all).

    What is not finite is NaN there; ``whole``: all are. The pieces, not to be changed, hold all that a short record
    has, but a rest shorter than one.
    """
    length = min(PIECE, len(x))
    most = min(SUBSAMPLE // PIECE, len(x) // max(length, 1))
    if len(x) <= SUBSAMPLE:
        first = np.arange(most, dtype=np.int64) * length
        rows = x[: most * length].astype(np.float64, copy=not whole).reshape(most, length)
    else:
        first = np.linspace(0.0, len(x) - length, most).astype(np.int64)
        rows = np.empty((most, length))
        for own in together(x, most):
            rows[own] = x[first[own, None] + np.arange(length)]
            release(x)
    if not whole and not known_finite(x):
        rows[~np.isfinite(rows)] = np.nan
    return first, rows


def together(x: NDArray[Any], n: int) -> list[slice]:
    """Return groups of n pieces, after each of which what they touch of a stored record is let go."""
    size = TOGETHER if is_stored(x) else max(n, 1)
    return [slice(k, k + size) for k in range(0, n, size)]


def _flip(kind: np.dtype[Any], bits: np.dtype[Any]) -> Any:
    return bits.type(np.iinfo(bits).max if kind.kind == "f" else 0)


def _values(keys: NDArray[Any], kind: np.dtype[Any]) -> Array:
    """Return the numbers that sorted bits stand for."""
    if kind.kind != "f":
        return keys.astype(np.float64)
    flip = _flip(kind, keys.dtype)
    turned = keys ^ ((keys >> (8 * keys.itemsize - 1)) & flip)
    return np.asarray(turned.view(kind), dtype=np.float64)
