"""A flip without a campaign file: what ``flip PATH`` and ``inertialcal.flip`` do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.errors import DataError, UsageError
from ....core.influence import Influence
from ....core.recording import Recording
from ....core.remarks import Remark, gather
from ....core.results import Row
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import estimate_table, remarks_line
from ....core.show.tables import Block, html, text
from ....core.units import factor, kind, normalise, parse_quantity
from ....files import read
from ....files.pad.frames import sensor_frame
from ....files.text.table import read_table
from ...display import curve_contents, displayed
from ..dwells.recordings import FlipRecording, readings_from
from ..inputs import means_of, readings_of_means
from ..plan import Axis, Plan
from ..readings import Readings
from ..reduction import Result, reduce
from .record import Said, axes_of, found_windows, given_windows, head_recording
from .source import FlipSource, source_of
from .table import is_table_of_means, means_columns

if TYPE_CHECKING:
    from pandas import DataFrame


HALF_TURN = "180 deg"
MICRO = 0.01  # [g], below which g is told in ug
AXES: dict[str, Axis] = {"x": "x", "y": "y", "z": "z"}


@dataclass(frozen=True, eq=False)
class FlipFile:
    """Result of one or more files.

    Parameters
    ----------
    result : flip.Result
        SI.
    rows : tuple of Row
        In the unit of the files.
    inputs : mapping of str to str
        SHA-256 by path.
    unit : str
        Of the figures: that of the files, but ug for g where all is below 0.01 g.
    remarks : tuple of Remark
        What reading and reducing brought up.
    sources : mapping of str to FlipSource
        What was taken from each file, by path.
    """

    result: Result
    rows: tuple[Row, ...]
    inputs: Mapping[str, str]
    unit: str
    remarks: tuple[Remark, ...]
    sources: Mapping[str, FlipSource] = field(default_factory=dict[str, FlipSource])

    def content(self) -> dict[str, Any]:
        """Return rows and curves as ``results.json`` would hold them, in the unit of the files."""
        curves = curve_contents(self.result.curves(), self.unit, "flip")
        return {"curves": curves, "results": [row.to_dict() for row in self.rows]}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the figures in the unit of the files, how many remarks."""
        rows = [row.to_dict() for row in self.rows if not row.case.beside]
        caption = f"flip about {self.result.plan.axis}: {len(self.result.readings)} dwells"
        return (*estimate_table(rows, caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def flip(
    paths: str | Path | Sequence[str | Path],
    *,
    axis: str = "x",
    unit: str | None = None,
    positions: Mapping[str, str] | None = None,
    windows: Sequence[tuple[str, str, str]] = (),
    angle: str = HALF_TURN,
    columns: Mapping[str, str] | None = None,
    settle: str = "0 s",
    corrected: bool = False,
    start: str | None = None,
    stop: str | None = None,
    mission_start: str | None = None,
    frame: str | None = None,
) -> FlipFile:
    """Separate the bias of a triaxial head from ambient acceleration, by turning it.

    Parameters
    ----------
    paths : path or sequence of path
        A table of means (a row an axis and position), or recordings.
    axis : {"x", "y", "z"}
        Head axis about which it was turned.
    unit : str, optional
        Of the readings, where the files do not say it.
    positions : mapping of str to str, optional
        Of a table: angle of each position, ``{"reverse": "180 deg"}``.
    windows : sequence of (start, stop, angle), optional
        Of recordings: when the head stood still, and how it was turned. Absent: found by the spikes of the turns.
    angle : str
        Of the turns, where the windows are found.
    columns : mapping of axis to str, optional
        Channels of the axes, where their names do not say it.
    settle : str
        Left out at the start of each window.
    corrected : bool
        The bias of a model was taken off before: what is left of it is ``model_bias_error``.
    start, stop, mission_start, frame : str, optional
        Of recordings: as ``inertialcal.read`` takes them. Records of the archive are taken in axes of the sensor.

    Raises
    ------
    DataError
        If a file cannot be read or cannot carry the answer.
    UsageError
        If it is not clear which column is what, in which unit, or how the head was turned.
    """
    files = [Path(one) for one in ([paths] if isinstance(paths, str | Path) else paths)]
    _check_once(files)
    if axis not in AXES:
        raise UsageError(f"axis {axis!r}", do="There are: x, y, z", code="unknown_name")
    standards: dict[str, Influence] = {}
    plan = Plan(
        axis=AXES[axis],
        settle=_quantity(settle, "s", "settle"),
        corrected=corrected,
        standards=standards,
    )
    spoken = None if unit is None else normalise(unit)
    part = {"start": start, "stop": stop, "mission_start": mission_start, "frame": frame}
    if len(files) == 1 and files[0].is_file() and _holds_means(files[0]):
        readings, inputs, shown, sources = _of_table(files[0], positions or {}, spoken)
    else:
        _no_tables(files)
        said = [Said(start, stop, _quantity(at, "rad", f"window {start}..{stop}")) for start, stop, at in windows]
        heads, inputs, shown, sources = _heads(files, spoken, columns, part)
        turned = _turned(heads, said, _quantity(angle, "rad", "angle"), mission_start)
        windowed = zip(sources.items(), turned, strict=True)
        sources = {path: replace(source, windows=one.windows) for (path, source), one in windowed}
        readings = readings_from(plan, turned)
    result = reduce(plan, readings)
    shown = _in_orbit(shown, result)
    rows = tuple(displayed(replace(row, test="flip"), shown) for row in result.rows())
    return FlipFile(result, rows, inputs, shown, result.remarks, sources)


def _check_once(files: Sequence[Path]) -> None:
    """Refuse a file that is given twice: its flips would count twice, and scatter by nothing."""
    known: set[Path] = set()
    for file in files:
        if file.resolve() in known:
            raise UsageError(f"{file}: given twice", why="its flips would count twice", code="duplicate_id")
        known.add(file.resolve())


def _no_tables(files: Sequence[Path]) -> None:
    """Refuse a table of means among several files."""
    tables = [file for file in files if file.is_file() and _holds_means(file)] if len(files) > 1 else []
    if tables:
        what = f"{tables[0]} is a table of means, one of {len(files)} files"
        why = "tables, or a table and recordings, are not taken together here"
        raise UsageError(what, why=why, do="Put all rows into one table, a flip a value", code="wrong_value")


def _quantity(given: str, unit: str, what: str) -> float:
    """Return a setting in a unit; that it needs one is said with the setting and the text given."""
    try:
        return float(parse_quantity(given).to(unit))
    except DataError:
        like = {"rad": "180 deg", "s": "20 s"}[unit]
        raise UsageError(
            f"{what}: {given!r}", do=f"Write a number with its unit, like {like}", code="no_unit"
        ) from None


def _in_orbit(unit: str, result: Result) -> str:
    """Return the unit to show: readings in g of a head in orbit are told in ug, as the field does."""
    largest = max((abs(value) for value in result.whole.values), default=np.inf)
    return "ug" if unit == "g" and largest < MICRO * factor("g", "m/s^2") else unit


def _holds_means(file: Path) -> bool:
    return file.suffix.lower() in {".csv", ".txt", ".tsv", ".gz"} and is_table_of_means(read_table(file))


def _of_table(
    file: Path, positions: Mapping[str, str], unit: str | None
) -> tuple[Readings, dict[str, str], str, dict[str, FlipSource]]:
    table = read_table(file)
    means = means_columns(table, positions, unit)
    readings = readings_of_means(means_of(table, means, str(file)))
    remarks = gather([*table.remarks, *table.missing(means.mean), *readings.remarks])
    readings = replace(readings, remarks=remarks)
    return readings, {str(file): table.source.sha256}, means.unit, {str(file): FlipSource({}, means=means)}


def _heads(
    files: Sequence[Path], unit: str | None, columns: Mapping[str, str] | None, part: Mapping[str, str | None]
) -> tuple[list[Recording], dict[str, str], str, dict[str, FlipSource]]:
    """Return the recordings with the axes of the head, SHA-256 of their files, the unit to show, what was taken."""
    heads, inputs, shown = [], {}, unit or ""
    sources: dict[str, FlipSource] = {}
    for file in files:
        said = {**part, "frame": part["frame"] or sensor_frame(file)}
        recording = read(file, **said)  # type: ignore[arg-type]
        units = [c.unit for c in recording.channels if c.unit and kind(c.unit) == "acceleration"]
        shown = shown or (units[0] if units else "")
        heads.append(head_recording(recording, columns, unit))
        inputs[str(file)] = recording.source.sha256
        taken = {
            axis: (name, unit or recording.channel(name).unit or "")
            for axis, name in axes_of(recording, columns).items()
        }
        sources[str(file)] = source_of(recording, taken, said["frame"] or "")
    return heads, inputs, shown or "m/s^2", sources


def _turned(
    heads: Sequence[Recording], said: Sequence[Said], angle: float, mission_start: str | None
) -> list[FlipRecording]:
    """Return the recordings with their windows, given or found; each recording is a flip."""
    if said:
        windows = given_windows(heads, said, mission_start)
        remarks: list[tuple[Remark, ...]] = [()] * len(heads)
    else:
        found = [found_windows(head, angle) for head in heads]
        windows, remarks = [one[0] for one in found], [one[1] for one in found]
    return [
        FlipRecording(
            replace(head, remarks=(*head.remarks, *more)),
            tuple(replace(window, flip=str(number)) for window in own),
            name=head.source.path,
        )
        for number, (head, own, more) in enumerate(zip(heads, windows, remarks, strict=True), 1)
    ]


__all__ = ["FlipFile", "flip"]
