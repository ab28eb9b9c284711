"""What a flip was made of, file by file: columns, units, axes and windows, as a campaign file would say it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....core.campaign_text import Noted
from ....core.recording import SECOND, Recording
from ....core.times import instant_text
from ...suggestions import fill_in
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


def entry_table(file: str, source: FlipSource) -> dict[str, object]:
    """Return the table of a recording; values that the source does not say are marked to be filled in."""
    entry: dict[str, object] = {"sensor": "head", "file": file}
    if source.means is not None:
        return entry | {"means": _means(source.means)}
    if source.time_column:
        entry["clock"] = {"column": source.time_column}
    if source.frame:
        entry["frame"] = source.frame
    channels = {
        axis: {"column": column, "unit": unit} if unit else fill_in({"column": column, "unit": "?"})
        for axis, (column, unit) in sorted(source.columns.items())
    }
    positions: list[object] = [
        {
            "start": instant_text(one.start) if source.utc else one.start / SECOND,
            "stop": instant_text(one.stop) if source.utc else one.stop / SECOND,
            "angle": f"{np.degrees(one.angle):.12g} deg",
            "flip": one.flip,
        }
        for one in source.windows
    ] or [fill_in({"start": "?", "stop": "?", "angle": f"{angle} deg"}) for angle in (0, 180)]
    return entry | {"positions": Noted(positions, "when the head stood still, and its angle"), "channels": channels}


def _means(one: Means) -> dict[str, object]:
    columns = {"axis": one.axis, "position": one.position, "flip": one.flip, "mean": one.mean, "unit": one.unit}
    columns |= {"temperature": one.temperature, "predicted": one.predicted}
    means: dict[str, object] = {key: column for key, column in columns.items() if column is not None}
    if one.half_widths:
        means["half_widths"] = dict(one.half_widths)
    unknown = any(np.isnan(angle) for angle in one.angles.values())
    angles = {
        name: "? deg" if np.isnan(angle) else f"{np.degrees(angle):.12g} deg" for name, angle in one.angles.items()
    }
    return means | {"angles": fill_in(angles) if unknown else angles}
