"""Block means of the quiet part of a recording, beside the windows that are its dwells.

Quiet is all that the user names so; else everything but what lies between two windows of different position, where the
head was turned. Blocks start anew at each window and each quiet stretch, so that no block lies half in a window; what
is left at the end of a stretch is shorter than a block and left out, and so is an axis where its samples are missing. A
window's mean is taken as that of its blocks here: this matters to its uncertainty alone.

A record of more than 720 blocks is cut to the 720 about its windows: "the record" is then that part. Where windows are
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


def stretches(
    windows: Sequence[Window], first: int, last: int, quiet: Sequence[tuple[int, int]] | None
) -> list[Stretch]:
    """Return the quiet stretches of a recording in order of time, windows among them.

    Parameters
    ----------
    windows : sequence of Window
        Of the recording.
    first, last : int
        Ends of the recording [ns].
    quiet : sequence of (int, int), optional
        What is quiet, where the user says so [ns]; windows always are.
    """
    order = sorted(range(len(windows)), key=lambda i: windows[i].start)
    placed = [windows[i] for i in order]
    ends = [(first, placed[0].start, placed[0].angle), (placed[-1].stop, last, placed[-1].angle)]
    between = [(one.stop, two.start, one.angle) for one, two in pairwise(placed) if one.angle == two.angle]
    free = ends + between
    if quiet is not None:
        cut = [(max(a, c), min(b, d), angle) for a, b, angle in free for c, d in quiet]
        free = cut
    found = [Stretch(w.start, w.stop, w.angle, i) for i, w in zip(order, placed, strict=True)]
    found += [Stretch(a, b, angle) for a, b, angle in free if b > a]
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
    """Return the quiet part as block means, and how many blocks an axis was left out of, its samples missing.

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
    starts, owners = _nearest(*_starts(parts, step))
    means, whole = _means(time_ns, channels, starts, step)
    starts, owners = starts[whole], owners[whole]
    weights, spans = np.zeros((dwells, len(starts))), np.full((dwells, 2), np.nan)
    for at, part in enumerate(parts):
        if part.window >= 0:
            own = owners == at
            weights[rows[part.window], own] = 1.0 / max(int(own.sum()), 1)
            spans[rows[part.window]] = (np.array([part.start, part.stop]) - time_ns[0]) / SECOND
    angle = np.array([parts[at].angle for at in owners])
    middle = (starts - time_ns[0]) / SECOND + 0.5 * length
    values = {axis: one[whole] for axis, one in means.items()}
    lost = np.any([np.isnan(one) for one in means.values()], axis=0)
    return Quiet(middle, length, angle, values, weights, spans, name), int(np.sum(lost))


def _starts(parts: Sequence[Stretch], step: int) -> tuple[Times, NDArray[np.intp], NDArray[np.bool_]]:
    """Start of each block [ns], the stretch it lies in, and whether that is a window."""
    found = [np.arange(part.start, part.stop - step + 1, step, dtype=np.int64) for part in parts]
    owner = np.repeat(np.arange(len(parts)), [len(one) for one in found])
    window = np.array([part.window >= 0 for part in parts])[owner]
    return np.concatenate(found), owner, window


def _nearest(starts: Times, owners: NDArray[np.intp], window: NDArray[np.bool_]) -> tuple[Times, NDArray[np.intp]]:
    """Cut a long record to the blocks about its windows, in order of time."""
    if len(starts) <= MOST:
        return starts, owners
    inside = starts[window]
    beyond = np.maximum(inside.min() - starts, starts - inside.max())
    keep = np.sort(np.argsort(np.where(window, np.iinfo(np.int64).min, beyond), kind="stable")[:MOST])
    return starts[keep], owners[keep]


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
    if not len(pairs):
        return np.zeros(0)
    first, last = int(pairs[0, 0]), int(pairs[:, 1].max())
    piece = np.append(np.asarray(values[first:last], dtype=np.float64), 0.0)
    return np.asarray(np.add.reduceat(piece, edges - first)[::2], dtype=np.float64)
