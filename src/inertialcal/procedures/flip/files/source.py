"""What a flip was made of, file by file: columns, units, axes and windows, as a campaign file would say it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....core.campaign_text import quoted
from ....core.recording import SECOND, Recording
from ....core.times import instant_text
from ..dwells.quiet import Window
from ..entry import Means


@dataclass(frozen=True)
class FlipSource:
    """A file of a flip.

    Parameters
    ----------
    columns : mapping of str to (str, str)
        Column and unit by axis; the unit is empty where it is not known.
    time_column : str
        Empty where the format says the time.
    frame : str
        Axes that an archive record was taken in; empty for those of its data.
    utc : bool
        Whether its time is UTC; else elapsed.
    windows : tuple of Window
        When the head stood still, and at which angle.
    means : Means or None
        Of a table of means, in place of all these.
    """

    columns: Mapping[str, tuple[str, str]]
    time_column: str = ""
    frame: str = ""
    utc: bool = True
    windows: tuple[Window, ...] = ()
    means: Means | None = None


def source_of(
    recording: Recording, columns: Mapping[str, tuple[str, str]], frame: str = "", windows: tuple[Window, ...] = ()
) -> FlipSource:
    """Return what a recording, as read, has to be called in a campaign file."""
    return FlipSource(columns, recording.time_column, frame, recording.epoch == "utc", windows)


def entry_text(name: str, file: str, source: FlipSource, mark: str = "") -> str:
    """Return the table of a recording.

    Parameters
    ----------
    name, file : str
        Of the recording; its path in the campaign folder.
    source : FlipSource
        What is in it.
    mark : str
        At the end of lines that have to be filled in.
    """
    head = f'[recordings.{name}]\nsensor = "head"\nfile = {quoted(file)}\n'
    if source.means is not None:
        return f"{head}{_means(source.means)}{'  ' + mark if mark else ''}\n"
    channels = [
        f"{axis} = {{ column = {quoted(column)}, unit = {quoted(unit or '?')} }}"
        for axis, (column, unit) in sorted(source.columns.items())
    ]
    known = all(unit for _, unit in source.columns.values())
    clock = f"clock = {{ column = {quoted(source.time_column)} }}\n" if source.time_column else ""
    frame = f"frame = {quoted(source.frame)}\n" if source.frame else ""
    return (
        f"{head}{clock}{frame}channels = {{ {', '.join(channels)} }}{'' if known else '  ' + mark}\n"
        f"positions = [  # when it stood still, and how it was turned then\n{_positions(source, mark)}]\n"
    )


def _positions(source: FlipSource, mark: str) -> str:
    if not source.windows:
        unknown = '  {{ start = "?", stop = "?", angle = "{} deg" }},  ' + mark
        return "\n".join([unknown.format(angle) for angle in (0, 180)]) + "\n"
    return "".join(
        f"  {{ start = {_instant(one.start, source.utc)}, stop = {_instant(one.stop, source.utc)}, "
        f'angle = "{np.degrees(one.angle):.12g} deg", flip = {quoted(one.flip)} }},\n'
        for one in source.windows
    )


def _instant(time_ns: int, utc: bool) -> str:
    return quoted(instant_text(time_ns)) if utc else f"{time_ns / SECOND:.9f}"


def _means(one: Means) -> str:
    columns = {"axis": one.axis, "position": one.position, "flip": one.flip, "mean": one.mean, "unit": one.unit}
    columns |= {"temperature": one.temperature, "predicted": one.predicted}
    angles = ", ".join(f"{quoted(name)} = {_angle(angle)}" for name, angle in one.angles.items())
    widths = ", ".join(f"{quoted(p)} = {quoted(column)}" for p, column in one.half_widths.items())
    parts = [f"{key} = {quoted(value)}" for key, value in columns.items() if value is not None]
    parts += [f"half_widths = {{ {widths} }}"] if widths else []
    return f"means = {{ {', '.join([*parts, f'angles = {{ {angles} }}'])} }}"


def _angle(radians: float) -> str:
    return '"? deg"' if np.isnan(radians) else f'"{np.degrees(radians):.12g} deg"'
