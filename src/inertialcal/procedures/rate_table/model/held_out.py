"""Dwells held out, and what a model finds from them: as it is, and mixed up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import permutations
from typing import Any

import numpy as np

from ....core.errors import PlanError
from ....core.estimate import Array
from ....core.key import Key
from ....core.remarks import Remark
from ....sensors.model.compensate import compensate
from ....sensors.model.sensor_model import Provenance, SensorModel
from ...model_terms import HeldOut, ModelTerms
from ...protocol import Tested
from ..exclusions import exclusions
from ..fit.earth_input import with_earth
from ..fit.quantities import CURVATURES
from ..plan import Plan
from ..readings import Readings
from ..recordings import together
from ..reduction import Result
from .closed_loop import Find, closed_loop, compensated_curves


def judged_on(model: SensorModel, result: Result, fitted: Sequence[Turned], held: Sequence[Turned]) -> HeldOut:
    """Return what a model does to the dwells of tests held out."""
    readings, find = dwells_held_out(held), partial(compensated_dwells, model)
    remarks = []
    shared = _runs(fitted) & _runs(held)
    if shared:
        what = "readings held out come from runs that the model was fitted on: run-to-run error is not judged"
        remarks.append(Remark("shared_runs", "warning", what, count=len(shared), do="Hold out whole power-up runs"))
    mounting = result.plan.standards.get("rate_table.mounting")
    remounted = any(one.occasion.remounted(other.occasion) for one in fitted for other in held)
    laid = mounting.u if mounting is not None and remounted else 0.0
    return HeldOut(
        closed_loop(result.lines, readings, find, mixed_up(model), laid),
        curves=compensated_curves(result.lines, readings, find),
        remarks=tuple(remarks),
    )


def dwells_held_out(held: Sequence[Turned]) -> Readings:
    """Return the dwells held out, those left out by rule left out here too."""
    parts = []
    for one in held:
        readings = one.readings if one.readings.earth is not None else with_earth(one.plan, one.readings)
        out = [exclusions(one.plan, readings, sensor).any for sensor in readings.outputs]
        parts.append(readings.take(~np.any(out, axis=0)))
    return together(parts)


def _runs(tests: Sequence[Turned]) -> set[Any]:
    """Return what tells power-ups apart: run labels, which hold in the whole campaign, and files."""
    found: set[Any] = set()
    for one in tests:
        labels = [] if one.readings.run is None else [str(run) for run in np.unique(one.readings.run)]
        found |= {("run", label) for label in labels if label} | {("file", path) for path in one.files}
    return found


def mixed_up(model: SensorModel) -> dict[str, Find]:
    """Return what the model would find if it were mixed up, by the name of the mix-up.

    The transposed form keeps its diagonal; "turned" has the errors (M - I) or the bias with the opposite sign;
    with axes exchanged, row and column (or bias) of one axis stand at another.
    """
    matrix, bias, k = model.matrix[0], model.bias, len(model.axes)
    entries = [one.name for one in model.parameters if one.key.quantity in ("misalignment", "scale_factor_error")]
    whole = model.not_estimated.keys().isdisjoint(entries)
    forms = {"the matrix with its sign turned": (2.0 * np.eye(k) - matrix, bias)}
    forms["the bias with its sign turned"] = (matrix, -bias)
    if whole and k > 1:
        forms["the transposed matrix"] = (matrix.T, bias)
    for order in permutations(range(k)):
        if order == tuple(range(k)):
            continue
        places = ", ".join(f"{model.axes[i]} for {model.axes[j]}" for j, i in enumerate(order) if i != j)
        moved, shifted = matrix[np.ix_(order, order)], bias[list(order)]
        forms[f"the bias with {places}"] = (matrix, shifted)
        if whole:  # an entry that was not estimated is no error of the axes
            forms[f"the matrix with {places}"] = (moved, bias)
            forms[f"the model with {places}"] = (moved, shifted)
    return {name: partial(_inverted, model, *terms) for name, terms in forms.items()}


def _inverted(model: SensorModel, matrix: Array, bias: Array, readings: Readings) -> dict[str, Array]:
    """Return the inputs found with another matrix and bias [rad/s], by axis; bias, curve and matrix alone."""
    columns = _columns(model, readings)
    nothing = np.zeros(len(model.axes))
    bend, second, third = (
        nothing if term is None else term
        for term in (model.scale_factor_asymmetry, model.second_order, model.third_order)
    )
    without = np.nan_to_num(columns) - bias
    inverse: Array = np.linalg.inv(matrix).astype(np.float64)
    u = without / (1.0 + 0.5 * bend * np.sign(without))
    for _ in range(CURVE_PASSES if np.any(second) or np.any(third) else 0):
        u = (without - second * u**2 - third * u**3) / (1.0 + 0.5 * bend * np.sign(without))
    x = u @ inverse.T
    return _known(model, x, columns, inverse)


def compensated_dwells(model: SensorModel, readings: Readings) -> dict[str, Array]:
    """Return the inputs that a model finds from the readings of dwells [rad/s], by axis.

    Where a sensor was not read, only axes that do not need it are found; the others are NaN.
    """
    columns = _columns(model, readings)
    return _known(model, compensate(model, np.nan_to_num(columns)), columns, np.linalg.inv(model.matrix[0]))


def _columns(model: SensorModel, readings: Readings) -> Array:
    return np.column_stack([readings.outputs.get(axis, np.full(len(readings), np.nan)) for axis in model.axes])


def _known(model: SensorModel, x: Array, columns: Array, inverse: Array) -> dict[str, Array]:
    """Give inputs by axis, NaN where a sensor that is needed was not read."""
    missing = (~np.isfinite(columns)).astype(float)
    needed = (np.abs(inverse) > 0.0).astype(float)  # row: axis found, column: sensor needed
    found = np.where(missing @ needed.T > 0.0, np.nan, x)
    return {axis: found[:, i] for i, axis in enumerate(model.axes)}


TERM = ("bias", "scale_factor_error", "misalignment", "scale_factor_asymmetry")
NOT_SEEN = "not seen at the rates of the test: taken as 0"
CURVE_PASSES = 8  # of K2 u^2 + K3 u^3, which is small beside u


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
    """Return the terms that a joint reduction gives."""
    axes = tuple([axis for axis in tests[0].facts.axes if axis in result.lines])
    estimate, referenced = result.estimate, result.plan.zero_reference
    curved = tuple([Key(CURVATURES[name], sensor) for sensor, line in result.lines.items() for name in line.curvature])
    keys = () if estimate is None else _parameters(estimate.keys, curved, axes, referenced)
    provenance = {sensor: _provenance(sensor, tests) for sensor in axes}
    missing = [row for row in result.rows() if row.status == "not_estimated" and row.case.plain]
    return ModelTerms(
        estimate,
        keys,
        axes,
        {key: provenance[key.axis[0]] for key in keys},
        _not_seen(axes) | {str(row.key): row.reason.text for row in missing},
        input_range=_input_range(result, axes),
        bias_run_to_run=_run_to_run(result, axes),
        referenced=referenced,
    )


@lru_cache(maxsize=256)  # the same of all units of a lot
def _parameters(
    keys: tuple[Key, ...], curved: tuple[Key, ...], axes: tuple[str, ...], referenced: bool
) -> tuple[Key, ...]:  # fmt: skip
    """Return the keys of an estimate that are parameters of the model."""
    return tuple(
        key
        for key in keys
        if (key.quantity in TERM or key in curved)
        and set(key.axis) <= set(axes)
        and not (key.quantity == "bias" and referenced)
    )


@lru_cache(maxsize=256)
def _not_seen(axes: tuple[str, ...]) -> dict[str, str]:
    return {str(Key(quantity, axis)): NOT_SEEN for quantity in CURVATURES.values() for axis in axes}


def _provenance(sensor: str, tests: Sequence[Turned]) -> Provenance:
    """Return where the terms of a sensor come from: the tests in which it was read."""
    which = [one for one in tests if np.isfinite(one.readings.outputs.get(sensor, np.nan)).any()]
    recordings = tuple(dict.fromkeys(recording for one in which for recording in one.recordings))
    return Provenance(", ".join(one.id for one in which), recordings)


def _input_range(result: Result, axes: tuple[str, ...]) -> Array:
    """Rates that each axis was turned at; an axis that was not turned has no range."""
    return np.array([result.lines[axis].readings.turned.span(axis) for axis in axes])


def _run_to_run(result: Result, axes: tuple[str, ...]) -> Array | None:
    """Scatter of the bias between power-ups, where every axis has one."""
    if result.plan.run_level != "power_up":
        return None
    stds = [level.std for axis in axes for level in result.lines[axis].levels if level.name == "run"]
    return None if any(std is None for std in stds) else np.array(stds, dtype=float)
