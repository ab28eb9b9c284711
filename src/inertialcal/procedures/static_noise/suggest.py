"""What looks like a record for a test of noise: the command to type next, a draft of the tests."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import replace

from ...core.campaign_text import Noted
from ...core.recording import Channel, Recording
from ...core.units import kind
from ...files.info.channel_survey import unit_hints
from ...files.info.motion import SHORT, any_accelerometers, gyros, may_float
from ...files.info.survey import Survey
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion, channel_tables, recording_table, sensor_table

SENSED = {"gyro", "acc", ""}  # quantities of channels that may be a sensor's
REQUIREMENT = {"quantity": "angle_random_walk", "upper": "0.3 deg/sqrt(h)"}
KINDS = {"gyro": ("gyros", "angular_rate"), "accelerometer": ("accelerometers", "acceleration")}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``allan``, or the spectrum, of a record at rest that is long enough.

    Where no channel can be a sensor's by its name, one is named: such a file has nothing for a campaign.
    """
    if not any(one.quantity in SENSED for one in recording.channels):
        other = next((one.name for one in recording.channels if one.quantity not in ("time", "index")), None)
        named = f"--column {shlex.quote(other)}" if other is not None else ""
        return Suggestion(("allan", "psd"), Strength.POSSIBLE, options=named) if named else None
    if len(recording) < SHORT or any(remark.code == "not_at_rest" for remark in survey.remarks):
        return None
    return Suggestion(("allan", "psd"), Strength.POSSIBLE, in_campaign=True)


def claims(file: FolderFile) -> Claim | None:
    """Claim a recording at rest, unless it says a rate that was applied, or is of accelerometers alone that float."""
    recording = file.recording
    if recording is None:
        return None
    own = not file.columns.applied if gyros(recording) else not may_float(recording)
    return Claim(Strength.POSSIBLE, lambda: (recording, ())) if own and file.at_rest else None


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensors, recordings and tests of recordings at rest, by file."""
    recordings = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    sensors: dict[str, object] = {}
    entries: dict[str, object] = {}
    tests: list[object] = []
    for sensor, (name, quantity) in KINDS.items():
        of_sensor = gyros if sensor == "gyro" else any_accelerometers
        channels = {file: own for file, one in recordings.items() if (own := of_sensor(one))}
        if not channels:
            continue
        units = [c.unit for own in channels.values() for c in own.values() if c.unit and kind(c.unit) == quantity]
        sensors[name] = sensor_table(sensor, units)
        alike: dict[str, list[str]] = {}  # recordings by their axes: one test for those that have the same
        for number, (file, own) in enumerate(channels.items(), 1):
            alike.setdefault("".join(sorted(own)), []).append(f"{name}{number}")
            entries[f"{name}{number}"] = _entry(name, file, recordings[file], own)
        for axes, labels in alike.items():
            test = f"noise_{name}" if len(alike) == 1 else f"noise_{name}_{axes}"
            tests.append({"id": test, "procedure": "static_noise", "recordings": labels})
    return Draft(sensors, entries, tests, REQUIREMENT, example=False)


def _entry(sensor: str, file: str, recording: Recording, channels: Mapping[str, Channel]) -> Noted:
    """Return the table of a recording, below a comment on what is not said: the order of axes, units to confirm."""
    sure = all(c.axis for c in channels.values())
    said = [] if sure else ["the axes are taken in the order of the columns"]
    bare = [c for c in channels.values() if not c.unit]
    hints = unit_hints(replace(recording, channels=tuple(bare)))
    said += [f"the numbers suggest {one.unit}: {one.reason}" for one in hints if one.unit]
    table = recording_table(sensor, file, recording, channel_tables(channels, sure))
    return Noted(table, above=f"Please confirm: {'; '.join(said)}" if said else "")
