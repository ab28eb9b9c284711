"""What a test of noise gives to the model of a sensor: its noise terms.

There is no bias in them: nothing says how the sensor lay, so that earth rate, or gravity, is in the mean as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..model_terms import ModelTerms
from ..protocol import Tested

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the noise terms that were found, of axes that nothing speaks against; the others with their reasons.

    None where the kind of the sensor is not known, or no axis has terms.
    """
    if result.plan.kind is None or result.estimate is None:
        return None
    doubts = {one.axis: one.doubt for one in result.axes}
    kept = [key for key in result.estimate.keys if not doubts[key.axis]]
    reasons = {
        str(row.key): row.reason.text
        for row in result.rows()
        if row.case.plain and row.key not in kept and row.key.at is None
    }
    if not kept:
        return None
    axes = tuple(dict.fromkeys(key.axis for key in kept))
    return ModelTerms(None, (), axes, {}, reasons, noise=result.estimate.select(kept))
