"""Block means of the quiet part of a recording, around the windows that are its dwells.

Quiet is everything but the time between two windows of different position, where the head was turned. Blocks start anew
at each window and each quiet stretch, so that no block lies half in a window; the remainder at the end of a stretch,
shorter than a block, is left out, and so is an axis where its samples are missing. A window's mean is taken as that of
its blocks here, for its uncertainty alone.

A record of more than 720 blocks is cut to the 720 around its windows: "the record" is then that part. Where windows are
long, ``recordings`` takes longer blocks, so that it still is many times as long as a window.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....core.recording import SECOND, Times
from ..readings import Quiet

MOST = 720  # blocks: time and memory of the noise model grow with their cube and square
AT_ONCE = 16  # blocks that are summed at once, so that a day of samples is not copied
PRESENT = 0.9  # of the samples that a block should have


@dataclass(frozen=True)
class Window:
    """One dwell of a recording: a quiet stretch at one position.

    Parameters
    ----------
    start, stop : int
        On the clock of the recording, half-open [ns].
    angle : float
        Turn of the head from position 0 [rad].
    flip : str
        Which flip it belongs to.
    """

    start: int
    stop: int
    angle: float
    flip: str = "1"


@dataclass(frozen=True)
class Stretch:
    """A quiet stretch [ns], its position [rad], and the window that it is (-1: none)."""

    start: int
    stop: int
    angle: float
    window: int = -1


def stretches(windows: Sequence[Window], first: int, last: int) -> list[Stretch]:
    """Return the quiet stretches of a recording between its ends [ns] in order of time, windows among them."""
    order = sorted(range(len(windows)), key=lambda i: windows[i].start)
    placed = [windows[i] for i in order]
    ends = [(first, placed[0].start, placed[0].angle), (placed[-1].stop, last, placed[-1].angle)]
    between = [(one.stop, two.start, one.angle) for one, two in pairwise(placed) if one.angle == two.angle]
    found = [Stretch(w.start, w.stop, w.angle, i) for i, w in zip(order, placed, strict=True)]
    found += [Stretch(a, b, angle) for a, b, angle in ends + between if b > a]
    return sorted(found, key=lambda one: one.start)


def quiet_of(
    time_ns: Times,
    channels: Mapping[str, NDArray[np.floating]],
    parts: Sequence[Stretch],
    rows: NDArray[np.intp],
    dwells: int,
    length: float,
    name: str = "",
) -> tuple[Quiet, int]:
    """Return the quiet part as block means, and how many blocks lack samples of an axis.

    Parameters
    ----------
    time_ns : ndarray of int64, shape (s,)
        Stamps [ns].
    channels : mapping of str to ndarray, shape (s,)
        Each axis [m/s^2]; may hold NaN.
    parts : sequence of Stretch
        Of ``stretches``.
    rows : ndarray of int, shape (w,)
        Row of each window in the Readings.
    dwells : int
        Rows of the Readings.
    length : float
        Of a block [s]; no longer than the shortest window.
    name : str
        Of the recording.
    """
    step = round(length * SECOND)
    pieces = [np.arange(part.start, part.stop - step + 1, step, dtype=np.int64) for part in parts]
    starts, owners = np.concatenate(pieces), np.repeat(np.arange(len(parts)), [len(one) for one in pieces])
    if len(starts) > MOST:  # a long record: the blocks around its windows, in order of time
        window = np.array([part.window >= 0 for part in parts])[owners]
        inside = starts[window]
        beyond = np.maximum(inside.min() - starts, starts - inside.max())
        keep = np.sort(np.argsort(np.where(window, np.iinfo(np.int64).min, beyond), kind="stable")[:MOST])
        starts, owners = starts[keep], owners[keep]
    means, whole = _means(time_ns, channels, starts, step)
    starts, owners = starts[whole], owners[whole]
    weights, spans = np.zeros((dwells, len(starts))), np.full((dwells, 2), np.nan)
    for at, part in enumerate(parts):
        if part.window >= 0:
            own = owners == at
            weights[rows[part.window], own] = 1.0 / max(int(own.sum()), 1)
            spans[rows[part.window]] = (np.array([part.start, part.stop]) - time_ns[0]) / SECOND
    angle = np.array([parts[int(at)].angle for at in owners])
    middle = (starts - time_ns[0]) / SECOND + 0.5 * length
    values = {axis: one[whole] for axis, one in means.items()}
    lost = np.any([np.isnan(one) for one in means.values()], axis=0)
    return Quiet(middle, length, angle, values, weights, spans, name), int(np.sum(lost))


def _means(
    time_ns: Times, channels: Mapping[str, NDArray[np.floating]], starts: Times, step: int
) -> tuple[dict[str, Array], NDArray[np.bool_]]:
    """Mean of each block and axis, NaN where samples of the axis are missing, and which blocks some axis has."""
    low, high = np.searchsorted(time_ns, starts), np.searchsorted(time_ns, starts + step)
    usual = float(np.median(high - low)) if len(starts) else 0.0
    there = (high > low) & (high - low >= PRESENT * usual)
    whole = np.zeros(len(starts), dtype=bool)
    edges = np.column_stack([low, high]).ravel()
    means = {}
    for axis, samples in channels.items():
        good = np.isfinite(samples)
        sums = _sums(samples if good.all() else np.where(good, samples, 0.0), edges)
        counts = (high - low).astype(float) if good.all() else _sums(good, edges)
        own = there & (counts >= PRESENT * usual)
        means[axis] = np.where(own, sums / np.maximum(counts, 1.0), np.nan)
        whole |= own
    return means, whole


def _sums(values: NDArray[np.generic], edges: NDArray[np.intp]) -> Array:
    """Sum between each pair of edges, in double precision."""
    pairs = edges.reshape(-1, 2)
    sums = np.zeros(len(pairs))
    for at in range(0, len(pairs), AT_ONCE):
        some = pairs[at : at + AT_ONCE]
        first, last = int(some[0, 0]), int(some[:, 1].max())
        piece = np.append(np.asarray(values[first:last], dtype=np.float64), 0.0)
        sums[at : at + AT_ONCE] = np.add.reduceat(piece, some.ravel() - first)[::2]
    return sums
