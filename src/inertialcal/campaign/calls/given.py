"""What a call was given, as a store of a campaign: each file is read once, as was said."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ...core.batches import every
from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import Recording
from ...core.units import kind, normalise
from ...files import read, read_table
from ...files.budget import ANALYSIS, AS_WIDE, STREAMED, claim_recording
from ...files.info.describe import is_raw, overridden
from ...files.memory import numbers_of, of_array, the_only, with_named_units
from ...files.source import load as load_file
from ...files.text.headers import full_name, heading
from ...files.text.table import Table
from ...procedures.given import Said, bare, named_columns
from ...procedures.protocol import InputSpec
from ..file.recordings import RecordingEntry

T = TypeVar("T")
SENSORS = ("gyro", "acc")
Given = str | Path | Recording | Array
# Quantity of a unit that is given without a name.
GROUPS = {"angular_rate": "gyro", "acceleration": "acc"}


def text_said(said: Said) -> dict[str, Any]:
    """Return what was said of a text, as `files.read` takes it."""
    given = {"decimal": said.decimal, "skip": said.skip, "dates": said.dates}
    return {name: value for name, value in given.items() if value is not None}


def _reading(said: Said) -> dict[str, Any]:
    """Return what was said of a file but its columns and units, as `files.read` takes it."""
    return {
        "sample_rate": said.sample_rate, "time_column": said.time_column, "start": said.start, "stop": said.stop,
        "mission_start": said.mission_start, "frame": said.frame, "topics": said.topics or None, **text_said(said),
    }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Files:
    """Files and recordings by the name that messages use: a ``Store``.

    Parameters
    ----------
    said : Said
        How they are read.
    held : dict of str to Recording
        That were given, or have been read.
    read_as : dict of str to dict
        How those were read.
    work : (float, float)
        How much memory the procedure takes for a recording.
    """

    said: Said
    held: dict[str, Recording] = field(default_factory=dict[str, Recording])
    folder: Path | None = Path()
    read_as: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])
    work: tuple[float, float] = ANALYSIS

    def read(self, name: str, **reading: Any) -> Recording:
        """Return a recording, read as was said, but for what ``reading`` has else; those in memory as they are."""
        said = self.said
        if name in self.held and not any(value is not None for value in reading.values()):
            return self.held[name]
        wanted = _reading(said) | {one: value for one, value in reading.items() if value is not None}
        if name not in self.held or self.read_as.get(name, wanted) != wanted:
            units = {key: unit for key, unit in _by_column(said).items() if key != unit}
            try:
                found = read(name, units=units, **wanted)
            except UsageError as error:
                columns = {key: unit for key, unit in units.items() if key not in SENSORS}
                if error.problems[0].code != "wrong_column" or len(columns) == len(units):
                    raise
                found = read(name, units=columns, **wanted)  # of one sensor, or without a header
            claim_recording(found, self.work)
            self.held[name] = _with_unit(found, bare(said.units), said.columns)
            self.read_as[name] = wanted
        return self.held[name]

    def recording(self, entry: RecordingEntry, required: Sequence[str]) -> Recording:
        """Return a recording; a literal NaN in a required column is refused with its row."""
        from ..inputs.sources import reading_of  # noqa: PLC0415 - with scipy, which `info` needs not

        found = self.read(entry.file, **reading_of(entry))
        needed = [found.channel(name).data for name in required]
        empty = not all(every(data, lambda part: not np.isnan(part).any()) for data in needed if data.dtype.kind == "f")
        if empty and Path(entry.file).exists():
            read(entry.file, required=required, **reading_of(entry))
        return found

    def table(self, file: str, text: Mapping[str, Any] | None = None) -> Table:
        """Return the rows of a file."""
        from ..inputs.sources import table_of  # noqa: PLC0415 - as above

        if not Path(file).exists():
            raise DataError(
                f"{file}: a table of rows is needed, not a recording", do="Give the file", code="wrong_value"
            )
        stated = {name: value for name, value in (text or {}).items() if value is not None}
        return read_table(file, **table_of({"topics": self.said.topics or None} | text_said(self.said) | stated))

    def has(self, file: str) -> bool:
        """Return whether there is such a file."""
        return Path(file).is_file()

    def read_file(self, file: str, read_it: Callable[[Any], T]) -> tuple[T, str]:
        """Return what another file says, and its SHA-256."""
        return read_it(Path(file)), load_file(Path(file)).sha256


def files_of(given: Given | Sequence[Given], said: Said, inputs: InputSpec | None = None) -> tuple[list[str], Files]:
    """Return names of what was given, and the store that holds it.

    Raises
    ------
    UsageError
        If nothing is given, or a file twice: a copy is no second run.
    DataError
        If an array comes without its sample rate.
    """
    several = given_items(given)
    if not several:
        raise UsageError("no file", do="Name a recording")
    streamed, as_wide = inputs is not None and inputs.streamed, inputs is not None and inputs.as_wide
    files = Files(said, work=STREAMED if streamed else AS_WIDE if as_wide else ANALYSIS)
    names: list[str] = []
    known: set[str] = set()
    for number, one in enumerate(several, 1):
        if isinstance(one, str | Path):
            name, identity = str(one), os.path.realpath(one)
            if name != os.fsencode(name).decode("utf-8", "replace"):
                raise UsageError("file name is not UTF-8", name, "results name their inputs", "Rename it", "file_name")
        elif isinstance(one, Recording):
            name, identity = one.source.path or f"recording_{number}", str(id(one))
            files.held[name] = _with_unit(with_named_units(one, _by_column(said)), bare(said.units), said.columns)
        else:
            name, identity = f"array_{number}", str(id(one))
            files.held[name] = of_array(numbers_of(one), said.sample_rate, next(iter(said.units.values()), None))
        if identity in known or name in names:
            raise UsageError(f"{name}: given twice", why="a copy is not a second run", code="duplicate_id")
        known.add(identity)
        names.append(name)
    return names, files


def read_as_said(given: Given, said: Said, *, whole: bool = False) -> Recording:
    """Return one recording as was said: the columns that were named alone, each as what it was named for.

    ``whole``: all of its columns, as the file has them.

    Raises
    ------
    UsageError, DataError
        As ``files.read``; ``duplicate_id`` where a column is named for two channels.
    """
    one, columns = the_only(given), {} if whole else said.columns
    meant = {heading(what).quantity or _group(said) for what in columns}
    units = {key: unit for key, unit in _by_column(said).items() if key != unit}
    later = {key: units.pop(key) for key in list(units) if key in SENSORS and key in meant}
    reading = _reading(said) if isinstance(one, str | os.PathLike) else {
        name: getattr(said, name) for name in ("sample_rate", "start", "stop", "mission_start")}  # fmt: skip
    found = _with_unit(read(one, units=units, **reading), bare(said.units), said.columns)
    found = with_columns(found, columns, _group(said))
    bare_ones = [one for one in found.channels if one.unit is None and one.quantity in later]
    for channel in bare_ones:
        found = found.with_unit([channel.name], normalise(later[channel.quantity]), "flag")
    return found


def with_columns(recording: Recording, columns: Mapping[str, str], group: str = "") -> Recording:
    """Return a recording of the columns that are named, each as if its header said what it is named for.

    ``group`` is the sensor of an axis that has no unit.

    Raises
    ------
    DataError
        ``wrong_column`` where there is no such column.
    UsageError
        ``duplicate_id`` where one is named for two channels.
    """
    full = named_columns(recording, columns)
    channels = []
    for what, name in full.items():
        if others := [one for one, same in full.items() if same == name and one != what]:
            twice = f"column {name!r} is given for {what} and {others[0]}"
            raise UsageError(twice, recording.source.path, do="Each channel has its own column", code="duplicate_id")
        channel = recording.channel(name)
        if columns[what] != what:  # one given by its name alone is what its header says
            meant = heading(what)
            quantity = meant.quantity or channel.quantity or GROUPS.get(kind(channel.unit) if channel.unit else "", "")
            quantity = quantity or (group if meant.axis else "")
            channel = replace(channel, axis=meant.axis, quantity=quantity)
        channels.append(channel)
    return replace(recording, channels=tuple(channels)) if columns else recording


def with_said_columns(recording: Recording, said: Said) -> Recording:
    """Return a recording `with_columns` of those that were named and are there: of several files, each has its own."""
    there = {what: name for what, name in said.columns.items() if full_name(recording.names, name)}
    return with_columns(recording, there, _group(said))


def _group(said: Said) -> str:
    """Return the sensor whose unit was said; empty where that is not one."""
    found = [one for one in SENSORS if one in said.units]
    return found[0] if len(found) == 1 else ""


def renamed(recording: Recording, columns: Mapping[str, str]) -> Recording:
    """Return a recording `with_columns` whose channels are called what they were named for: ``gyro_x`` for ``x``."""
    meant = {name: what for what, name in named_columns(recording, columns).items() if columns[what] != what}
    names = {one.name: f"{one.quantity}_{what}" if (what := meant.get(one.name, "")) in AXES and one.quantity else what
             for one in recording.channels}  # fmt: skip
    channels = tuple(replace(one, name=names[one.name] or one.name) for one in recording.channels)
    return replace(recording, channels=channels)


def given_items(given: Given | Sequence[Given]) -> list[Given]:
    """Return what was given, one by one.

    Raises
    ------
    UsageError
        ``wrong_type``, if one is neither a path, a Recording nor an array.
    """
    kinds = str | Path | Recording | np.ndarray
    items: list[Any] = (
        [given] if isinstance(given, kinds) or not isinstance(given, Sequence | Iterator) else list(given)
    )
    for one in items:
        if not isinstance(one, kinds):
            what = f"a recording of type {type(one).__name__}"
            raise UsageError(what, do="Give paths, Recordings, or arrays with their sample_rate", code="wrong_type")
    return items


def _by_column(said: Said) -> dict[str, str]:
    """Return units by column where they were given by channel: ``x`` of ``--column x=speed``."""
    return {said.columns.get(key, key): unit for key, unit in said.units.items()}


def _with_unit(recording: Recording, unit: str | None, columns: Mapping[str, str]) -> Recording:
    """Return a recording with a unit without a name: of all of its kind, else of an axis, else named, else nameless."""
    if unit is None:
        return recording
    group = GROUPS.get(kind(unit), "")  # counts and volts are those of any axis
    axes = [one for one in recording.channels if one.axis in AXES]
    every = [one for one in recording.channels if group and one.quantity == group]
    own = [one for one in every if not is_raw(one.unit, unit)]
    if not own and any(one in every for one in axes):
        return recording  # counts or volts by its header: they become rates by a chain alone
    own = [one for one in own if one.unit is None or one.axis] or own  # not the rate of the table, which states its own
    own = own or [one for one in axes if not one.quantity or (not group and one.quantity in GROUPS.values())]
    readings = {full_name(recording.names, name) for what, name in columns.items()
                if what == name or heading(what).quantity in ("", group)}  # fmt: skip
    own = own or [one for one in recording.channels if one.name in readings and one.unit is None]
    if not own and not axes and not columns:  # names that say nothing: what no header tells is a reading
        own = [one for one in recording.channels if not one.quantity and one.unit is None]
    named, unit = {one.name for one in own}, normalise(unit)
    channels = [replace(one, unit=unit, unit_from="flag", quantity=group or one.quantity)
                if one.name in named else one for one in recording.channels]  # fmt: skip
    said = overridden([(one.name, one.unit, unit) for one in own], recording.source.path)
    return replace(recording, channels=tuple(channels), remarks=(*recording.remarks, *said))


__all__ = ["Files", "Given", "files_of", "given_items", "read_as_said", "renamed", "with_said_columns"]
