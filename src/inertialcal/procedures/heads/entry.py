"""Key of a recording's entry for a head: the file of its body, and its name there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, cast

from ...core.errors import Problem
from ...core.schema.quantities import Strict, Text
from ..entries import Entry, EntryKey, SaidTest


class Head(Strict):
    """head = {...}: the TOML file of the body, and the name of the head there; that of the recording if not given."""

    file: Text
    name: Text | None = None


class HeadEntry(Entry, Protocol):
    """A recording of a head."""

    @property
    def head(self) -> Head | None:
        """Where its body is described."""
        ...


KEYS = (EntryKey("head", Head, file=lambda head: head.file),)


def recording_problems(test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
    """Yield a recording of a head without its body; a gyro needs none."""
    sensor = test.sensors.get(entry.sensor)
    if cast("HeadEntry", entry).head is None and (sensor is None or sensor.kind == "accelerometer"):
        what = f"recordings.{name}: which head it is of is not said"
        why = "positions and orientations of all heads are needed"
        yield Problem(what, test.at("recordings", name), why, 'Add head = { file = "body.toml" }', "missing_key")
