"""Terms of the model that a sensitivity test gives, with the conditions that they refer to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...sensors.model.sensitivity import ChannelReference
from ...sensors.model.sensor_model import Provenance
from ..model_terms import ModelTerms, kind_of
from ..protocol import Tested
from .plan import START_TEMPERATURE, TEMPERATURE, Plan

if TYPE_CHECKING:
    from .readings import Readings
    from .reduction import Result


GIVEN = ("sensitivity", "warm_up")


def terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the sensitivities; None where nothing was estimated, or in one power-up alone.

    A term that was not seen is one of the model all the same, as it was estimated: its uncertainty is then that of what
    the model leaves. A stated one has its source.
    """
    readings, estimate = result.readings, result.estimate
    power_ups = max((fit.runs for fit in result.sensors.values()), default=len(readings.power_ups))
    if estimate is None or power_ups < 2:
        return None
    keys = tuple(key for key in estimate.keys if kind_of(key) in GIVEN and key.quantity != START_TEMPERATURE)
    names = tuple(dict.fromkeys(name for one in tests for name in one.recordings))
    test = ", ".join(dict.fromkeys(one.id for one in tests))
    provenance = {
        key: Provenance(test, names, f"stated: {result.by_key[key].source}" if key in result.by_key else "")
        for key in keys
    }
    references = {}
    for name, value in result.references.items():
        levels = np.concatenate([readings.conditions[name][axis] for axis in readings.axes])
        levels = levels[np.isfinite(levels)]
        if name != TEMPERATURE and len(levels):
            span = (float(levels.min()), float(levels.max()))
            references[name] = ChannelReference(value, readings.units[name], span)
    refused = {str(key): str(reason) for fit in result.sensors.values() for key, (_, reason) in
               fit.design.refused.items()}  # fmt: skip
    return ModelTerms(
        estimate, keys, readings.axes, provenance, refused, reference_temperature=result.plan.reference_temperature,
        temperature_range=_range(readings), references=references,
    )  # fmt: skip


def _range(readings: Readings) -> tuple[float, float] | None:
    if TEMPERATURE not in readings.conditions:
        return None
    levels = np.concatenate([readings.conditions[TEMPERATURE][axis] for axis in readings.axes])
    levels = levels[np.isfinite(levels)]
    return (float(levels.min()), float(levels.max())) if len(levels) else None
