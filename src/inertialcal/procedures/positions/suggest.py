"""What looks like a unit laid by hand: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...core.axes import AXES
from ...core.campaign_text import MARK, quoted
from ...core.recording import Channel, Recording
from ...core.units import factor, kind
from ...files.info.motion import accelerometers, gyros, is_laid, triad
from ...files.info.survey import Survey
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion

SENSORS = {"acc": ("accelerometer", "acceleration"), "gyro": ("gyro", "angular_rate")}
REQUIREMENT = '# [[requirements]]\n# id = "R1"\n# quantity = "transition_error"\n# upper = "0.5 deg"\n'
SITE = f'[site]\n# latitude = "48 deg"\n# height = "300 m"\ngravity = "9.80665 m/s2"  {MARK}\n'
GRAVITY = 0.5  # least that an axis feels of it, in any position of a triad [g]


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``positions`` where a triad of accelerometers was moved, and feels gravity."""
    if not any(remark.code == "not_at_rest" for remark in survey.remarks):
        return None
    sizes = [float(np.max(np.abs(one.data))) * factor(one.unit or "", "g") for one in triad(recording)]
    laid = len(sizes) == len(AXES) and max(sizes) > GRAVITY
    return Suggestion(("positions",), Strength.POSSIBLE) if laid else None


def claims(file: FolderFile) -> Claim | None:
    """Claim a recording in many orientations that says no rate that was applied."""
    recording = file.recording
    if recording is None or file.columns.applied or not is_laid(recording):
        return None
    return Claim(Strength.LIKELY, lambda: (recording, ()))


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensors, recordings and tests of a unit that was laid by hand, by file."""
    recordings = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    channels = {sensor: {file: _of(sensor, one) for file, one in recordings.items()} for sensor in SENSORS}
    have = [sensor for sensor, by_file in channels.items() if all(len(own) == 3 for own in by_file.values())]
    names = {file: f"hand{number}" for number, file in enumerate(recordings, 1)}
    parts = (
        SITE,
        "# Uncertainties of the standards: without them the results are relative to the fixture.\n"
        '# [standards.gravity]\n# value = { u = "0.001 m/s2", certificate = "..." }\n'
        '# [standards.clock]\n# rate = { u = "50 ppm", certificate = "..." }\n',
        *(_sensor(sensor, channels[sensor]) for sensor in have),
        *(
            _entry(f"{sensor}_{names[file]}", sensor, file, one, channels[sensor][file])
            for file, one in recordings.items()
            for sensor in have
        ),
        *_tests(have, list(names.values())),
    )
    return Draft(parts, REQUIREMENT)


def _of(sensor: str, recording: Recording) -> dict[str, Channel]:
    return accelerometers(recording) if sensor == "acc" else gyros(recording)


def _sensor(sensor: str, by_file: Mapping[str, Mapping[str, Channel]]) -> str:
    word, quantity = SENSORS[sensor]
    units = [c.unit for own in by_file.values() for c in own.values() if c.unit and kind(c.unit) == quantity]
    unit = f"unit = {quoted(units[0])}" if units else f'unit = "?"  {MARK}'
    chain = '# chain = { kind = "adc", lsb = "...", counts = [0, 65535], scale_factor = "..." }\n'
    return f'[sensors.{sensor}]\nkind = "{word}"\naxes = ["x", "y", "z"]\n{unit}\n{chain}'


def _entry(name: str, sensor: str, file: str, recording: Recording, channels: Mapping[str, Channel]) -> str:
    column = recording.time_column
    clock = f"clock = {{ column = {quoted(column)} }}\n" if column else ""
    each = [f"{axis} = {{ column = {quoted(c.name)}, unit = {quoted(c.unit or '?')} }}" for axis, c in channels.items()]
    mark = "" if all(c.unit for c in channels.values()) else f"  {MARK}"
    return (
        f"[recordings.{name}]\nsensor = {quoted(sensor)}\nfile = {quoted(file)}\n{clock}"
        f"channels = {{ {', '.join(each)} }}{mark}\n"
    )


def _tests(sensors: Sequence[str], names: Sequence[str]) -> list[str]:
    """Return a test of all sensors; of several recordings the last one is held out."""
    fitted, held = (names[:-1], names[-1:]) if len(names) > 1 else (names, ())
    found = []
    for name, use, own in (("imu", "fit", fitted), ("imu_held_out", "hold_out", held)):
        if own and sensors:
            listed = ", ".join(quoted(f"{sensor}_{one}") for one in own for sensor in sensors)
            found.append(f'[[tests]]\nid = "{name}"\nprocedure = "positions"\nrecordings = [{listed}]\nuse = "{use}"\n')
    return found
