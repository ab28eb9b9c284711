"""Terms of the model of a sensor from a rate table: all tests that a term comes from, reduced together.

So what they share (the errors of the table, the attitude) is shared in the covariance too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ....core.errors import PlanError
from ....core.estimate import Array
from ....core.key import Key
from ....sensors.model.sensor_model import Provenance
from ...model_terms import ModelTerms
from ...protocol import Tested
from ..fit.quantities import taken_off_changes
from ..plan import Plan
from ..readings import Readings
from ..recordings import together
from ..reduction import Result

TERM = ("bias", "scale_factor_error", "misalignment", "scale_factor_asymmetry")

Turned = Tested[Plan, Readings, Any]


def joined(tests: Sequence[Turned]) -> tuple[Plan, Readings]:
    """Return plan and readings of several tests as one.

    Raises
    ------
    PlanError
        If their plans differ in more than the axis.
    """
    plans = {repr(replace(one.plan, axis="")) for one in tests}
    if len(plans) > 1:
        names = ", ".join(one.id for one in tests)
        what = f"tests {names} make one model, but their plans differ"
        raise PlanError(what, do="Give them the same plan (but for axis), or name the tests of each term in [model]")
    return replace(tests[0].plan, axis=""), together([one.readings for one in tests])


def check_alike(tests: Sequence[Turned]) -> None:
    """Refuse tests of one model, or held out, whose biases mean different things.

    Raises
    ------
    PlanError
        ``plans_differ``.
    """
    if len({one.plan.zero_reference for one in tests}) > 1:
        what = "tests of a fit and those held out differ in zero_reference: their biases mean different things"
        raise PlanError(what, do="Give them the same zero_reference", code="plans_differ")


def model_terms(result: Result, tests: Sequence[Turned]) -> ModelTerms:
    """Return the terms that a joint reduction gives.

    Parameters
    ----------
    result : Result
        Joint.
    tests : sequence of Tested
        Reduced in it.
    """
    axes = tuple(axis for axis in tests[0].facts.axes if axis in result.lines)
    estimate, referenced = result.estimate, result.plan.zero_reference
    keys = () if estimate is None else tuple(
        key for key in estimate.keys
        if key.quantity in TERM and set(key.axis) <= set(axes) and not (key.quantity == "bias" and referenced)
    )  # fmt: skip
    taken_off = {source: one for line in result.lines.values() for source, one in line.readings.taken_off.items()}
    return ModelTerms(
        estimate,
        keys,
        axes,
        {key: _provenance(key, tests) for key in keys},
        {str(row.key): row.reason.text for row in result.rows() if row.status == "not_estimated" and row.case.plain},
        input_range=_input_range(result, axes),
        bias_run_to_run=_run_to_run(result, axes),
        referenced=referenced,
        taken_off=taken_off,
        changes={source: taken_off_changes(result.lines, source) for source in taken_off},
    )


def _provenance(key: Key, tests: Sequence[Turned]) -> Provenance:
    """Return where a term comes from: the tests in which its sensor was read."""
    sensor = key.axis[0]
    which = [one for one in tests if np.isfinite(one.readings.outputs.get(sensor, np.nan)).any()]
    recordings = tuple(dict.fromkeys(recording for one in which for recording in one.recordings))
    return Provenance(", ".join(one.id for one in which), recordings)


def _input_range(result: Result, axes: tuple[str, ...]) -> Array:
    """Rates that each axis was turned at; an axis that was not turned has no range."""
    ranges = []
    for axis in axes:
        readings = result.lines[axis].readings
        rates = readings.applied[readings.axis == axis]
        ranges.append((min(rates.min(), 0.0), max(rates.max(), 0.0)) if len(rates) else (0.0, 0.0))
    return np.array(ranges)


def _run_to_run(result: Result, axes: tuple[str, ...]) -> Array | None:
    """Scatter of the bias between power-ups, where every axis has one."""
    if result.plan.run_level != "power_up":
        return None
    stds = [level.std for axis in axes for level in result.lines[axis].levels if level.name == "run"]
    return None if any(std is None for std in stds) else np.array(stds, dtype=float)
