"""Records of an archive in a folder, and whether the head was turned in one: for a flip, else for its environment."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.errors import InertialcalError
from ..core.key import AXES
from ..core.recording import SECOND, Recording
from ..core.remarks import Remark
from ..files.info.motion import on_ground, triad

if TYPE_CHECKING:
    from ..signals.segmentation.turns import Turns

ARCHIVED = "pad"  # reader of records of triaxial heads in orbit
PART = 0.1  # of a record that a window may be: its noise is known from ten times as much
Entry = dict[str, Any]  # of a recording, without its sensor and file
Made = tuple[Entry, Sequence[Remark]]


def in_orbit(recording: Recording) -> bool:
    """Whether this is an archive record, or a triad of accelerometers without gyros that does not feel gravity."""
    if recording.source.reader == ARCHIVED:
        return True
    if recording.time_ns is None or any(one.quantity == "gyro" for one in recording.channels):
        return False
    return len(triad(recording)) == len(AXES) and not on_ground(recording)


def turns_of(recording: Recording) -> Turns:
    """Return the turns of a head that its channels show."""
    from ..signals.segmentation.turns import TurnPlan, find_turns  # noqa: PLC0415 - starts slowly

    plan = TurnPlan()
    plan = TurnPlan(widest=min(max(PART * seconds_of(recording), plan.shortest), plan.widest))
    channels = [one.data for one in recording.channels if one.axis in AXES]
    return find_turns(channels, recording.time_ns, recording.sample_interval, plan=plan)


def seconds_of(recording: Recording) -> float:
    """Return how long a recording is [s]."""
    time_ns, interval = recording.time_ns, recording.sample_interval or 0.0
    if time_ns is None:
        return len(recording) * interval
    return (int(time_ns[-1]) - int(time_ns[0])) / SECOND + interval


def is_turned(recording: Recording) -> bool:
    """Whether the head was turned, or may have been."""
    try:
        turns = turns_of(recording)
    except InertialcalError:  # too short to tell
        return False
    return bool(turns.turns or turns.doubt)


def found_in(root: Path, entry: Callable[[Path], Made | None]) -> tuple[dict[str, Entry], list[Remark]]:
    """Return the entries of archive records in a campaign folder, by file, of those for which there is one.

    Those of one sensor, in one folder (with the archive's own tree below it), are one recording.
    """
    found: dict[str, Entry] = {}
    remarks: list[Remark] = []
    for path in _records(root, remarks):
        file = path.relative_to(root).as_posix()
        try:
            if (made := entry(path)) is not None:
                found[file], more = made
                remarks += [one.at(file) for one in more]
        except InertialcalError as error:
            remarks.append(Remark("not_read", "warning", error.problems[0].what, file, do=error.problems[0].do))
    return found, remarks


def _records(root: Path, remarks: list[Remark]) -> Iterator[Path]:
    """Yield the paths of archive records: a file, or a folder of several of one sensor."""
    from ..files.pad.pairs import pairs_of  # noqa: PLC0415 - starts slowly

    taken: list[str] = []
    for folder in (root, *sorted({one.parent for one in root.rglob("*.header")} - {root})):
        file = folder.relative_to(root).as_posix()
        if file.startswith("out/") or any(file.startswith(f"{one}/") or one == "." for one in taken):
            continue
        try:
            pairs = pairs_of(folder)
        except InertialcalError as error:
            remarks.append(Remark("not_read", "warning", error.problems[0].what, file, do=error.problems[0].do))
            continue
        if pairs:
            taken.append(file if len(pairs) > 1 else pairs[0].data.relative_to(root).as_posix())
            yield folder if len(pairs) > 1 else pairs[0].data
