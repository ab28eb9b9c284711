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

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain, compress
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array, Estimate, Sources
from ....core.influence import Influence
from ....core.key import AXES, At, Key, Origin
from ....core.units import normalise
from ....physics.earth import OMEGA, earth_rate, level_to_table
from ....sensors.thermal import over_voltage
from ....statistics.least_squares import times
from ....statistics.polynomial import Polynomial, powers_from_series, powers_from_series_each
from ..plan import Attitude, Plan, Thermometer
from .law import Law, contrasts_of, gathered, series_rows_each, slopes_of

SOURCES = {
    "run": "scatter between runs",
    "ramp": "scatter between ramps",
    "block": "scatter between stretches of ramps",
    "recording": "scatter between recordings",  # where a run is a recording, and no power-up is known
    "highest": "scatter at the highest level repeated",
}


ORDER = Origin("order of the polynomial", level="hidden")
THERMOMETER, REFERENCE = "thermometer", "converter reference"


class Asked(NamedTuple):
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
    inside = _inside(plan, law)
    thermometer = (plan.thermometers or {}).get(axis) if quantity == "bias" else None
    scale = (plan.scale_factor or {}).get(axis)

    def rows_of(one: Law) -> list[Array]:
        name = _asked_rows(plan, one, inside)
        if name not in one.cells.once:
            find_rows([(plan, one)])
        found: list[Array] = one.cells.once[name]
        return found + ([] if thermometer is None else [_over_volts(one, thermometer, scale)])

    own = rows_of(law)
    labels = _labels(quantity, axis, unit, law.order, inside, scale is not None)
    kept = [True, bool(inside), thermometer is not None]
    higher = [None] * len(own) if law.higher is None else rows_of(law.higher)
    return [
        Asked(keys, units, rows, over,
              None if more is None or law.higher is None
              else more[: len(keys)] @ law.higher.coefficients - rows @ law.coefficients)
        for (keys, units, over), rows, more in zip(compress(labels, kept), own, higher, strict=True)
    ]  # fmt: skip


def find_rows(laws: Sequence[tuple[Plan, Law]]) -> None:
    """Find the rows over temperature that `asked_of` wants of laws and of those of a higher order, alike at once."""
    own: dict[tuple[int, Hashable], tuple[Plan, Law, tuple[float, ...]]] = {}
    for plan, law in laws:
        inside = _inside(plan, law)
        for one in (law, law.higher):
            if one is not None:
                own[id(one.cells.once), _asked_rows(plan, one, inside)] = plan, one, inside
    named = [*own.items()]
    for at in gathered((one.order, len(inside)) for _, (_, one, inside) in named):
        alike = [named[i] for i in at]
        first, order = alike[0][1], alike[0][1][1].order
        domains = np.array([one.domain for _, (_, one, _) in alike])
        powers = powers_from_series_each(order, domains, [plan.reference_temperature for _, (plan, _, _) in alike])
        bases = series_rows_each(np.array([inside for _, (_, _, inside) in alike]), domains, order)
        for ((_, name), (_, one, _)), *rows in zip(alike, powers, bases, strict=True):
            one.cells.once.keep(name, rows if first[2] else rows[:1])


def _asked_rows(plan: Plan, law: Law, inside: tuple[float, ...]) -> Hashable:
    return "asked", law.order, law.domain, plan.reference_temperature, inside


def _inside(plan: Plan, law: Law) -> tuple[float, ...]:
    """Return the temperatures asked for that the law holds at [degC]."""
    low, high = law.domain
    return tuple([one for one in plan.at or () if low <= one <= high])


def find_asked(laws: Sequence[Law], asked: Sequence[Sequence[Asked]]) -> None:
    """Find what `estimate` wants of judged laws, of many units, alike at once; also the covariance of coefficients."""
    rows = [np.concatenate([*(one.rows for one in own), np.eye(law.order + 1)])
            for law, own in zip(laws, asked, strict=True)]  # fmt: skip
    free = [len(every) - law.order - 1 for law, every in zip(laws, rows, strict=True)]
    found = contrasts_of(laws, rows, free=free)
    for law, every, n, (first, *rest), (covariance, dof) in zip(laws, rows, free, asked, found, strict=True):
        m = len(first.rows)
        law.scatter.once.keep("covariance", covariance[n:, n:])
        law.know_contrasts(every[:n], (covariance[:n, :n], dof))
        if rest:
            law.know_contrasts(first.rows, (covariance[:m, :m], dof[:m]))


@lru_cache(maxsize=256)
def _labels(
    quantity: str, axis: str, unit: str, order: int, at: tuple[float, ...], in_volts: bool
) -> tuple[tuple[tuple[Key, ...], tuple[str, ...], bool], ...]:
    """Return keys, units and whether they hold over temperature: of the coefficients, of values, and over volts."""
    powers, own = range(order + 1), "V" if in_volts else unit
    keys = (Key(quantity, axis), *(Key(f"{quantity}_temperature", axis, power=j) for j in powers[1:]))
    return (
        (keys, tuple(power_unit(unit, "degC", j) for j in powers), True),
        (tuple(Key(quantity, axis, at=at_degrees(one)) for one in at), (unit,) * len(at), True),
        (tuple(Key("bias_voltage", axis, power=j) for j in powers), tuple(power_unit(own, "V", j) for j in powers),
         False),
    )  # fmt: skip


def _over_volts(law: Law, channel: Thermometer, volts_per_unit: float | None) -> Array:
    """Return the rows of the coefficients over the channel's volts, in volts where the scale factor is known."""
    blank = Polynomial(np.ones(law.order + 1), None, 0.0, law.domain)
    volts = over_voltage(blank, channel.slope, channel.voltage, channel.temperature)
    rows = powers_from_series(law.order, volts.domain, 0.0) * volts.coefficients  # odd ones turned by a negative slope
    return rows if volts_per_unit is None else volts_per_unit * rows


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
    found = estimates([Wanted(plan, laws, asked, unit)])[0]
    if isinstance(found, DataError):
        raise found
    return found


class Wanted(NamedTuple):
    """What `estimate` takes of a unit."""

    plan: Plan
    laws: Mapping[str, Law]
    asked: Mapping[str, list[Asked]]
    unit: str


class _Part(NamedTuple):
    """What is asked of one sensor, shape (m,) each."""

    law: Law
    asked: Asked
    raw: Array  # values as read
    constant: Array  # change by what adds to every reading
    slope: Array  # change with the temperature of the law; 0 over the channel's own volts
    covariance: Array  # shape (m, m): type A
    dof: Array
    choice: Array  # values of a higher order less these
    at: int  # number of the axis

    @classmethod
    def each(cls, sensors: Sequence[tuple[str, Law, Sequence[Asked]]]) -> list[_Part]:
        """Return the parts of several sensors, those alike at once."""
        joined = [_joined(asked) for _, _, asked in sensors]
        laws = [law for _, law, _ in sensors]
        found: dict[int, _Part] = {}
        for alike in gathered(one.rows.shape for one in joined):
            rows, coefficients = (
                np.array([joined[i].rows for i in alike]),
                np.array([laws[i].coefficients for i in alike]),
            )
            raw, slope = times(rows, coefficients), times(rows, slopes_of([laws[i] for i in alike]))
            for k, i in enumerate(alike):
                axis, law, asked = sensors[i]
                one = joined[i]
                covariance, dof = law.contrasts(one.rows)
                own, start = slope[k], 0
                for part in asked:
                    if not part.by_temperature:
                        own[start : start + len(part.keys)] = 0.0
                    start += len(part.keys)
                choice = np.zeros(len(dof)) if one.changes is None else one.changes
                found[i] = cls(law, one, raw[k], rows[k, :, 0], own, covariance, dof, choice, AXES.index(axis))
        return [found[i] for i in range(len(sensors))]

    def known(self, unit: str, gap: bool) -> _Part | None:
        """Return what has degrees of freedom, without what holds the constant where that is hidden; None for nothing.

        ``gap``: how far the path that was not seen may be is stated.
        """
        keep = self.dof > 0.0
        if unit == "m/s^2" or (unit != "V" and not self.law.midway and not gap):
            keep &= ~np.array([_is_level(key) for key in self.asked.keys])
        if keep.all():
            return self
        if not keep.any():
            return None
        keys, units = tuple(compress(self.asked.keys, keep)), tuple(compress(self.asked.units, keep))
        return _Part(
            self.law, Asked(keys, units, self.asked.rows[keep]), self.raw[keep], self.constant[keep], self.slope[keep],
            self.covariance[np.ix_(keep, keep)], self.dof[keep], self.choice[keep], self.at,
        )  # fmt: skip


def estimates(units: Sequence[Wanted]) -> list[Estimate | DataError | None]:
    """Return the `estimate` of each of several units, or why there is none, at once."""
    sensors = [(axis, law, one.asked[axis]) for one in units for axis, law in one.laws.items()]
    parts = iter(_Part.each(sensors))
    found: list[Estimate | DataError | None] = [None] * len(units)
    kinds: dict[tuple[int, str, str], list[tuple[int, list[_Part]]]] = {}
    for i, (plan, laws, _, unit) in enumerate(units):
        gap = plan.standards.get("sensor.hysteresis") is not None
        own = [one for _, part in zip(laws, parts, strict=False) if (one := part.known(unit, gap)) is not None]
        if own:
            by_recording = plan.run_level == "recording"
            levels: set[str] = {
                "recording" if by_recording and one.law.level == "run" else one.law.level for one in own
            }
            level = levels.pop() if len(levels) == 1 else "highest"
            kinds.setdefault((id(plan), unit, level), []).append((i, own))
    for (_, unit, level), alike in kinds.items():
        made = _alike(units[alike[0][0]].plan, unit, level, [own for _, own in alike])
        for (i, _), each in zip(alike, made, strict=True):
            found[i] = each
    return found


def _alike(plan: Plan, unit: str, level: str, units: Sequence[Sequence[_Part]]) -> list[Estimate | DataError]:
    """Return the estimates of units of one plan whose scatter is of one level."""
    keys = [tuple(chain.from_iterable([one.asked.keys for one in own])) for own in units]
    shape = len(units), max(map(len, keys))
    raw, constant, slope, one_path = np.zeros((4, *shape))
    dof, covariance = np.full(shape, np.inf), np.zeros((*shape, shape[1]))
    choice, at = np.zeros((len(units), len(AXES), shape[1])), np.zeros(shape, dtype=np.intp)
    for u, own in enumerate(units):
        start = 0
        for k, one in enumerate(own):
            block = slice(start, start := start + len(one.dof))
            raw[u, block], constant[u, block], slope[u, block], dof[u, block] = (
                one.raw,
                one.constant,
                one.slope,
                one.dof,
            )
            covariance[u, block, block] = 0.5 * (one.covariance + one.covariance.T)
            choice[u, k, block], at[u, block], one_path[u, block] = one.choice, one.at, not one.law.midway
    earth, unknown = earth_along(plan) if unit == "rad/s" else (np.zeros(len(AXES)), {})
    sources = [Sources(Origin(SOURCES[level], level=level), "A", covariance, dof, "t")]
    if choice.any():
        hidden = Sources.of_changes(ORDER, choice, np.inf, "A")
        sources.append(replace(hidden, changes=None, there=np.asarray(choice.any(axis=(1, 2)))))
    for name, each in unknown.items():
        changes = -each.patterns[:, at].swapaxes(0, 1) * constant[:, None]
        sources.append(_of(f"earth rate: {name}", each.influence, changes))
    thermometer, reference, gap = (
        plan.standards.get(one) for one in ("thermometer.temperature", "converter.reference", "sensor.hysteresis")
    )
    if thermometer is not None:
        bent = np.array([any(one.law.order for one in own) for own in units])
        sources.append(replace(_of(THERMOMETER, thermometer, -(thermometer.u * slope)[:, None]), there=bent))
    if reference is not None:
        sources.append(_of(REFERENCE, reference, (reference.u * raw)[:, None]))
    if gap is not None and unit != "V":
        single = np.array([not all(one.law.midway for one in own) for own in units])
        changes = (0.5 * gap.u * constant * one_path)[:, None]
        sources.append(replace(_of("path not seen", gap, changes), there=single))
    spoken = [tuple(chain.from_iterable([one.asked.units for one in own])) for own in units]
    sources = [one for one in sources if one.there is None or one.there.any()]
    return Estimate.of_each(keys, raw - earth[at] * constant, spoken, sources)


def _of(source: str, influence: Influence, changes: Array) -> Sources:
    return Sources.of_influence(influence.origin(source), changes, influence)


def _joined(asked: Sequence[Asked]) -> Asked:
    if len(asked) == 1:
        return asked[0]
    keys = tuple(chain.from_iterable([one.keys for one in asked]))
    changes = None if asked[0].changes is None else np.concatenate([one.changes for one in asked])
    rows, units = np.concatenate([one.rows for one in asked]), tuple(chain.from_iterable([one.units for one in asked]))
    return Asked(keys, units, rows, changes=changes)


def _is_level(key: Key) -> bool:
    """Whether a quantity holds the constant of the law, and not its shape alone."""
    return key.quantity in ("bias", "bias_voltage") and key.power == 0


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
