"""A recording of a turned head without a campaign file: its axes, and its windows, given or found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.axes import AXES
from ....core.errors import UsageError
from ....core.recording import SECOND, Channel, Recording
from ....core.remarks import Remark
from ....core.times import elapsed_text, instant_text
from ....core.units import convert, factor, kind
from ....files.time.window import Window as Between
from ....signals.segmentation.turn_windows import turn_windows
from ....signals.segmentation.turns import Turn, TurnPlan, find_turns
from ..dwells.disturbances import readable
from ..dwells.quiet import Window

MOST = 8  # times told
PART = 0.1  # of a record that a window may be: its noise is known from ten times as much


@dataclass(frozen=True)
class Said:
    """One window that the user gives: start, stop, angle [rad]."""

    start: str
    stop: str
    angle: float


def head_recording(recording: Recording, columns: Mapping[str, str] | None, unit: str | None) -> Recording:
    """Return the recording with the axes of the head, ``x``, ``y``, ``z`` [m/s^2].

    Raises
    ------
    UsageError
        If no channel is clearly an axis of an accelerometer, or its unit is not said.
    """
    named = axes_of(recording, columns)
    made = []
    for axis, name in named.items():
        channel = recording.channel(name)
        spoken = unit or channel.unit
        if spoken is None or kind(spoken) != "acceleration":
            raise _no_unit(recording, channel, spoken)
        made.append(Channel(axis, _in_si(channel.data, spoken), "m/s^2", channel.unit_from, axis))
    others = [channel for channel in recording.channels if channel.name not in {*named.values(), *AXES}]
    return readable(replace(recording, channels=(*made, *others)))


def _in_si(data: NDArray[Any], unit: str) -> NDArray[Any]:
    """Return readings in m/s^2; 32 bits stay 32 bits wide, so that a day of three axes stays as large as it is."""
    if data.dtype != np.float32:
        return convert(data, unit, "m/s^2")
    found: NDArray[np.float32] = np.empty_like(data)
    with np.errstate(over="ignore"):  # beyond 32 bits is no reading, and is left out as such
        np.multiply(data, factor(unit, "m/s^2"), out=found, dtype=np.float64, casting="same_kind")
    return found


def _no_unit(recording: Recording, channel: Channel, spoken: str | None) -> UsageError:
    """Return the error for readings that are in no unit of acceleration; whole numbers are counts as a rule."""
    what = f"{recording.source.path}: {channel.name!r} is in {spoken or 'no unit'}, need a unit of acceleration"
    if (spoken is None and channel.data.dtype.kind in "iu") or (spoken is not None and kind(spoken) == "count"):
        why = "counts become readings by gain, zero and scale factor of the head, which a campaign says (its chain)"
        do = "Run the campaign: inertialcal run DIR; or say the unit, if these are readings: --unit g"
        return UsageError(what, why=why, do=do, code="no_unit")
    return UsageError(what, do="Say it: --unit g", code="no_unit")


def axes_of(recording: Recording, columns: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the channel of each axis, as said or by their names.

    Raises
    ------
    UsageError
        If no channel is clearly an axis of an accelerometer, or one that was said is none.
    """
    named = dict(columns) if columns else _axes(recording)
    if not named:
        what = f"{recording.source.path}: no channel is clearly an axis of an accelerometer"
        do = f"Say it: --column x=COLUMN. There are: {', '.join(recording.names)}"
        raise UsageError(what, do=do, code="no_column")
    strange = [axis for axis in named if axis not in AXES]
    if strange:
        raise UsageError(f"--column: axis {strange[0]!r}", do="There are: x, y, z", code="unknown_name")
    twice = [name for name in named.values() if list(named.values()).count(name) > 1]
    if twice:
        what = f"--column: {twice[0]!r} is the channel of {' and '.join(a for a in named if named[a] == twice[0])}"
        raise UsageError(what, do="Give each axis a channel of its own", code="duplicate_id")
    return named


def _axes(recording: Recording) -> dict[str, str]:
    found = [c for c in recording.channels if c.axis in AXES and c.quantity in ("acc", "")]
    named = {c.axis: c.name for c in found}
    return named if len(named) == len(found) else {}


def given_windows(
    recordings: Sequence[Recording], said: Sequence[Said], mission_start: str | None = None
) -> list[tuple[Window, ...]]:
    """Return the windows that the user gave, of each recording those that lie in it, on its clock.

    Raises
    ------
    UsageError
        If a time cannot be read on that clock, or a window lies in no recording.
    """
    found = [tuple(_given(recording, one, mission_start) for one in said) for recording in recordings]
    inside = [[_touches(recording, w) for w in own] for recording, own in zip(recordings, found, strict=True)]
    for i, one in enumerate(said):
        if not any(of[i] for of in inside):
            none = f"none of the {len(recordings)} recordings" if len(recordings) > 1 else "no part of the recording"
            what = f"--window {one.start}..{one.stop}: lies in {none}"
            raise UsageError(what, do=f"There is {', '.join(map(_reach, recordings[:3]))}", code="empty_window")
    return [tuple(w for w, there in zip(own, of, strict=True) if there) for own, of in zip(found, inside, strict=True)]


def _given(recording: Recording, one: Said, mission_start: str | None) -> Window:
    try:
        start, stop = Between(one.start, one.stop, mission_start).bounds(recording.epoch)
    except UsageError as error:
        problem = error.problems[0]
        mission = "Say it: --mission-start 1996-03-22T08:13:04Z" if problem.code == "no_mission_start" else ""
        do = problem.do or mission
        raise UsageError(f"--window {one.start}..{one.stop}: {problem.what}", do=do, code="wrong_time") from None
    assert start is not None  # noqa: S101 - both were given
    assert stop is not None  # noqa: S101
    return Window(start, stop, one.angle)


def _reach(recording: Recording) -> str:
    """Say from when to when a recording goes, as its own clock has it."""
    said = instant_text if recording.epoch == "utc" else lambda at: f"{at / SECOND:.9g} s"
    time_ns = recording.time_ns
    ends = "" if time_ns is None else f" from {said(int(time_ns[0]))} to {said(int(time_ns[-1]))}"
    return f"{recording.source.path}{ends}"


def _touches(recording: Recording, window: Window) -> bool:
    time_ns = recording.time_ns
    return time_ns is None or (window.start <= int(time_ns[-1]) and window.stop > int(time_ns[0]))


def found_windows(recording: Recording, angle: float) -> tuple[tuple[Window, ...], tuple[Remark, ...]]:
    """Return the windows beside the turns that the record shows, and what speaks against them.

    The head starts at position 0 and each turn takes it to ``angle`` or back; all turns of a recording are one flip.
    Windows are the same length on both sides of a turn, and no longer than a part of the record: what is left shows the
    noise. Two that reach into each other between their turns are one.

    Raises
    ------
    UsageError
        If no turn is found.
    """
    axes = [axis for axis in AXES if axis in recording.names]
    shortest = TurnPlan().shortest
    plan = TurnPlan(widest=min(max(PART * _seconds(recording), shortest), TurnPlan().widest))
    channels = [recording.channel(axis).data for axis in axes]
    turns = find_turns(channels, recording.time_ns, recording.sample_interval, plan=plan)
    pairs = turn_windows(turns)
    if not pairs:
        what = f"{recording.source.path}: no turn of the head is seen in {_seconds(recording):.4g} s"
        spikes = _spikes(recording, turns.others)
        why = f"no axis clearly changes its level, by means over {shortest:g} s, across {spikes}"
        do = 'Give the windows: --window "START..STOP=0 deg" --window "START..STOP=180 deg"'
        raise UsageError(what, why=why, do=do, code="no_turns")
    windows: list[Window] = []
    remarks = [*turns.remarks, *(problem for pair in pairs for problem in pair.problems)]
    for i, pair in enumerate(pairs):
        ends = ((pair.before, 0.0 if i % 2 == 0 else angle), (pair.after, angle if i % 2 == 0 else 0.0))
        for w, at in ends:
            if w is not None:
                windows = _joined(windows, Window(w.start_ns, w.stop_ns, at))
    remarks.append(_turns_found(recording, [pair.turn for pair in pairs], turns.others, angle))
    return tuple(windows), tuple(remarks)


def _turns_found(recording: Recording, found: Sequence[Turn], others: Sequence[Turn], angle: float) -> Remark:
    """Say where turns were found and which positions follow; a warning where a spike may be one more."""
    word = "turn" if len(found) == 1 else "turns"
    there = f"0 deg before, {np.degrees(angle):g} deg after{'' if len(found) == 1 else ', and so on by turns'}"
    what = f"{len(found)} {word} found, at {_times(recording, found)}: {there}"
    unsure = [one for one in others if not one.significance > TurnPlan().step]
    if not unsure:
        return Remark("turns_found", "info", what)
    more = (
        f"{_spikes(recording, unsure)} is not taken for a turn"
        if len(unsure) == 1
        else (f"{_spikes(recording, unsure)} are not taken for turns")
    )
    why = "if one is, positions and the sign of ambient acceleration are wrong"
    do = 'If the head was turned there, give the windows: --window "START..STOP=0 deg" ...'
    return Remark("turns_found", "warning", f"{what}. {more}: {why}", do=do)


def _spikes(recording: Recording, others: Sequence[Turn]) -> str:
    """Say which spikes there are."""
    if not others:
        return "a spike"
    return f"the {'spike' if len(others) == 1 else f'{len(others)} spikes'} at {_times(recording, others)}"


def _times(recording: Recording, turns: Sequence[Turn]) -> str:
    """Say when turns begin, to 0.1 s, on the clock of the recording; of many, the first few."""
    at = [round(one.start_ns, -8) for one in turns]
    said = instant_text if recording.epoch == "utc" else _elapsed
    more = f" and {len(at) - MOST} more" if len(at) > MOST else ""
    return ", ".join(said(one) for one in at[:MOST]) + more


def _elapsed(at: int) -> str:
    return elapsed_text(at) if at >= 0 else f"{at / SECOND:.9g} s"


def _joined(before: list[Window], after: Window) -> list[Window]:
    if before and after.start <= before[-1].stop and after.angle == before[-1].angle:
        return [*before[:-1], replace(before[-1], stop=max(before[-1].stop, after.stop))]
    return [*before, after]


def _seconds(recording: Recording) -> float:
    """Length of a recording [s]."""
    time_ns, interval = recording.time_ns, recording.sample_interval or 0.0
    return len(recording) * interval if time_ns is None else (int(time_ns[-1]) - int(time_ns[0])) / SECOND + interval
