"""The model of a campaign: made from tests with ``use = "fit"``, judged on those with ``use = "hold_out"``.

All rate-table tests that a term comes from are reduced together, so that what they share (the errors of the
table, the attitude) is shared in the covariance too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import permutations
from typing import Any

import numpy as np

from ..core.errors import PlanError
from ..core.estimate import Array, Component, Estimate
from ..core.key import Key, key_of
from ..core.remarks import Remark
from ..procedures.rate_table import reduction as rate_table
from ..procedures.rate_table.closed_loop import AxisLoop, Find, HeldOut, closed_loop, held_out_errors, overall
from ..procedures.rate_table.recordings import together
from ..procedures.thermal.closed_loop import Left
from ..procedures.thermal.correction import ThermalCorrection
from ..sensors.model.assemble import model_from
from ..sensors.model.compensate import compensate
from ..sensors.model.sensor_model import Item, Provenance, SensorModel
from .chains import body_scale_factors
from .engine import Prepared
from .load import Campaign
from .schema_sensors import Sensor
from .temperature_terms import with_temperature
from .thermal_loop import ThermalLoop, judged_loops

MATRIX = ("scale_factor", "misalignment", "asymmetry")
OVER_TEMPERATURE = "bias_temperature"
BIASES = ("bias", OVER_TEMPERATURE)
TERM = {
    "bias": "bias",
    "scale_factor_error": "scale_factor",
    "misalignment": "misalignment",
    "scale_factor_asymmetry": "asymmetry",
}


@dataclass(frozen=True, eq=False)
class Modelled:
    """A model, the joint reduction behind it, and the closed loop.

    Parameters
    ----------
    model : SensorModel
        ``judged`` where the closed loop PASSes.
    result : rate_table.Result or None
        Joint reduction of all tests of a rate table behind the matrix; None for a model of positions.
    loops : tuple of AxisLoop
        Empty where nothing was held out.
    verdict : str
        ``PASS``, ``FAIL``, ``INCONCLUSIVE``, or ``not run``.
    remarks : tuple of Remark
        Findings.
    errors : tuple of HeldOut
        Of each axis in ``loops``: the dwells behind it, before and after compensation.
    thermal_loops : tuple of ThermalLoop
        Of thermal tests held out.
    unit : str
        Of what the loops judge, SI.
    loop_units : mapping of str to str
        The same by the name of a loop, where one differs.
    others : mapping of str to Modelled
        Models of further sensors, by the name of the sensor.
    """

    model: SensorModel
    result: rate_table.Result | None
    loops: tuple[AxisLoop, ...]
    verdict: str
    remarks: tuple[Remark, ...]
    errors: tuple[HeldOut, ...] = ()
    thermal_loops: tuple[ThermalLoop, ...] = ()
    unit: str = "rad/s"
    loop_units: Mapping[str, str] = field(default_factory=dict[str, str])
    others: Mapping[str, Modelled] = field(default_factory=dict[str, Any])

    @property
    def every(self) -> tuple[Modelled, ...]:
        """The model itself and those of further sensors."""
        return (self, *self.others.values())

    @property
    def whole_verdict(self) -> str:
        """The worst verdict of all models that were judged; ``not run`` where none was."""
        found = {one.verdict for one in self.every if one.loops}
        return next((word for word in ("FAIL", "INCONCLUSIVE", "PASS") if word in found), "not run")


def make_model(
    campaign: Campaign,
    prepared: Sequence[Prepared],
    sensor: Sensor,
    biases: Mapping[str, ThermalCorrection] | None = None,
    left: Mapping[str, tuple[str, tuple[Left, ...]]] | None = None,
) -> Modelled | None:
    """Make and judge the model of one sensor; None where no test is for a fit or nothing could be estimated.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : sequence of Prepared
        Rate-table tests of the sensor.
    sensor : Sensor
        Which.
    biases : mapping of str to ThermalCorrection, optional
        Of thermal tests, by name: what rate-table tests come after.
    left : mapping, optional
        What thermal tests leave on power-ups held out, as ``thermal_loop.left_over`` gives it.

    Raises
    ------
    PlanError
        If tests that belong together differ in their plan.
    DataError
        As ``rate_table.reduce``.
    """
    fitted = [one for one in prepared if one.test.use == "fit"]
    if not fitted:
        return None
    matrix = _chosen(campaign, fitted, MATRIX)
    bias = _chosen(campaign, fitted, ("bias",))
    result = of_bias = joint(matrix)
    estimate = result.estimate
    if {one.test.id for one in bias} != {one.test.id for one in matrix}:
        of_bias = joint(bias) if bias else result
        estimate = _merged(estimate, of_bias.estimate if bias else None)
    if estimate is None:
        return None
    held = [one for one in prepared if one.test.use == "hold_out"]
    law = _taken_off([*matrix, *bias, *held], biases or {})
    tests = {"matrix": matrix, "bias": bias}
    model = whole = _model(campaign, sensor, result, estimate, tests)
    if law is not None and bias:
        axes = tuple(axis for axis in sensor.axes if axis in result.lines)
        whole = _model(campaign, sensor, result, with_temperature(estimate, result, of_bias, law, axes), tests, law)
    if any(one.plan.zero_reference != fitted[0].plan.zero_reference for one in [*fitted, *held]):
        what = "tests of a fit and those held out differ in zero_reference: their biases mean different things"
        raise PlanError(what, do="Give them the same zero_reference", code="plans_differ")
    if not held:
        return Modelled(whole, result, (), "not run", ())
    over_temperature = judged_loops(left or {}, 0.5)
    loops, remarks = _judge(model, result, [*matrix, *bias], held, 0.5 if over_temperature else 1.0)
    errors = held_out_errors(result.lines, held_out(held), partial(compensated_dwells, model))
    verdict = overall((*loops, *(one.loop for one in over_temperature)))
    whole = replace(whole, judged=verdict == "PASS")
    return Modelled(whole, result, loops, verdict, remarks, errors, over_temperature)


def _taken_off(tests: Sequence[Prepared], biases: Mapping[str, ThermalCorrection]) -> ThermalCorrection | None:
    """Return the bias over temperature that was taken off all of these tests; None where none was.

    Raises
    ------
    PlanError
        If it was not the same in all: their biases mean different things.
    """
    names = {"".join(one.test.after) for one in tests}
    if len(names) > 1:
        what = "tests that make one model, or judge it, differ in after: their biases mean different things"
        raise PlanError(what, do="Give them the same after", code="plans_differ")
    return biases.get(names.pop()) if names else None


def _chosen(campaign: Campaign, fitted: Sequence[Prepared], terms: Sequence[str]) -> list[Prepared]:
    named = campaign.file.model.terms
    wanted = {test for term in terms for test in named.get(term, [])}  # type: ignore[call-overload]
    if not any(term in named for term in terms):
        return list(fitted)
    return [one for one in fitted if one.test.id in wanted]


def joint(tests: Sequence[Prepared]) -> rate_table.Result:
    """Reduce several tests as one.

    Raises
    ------
    PlanError
        If their plans differ in more than the axis.
    """
    plans = {repr(replace(one.plan, axis="")) for one in tests}
    if len(plans) > 1:
        names = ", ".join(one.test.id for one in tests)
        what = f"tests {names} make one model, but their plans differ"
        raise PlanError(what, do="Give them the same plan (but for axis), or name the tests of each term in [model]")
    plan = replace(tests[0].plan, axis="")
    return rate_table.reduce(plan, together([one.readings for one in tests]))


def _merged(matrix: Estimate | None, bias: Estimate | None) -> Estimate | None:
    """Matrix entries of one reduction and biases of another, taken as independent."""
    if matrix is None or bias is None:
        return matrix if bias is None else bias
    a = matrix.select([key for key in matrix.keys if key.quantity not in BIASES])
    b = bias.select([key for key in bias.keys if key.quantity in BIASES])
    na, nb = len(a.keys), len(b.keys)
    components = [
        replace(c, covariance=_block(c.covariance, 0, na + nb), dof=_wide(c, na, nb, 0)) for c in a.components
    ]
    components += [
        replace(c, covariance=_block(c.covariance, na, na + nb), dof=_wide(c, nb, na, na)) for c in b.components
    ]
    return Estimate((*a.keys, *b.keys), np.concatenate([a.values, b.values]), (*a.units, *b.units), tuple(components))


def _block(covariance: Array, start: int, size: int) -> Array:
    whole = np.zeros((size, size))
    stop = start + len(covariance)
    whole[start:stop, start:stop] = covariance
    return whole


def _wide(component: Component, own: int, other: int, start: int) -> Array:
    dof = np.full(own + other, np.inf)
    dof[start : start + own] = component.dof
    return dof


def _model(
    campaign: Campaign,
    sensor: Sensor,
    result: rate_table.Result,
    estimate: Estimate,
    tests: Mapping[str, list[Prepared]],
    law: ThermalCorrection | None = None,
) -> SensorModel:
    axes = tuple(axis for axis in sensor.axes if axis in result.lines)
    referenced = all(one.plan.zero_reference for one in tests["bias"])
    keys = [
        key for key in estimate.keys
        if (key.quantity in TERM or key.quantity == OVER_TEMPERATURE)
        and set(key.axis) <= set(axes)
        and not (key.quantity in BIASES and referenced)
    ]  # fmt: skip
    volts = None if sensor.mounting is not None else body_scale_factors(sensor)
    item = campaign.file.item
    return model_from(
        estimate.select(keys),
        sensor.kind,
        axes,
        scale_factor=1.0 if volts is None else np.array([volts[axis] for axis in axes]),
        output_unit=None if volts is None else "V",
        source="" if sensor.mounting is None else f"readings in body axes, after mounting {sensor.mounting}",
        item=Item(item.maker, item.part, item.serial),
        input_range=_input_range(result, axes),
        bias_run_to_run=_run_to_run(result, axes),
        not_estimated=_reasons(result),
        provenance={str(key): _provenance(key, tests, law) for key in keys},
        **({} if law is None else _temperatures(law)),
    )


def _temperatures(law: ThermalCorrection) -> dict[str, Any]:
    """Return the temperatures that the terms of a bias over temperature refer to, and hold for."""
    return {"reference_temperature": law.result.plan.reference_temperature, "temperature_range": law.range}


def _provenance(key: Key, tests: Mapping[str, list[Prepared]], law: ThermalCorrection | None = None) -> Provenance:
    """Return where a term comes from: the tests in which its sensor was read, and the bias that was taken off."""
    if law is not None and key.quantity == OVER_TEMPERATURE:
        return Provenance(law.test, tuple(sweep.name for sweep in law.result.readings.sweeps))
    sensor = key.axis[0]
    family = tests["bias" if key.quantity in BIASES else "matrix"]
    which = [one for one in family if np.isfinite(one.readings.outputs.get(sensor, np.nan)).any()]
    recordings = tuple(dict.fromkeys(r for one in which for r in one.test.recordings))
    if law is not None and key.quantity in BIASES:
        own = tuple(sweep.name for sweep in law.result.readings.sweeps)
        return Provenance(", ".join([law.test, *(one.test.id for one in which)]), (*own, *recordings))
    return Provenance(", ".join(one.test.id for one in which), recordings)


def _reasons(result: rate_table.Result) -> dict[str, str]:
    return {str(row.key): row.reason.text for row in result.rows() if row.status == "not_estimated" and row.case.plain}


def _input_range(result: rate_table.Result, axes: tuple[str, ...]) -> Array:
    """Rates that each axis was turned at; an axis that was not turned has no range."""
    ranges = []
    for axis in axes:
        readings = result.lines[axis].readings
        rates = readings.applied[readings.axis == axis]
        ranges.append((min(rates.min(), 0.0), max(rates.max(), 0.0)) if len(rates) else (0.0, 0.0))
    return np.array(ranges)


def _run_to_run(result: rate_table.Result, axes: tuple[str, ...]) -> Array | None:
    """Scatter of the bias between power-ups, where every axis has one."""
    if result.plan.run_level != "power_up":
        return None
    stds = [level.std for axis in axes for level in result.lines[axis].levels if level.name == "run"]
    return None if any(std is None for std in stds) else np.array(stds, dtype=float)


def _judge(
    model: SensorModel, result: rate_table.Result, fitted: Sequence[Prepared], held: Sequence[Prepared], share: float
) -> tuple[tuple[AxisLoop, ...], tuple[Remark, ...]]:
    readings = held_out(held)
    loops = closed_loop(result.lines, readings, partial(compensated_dwells, model), mixed_up(model), share)
    remarks = []
    shared = _runs(fitted) & _runs(held)
    if shared:
        what = "readings held out come from runs that the model was fitted on: run-to-run error is not judged"
        remarks.append(Remark("shared_runs", "warning", what, count=len(shared), do="Hold out whole power-up runs"))
    return loops, tuple(remarks)


def held_out(held: Sequence[Prepared]) -> rate_table.Readings:
    """Return the dwells held out, those left out by rule left out here too."""
    parts = []
    for one in held:
        readings = one.readings if one.readings.earth is not None else rate_table.with_earth(one.plan, one.readings)
        out = [rate_table.exclusions(one.plan, readings, sensor).any for sensor in readings.outputs]
        parts.append(readings.take(~np.any(out, axis=0)))
    return together(parts)


def _runs(tests: Sequence[Prepared]) -> set[Any]:
    """Return what tells power-ups apart: run labels, which hold in the whole campaign, and files."""
    found: set[Any] = set()
    for one in tests:
        labels = [] if one.readings.run is None else [str(run) for run in np.unique(one.readings.run)]
        found |= {("run", label) for label in labels if label} | {("file", path) for path in one.inputs}
    return found


def mixed_up(model: SensorModel) -> dict[str, Find]:
    """Return what the model would find if it were mixed up, by the name of the mix-up.

    The transposed form keeps its diagonal; "turned" has the errors (M - I) or the bias with the opposite sign;
    with axes exchanged, row and column (or bias) of one axis stand at another.
    """
    matrix, bias, k = model.matrix[0], model.bias, len(model.axes)
    whole = not any(key_of(name).quantity in ("misalignment", "scale_factor_error") for name in model.not_estimated)
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


def _inverted(model: SensorModel, matrix: Array, bias: Array, readings: rate_table.Readings) -> dict[str, Array]:
    """Return the inputs found with another matrix and bias [rad/s], by axis; bias, asymmetry and matrix alone."""
    columns = _columns(model, readings)
    bend = np.zeros(len(model.axes)) if model.scale_factor_asymmetry is None else model.scale_factor_asymmetry
    without = np.nan_to_num(columns) - bias
    inverse: Array = np.linalg.inv(matrix).astype(np.float64)
    x = (without / (1.0 + 0.5 * bend * np.sign(without))) @ inverse.T
    return _known(model, x, columns, inverse)


def compensated_dwells(model: SensorModel, readings: rate_table.Readings) -> dict[str, Array]:
    """Return the inputs that a model finds from the readings of dwells [rad/s], by axis.

    Where a sensor was not read, only axes that do not need it are found; the others are NaN.
    """
    columns = _columns(model, readings)
    return _known(model, compensate(model, np.nan_to_num(columns)), columns, np.linalg.inv(model.matrix[0]))


def _columns(model: SensorModel, readings: rate_table.Readings) -> Array:
    return np.column_stack([readings.outputs.get(axis, np.full(len(readings), np.nan)) for axis in model.axes])


def _known(model: SensorModel, x: Array, columns: Array, inverse: Array) -> dict[str, Array]:
    """Give inputs by axis, NaN where a sensor that is needed was not read."""
    missing = (~np.isfinite(columns)).astype(float)
    needed = (np.abs(inverse) > 0.0).astype(float)  # row: axis found, column: sensor needed
    found = np.where(missing @ needed.T > 0.0, np.nan, x)
    return {axis: found[:, i] for i, axis in enumerate(model.axes)}
