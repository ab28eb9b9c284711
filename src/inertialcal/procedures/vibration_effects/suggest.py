"""What looks like a gyro that rides on a shaker: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Mapping

from ...core.recording import Recording
from ...core.units import kind
from ...files.info.motion import gyros
from ...files.info.survey import Survey
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
from ..vibration.suggest import Shaken, shaken

REQUIREMENT = {"quantity": "vibration_rectification", "limit": "10 deg/h/g^2"}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``vibration effects`` of gyros beside the control of a random run."""
    one = shaken(recording)
    if one is None or not _rides(one):
        return None
    return Suggestion(("vibration effects",), Strength.STEPPED, options=one.options)


def _rides(one: Shaken) -> bool:
    return one.kind == "random" and one.rides and not one.item


def claims(file: FolderFile) -> Claim | None:
    """Claim such a record."""
    one = None if file.recording is None else shaken(file.recording)
    return None if one is None or not _rides(one) else Claim(Strength.STEPPED, lambda: (one, ()))


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensor, recordings and one test of them; along which axis each was vibrated is to be filled in."""
    runs = {file: one for file, one in contents.items() if isinstance(one, Shaken)}
    units = [c.unit for one in runs.values() for c in gyros(one.recording).values()
             if c.unit and kind(c.unit) == "angular_rate"]  # fmt: skip
    recordings: dict[str, object] = {}
    for number, (file, one) in enumerate(runs.items(), 1):
        control = one.recording.channel(one.controls[0])
        entry: dict[str, object] = {"column": control.name, "unit": control.unit or "?"}
        channels: dict[str, object] = {"control": entry if control.unit and one.named else fill_in(entry)}
        channels |= channel_tables(gyros(one.recording))
        recordings[f"ride{number}"] = recording_table("rider", file, one.recording, channels) | {"axis": fill_in("z")}
    test = {"id": "vibration_effects", "procedure": "vibration_effects", "recordings": list(recordings)}
    return Draft({"rider": sensor_table("gyro", units)}, recordings, [test], REQUIREMENT)
