"""Long arrays, a batch at a time: what is longer than memory lies in a temporary file that is mapped.

An array of more than ``HELD`` bytes that `empty` gives is a file without a name, mapped into memory: numpy and the
compiled loops read and write it as any other, and it goes when nobody holds it. Pages of it that were touched count as
memory of the process until they are let go, which `batches` does behind each batch. So a pass over an array of any
length takes the memory of one batch.

>>> import numpy as np
>>> x = np.arange(10.0)
>>> [float(x[first:stop].sum()) for first, stop in batches(x, size=4)]
[6.0, 22.0, 17.0]
"""

from __future__ import annotations

import errno
import mmap
import os
import tempfile
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ..errors import DataError

Place = tuple[int, np.dtype[Any], tuple[int, ...], tuple[int, ...]]  # address, type, shape and steps of an array

HELD = 2**26  # bytes of an array that is kept in memory
SIZE = 2**20  # samples of a batch
NEAR = 2**16  # samples of a batch of which other arrays are made on the way: the nearest cache but one holds them
_mapped: dict[int, tuple[int, weakref.ref[mmap.mmap]]] = {}  # address -> bytes, mapping
_files: dict[int, int] = {}  # address -> descriptor of a temporary file


def is_long(size: int) -> bool:
    """Return whether arrays that are read together, of so many bytes in all, are too many to be kept in memory."""
    return size > 2 * HELD


def empty(n: int, dtype: DTypeLike, stored: bool | None = None) -> NDArray[Any]:
    """Return an array to be filled, shape (n,): in memory, or of more than ``HELD`` bytes in a temporary file.

    Parameters
    ----------
    n, dtype
        Of the array.
    stored : bool, optional
        Whether it lies in a temporary file whatever its own size: one of many that are long together.

    Raises
    ------
    DataError
        ``no_room``, if the folder of temporary files has no room for it.
    """
    kind = np.dtype(dtype)
    size = n * kind.itemsize
    if not (size > HELD if stored is None else stored and size) or kind.hasobject:
        return np.empty(n, dtype=kind)
    try:
        with tempfile.TemporaryFile(prefix="inertialcal-") as file:
            if hasattr(os, "posix_fallocate"):  # a full disk shows here, and not as a fault while it is written
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.truncate(size)
            mapping = mmap.mmap(file.fileno(), size)
            written = os.dup(file.fileno())
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
        raise DataError(
            f"needs {size / 2**30:.3g} GiB of room for temporary files",
            where=tempfile.gettempdir(),
            why="the disk is full" if full else str(error.strerror),
            do="Free some, or name another folder: TMPDIR=FOLDER",
            code="no_room",
        ) from None
    found = np.frombuffer(mapping, dtype=kind)
    at = found.ctypes.data

    def forget(_: object) -> None:
        _mapped.pop(at, None)
        os.close(_files.pop(at))

    _mapped[at], _files[at] = (size, weakref.ref(mapping, forget)), written
    return found


def columns(n: int, many: int) -> NDArray[np.float64]:
    """Return room for so many channels, shape (n, many), each in one piece, in memory or stored as `empty` decides."""
    return empty(n * many, np.float64).reshape(many, n).T


def stacked(channels: Sequence[NDArray[Any]]) -> NDArray[np.float64]:
    """Return channels side by side as floats, shape (n, k), each in one piece."""
    out = columns(len(channels[0]), len(channels))
    for k, one in enumerate(channels):
        for first, stop in batches(out[:, k], one):
            out[first:stop, k] = one[first:stop]
    return out


def adopt(x: NDArray[Any]) -> None:
    """Let a memory map of the user count as stored: its pages are let go of behind each batch, its file stays as it is.

    Not one that is private to the process (``mode="c"``): what was written into it would be lost.
    """
    base: Any = x
    while not isinstance(base, np.memmap) and isinstance(base, np.ndarray):
        base = base.base
    mapping = getattr(base, "_mmap", None)
    if mapping is None or base.mode == "c" or is_stored(x):
        return
    while isinstance(base.base, np.memmap):  # a part of the map
        base = base.base
    at = base.ctypes.data // mmap.PAGESIZE * mmap.PAGESIZE
    _mapped[at] = (len(mapping), weakref.ref(mapping, lambda _: _mapped.pop(at, None)))


def is_stored(x: NDArray[Any]) -> bool:
    """Return whether an array, or what it is a part of, lies in a temporary file."""
    return bool(_mapped) and _mapping_of(x) is not None


def is_long_stretch(x: NDArray[Any], size: int) -> bool:
    """Return whether so many samples of an array are looked at a batch at a time: it is stored, they are more."""
    return size > SIZE and is_stored(x)


def batches(*arrays: NDArray[Any], size: int | None = None, whole: int = 1) -> Iterator[tuple[int, int]]:
    """Yield first and stop of each batch of arrays of one length, shape (n, ...); let go of its pages behind it.

    Parameters
    ----------
    *arrays : ndarray, shape (n, ...)
        That are read or written, a batch at a time.
    size : int, optional
        Samples of a batch; ``SIZE`` by default.
    whole : int
        Batches begin at multiples of it: blocks are not cut.
    """
    n = len(arrays[0])
    step = max(whole, (size or SIZE) // whole * whole)
    stored = [one for one in arrays if is_stored(one)]
    for first in range(0, n, step):
        stop = min(first + step, n)
        yield first, stop
        for one in stored:
            release(one[first:stop])


def release(x: NDArray[Any]) -> None:
    """Let go of the memory that a stored array takes; what it holds stays."""
    found = _mapping_of(x) if _mapped and x.size else None
    if found is not None and x.ndim == 2 and x.strides[0] == x.itemsize and not x.flags.f_contiguous:  # of columns
        for column in x.T:
            release(column)
        return
    if found is None or not hasattr(mmap, "MADV_DONTNEED"):
        return
    address, mapping = found
    low, high = np.lib.array_utils.byte_bounds(x)
    first = (low - address) // mmap.PAGESIZE * mmap.PAGESIZE
    mapping.madvise(mmap.MADV_DONTNEED, first, high - address - first)


def put(x: NDArray[Any], first: int, values: NDArray[Any]) -> None:
    """Write into an array, shape (n,), from a sample on; a stored one by its file: mapped pages take thrice as long."""
    part = x[first : first + len(values)]
    found = _mapping_of(part) if _mapped and part.size else None
    file = _files.get(found[0]) if found is not None and x.flags.c_contiguous and hasattr(os, "pwrite") else None
    if found is None or file is None:
        part[...] = values
        release(part)
        return
    left = np.ascontiguousarray(values, dtype=x.dtype).view(np.uint8).data
    at = part.ctypes.data - found[0]
    while left.nbytes:
        done = os.pwrite(file, left, at)
        left, at = left[done:], at + done


def _mapping_of(x: NDArray[Any]) -> tuple[int, mmap.mmap] | None:
    at = x.__array_interface__["data"][0]
    for address, (size, known) in _mapped.items():
        mapping = known() if address <= at < address + size else None
        if mapping is not None:
            return address, mapping
    return None


def near() -> int:
    """Return the samples of a batch of which other arrays are made on the way: caches hold them."""
    return min(NEAR, SIZE)


def thinned(x: NDArray[Any], step: int) -> NDArray[Any]:
    """Return every so manieth sample, shape (n / step,), without holding all pages of a stored array at a time."""
    if not is_stored(x):
        return x[::step]
    span = max(step, SIZE // step * step)
    parts = []
    for first in range(0, len(x), span):
        parts.append(x[first : first + span : step].copy())
        release(x[first : first + span])
    return np.concatenate(parts)


def made(n: int, dtype: DTypeLike, part: Callable[[int, int], NDArray[Any]], *read: NDArray[Any]) -> NDArray[Any]:
    """Return an array made batch by batch, shape (n,): ``part`` gives samples first to stop, of the arrays ``read``."""
    out = empty(n, dtype)
    if 0 < n <= near() and not any(is_stored(one) for one in (out, *read)):  # in one piece, as most are
        found = part(0, n)
        if type(found) is np.ndarray and found.base is None and (found.dtype, found.shape) == (out.dtype, out.shape):
            return found
        out[...] = found
        return out
    for first, stop in batches(out, *read, size=near()):
        put(out, first, part(first, stop))
    return out


def changed(x: NDArray[Any], part: Callable[[NDArray[Any]], NDArray[Any]], dtype: DTypeLike = float) -> NDArray[Any]:
    """Return a function of each sample, shape (n,), in memory or stored as `empty` decides."""
    return made(len(x), dtype, lambda first, stop: part(x[first:stop]), x)


def extremes(x: NDArray[Any], infinite: bool = True) -> tuple[float, float]:
    """Return the least and the largest number of an array, shape (n,), NaN left out; NaN where there is no other.

    ``infinite`` says whether infinite ones count.
    """
    known = _unchanged.get()
    key = _place_of(x) if known else None
    if key is not None and (found := known.get(key)) is not None:
        return found
    low = high = np.nan
    whole = True
    if 0 < len(x) <= NEAR and not is_stored(x):
        low, high = float(x.min()), float(x.max())
        if isfinite(low) and isfinite(high):
            if key in known:
                known[key] = low, high
            return low, high
        low = high = np.nan
    for first, stop in batches(x, size=NEAR):
        part = x[first:stop]
        least, largest = float(part.min()), float(part.max())
        if not (np.isfinite(least) and np.isfinite(largest)):  # rare, and takes ten times as long
            whole = False
            part = part if infinite else part[np.isfinite(part)]
            if not len(part):
                continue
            least, largest = float(np.fmin.reduce(part)), float(np.fmax.reduce(part))
        low, high = np.fmin(low, least), np.fmax(high, largest)
    if whole and key in known:
        known[key] = float(low), float(high)
    return float(low), float(high)


@contextmanager
def unchanged(arrays: Iterable[NDArray[Any]]) -> Iterator[None]:
    """Take arrays, shape (n,), for unchanged meanwhile: what `extremes` found of one, all finite, it need not look up.

    >>> x = np.arange(3.0)
    >>> with unchanged([x]):
    ...     extremes(x), extremes(x[:]), extremes(x[1:]), known_finite(x[1:]), known_finite(x[::2])
    ((0.0, 2.0), (0.0, 2.0), (1.0, 2.0), True, False)
    """
    held = list(arrays)  # nothing else comes to lie where they do
    before, none = _unchanged.set({_place_of(one): None for one in held}), _held.set(held)
    try:
        yield
    finally:
        _unchanged.reset(before)
        _held.reset(none)


def keep_unchanged(x: NDArray[Any]) -> None:
    """Take one more array, shape (n,), for unchanged, as long as others are."""
    held, known = _held.get(), _unchanged.get()
    if held is not None and _place_of(x) not in known:
        held.append(x)
        known[_place_of(x)] = None


def known_finite(x: NDArray[Any]) -> bool:
    """Return whether all samples, shape (n,), are known to be finite: x is an unchanged array or neighbours of it."""
    unchanged = _unchanged.get()
    if not unchanged:
        return False
    address, kind, (n, *_), (step, *_) = _place_of(x)
    for (start, own, (many, *_), (by, *_)), found in [*unchanged.items()]:
        if found is not None and own == kind and by == step and by > 0 and (address - start) % by == 0:
            first = (address - start) // by
            if first >= 0 and first + n <= many:
                return True
    return False


_held: ContextVar[list[NDArray[Any]] | None] = ContextVar("held", default=None)
_unchanged: ContextVar[dict[Place, tuple[float, float] | None]] = ContextVar("unchanged", default={})  # noqa: B039 - nothing is put into it


def _place_of(x: NDArray[Any]) -> Place:
    return x.__array_interface__["data"][0], x.dtype, x.shape, x.strides


def mean(x: NDArray[Any]) -> float:
    """Return the mean of an array, shape (n,), as float64."""
    return sum(float(np.sum(x[first:stop], dtype=np.float64)) for first, stop in batches(x)) / len(x)


def every(x: NDArray[Any], holds: Callable[[NDArray[Any]], object]) -> bool:
    """Return whether something holds of all samples; no batch is read behind one of which it does not."""
    return all(bool(holds(x[first:stop])) for first, stop in batches(x, size=near()))


def where(x: NDArray[Any], holds: Callable[[NDArray[Any]], NDArray[np.bool_]]) -> NDArray[np.int64]:
    """Return the samples of which something holds, ascending."""
    found = [first + np.flatnonzero(holds(x[first:stop])) for first, stop in batches(x, size=near())]
    return np.concatenate(found) if found else np.empty(0, dtype=np.int64)


def where_steps(x: NDArray[Any], holds: Callable[[NDArray[Any]], NDArray[np.bool_]]) -> NDArray[np.int64]:
    """Return the samples to which the step from the one before meets a condition, ascending."""
    steps = ((first, np.diff(x[first : stop + 1])) for first, stop in batches(x[:-1], size=near()))
    found = [first + 1 + np.flatnonzero(holds(step)) for first, step in steps]
    return np.concatenate(found) if found else np.empty(0, dtype=np.int64)


def any_step(x: NDArray[Any], holds: Callable[[NDArray[Any]], NDArray[np.bool_]]) -> bool:
    """Return whether any step from one sample to the next meets a condition."""
    return any(bool(np.any(holds(np.diff(x[first : stop + 1])))) for first, stop in batches(x[:-1], size=near()))


def taken(x: NDArray[Any], at: NDArray[np.int64]) -> NDArray[Any]:
    """Return some samples of an array, ``at`` ascending, shape (k,)."""
    if not is_stored(x):
        return np.asarray(x[at])
    out = np.empty(len(at), dtype=x.dtype)
    ends = np.searchsorted(at, np.arange(0, len(x) + SIZE, SIZE))
    for first, (a, b) in zip(
        range(0, len(x), SIZE), zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True), strict=False
    ):
        if b > a:
            out[a:b] = x[at[a:b]]
            release(x[first : first + SIZE])
    return out


def rows_taken(x: NDArray[Any], at: NDArray[np.int64]) -> NDArray[Any]:
    """Return some rows of channels (n, k), ``at`` ascending, shape (m, k)."""
    return np.stack([taken(one, at) for one in x.T], axis=1) if is_stored(x) else np.asarray(x[at])


def counts_before(flags: NDArray[np.bool_], at: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many samples are flagged before each of some places, ``at`` ascending, from 0 to n."""
    out, total = np.empty(len(at), dtype=np.int64), 0
    for first, stop in batches(flags):
        a, b = np.searchsorted(at, (first, stop))
        sums = np.cumsum(flags[first:stop], dtype=np.int64)
        out[a:b] = total + np.where(at[a:b] > first, sums[np.maximum(at[a:b] - first - 1, 0)], 0)
        total += int(sums[-1])
    out[np.searchsorted(at, len(flags)) :] = total
    return out


def zeros(n: int, dtype: DTypeLike) -> NDArray[Any]:
    """Return an array of zeros, shape (n,), in memory or stored as `empty` decides."""
    return np.zeros(n, dtype=dtype) if n * np.dtype(dtype).itemsize <= HELD else empty(n, dtype)  # a new file is zeros


def finite(x: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which samples are finite, shape (n,)."""
    return changed(x, (lambda part: np.ones(len(part), bool)) if known_finite(x) else np.isfinite, bool)


def count(x: NDArray[Any], holds: Callable[[NDArray[Any]], NDArray[np.bool_]]) -> int:
    """Return of how many samples something holds."""
    return sum(int(np.count_nonzero(holds(x[first:stop]))) for first, stop in batches(x, size=near()))


def kept(x: NDArray[Any], flags: NDArray[np.bool_]) -> NDArray[Any]:
    """Return the samples that are flagged, shape (k,); the array itself where all are."""
    many = count(flags, lambda part: part)
    if many == len(x):
        return x
    out, at = empty(many, x.dtype), 0
    for first, stop in batches(x, flags):
        part = x[first:stop][flags[first:stop]]
        out[at : at + len(part)] = part
        release(out[at : at + len(part)])
        at += len(part)
    return out


def masked(x: NDArray[Any], there: NDArray[np.bool_]) -> NDArray[Any]:
    """Return the samples as floats, NaN where they are not there, shape (n,)."""
    return made(len(x), float, lambda first, stop: np.where(there[first:stop], x[first:stop], np.nan), x, there)


def without(flags: NDArray[np.bool_], others: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return what is flagged, and not by the others, shape (n,)."""
    return made(len(flags), bool, lambda first, stop: flags[first:stop] & ~others[first:stop], flags, others)
