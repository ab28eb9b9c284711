"""What is awaited and what is enough, judged by the code that cuts recordings in the procedures.

Rest is what `signals.segmentation` finds still, as for positions; a value that is held, a dwell of the reference as for
a rate table, `signals.time.schedule.dwells_by_reference`.

It is enough when the 95 % interval of every mean is no wider than that of the wanted standard uncertainty, 1.96 times
it to both sides. The interval is the widest of three, as noise that is slow is taken for quick when little of it was
recorded:

- that of a dwell, with the effective size of samples whose neighbours are correlated; none before INDEPENDENT samples
  are left when that correlation is as strong as it may well be, SURE times its uncertainty more;
- with the noise of the mean from the slowest COSINES in the record [1]_, and Student's t of as many degrees of freedom;
- for the slowest 1, 2, 4 and 8 of them, the smallest standard uncertainty with which they are likely: a drift
  shows in the first.

References
----------
.. [1] Lazarus, Lewis, Stock and Watson, J. Business and Economic Statistics 36 (2018) 541-559: the long-run variance as
   the mean square of weighted sums with cosines of 1/2, 1, 3/2 ... periods, whose Student's t has as many degrees.
"""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND, Times
from ...signals.segmentation.dwells import Dwell, dwell_of
from ...signals.segmentation.segments import detect
from ...signals.time.samples import Samples, samples_of
from ...signals.time.schedule import dwells_by_reference
from ...statistics.quantiles import chi_square_quantile, t_upper

LEVEL = 0.025  # beyond each end of an interval
WIDE = 1.959964  # half of a 95 % interval [standard uncertainties]
COSINES = 12
LIKELY = {1: 0.8, 2: 0.7, 4: 0.6, 8: 0.5}  # of so many slowest cosines: quantile at which their power is taken to lie
INDEPENDENT, SURE = 20.0, 2.5
SUMS = 600  # of samples side by side, on which cosines are taken


def at_rest(values: Array, time_ns: Times, lasting: float) -> bool:
    """Return whether channels have been still for so long up to the last sample; shape (n, channels), (n,) [ns]."""
    try:
        found = detect(values, time_ns)
    except DataError:  # too few samples, or none
        return False
    if not found.still[-1]:
        return False
    first = int(found.start[-1])
    return bool(time_ns[-1] - time_ns[first] >= lasting * SECOND)


def stays_at_rest(values: Array, time_ns: Times) -> bool:
    """Return whether channels are still throughout; True of too few samples to tell."""
    try:
        found = detect(values, time_ns)
    except DataError:
        return True
    return bool(np.all(found.still))


def held(reference: Array, time_ns: Times, at: float | None, within: float, lasting: float) -> bool:
    """Return whether a reference, (n,), has been held for so long up to the last sample, and at its value."""
    try:
        last = dwells_by_reference(reference, reference, time_ns, tolerance=within, drop_edge=0)[-1]
    except DataError:
        return False
    if last.stop < len(reference) or time_ns[-1] - time_ns[last.start] < lasting * SECOND:
        return False
    return at is None or bool(np.all(np.abs(reference[last.start :] - at) <= within * (1.0 + 1e-9)))


def uncertainty(values: Array, time_ns: Times) -> tuple[Array, Array]:
    """Return standard uncertainty of the mean, and half of its 95 % interval, of each channel, shape (channels,).

    NaN of too few samples; an interval is infinite as long as too few are independent.
    """
    samples = samples_of(values, time_ns) if len(values) > 1 else None
    dwell = None if samples is None else dwell_of(samples, 0, len(values))
    if samples is None or dwell is None:
        nothing = np.full(values.shape[1], np.nan)
        return nothing, nothing
    powers = _cosine_powers(samples, dwell)
    count = len(powers)
    u = np.maximum(dwell.u, np.sqrt(powers[-1] / dwell.n))
    dof = dwell.n_effective - 1.0
    with np.errstate(invalid="ignore", divide="ignore"):
        half = np.where(dof > 0.5, t_upper(LEVEL, np.maximum(dof, 0.5)) * dwell.u, np.inf)
    half = np.maximum(half, t_upper(LEVEL, count) * np.sqrt(powers[-1] / dwell.n))
    for slow, likely in LIKELY.items():
        least = powers[min(slow, count) - 1] * slow / chi_square_quantile(likely, slow)
        half = np.maximum(half, WIDE * np.sqrt(least / dwell.n))
    return u, np.where(_independent(dwell) >= INDEPENDENT, half, np.inf)


def _independent(dwell: Dwell) -> Array:
    """Return how many independent samples there are if neighbours are as correlated as they may be; (channels,)."""
    correlation = (dwell.n - dwell.n_effective) / (dwell.n + dwell.n_effective)
    most = np.minimum(correlation + SURE * np.sqrt((1.0 - correlation**2) / dwell.n), 1.0)
    found: Array = dwell.n * (1.0 - most) / (1.0 + most)
    return found


def _cosine_powers(samples: Samples, dwell: Dwell) -> Array:
    """Return the mean power of the slowest 1, 2, 3 ... cosines in a dwell, that of white noise its variance.

    Shape (cosines, channels).
    """
    part = slice(dwell.start, dwell.stop)
    x = samples.values[part][samples.finite[part] & ~samples.outlier[part]] - dwell.mean
    edges = np.arange(min(len(x), SUMS) + 1) * len(x) // min(len(x), SUMS)
    middle = 0.5 * (edges[:-1] + edges[1:]) / len(x)
    number = np.arange(1, min(COSINES, len(x) - 1) + 1)
    sums = np.add.reduceat(x, edges[:-1], axis=0)
    powers = 2.0 / len(x) * (np.cos(np.pi * np.outer(number, middle)) @ sums) ** 2
    found: Array = np.cumsum(powers, axis=0) / number[:, np.newaxis]
    return found


def known_well(values: Array, time_ns: Times, u: float) -> bool:
    """Return whether the mean of each channel is known as well as is wanted."""
    _, half = uncertainty(values, time_ns)
    return bool(np.all(half <= WIDE * u))
