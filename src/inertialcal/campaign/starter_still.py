"""The part of a first campaign.toml that is about sensors at rest: tests of their noise."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..core.axes import AXES
from ..core.recording import Channel, Recording
from ..core.units import kind
from ..files.info.channel_survey import survey_channel
from ..files.info.hints import unit_hints
from ..procedures.flip.files.source import quoted
from ..signals.segmentation.stillness import judge
from .file.load import MARK
from .starter_flip import accelerometers

SHORT = 1_000  # samples: a shorter record says little about noise, and may be a dwell
APART = 20.0  # standard deviations: levels of files that differ by more were turned at different rates
REQUIREMENT = '# [[requirements]]\n# id = "R1"\n# quantity = "angle_random_walk"\n# upper = "0.3 deg/sqrt(h)"\n'
KINDS = {"gyro": ("gyros", "angular_rate"), "accelerometer": ("accelerometers", "acceleration")}


def gyros(recording: Recording) -> dict[str, Channel]:
    """Return the gyro channels by axis: three whose axes nobody said in their order, which is to be confirmed.

    Parameters
    ----------
    recording : Recording
        As read.
    """
    found = [c for c in recording.channels if c.quantity == "gyro"]
    return {c.axis: c for c in found if c.axis in AXES} or _in_order(found)


def _accelerometers(recording: Recording) -> dict[str, Channel]:
    return accelerometers(recording) or _in_order([c for c in recording.channels if c.quantity == "acc"])


def _in_order(channels: Sequence[Channel]) -> dict[str, Channel]:
    """Return three channels as x, y and z, in the order of the file; none where there are not three."""
    return dict(zip(AXES, channels, strict=True)) if len(channels) == len(AXES) else {}


def is_still(recording: Recording) -> bool:
    """Whether the gyros of a recording, or else its accelerometers, stand still long enough to tell of their noise.

    Parameters
    ----------
    recording : Recording
        As read.
    """
    if recording.time_ns is None or len(recording) < SHORT:
        return False
    channels = gyros(recording) or _accelerometers(recording)
    values = [one.data.astype(np.float64) for one in channels.values()]
    judged = [judge(one[np.isfinite(one)]) for one in values]
    found = [one.at_rest for one in judged if one is not None]
    return bool(found) and all(found)


def of_one_level(recordings: Collection[Recording]) -> bool:
    """Whether recordings at rest have the same level: else each is a dwell at a rate of its own.

    Parameters
    ----------
    recordings : collection of Recording
        At rest.
    """
    for axis in AXES:
        values = [one[axis].data.astype(np.float64) for one in map(gyros, recordings) if axis in one]
        if values:
            levels = [float(np.nanmedian(one)) for one in values]
            if max(levels) - min(levels) > APART * max(float(np.nanstd(one)) for one in values):
                return False
    return True


def still_parts(recordings: Mapping[str, Recording]) -> list[str]:
    """Return the texts of sensors, recordings and tests; what is not known is marked.

    Parameters
    ----------
    recordings : mapping of str to Recording
        At rest, by file.
    """
    return [*_parts("gyro", recordings), *_parts("accelerometer", recordings)]


def _parts(sensor: str, recordings: Mapping[str, Recording]) -> list[str]:
    channels = {file: gyros(one) if sensor == "gyro" else _accelerometers(one) for file, one in recordings.items()}
    taken = {file: one for file, one in channels.items() if one}
    if not taken:
        return []
    name, quantity = KINDS[sensor]
    units = [c.unit for one in taken.values() for c in one.values() if c.unit and kind(c.unit) == quantity]
    unit = f"unit = {quoted(units[0])}" if units else f'unit = "?"  {MARK}'
    own = {f"{name}{number}": file for number, file in enumerate(taken, 1)}
    return [
        f'[sensors.{name}]\nkind = "{sensor}"\naxes = ["x", "y", "z"]\n{unit}\n',
        *(_entry(label, name, file, recordings[file], taken[file]) for label, file in own.items()),
        *_tests(name, {label: "".join(sorted(taken[file])) for label, file in own.items()}),
    ]


def _tests(name: str, axes: Mapping[str, str]) -> Iterator[str]:
    """Yield a test of all recordings that have the same axes."""
    alike: dict[str, list[str]] = {}
    for label, own in axes.items():
        alike.setdefault(own, []).append(label)
    for own, labels in alike.items():
        test = f"noise_{name}" if len(alike) == 1 else f"noise_{name}_{own}"
        listed = ", ".join(map(quoted, labels))
        yield f'[[tests]]\nid = "{test}"\nprocedure = "static_noise"\nrecordings = [{listed}]\n'


def _entry(label: str, sensor: str, file: str, recording: Recording, channels: Mapping[str, Channel]) -> str:
    column = recording.time_column
    clock = f"clock = {{ column = {quoted(column)} }}\n" if column else ""
    each = [f"{axis} = {{ column = {quoted(c.name)}, unit = {quoted(c.unit or '?')} }}" for axis, c in channels.items()]
    sure = all(c.unit and c.axis for c in channels.values())
    return (
        f"{_hint(recording, channels)}[recordings.{label}]\nsensor = {quoted(sensor)}\nfile = {quoted(file)}\n{clock}"
        f"channels = {{ {', '.join(each)} }}{'' if sure else f'  {MARK}'}\n"
    )


def _hint(recording: Recording, channels: Mapping[str, Channel]) -> str:
    """Return a line on what is not said: the order of axes, and a unit with what the numbers suggest."""
    said = []
    if not all(c.axis for c in channels.values()):
        said.append("axes in the order of the columns")
    bare = [c for c in channels.values() if not c.unit]
    hints = unit_hints(replace(recording, channels=tuple(bare)), [survey_channel(c) for c in bare])
    said += [f"{one.unit}, as the numbers suggest: {one.reason}" for one in hints if one.unit]
    return f"# To be confirmed: {'; '.join(said)}.\n" if said else ""
