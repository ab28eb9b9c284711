"""Whether a channel at rest is fit for noise terms: disturbances, motion, and drift beyond slow noise.

*Disturbances* are what the one detector of still and moving stretches takes for such (``stillness``), in the samples
that the screening leaves: noise terms fitted across them are wrong. Motion that never stops looks to that detector
like noise that is not white: nobody can tell it from a filtered output without knowing the sensor.

*Drift* is what slow noise does not explain (``drift``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core.batches import changed
from ..core.errors import DataError
from ..core.estimate import Array
from .drift import Drift, drift_of, drifts_of
from .segmentation.stillness import Disturbance, judge_in_pieces, surely_still
from .threads import LARGE


@dataclass(frozen=True, eq=False)
class RecordQuality:
    """What stands in the way of noise terms."""

    disturbances: tuple[Disturbance, ...]  # in samples of the record, in order
    at_rest: bool  # False where the channel moves, or its level steps, all the time
    drifts: tuple[Drift, ...]  # none where it is too short to be tested
    values: Array  # the record, shape (n,)

    def cleaned(self) -> Array:
        """Return the record with NaN where it is disturbed, shape (n,): itself where nowhere."""
        return _cleaned(self.values, self.disturbances) if self.disturbances else self.values


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
    if floor == 0.0 and len(values) < LARGE and surely_still(values):
        return RecordQuality((), True, drift_of(values, 0, interval), values)
    rest = judge_in_pieces(values, floor)
    placed = () if rest is None else rest.disturbances
    cleaned = _cleaned(values, placed) if placed else values
    return RecordQuality(placed, rest is None or rest.at_rest, drift_of(cleaned, 0, interval), values)


def qualities_alike(series: Sequence[Array], interval: float) -> list[RecordQuality]:
    """Return what `record_quality` finds in each of many channels at rest of one length, shape (n,), in float64."""
    still = [len(x) < LARGE and surely_still(x) for x in series]
    drifts = iter(drifts_of([x for x, none in zip(series, still, strict=True) if none], interval) if any(still) else ())
    return [
        RecordQuality((), True, next(drifts), x) if none else record_quality(x, interval)
        for x, none in zip(series, still, strict=True)
    ]


def _cleaned(values: Array, disturbances: tuple[Disturbance, ...]) -> Array:
    out = changed(values, np.array)
    for one in disturbances:
        out[one.first : one.last + 1] = np.nan
    return out
