"""Readings of a test of positions: recordings of accelerometers and of gyros on one clock, each of its own sensor.

A test is about the sensor of its first recording; gyros need the accelerometers beside them. Recordings of both are
paired in their order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.axes import AXES, Kind
from ..core.errors import DataError, PlanError
from ..core.influence import Standards
from ..core.recording import Channel, Recording
from ..files.source import load
from ..files.text.table import read_table
from ..procedures.positions import reduction as positions
from ..procedures.positions.readings import Readings
from ..procedures.positions.recordings import Section, readings_from
from .channels import TEMPERATURE, prepare_recording, windowed
from .load import Campaign
from .modelling import Prepared
from .origins import Origin
from .plans import plan_values
from .positions_channels import check_clock
from .positions_site import site_problems
from .positions_sources import named_section, section_of
from .positions_words import FACES, of_words, runs_of, sections_of
from .positions_words import Section as Said
from .schema import CampaignFile, Test
from .schema_recordings import RecordingEntry
from .schema_sensors import Sensor

PREFIX: dict[Kind, str] = {"accelerometer": "acc", "gyro": "gyro"}


@dataclass(frozen=True, eq=False)
class Part:
    """A recording of one sensor, with its entry."""

    name: str
    entry: RecordingEntry
    recording: Recording
    whole: int
    kind: Kind


def prepared_positions(campaign: Campaign, test: Test, sensor: Sensor) -> Prepared:
    """Return a test of positions ready to be reduced.

    Raises
    ------
    PlanError, DataError
        If a recording cannot be read, or the plan; ``no_accelerometers``; ``clocks_differ``.
    """
    plan = positions_plan(campaign.file, campaign.standards, test)
    parts = [_part(campaign, name, test) for name in test.recordings]
    inputs = {one.entry.file: one.recording.source.sha256 for one in parts}
    origins = tuple(
        Origin(one.name, one.entry.file, one.recording.source.sha256, "recording", one.whole, len(one.recording))
        for one in parts
    )
    named = [one.entry.sections for one in parts if one.entry.sections is not None]
    inputs |= {name: load(campaign.folder / name).sha256 for name in named if (campaign.folder / name).is_file()}
    return Prepared(test, plan, readings_of(plan, parts, test.id, campaign.folder), inputs, origins)


def readings_of(
    plan: positions.Plan,
    parts: Sequence[Part],
    test: str,
    folder: Path,
    said: Mapping[str, Sequence[Said]] | None = None,
) -> Readings:
    """Return the readings of the recordings of a test.

    Parameters
    ----------
    plan : Plan
        Of the test.
    parts : sequence of Part
        Recordings of accelerometers, and of gyros, in body axes and SI.
    test : str
        Its name, for messages.
    folder : Path
        In which sections lie.
    said : mapping of str to sequence of Section, optional
        Sections that are no files, by the name that an entry gives them.

    Raises
    ------
    DataError
        As `prepared_positions`.
    """
    pairs = _paired(parts, test)
    joined = [_joined(pair) for pair in pairs]
    sections = [_sections(folder, pair, one, said or {}) for pair, one in zip(pairs, joined, strict=True)]
    faces = any(one.entry.orientations == [FACES] for one in parts)
    return _oriented(readings_from(plan, joined, sections, faces), parts)


def positions_plan(file: CampaignFile, standards: Standards, test: Test) -> positions.Plan:
    """Return the plan of a test, with what the site and the standards of the campaign say.

    Raises
    ------
    PlanError
        If a setting is wrong.
    """
    values, problems = plan_values(test.procedure, test.plan, "")
    if problems:
        raise PlanError(problems)
    place: dict[str, Any] = {"gravity": file.site.gravity, "height": file.site.height or 0.0} | values
    plan = positions.Plan(**place, latitude=file.site.latitude, standards=standards)
    if site_problems(plan):
        raise PlanError(site_problems(plan))
    return plan


def _part(campaign: Campaign, name: str, test: Test) -> Part:
    entry = campaign.file.recordings[name]
    sensor = campaign.file.sensors[entry.sensor]
    whole = prepare_recording(campaign.folder, name, entry, sensor)
    one = windowed(whole, test)
    one = replace(one, source=replace(one.source, path=entry.file))
    return Part(name, entry, one, len(whole), sensor.kind)


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
            what = f"recordings.{one.name}: no channel {', '.join(missing)}"
            raise DataError(what, one.entry.file, "positions need three axes", code="wrong_column")
        made += [replace(one.recording.channel(axis), name=f"{PREFIX[one.kind]}_{axis}") for axis in AXES]
    first = pair[0].recording
    made += [c for c in first.channels if c.name == TEMPERATURE]
    remarks = tuple(dict.fromkeys(remark for one in pair for remark in one.recording.remarks))
    return replace(first, channels=tuple(made), remarks=remarks)


def _sections(
    folder: Path, pair: Sequence[Part], recording: Recording, known: Mapping[str, Sequence[Said]]
) -> tuple[Section, ...]:
    """Return the labelled parts that an entry of a pair names; none where none does."""
    entry = next((one.entry for one in pair if one.entry.sections is not None), None)
    if entry is None or entry.sections is None:
        return ()
    turn = 2.0 * np.pi if entry.turn is None else entry.turn
    path = folder / entry.sections
    if entry.sections in known or path.is_file():
        found = known.get(entry.sections) or sections_of(path)
        return tuple(section_of(one, recording, turn) for one in found)
    said = runs_of(read_table(folder / entry.file).text(entry.sections))
    return tuple(named_section(one.label, round(one.start), round(one.stop), turn) for one in said)


def _oriented(readings: Readings, parts: Sequence[Part]) -> Readings:
    """Return the readings with the directions that the entries say, those of all recordings in a row.

    Raises
    ------
    DataError
        ``wrong_value`` if there are not as many as positions.
    """
    said = [one.entry.orientations for one in parts if one.entry.orientations not in (None, [FACES])]
    words = [word for one in said for word in one or ()]
    if not words:
        return readings
    found = of_words(words, parts[0].entry.file)
    if len(found) != len(readings):
        listed = ", ".join(readings.where[:12]) + (", ..." if len(readings) > 12 else "")
        what = f"{len(found)} orientations for {len(readings)} positions"
        do = 'Give one for each, "?" for one that is not known; or plan = { shortest = ... } for other rests'
        raise DataError(what, parts[0].entry.file, f"they were found at: {listed}", do, "wrong_value")
    return replace(readings, direction=found if np.isfinite(found).any() else None)
