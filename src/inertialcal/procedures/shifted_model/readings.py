"""Readings of a shifted ground model: flips of several flights, and the ground model that they shift.

What cannot be meant is refused by its cause: flips of another unit, older than the ground model, beyond its
temperatures, in a unit or with a sign that the ground model contradicts, or a flight that stands in the table twice.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import combinations
from pathlib import Path
from typing import cast

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import factor, kind, si_unit
from ...files.models.model_file import load_model_file
from ...files.text.table import Table
from ...sensors.ground.model import GroundModel
from ...sensors.model.equation import condition_columns, inverted, matrix_at, offset
from ...sensors.model.sensor_model import SensorModel
from ..protocol import Source
from .entry import Flips, FlipsEntry
from .plan import Plan

FAR = 0.5  # of the bias of the ground model, by which a flip is off before a wrong unit or sign is looked for
NEAR = 0.2  # of that distance, to which it comes with the right one
UNITS = {  # factor between units of acceleration: what is then wrong
    1e-6: "g for ug", 1e6: "ug for g", 1e-3: "mg for ug, or g for mg", 1e3: "ug for mg, or mg for g",
    9.80665: "g for m/s2", 1.0 / 9.80665: "m/s2 for g",
}  # fmt: skip
DEGREE = 0.5  # [degC]: beyond the temperature range of the ground model by no more than its last digit


@dataclass(frozen=True)
class Flip:
    """Bias of one axis from one flip, SI."""

    flight: str
    time: int  # [ns since 1970 UTC]
    axis: str
    temperature: float  # [degC]
    bias: float  # [m/s^2]
    u: float  # [m/s^2]
    dof: float
    where: str = ""


@dataclass(frozen=True, eq=False)
class Readings:
    """Flips in order of time, and the ground model."""

    flips: tuple[Flip, ...]
    ground: SensorModel
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of flips."""
        return len(self.flips)

    @property
    def flights(self) -> tuple[str, ...]:
        """Names of the flights, in order of time."""
        return tuple(dict.fromkeys(one.flight for one in self.flips))

    @property
    def runs(self) -> int:
        """Number of flights."""
        return len(self.flights)

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes that have flips."""
        return tuple(axis for axis in AXES if any(one.axis == axis for one in self.flips))


def ground_bias(ground: SensorModel, temperature: Array, bias_of: str) -> Array:
    """Return the bias that a ground model has at temperatures, shape (n, k) [m/s^2].

    Along the axes of the head it is ``M^-1 K0``, of the sensors as they read K0.
    """
    columns = condition_columns(ground, len(temperature), {"temperature": temperature[:, None]})
    own = np.broadcast_to(offset(ground, columns), (len(temperature), len(ground.axes)))
    if bias_of == "sensor":
        return np.asarray(own)
    return np.asarray(np.einsum("nij,nj->ni", np.broadcast_to(
        inverted(matrix_at(ground, columns)), (len(temperature), *ground.matrix.shape[1:])), own))  # fmt: skip


def instant(given: str, what: str, where: str = "") -> int:
    """Return a date as nanoseconds since 1970 UTC: UTC where it has no zone.

    Raises
    ------
    DataError
        ``wrong_time``.
    """
    try:
        when = datetime.fromisoformat(given.strip())
    except ValueError:
        raise DataError(
            f"{what} {given!r} is no date", where, do='Write it like "2026-03-01"', code="wrong_time"
        ) from None
    return int((when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()) * SECOND


def read_ground(path: str | Path) -> SensorModel:
    """Return the ground model of a file.

    Raises
    ------
    DataError
        As ``files.models.model_file``; ``wrong_model``, ``curved_model``, ``missing_condition`` where it is no model of
        bias and scale factor over temperature.
    """
    model = load_model_file(path).model
    if model.kind != "accelerometer":
        what = f"{path} is the model of a {model.kind}"
        raise DataError(what, why="flips are of accelerometers", do="Give the model of the head", code="wrong_model")
    GroundModel(model)
    return model


def readings_from(plan: Plan, sources: Sequence[Source]) -> Readings:
    """Return the flips of all tables of a test.

    Raises
    ------
    DataError
        ``nothing_left``, ``wrong_serial``, ``older_than_ground``, ``outside_temperature_range``, ``flight_twice``,
        ``unit_mixed``, ``wrong_sign``, ``axes_exchanged``, ``wrong_value``, ``models_differ``.
    """
    flips: list[Flip] = []
    remarks: list[Remark] = []
    grounds: list[SensorModel] = []
    for source in sources:
        said = cast("FlipsEntry", source.entry).flips
        assert said is not None  # noqa: S101 - as the file was checked
        ground = source.read_file(said.file, read_ground)
        if grounds and (ground.item != grounds[0].item or not np.array_equal(ground.bias, grounds[0].bias)):
            what = f"{said.file} is another ground model than that of {sources[0].name}"
            raise DataError(what, source.file, "one new model is made of one", "Give the same", "models_differ")
        grounds.append(ground)
        table = source.table()
        found = list(_rows(source, table, said, ground))
        chosen = [one for one in found if source.groups is None or one.flight in source.groups]
        source.chose(len(chosen))
        flips += chosen
        remarks += [*table.remarks, *table.missing(said.bias)]
    if not flips:
        what = f"test {sources[0].test!r}: no flip is in its groups ({', '.join(sources[0].groups or ())})"
        raise DataError(what, code="nothing_left")
    flips.sort(key=lambda one: one.time)
    made = Readings(tuple(flips), grounds[0], tuple(remarks))
    for check in (_of_one_date, _twice, _older, _beyond, _as_ground):
        check(plan, made)
    return made


def _rows(source: Source, table: Table, said: Flips, ground: SensorModel) -> Iterator[Flip]:
    """Yield the flips of a table, SI."""
    axes = [one.lower() for one in table.text(said.axis)]
    flights, dates = table.text(said.flight), table.text(said.date)
    serials = table.text(said.serial) if said.serial else ()
    temperature, bias, u = (table.numbers(name) for name in (said.temperature, said.bias, said.u))
    own = table.unit(said.u)
    per_u = factor(own, si_unit(own)) if own is not None and kind(own) == "acceleration" else None
    warm = table.unit(said.temperature)
    if warm not in (None, "degC"):
        what = f"column {said.temperature!r} is in {warm}"
        raise DataError(what, source.file, do="Give temperatures in degC", code="wrong_value")
    dof = table.numbers(said.dof) if said.dof else np.full(len(table), math.inf)
    for i in range(len(table)):
        where = table.where(i)
        if serials and ground.item.serial and serials[i].strip() != ground.item.serial:
            what = f"the flip is of serial {serials[i]!r}, the ground model of {ground.item.serial!r}"
            do = "Leave out flips of other units, or give their ground model"
            raise DataError(what, where, "each head has a bias of its own", do, "wrong_serial")
        if axes[i] not in ground.axes:
            what = f"axis {axes[i]!r}: the ground model has {', '.join(ground.axes)}"
            raise DataError(what, where, do="Correct the axis", code="wrong_value")
        if math.isnan(bias[i]):
            continue
        if not (u[i] > 0.0 and math.isfinite(temperature[i])):
            what = f"flip of {axes[i]} in flight {flights[i]}: uncertainty {u[i]:g}, temperature {temperature[i]:g}"
            raise DataError(what, where, "a flip counts by its uncertainty, and shifts the bias at its temperature",
                            "Give both; flip prints the uncertainty", "wrong_value")  # fmt: skip
        value = float(source.in_si(bias[i : i + 1], said.unit, axes[i])[0])
        size = float(u[i]) * (per_u if per_u is not None else abs(source.factor(said.unit, axes[i])))
        free = float(dof[i]) if math.isfinite(dof[i]) and dof[i] > 0.0 else math.inf
        time = instant(dates[i], "date", where)
        yield Flip(flights[i].strip(), time, axes[i], float(temperature[i]), value, size, free, where)


def _of_one_date(plan: Plan, made: Readings) -> None:
    """Refuse flips of one flight more than a year apart: they are of two flights."""
    for flight in made.flights:
        times = [one.time for one in made.flips if one.flight == flight]
        if max(times) - min(times) > 366 * 86_400 * SECOND:
            what = f"flips of flight {flight} are more than a year apart"
            where = next(one.where for one in made.flips if one.flight == flight)
            do = "Give each flight a name of its own, or correct the dates"
            raise DataError(what, where, "each flight has a shift of its own", do, "flight_twice")


def _twice(plan: Plan, made: Readings) -> None:
    """Refuse a flight that stands in the table twice."""
    contents = {
        flight: sorted((one.axis, one.temperature, one.bias) for one in made.flips if one.flight == flight)
        for flight in made.flights
    }
    for one, other in combinations(contents, 2):
        if contents[one] == contents[other]:
            what = f"flights {one} and {other} have the same flips, to the last digit"
            where = next(flip.where for flip in made.flips if flip.flight == other)
            raise DataError(what, where, "one flight would count twice", "Leave one of them out", "flight_twice")
    seen: dict[tuple[str, str, int, float, float], str] = {}
    for flip in made.flips:
        key = (flip.flight, flip.axis, flip.time, flip.temperature, flip.bias)
        if key in seen:
            what = f"flip of {flip.axis} in flight {flip.flight} stands there twice"
            raise DataError(what, flip.where, f"the first is {seen[key]}", "Leave one of them out", "flight_twice")
        seen[key] = flip.where


def _older(plan: Plan, made: Readings) -> None:
    if plan.ground_date is None:
        return
    begin = instant(plan.ground_date, "ground_date")
    old = next((one for one in made.flips if one.time < begin), None)
    if old is not None:
        what = f"flight {old.flight} is older than the ground model, of {plan.ground_date}"
        do = "Leave it out, or correct the date of either"
        raise DataError(what, old.where, "what shifted before does not shift the model", do, "older_than_ground")


def _beyond(plan: Plan, made: Readings) -> None:
    ends = made.ground.temperature_range
    for one in made.flips if ends is not None else ():
        assert ends is not None  # noqa: S101 - as above
        if not ends[0] - DEGREE <= one.temperature <= ends[1] + DEGREE:
            what = f"flip of {one.axis} at {one.temperature:g} degC: the ground model holds from {ends[0]:g} "
            what += f"to {ends[1]:g} degC"
            why = "its bias at that temperature is not known, so neither is the shift"
            do = "Leave the flip out, or give a ground model that holds there"
            raise DataError(what, one.where, why, do, "outside_temperature_range")


def _as_ground(plan: Plan, made: Readings) -> None:
    """Refuse flips that another unit, the other sign or another axis would bring to the ground model."""
    temperatures = np.array([one.temperature for one in made.flips])
    every = ground_bias(made.ground, temperatures, plan.bias_of)
    for one, row in zip(made.flips, every, strict=True):
        own = float(row[made.ground.axes.index(one.axis)])
        off = abs(one.bias - own)
        if off <= FAR * abs(own):
            continue
        others = {axis: float(value) for axis, value in zip(made.ground.axes, row, strict=True) if axis != one.axis}
        causes = [
            *((abs(one.bias / times - own), "unit_mixed", f"a factor of {times:g} apart ({words}): units are mixed",
               "Give all flips in the unit that is stated") for times, words in UNITS.items()),
            (abs(one.bias + own), "wrong_sign", "of the other sign",
             "Check the direction of the axis in flight and on the ground"),
            *((abs(one.bias - value), "axes_exchanged", f"apart; it has {_ug(value)} for {axis}: axes are exchanged",
               "Check the column of axes") for axis, value in others.items()),
        ]  # fmt: skip
        left, code, words, do = min(causes)
        if left < NEAR * min(off, abs(own)):
            what = (
                f"flip of {one.axis} in flight {one.flight}: {_ug(one.bias)}, the ground model has {_ug(own)}: {words}"
            )
            raise DataError(what, one.where, "it would shift the model by the mistake", do, code)


def _ug(value: float) -> str:
    return f"{number(value * factor('m/s^2', 'ug'), 4)} ug"


def flights_of(plan: Plan, readings: Readings) -> tuple[Readings, Readings]:
    """Return the readings that are fitted, and those of later flights that are predicted.

    Raises
    ------
    PlanError
        ``unknown_name`` for a flight that is not there; ``nothing_left``.
    """
    if unknown := [one for one in plan.later if one not in readings.flights]:
        what = f"later: no flight {unknown[0]!r}"
        raise PlanError(what, do=f"There are: {', '.join(readings.flights)}", code="unknown_name")
    kept = tuple(one for one in readings.flips if one.flight not in plan.later)
    if not kept:
        raise PlanError("later: no flight is left to shift the model", do="Leave out fewer", code="nothing_left")
    rest = tuple(one for one in readings.flips if one.flight in plan.later)
    return Readings(kept, readings.ground, readings.remarks), Readings(rest, readings.ground)
