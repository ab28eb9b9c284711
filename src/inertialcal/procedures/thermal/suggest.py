"""What looks like a test over temperature: the command to type next, a draft of the test."""

from __future__ import annotations

from collections.abc import Mapping

from ...core.batches import extremes
from ...core.campaign_text import Noted
from ...core.key import AXES, Kind
from ...core.recording import Channel, Recording
from ...core.units import kind
from ...files.info.motion import accelerometers, gyros
from ...files.info.survey import Survey
from ...files.text.headers import is_set_point
from ..given import KIND_OF_UNIT
from ..suggestions import (
    Claim,
    Draft,
    FolderFile,
    Strength,
    Suggestion,
    channel_tables,
    fill_in,
    recording_table,
    sensor_table,
)

SWING = 10.0  # change of the temperature that nobody makes by accident [K]
REQUIREMENT = {"quantity": "bias", "limit": "0.5 deg/s", "where": "temperature >= -20 degC and temperature <= 60 degC"}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``thermal`` where sensors were read while their temperature was made to change."""
    if not _is_warmed(recording):
        return None
    clear = not isinstance(_temperatures(recording).get("temperature"), Noted)
    return Suggestion(("thermal",), Strength.LIKELY, options="" if clear else "--column temperature=COLUMN")


def claims(file: FolderFile) -> Claim | None:
    """Claim a recording of sensors whose temperature was made to change, and of no rate that was applied."""
    recording = file.recording
    if recording is None or file.columns.applied or not _is_warmed(recording):
        return None
    return Claim(Strength.LIKELY, lambda: (recording, ()))


def _is_warmed(recording: Recording) -> bool:
    warm = [one for one in recording.channels if one.unit is not None and kind(one.unit) == "temperature"]
    read = [one for one in recording.channels if one.axis and one.quantity in ("gyro", "acc")]
    return bool(read) and any(_swing(one) > SWING for one in warm)


def _swing(channel: Channel) -> float:
    low, high = extremes(channel.data)
    return high - low if high > low else 0.0


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensors, recordings and tests over temperature, by file: a sensor and a test of each kind."""
    recordings = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    sensors: dict[str, object] = {}
    entries: dict[str, object] = {}
    tests: list[object] = []
    kinds: tuple[Kind, ...] = ("gyro", "accelerometer")
    for sensor in kinds:
        of_sensor = gyros if sensor == "gyro" else accelerometers
        channels = {file: own for file, one in recordings.items() if (own := of_sensor(one))}
        if not channels:
            continue
        units = [c.unit for own in channels.values() for c in own.values()]
        known = [unit for unit in units if unit and kind(unit) == KIND_OF_UNIT[sensor]]
        axes = [axis for axis in AXES if any(axis in own for own in channels.values())]
        name = f"warmed_{sensor}"
        sensors[name] = sensor_table(sensor, known) | {"axes": axes}
        for number, (file, own) in enumerate(channels.items(), 1):
            warm = _temperatures(recordings[file])
            entries[f"{name}{number}"] = recording_table(name, file, recordings[file], channel_tables(own) | warm)
        tests.append({"id": f"thermal_{sensor}", "procedure": "thermal",
                      "recordings": [f"{name}{number}" for number in range(1, len(channels) + 1)]})  # fmt: skip
    standard = Noted({"temperature": {"u": "0.5 K", "certificate": "..."}}, example=True)
    return Draft(sensors, entries, tests, REQUIREMENT, {"thermometer": standard})


def _temperatures(recording: Recording) -> dict[str, object]:
    """Return the channel of the temperature, or one each; what is not clear is marked."""
    warm = [one for one in recording.channels if one.unit and kind(one.unit) == "temperature"]
    warm = [one for one in warm if not is_set_point(one.name)] or warm
    if len(warm) == 1:
        return {"temperature": {"column": warm[0].name, "unit": warm[0].unit}}
    by_axis: dict[str, object] = {f"temperature_{one.axis}": {"column": one.name, "unit": one.unit}
                                  for one in warm if one.axis}  # fmt: skip
    if len(by_axis) == len(warm):
        return by_axis
    largest = max(warm, key=_swing)
    return {"temperature": fill_in({"column": largest.name, "unit": largest.unit})}
