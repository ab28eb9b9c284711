"""Keys of a flip's recordings in a campaign: columns of reduced means, positions of the head."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Protocol, cast

from pydantic import Field, field_validator

from ...core.errors import Problem
from ...core.schema.quantities import Angle, Strict, Text, Unit
from ...core.units import kind
from ..entries import Entry, EntryKey, SaidSensor, SaidTest


class Means(Strict):
    """means = {...}: which column of a table of reduced means is what; a row is the mean of one axis in one dwell."""

    axis: Text
    position: Text
    mean: Text
    unit: Unit
    angles: dict[Text, Angle]
    flip: Text | None = None
    temperature: Text | None = None
    predicted: Text | None = None
    half_widths: dict[Text, Text] = Field(default={})

    @field_validator("half_widths")
    @classmethod
    def _probabilities(cls, given: dict[str, str]) -> dict[str, str]:
        for text in given:
            if not re.fullmatch(r"0?\.\d{1,9}", text):
                raise ValueError(f'half_widths: {text!r} is no probability: write it like "0.95"')
        return given


class Position(Strict):
    """An entry of ``positions``: when a head stood still, and how it was turned then."""

    start: str | int | float
    stop: str | int | float
    angle: Angle
    flip: Text = "1"


class Dwells(Strict):
    """dwells = {...}: a table of the positions of a recording, a row a dwell; rows without a dwell are none."""

    file: Text
    start: Text = "start"
    stop: Text = "stop"
    angle: Text = "angle"
    unit: Unit = "deg"
    dwell: Text | None = None
    flip: Text | None = None


class FlipEntry(Entry, Protocol):
    """A recording of a turned head."""

    @property
    def means(self) -> Means | None:
        """Columns of a table of reduced means."""
        ...

    @property
    def positions(self) -> Sequence[Position] | None:
        """How the head was turned, and when."""
        ...

    @property
    def dwells(self) -> Dwells | None:
        """The same, as a table."""
        ...


KEYS = (
    EntryKey("means", Means, table=True, readings=lambda means: [means.mean], run=lambda means: means.flip),
    EntryKey("positions", Annotated[list[Position], Field(min_length=1)]),
    EntryKey("dwells", Dwells, file=lambda dwells: dwells.file),
)


def test_problems(test: SaidTest) -> Iterator[Problem]:
    """Yield windows of a test: they would have no effect."""
    if test.windows is not None:
        what = f"test {test.id!r}: windows, but a flip takes the positions of its recordings, or groups"
        where = test.at("tests", test.number, "windows")
        yield Problem(what, where, "they would have no effect", "Leave them out", "wrong_value")


def recording_problems(test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
    """Yield a recording without positions of the head."""
    own = cast("FlipEntry", entry)
    if own.positions is not None and own.dwells is not None:
        what, do = f"recordings.{name}: positions and dwells both say how the head was turned", "Give one of them"
        yield Problem(what, test.at("recordings", name), do=do, code="wrong_value")
    if entry.channels is not None and own.positions is None and own.dwells is None:
        what = f"recordings.{name}: positions of the head are not given"
        do = 'Give positions = [{ start = ..., stop = ..., angle = "ANGLE deg" }, ...]'
        yield Problem(what, test.at("recordings", name), do=do, code="missing_key")


def entry_problems(name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
    """Yield means in a unit of another kind: counts and volts need a chain that takes them."""
    means = cast("FlipEntry", entry).means
    if means is None or kind(means.unit) == kind(sensor.unit):
        return
    takes = {"adc": ("count", "voltage"), "output": ("count", "voltage")}.get(sensor.chain.kind, ())
    if kind(means.unit) not in takes:
        what = f"recordings.{name}: means in {means.unit!r}, need a unit of {kind(sensor.unit)}"
        do = "Counts and volts need the chain of the sensor" if kind(means.unit) in {"count", "voltage"} else ""
        yield Problem(what, at("recordings", name, "means"), do=do, code="wrong_value")
