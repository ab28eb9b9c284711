"""Readings of a test of positions: recordings of accelerometers and of gyros on one clock, each of its own sensor.

A test is about the sensor of its first recording; gyros need the accelerometers beside them. Recordings of both are
paired in their order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ...core.axes import AXES, Kind
from ...core.errors import DataError
from ...core.recording import Channel, Recording
from ..protocol import Source
from .entry import PositionsEntry
from .files.channels import check_clock
from .files.sources import named_section, section_of
from .orientations.text import FACES, of_words, runs_of, sections_of
from .plan import Plan
from .readings import Readings
from .recordings import Section, readings_from

TEMPERATURE = "temperature"
PREFIX: dict[str, str] = {"accelerometer": "acc", "gyro": "gyro"}


@dataclass(frozen=True, eq=False)
class Part:
    """A recording of one sensor, with where it comes from."""

    source: Source
    recording: Recording

    @property
    def kind(self) -> Kind | None:
        """Of its sensor."""
        return self.source.facts.kind


def readings_of(plan: Plan, sources: Sequence[Source]) -> Readings:
    """Return the readings of the recordings of a test.

    Raises
    ------
    DataError
        If a recording cannot be read; ``no_accelerometers``; ``clocks_differ``.
    """
    parts = [Part(one, recording) for one in sources for _, recording in one.recordings()]
    pairs = _paired(parts, sources[0].test)
    joined = [_joined(pair) for pair in pairs]
    sections = [_sections(pair, one) for pair, one in zip(pairs, joined, strict=True)]
    faces = any(_said(one).orientations == [FACES] for one in sources)
    return _oriented(readings_from(plan, joined, sections, faces), pairs)


def _paired(parts: Sequence[Part], test: str) -> list[list[Part]]:
    """Return each recording of accelerometers with that of the gyros of the same clock.

    Raises
    ------
    DataError
        ``no_accelerometers``, ``wrong_value`` if there are not as many of both.
    """
    acc = [one for one in parts if one.kind == "accelerometer"]
    gyro = [one for one in parts if one.kind == "gyro"]
    if not acc:
        do = "Add the recording of the accelerometers to recordings of the test"
        why = "gravity is what calibrates, and accelerometers feel it"
        raise DataError(f"test {test!r} has no recording of accelerometers", "", why, do, "no_accelerometers")
    if gyro and len(gyro) != len(acc):
        what = f"test {test!r}: {len(acc)} recording(s) of accelerometers and {len(gyro)} of gyros"
        raise DataError(what, why="they are paired in their order", do="Name as many of both", code="wrong_value")
    return [[one, other] for one, other in zip(acc, gyro, strict=True)] if gyro else [[one] for one in acc]


def _joined(pair: Sequence[Part]) -> Recording:
    """Return one recording with channels ``acc_x``, ..., ``gyro_z``, in SI."""
    check_clock([one.recording for one in pair])
    made: list[Channel] = []
    for one in pair:
        missing = [axis for axis in AXES if axis not in one.recording.names]
        if missing:
            what = f"recordings.{one.source.name}: no channel {', '.join(missing)}"
            raise DataError(what, one.source.file, "positions need three axes", code="wrong_column")
        made += [replace(one.recording.channel(axis), name=f"{PREFIX[str(one.kind)]}_{axis}") for axis in AXES]
    first = pair[0].recording
    made += [c for c in first.channels if c.name == TEMPERATURE]
    remarks = tuple(dict.fromkeys(remark for one in pair for remark in one.recording.remarks))
    return replace(first, channels=tuple(made), remarks=remarks)


def _said(source: Source) -> PositionsEntry:
    return cast("PositionsEntry", source.entry)


def _sections(pair: Sequence[Part], recording: Recording) -> tuple[Section, ...]:
    """Return the labelled parts that an entry of a pair names; none where none does."""
    source = next((one.source for one in pair if _said(one.source).sections is not None), None)
    if source is None:
        return ()
    entry = _said(source)
    named = str(entry.sections)
    turn = 2.0 * np.pi if entry.turn is None else entry.turn
    if source.has(named):
        return tuple(section_of(one, recording, turn) for one in source.read_file(named, sections_of))
    said = runs_of(source.table().text(named))
    return tuple(named_section(one.label, round(one.start), round(one.stop), turn) for one in said)


def _oriented(readings: Readings, pairs: Sequence[Sequence[Part]]) -> Readings:
    """Return the readings with the directions that the entries give, recording after recording.

    Raises
    ------
    DataError
        ``wrong_value`` if the entries of one recording differ, or there are not as many as positions.
    """
    words: list[str] = []
    for pair in pairs:
        each = [list(said) for one in pair if (said := _said(one.source).orientations) is not None]
        if any(one != each[0] for one in each):
            what = f"recordings {' and '.join(one.source.name for one in pair)} give different orientations"
            do = "Give them once"
            raise DataError(what, pair[0].source.file, "the unit lay in one way", do, "wrong_value")
        words += each[0] if each and each[0] != [FACES] else []
    if not words:
        return readings
    where = pairs[0][0].source.file
    found = of_words(words, where)
    if len(found) != len(readings):
        listed = ", ".join(readings.where[:12]) + (", ..." if len(readings) > 12 else "")
        what = f"{len(found)} orientations for {len(readings)} positions"
        do = 'Give one for each, "?" for one that is not known; or plan = { shortest = ... } for other rests'
        raise DataError(what, where, f"they were found at: {listed}", do, "wrong_value")
    return replace(readings, direction=found if np.isfinite(found).any() else None)
