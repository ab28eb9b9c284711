"""Columns of the fit: which terms of the sensor equation a test asks for, and which of them its levels can carry.

For one sensor, level i of power-up r, with d the condition less its reference and h = T - T_ref [1]_::

    y_i - u_i = b_r + sum_k c_k h^k + sum_V (d_V d + d_VT d h) + (s_0 + s_1 h + sum_V s_V d) u_i + (cross term) + error

u is the applied input along the sensor; terms with u are there where it was recorded. Only what changes within a
power-up tells a term, as each has an intercept of its own.

References
----------
.. [1] IEEE Std 1431-2004, 8.3: model equation of a Coriolis vibratory gyro with environmental sensitivities.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.key import AXES, Key, Reason
from ...core.remarks import Remark
from ...core.units import divide, multiply, parse_quantity, power
from ...physics.earth import earth_rate_along
from .plan import APPLIED, SUPPLY, TEMPERATURE, WARM_UP, Plan
from .readings import ALIKE, RANGES, Readings

MOST_POWERS = 3  # of the temperature, where nobody said
STILL = 0.01  # of a range, inside power-ups, that tells nothing
TOGETHER, APART = 0.98, 0.9  # squared multiple correlation: told apart by nothing; badly
TOLD = 1e-4  # share of a column that no other makes up, below which its coefficient is not told
NEAR = 3.0  # ratio of a condition to its reference that is a wrong unit
TO_DO = {
    "missing_condition": "Record it with the readings",
    "not_varied": "Step it while the unit stays powered",
    "between_power_ups": "Step it while the unit stays powered",
    "conditions_together": "Change one while the other stays",
}
SUPPLIES = (0.5, 500.0)  # of any sensor [V]


@dataclass(frozen=True, eq=False)
class Column:
    """One term: its key, None for what is fitted and not published; unit of the coefficient; values, shape (n,)."""

    key: Key | None
    name: str
    unit: str
    values: Array
    condition: str = ""  # Whose term it is
    scale: bool = False  # Of the scale factor
    warm: bool = False  # With a power of the temperature
    slope: Array | None = None  # shape (n,): change of the column with its condition


@dataclass(frozen=True, eq=False)
class Design:
    """Columns of one sensor, the levels that they are of, and what cannot be estimated, with the reason."""

    axis: str
    chosen: NDArray[np.bool_]  # (n,): levels that have all conditions
    readings: Array  # (m,): less the applied input
    runs: NDArray[np.str_]  # (m,)
    columns: tuple[Column, ...]
    refused: Mapping[Key, tuple[str, Reason]] = field(default_factory=dict[Key, tuple[str, Reason]])
    order: int = 0
    remarks: tuple[Remark, ...] = ()


def references_of(plan: Plan, readings: Readings) -> dict[str, float]:
    """Return the reference of each condition [SI]: as stated, the temperature's, else the middle of its levels.

    Raises
    ------
    DataError
        ``impossible_value`` where the levels of a condition are so far from what was stated that their unit is wrong.
    """
    found: dict[str, float] = {}
    for name in (one for one in (*plan.to, TEMPERATURE) if one in readings.conditions):
        levels = np.concatenate([readings.conditions[name][axis] for axis in readings.axes])
        levels = levels[np.isfinite(levels)]
        if not len(levels):
            continue
        middle = 0.5 * (float(levels.min()) + float(levels.max()))
        found[name] = plan.reference_temperature if name == TEMPERATURE else _round(middle, float(np.ptp(levels)))
        if name in plan.references:
            found[name] = _stated_reference(name, plan.references[name], readings.units[name])
            ratio = abs(middle / found[name]) if found[name] and name != TEMPERATURE else 1.0
            if not 1.0 / NEAR <= ratio <= NEAR:
                raise _wrong_unit(name, middle, readings.units[name], f"{plan.references[name]} is its reference")
        elif name == SUPPLY and not SUPPLIES[0] <= abs(middle) <= SUPPLIES[1]:
            raise _wrong_unit(name, middle, "V", "no supply of a sensor")
    return found


def _stated_reference(name: str, said: str, unit: str) -> float:
    """Return a reference in the unit of its channel."""
    try:
        return parse_quantity(said).to(unit)
    except DataError as error:
        (problem,) = error.problems
        what = f"reference of {name} = {said!r}: {problem.what}"
        raise PlanError(what, why=problem.why, do=problem.do, code=problem.code) from None


def _round(middle: float, span: float) -> float:
    """Return a number near the middle of a range with no more digits than the range needs."""
    if not span > 0.0:
        return middle
    digits = -math.floor(math.log10(span))
    return round(middle, digits)


def _wrong_unit(name: str, middle: float, unit: str, why: str) -> DataError:
    like = next(
        (one for one, size in (("V", 1e3), ("mV", 1e-3)) if SUPPLIES[0] <= size * abs(middle) <= SUPPLIES[1]), ""
    )
    like = like if unit == "V" and like else "UNIT"
    like += " (mV where the header says uV)" if like == "V" else ""
    do = f"State the unit of its column: --unit {name}={like}, or the reference: --reference {name}=VALUE"
    return DataError(f"{name}: levels about {middle:.4g} {unit}", why=why, do=do, code="impossible_value")


def term_keys(plan: Plan, axis: str, name: str, order: int = 1, *, applied: bool = False) -> list[Key]:
    """Return the keys of the terms that are asked for of a condition and a sensor."""
    if name == TEMPERATURE:
        keys = [Key(f"bias_{name}", axis, power=j) for j in range(1, max(order, 1) + 1)]
        return keys + ([Key(f"scale_factor_error_{name}", axis, power=1)] if applied else [])
    keys = [Key(f"bias_{name}", axis)]
    keys += [Key(f"bias_{name}_{TEMPERATURE}", axis)] if plan.interactions else []
    return keys + ([Key(f"scale_factor_error_{name}", axis)] if applied else [])


def design_of(
    plan: Plan, readings: Readings, axis: str, references: Mapping[str, float], like: Design | None = None
) -> Design:
    """Return the columns of one sensor that its levels carry; those of another design where one is given."""
    wanted = [name for name in plan.to if name in readings.conditions and name not in (TEMPERATURE, WARM_UP)]
    own = {name: by_axis[axis] for name, by_axis in readings.conditions.items()}
    chosen = np.isfinite(readings.values[axis])
    for name in wanted:
        chosen &= np.isfinite(own[name])
    warm = own.get(TEMPERATURE)
    if warm is not None and TEMPERATURE in plan.to:
        chosen &= np.isfinite(warm)
    # While another axis is turned, this one reads parts of the earth's rate that change with the angle
    own_levels = chosen & np.isin(readings.turned, ["", axis])
    across_fitted = like is not None and any(one.key is None and one.condition == APPLIED for one in like.columns)
    if not across_fitted and (own_levels.any() or like is not None):
        chosen = own_levels
    if not chosen.any():
        what = f"{axis}: no level has all of {', '.join(plan.to)}"
        raise DataError(what, do="Record all conditions together", code="missing_condition")
    warm = None if warm is None or not np.all(np.isfinite(warm[chosen])) else warm[chosen]
    runs = readings.run[chosen]
    along, across = _applied(readings, axis, own.get(APPLIED), chosen, _earth(plan))
    y = readings.values[axis][chosen] - along
    moving = {name: own[name][chosen] - references[name] for name in wanted}
    order = _order(plan, warm, runs) if like is None else like.order
    refused, remarks = _refused(plan, readings, axis, moving, warm, runs, order, applied=bool(along.any()))
    h = np.zeros(len(runs)) if warm is None else warm - plan.reference_temperature
    columns = [_warm_column(plan, readings, axis, j, h) for j in range(1, order + 1)]
    changes = order > 0
    columns += _drift(plan, readings, chosen)
    for name, d in moving.items():
        columns += _columns_of(plan, readings, axis, name, d, h, changes=changes)
    columns += _of_scale(plan, readings, axis, along, across, moving, h, changes=changes)
    if like is not None:
        fitted = {one.name for one in like.columns}
        return Design(axis, chosen, y, runs, tuple(one for one in columns if one.name in fitted), refused, order)
    there = {one.key for one in columns} | set(refused)
    for name in (*moving, *(one for one in (TEMPERATURE,) if one in plan.to)):
        for key in term_keys(plan, axis, name, applied=bool(along.any())):
            if key not in there:
                what = "the temperature stays within power-ups" if warm is not None else _without(own, chosen, readings)
                refused[key] = (_unit_of(readings, key, name), Reason("not_varied", what))
    kept = _told_apart(columns, runs, refused, axis)
    return Design(axis, chosen, y, runs, tuple(kept), refused, order, tuple(remarks))


def _without(own: Mapping[str, Array], chosen: NDArray[np.bool_], readings: Readings) -> str:
    """Say that the temperature is not known, and of which power-ups where it is known of others."""
    known = np.isfinite(own[TEMPERATURE]) if TEMPERATURE in own else np.zeros(len(readings), dtype=bool)
    lacking = [run for run in readings.power_ups if np.any(chosen & ~known & (readings.run == run))]
    some = np.any(chosen & known)
    return f"no temperature was recorded in power-up {', '.join(lacking)}" if some else "no temperature was recorded"


def _applied(
    readings: Readings, axis: str, applied: Array | None, chosen: NDArray[np.bool_], earth: float
) -> tuple[Array, Array]:
    """Return the applied input along the sensor and along each other axis, shapes (m,), (m, 3)."""
    n = int(np.count_nonzero(chosen))
    across = np.zeros((n, len(AXES)))
    if applied is None:
        return np.zeros(n), across
    given = np.nan_to_num(applied[chosen]) + earth
    turned = readings.turned[chosen]
    for k, other in enumerate(AXES):
        across[:, k] = np.where(turned == other, given, 0.0)
    along = across[:, AXES.index(axis)].copy()
    across[:, AXES.index(axis)] = 0.0
    return along, across


def _earth(plan: Plan) -> float:
    """Return the earth rate along a turned axis; 0 where the attitude is not known."""
    if plan.attitude is None or plan.latitude is None:
        return 0.0
    azimuth = 0.5 * np.pi if plan.attitude.azimuth is None else plan.attitude.azimuth
    return float(earth_rate_along(plan.latitude, plan.attitude.tilt, azimuth))


def within(values: Array, runs: NDArray[np.str_]) -> Array:
    """Return values less the mean of their power-up, shape (n,) or (n, k)."""
    numbers = np.unique(runs, return_inverse=True)[1]
    columns = values if values.ndim > 1 else values[:, None]
    counts = np.bincount(numbers)
    means = np.column_stack([np.bincount(numbers, column) / counts for column in columns.T])
    made = columns - means[numbers]
    return made if values.ndim > 1 else made[:, 0]


def _spread(values: Array, runs: NDArray[np.str_]) -> float:
    return float(np.ptp(within(values, runs))) if len(values) else 0.0


def _order(plan: Plan, warm: Array | None, runs: NDArray[np.str_]) -> int:
    """Return how many powers of the temperature the levels of the power-ups carry, no more than asked for."""
    if warm is None:
        return 0
    whole = float(np.ptp(warm))
    if whole < RANGES[TEMPERATURE] or _spread(warm, runs) < STILL * whole:
        return 0
    distinct = len(np.unique(np.round((warm - warm.min()) / (2.0 * ALIKE * whole))))
    return min(distinct - 1, MOST_POWERS if plan.order is None else plan.order)


def _drift(plan: Plan, readings: Readings, chosen: NDArray[np.bool_]) -> list[Column]:
    """Return powers of the time since power-up, the same in all of them.

    Raises
    ------
    DataError
        ``no_time``.
    """
    time = readings.time[chosen]
    if plan.drift and not np.all(np.isfinite(time)):
        raise DataError("drift: recordings without time", do="Give the sample rate", code="no_time")
    span = float(np.ptp(time)) or 1.0
    return [Column(None, f"t^{j}", readings.unit, (time / span) ** j) for j in range(1, plan.drift + 1)]


def _warm_column(plan: Plan, readings: Readings, axis: str, j: int, h: Array) -> Column:
    key = Key(f"bias_{TEMPERATURE}", axis, power=j) if TEMPERATURE in plan.to else None
    unit = divide(readings.unit, power("degC", j))
    return Column(key, f"T^{j}", unit, h**j, TEMPERATURE, warm=True, slope=j * h ** (j - 1))


def _columns_of(
    plan: Plan, readings: Readings, axis: str, name: str, d: Array, h: Array, *, changes: bool
) -> list[Column]:
    unit = divide(readings.unit, readings.units[name])
    found = [Column(Key(f"bias_{name}", axis), name, unit, d, name, slope=np.ones(len(d)))]
    if plan.interactions and changes:
        key = Key(f"bias_{name}_{TEMPERATURE}", axis)
        found.append(Column(key, f"{name} x T", divide(unit, "degC"), d * h, name, warm=True, slope=h))
    return found


def _of_scale(
    plan: Plan, readings: Readings, axis: str, along: Array, across: Array, moving: Mapping[str, Array], h: Array,
    *, changes: bool,
) -> list[Column]:  # fmt: skip
    found = [Column(None, f"input {other}", "1", across[:, k], APPLIED)
             for k, other in enumerate(AXES) if across[:, k].any()]  # fmt: skip
    if not along.any():
        return found
    found.append(Column(Key("scale_factor_error", axis), "input", "1", along, APPLIED, scale=True))
    if changes:
        key = Key(f"scale_factor_error_{TEMPERATURE}", axis, power=1) if TEMPERATURE in plan.to else None
        found.append(Column(key, "input x T", divide("1", "degC"), along * h, TEMPERATURE, scale=True, warm=True))
    for name, d in moving.items():
        unit = divide("1", readings.units[name])
        key = Key(f"scale_factor_error_{name}", axis)
        found.append(Column(key, f"input x {name}", unit, along * d, name, scale=True, slope=along))
    return found


def _refused(
    plan: Plan, readings: Readings, axis: str, moving: Mapping[str, Array], warm: Array | None, runs: NDArray[np.str_],
    order: int, *, applied: bool,
) -> tuple[dict[Key, tuple[str, Reason]], list[Remark]]:  # fmt: skip
    """Return terms that the conditions themselves rule out: they did not change, or moved together."""
    base = {**moving, **({} if warm is None else {TEMPERATURE: warm})}
    refused: dict[Key, tuple[str, Reason]] = {}
    remarks: list[Remark] = []
    asked = [name for name in plan.to if name in base or name == TEMPERATURE]

    def refuse(name: str, code: str, text: str) -> None:
        # Where the temperature follows a condition, their product follows its square
        powers = min(order, 2) if code == "conditions_together" and plan.interactions else 1
        for key in term_keys(plan, axis, name, powers, applied=applied):
            refused.setdefault(key, (_unit_of(readings, key, name), Reason(code, text)))
        remarks.append(Remark(code, "warning", text, do=TO_DO[code], axis=axis, subject=name))

    for name in asked:
        values, unit = base.get(name), readings.units.get(name, "degC")
        if values is None:
            refuse(name, "missing_condition", f"{axis} has no {name}")
            continue
        whole, inside = float(np.ptp(values)), _spread(values, runs)
        least = max(RANGES.get(name, 0.0), readings.scatter.get(name, 0.0))
        if whole <= least:
            noise = readings.scatter.get(name, 0.0)
            hidden = f", as far as its noise of {noise:.2g} {unit} a sample tells" if noise > whole else ""
            refuse(name, "not_varied", f"{name} stayed within {whole:.3g} {unit} in all recordings{hidden}")
        elif inside < STILL * whole:
            what = f"{name} changes from power-up to power-up only, and each has an intercept of its own"
            refuse(name, "between_power_ups", what)
    live = [name for name in base if base[name].size and _spread(base[name], runs) > 0.0
            and (_unit_key(axis, name) not in refused)]  # fmt: skip
    for name in (one for one in live if one in plan.to and len(live) > 1):
        share, partner = _explained(name, {one: within(base[one], runs) for one in live})
        text = f"{name} and {partner} change together (R^2 = {share:.3f} within power-ups)"
        if share > TOGETHER:
            refuse(name, "conditions_together", f"{text}: nothing tells their effects apart")
        elif share > APART:
            do = TO_DO["conditions_together"]
            remarks.append(Remark("conditions_together", "warning", text, do=do, axis=axis, subject=name))
    return refused, remarks


def _unit_key(axis: str, name: str) -> Key:
    return Key(f"bias_{name}", axis, power=1) if name == TEMPERATURE else Key(f"bias_{name}", axis)


def _unit_of(readings: Readings, key: Key, name: str) -> str:
    unit = readings.units.get(name, "degC" if name == TEMPERATURE else "1")
    if key.quantity == f"scale_factor_error_{name}":
        return divide("1", unit)
    if key.quantity == f"bias_{name}_{TEMPERATURE}":
        return divide(readings.unit, multiply(unit, "degC"))
    return divide(readings.unit, power(unit, max(key.power, 1)))


def _explained(name: str, columns: Mapping[str, Array]) -> tuple[float, str]:
    """Return the part of the variance of one column that the others make up, and the one most like it."""
    others = [one for one in columns if one != name]
    target = columns[name] / np.linalg.norm(columns[name])
    basis = np.column_stack([columns[one] / np.linalg.norm(columns[one]) for one in others])
    left = target - basis @ np.linalg.lstsq(basis, target, rcond=None)[0]
    return 1.0 - float(left @ left), others[int(np.argmax(np.abs(target @ basis)))]


def _told_apart(
    columns: Sequence[Column], runs: NDArray[np.str_], refused: dict[Key, tuple[str, Reason]], axis: str
) -> list[Column]:
    """Return columns of which none is made up of those before it; terms of the others are refused."""
    kept: list[Column] = []
    basis = np.zeros((len(runs), 0))
    for one in sorted(columns, key=lambda column: (column.scale, column.warm and column.condition != TEMPERATURE)):
        own = within(one.values, runs)
        size = float(np.linalg.norm(own))
        left = own - basis @ (basis.T @ own)
        left -= basis @ (basis.T @ left)
        whole = float(np.linalg.norm(one.values - one.values.mean()))
        if size > STILL * whole > 0.0 and float(left @ left) > TOLD * size**2:
            kept.append(one)
            basis = np.column_stack([basis, left / np.linalg.norm(left)])
        elif one.key is not None and one.key not in refused:
            text = f"{one.name}: the levels of {axis} do not tell it from the other terms"
            refused[one.key] = (one.unit, Reason("not_told_apart", text))
    return kept
