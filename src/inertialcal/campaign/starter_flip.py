"""The part of a first campaign.toml that is about flips: tables of means, and recordings of accelerometers."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path

from ..core.axes import AXES
from ..core.errors import InertialcalError, UsageError
from ..core.recording import Channel, Recording
from ..core.remarks import Remark
from ..core.units import kind
from ..files import read
from ..files.pad.pairs import pairs_of
from ..files.text.table import Table
from ..procedures.flip import reduction as flip
from ..procedures.flip.files.record import found_windows, head_recording
from ..procedures.flip.files.source import FlipSource, entry_text, quoted, source_of
from ..procedures.flip.files.table import is_table_of_means, means_columns
from .file.load import MARK


def means_of_table(table: Table) -> FlipSource | None:
    """Return which column of a table of means is what, positions without angle; None where it is none.

    Raises
    ------
    UsageError
        If its names do not tell, or not the unit.
    """
    if not is_table_of_means(table):
        return None
    columns = [name for name in table.names if re.fullmatch("position|orientation|attitude|turned", name.lower())]
    unknown = {one: "0 deg" for name in columns for one in table.text(name)}
    means = means_columns(table, unknown, None)
    return FlipSource({}, means=means.model_copy(update={"angles": dict.fromkeys(means.angles, math.nan)}))


def accelerometers(recording: Recording) -> dict[str, Channel]:
    """Return the accelerometer channels by axis."""
    return {
        c.axis: c for c in recording.channels
        if c.axis in AXES and (c.quantity == "acc" or (c.unit is not None and kind(c.unit) == "acceleration"))
    }  # fmt: skip


def head_source(recording: Recording, frame: str = "") -> tuple[FlipSource, tuple[Remark, ...]]:
    """Return a recording of a turned head with the windows that it shows, and what speaks against them.

    Parameters
    ----------
    recording : Recording
        As read.
    frame : str
        Axes that it was read in.
    """
    columns = {axis: (c.name, c.unit or "") for axis, c in accelerometers(recording).items()}
    try:
        windows, remarks = found_windows(head_recording(recording, None, None), math.pi)
    except UsageError as error:
        why = Remark(
            "no_turns", "info", error.problems[0].what, do="Fill in when it stood still, and how it was turned"
        )
        return source_of(recording, columns, frame), (why,)
    return source_of(recording, columns, frame, windows), remarks


def archive_sources(root: Path) -> tuple[dict[str, FlipSource], list[Remark]]:
    """Return the archive records of a folder by file: those of one sensor, in one folder, are one recording.

    Parameters
    ----------
    root : Path
        Folder of the campaign; the archive's own tree below it counts as one folder.
    """
    found: dict[str, FlipSource] = {}
    remarks: list[Remark] = []
    for folder in (root, *sorted({one.parent for one in root.rglob("*.header")} - {root})):
        name = folder.relative_to(root).as_posix()
        if name.startswith("out/") or any(name.startswith(f"{one}/") or one == "." for one in found):
            continue
        try:
            pairs = pairs_of(folder)
            if not pairs:
                continue
            name = name if len(pairs) > 1 else pairs[0].data.relative_to(root).as_posix()
            found[name], more = head_source(*_in_sensor_axes(root / name))
            remarks += [one.at(name) for one in more]
        except InertialcalError as error:
            remarks.append(Remark("not_read", "warning", error.problems[0].what, name, do=error.problems[0].do))
    return found, remarks


def _in_sensor_axes(path: Path) -> tuple[Recording, str]:
    """Return an archive record in the axes of its sensor, where it says them, and the name of the frame."""
    recording = read(path)
    if any(remark.code == "not_sensor_axes" for remark in recording.remarks):
        return read(path, frame="sensor"), "sensor"
    return recording, ""


def flip_parts(sources: Mapping[str, FlipSource]) -> list[str]:
    """Return the texts of sensor, recordings and tests; what is not known is marked.

    Parameters
    ----------
    sources : mapping of str to FlipSource
        Tables of means and recordings, by file.
    """
    if not sources:
        return []
    known = next((unit for one in sources.values() for unit in _units(one) if unit), None)
    parts = [sensor_text(known or "?", "" if known else MARK)]
    counts = {"means": 0, "head": 0}
    for file, one in sources.items():
        word = "means" if one.means is not None else "head"
        counts[word] += 1
        name = f"{word}{counts[word]}"
        parts += [entry_text(name, file, one, MARK), flip_text(f"flip_{name}", [name], flip.Plan(), MARK)]
    return parts


def _units(one: FlipSource) -> list[str]:
    return [one.means.unit] if one.means is not None else [unit for _, unit in one.columns.values()]


def sensor_text(unit: str, mark: str = "") -> str:
    """Return the tables of standards, to be filled in by who has them, and of the head."""
    return (
        "# Uncertainties of a flip: without them the results are relative to the fixture.\n"
        '# [standards.turn]\n# angle = { u = "0.2 deg", certificate = "..." }\n# axis = { u = "0.2 deg" }\n\n'
        f'[sensors.head]\nkind = "accelerometer"\naxes = ["x", "y", "z"]\nunit = {quoted(unit)}'
        f"{'  ' + mark if mark else ''}\n"
    )


def flip_text(test: str, recordings: list[str], plan: flip.Plan, mark: str = "") -> str:
    """Return the table of a test."""
    settings = [f"axis = {quoted(plan.axis)}"]
    settings += [f'settle = "{plan.settle:.12g} s"'] if plan.settle else []
    settings += ["corrected = true"] if plan.corrected else []
    names = ", ".join(quoted(one) for one in recordings)
    return (
        f'[[tests]]\nid = {quoted(test)}\nprocedure = "flip"\nrecordings = [{names}]\n'
        f"plan = {{ {', '.join(settings)} }}{'  ' + mark if mark else ''}\n"
    )
