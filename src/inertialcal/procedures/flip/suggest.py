"""What looks like a flip of a head: the command to type next, a draft of the tests."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.campaign_text import Noted
from ...core.errors import InertialcalError, UsageError
from ...core.key import AXES
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.units import factor, kind
from ...files import read
from ...files.info.channel_survey import median_norm
from ...files.info.motion import accelerometers, gyros, triad
from ...files.info.survey import Survey
from ...files.pad.pairs import pairs_of
from ...files.text.table import Table
from ..given import GivenFile, Said
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion, channel_tables, fill_in, sensor_table

Entry = dict[str, Any]  # of a recording, without its sensor and file
REQUIREMENT = {"quantity": "control_error", "limit": "0.5 ug"}
STANDARDS = {
    "turn": Noted({"angle": {"u": "0.2 deg", "certificate": "..."}, "axis": {"u": "0.2 deg"}}, example=True),
}
AXIS_COLUMNS = {"axis", "channel", "sensor"}
POSITION_COLUMNS = {"position", "orientation", "attitude", "turned"}
FREE_FALL = 0.1  # [g]: on the ground a triad reads 1 g in all
ARCHIVED = "pad"  # triaxial heads in orbit


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``flip`` of a head in orbit: an archive record, means of a flip, or a triad in free fall."""
    archived = recording.source.reader == ARCHIVED
    if not (archived or _is_of_means(recording, survey.remarks) or _floats(recording)):
        return None
    return Suggestion(("flip",), Strength.SURE)


def _is_of_means(recording: Recording, remarks: Sequence[Remark]) -> bool:
    """Whether a file looks like means of a flip, by its columns: axes, positions, and an acceleration."""
    names = {one.subject.lower() for one in remarks if one.code == "text_column"}
    means = any(one.unit is not None and kind(one.unit) == "acceleration" for one in recording.channels)
    return means and bool(names & AXIS_COLUMNS) and bool(names & POSITION_COLUMNS)


def _floats(recording: Recording) -> bool:
    """Whether this is a triad of accelerometers, and nothing of gyros, that feels next to nothing of gravity."""
    if recording.time_ns is None or any(one.quantity == "gyro" for one in recording.channels):
        return False
    channels = triad(recording)
    in_g = [factor(one.unit or "", "g") for one in channels]
    return len(channels) == len(AXES) and max(in_g) * median_norm(channels) < FREE_FALL


def claims(file: FolderFile) -> Claim | None:
    """Claim a table of means, and a recording of accelerometers alone."""
    recording = file.recording
    if recording is None:
        means = means_of_table(file.table)
        return None if means is None else Claim(Strength.SURE, lambda: (means, ()))
    alone = accelerometers(recording) and not gyros(recording)
    return Claim(Strength.POSSIBLE, lambda: head_entry(recording)) if alone else None


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


def found_in(root: Path) -> tuple[dict[str, Entry], list[Remark]]:
    """Return the entries of archive records in a campaign folder, by file.

    Those of one sensor, in one folder (with the archive's own tree below it), are one recording.
    """
    found: dict[str, Entry] = {}
    remarks: list[Remark] = []
    for folder in (root, *sorted({one.parent for one in root.rglob("*.header")} - {root})):
        file = folder.relative_to(root).as_posix()
        if file.startswith("out/") or any(file.startswith(f"{one}/") or one == "." for one in found):
            continue
        try:
            pairs = pairs_of(folder)
            if not pairs:
                continue
            file = file if len(pairs) > 1 else pairs[0].data.relative_to(root).as_posix()
            found[file], more = head_entry(*_in_sensor_axes(root / file))
            remarks += [one.at(file) for one in more]
        except InertialcalError as error:
            remarks.append(Remark("not_read", "warning", error.problems[0].what, file, do=error.problems[0].do))
    return found, remarks


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
