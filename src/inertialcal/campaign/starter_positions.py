"""The part of a first campaign.toml that is about positions: recordings of an IMU that was laid by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..core.errors import InertialcalError
from ..core.recording import Channel, Recording
from ..core.units import kind
from ..procedures.flip.files.source import quoted
from ..signals.segmentation.segments import detect, static_intervals
from .file.load import MARK
from .starter_flip import accelerometers
from .starter_still import gyros

FEWEST = 6  # static intervals
SHORTEST = 1.0  # [s]
TURNED = 0.3  # of the largest reading at rest, by which the second widest direction of the readings spreads
SENSORS = {"acc": ("accelerometer", "acceleration"), "gyro": ("gyro", "angular_rate")}
REQUIREMENT = '# [[requirements]]\n# id = "R1"\n# quantity = "transition_error"\n# upper = "0.5 deg"\n'
SITE = f'[site]\n# latitude = "48 deg"\n# height = "300 m"\ngravity = "9.80665 m/s2"  {MARK}\n'


def is_laid(recording: Recording) -> bool:
    """Whether the accelerometers of a recording rest in many orientations, as of a unit that is laid by hand.

    Parameters
    ----------
    recording : Recording
        As read.
    """
    acc = accelerometers(recording)
    if recording.time_ns is None or len(acc) != 3:
        return False
    values = np.column_stack([np.asarray(acc[axis].data, dtype=np.float64) for axis in "xyz"])
    try:
        placed = static_intervals(detect(values, recording.time_ns, recording.sample_interval), min_duration=SHORTEST)
    except InertialcalError:
        return False
    if len(placed) < FEWEST:
        return False
    mean = np.array([one.mean for one in placed])
    spread = np.linalg.svd(mean - mean.mean(axis=0), compute_uv=False) / np.sqrt(len(mean))
    return bool(spread[1] > TURNED * np.linalg.norm(mean, axis=1).max())


def positions_parts(recordings: Mapping[str, Recording]) -> list[str]:
    """Return the texts of sensors, recordings and tests; what is not known is marked.

    Parameters
    ----------
    recordings : mapping of str to Recording
        Of a unit that was laid by hand, by file.
    """
    if not recordings:
        return []
    channels = {sensor: {file: _of(sensor, one) for file, one in recordings.items()} for sensor in SENSORS}
    have = [sensor for sensor, by_file in channels.items() if all(len(own) == 3 for own in by_file.values())]
    names = {file: f"hand{number}" for number, file in enumerate(recordings, 1)}
    return [
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
    ]


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
    """Return a test a sensor; of several recordings the last one is held out."""
    fitted, held = (list(names[:-1]), [names[-1]]) if len(names) > 1 else (list(names), [])
    found = []
    for use, own, ending in (("fit", fitted, ""), ("hold_out", held, "_held_out")):
        for sensor in sensors if own else ():
            others = [one for one in sensors if one != sensor] if sensor == "gyro" else []
            listed = ", ".join(quoted(f"{one}_{name}") for one in (sensor, *others) for name in own)
            found.append(
                f'[[tests]]\nid = "{sensor}{ending}"\nprocedure = "positions"\nrecordings = [{listed}]\nuse = "{use}"\n'
            )
    return found
