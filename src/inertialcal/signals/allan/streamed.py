"""Overlapping deviations of a record of any length, a part of it at a time.

The sums are those of ``deviations``, over every starting point: nothing is decimated, so a record has one figure,
however it is held. Starting points are taken in blocks. Of each, the integrated signal is summed anew, from 0 on and as
far as windows up to ``NEAR`` samples reach: no figure hangs on how far the sum has run, and no digit is lost to it. Of
longer windows the two or three points of a term lie far apart; there each is a stream of its own through the record,
with the sum that lies between it and the first kept apart. Averaging times that double share streams, so that of k of
them the record is read k + 2 times. What tells the noise type stands at some thousand points a time, known beforehand.

Memory is that of some blocks, whatever the record's length.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import release
from ...core.estimate import Array, Numbers
from . import _kernels as kernels
from . import _kernels_streamed as streams
from .deviations import Kind, Variances, terms_of
from .gaps import COMPLETE
from .noise_type import identified_at, places
from .prefix import level_of, summed_as

LONG = 2**24  # samples: of a longer record the integrated signal is not held whole
BLOCK = 2**21  # starting points of a block
NEAR = 2**19  # samples: longest window whose terms lie in one part


def is_streamed(x: Numbers, quantity: str, kind: Kind) -> bool:
    """Return whether a record is so long that its deviations are summed part by part."""
    return len(x) > LONG and kind.overlapping and not kind.modified and not kind.total and quantity != "angle"


def streamed_variances(
    x: Numbers, kind: Kind, factors: NDArray[np.int64], block: int = 0, near: int = 0
) -> tuple[Variances, Array] | None:
    """Return variances at rising averaging factors, and the exponent that averages tell at each; None with gaps.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples of a rate, or of what each adds, whole numbers or floats.
    kind : Kind
        Overlapping, not modified.
    factors : ndarray of int, shape (k,)
        Averaging times in samples, rising, each small enough for a term.
    block, near : int, optional
        Starting points of a block, and the longest window whose terms lie in one part; ``BLOCK`` and ``NEAR`` by
        default. The figures do not hang on them.
    """
    block, near = block or BLOCK, near or NEAR
    kind_of_sum, level, points, order = summed_as(x), level_of(x), len(x) + 1, kind.order
    release(x)
    close = factors[factors <= near]
    far = factors[len(close) :]
    sums = np.zeros(len(factors))
    offsets = np.unique(np.concatenate([[0], *([i * m for i in range(1, order + 1)] for m in far)])).astype(np.int64)
    wanted = np.unique(np.concatenate([offsets, *(places(points, m).ravel() for m in factors.tolist())]))
    known = np.empty(len(wanted), dtype=kind_of_sum)
    reach = order * int(close[-1]) if len(close) else 0
    total = kind_of_sum(0)
    for start in range(0, points, block):
        stop = min(start + block, points)
        part = x[start : stop + reach]
        phase = np.empty(len(part) + 1, dtype=kind_of_sum)
        kernels.integrate(part, level, phase)
        release(part)
        if not np.isfinite(phase[-1]):
            return None
        streams.add_near(phase, stop - start, close, order, sums[: len(close)])
        here = slice(*np.searchsorted(wanted, (start, stop)))
        known[here] = total + phase[wanted[here] - start]
        if stop < points:
            total = total + phase[stop - start]
    if len(far):
        _add_far(x, level, offsets, known[np.searchsorted(wanted, offsets)], far, order, block, sums[len(close) :])
    power = np.array([identified_at(wanted, known, points, m, -kind.reddest // 2) for m in factors.tolist()])
    terms, size = terms_of(kind, points, factors), factors.astype(np.float64) ** 2
    ones, ends = np.ones(len(factors)), np.full(len(factors), COMPLETE)
    return Variances(sums / (kind.divisor * terms * size), terms, ones, ends), power


def _add_far(
    x: Numbers,
    level: Any,
    offsets: NDArray[np.int64],
    before: NDArray[Any],
    factors: NDArray[np.int64],
    order: int,
    block: int,
    sums: Array,
) -> None:
    """Add terms of long windows: ``before`` is the integrated signal at each offset."""
    points, before = len(x) + 1, before.copy()
    phases = {int(one): np.empty(block + 1, dtype=before.dtype) for one in offsets}
    index = {int(one): k for k, one in enumerate(offsets)}
    for start in range(0, points - order * int(factors[0]), block):
        for offset in offsets.tolist():
            part = x[start + offset : start + offset + block]
            if len(part) or start + offset < points:
                kernels.integrate(part, level, phases[offset][: len(part) + 1])
                release(part)
        for i, m in enumerate(factors.tolist()):
            many = min(block, points - order * m - start)
            if many <= 0:
                break
            own = [phases[j * m][:many] for j in range(order + 1)]
            a, b, c, *e = (before[index[j * m]] for j in range(order + 1))
            if order == 2:
                sums[i] += streams.far_seconds(own[0], own[1], own[2], a - 2 * b + c)
            else:
                sums[i] += streams.far_thirds(own[0], own[1], own[2], own[3], e[0] - a + 3 * (b - c))
        for k, offset in enumerate(offsets.tolist()):
            if start + offset + block < points:
                before[k] = before[k] + phases[offset][block]
