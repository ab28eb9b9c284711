"""Readings of a shifted ground model: flips of several flights, and the ground model that they shift.

What cannot be meant is refused by its cause: flips of another unit, older than the ground model, beyond its
temperatures, in a unit or with a sign that the ground model contradicts, or a flight that stands in the table twice.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import combinations
from pathlib import Path
from typing import cast

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.influence import influence_of
from ...core.key import AXES
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import factor, kind, si_unit
from ...files.models.model_file import load_model_file
from ...files.text.results_table import shared_columns
from ...files.text.table import Table
from ...sensors.ground.model import GroundModel
from ...sensors.model.equation import condition_columns, inverted, matrix_at, offset
from ...sensors.model.sensor_model import SensorModel
from ..corrections import BiasCorrection
from ..protocol import Correction, Source
from .entry import Flips, FlipsEntry
from .plan import Plan

FAR = 0.5  # of the bias of the ground model, by which a flip is off before a wrong unit or sign is looked for
NEAR = 0.2  # of that distance, to which it comes with the right one
UNITS = {  # factor between units of acceleration: what is then wrong
    1e-6: "g for ug", 1e6: "ug for g", 1e-3: "mg for ug, or g for mg", 1e3: "ug for mg, or mg for g",
    9.80665: "g for m/s2", 1.0 / 9.80665: "m/s2 for g",
}  # fmt: skip
ANEW = ("mounting", "power_up", "day")  # what draws the error of a standard anew for each flight
FRAME = "bias_of"  # column of a table
DEGREE = 0.5  # [degC]: beyond the temperature range of the ground model by no more than its last digit


@dataclass(frozen=True)
class Flip:
    """Bias of one axis from one flip, SI."""

    flight: str
    time: int  # [ns since 1970 UTC]
    axis: str
    temperature: float  # [degC]
    bias: float  # [m/s^2]
    u: float  # Of what is drawn anew for each flight [m/s^2]
    dof: float
    where: str = ""
    # Change of the bias for one standard uncertainty of each unknown that all flips share [m/s^2]; empty: as the
    # standards of the plan say
    shared: Mapping[str, float] = field(default_factory=dict[str, float])


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


def readings_from(plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
    """Return the flips of a test: of all tables, and of the flip tests that it is made of.

    Where the corrections are not known yet, as for a check, flips of recordings are left out.

    Raises
    ------
    DataError
        ``nothing_left``, ``no_flip``, ``no_temperature``, ``no_date``, ``no_ground_model``, ``frames_differ``,
        ``wrong_serial``, ``older_than_ground``, ``outside_temperature_range``, ``flight_twice``, ``unit_mixed``,
        ``wrong_sign``, ``axes_exchanged``, ``wrong_value``, ``models_differ``.
    """
    flips: list[Flip] = []
    remarks: list[Remark] = []
    grounds: list[SensorModel] = []
    for source in sources:
        said = cast("FlipsEntry", source.entry).flips
        ground = _ground_of(source) if said is None else source.read_file(said.file, read_ground)
        if grounds and (ground.item != grounds[0].item or not np.array_equal(ground.bias, grounds[0].bias)):
            what = f"{source.name} has another ground model than {sources[0].name}"
            raise DataError(what, source.file, "one new model is made of one", "Give the same", "models_differ")
        grounds.append(ground)
        if said is None:
            continue
        table = source.table()
        found = list(_rows(plan, source, table, said, ground))
        chosen = [one for one in found if source.groups is None or one.flight in source.groups]
        source.chose(len(chosen))
        flips += chosen
        remarks += [*table.remarks, *table.missing(said.bias)]
    recorded = [one for one in sources if not one.is_table]
    flips += _of_tests(plan, corrections, recorded)
    if not flips and not recorded:
        what = f"test {sources[0].test!r}: no flip is in its groups ({', '.join(sources[0].groups or ())})"
        raise DataError(what, code="nothing_left")
    flips.sort(key=lambda one: one.time)
    made = Readings(tuple(flips), grounds[0], tuple(remarks))
    if not flips:
        return made
    for check in (_of_one_date, _twice, _older, _beyond, _as_ground):
        check(plan, made)
    return made


def _ground_of(source: Source) -> SensorModel:
    """Return the ground model in the chain of a recording."""
    ground = source.ground
    if ground is None:
        what = f"recordings.{source.name}: its sensor has no ground model in its chain"
        do = 'Give the sensor chain = { model = "ground.json" }, so that flips have the bias along the axes of the head'
        raise DataError(what, source.file, "flips shift it", do, "no_ground_model")
    return ground


def _of_tests(plan: Plan, corrections: Sequence[Correction], sources: Sequence[Source]) -> Iterator[Flip]:
    """Yield what flip tests found, an axis each.

    A flight is a power-up: tests whose recordings say one ``run`` are of one flight, any other test is one itself. What
    a standard adds is shared by all flips, unless a mounting, a power-up or a day draws its error anew.
    """
    runs = {one.name: one.run for one in sources}
    if corrections and plan.bias_of == "sensor":
        what = 'bias_of = "sensor", but flips of recordings have the bias along the axes of the head'
        do = "Leave bias_of out"
        raise DataError(what, why="their readings are those after the ground model", do=do, code="frames_differ")
    for found in corrections:
        if not isinstance(found, BiasCorrection):
            continue
        if found.time is None:
            what = f"test {found.test!r}: its recording has no date"
            do = "Give a recording whose time column has dates, or the flip as a row of a table"
            raise DataError(what, "", "flights are told apart, and drift, by their dates", do, "no_date")
        named = {runs.get(name, "") for name in found.recordings}
        flight = (named.pop() if len(named) == 1 else "") or found.test
        estimate = found.estimate
        for i, key in enumerate(estimate.keys):
            if key.axis not in found.temperature:
                what = f"test {found.test!r}: temperature of {key.axis} not known"
                do = "Name the channel of the temperature in the recording"
                why = "the ground model has another bias at each temperature"
                raise DataError(what, "", why, do, "no_temperature")
            changes = estimate.shared(key)
            anew = {name for name in changes if _drawn_anew(plan, name)}
            scatter = [one.covariance[i, i] for one in estimate.components if not one.named_changes]
            u = math.sqrt(sum(scatter) + sum(changes[name] ** 2 for name in anew))
            yield Flip(
                flight, round(found.time * SECOND), key.axis, found.temperature[key.axis], float(estimate.values[i]), u,
                float(estimate.dof[i]), f"test {found.test}",
                {name: change for name, change in changes.items() if name not in anew and change},
            )  # fmt: skip
    absent = [] if not corrections else [name for name in runs if not any(
        name in one.recordings for one in corrections if isinstance(one, BiasCorrection))]  # fmt: skip
    if absent:
        what = f"recordings.{absent[0]}: no test in after found a bias with its uncertainty in it"
        do = "Look at that flip: it says why; or leave the recording out"
        raise DataError(what, "", "the flight would be missing without a word", do, "no_flip")


def _drawn_anew(plan: Plan, unknown: str) -> bool:
    standard = plan.standards.get(influence_of(unknown))
    return standard is not None and standard.redrawn_by in ANEW


def _rows(plan: Plan, source: Source, table: Table, said: Flips, ground: SensorModel) -> Iterator[Flip]:
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
    frames = set(table.text(FRAME)) - {plan.bias_of} if FRAME in table.names else set()
    if frames:
        what = f'the bias is that of the {frames.pop()}, bias_of = "{plan.bias_of}"'
        why = "scale factor and misalignment of the ground model lie between the two"
        do = "Flip with the ground model in the chain" if plan.bias_of == "head" else 'Set bias_of = "head"'
        do = f'{do}, or set bias_of = "sensor"' if plan.bias_of == "head" else do
        raise DataError(what, source.file, why, do, "frames_differ")
    dof = table.numbers(said.dof) if said.dof else np.full(len(table), math.inf)
    shared = {unknown: table.numbers(name) for name, unknown in shared_columns(table.names).items()}
    for i in range(len(table)):
        where = table.where(i)
        if serials and ground.item.serial and serials[i].strip() not in ("", ground.item.serial):
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
        own_unknowns = {name: float(column[i]) * abs(source.factor(said.unit, axes[i]))
                        for name, column in shared.items() if np.isfinite(column[i]) and column[i]}  # fmt: skip
        yield Flip(flights[i].strip(), time, axes[i], float(temperature[i]), value, size, free, where, own_unknowns)


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
