"""What a shifted ground model gives: all terms of the ground model, with the new bias; and how later flips judge it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...sensors.model.sensor_model import Provenance
from ...sensors.model.terms import values
from ...statistics.closed_loop import AxisLoop
from ..model_terms import HeldOut, ModelTerms
from ..protocol import Tested
from .curves import predictions
from .later import Predicted, predicted
from .model import BIAS, OVER, UNIT
from .remarks import told

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms:
    """Return all terms of the new model."""
    model, ground = result.model(), result.readings.ground
    assert model.estimate is not None  # noqa: S101 - new models have one
    origin = Provenance(", ".join(one.id for one in tests), tuple(name for one in tests for name in one.recordings))
    shifted = [key for key in model.estimate.keys if key.quantity in (BIAS, OVER) and key.axis in result.shifts]
    old = {key: ground.provenance.get(str(key), Provenance(source=ground.source)) for key in model.estimate.keys}
    numbers = dict(
        zip([one.name for one in model.parameters], values(model.parameters, model.terms).tolist(), strict=True)
    )
    same = np.ptp(model.scale_factor) == 0.0
    return ModelTerms(
        model.estimate,
        model.estimate.keys,
        model.axes,
        old | dict.fromkeys(shifted, origin),
        dict(model.not_estimated),
        {name: value for name, value in numbers.items() if name not in model.estimate.names},
        float(model.scale_factor[0]) if same else model.scale_factor,
        model.output_unit,
        model.input_range,
        model.bias_run_to_run,
        reference_temperature=None if model.reference_temperature is None else float(model.reference_temperature[0]),
        temperature_range=model.temperature_range,
        noise=model.noise,
    )


def held_out(result: Result, held: Sequence[Tested[Any, Any, Any]]) -> HeldOut | None:
    """Return what the flips of later tests say of the new model against the ground model, axis by axis.

    The model is that which is delivered, for its own date. A flight that is off the ground model by e0 and off the new
    one by e1 = e0 - s gains ``e0^2 - e1^2 = 2 s e0 - s^2``; its uncertainty is that of flips and launch, ``2 s u(e0)``.
    """
    flights: list[Predicted] = []
    for test in held:
        flights += predicted(result, test.readings, at_date=False)
    loops = []
    for axis in dict.fromkeys(one.axis for one in flights):
        own = [one for one in flights if one.axis == axis]
        old = np.array([one.measured - one.ground for one in own])
        new = np.array([one.error for one in own])
        moved = np.array([one.predicted - one.ground for one in own])
        spread = np.array([math.hypot(one.u_flips, one.launch) for one in own])
        u = float(np.sqrt(np.sum((2.0 * moved * spread) ** 2))) / len(own)
        known = [one.u**2 - one.u_flips**2 - one.launch**2 for one in own if math.isfinite(one.u)]
        loops.append(AxisLoop(
            axis, len(own), len({one.flight for one in own}), float(np.sqrt(np.mean(old**2))),
            float(np.sqrt(np.mean(new**2))), float(np.mean(old**2 - new**2)), u, min(one.dof for one in own),
            max(float(np.mean(known)), 0.0) if known else 0.0, UNIT,
        ))  # fmt: skip
    at_own_date = [one for test in held for one in predicted(result, test.readings)]
    return HeldOut(tuple(loops), (), predictions(at_own_date), tuple(told(at_own_date))) if loops else None
