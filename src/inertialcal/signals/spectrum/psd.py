"""Spectral density by Welch's method or by several orthogonal tapers, of a record that may have gaps.

The record is cut into equally long segments, laid into the stretches without a missing sample; each segment has its
mean removed. What fits into no segment is counted and remarked. Nothing is interpolated or resampled.

``"welch"``: Hann window, segments overlapping by half. ``"multitaper"``: Slepian tapers, segments side by side, for
short records: a lower variance from one segment, at the price of broader lines.

References
----------
.. [1] P. D. Welch, IEEE Trans. Audio Electroacoustics AU-15 (1967) 70-73.
.. [2] D. J. Thomson, Proc. IEEE 70 (1982) 1055-1096.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft, signal

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.remarks import Remark
from .density import Method, Spectrum
from .stretches import Indices, Stretches, stretches_of
from .tapers import Tapers, correlations, falsified, hann, slepian

SHORTEST = 32  # samples of a segment
PARTS = 8  # of a record, in the length of a segment, by default
LONGEST_TAPER = 2**16  # samples of a segment under several tapers, by default
FALSIFIED = 0.01  # of the power, from which a frequency is left out because the mean was removed
AT_ONCE = 2**22  # samples transformed together: bounds the memory
CONSTANT = 8.0 * np.finfo(float).eps  # variation, relative to the largest value, that is rounding


def psd(
    x: NDArray[Any],
    interval: float,
    method: Method = "welch",
    *,
    segment: int | None = None,
    time_bandwidth: float = 4.0,
    p: float = 0.6827,
) -> Spectrum:
    """Return the one-sided spectral density of a sampled signal, with degrees of freedom and intervals.

    Parameters
    ----------
    x : ndarray, shape (n,) or (n, axes)
        Evenly spaced samples, NaN where one is missing [unit]. Angles or increments are to be made rates first.
    interval : float
        From sample to sample [s].
    method : {"welch", "multitaper"}
        See the module head.
    segment : int, optional
        Samples of each segment. By default an eighth of the record with Welch's method, the longest stretch
        without a gap up to 65,536 samples with several tapers.
    time_bandwidth : float
        Of the Slepian tapers: half their bandwidth times their length; ``2 NW - 1`` of them are used.
    p : float
        Probability of the intervals.

    Returns
    -------
    Spectrum
        Density [unit^2/Hz] of each axis.

    Raises
    ------
    DataError
        ``bad_interval``, ``bad_shape``, ``too_short`` (fewer than 32 samples in a segment), ``gaps`` (no segment
        without a gap).
    PlanError
        If method, segment, time bandwidth or probability are out of range.
    """
    values = _checked(x, interval, method, time_bandwidth, p)
    gaps = stretches_of(values)
    length = _length(len(values), gaps, method, segment)
    tapers = hann(length) if method == "welch" else slepian(length, float(time_bandwidth))
    starts = gaps.starts(length, tapers.step)
    density = _averaged(values, starts, tapers, interval)
    edf, neighbours = correlations(tapers, starts)
    first, stop = falsified(tapers, FALSIFIED), (length + 1) // 2
    used = sum(int(one[-1] - one[0]) + length for one in starts)
    frequency = np.arange(first, stop) / (length * interval)
    return Spectrum(
        frequency, density[first:stop], edf, neighbours, tapers.lobe, tapers.enbw / (length * interval), interval,
        length, sum(len(one) for one in starts), used, gaps.missing, method, p, _remarks(values, gaps, used, length),
    )  # fmt: skip


def _checked(x: NDArray[Any], interval: float, method: str, time_bandwidth: float, p: float) -> Array:
    if method not in {"welch", "multitaper"}:
        raise PlanError(f"method {method!r}", do="There are 'welch' and 'multitaper'")
    if not 1.0 <= time_bandwidth <= 32.0:
        raise PlanError(f"time_bandwidth {time_bandwidth}, need 1 to 32")
    if not 0.0 < p < 1.0:
        raise PlanError(f"probability {p}", do="Need more than 0 and less than 1, such as 0.95")
    if not (np.isfinite(interval) and interval > 0.0):
        raise DataError(f"a sample interval of {interval} s", do="It must be positive", code="bad_interval")
    values = np.asarray(x, dtype=np.float64)
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or not values.shape[1]:
        raise DataError(f"a signal of shape {np.shape(x)}, need (n,) or (n, axes)", code="bad_shape")
    return values


def _length(n: int, gaps: Stretches, method: Method, segment: int | None) -> int:
    """Return the samples of a segment: the one asked for, or a default that fits, and is fast to transform."""
    longest = gaps.longest
    if longest < SHORTEST:
        raise DataError(
            f"{n} samples, at most {longest} in a row without a gap: a spectrum needs {SHORTEST}",
            why=f"{gaps.missing} sample(s) are missing" if gaps.missing else "",
            do="Record longer",
            code="gaps" if n >= SHORTEST else "too_short",
        )
    if segment is None:
        wanted = n // PARTS if method == "welch" else LONGEST_TAPER
        return int(fft.prev_fast_len(max(SHORTEST, min(wanted, longest)), real=True))
    if segment < SHORTEST:
        raise PlanError(f"segments of {segment} samples, need {SHORTEST} or more")
    if segment > longest:
        raise DataError(
            f"segments of {segment} samples, but at most {longest} samples in a row without a gap",
            why="a segment across a gap has no spectrum",
            do=f"Give a segment of {longest} samples or fewer",
            code="gaps" if n >= segment else "too_short",
        )
    return segment


def _averaged(values: Array, starts: list[Indices], tapers: Tapers, interval: float) -> Array:
    """Mean of the powers of all segments under all tapers, shape (n // 2 + 1, axes)."""
    length = tapers.weights.shape[1]
    total = np.zeros((length // 2 + 1, values.shape[1]))
    at_once = max(1, AT_ONCE // length)
    for stretch in starts:
        for group in np.split(stretch, np.arange(at_once, len(stretch), at_once)):
            part = values[group[0] : group[-1] + length]
            for weights in tapers.weights:
                mean = signal.welch(
                    part, 1.0 / interval, window=weights, noverlap=length - tapers.step, detrend="constant", axis=0
                )[1]
                total += len(group) * mean
    return np.asarray(total / (len(tapers.weights) * sum(len(stretch) for stretch in starts)))


def _remarks(values: Array, gaps: Stretches, used: int, length: int) -> tuple[Remark, ...]:
    found = []
    left = len(values) - gaps.missing - used
    if gaps.missing:
        what = f"{gaps.missing} of {len(values)} samples are missing: segments lie between the gaps"
        found.append(Remark("gaps", "info", what, count=max(1, len(gaps.start) - 1)))
    if gaps.missing and left > used:
        what = f"{left} samples between gaps fit into no segment of {length}; {used} are used"
        found.append(Remark("few_segments", "warning", what, do="Give shorter segments"))
    for axis in range(values.shape[1]):
        column = values[np.isfinite(values[:, axis]), axis]
        if np.ptp(column) <= CONSTANT * np.abs(column).max():
            what = f"axis {axis} does not vary: it has no spectrum"
            found.append(Remark("constant", "warning", what, do="Check for a stuck or disconnected channel"))
    return tuple(found)
