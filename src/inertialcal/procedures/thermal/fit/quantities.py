"""From the law of each sensor to the field's quantities, with Type A and Type B parts.

``bias`` is K0, the reading at rest with earth rate taken off; ``bias_temperature_1``, ... its further coefficients in
powers of the temperature less the reference; ``bias_voltage_0``, ... those in powers of the volts of the temperature
channel, themselves in volts where the scale factor is known. Of an accelerometer at rest the constant holds what
gravity adds along the axis: it is no bias, and not given.

Type B (one unknown value for the whole test, so more runs do not average it):

earth rate
    what is not known of it adds to every bias alike (module ``earth``).
thermometer
    its error moves the law along the temperature: every bias by the slope there. Not over the channel's own volts.
converter reference
    a relative error changes every reading in proportion.
one path
    where one path alone was seen, half of what the paths may differ by is unknown; without a stated
    ``sensor.hysteresis`` nothing is given midway.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.polynomial import chebyshev

from ....core.estimate import Array, Component, Estimate
from ....core.influence import Influence
from ....core.key import AXES, At, Key, Origin
from ....core.units import normalise
from ....physics.earth import OMEGA, earth_rate, level_to_table
from ....sensors.thermal import over_voltage, powers_of
from ....statistics.polynomial import Polynomial
from ..plan import Attitude, Plan, Thermometer
from .law import Law

SOURCES = {
    "run": "scatter between runs",
    "ramp": "scatter between ramps",
    "block": "scatter between stretches of ramps",
    "recording": "scatter between recordings",  # where a run is a recording, and no power-up is known
    "highest": "scatter at the highest level repeated",
}


ORDER = Origin("order of the polynomial", level="hidden")


@dataclass(frozen=True, eq=False)
class Asked:
    """Values that are linear in the coefficients of P."""

    keys: tuple[Key, ...]  # One a value
    units: tuple[str, ...]  # SI
    rows: Array  # shape (m, order + 1): values are ``rows @ coefficients``
    by_temperature: bool = True  # Whether they hold over temperature, and not over the channel's own volts
    changes: Array | None = None  # shape (m,): values of a higher order of P less these; None where the order was given


def at_degrees(temperature: float) -> At:
    """Return the place of a value at a temperature [degC]."""
    return At("temperature", temperature, "degC")


def power_unit(unit: str, by: str, power: int) -> str:
    """Return the unit of a coefficient: ``rad/s``, ``rad/s/degC``, ``rad/s/degC^2``, as ``core.units`` prints it."""
    if power == 0:
        return unit
    return normalise(f"({unit})/{by}" if power == 1 else f"({unit})/{by}^{power}")


def asked_of(plan: Plan, law: Law, axis: str, unit: str, quantity: str = "bias") -> list[Asked]:
    """Return what is wanted of a law: coefficients over temperature, values at temperatures, the same over volts."""
    found = _by_order(plan, law, axis, unit, quantity)
    if law.higher is None:
        return found
    other = {
        key: row @ law.higher.coefficients
        for one in _by_order(plan, law.higher, axis, unit, quantity)
        for key, row in zip(one.keys, one.rows, strict=True)
    }
    return [
        replace(one, changes=np.array([other[key] for key in one.keys]) - one.rows @ law.coefficients) for one in found
    ]


def _by_order(plan: Plan, law: Law, axis: str, unit: str, quantity: str) -> list[Asked]:
    powers = powers_of(law.order, law.domain, plan.reference_temperature)
    keys = [Key(quantity, axis), *(Key(f"{quantity}_temperature", axis, power=j) for j in range(1, law.order + 1))]
    units = tuple(power_unit(unit, "degC", j) for j in range(law.order + 1))
    found = [Asked(tuple(keys), units, powers)]
    inside = [one for one in plan.at or () if law.domain[0] <= one <= law.domain[1]]
    if inside:
        found.append(
            Asked(
                tuple(Key(quantity, axis, at=at_degrees(one)) for one in inside),
                (unit,) * len(inside),
                law.basis(inside),
            )
        )
    thermometer = (plan.thermometers or {}).get(axis)
    if thermometer is not None and quantity == "bias":
        found.append(_over_volts(law, axis, unit, thermometer, (plan.scale_factor or {}).get(axis)))
    return found


def _over_volts(law: Law, axis: str, unit: str, channel: Thermometer, volts_per_unit: float | None) -> Asked:
    """Return the coefficients over the channel's volts, in volts where the scale factor is known."""
    blank = Polynomial(np.ones(law.order + 1), None, 0.0, law.domain)
    volts = over_voltage(blank, channel.slope, channel.voltage, channel.temperature)
    rows = powers_of(law.order, volts.domain, 0.0) * volts.coefficients  # odd ones turned by a negative slope
    keys = tuple(Key("bias_voltage", axis, power=j) for j in range(law.order + 1))
    own, scale = ("V", volts_per_unit) if volts_per_unit is not None else (unit, 1.0)
    units = tuple(power_unit(own, "V", j) for j in range(law.order + 1))
    return Asked(keys, units, scale * rows, by_temperature=False)


def bias_at(plan: Plan, law: Law, axis: str, unit: str, temperatures: Array) -> Estimate | None:
    """Return the bias at temperatures inside the range of a law, in order; None where it has no uncertainty."""
    return _at("bias", plan, law, axis, unit, law.basis(temperatures), law.changed(temperatures))


def change_at(plan: Plan, law: Law, axis: str, unit: str, temperatures: Array) -> Estimate | None:
    """Return the bias at temperatures inside the range of a law less that at the reference temperature, likewise."""
    reference = plan.reference_temperature
    rows = law.basis(temperatures) - law.basis([reference])
    return _at("bias_over_temperature", plan, law, axis, unit, rows, law.changed(temperatures) - law.changed(reference))


def _at(quantity: str, plan: Plan, law: Law, axis: str, unit: str, rows: Array, changes: Array) -> Estimate | None:
    keys = tuple(Key(quantity, axis, at=At("place", i, "")) for i in range(len(rows)))
    asked = Asked(keys, (unit,) * len(rows), rows, changes=changes)
    found = estimate(plan, {axis: law}, {axis: [asked]}, unit)
    return found if found is not None and len(found.names) == len(rows) else None


@dataclass(frozen=True, eq=False)
class _Part:
    """Known values of one law: keys, values, units, Type A covariance and dof, Type B changes by source."""

    keys: list[Key]
    values: Array
    units: list[str]
    covariance: Array
    dof: Array
    changes: Mapping[str, Array]
    level: str
    choice: Array  # What a higher order of P changes


def estimate(plan: Plan, laws: Mapping[str, Law], asked: Mapping[str, list[Asked]], unit: str) -> Estimate | None:
    """Return all quantities of all sensors; None where nothing can be told.

    The Type A parts of different sensors are taken as independent. What has no degrees of freedom is left out.

    Parameters
    ----------
    plan : Plan
        With the standards.
    laws : mapping of str to Law
        By axis.
    asked : mapping of str to list of Asked
        By axis.
    unit : {"rad/s", "m/s^2", "V"}
        Of the readings.
    """
    parts = [_part(plan, law, axis, one, unit) for axis, law in laws.items() for one in [_joined(asked[axis])]]
    parts = [one for one in parts if one.keys]
    if not parts:
        return None
    keys = tuple(key for part in parts for key in part.keys)
    components = [_type_a(plan, parts, len(keys)), *_type_b(plan, parts, unit)]
    choice, start = np.zeros((len(parts), len(keys))), 0  # a row a sensor
    for row, part in zip(choice, parts, strict=True):
        row[start : start + len(part.keys)] = part.choice
        start += len(part.keys)
    if choice.any():
        components.insert(1, Component(ORDER, "A", choice.T @ choice))
    values = np.concatenate([part.values for part in parts])
    return Estimate(keys, values, tuple(u for part in parts for u in part.units), tuple(components))


def _joined(asked: Iterable[Asked]) -> tuple[Asked, Array]:
    every = list(asked)
    over = np.concatenate([np.full(len(one.rows), one.by_temperature) for one in every])
    keys = tuple(key for one in every for key in one.keys)
    changes = None if every[0].changes is None else np.concatenate([one.changes for one in every])
    rows, units = np.vstack([one.rows for one in every]), tuple(u for one in every for u in one.units)
    return Asked(keys, units, rows, changes=changes), over


def _part(plan: Plan, law: Law, axis: str, joined: tuple[Asked, Array], unit: str) -> _Part:
    asked, over = joined
    covariance, dof = law.contrasts(asked.rows)
    constant = asked.rows[:, 0]
    known = dof > 0.0
    if unit == "m/s^2":
        known &= np.array([not _is_level(key) for key in asked.keys])
    if unit != "V" and not law.midway and "sensor.hysteresis" not in plan.standards:
        known &= np.array([not _is_level(key) for key in asked.keys])
    raw = asked.rows @ law.coefficients
    at = AXES.index(axis)
    earth, unknown = earth_along(plan) if unit == "rad/s" else (np.zeros(3), {})
    changes = {f"earth rate: {name}": -np.outer(one.patterns[:, at], constant) for name, one in unknown.items()}
    changes |= _own_changes(plan, law, asked.rows, over, raw, unit)
    return _Part(
        [key for key, keep in zip(asked.keys, known, strict=True) if keep],
        (raw - earth[at] * constant)[known],
        [one for one, keep in zip(asked.units, known, strict=True) if keep],
        covariance[np.ix_(known, known)],
        dof[known],
        {name: change[:, known] for name, change in changes.items()},
        (plan.run_level if law.level == "run" and plan.run_level == "recording" else law.level),
        (np.zeros(len(raw)) if asked.changes is None else asked.changes)[known],
    )


def _is_level(key: Key) -> bool:
    """Whether a quantity holds the constant of the law, and not its shape alone."""
    return key.quantity in ("bias", "bias_voltage") and key.power == 0


def _own_changes(plan: Plan, law: Law, rows: Array, over: Array, raw: Array, unit: str) -> dict[str, Array]:
    """Change of the values for one standard uncertainty of thermometer, converter and the path not seen, (1, m)."""
    found = {}
    thermometer = plan.standards.get("thermometer.temperature")
    if thermometer is not None and law.order:
        slope = np.append(chebyshev.chebder(law.coefficients), 0.0) * 2.0 / (law.domain[1] - law.domain[0])
        found["thermometer"] = -(thermometer.u * over * (rows @ slope))[None]
    reference = plan.standards.get("converter.reference")
    if reference is not None:
        found["converter reference"] = (reference.u * raw)[None]
    gap = plan.standards.get("sensor.hysteresis")
    if gap is not None and not law.midway and unit != "V":
        found["path not seen"] = (0.5 * gap.u * rows[:, 0])[None]
    return found


def _type_a(plan: Plan, parts: list[_Part], size: int) -> Component:
    covariance, dof, start = np.zeros((size, size)), np.empty(size), 0
    for part in parts:
        block = slice(start, start + len(part.keys))
        covariance[block, block] = 0.5 * (part.covariance + part.covariance.T)
        dof[block] = part.dof
        start += len(part.keys)
    levels = {part.level for part in parts}
    level = levels.pop() if len(levels) == 1 else "highest"
    return Component(Origin(SOURCES[level], level=level), "A", covariance, dof, "t")


def _type_b(plan: Plan, parts: list[_Part], unit: str) -> list[Component]:
    influences = {
        "thermometer": plan.standards.get("thermometer.temperature"),
        "converter reference": plan.standards.get("converter.reference"),
        "path not seen": plan.standards.get("sensor.hysteresis"),
    }
    if unit == "rad/s":
        influences |= {f"earth rate: {name}": one.influence for name, one in earth_along(plan)[1].items()}
    found = []
    for source in dict.fromkeys(name for part in parts for name in part.changes):
        widths = [len(part.keys) for part in parts]
        deep = max(len(part.changes[source]) for part in parts if source in part.changes)
        whole = np.hstack(
            [part.changes.get(source, np.zeros((deep, n))) for part, n in zip(parts, widths, strict=True)]
        )
        covariance = whole.T @ whole
        one = influences[source]
        assert one is not None  # noqa: S101 - a change has its influence
        found.append(
            Component(
                one.origin(source), "B", 0.5 * (covariance + covariance.T), one.dof, one.distribution, one.stated, whole
            )
        )
    return found


STEP = 1e-4  # [rad], of the differences


@dataclass(frozen=True, eq=False)
class Unknown:
    """What is not known of the earth rate from one source."""

    patterns: Array  # shape (s, 3): along x, y, z, each one standard uncertainty [rad/s]
    influence: Influence  # What it rests on


def earth_along(plan: Plan) -> tuple[Array, Mapping[str, Unknown]]:
    """Return earth rate along the body axes, shape (3,) [rad/s], and what is not known of it, by source; read-only."""
    return _kept(plan.attitude, plan.latitude, plan.standards.get("site.latitude", Influence(0.0, "rad")))


@lru_cache(maxsize=16)
def _kept(attitude: Attitude | None, latitude: float | None, known: Influence) -> tuple[Array, Mapping[str, Unknown]]:
    earth, found = _earth_along(attitude, latitude, known)
    for array in (earth, *(one.patterns for one in found.values())):
        array.flags.writeable = False
    return earth, MappingProxyType(found)


def _earth_along(
    attitude: Attitude | None, latitude: float | None, known: Influence
) -> tuple[Array, dict[str, Unknown]]:
    if attitude is None or latitude is None:
        size = OMEGA / np.sqrt(3.0)
        unknown = Unknown(size * np.eye(3), Influence(size, "rad/s", distribution="rectangular"))
        return np.zeros(3), {"attitude unknown": unknown}
    found = {}
    for name, at, influence in (
        ("latitude", 0, known),
        ("tilt of the body", 1, Influence(attitude.u, "rad")),
        ("azimuth of the body", 2, Influence(attitude.u_azimuth, "rad")),
    ):
        if influence.u > 0.0 and not (at == 2 and attitude.azimuth is None):
            # Change of earth rate along x, y, z with the latitude (0), the tilt (1) or the azimuth (2), shape (3,)
            moved = STEP * np.eye(3)[at]
            azimuth = None if attitude.azimuth is None else (attitude.azimuth - moved[2], attitude.azimuth + moved[2])
            low = _mean(latitude - moved[0], attitude.tilt - moved[1], None if azimuth is None else azimuth[0])
            high = _mean(latitude + moved[0], attitude.tilt + moved[1], None if azimuth is None else azimuth[1])
            slope = np.asarray((high - low) / (2.0 * STEP))
            found[name] = Unknown((influence.u * slope)[None], influence)
    if attitude.azimuth is None:
        found["azimuth of the body unknown"] = _any_azimuth(latitude, attitude)
    return _mean(latitude, attitude.tilt, attitude.azimuth), found


def _mean(latitude: float, tilt: float, azimuth: float | None) -> Array:
    """Earth rate along x, y, z; mean over all azimuths where it is not known."""
    if azimuth is None:
        return np.asarray(0.5 * (_mean(latitude, tilt, 0.0) + _mean(latitude, tilt, np.pi)))
    return np.asarray(level_to_table(tilt, azimuth) @ earth_rate(latitude))


def _any_azimuth(latitude: float, attitude: Attitude) -> Unknown:
    middle = _mean(latitude, attitude.tilt, None)
    waves = np.stack([_mean(latitude, attitude.tilt, angle) - middle for angle in (0.0, 0.5 * np.pi)])
    size = float(np.cos(latitude) * OMEGA * np.sqrt(0.5))
    return Unknown(waves * np.sqrt(0.5), Influence(size, "rad/s", distribution="arcsine"))
