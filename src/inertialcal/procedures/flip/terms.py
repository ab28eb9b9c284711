"""What a flip gives to the model of a head: the bias of the axes across the turn.

It is the mean over the quiet record, under the conditions of the test. The axis along the turn has none: what it reads
is bias and ambient acceleration together. After a ground model what is left is the error of that model, and no term.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.estimate import Estimate
from ...sensors.model.sensor_model import Provenance
from ..corrections import BiasCorrection, found_by
from ..model_terms import ModelTerms
from ..protocol import Tested
from .separation.equations import BIAS

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result

OLDEST = 5 * 31_557_600.0  # [s] since 1970: no mission lasts so long, so a smaller time is elapsed


def bias_of(result: Result) -> Estimate | None:
    """Return the bias of each axis that has one, SI; None where there is none, or its unit is in doubt."""
    found = result.estimate
    if found is None or result.plan.corrected or any(one.code == "magnitude" for one in result.remarks):
        return None
    keys = [key for key in found.keys if key.quantity == BIAS]
    return found.select(keys) if keys else None


def correction(test: str, result: Result) -> BiasCorrection | None:
    """Return the bias of the axes across the turn, with the temperature and the time of the dwells behind it."""
    found = bias_of(result)
    if found is None:
        return None
    names = tuple(one.name for one in result.readings.quiet)
    return BiasCorrection(test, found, temperatures(result), time_of(result), names)


def temperatures(result: Result) -> dict[str, float]:
    """Return the mean temperature of each axis across the turn over its dwells [degC], where it is known."""
    readings = result.readings
    read = {axis: np.isfinite(readings.outputs[axis]) for axis in result.plan.turned if axis in readings.outputs}
    known = {axis: readings.temperature[axis][own] for axis, own in read.items() if axis in readings.temperature}
    return {axis: float(np.nanmean(one)) for axis, one in known.items() if np.isfinite(one).any()}


def time_of(result: Result) -> float | None:
    """Return the middle of the dwells since 1970 UTC [s]; None where their clock is elapsed time."""
    time = result.readings.time
    middle = math.nan if time is None or not np.isfinite(time).any() else float(np.nanmean(time))
    return middle if middle > OLDEST else None


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the bias of the axes across the turn; None where there is none."""
    found = bias_of(result)
    if found is None:
        return None
    origin = Provenance(", ".join(one.id for one in tests), tuple(name for one in tests for name in one.recordings))
    axes = tuple(key.axis for key in found.keys)
    return ModelTerms(found_by(found, tests[0].id), found.keys, axes, dict.fromkeys(found.keys, origin))
