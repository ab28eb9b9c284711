"""What a file of a survey is: axes of the sensor that rides on the table, and control accelerometers by their names."""

from __future__ import annotations

from dataclasses import replace

from ...core.errors import UsageError
from ...core.key import AXES
from ...core.recording import Recording
from ...files.text.headers import bare_name
from ..given import Described, GivenFile
from ..given import described as described_channels
from ..protocol import InputSpec
from .plan import CONTROL

GENERAL = "channel_"  # before the name of a channel of UFF 58
OVER_FREQUENCY = ("freq",)  # names of the first column of a transfer function
BEGINS = ("control", "ctrl", "ctl")  # names of control channels, and a number behind them


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return a recording of a sensor on a shaker; control channels as they are given, or by their names.

    Raises
    ------
    UsageError
        ``no_column`` where it is not clear which channel is the control, ``over_frequency``, ``too_many``, ``no_unit``.
    """
    columns = dict(given.said.columns)
    control = given.own.get("control") or ()
    said = [control] if isinstance(control, str) else list(control)
    if len(said) > len(CONTROL):
        what = f"{given.name}: {len(said)} control channels, {len(CONTROL)} at most"
        raise UsageError(what, do="Name those that the table was controlled by", code="too_many")
    for role, name in zip(CONTROL, said, strict=False):
        columns.setdefault(role, str(name))
    if CONTROL[0] not in columns:
        free = [name for name in controls(given.recording) if name not in columns.values()]
        columns |= dict(zip(CONTROL, free, strict=False))
    if CONTROL[0] not in columns:
        if any(bare_name(name).lower().startswith(OVER_FREQUENCY) for name in given.recording.names):
            what = f"{given.name}: a table over frequency; it has {', '.join(given.recording.names)}"
            why = "a transfer function that a controller worked out is not read: modes are fitted to the record in time"
            raise UsageError(what, why=why, do="Export control and response over time", code="over_frequency")
        what = f"{given.name}: cannot tell which column is the control; it has {', '.join(given.recording.names)}"
        why = "a response alone does not tell drive from resonance; both stand in one file, on one clock"
        raise UsageError(what, why=why, do=f"Add: {given.add('control', 'COLUMN')}", code="no_column")
    taken = {columns[name] for name in CONTROL if name in columns}
    # A control channel is an accelerometer too, and may bear the letter of an axis: it is no axis of the item.
    names = {bare_name(one) for one in taken} | taken
    channels = tuple(
        replace(one, axis="", quantity="") if one.name in names or bare_name(one.name) in names else one
        for one in given.recording.channels
    )
    recording = replace(given.recording, channels=channels)
    left = [one for one in channels if one.name not in names and bare_name(one.name) not in names]
    numbers = [one for one in left if one.data.dtype.kind in "iuf" and one.quantity != "time"]
    if not any(axis in columns for axis in AXES) and not any(one.axis in AXES for one in left) and len(numbers) == 1:
        columns["x"] = numbers[0].name
    seen = replace(given, read=lambda *_, **__: recording, said=replace(given.said, columns=columns))
    return described_channels(seen, spec)


def controls(recording: Recording) -> list[str]:
    """Return the columns whose names begin as those of a control accelerometer, in the order of their names."""
    every = {one.name: bare_name(one.name).lower().removeprefix(GENERAL) for one in recording.channels}
    named = [column for column, word in every.items() if word.startswith(BEGINS)]
    return sorted(named)[: len(CONTROL)]
