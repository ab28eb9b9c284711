"""What looks like a record for a test of noise: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ...core.campaign_text import MARK, quoted
from ...core.recording import Channel, Recording
from ...core.units import kind
from ...files.info.channel_survey import survey_channel
from ...files.info.hints import unit_hints
from ...files.info.motion import SHORT, accelerometers, any_accelerometers, gyros
from ...files.info.survey import Survey
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion

REQUIREMENT = '# [[requirements]]\n# id = "R1"\n# quantity = "angle_random_walk"\n# upper = "0.3 deg/sqrt(h)"\n'
KINDS = {"gyro": ("gyros", "angular_rate"), "accelerometer": ("accelerometers", "acceleration")}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``allan``, or the spectrum, of a record at rest that is long enough."""
    if len(recording) < SHORT or any(remark.code == "not_at_rest" for remark in survey.remarks):
        return None
    return Suggestion(("allan", "psd"), Strength.POSSIBLE, in_campaign=True)


def claims(file: FolderFile) -> Claim | None:
    """Claim a recording at rest, unless it says a rate that was applied, or is of a head of accelerometers alone."""
    recording = file.recording
    if recording is None:
        return None
    own = not file.columns.applied if gyros(recording) else not accelerometers(recording)
    return Claim(Strength.POSSIBLE, lambda: (recording, ())) if own and file.at_rest else None


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensors, recordings and tests of recordings at rest, by file."""
    recordings = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    return Draft((*_parts("gyro", recordings), *_parts("accelerometer", recordings)), REQUIREMENT, example=False)


def _parts(sensor: str, recordings: Mapping[str, Recording]) -> list[str]:
    channels = {file: gyros(one) if sensor == "gyro" else any_accelerometers(one) for file, one in recordings.items()}
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
