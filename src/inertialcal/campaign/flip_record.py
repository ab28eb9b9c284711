"""A recording of a turned head without a campaign file: its axes, and its windows, given or found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ..core.errors import UsageError
from ..core.recording import SECOND, Channel, Recording
from ..core.remarks import Remark
from ..core.times import read_elapsed, read_instant
from ..core.units import convert, kind
from ..procedures import flip
from ..signals.turn_windows import turn_windows
from ..signals.turns import find_turns

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Said:
    """One window that the user gives: start, stop, angle [rad], flip."""

    start: str
    stop: str
    angle: float
    flip: str = "1"


def head_recording(recording: Recording, columns: Mapping[str, str] | None, unit: str | None) -> Recording:
    """Return the recording with the axes of the head, ``x``, ``y``, ``z`` [m/s^2].

    Raises
    ------
    UsageError
        If no channel is clearly an axis of an accelerometer, or its unit is not said.
    """
    named = dict(columns) if columns else _axes(recording)
    if not named:
        what = f"{recording.source.path}: no channel is clearly an axis of an accelerometer"
        do = f"Say it: --column x=COLUMN. There are: {', '.join(recording.names)}"
        raise UsageError(what, do=do, code="no_column")
    made = []
    for axis, name in named.items():
        channel = recording.channel(name)
        spoken = unit or channel.unit
        if spoken is None or kind(spoken) != "acceleration":
            what = f"{recording.source.path}: {name!r} is in {spoken or 'no unit'}, need a unit of acceleration"
            raise UsageError(what, do="Say it: --unit g", code="no_unit")
        made.append(Channel(axis, convert(channel.data, spoken, "m/s^2"), "m/s^2", channel.unit_from, axis))
    others = [channel for channel in recording.channels if channel.name not in {*named.values(), *named}]
    return replace(recording, channels=(*made, *others))


def _axes(recording: Recording) -> dict[str, str]:
    found = [c for c in recording.channels if c.axis in AXES and c.quantity in ("acc", "")]
    named = {c.axis: c.name for c in found}
    return named if len(named) == len(found) else {}


def given_windows(recording: Recording, said: Sequence[Said]) -> tuple[flip.Window, ...]:
    """Return the windows that the user gave, on the clock of the recording.

    Raises
    ------
    UsageError
        If a time cannot be read on that clock.
    """
    read = read_instant if recording.epoch == "utc" else read_elapsed
    try:
        return tuple(flip.Window(read(one.start), read(one.stop), one.angle, one.flip) for one in said)
    except ValueError as error:
        raise UsageError(f"--window: {error}", code="wrong_time") from None


def _length(recording: Recording) -> str:
    """Return how long a recording is, in words."""
    time_ns = recording.time_ns
    if time_ns is None:
        return f"{len(recording)} samples"
    return f"{(int(time_ns[-1]) - int(time_ns[0])) / SECOND + (recording.sample_interval or 0.0):.4g} s"


def found_windows(recording: Recording, angle: float) -> tuple[tuple[flip.Window, ...], tuple[Remark, ...]]:
    """Return the windows beside the turns that the record shows, and what speaks against them.

    The head starts at position 0 and each turn takes it to ``angle`` or back. A turn is one flip; its windows are the
    same length on both sides.

    Raises
    ------
    UsageError
        If no turn is found.
    """
    axes = [axis for axis in AXES if axis in recording.names]
    turns = find_turns(recording.array(axes), recording.time_ns, recording.sample_interval)
    pairs = turn_windows(turns)
    if not pairs:
        what = f"{recording.source.path}: no turn of the head is seen in {_length(recording)}"
        why = "the level of no axis changes across a spike"
        do = 'Give the windows: --window "START..STOP=0 deg" --window "START..STOP=180 deg"'
        raise UsageError(what, why=why, do=do, code="no_turns")
    windows, remarks = [], list(turns.remarks)
    for i, pair in enumerate(pairs):
        ends = ((pair.before, 0.0 if i % 2 == 0 else angle), (pair.after, angle if i % 2 == 0 else 0.0))
        windows += [flip.Window(w.start_ns, w.stop_ns, at, str(i + 1)) for w, at in ends if w is not None]
        remarks += pair.problems
    lengths = ", ".join(f"{pair.turn.start_ns / SECOND:.0f} s" for pair in pairs)
    word = "turn" if len(pairs) == 1 else "turns"
    remarks.append(Remark("turns_found", "info", f"{len(pairs)} {word} found, at {lengths} on the clock of the record"))
    return tuple(sorted(windows, key=lambda one: one.start)), tuple(remarks)
