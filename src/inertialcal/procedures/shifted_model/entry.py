"""Key of a table of flips in a campaign: which column is what, and the ground model."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, cast

from ...core.errors import Problem
from ...core.schema.quantities import Strict, Text, Unit
from ...core.units import kind
from ..entries import Entry, EntryKey, SaidSensor


class Flips(Strict):
    """flips = {...}: which column of a table of flips is what; a row is one flip of one axis. ``file``: the model."""

    file: Text
    flight: Text
    date: Text
    axis: Text
    temperature: Text
    bias: Text
    u: Text
    unit: Unit
    dof: Text | None = None
    serial: Text | None = None


class FlipsEntry(Entry, Protocol):
    """A table of flips."""

    @property
    def flips(self) -> Flips | None:
        """Columns of the table, and the ground model."""
        ...


KEYS = (EntryKey("flips", Flips, table=True, file=lambda flips: flips.file),)


def entry_problems(name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
    """Yield biases in a unit of another kind."""
    flips = cast("FlipsEntry", entry).flips
    if flips is not None and kind(flips.unit) != kind(sensor.unit):
        what = f"recordings.{name}: biases in {flips.unit!r}, need a unit of {kind(sensor.unit)}"
        yield Problem(what, at("recordings", name, "flips"), code="wrong_value")
