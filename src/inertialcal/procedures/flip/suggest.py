"""What looks like a flip of a head: the command to type next, a draft of the tests."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...core.axes import AXES
from ...core.campaign_text import Noted
from ...core.errors import InertialcalError, UsageError
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.units import factor, kind
from ...files import read
from ...files.info.motion import accelerometers, gyros, triad
from ...files.info.survey import Survey
from ...files.pad.pairs import pairs_of
from ...files.text.table import Table
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion, fill_in, sensor_table
from .plan import Plan

if TYPE_CHECKING:
    from .files.source import FlipSource

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
    sizes = [abs(float(np.median(one.data))) * factor(one.unit or "", "g") for one in triad(recording)]
    return len(sizes) == len(AXES) and max(sizes) < FREE_FALL


def claims(file: FolderFile) -> Claim | None:
    """Claim a table of means, and a recording of accelerometers alone."""
    recording = file.recording
    if recording is None:
        means = means_of_table(file.table)
        return None if means is None else Claim(Strength.SURE, lambda: (means, ()))
    alone = accelerometers(recording) and not gyros(recording)
    return Claim(Strength.POSSIBLE, lambda: head_source(recording)) if alone else None


def means_of_table(table: Table) -> FlipSource | None:
    """Return which column of a table of means is what, positions without angle; None where it is none.

    Raises
    ------
    UsageError
        If its names do not tell, or not the unit.
    """
    from .files.source import FlipSource  # noqa: PLC0415 - starts slowly
    from .files.table import is_table_of_means, means_columns  # noqa: PLC0415 - starts slowly

    if not is_table_of_means(table):
        return None
    columns = [name for name in table.names if re.fullmatch("position|orientation|attitude|turned", name.lower())]
    unknown = {one: "0 deg" for name in columns for one in table.text(name)}
    means = means_columns(table, unknown, None)
    return FlipSource({}, means=means.model_copy(update={"angles": dict.fromkeys(means.angles, math.nan)}))


def head_source(recording: Recording, frame: str = "") -> tuple[FlipSource, tuple[Remark, ...]]:
    """Return a recording of a turned head with the windows that it shows, and what speaks against them.

    Parameters
    ----------
    recording : Recording
        As read.
    frame : str
        Axes that it was read in.
    """
    from .files.record import found_windows, head_recording  # noqa: PLC0415 - starts slowly
    from .files.source import source_of  # noqa: PLC0415 - starts slowly

    columns = {axis: (c.name, c.unit or "") for axis, c in accelerometers(recording).items()}
    try:
        windows, remarks = found_windows(head_recording(recording, None, None), math.pi)
    except UsageError as error:
        why = Remark(
            "no_turns", "info", error.problems[0].what, do="Fill in when it stood still, and how it was turned"
        )
        return source_of(recording, columns, frame), (why,)
    return source_of(recording, columns, frame, windows), remarks


def found_in(root: Path) -> tuple[dict[str, FlipSource], list[Remark]]:
    """Return the archive records of a folder by file: those of one sensor, in one folder, are one recording.

    Parameters
    ----------
    root : Path
        Folder of the campaign; the archive's own tree below it counts as one folder.
    """
    found: dict[str, FlipSource] = {}
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
            found[file], more = head_source(*_in_sensor_axes(root / file))
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
    from .files.source import FlipSource, entry_table  # noqa: PLC0415 - starts slowly

    sources = {file: one for file, one in contents.items() if isinstance(one, FlipSource)}
    units: list[str] = []
    recordings: dict[str, object] = {}
    tests = []
    counts = {"means": 0, "head": 0}
    for file, one in sources.items():
        units += [one.means.unit] if one.means is not None else [unit for _, unit in one.columns.values()]
        word = "means" if one.means is not None else "head"
        counts[word] += 1
        name = f"{word}{counts[word]}"
        recordings[name] = entry_table(file, one)
        tests.append(flip_test(f"flip_{name}", [name], Plan(), known=False))
    sensors = {"head": sensor_table("accelerometer", units)}
    return Draft(sensors, recordings, tests, REQUIREMENT, STANDARDS)


def flip_test(test: str, recordings: list[str], plan: Plan, known: bool) -> dict[str, object]:
    """Return the table of a test; ``known``: whether the plan was used, not guessed."""
    settings: dict[str, object] = {"axis": plan.axis}
    if plan.settle:
        settings["settle"] = f"{plan.settle:.12g} s"
    if plan.corrected:
        settings["corrected"] = True
    own = settings if known else fill_in(settings)
    return {"id": test, "procedure": "flip", "recordings": recordings, "plan": own}
