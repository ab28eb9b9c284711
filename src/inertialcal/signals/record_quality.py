"""Whether a channel at rest is fit for noise terms: disturbances, motion, and drift beyond slow noise.

*Disturbances* are what the one detector of still and moving stretches takes for such (``stillness``), in the samples
that the screening leaves: noise terms fitted across them are wrong. Motion that never stops looks to that detector
like noise that is not white: nobody can tell it from a filtered output without knowing the sensor.

A record of more than 16,777,216 samples is looked through in pieces of 4,194,304, each by itself: it is at rest if
three quarters of its samples lie in pieces that are.

*Drift* is what slow noise does not explain (``drift``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..core.batches import changed, release
from ..core.errors import DataError
from ..core.estimate import Array
from .drift import Drift, drift_of
from .segmentation.stillness import STILL_SHARE, Disturbance, judge

LONG = 2**24  # samples: a longer record is looked through in pieces ...
PIECE = 2**22  # ... of so many


@dataclass(frozen=True, eq=False)
class RecordQuality:
    """What stands in the way of noise terms."""

    disturbances: tuple[Disturbance, ...]  # in samples of the record, in order
    at_rest: bool  # False where the channel moves, or its level steps, all the time
    drifts: tuple[Drift, ...]  # none where it is too short to be tested
    values: Array  # the record, shape (n,)

    def cleaned(self) -> Array:
        """Return the record with NaN where it is disturbed, shape (n,): itself where nowhere."""
        if not self.disturbances:
            return self.values
        out = changed(self.values, np.array)
        for one in self.disturbances:
            out[one.first : one.last + 1] = np.nan
        return out


def record_quality(x: Array, interval: float, floor: float = 0.0) -> RecordQuality:
    """Look a channel at rest through for what its noise terms should not be fitted to.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Evenly spaced samples of a rate or acceleration, NaN where one is missing or no reading (``screening``).
    interval : float
        From sample to sample [s].
    floor : float
        Smallest standard deviation that the noise may have: the resolution step.

    Raises
    ------
    DataError
        If the record has another shape, or the interval is not positive.
    """
    values = np.asarray(x, dtype=np.float64)
    if values.ndim != 1:
        raise DataError(f"a channel of shape {np.shape(x)}, need (n,)", code="bad_shape")
    if not (np.isfinite(interval) and interval > 0.0):
        raise DataError(f"a sample interval of {interval} s", do="It must be positive", code="bad_interval")
<<<<<<< HEAD
    good = np.isfinite(values)
    whole = bool(good.all())
    rest = judge(values if whole else values[good], floor)
    if rest is None:
        return RecordQuality((), True, drift_of(values, 0, interval), values)
    placed = rest.disturbances
    if placed and not whole:
        rows = np.flatnonzero(good)
        placed = tuple(Disturbance(int(rows[one.first]), int(rows[one.last]), one.peak) for one in placed)
    found = RecordQuality(placed, rest.at_rest, (), values)
    return replace(found, drifts=drift_of(found.cleaned() if placed else values, 0, interval))
=======
    placed: list[Disturbance] = []
    judged = still = 0
    for first in range(0, max(len(values), 1), PIECE if len(values) > LONG else max(len(values), 1)):
        part = values[first : first + PIECE] if len(values) > LONG else values
        rows = first + np.flatnonzero(np.isfinite(part))
        rest = judge(part[rows - first], floor)
        release(part)
        if rest is not None:
            judged, still = judged + len(rows), still + len(rows) * rest.at_rest
            placed += [Disturbance(int(rows[one.first]), int(rows[one.last]), one.peak) for one in rest.disturbances]
    found = RecordQuality(tuple(placed), still >= STILL_SHARE * judged, (), values)
    return replace(found, drifts=drift_of(found.cleaned(), 0, interval))
>>>>>>> 1265b2c6 (squash stream25)
