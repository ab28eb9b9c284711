"""What a flip gives to the model of a head: the bias of the axes across the turn.

It is the mean over the quiet record, under the conditions of the test. The axis along the turn has none: what it reads
is bias and ambient acceleration together. After a ground model what is left is the error of that model, and no term.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...core.estimate import Estimate
from ...sensors.model.sensor_model import Provenance
from ..corrections import found_by
from ..model_terms import ModelTerms
from ..protocol import Tested
from .separation.equations import BIAS

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result


def bias_of(result: Result) -> Estimate | None:
    """Return the bias of each axis that has one, SI; None where there is none, or its unit is in doubt."""
    found = result.estimate
    if found is None or result.plan.corrected or any(one.code == "magnitude" for one in result.remarks):
        return None
    keys = [key for key in found.keys if key.quantity == BIAS]
    return found.select(keys) if keys else None


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the bias of the axes across the turn; None where there is none."""
    found = bias_of(result)
    if found is None:
        return None
    origin = Provenance(", ".join(one.id for one in tests), tuple(name for one in tests for name in one.recordings))
    axes = tuple(key.axis for key in found.keys)
    return ModelTerms(found_by(found, tests[0].id), found.keys, axes, dict.fromkeys(found.keys, origin))
