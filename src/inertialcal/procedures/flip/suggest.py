"""What looks like a flip of a head: the command to type next, a draft of the tests."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.campaign_text import Noted
from ...core.errors import UsageError
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.units import kind
from ...files import read
from ...files.info.motion import accelerometers, gyros, may_float, on_ground
from ...files.info.survey import Survey
from ...files.text.table import Table
from ..archived import Entry, Made, in_orbit, is_turned
from ..given import GivenFile, Said
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion, channel_tables, fill_in, sensor_table

REQUIREMENT = {"quantity": "control_error", "limit": "0.5 ug"}
STANDARDS = {
    "turn": Noted({"angle": {"u": "0.2 deg", "certificate": "..."}, "axis": {"u": "0.2 deg"}}, example=True),
}
AXIS_COLUMNS = {"axis", "channel", "sensor"}
POSITION_COLUMNS = {"position", "orientation", "attitude", "turned"}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``flip`` of means of a flip, and of a head that turned in orbit."""
    if not (_is_of_means(recording, survey.remarks) or (in_orbit(recording) and is_turned(recording))):
        return None
    return Suggestion(("flip",), Strength.SURE)


def _is_of_means(recording: Recording, remarks: Sequence[Remark]) -> bool:
    """Whether a file looks like means of a flip, by its columns: axes, positions, and an acceleration."""
    names = {one.subject.lower() for one in remarks if one.code == "text_column"}
    means = any(one.unit is not None and kind(one.unit) == "acceleration" for one in recording.channels)
    return means and bool(names & AXIS_COLUMNS) and bool(names & POSITION_COLUMNS)


def claims(file: FolderFile) -> Claim | None:
    """Claim a table of means, and a recording of accelerometers alone that do not feel gravity, as far as is known."""
    recording = file.recording
    if recording is None:
        means = means_of_table(file.table)
        return None if means is None else Claim(Strength.SURE, lambda: (means, ()))
    alone = accelerometers(recording) and not gyros(recording) and not on_ground(recording)
    may = may_float(recording) or (alone and is_turned(recording))
    return Claim(Strength.POSSIBLE, lambda: head_entry(recording)) if may else None


def means_of_table(table: Table) -> Entry | None:
    """Return the entry of a table of means, angles of its positions open; None where it is none.

    Raises
    ------
    UsageError
        If its columns, or their unit, are not clear.
    """
    from .given import is_table_of_means, means_columns  # noqa: PLC0415 - starts slowly

    if not is_table_of_means(table):
        return None
    columns = [name for name in table.names if re.fullmatch("position|orientation|attitude|turned", name.lower())]
    angles = {one: "0 deg" for name in columns for one in table.text(name)}
    path = table.source.path
    means, _ = means_columns(GivenFile(path, Said(), {"positions": angles}, {}, lambda: read(path), lambda: table))
    return {"means": {**means, "angles": fill_in(dict.fromkeys(means["angles"], "? deg"))}}


def head_entry(recording: Recording, frame: str = "") -> tuple[Entry, tuple[Remark, ...]]:
    """Return the entry of a recording of a turned head, read in a frame, with the windows that it shows."""
    from .given import found_windows, head_recording, position_rows  # noqa: PLC0415 - starts slowly

    heads = dict(sorted(accelerometers(recording).items()))
    columns = {axis: {"column": one.name, "unit": one.unit or "m/s^2"} for axis, one in heads.items()}
    positions: list[Any]
    remarks: tuple[Remark, ...]
    try:
        windows, remarks = found_windows(head_recording(recording, columns), math.pi)
        positions = position_rows(windows, recording.epoch, "1")
    except UsageError as error:
        do = "Fill in when it stood still, and how it was turned"
        remarks = (Remark("no_turns", "info", error.problems[0].what, do=do),)
        positions = [fill_in({"start": "?", "stop": "?", "angle": f"{angle} deg"}) for angle in (0, 180)]
    entry: Entry = {"clock": {"column": recording.time_column}} if recording.time_column else {}
    entry |= {"frame": frame} if frame else {}
    entry["positions"] = Noted(positions, "when the head stood still, and its angle")
    return entry | {"channels": channel_tables(heads)}, remarks


def in_archive(path: Path) -> Made | None:
    """Return the entry of an archive record in whose readings the head turns."""
    recording, frame = _in_sensor_axes(path)
    return head_entry(recording, frame) if is_turned(recording) else None


def _in_sensor_axes(path: Path) -> tuple[Recording, str]:
    """Return an archive record in the axes of its sensor, where it says them, and the name of the frame."""
    recording = read(path)
    if any(remark.code == "not_sensor_axes" for remark in recording.remarks):
        return read(path, frame="sensor"), "sensor"
    return recording, ""


def draft(contents: Mapping[str, object]) -> Draft:
    """Return the head, its recordings and tests, by file: tables of means and recordings."""
    units: list[str] = []
    recordings: dict[str, object] = {}
    tests = []
    counts = {"means": 0, "head": 0}
    for file, entry in contents.items():
        assert isinstance(entry, dict)  # noqa: S101 - as claimed
        named = [entry["means"]] if "means" in entry else entry["channels"].values()
        units += [one["unit"] for one in named if not isinstance(one, Noted)]
        word = "means" if "means" in entry else "head"
        counts[word] += 1
        name = f"{word}{counts[word]}"
        recordings[name] = {"sensor": "head", "file": file, **entry}
        plan = fill_in({"axis": "x"})
        tests.append({"id": f"flip_{name}", "procedure": "flip", "recordings": [name], "plan": plan})
    sensors = {"head": sensor_table("accelerometer", units)}
    return Draft(sensors, recordings, tests, REQUIREMENT, STANDARDS)
