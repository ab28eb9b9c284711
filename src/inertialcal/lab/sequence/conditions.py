"""What is awaited and what is enough, judged by the code that cuts recordings in the procedures.

Rest is what `signals.segmentation` finds still, as for positions; a value that is held, a dwell of the reference as for
a rate table, `signals.time.schedule.dwells_by_reference`. The uncertainty of a mean is that of its dwell, with the
effective size of correlated samples.

It is enough when the 95 % interval of every mean is no wider than that of the wanted standard uncertainty, 1.96 times
it to both sides. Few samples whose scatter happens to look small are thus not enough: their interval is wide by
Student's t. Intervals of 1,000 simulated records of white noise that ended so hold the truth in 95 %, with 10, 20 and
40 samples at least. Of slow noise they do not, unless the record is long at least: the correlation, too, is judged from
what was recorded (neighbours correlated by 0.9: 79 % from 20 samples on, 92 % from 200 on).
"""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND, Times
from ...signals.segmentation.dwells import dwell_of
from ...signals.segmentation.segments import detect
from ...signals.time.samples import samples_of
from ...signals.time.schedule import dwells_by_reference
from ...statistics.quantiles import t_upper

LEVEL = 0.025  # beyond each end of an interval
WIDE = 1.959964  # half of a 95 % interval [standard uncertainties]


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

    NaN of too few samples.
    """
    dwell = dwell_of(samples_of(values, time_ns), 0, len(values))
    if dwell is None:
        nothing = np.full(values.shape[1], np.nan)
        return nothing, nothing
    dof = dwell.n_effective - 1.0
    with np.errstate(invalid="ignore", divide="ignore"):
        half = np.where(dof > 0.5, t_upper(LEVEL, np.maximum(dof, 0.5)) * dwell.u, np.inf)
    return dwell.u, half


def known_well(values: Array, time_ns: Times, u: float) -> bool:
    """Return whether the mean of each channel is known as well as is wanted."""
    _, half = uncertainty(values, time_ns)
    return bool(np.all(half <= WIDE * u))
