"""Ground model shifted by flips: the bias of a flight to come over temperature, with its covariance.

The new bias is that of the ground model and the shift, ``K0 + M s``, with ``s`` that of ``fit``. Coefficients of the
ground model and the shift are correlated: what the ground model is off at the temperatures of the flips, the shift
takes back. New covariance ``(I - E A G) C_g (I - E A G)^T + E A V A^T E^T``: G the ground bias at the flips by its
coefficients, A the weights of the flips, E what a shift adds to the coefficients. So at those temperatures the new
model is as good as the flips; away from them it is worse by what the ground model does not know of the difference, and
by what the shift may change with temperature.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996: the ground model moved by the bias that flips find.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.estimate import Array, Component, Estimate, joined_dof
from ...core.influence import Influence, influence_of, standard_of, unknown_of
from ...core.key import Key, Origin
from ...core.recording import SECOND
from ...sensors.model.assemble import with_parameters
from ...sensors.model.equation import inverted
from ...sensors.model.sensor_model import SensorModel
from ...sensors.model.terms import values as values_of
from .fit import Fit
from .plan import SCALE, ZERO, Plan
from .readings import Flip, ground_bias

if TYPE_CHECKING:
    from .reduction import Result

BIAS, OVER = "bias", "bias_temperature"
SHIFT, DRIFT, SLOPE = "bias_shift", "bias_drift", "bias_shift_slope"
UNIT = "m/s^2"
SCATTER = "scatter of flights"


@dataclass(frozen=True, eq=False)
class AxisShift:
    """Of one axis."""

    axis: str
    flips: tuple[Flip, ...]
    ground: Array  # shape (N,): bias of the ground model at the flips [m/s^2]
    fit: Fit
    names: tuple[str, ...]  # Of the coefficients: SHIFT, and DRIFT, SLOPE where they are
    time: int  # t_0 [ns]
    temperature: float  # T_0 [degC]
    no_slope: str  # Why there is none; empty where there is
    line: tuple[float, float, float] | None  # Drift with u and dof, also where the model has none [m/s^2/s]

    def row(self, time: int, temperature: float) -> Array:
        """Return the row of the design at a date and a temperature, shape (p,)."""
        at = {SHIFT: 1.0, DRIFT: (time - self.time) / SECOND, SLOPE: temperature - self.temperature}
        return np.array([at[name] for name in self.names])

    def launch(self, time: int, temperature: float) -> float:
        """Return the uncertainty that its launch adds to a flight to come at a date and a temperature."""
        return math.sqrt(self.fit.launch(self.row(time, temperature)))


def free_of(one: AxisShift) -> float:
    """Return the degrees of freedom of a shift: flights left over, else those of its flips."""
    return one.fit.dof or min(flip.dof for flip in one.flips)


def shifts_of(result: Result) -> Estimate:
    """Return the estimate of all shifts at the date of the new model: level, drift, slope of each axis, SI."""
    units = {SHIFT: UNIT, DRIFT: f"{UNIT}/s", SLOPE: f"{UNIT}/degC"}
    keys: list[Key] = []
    values, of_axis, blocks, acting = [], [], [], {}
    for axis, one in result.shifts.items():
        rows = np.eye(len(one.names))
        rows[0] = one.row(result.date, one.temperature)
        weights, covariance = one.fit.predicted(rows)
        blocks.append(covariance)
        acting[axis] = np.vstack([np.zeros((len(keys), len(one.flips))), weights])
        keys += [Key(name, axis) for name in one.names]
        values += (weights @ one.fit.shift).tolist()
        of_axis += [one] * len(one.names)
    k = len(keys)
    covariance, start = np.zeros((k, k)), 0
    for block in blocks:
        covariance[start : start + len(block), start : start + len(block)] = block
        start += len(block)
    dof = np.array([free_of(one) for one in of_axis])
    components = [Component(Origin(SCATTER, level="run"), "A", covariance, dof, "t")]
    components += _of_standards(result, acting)
    return Estimate(tuple(keys), np.array(values), tuple(units[key.quantity] for key in keys), tuple(components))


def _of_standards(result: Result, acting: Mapping[str, Array]) -> list[Component]:
    """Return what all flips share.

    ``acting``: of each axis, by how much each of its flips moves the figures, shape (up to k, N).
    """
    k = max(len(one) for one in acting.values())
    flips = {axis: [_shared_by(result.plan, flip) for flip in one.flips] for axis, one in result.shifts.items()}
    names = dict.fromkeys(name for own in flips.values() for each in own for name in each)
    by_influence: dict[str, list[str]] = {}
    for name in names:
        by_influence.setdefault(influence_of(name), []).append(name)
    found = []
    for influence, unknowns in by_influence.items():
        changes = np.zeros((len(unknowns), k))
        for axis, weights in acting.items():
            each = np.array([[own.get(name, 0.0) for own in flips[axis]] for name in unknowns])
            changes[:, : len(weights)] += each @ weights.T
        standard = result.plan.standards.get(influence, Influence(1.0, standard=standard_of(influence)[0],
                                                                  quantity=standard_of(influence)[1]))  # fmt: skip
        stated = standard.stated if influence in result.plan.standards else None
        own_names = tuple(unknown_of(influence, name) for name in unknowns)
        found.append(Component(standard.origin(influence), "B", changes.T @ changes, standard.dof,
                               standard.distribution, stated, changes, own_names))  # fmt: skip
    return found


def _shared_by(plan: Plan, flip: Flip) -> Mapping[str, float]:
    """Return what one standard uncertainty of each unknown that all flips share changes the bias of a flip by."""
    if flip.shared:
        return flip.shared
    sizes = {ZERO: 1.0, SCALE: flip.bias}
    stated = {name: one.u for name, one in plan.standards.items() if name in sizes and one.u}
    return {f"{name}[{flip.axis}]": u * sizes[name] for name, u in stated.items()}


def shifted(result: Result, date: int) -> SensorModel:
    """Return the ground model with the bias of a flight to come at a date [ns], with its covariance."""
    ground, plan = result.readings.ground, result.plan
    reference = 0.0 if ground.reference_temperature is None else float(ground.reference_temperature[0])
    wide = any(SLOPE in one.names for one in result.shifts.values()) or plan.shift_slope > 0.0
    base = ground if not wide or ground.bias_temperature is not None else replace(
        ground, bias_temperature=np.zeros((1, len(ground.axes))), estimate=None,
        reference_temperature=np.full(len(ground.axes), reference))  # fmt: skip
    every = {one.key: one for one in base.parameters}
    # Two numbers a shifted axis: at the reference temperature, and a degree; what they add to the coefficients: E
    held = () if ground.estimate is None else ground.estimate.keys
    moved = [key for key in every if key.quantity == BIAS or (wide and key.quantity == OVER and key.power == 1)]
    # Terms in temperature without an uncertainty stand there as known, so that the model has all their powers
    keys = [key for key in every if key in held or (key in moved and key.axis in result.shifts) or key.power]
    at = {key: i for i, key in enumerate(keys)}
    add = np.zeros((len(keys), 2 * len(result.shifts)))
    matrix = np.eye(len(ground.axes)) if plan.bias_of == "sensor" else ground.matrix[0]
    for j, axis in enumerate(result.shifts):
        for i, other in enumerate(ground.axes):
            for power in range(2):
                key = Key(BIAS, other) if not power else Key(OVER, other, power=1)
                if key in at:
                    add[at[key], 2 * j + power] = matrix[i, ground.axes.index(axis)]
    values = np.array(values_of([every[key] for key in keys], base.terms))
    taken = np.zeros((2 * len(result.shifts), len(keys)))  # A G
    scatter = np.zeros((2 * len(result.shifts),) * 2)
    shift = np.zeros(2 * len(result.shifts))
    dof = np.full(2 * len(result.shifts), np.inf)
    tilt, acting = np.zeros((len(result.shifts), 2 * len(result.shifts))), {}
    for j, (axis, one) in enumerate(result.shifts.items()):
        rows = np.zeros((2, len(one.names)))
        rows[0] = one.row(date, reference)
        if SLOPE in one.names:
            rows[1, one.names.index(SLOPE)] = 1.0
        else:
            tilt[j, 2 * j : 2 * j + 2] = plan.shift_slope * np.array([reference - one.temperature, 1.0])
        weights, covariance = one.fit.predicted(rows)
        own = slice(2 * j, 2 * j + 2)
        shift[own], scatter[own, own], dof[own] = weights @ one.fit.shift, covariance, free_of(one)
        acting[axis] = add[:, own] @ weights
        taken[own] = weights @ _by_coefficient(result, one, keys)
    change = np.eye(len(keys)) - add @ taken
    components = [] if ground.estimate is None else [
        _carried(part, ground.estimate, keys, change) for part in ground.estimate.components
    ]  # fmt: skip
    components.append(_spread_over(Origin(SCATTER, level="run"), add @ scatter @ add.T, add, dof))
    if plan.shift_slope > 0.0 and np.any(tilt):
        turned, size = tilt @ add.T, (plan.shift_slope, f"{UNIT}/degC")
        source = Origin("change of the shift with temperature")
        components.append(
            Component(source, "B", turned.T @ turned, np.inf, "normal", size, turned, tuple(result.shifts))
        )
    components += _of_standards(result, acting)
    estimate = Estimate(tuple(keys), values + add @ shift, tuple(every[key].unit for key in keys), tuple(components))
    found = with_parameters(base, dict(zip([every[key] for key in keys], estimate.values.tolist(), strict=True)))
    scatter_of = {axis: one.fit.tau for axis, one in result.shifts.items()}
    before = np.zeros(len(ground.axes)) if ground.bias_run_to_run is None else ground.bias_run_to_run
    to_run = np.array([scatter_of.get(axis, float(old)) for axis, old in zip(ground.axes, before, strict=True)])
    missing = {name: why for name, why in ground.not_estimated.items() if name not in {str(key) for key in keys}}
    return replace(found, estimate=estimate, bias_run_to_run=to_run, not_estimated=missing, judged=False)


def _by_coefficient(result: Result, one: AxisShift, keys: Sequence[Key]) -> Array:
    """Return the ground bias at the flips of an axis by each coefficient, shape (N, m)."""
    ground = result.readings.ground
    reference = 0.0 if ground.reference_temperature is None else float(ground.reference_temperature[0])
    away = np.array([flip.temperature for flip in one.flips]) - reference
    back = np.eye(len(ground.axes))
    if result.plan.bias_of == "head":
        back = inverted(ground.matrix[:1])[0]
    found = np.zeros((len(away), len(keys)))
    for i, key in enumerate(keys):
        if key.quantity in (BIAS, OVER):
            found[:, i] = back[ground.axes.index(one.axis), ground.axes.index(key.axis)] * away**key.power
    return found


def _carried(part: Component, ground: Estimate, keys: Sequence[Key], change: Array) -> Component:
    """Return a source of uncertainty of the ground model as it acts on the new one."""
    place = [keys.index(key) for key in ground.keys]
    own = change[:, place]
    free = np.broadcast_to(np.asarray(part.dof, dtype=float), len(place))
    acts = np.abs(own) > 0.0
    dof = np.array([float(free[row].min()) if row.any() else math.inf for row in acts])
    covariance = own @ part.covariance @ own.T
    changes = None if part.changes is None else part.changes @ own.T
    return replace(part, covariance=0.5 * (covariance + covariance.T), dof=dof, changes=changes)


def _spread_over(origin: Origin, covariance: Array, add: Array, dof: Array) -> Component:
    acts = np.abs(add) > 0.0
    free = np.array([float(dof[row].min()) if row.any() else math.inf for row in acts])
    return Component(origin, "A", 0.5 * (covariance + covariance.T), free, "t")


def bias_at(model: SensorModel, result: Result, axis: str, temperatures: Array) -> tuple[float, float, float]:
    """Return the mean bias of an axis of a new model at temperatures, its uncertainty and degrees of freedom.

    That of a flight to come, without its own launch.
    """
    assert model.estimate is not None  # noqa: S101 - new models have one
    keys = list(model.estimate.keys)
    own = replace(result.shifts[axis], flips=tuple(
        replace(result.shifts[axis].flips[0], temperature=float(T)) for T in temperatures))  # fmt: skip
    row = _by_coefficient(result, own, keys).mean(axis=0)
    variances = [np.array([row @ part.covariance @ row]) for part in model.estimate.components]
    parts = [
        (variance, float(np.min(np.broadcast_to(np.asarray(part.dof, dtype=float), len(keys))[np.abs(row) > 0.0])))
        for variance, part in zip(variances, model.estimate.components, strict=True)
    ]
    value = float(ground_bias(model, np.asarray(temperatures), result.plan.bias_of)[:, model.axes.index(axis)].mean())
    total = float(sum(one[0] for one in variances))
    dof = float(joined_dof([one for one, _ in parts], [free for _, free in parts])[0])
    return value, math.sqrt(max(total, 0.0)), dof
