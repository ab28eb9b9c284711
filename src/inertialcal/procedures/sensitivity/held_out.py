"""What the terms of a sensitivity test leave of power-ups that it has not seen, and tests that are reduced together.

Each power-up has an intercept of its own, so that no run-to-run bias is counted. What is compared is the reading with
the published terms taken off and as it is; the others (temperature, applied input) are taken off both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...statistics.closed_loop import AxisLoop
from ..model_terms import HeldOut
from ..protocol import Tested
from .design import design_of, within
from .plan import Plan
from .readings import Readings
from .warm_up import power_ups_of, warm_up_loops

if TYPE_CHECKING:
    from .fit import SensorFit
    from .reduction import Result


def joined(tests: Sequence[Tested[Plan, Readings, Result]]) -> tuple[Plan, Readings] | None:
    """Return the plan and the readings of several tests together; None for one.

    Raises
    ------
    PlanError
        ``plans_differ`` if they are not asked for the same.
    """
    first, *others = tests
    differ = [one for one in others if one.plan != first.plan]
    if not others or (len(differ) == len(others) == 1 and not {*first.plan.to} & {*differ[0].plan.to}):
        return None
    if differ:
        what = f"tests {first.id} and {differ[0].id} find sensitivities of one sensor with different settings"
        do = 'Give them the same plan, name the terms of each under [model] terms, or use = "report_only"'
        raise PlanError(what, do=do, code="plans_differ")
    from .readings import readings_from  # noqa: PLC0415 - not needed for one test

    recordings = [one for test in tests for one in test.readings.recorded]
    return first.plan, readings_from(first.plan, recordings, first.readings.unit)


Tests = Sequence[Tested[Plan, Readings, "Result"]]


def held_out(result: Result, fitted: Tests, held: Tests) -> HeldOut:
    """Return what the terms leave of power-ups held out, each set against the tests of the same conditions.

    Parameters
    ----------
    result : Result
        Of the tests that were fitted together.
    fitted, held : sequence of Tested
        Behind the model, and held out.
    """
    loops: list[AxisLoop] = []
    for to in dict.fromkeys(tuple(one.plan.to) for one in held):
        unseen = [one for one in held if tuple(one.plan.to) == to]
        own = result if tuple(result.plan.to) == to else _result_of([one for one in fitted if tuple(one.plan.to) == to])
        if own is not None:
            found = _loops(own, unseen)
            what = " and ".join(to).replace("_", "-")
            loops += [replace(one, axis=f"{one.axis}, {what}") for one in found]
    return HeldOut(tuple(loops))


def _result_of(tests: Tests) -> Result | None:
    """Return the result of tests of one plan; None where there is none."""
    from .reduction import reduce  # noqa: PLC0415 - it knows this module

    if not tests:
        return None
    made = joined(tests)
    return tests[0].result if made is None else reduce(*made)


def _loops(result: Result, held: Tests) -> list[AxisLoop]:
    """Return how much the terms reduce the mean square of levels about the mean of their power-up, axis by axis."""
    loops = []
    for axis, fit in result.sensors.items():
        parts = [part for one in held if (part := _compared(result, one.readings, axis, fit)) is not None]
        if not parts or fit.own is None:
            continue
        raw, left, own, runs = (np.concatenate(some) for some in zip(*parts, strict=True))
        gain = raw**2 - left**2
        labels = np.unique(runs)
        by_run = gain
        if len(labels) > 1:  # each as a part of its own mean square: on a table all is larger than at rest
            parts_of = np.array([gain[runs == one].mean() / np.mean(raw[runs == one] ** 2) for one in labels])
            by_run = parts_of * float(np.mean(raw**2))
        count = len(by_run)
        u = float(np.std(by_run, ddof=1) / np.sqrt(count)) if count > 1 else float("nan")
        before, after = (float(np.sqrt(np.mean(one**2))) for one in (raw, left))
        loops.append(
            AxisLoop(axis, len(raw), len(labels), before, after, float(by_run.mean()), u, count - 1.0,
                     float(own.mean()), result.readings.unit)
        )  # fmt: skip
    if result.warm_up is not None and not loops:
        return list(warm_up_loops(result.warm_up, [power_ups_of(one.plan, one.readings) for one in held]))
    return loops


def _compared(
    result: Result, readings: Readings, axis: str, fit: SensorFit
) -> tuple[Array, Array, Array, np.ndarray[tuple[int], np.dtype[np.str_]]] | None:
    """Return levels as read and with the terms taken off, the variance of the terms, and the power-ups."""
    if axis not in readings.axes or fit.own is None:
        return None
    plan = replace(result.plan, stated={})
    try:
        design = design_of(plan, readings, axis, result.references, like=fit.design)
    except DataError:
        return None  # no level has all conditions
    values = {one.key or one.name: value for one, value in
              zip(fit.columns, fit.own.coefficients[1:], strict=True)}  # fmt: skip
    values |= {one.key: one.value for one in fit.stated}
    published = {*fit.keys, *(one.key for one in fit.stated)}
    terms, others = np.zeros(len(design.readings)), np.zeros(len(design.readings))
    for one in design.columns:
        size = values.get(one.key or one.name, 0.0) * one.values
        if one.key in published:
            terms = terms + size
        else:
            others = others + size
    raw = within(design.readings - others, design.runs)
    own = [one for one in design.columns if one.key in fit.keys]
    columns = within(np.column_stack([one.values for one in own]), design.runs) if own else np.zeros((len(raw), 0))
    names = [one.key for one in fit.columns]
    at = [1 + names.index(one.key) for one in own]
    variance = np.einsum("ij,jk,ik->i", columns, fit.own.covariance[np.ix_(at, at)], columns)
    return raw, raw - within(terms, design.runs), variance, design.runs
