"""From the coefficients of the lines to the field's quantities, with Type A and Type B parts.

Signs and words (DESIGN of the sensor equation; IEEE 528, 1431): ``bias`` is K0, the reading at no rate;
``scale_factor_error_x`` is M_xx - 1, positive when the sensor reads too much; ``misalignment_xz`` is
M_xz / M_xx: the row is the sensor that reads, the column the axis that turns; ``scale_factor_asymmetry`` is
K1' = 2 c / M, the difference of the scale factors of the two senses of rotation over their mean;
``second_order`` and ``third_order`` are K2 = b2 / M^2 and K3 = b3 / M^3. Where a line has K3, its scale factor is the
slope at zero rate, M of the sensor equation; where it has not, that of the best straight line.

Type B (one unknown value for the whole test, so dwells do not average it):

table rate
    a relative error r of every rate changes all matrix entries by -r in proportion.
mounting
    the axis turned is off the one named by two small angles, each with the stated uncertainty u, anew for
    each axis that is mounted: a sensor then reads its own entries of the other axes too, so a misalignment takes u
    and a scale factor u times the misalignments; and all entries shrink by 1 - cos, root mean square sqrt(2) u^2.
converter reference
    a relative error changes all scale factors in proportion (and the bias, by its own size times that).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array, Estimate, Sources
from ....core.key import AXES, Key, Origin
from ....statistics.least_squares import times
from ..plan import Plan
from ..turned import POWERS, WORDS
from .earth_input import earth_influences
from .regression import Line

UNITS = {
    "bias": "rad/s", "scale_factor_error": "1", "scale_factor_asymmetry": "1", "cross_axis_sensitivity": "1",
    "misalignment": "rad", "second_order": "1/(rad/s)", "third_order": "1/(rad/s)^2",
}  # fmt: skip


FAINT = 0.01  # own response over the ideal one, below which a sensor does not sense its rate
CURVATURES = {"K2": "second_order", "K3": "third_order"}


@dataclass(frozen=True, eq=False)
class _Layout:
    """Quantities of a line: ``factor * coefficient / slope**power - ideal``, shape (m,) each."""

    keys: tuple[Key, ...]
    about: NDArray[np.intp]  # the coefficient
    rows: NDArray[np.intp]
    power: Array
    factor: Array
    ideal: Array


@lru_cache(maxsize=256)  # the same of all units that are turned alike
def _layout(
    s: str, axes: tuple[str, ...], names: tuple[str, ...], silent: bool, responds: bool, told: tuple[bool, ...],
    curvatures: tuple[str, ...] | None,
) -> _Layout:  # fmt: skip
    """Return the quantities of a line by the names of its coefficients, of those that are told of alone."""
    found: list[tuple[Key, int, float, float, float]] = [(Key("bias", s), 0, 0.0, 1.0, 0.0)]
    if s in axes and not silent:
        found.append((Key("scale_factor_error", s), names.index(f"M_{s}{s}"), 0.0, 1.0, 1.0))
    if "c" in names and responds:
        found.append((Key("scale_factor_asymmetry", s), names.index("c"), 1.0, 2.0, 0.0))
    for name in (name for name in POWERS if name in names and responds):
        found.append((Key(CURVATURES[name], s), names.index(name), float(POWERS[name]), 1.0, 0.0))
    for axis in (axis for axis in axes if axis != s and not silent):
        at = names.index(f"M_{s}{axis}")
        found.append((Key("cross_axis_sensitivity", s + axis), at, 0.0, 1.0, 0.0))
        if responds:
            found.append((Key("misalignment", s + axis), at, 1.0, 1.0, 0.0))
    chosen = None if curvatures is None else [Key(CURVATURES[name], s) for name in curvatures]
    found = [one for one in found if told[one[1]] and (chosen is None or one[0] in chosen)]
    about, power, factor, ideal = (np.array([one[i] for one in found], dtype=float) for i in range(1, 5))
    return _Layout(tuple(one[0] for one in found), about.astype(np.intp), np.arange(len(found)), power, factor, ideal)


def estimate(plan: Plan, lines: Mapping[str, Line], full: Mapping[str, Line] | None = None) -> Estimate | None:
    """Return bias, scale factor error, asymmetry, cross-axis sensitivity and misalignment of all sensors.

    The Type A parts of different sensors are taken as independent, and so are curvatures that a line does not have,
    which come from ``full``, its line with all curvatures that the rates allow. Sensors whose scatter was not
    repeated at any level are left out.

    Returns
    -------
    Estimate or None
        Names like ``bias_x`` [rad/s], ``scale_factor_error_x`` [1], ``scale_factor_asymmetry_x`` [1],
        ``cross_axis_sensitivity_zx`` [1], ``misalignment_zx`` [rad]; None where nothing can be estimated.
    """
    found = estimates([(plan, lines, full or {})])[0]
    if isinstance(found, DataError):
        raise found
    return found


def estimates(
    units: Sequence[tuple[Plan, Mapping[str, Line], Mapping[str, Line]]],
) -> list[Estimate | DataError | None]:
    """Return the `estimate` of each of several units, or why there is none; those with the same figures at once."""
    found: list[Estimate | DataError | None] = [None] * len(units)
    kinds: dict[tuple[object, ...], list[tuple[int, list[_Used]]]] = {}
    for i, (plan, lines, full) in enumerate(units):
        used = [_Used.of(one) for one in lines.values() if one.covariance is not None]
        for one in [*used]:
            whole = full.get(one.line.sensor)
            if whole is not None and whole.covariance is not None and whole.curvature != one.line.curvature:
                lacking = tuple(name for name in whole.curvature if name not in one.line.curvature)
                used.append(_Used.of(whole, lacking))
        if used:
            kinds.setdefault((id(plan), *(one.kind for one in used)), []).append((i, used))
    for alike in kinds.values():
        plan = units[alike[0][0]][0]
        made = _alike(plan, [Part.of(each) for each in zip(*(used for _, used in alike), strict=True)])
        for (i, _), each in zip(alike, made, strict=True):
            found[i] = each
    return found


def is_silent(one: Line) -> bool:
    """Tell whether a sensor was turned about its own axis and does not respond: nothing is relative to that."""
    return one.sensor in one.axes and abs(one.coefficient(f"M_{one.sensor}{one.sensor}")) < FAINT


class _Used(NamedTuple):
    """A line of a unit, and all that its figures have in common with those of other units."""

    line: Line
    layout: _Layout
    responds: bool
    kind: tuple[object, ...]

    @classmethod
    def of(cls, one: Line, curvatures: tuple[str, ...] | None = None) -> _Used:
        """Return a line with the layout of its figures; of curvatures alone where they are given.

        A coefficient that only one run tells of has no degrees of freedom, and what rests on it is left out. Of a
        sensor that is silent only its bias is given.
        """
        own, silent = one.sensor in one.axes, is_silent(one)
        responds = own and not silent and one.coefficient(f"M_{one.sensor}{one.sensor}") != 0.0
        told = tuple((one.dof > 0.0).tolist())
        layout = _layout(one.sensor, one.axes, one.names, silent, responds, told, curvatures)
        taken_off = one.readings.taken_off
        kind = (
            layout, responds, one.level, id(one.readings.earth_sources) if one.readings.earth_sources else 0,
            id(taken_off) if taken_off else 0, one.fit.solve.shape, tuple(other.name for other in one.unresolved),
        )  # fmt: skip
        return cls(one, layout, responds, kind)


@dataclass(frozen=True, eq=False)
class Part:
    """The figures of a line of each of several units that are alike."""

    lines: list[Line]
    layout: _Layout
    theta: Array  # shape (u, p): coefficients of the lines
    values: Array  # shape (u, m)
    jacobian: Array  # shape (u, m, p): with the coefficients of the lines

    @classmethod
    def of(cls, used: Sequence[_Used]) -> Part:
        """Return the figures of lines of one kind."""
        (first, layout, responds, _), lines = used[0], [one.line for one in used]
        theta = np.array([one.fit.coefficients for one in lines])
        own = first.names.index(f"M_{first.sensor}{first.sensor}") if responds else 0
        slope = theta[:, own, None] if responds else np.ones((len(lines), 1))
        by_own = layout.factor / slope**layout.power
        values = theta[:, layout.about] * by_own - layout.ideal
        jacobian = np.zeros((*values.shape, theta.shape[1]))
        jacobian[:, layout.rows, layout.about] = by_own
        if responds:
            bent = layout.power > 0
            jacobian[:, bent, own] = (-layout.power * values / slope)[:, bent]
        return cls(lines, layout, theta, values, jacobian)

    @property
    def entries(self) -> Array:
        """What the sensor reads of x, y and z, as fitted; as ideal where the axis was not turned, shape (u, 3)."""
        first = self.lines[0]
        found = np.tile([float(axis == first.sensor) for axis in AXES], (len(self.lines), 1))
        found[:, [AXES.index(axis) for axis in first.axes]] = self.theta[:, 1 : 1 + len(first.axes)]
        return found

    def by(self, coefficients: Array) -> Array:
        """Return changes of the figures by changes of the coefficients, (u, p, s): shape (u, s, m)."""
        return (self.jacobian @ coefficients).swapaxes(1, 2)


def quantities_of(one: Line) -> tuple[tuple[Key, ...], Array]:
    """Return keys and Jacobian of the quantities of a line, shape (m, p)."""
    part = Part.of([_Used.of(one)])
    return part.layout.keys, part.jacobian[0]


SOURCES = {
    "run": "scatter between runs",
    "dwell": "scatter between dwells",
    "sample": "scatter between samples",
    "recording": "scatter between recordings",  # where a run is a recording, and no power-up is known
    "highest": "scatter at the highest level repeated",
}


def _alike(plan: Plan, parts: list[Part]) -> list[Estimate | DataError]:
    """Return the estimates of units whose lines are of the same kinds, part by part."""
    keys = tuple(key for one in parts for key in one.layout.keys)
    values = np.concatenate([one.values for one in parts], axis=1)
    stops = np.cumsum([len(one.layout.keys) for one in parts]).tolist()
    blocks = [slice(start, stop) for start, stop in zip([0, *stops], stops, strict=False)]
    sources = [
        _type_a(plan, parts, blocks, values.shape),
        *_type_b(plan, keys, values, parts, blocks),
        *_earth(plan, parts, blocks, values.shape),
        *_taken_off(keys, parts),
        *_unresolved(parts, blocks, values.shape),
    ]
    count, units = len(values), tuple(UNITS[key.quantity] for key in keys)
    return Estimate.of_each([keys] * count, values, [units] * count, sources)


def _type_a(plan: Plan, parts: list[Part], blocks: list[slice], shape: tuple[int, ...]) -> Sources:
    covariance, dof = np.zeros((*shape, shape[1])), np.empty(shape)
    for part, block in zip(parts, blocks, strict=True):
        each = [one.covariance for one in part.lines if one.covariance is not None]
        own = part.jacobian @ np.array(each) @ part.jacobian.swapaxes(1, 2)
        covariance[:, block, block] = 0.5 * (own + own.swapaxes(1, 2))
        dof[:, block] = np.array([one.dof for one in part.lines])[:, part.layout.about]
    levels = {one.lines[0].level for one in parts}
    level = levels.pop() if len(levels) == 1 else "highest"
    level = plan.run_level if level == "run" and plan.run_level == "recording" else level
    return Sources(Origin(SOURCES[level], level=level), "A", covariance, dof, "t")


def _type_b(plan: Plan, keys: tuple[Key, ...], values: Array, parts: list[Part], blocks: list[slice]) -> list[Sources]:
    ideal, with_rate, bias = _kinds(keys)
    proportional = ideal + with_rate * values  # change for a relative change of every rate
    found = []
    rate = plan.standards.get("rate_table.rate")
    if rate is not None:
        # The true input is larger by e: what is proportional to 1 / input is smaller, and errors of rate are too.
        found.append(Sources.of_influence(rate.origin("table rate"), -rate.u * proportional[:, None], rate))
    mounting = plan.standards.get("rate_table.mounting")
    if mounting is not None:
        names, by_angle = _mounting(parts, blocks, values.shape, mounting.u)
        found.append(Sources.of_influence(mounting.origin("mounting on the table"), by_angle, mounting, names))
    reference = plan.standards.get("converter.reference")
    if reference is not None:
        changes = reference.u * (proportional + bias * values)[:, None]
        found.append(Sources.of_influence(reference.origin("converter reference"), changes, reference))
    return found


@lru_cache(maxsize=64)  # the same of all units that are turned alike
def _kinds(keys: tuple[Key, ...]) -> tuple[Array, Array, Array]:
    """Return which quantities have an ideal 1 in proportion to 1 / rate, are in that proportion, are a bias; 0 or 1."""
    names = [key.quantity for key in keys]
    wanted = (("scale_factor_error",), ("scale_factor_error", "cross_axis_sensitivity"), ("bias",))
    ideal, with_rate, bias = (np.array([float(one in some) for one in names]) for some in wanted)
    return ideal, with_rate, bias


def _mounting(
    parts: list[Part], blocks: list[slice], shape: tuple[int, ...], u: float
) -> tuple[tuple[str, ...], Array]:
    """Return the angles between axes turned and named, ``"xz"``: x towards z, and the changes of quantities by each.

    With axis a turned, an angle towards j adds ``M_sj`` times the angle to what every sensor s reads of a; the
    angles are others for each axis turned. Second order, all entries of a shrink together: ``"xx"``.
    """
    by_entry, entry = (np.zeros((*shape, len(AXES))) for _ in range(2))  # derivative of all quantities by the entries
    for part, block in zip(parts, blocks, strict=True):
        at = [AXES.index(axis) for axis in part.lines[0].axes]
        by_entry[:, block, at] = part.jacobian[:, :, 1 : 1 + len(at)]
        entry[:, block] = part.entries[:, None]
    turned = sorted({axis for one in parts for axis in one.lines[0].axes})
    pairs = [(a, j) for a in turned for j in (*(axis for axis in AXES if axis != a), a)]
    size = np.array([np.sqrt(2.0) * u**2 if a == j else u for a, j in pairs])
    of, to = (np.array([AXES.index(pair[i]) for pair in pairs]) for i in (0, 1))
    changes = by_entry.swapaxes(1, 2)[:, of] * (size[:, None] * entry.swapaxes(1, 2)[:, to])
    return tuple(f"{a}{j}" for a, j in pairs), changes


def matrix_entry(one: Line, axis: str) -> float:
    """Return what a sensor reads of an axis, as fitted; as ideal where the axis was not turned."""
    return one.coefficient(f"M_{one.sensor}{axis}") if axis in one.axes else float(axis == one.sensor)


def _earth(plan: Plan, parts: list[Part], blocks: list[slice], shape: tuple[int, ...]) -> list[Sources]:
    """Return what is not known of the earth rate: a wrong input of M e in the dwells that were used."""
    turned = dict.fromkeys(axis for one in parts for axis in one.lines[0].axes)
    known = {name: influence for axis in turned for name, influence in earth_influences(plan, axis).items()}
    changed: dict[str, Array] = {}
    for part, block in zip(parts, blocks, strict=True):
        patterns = part.lines[0].readings.earth_sources
        if not patterns:
            continue
        every = np.concatenate([*patterns.values()])  # (s of all, n, 3)
        solve = np.array([one.fit.solve for one in part.lines])
        moved = solve @ every.swapaxes(0, 1).reshape(len(every[0]), -1)  # coefficients, by each pattern along x, y, z
        moved = moved.reshape(*solve.shape[:2], len(every), len(AXES)) @ part.entries[:, None, :, None]
        own, start = -part.by(moved[..., 0]), 0
        for name, each in patterns.items():
            changes = changed.setdefault(name, np.zeros((shape[0], len(each), shape[1])))
            changes[:, :, block] = own[:, start : start + len(each)]
            start += len(each)
    found = []
    for source, changes in changed.items():
        name, own_influence = f"earth rate: {source}", known.get(source)
        if own_influence is None:  # the readings were made with another attitude than this plan has
            found.append(replace(Sources.of_changes(name, changes), changes=None))
            continue
        origin = own_influence.origin(name) if own_influence.standard else name
        one = Sources.of_influence(origin, changes, own_influence)
        found.append(one if own_influence.standard else replace(one, changes=None))
    return found


def _taken_off(keys: tuple[Key, ...], parts: list[Part]) -> list[Sources]:
    """Return what is not known of a bias that was taken off before."""
    found = []
    known = {origin: off for one in parts for origin, off in one.lines[0].readings.taken_off.items()}
    for origin, off in known.items():
        each = [_taken_off_changes(part, origin, len(off.changes)) for part in parts]
        dof = np.array([[off.dof[AXES.index(key.axis[0])] for key in keys]] * len(each[0]))
        found.append(
            Sources.of_changes(
                origin, np.concatenate(each, axis=2), dof, off.kind, off.distribution, off.stated, off.unknowns
            )
        )
    return found


def _taken_off_changes(part: Part, origin: Origin, unknowns: int) -> Array:
    """Change of quantities of a sensor for each unknown of what was taken off before, shape (u, s, m)."""
    off = part.lines[0].readings.taken_off.get(origin)
    if off is None:
        return np.zeros((len(part.values), unknowns, part.values.shape[1]))
    solve = np.array([one.fit.solve for one in part.lines])
    return -part.by(solve @ off.of_sensor(part.lines[0].sensor).T)


def _unresolved(parts: list[Part], blocks: list[slice], shape: tuple[int, ...]) -> list[Sources]:
    """Return the sources of curvatures that lines do not have: what each would change, and how large it may be."""
    found = []
    for part, block in zip(parts, blocks, strict=True):
        for k, other in enumerate(part.lines[0].unresolved):
            each = [one.unresolved[k] for one in part.lines]
            change = np.zeros((shape[0], 1, shape[1]))
            change[:, 0, block] = times(part.jacobian, np.array([one.pattern for one in each]))
            sensor = part.lines[0].sensor
            source, term = f"{WORDS[other.name]} of {sensor}, not resolved", Key(CURVATURES[other.name], sensor)
            size, unit = np.array([one.size for one in each]), UNITS[term.quantity]
            covariance = size[:, None, None] ** 2 * (change.swapaxes(1, 2) * change)
            stated: list[tuple[float, str] | None] = [(one.size, unit) for one in each]
            found.append(Sources(source, "B", covariance, stated=stated, changes=change, term=str(term)))
    return found
