"""Keys of a recording's entry for a moved mass: columns of reduced runs, schedule of the mass."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, cast

from pydantic import Field

from ...core.errors import DataError, Problem
from ...core.schema.quantities import Strict, Text, Unit
from ...core.units import divide, kind, parse_quantity, same_dimension, si_unit
from ..entries import Entry, EntryKey, SaidSensor, SaidTest


class Lines(Strict):
    """lines = {...}: columns of a table of reduced runs; a row is a run with a moved mass."""

    run: Text
    applied: Text
    applied_unit: Unit
    response: Text
    noise: Text
    unit: Unit
    beside: int = Field(default=8, gt=0)
    psd_response: Text | None = None
    psd_noise: Text | None = None
    scatter: Text | None = None
    moved: Text | None = None
    u_applied: str | None = None


class MovedMass(Strict):
    """mass = {...}: schedule of the mass that moves during a recording, and its begin."""

    schedule: Text
    begin: str | int | float | None = None
    moved: bool = True


class MassEntry(Entry, Protocol):
    """A recording with a moved mass."""

    @property
    def lines(self) -> Lines | None:
        """Columns of a table of reduced runs."""
        ...

    @property
    def mass(self) -> MovedMass | None:
        """Schedule of the mass."""
        ...


KEYS = (
    EntryKey("lines", Lines, table=True, readings=lambda lines: [lines.response, lines.noise]),
    EntryKey("mass", MovedMass, file=lambda mass: mass.schedule),
)


def recording_problems(test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
    """Yield a recording without a schedule of the mass, and a scale factor at high g of another output."""
    if entry.channels is not None and cast("MassEntry", entry).mass is None:
        what = f"recordings.{name}: schedule of the mass missing"
        do = 'Add mass = { schedule = "schedule.csv" }'
        yield Problem(what, test.at("recordings", name), do=do, code="missing_key")
    sensor, high_g = test.sensors.get(entry.sensor), test.plan.get("high_g")
    if sensor is not None and isinstance(high_g, dict) and isinstance(said := high_g.get("scale_factor"), str):
        output = _output_unit(sensor)
        if not same_dimension(parse_quantity(said).unit, divide(output, "m/s^2")):
            what = f"test {test.id!r}: plan.high_g.scale_factor = {said!r} is not in {output}, what the sensor gives"
            do = f"Give it in {divide(output, 'g')}"
            where = test.at("tests", test.number, "plan", "high_g")
            yield Problem(what, where, do=do, code="wrong_value")
    if test.windows is not None:
        what = f"test {test.id!r}: windows, but the schedule says which part of a run is read"
        where = test.at("tests", test.number, "windows")
        yield Problem(what, where, "they would have no effect", "Remove them", "wrong_value")


def _output_unit(sensor: SaidSensor) -> str:
    """Return the unit of what leaves a sensor; SI where its readings are in units of input."""
    chain, factors = sensor.chain, sensor.chain.scale_factor
    text = str(next(iter(factors.values())) if isinstance(factors, dict) else factors)
    if chain.kind == "output" and same_dimension(parse_quantity(text).unit, "count/(m/s^2)"):
        return "count"
    return {"none": si_unit(sensor.unit), "pulse_rate": "count/s"}.get(chain.kind, "V")


def entry_problems(name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
    """Yield units of a table of reduced runs that do not fit."""
    lines = cast("MassEntry", entry).lines
    if lines is None:
        return
    where = at("recordings", name, "lines")
    if kind(lines.applied_unit) != "acceleration":
        what = f"recordings.{name}: applied in {lines.applied_unit!r}, not a unit of acceleration"
        yield Problem(what, where, code="wrong_value")
    if not any(same_dimension(lines.unit, one) for one in ("count/s", "V", "count", "m/s^2")):
        what = f"recordings.{name}: response in {lines.unit!r}, not in what a sensor gives"
        yield Problem(
            what, where, do="Write count/s for pulses a second; V, count or ug for others", code="wrong_value"
        )
    if lines.u_applied is not None:
        try:
            parse_quantity(lines.u_applied).to(lines.applied_unit, difference=True)
        except DataError as error:
            yield Problem(f"recordings.{name}.lines.u_applied: {error.problems[0].what}", where, code="wrong_value")
