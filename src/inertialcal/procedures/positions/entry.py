"""What a campaign says of a recording of positions: how the unit lay; or the columns of a table of rests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Protocol, cast

from pydantic import AfterValidator, Field

from ...core.errors import Problem
from ...core.key import AXES
from ...core.schema.quantities import Angle, Axis, Strict, Text, Unit
from ...core.units import kind
from ..entries import Entry, EntryKey, SaidSensor
from .orientations import FACES, LIKE, direction_of


def _orientation(text: str) -> str:
    if text != FACES and direction_of(text) is None:
        raise ValueError(f"{text!r} is not a position; there are: {LIKE}; or {FACES} alone")
    return text


Orientation = Annotated[str, AfterValidator(_orientation)]


class Rests(Strict):
    """rests = {...}: which column of a table is what; a row is a position of one sensor."""

    reading: dict[Axis, Text]
    unit: Unit
    scatter: dict[Axis, Text] | None = None
    samples: Text | None = None
    orientation: Text | None = None
    direction: dict[Axis, Text] | None = None


class PositionsEntry(Entry, Protocol):
    """A recording of a unit that was laid by hand."""

    @property
    def orientations(self) -> Sequence[str] | None:
        """How it lay, position by position."""
        ...

    @property
    def sections(self) -> str | None:
        """A file, or a column, of its labelled parts; or the label of the whole."""
        ...

    @property
    def rests(self) -> Rests | None:
        """Columns of a table."""
        ...

    @property
    def turn(self) -> float | None:
        """Angle of a turn [rad]."""
        ...


def _alone(orientations: Sequence[str]) -> str:
    both = FACES in orientations and list(orientations) != [FACES]
    return f'orientations: "{FACES}" stands alone, for all positions' if both else ""


KEYS = (
    EntryKey("orientations", Annotated[list[Orientation], Field(min_length=1)], alone=True, wrong=_alone),
    EntryKey("sections", Text, alone=True),
    EntryKey("turn", Angle),
    EntryKey("rests", Rests, table=True, apart=True, readings=lambda rests: list(rests.reading.values())),
)


def entry_problems(name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
    """Yield columns of a table that do not fit the sensor."""
    rests = cast("PositionsEntry", entry).rests
    if rests is None:
        return
    where, wanted = at("recordings", name, "rests"), kind(sensor.unit)
    if set(rests.reading) != set(AXES):
        what = f"recordings.{name}: rests.reading names {', '.join(rests.reading)}: positions need three axes"
        yield Problem(what, where, code="wrong_value")
    counted = kind(rests.unit) in ("count", "voltage") and sensor.chain.scale_factor is not None
    if kind(rests.unit) != wanted and not counted:
        yield Problem(f"recordings.{name}: unit {rests.unit!r}, need a unit of {wanted}", where, code="wrong_value")
    if sensor.mounting is not None:
        what = f"recordings.{name}: the sensor has a mounting, which is for recordings of channels"
        yield Problem(what, where, do="Give the table in body axes", code="wrong_value")
