"""What a campaign says of a moved mass: columns of reduced runs, the schedule of the mass."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, cast

from pydantic import Field

from ...core.errors import DataError, Problem
from ...core.schema.quantities import Strict, Text, Unit
from ...core.units import kind, parse_quantity, same_dimension
from ..entries import Entry, EntryKey, SaidSensor, SaidTest


class Lines(Strict):
    """lines = {...}: which column of a table of reduced runs is what; a row is a run with a moved mass."""

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
    """mass = {...}: the schedule of the mass that is moved during a recording, and when it begins."""

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
        """Where the mass was, and when."""
        ...


KEYS = (
    EntryKey("lines", Lines, table=True),
    EntryKey("mass", MovedMass, file=lambda mass: mass.schedule),
)


def recording_problems(test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
    """Yield a recording without a schedule of the mass, or of a sensor that no pulses are counted of."""
    if entry.channels is not None and cast("MassEntry", entry).mass is None:
        what = f"recordings.{name}: nothing says where the mass was"
        do = 'Give mass = { schedule = "schedule.csv" }'
        yield Problem(what, test.at("recordings", name), do=do, code="missing_key")
    sensor = test.sensors.get(entry.sensor)
    if sensor is not None and entry.channels is not None and sensor.chain.kind != "pulse_rate":
        what = f"test {test.id!r}: a moved mass calibrates pulses a second, the chain is {sensor.chain.kind!r}"
        do = 'Give chain = { kind = "pulse_rate", gate = ..., scale_factor = ... }'
        yield Problem(what, test.at("sensors", entry.sensor, "chain"), do=do, code="wrong_value")
    if test.windows is not None:
        what = f"test {test.id!r}: windows, but a run is read where its schedule says"
        where = test.at("tests", test.number, "windows")
        yield Problem(what, where, "they would have no effect", "Leave them out", "wrong_value")


def entry_problems(name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
    """Yield units of a table of reduced runs that are of another kind."""
    lines = cast("MassEntry", entry).lines
    if lines is None:
        return
    where = at("recordings", name, "lines")
    if kind(lines.applied_unit) != "acceleration":
        what = f"recordings.{name}: applied in {lines.applied_unit!r}, need a unit of acceleration"
        yield Problem(what, where, code="wrong_value")
    if not same_dimension(lines.unit, "count/s"):
        what = f"recordings.{name}: response in {lines.unit!r}, need pulses a second"
        yield Problem(what, where, do="Write count/s", code="wrong_value")
    if lines.u_applied is not None:
        try:
            parse_quantity(lines.u_applied).to(lines.applied_unit, difference=True)
        except DataError as error:
            yield Problem(f"recordings.{name}.lines.u_applied: {error.problems[0].what}", where, code="wrong_value")
