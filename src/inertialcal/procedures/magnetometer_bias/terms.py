"""What a test against a magnetometer gives to the model of a gyro: its bias, in orbit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...core.key import AXES, Key
from ...sensors.model.sensor_model import Provenance
from ..model_terms import ModelTerms
from ..protocol import Tested
from .reduction import BIAS

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms:
    """Return the bias of the three axes with its covariance."""
    keys = tuple(Key(BIAS, axis) for axis in AXES)
    names = tuple(one.name for one in result.readings.tracks)
    provenance = Provenance(", ".join(one.id for one in tests), names)
    return ModelTerms(result.estimate.select(keys), keys, AXES, dict.fromkeys(keys, provenance))
