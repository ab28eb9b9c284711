"""Readings after another test: the bias over temperature that it found is taken off, sample by sample.

The temperature is that of the sensor's own channel, in both tests: an error of the thermometer is in both alike, and
drops out; so does one of the converter's reference, in proportion. What is left of the uncertainty is the scatter of
the thermal test, the choice of the order, and what is not known of the rate of the earth in its chamber. It is carried
as unknowns of the recording, at the mean temperature of it.

An accelerometer at rest reads gravity along its axis, which no thermal test tells from the bias: of its law only the
change from the reference temperature is taken off, and its bias is left, as at that temperature. What the scale factor
does over temperature is in that change by as much as the axis was along gravity in the thermal test.

The unknowns are those of the coefficients of the law, in one order whatever the recordings: applied twice, to parts of
a recording, they are the same ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.influence import Influence
from ...core.key import AXES, At, Key, Origin
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.unknowns import Unknowns
from ...statistics.polynomial import powers_from_series
from ..corrections import factors
from .fit.law import Law, gathered
from .fit.quantities import ORDER, REFERENCE, THERMOMETER, Asked, Wanted, earth_along, estimates, power_unit
from .plan import Plan
from .recordings import TEMPERATURE

if TYPE_CHECKING:
    from .reduction import Result

CANCELLED = ("converter.reference",)  # in the readings and in what is taken off alike
IN_BOTH = {"thermometer.temperature": THERMOMETER, "converter.reference": REFERENCE}  # what drops out, as it is called
PATH = "sensor.hysteresis"
DWELL = "dwell"  # place of a value: number of a recording
TAKEN = "bias_taken_off"


@dataclass(frozen=True, eq=False)
class ThermalCorrection:
    """The bias over temperature that a thermal test found, to be taken off."""

    test: str  # Its name
    result: Result  # Of it

    @property
    def unit(self) -> str:
        """Of the readings."""
        return self.result.readings.unit

    @property
    def reference_temperature(self) -> float | None:
        """Of accelerometers, whose bias at it is left [degC]; of gyros nothing is left."""
        return self.result.plan.reference_temperature if self.unit == "m/s^2" else None

    @property
    def range(self) -> tuple[float, float]:
        """Temperatures that the law of every sensor holds for [degC]."""
        domains = [one.law.domain for one in self.result.sensors.values()]
        return max(low for low, _ in domains), min(high for _, high in domains)

    def apply(
        self, recordings: Sequence[tuple[str, Recording]]
    ) -> tuple[list[Recording], list[Mapping[Origin, Unknowns]]]:
        """Return recordings with the bias over temperature taken off, and what is not known of it in each.

        Parameters
        ----------
        recordings : sequence of (str, Recording)
            Each with its name: channels named by axis [SI], and their temperatures [degC].

        Raises
        ------
        DataError
            ``no_temperature`` if a recording has none; ``no_law`` if the thermal test found no bias of a sensor;
            ``outside`` if a recording lies outside the temperatures of the law.
        """
        corrected, levels = [], []
        for name, one in recordings:
            recording, level = _without(one, name, self)
            corrected.append(recording)
            levels.append(level)
        unknown = unknowns(self, levels)
        taken_off: list[Mapping[Origin, Unknowns]] = [
            {origin: one.take(np.array([i])) for origin, one in unknown.items()} for i in range(len(corrected))
        ]
        return corrected, taken_off


def _without(recording: Recording, name: str, bias: ThermalCorrection) -> tuple[Recording, dict[str, float]]:
    """Return a recording without the bias, and the mean temperature of each of its sensors [degC]."""
    level: dict[str, float] = {}
    channels, outside = [], 0
    place = recording.source.path or name
    for channel in recording.channels:
        if channel.name not in AXES:
            channels.append(channel)
            continue
        law = _law(bias, channel.name, place)
        warmth = _temperature(recording, channel.name, place)
        inside = (warmth >= law.domain[0]) & (warmth <= law.domain[1])
        if not inside.any():
            raise _nowhere(law.domain, warmth, channel.name, place, bias.test)
        outside = max(outside, int(np.count_nonzero(np.isfinite(warmth) & ~inside)))
        level[channel.name] = float(np.mean(warmth[inside]))
        off = np.where(inside, law.basis(np.where(inside, warmth, law.domain[0])) @ law.coefficients, np.nan)
        kept = _earth(bias.result)[AXES.index(channel.name)] + float(_level(bias.result, law) @ law.coefficients)
        channels.append(replace(channel, data=np.asarray(channel.data, dtype=float) - (off - kept)))
    remarks = recording.remarks
    if outside:
        what = f"{bias.test} knows no bias at the temperature of the sample: left out"
        remarks = (*remarks, Remark("outside", "warning", what, place, outside))
    return replace(recording, channels=tuple(channels), remarks=remarks), level


def _earth(result: Result) -> Array:
    """Return the earth rate along the axes; nothing for accelerometers, shape (3,)."""
    return earth_along(result.plan)[0] if result.readings.unit == "rad/s" else np.zeros(len(AXES))


def _level(result: Result, law: Law) -> Array:
    """Return the row of what is not taken off, shape (order + 1,): of accelerometers what they read at T_ref."""
    rows = powers_from_series(law.order, law.domain, result.plan.reference_temperature)[0]
    return np.asarray(rows if result.readings.unit == "m/s^2" else np.zeros(law.order + 1))


def _law(bias: ThermalCorrection, axis: str, place: str) -> Law:
    found = bias.result.sensors.get(axis)
    if found is None:
        what = f"after = {bias.test!r}, but that found no bias over temperature of {axis}"
        raise DataError(what, place, str(bias.result.reasons.get(axis, "it was not read there")), code="no_law")
    return found.law


def _temperature(recording: Recording, axis: str, place: str) -> Array:
    for name in (f"{TEMPERATURE}_{axis}", TEMPERATURE):
        if name in recording.names:
            found: Array = np.asarray(recording.channel(name).data, dtype=float)
            if np.isfinite(found).any():
                return found
    what = f"no temperature of the {axis} sensor, whose bias over temperature is to be taken off"
    raise DataError(what, place, do=f"Give channels.temperature_{axis}, or leave out after", code="no_temperature")


def _nowhere(domain: tuple[float, float], warmth: Array, axis: str, place: str, test: str) -> DataError:
    seen = f"{np.nanmin(warmth):.4g} to {np.nanmax(warmth):.4g} degC"
    what = f"{axis} was at {seen}, {test} knows its bias from {domain[0]:.4g} to {domain[1]:.4g} degC"
    return DataError(what, place, do="Leave out after, or ramp further", code="outside")


def unknowns(bias: ThermalCorrection, levels: Sequence[Mapping[str, float]] = ()) -> dict[Origin, Unknowns]:
    """Return what is not known of the bias taken off, a dwell for the temperatures of each level, by origin."""
    found, sources = sources_of(bias, levels)
    if found is None:
        return {}
    n, law = len(levels), np.flatnonzero([key.at is None for key in found.keys])
    held = [(i, int(key.at.value), AXES.index(key.axis)) for i, key in enumerate(found.keys) if key.at is not None]
    telling = law if n == 0 else np.array([i for i, _, _ in held], dtype=np.intp)  # values that tell of a sensor
    keys = tuple(found.keys[i] for i in law)
    sensors = [AXES.index(found.keys[i].axis) for i in telling]
    every = {}
    for one, changes in sources:
        patterns = np.zeros((len(changes), n, 3))
        for i, dwell, axis in held:
            patterns[:, dwell, axis] = changes[:, i]
        origin = one.origin._replace(test=bias.test)
        of_sensor = dof_of_sensors(one, telling, sensors, n == 0)
        every[origin] = Unknowns(origin, one.kind, patterns, keys, changes[:, law], of_sensor, one.distribution,
                                 one.stated, one.unknowns)  # fmt: skip
    return every


Known = tuple[Estimate | None, list[tuple[Component, Array]]]


def sources_of(bias: ThermalCorrection, levels: Sequence[Mapping[str, float]] = ()) -> Known:
    """Return the bias taken off at each level, with the coefficients of its law, and what is not known of them.

    Of each source the changes of all values by each of its unknowns, shape (s, values). None where nothing is known.
    """
    found = sources_of_each([bias.result], levels)[0]
    if isinstance(found, DataError):
        raise found
    return found


def sources_of_each(results: Sequence[Result], levels: Sequence[Mapping[str, float]] = ()) -> list[Known | DataError]:
    """Return the same of each of several results, or why there is none, at once."""
    plans: dict[int, Plan] = {}
    wanted = []
    for one in results:
        plan, unit = one.plan, one.readings.unit
        if id(plan) not in plans:  # one path was seen: the thermal test remarks it
            standards = {name: each for name, each in plan.standards.items() if name not in CANCELLED}
            standards.setdefault(PATH, Influence(0.0, unit))
            plans[id(plan)] = replace(plan, standards=standards)
        asked = {
            axis: [_asked(one, axis, law, tuple(level.get(axis, law.domain[0]) for level in levels))]
            for axis, law in one.laws.items()
        }
        wanted.append(Wanted(plans[id(plan)], one.laws, asked, unit))
    unknown = iter(_factors([law for one in wanted for law in one.laws.values()]))
    found: list[Known | DataError] = []
    for each, estimate in zip(wanted, estimates(wanted), strict=True):
        own = [(law, each.asked[axis][0], next(unknown)) for axis, law in each.laws.items()]
        if estimate is None:
            found.append((None, []))
        elif isinstance(estimate, DataError):
            found.append(estimate)
        else:
            acting = [part for part in estimate.components if (part.covariance.diagonal() > 0.0).any()]
            found.append((estimate, [(part, _changes(estimate, part, own)) for part in acting]))
    return found


def sources_of_laws(results: Sequence[Result]) -> list[Known | DataError]:
    """Return the coefficients of the laws of each of several results, and what is not known of them, likewise.

    They are part of what the results hold, but where one path alone was seen.
    """
    whole = [all(law.midway for law in one.laws.values()) for one in results]
    rest = iter(sources_of_each([one for one, held in zip(results, whole, strict=True) if not held]))
    laws = [law for one, held in zip(results, whole, strict=True) if held for law in one.laws.values()]
    unknown = iter(_factors(laws))
    found: list[Known | DataError] = []
    for one, held in zip(results, whole, strict=True):
        if not held:
            found.append(next(rest))
            continue
        own = [(law, one.asked[axis][0], next(unknown)) for axis, law in one.laws.items()]
        keys, units, at = (
            ((), (), np.zeros(0, dtype=np.intp))
            if one.estimate is None
            else _laws_in(one.estimate.keys, one.estimate.units)
        )
        if one.estimate is None or not keys:
            found.append((None, []))
            continue
        standards, grid = one.plan.standards, at[:, None] * len(one.estimate.keys) + at
        left = [standards[name].origin(words) for name, words in IN_BOTH.items() if name in standards]
        parts = []
        for part in one.estimate.components:
            covariance = part.covariance.take(grid)
            if part.given not in left and covariance.diagonal().any():
                dof = part.dof if isinstance(part.dof, float) else part.dof[at]
                changes = None if part.changes is None else part.changes[:, at]
                parts.append(part.changed(covariance=covariance, dof=dof, changes=changes))
        estimate = Estimate.of_own(keys, one.estimate.values[at], units, tuple(parts))
        found.append((estimate, [(part, _changes(estimate, part, own)) for part in parts]))
    return found


@lru_cache(maxsize=256)  # the same of all units of a lot
def _laws_in(
    keys: tuple[Key, ...], units: tuple[str, ...]
) -> tuple[tuple[Key, ...], tuple[str, ...], NDArray[np.intp]]:
    """Return keys, units and places of the coefficients of laws among values."""
    at = [i for i, key in enumerate(keys) if key.at is None and key.quantity in ("bias", "bias_temperature")]
    return tuple([keys[i] for i in at]), tuple([units[i] for i in at]), np.array(at, dtype=np.intp)


def _factors(laws: Sequence[Law]) -> list[Array]:
    """Return independent unknowns of the coefficients of each law, shape (s, order + 1)."""
    found: dict[int, Array] = {}
    for alike in gathered(one.order for one in laws):
        found.update(zip(alike, factors(np.array([laws[i].scatter.covariance for i in alike])), strict=True))
    return [found[i] for i in range(len(laws))]


def dof_of_sensors(
    component: Component, values: NDArray[np.intp], sensors: Sequence[int], fewest: bool = True
) -> Array:
    """Return the degrees of freedom of a source, by sensor, shape (3,): the fewest of some values of it, or the last.

    Of a sensor without a value they are infinite.
    """
    of_sensor = np.full(3, np.inf)
    if fewest and isinstance(component.dof, np.ndarray):
        np.minimum.at(of_sensor, sensors, component.dof[values])
    else:
        of_sensor[sensors] = component.dof[values] if isinstance(component.dof, np.ndarray) else component.dof
    return of_sensor


def _asked(result: Result, axis: str, law: Law, warmth: tuple[float, ...]) -> Asked:
    """Return the bias taken off at each temperature, then the coefficients of the law."""
    keys, units = _labels(result.readings.unit, axis, law.order, len(warmth))

    def rows(one: Law) -> Array:
        powers = powers_from_series(one.order, one.domain, result.plan.reference_temperature)[: law.order + 1]
        return np.vstack([one.basis(warmth) - _level(result, one), powers]) if len(warmth) else powers

    own = rows(law)
    more = None if law.higher is None else rows(law.higher) @ law.higher.coefficients - own @ law.coefficients
    return Asked(keys, units, own, by_temperature=False, changes=more)


@lru_cache(maxsize=256)  # the same of all units of a lot
def _labels(unit: str, axis: str, order: int, levels: int) -> tuple[tuple[Key, ...], tuple[str, ...]]:
    keys = [Key(TAKEN, axis, at=At(DWELL, i, "")) for i in range(levels)] + law_keys(axis, order)
    return tuple(keys), (*[unit] * levels, *(power_unit(unit, "degC", j) for j in range(order + 1)))


def _changes(found: Estimate, component: Component, own: Sequence[tuple[Law, Asked, Array]]) -> Array:
    """Return the changes of all values by each unknown of a source, shape (s, names): those of coefficients of laws."""
    if component.changes is not None:
        return component.changes
    whole, start = sum(len(asked.keys) for _, asked, _ in own) == len(found.keys), 0
    blocks, places = [], {} if whole else {key: i for i, key in enumerate(found.keys)}
    hidden = component.origin == ORDER
    for _, asked, unknowns in own:
        if whole:
            known: list[int] | slice = slice(None)
            at: list[int] | slice = slice(start, start := start + len(asked.keys))
        else:
            known = [k for k, key in enumerate(asked.keys) if key in places]
            at = [places[asked.keys[k]] for k in known]
        rows = (
            unknowns @ asked.rows[known].T
            if not hidden
            else (np.zeros((1, len(asked.rows[known]))) if asked.changes is None else asked.changes[None, known])
        )
        block = np.zeros((len(rows), len(found.keys)))
        block[:, at] = rows
        blocks.append(block)
    return np.concatenate(blocks)


def law_keys(axis: str, order: int) -> list[Key]:
    """Return the keys of the coefficients of a bias over temperature."""
    return [Key("bias", axis), *(Key("bias_temperature", axis, power=j) for j in range(1, order + 1))]
