"""What a moved mass gives to the model of an accelerometer: its scale factor, relative to that of its chain.

It holds for inputs as small as the mass applies. A constant that was taken off before does not follow the mass: nothing
of its uncertainty is in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.key import Key
from ...sensors.model.sensor_model import Provenance
from ..model_terms import ModelTerms
from ..protocol import Tested
from .joining import ERROR

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the scale factor error; None where it was not estimated, or no scale factor is stated to relate it to."""
    key, nominal = Key(ERROR, result.plan.axis), result.plan.nominal
    if result.estimate is None or not nominal:
        return None
    applied = max(one.applied for one in result.responses if one.moved)
    origin = Provenance(", ".join(one.id for one in tests), tuple(name for one in tests for name in one.recordings))
    return ModelTerms(
        result.estimate.select([key]),
        (key,),
        (result.plan.axis,),
        {key: origin},
        scale_factor=nominal,
        output_unit="count/s",
        input_range=np.array([(-applied, applied)]),
    )
