"""Keys of a recording's entry for a moved mass: columns of reduced runs, schedule of the mass."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, cast

from pydantic import Field

from ...core.errors import DataError, Problem
from ...core.schema.quantities import Strict, Text, Unit
from ...core.units import kind, parse_quantity, same_dimension
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
    """Yield a recording without a schedule of the mass, or of a sensor that does not count pulses."""
    if entry.channels is not None and cast("MassEntry", entry).mass is None:
        what = f"recordings.{name}: schedule of the mass missing"
        do = 'Add mass = { schedule = "schedule.csv" }'
        yield Problem(what, test.at("recordings", name), do=do, code="missing_key")
    sensor = test.sensors.get(entry.sensor)
    if sensor is not None and entry.channels is not None and sensor.chain.kind != "pulse_rate":
        what = f"test {test.id!r}: mass_attraction needs pulses, the chain is of kind {sensor.chain.kind!r}"
        do = 'Set chain = { kind = "pulse_rate", gate = "GATE s" }'
        yield Problem(what, test.at("sensors", entry.sensor, "chain"), do=do, code="wrong_value")
    if test.windows is not None:
        what = f"test {test.id!r}: windows, but the schedule says which part of a run is read"
        where = test.at("tests", test.number, "windows")
        yield Problem(what, where, "they would have no effect", "Remove them", "wrong_value")


def entry_problems(name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
    """Yield units of a table of reduced runs that do not fit."""
    lines = cast("MassEntry", entry).lines
    if lines is None:
        return
    where = at("recordings", name, "lines")
    if kind(lines.applied_unit) != "acceleration":
        what = f"recordings.{name}: applied in {lines.applied_unit!r}, not a unit of acceleration"
        yield Problem(what, where, code="wrong_value")
    if not same_dimension(lines.unit, "count/s"):
        what = f"recordings.{name}: response in {lines.unit!r}, not in pulses a second"
        yield Problem(what, where, do="Write count/s", code="wrong_value")
    if lines.u_applied is not None:
        try:
            parse_quantity(lines.u_applied).to(lines.applied_unit, difference=True)
        except DataError as error:
            yield Problem(f"recordings.{name}.lines.u_applied: {error.problems[0].what}", where, code="wrong_value")
