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
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array, Component, Estimate
from ....core.key import AXES, Key, Origin
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
    usable = [one for one in lines.values() if one.covariance is not None]
    if not usable:
        return None
    parts = [quantities_of(one) for one in usable]
    for one in [*usable]:
        whole = (full or {}).get(one.sensor)
        if whole is not None and whole.covariance is not None and whole.curvature != one.curvature:
            lacking = [Key(CURVATURES[name], one.sensor) for name in whole.curvature if name not in one.curvature]
            usable.append(whole)
            parts.append(_chosen(quantities_of(whole), lacking))
    keys = tuple(key for part in parts for key in part[0])
    values = np.concatenate([part[1] for part in parts])
    units = tuple(UNITS[key.quantity] for key in keys)
    components = [
        _type_a(plan, parts, usable, len(keys)),
        *_type_b(plan, keys, values, parts, usable),
        *_earth(plan, parts, usable),
        *_taken_off(keys, parts, usable),
        *_unresolved(parts, usable, len(keys)),
    ]
    return Estimate(keys, values, units, tuple(components))


def is_silent(one: Line) -> bool:
    """Tell whether a sensor was turned about its own axis and does not respond: nothing is relative to that."""
    return one.sensor in one.axes and abs(one.coefficient(f"M_{one.sensor}{one.sensor}")) < FAINT


def _chosen(part: Part, wanted: list[Key]) -> Part:
    """Return what a part says of some of its quantities."""
    keys, values, jacobian, about = part
    at = [i for i, key in enumerate(keys) if key in wanted]
    return [keys[i] for i in at], values[at], jacobian[at], about[at]


def _unresolved(parts: list[Part], lines: list[Line], k: int) -> list[Component]:
    """Components of curvatures that lines do not have: what each would change, and how large it may be."""
    found, start = [], 0
    for (keys, _, jacobian, _), one in zip(parts, lines, strict=True):
        for other in one.unresolved:
            change = np.zeros(k)
            change[start : start + len(keys)] = jacobian @ other.pattern
            source, term = f"{WORDS[other.name]} of {one.sensor}, not resolved", Key(CURVATURES[other.name], one.sensor)
            found.append(
                Component(
                    source,
                    "B",
                    other.size**2 * np.outer(change, change),
                    stated=(other.size, UNITS[term.quantity]),
                    changes=change[None],
                    term=str(term),
                )
            )
        start += len(keys)
    return found


Part = tuple[Sequence[Key], Array, Array, NDArray[np.intp]]


def quantities_of(one: Line) -> Part:
    """Return keys, values and Jacobian of the quantities, and the coefficient that each is mainly about.

    A coefficient that only one run tells of has no degrees of freedom, and what rests on it is left out. Of a sensor
    that is silent only its bias is given.
    """
    theta = one.fit.coefficients
    own = one.names.index(f"M_{one.sensor}{one.sensor}") if one.sensor in one.axes else None
    silent = is_silent(one)
    slope = 0.0 if own is None or silent else float(theta[own])
    told = tuple((one.dof > 0.0).tolist())
    layout = _layout(one.sensor, one.axes, one.names, silent, slope != 0.0, told)
    by_own = layout.factor / (slope or 1.0) ** layout.power
    values = theta[layout.about] * by_own - layout.ideal
    jacobian = np.zeros((len(values), len(theta)))
    jacobian[layout.rows, layout.about] = by_own
    if own is not None and slope:
        bent = layout.power > 0
        jacobian[bent, own] = (-layout.power * values / slope)[bent]
    return layout.keys, values, jacobian, layout.about


class _Layout(NamedTuple):
    """Quantities of a line: ``factor * coefficient / slope**power - ideal``, shape (m,) each."""

    keys: tuple[Key, ...]
    about: NDArray[np.intp]  # the coefficient
    rows: NDArray[np.intp]
    power: Array
    factor: Array
    ideal: Array


@lru_cache(maxsize=64)  # the same of all units that are turned alike
def _layout(
    s: str, axes: tuple[str, ...], names: tuple[str, ...], silent: bool, responds: bool, told: tuple[bool, ...]
) -> _Layout:
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
    found = [one for one in found if told[one[1]]]
    about, power, factor, ideal = (np.array([one[i] for one in found]) for i in range(1, 5))
    return _Layout(tuple(one[0] for one in found), about.astype(np.intp), np.arange(len(found)), power, factor, ideal)


SOURCES = {
    "run": "scatter between runs",
    "dwell": "scatter between dwells",
    "sample": "scatter between samples",
    "recording": "scatter between recordings",  # where a run is a recording, and no power-up is known
    "highest": "scatter at the highest level repeated",
}


def _type_a(plan: Plan, parts: list[Part], lines: list[Line], k: int) -> Component:
    covariance, dof, start = np.zeros((k, k)), np.empty(k), 0
    for (keys, _, jacobian, about), one in zip(parts, lines, strict=True):
        block = slice(start, start + len(keys))
        assert one.covariance is not None  # noqa: S101 - for the type checker
        own = jacobian @ one.covariance @ jacobian.T
        covariance[block, block] = 0.5 * (own + own.T)
        dof[block] = one.dof[about]
        start += len(keys)
    levels = {one.level for one in lines}
    level = levels.pop() if len(levels) == 1 else "highest"
    level = plan.run_level if level == "run" and plan.run_level == "recording" else level
    return Component(Origin(SOURCES[level], level=level), "A", covariance, dof, "t")


def _type_b(plan: Plan, keys: tuple[Key, ...], values: Array, parts: list[Part], lines: list[Line]) -> list[Component]:
    ideal, with_rate, bias = _kinds(keys)
    proportional = ideal + with_rate * values  # change for a relative change of every rate
    found = []
    rate = plan.standards.get("rate_table.rate")
    if rate is not None:
        # The true input is larger by e: what is proportional to 1 / input is smaller, and errors of rate are too.
        changes, whole = -rate.u * proportional, rate.u**2 * (proportional[:, None] * proportional)
        found.append(
            Component(rate.origin("table rate"), "B", whole, rate.dof, rate.distribution, rate.stated, changes[None])
        )
    mounting = plan.standards.get("rate_table.mounting")
    if mounting is not None:
        names, by_angle = _mounting(parts, lines, mounting.u)
        covariance = by_angle.T @ by_angle
        shape, origin = mounting.distribution, mounting.origin("mounting on the table")
        covariance = 0.5 * (covariance + covariance.T)
        found.append(Component(origin, "B", covariance, mounting.dof, shape, mounting.stated, by_angle, names))
    reference = plan.standards.get("converter.reference")
    if reference is not None:
        gain = proportional + bias * values
        covariance = reference.u**2 * (gain[:, None] * gain)
        shape = reference.distribution
        found.append(
            Component(
                reference.origin("converter reference"),
                "B",
                covariance,
                reference.dof,
                shape,
                reference.stated,
                reference.u * gain[None],
            )
        )
    return found


@lru_cache(maxsize=64)  # the same of all units that are turned alike
def _kinds(keys: tuple[Key, ...]) -> tuple[Array, Array, Array]:
    """Return which quantities have an ideal 1 in proportion to 1 / rate, are in that proportion, are a bias; 0 or 1."""
    names = [key.quantity for key in keys]
    wanted = (("scale_factor_error",), ("scale_factor_error", "cross_axis_sensitivity"), ("bias",))
    ideal, with_rate, bias = (np.array([float(one in some) for one in names]) for some in wanted)
    return ideal, with_rate, bias


def _mounting(parts: list[Part], lines: list[Line], u: float) -> tuple[tuple[str, ...], Array]:
    """Return the angles between axes turned and named, ``"xz"``: x towards z, and the changes of quantities by each.

    With axis a turned, an angle towards j adds ``M_sj`` times the angle to what every sensor s reads of a; the
    angles are others for each axis turned. Second order, all entries of a shrink together: ``"xx"``.
    """
    count = [len(part[0]) for part in parts]
    by_entry = np.zeros((sum(count), len(AXES)))  # derivative of all quantities by the matrix entries of their line
    start = 0
    for (_, _, jacobian, _), one in zip(parts, lines, strict=True):
        at = [AXES.index(axis) for axis in one.axes]
        by_entry[start : start + len(jacobian), at] = jacobian[:, 1 : 1 + len(at)]
        start += len(jacobian)
    entry = np.repeat([matrix_entries(one) for one in lines], count, axis=0)
    turned = sorted({axis for one in lines for axis in one.axes})
    pairs = [(a, j) for a in turned for j in (*(axis for axis in AXES if axis != a), a)]
    size = np.array([np.sqrt(2.0) * u**2 if a == j else u for a, j in pairs])
    of, to = (np.array([AXES.index(pair[i]) for pair in pairs]) for i in (0, 1))
    return tuple(f"{a}{j}" for a, j in pairs), by_entry.T[of] * (size[:, None] * entry.T[to])


def matrix_entries(one: Line) -> Array:
    """Return what a sensor reads of x, y and z, as fitted; as ideal where the axis was not turned, shape (3,)."""
    found = np.array([float(axis == one.sensor) for axis in AXES])
    found[[AXES.index(axis) for axis in one.axes]] = one.fit.coefficients[1 : 1 + len(one.axes)]
    return found


def matrix_entry(one: Line, axis: str) -> float:
    """Return what a sensor reads of an axis, as fitted; as ideal where the axis was not turned."""
    return one.coefficient(f"M_{one.sensor}{axis}") if axis in one.axes else float(axis == one.sensor)


def _earth(plan: Plan, parts: list[Part], lines: list[Line]) -> list[Component]:
    """Components of what is not known of the earth rate: a wrong input of M e in the dwells that were used."""
    turned = dict.fromkeys(axis for one in lines for axis in one.axes)
    known = {name: influence for axis in turned for name, influence in earth_influences(plan, axis).items()}
    stacked: dict[int, Array] = {}  # patterns of all sources, shape (s of all, n, 3), by the sources
    for one in lines:
        sources = one.readings.earth_sources
        if sources and id(sources) not in stacked:
            stacked[id(sources)] = np.concatenate([*sources.values()])
    changed = [
        _earth_changes(part, one, stacked[id(one.readings.earth_sources)])
        for part, one in zip(parts, lines, strict=True)
        if one.readings.earth_sources
    ]
    found = []
    for source in dict.fromkeys(name for one in changed for name in one):
        changes = np.concatenate([one[source] for one in changed])
        covariance = changes @ changes.T
        covariance = 0.5 * (covariance + covariance.T)
        name, own = f"earth rate: {source}", known.get(source)
        if own is None:  # the readings were made with another attitude than this plan has
            found.append(Component(name, "B", covariance))
            continue
        given, by = (own.origin(name), changes.T) if own.standard else (name, None)
        found.append(Component(given, "B", covariance, own.dof, own.distribution, own.stated, by))
    return found


def _earth_changes(part: Part, one: Line, stacked: Array) -> dict[str, Array]:
    """Return the change of the quantities of a sensor for each pattern of each source, shapes (names, s)."""
    sources = one.readings.earth_sources
    patterns = stacked @ matrix_entries(one)  # (s of all, n): what the sensor reads of each
    changes: Array = -part[2] @ (one.fit.solve @ patterns.T)
    found, start = {}, 0
    for name, each in sources.items():
        found[name] = changes[:, start : start + len(each)]
        start += len(each)
    return found


def _taken_off(keys: tuple[Key, ...], parts: list[Part], lines: list[Line]) -> list[Component]:
    """Components of what is not known of a bias that was taken off before."""
    found = []
    known = {origin: off for one in lines for origin, off in one.readings.taken_off.items()}
    for origin, off in known.items():
        changes = np.vstack([_taken_off_change(part[2], one, origin) for part, one in zip(parts, lines, strict=True)])
        covariance = changes @ changes.T
        dof = np.array([off.dof[AXES.index(key.axis[0])] for key in keys])
        covariance = 0.5 * (covariance + covariance.T)
        found.append(
            Component(origin, off.kind, covariance, dof, off.distribution, off.stated, changes.T, off.unknowns)
        )
    return found


def _taken_off_change(jacobian: Array, one: Line, origin: Origin) -> Array:
    """Change of quantities of a sensor for each unknown of what was taken off before, shape (names, s).

    Parameters
    ----------
    jacobian : ndarray, shape (names, p)
        Of the quantities with the coefficients of the line.
    one : Line
        Of the sensor.
    origin : Origin
        Of what was taken off.
    """
    off = one.readings.taken_off.get(origin)
    if off is None:
        return np.zeros((len(jacobian), 0))
    changes: Array = -jacobian @ (one.fit.solve @ off.of_sensor(one.sensor).T)
    return changes
