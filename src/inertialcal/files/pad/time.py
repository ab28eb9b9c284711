"""Stamps of an archive file, made anew as time zero + n / sample rate, and what its own stamps say of that.

The file's time is 32 bits wide: 600 s into a file it moves in steps of 61 us, a day into it in steps of 7.8 ms,
which is more than a sample interval. So the stamps are not used one by one. They are looked at for what they can
tell: that they go forward in steps of the header's sample rate, where samples are missing (the count then starts
anew behind the gap), and whether they run away from the count.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array, Numbers
from ...core.recording import SECOND, Times

BLOCK = 2**18  # stamps
STRETCHES = 1000  # over which the median step is taken
RATES_AGREE = 0.01  # relative difference of the two sample rates, as for any other file
JUMP = 0.5  # in intervals, from which a step is no jitter
DRIFT = 0.05  # in intervals, from which stamps run away from the count


@dataclass(frozen=True, eq=False)
class Stamps:
    """Time axis of one file."""

    time_ns: Times  # shape (n,): regenerated [ns since 1970 UTC]
    end: int  # Last of the file's own stamps [ns since 1970 UTC]
    interval: float  # By the file's own stamps, over the longest run without a gap [s]
    uncertain: float  # By how much it may be wrong for the width of the stamps [s]
    deviation: float  # Largest difference of the file's stamps from the regenerated ones [s]
    resolution: float  # Step in which the file's time moves at its end [s]
    drifts: bool  # Whether that is more than its resolution and a twentieth of an interval explain
    jumps: NDArray[np.int64]  # shape (k,): index of the last sample before each gap inside the file


def regenerate(time: Numbers, zero: int, sample_rate: float, where: str) -> Stamps:
    """Return the stamps of a file.

    Parameters
    ----------
    time : ndarray, shape (n,)
        As the file has it [s since ``zero``].
    zero : int
        Time zero of the header [ns since 1970 UTC].
    sample_rate : float
        [Hz].
    where : str
        File, for messages.

    Raises
    ------
    DataError
        ``bad_stamps``, if a stamp is no number or earlier than the one before it.
    """
    if not np.all(np.isfinite(time)):
        first = int(np.argmin(np.isfinite(time)))
        raise bad_stamps(f"record {first + 1}: the time is not a number", where)
    resolution = float(np.spacing(np.float32(np.abs(time).max())))
    jumps = _jumps(time, median_step(time) if len(time) > 1 else 1.0 / sample_rate, resolution, where)
    interval, uncertain = _longest_run(time, jumps, resolution) if len(time) > 1 else (1.0 / sample_rate, 0.0)
    time_ns = np.empty(len(time), dtype=np.int64)
    deviation = 0.0
    for first, last in _runs(len(time), jumps):
        begin = float(time[first])
        for a in range(first, last, BLOCK):
            b = min(a + BLOCK, last)
            since: Array = begin + np.arange(a - first, b - first) / sample_rate
            time_ns[a:b] = zero + np.rint(since * SECOND).astype(np.int64)
            deviation = max(deviation, float(np.abs(time[a:b] - since).max()))
    drifts = deviation > resolution + DRIFT / sample_rate
    end = zero + round(float(time[-1]) * SECOND)
    return Stamps(time_ns, end, interval, uncertain, deviation, resolution, drifts, jumps)


def median_step(time: Numbers) -> float:
    """Return the median over stretches of their mean step [s]: neither gaps nor the width of the floats move it."""
    size = max(1, (len(time) - 1) // STRETCHES)
    ends = time[::size].astype(np.float64)
    return float(np.median(np.diff(ends))) / size


def rates_agree(stamps: Stamps, sample_rate: float) -> bool:
    """Whether the file's own stamps go as fast as the sample rate [Hz], within a hundredth."""
    return abs(stamps.interval - 1.0 / sample_rate) <= RATES_AGREE / sample_rate + stamps.uncertain


def _runs(n: int, jumps: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Begin and end of each run of samples without a gap."""
    ends = [*(int(jump) + 1 for jump in jumps), n]
    yield from zip([0, *ends[:-1]], ends, strict=True)


def _longest_run(time: Numbers, jumps: NDArray[np.int64], resolution: float) -> tuple[float, float]:
    """Mean step over the longest run without a gap, and how far the width of the stamps may move it [s]."""
    first, last = max(_runs(len(time), jumps), key=lambda run: run[1] - run[0])
    steps = last - first - 1
    if not steps:
        return median_step(time), resolution
    return (float(time[last - 1]) - float(time[first])) / steps, resolution / steps


def _jumps(time: Numbers, interval: float, resolution: float, where: str) -> NDArray[np.int64]:
    """Index of the last sample before each step that is longer than jitter and resolution explain."""
    found = []
    for first in range(0, len(time) - 1, BLOCK):
        steps = np.diff(time[first : first + BLOCK + 1].astype(np.float64))
        back = np.flatnonzero(steps < -resolution)
        if len(back):
            what = f"record {first + int(back[0]) + 2}: the time is earlier than in the previous record"
            raise bad_stamps(what, where)
        found.append(first + np.flatnonzero(steps - interval > JUMP * max(interval, 0.0) + resolution))
    return np.concatenate(found).astype(np.int64) if found else np.empty(0, dtype=np.int64)


def bad_stamps(what: str, where: str) -> DataError:
    """Return the error for stamps that are no time."""
    return DataError(what, where=where, do="Fetch both files of the pair again from the archive", code="bad_stamps")
