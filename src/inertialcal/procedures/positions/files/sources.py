"""Static intervals and rotations out of files, without a campaign file: what is which, and of which sensor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ....core.errors import DataError, UsageError
from ....core.estimate import Array
from ....core.labelled import LabelledPart
from ....core.recording import SECOND, Recording
from ....files import read
from ....files.text.table import read_table
from ..gravity import site_problems, turn_problems
from ..orientations.text import direction_of, runs_of, sections_of, turn_of
from ..plan import Plan
from ..readings import Readings
from ..recordings import Section, readings_from
from .channels import SENSORS, Taken, taken
from .tables import is_table, readings_columns, table_readings

GAP = 1.0  # between files that are put one after the other [s]
OWN = ("acc", "gyro", "temperature")  # units that are said of sensors, and not of columns of time


@dataclass(frozen=True)
class File:
    """A file with what the user called it: ``acc``, ``gyro``, a position or turn in words, or nothing."""

    path: Path
    called: str = ""


@dataclass(frozen=True)
class Asked:
    """What the user said of the files.

    Parameters
    ----------
    columns, units : mapping of str to str
        As `positions_channels.taken`.
    sample_rate : float or None
        [Hz]
    time_column : str or None
        Column with the time.
    sections : str or None
        File of labelled parts, or column of labels.
    turn : float
        Angle of each turn [rad].
    faces : bool
        Each position lies on the nearest of the six faces.
    start, stop : str or None
        The part to use.
    """

    columns: Mapping[str, str]
    units: Mapping[str, str]
    sample_rate: float | None = None
    time_column: str | None = None
    sections: str | None = None
    turn: float = 2.0 * math.pi
    faces: bool = False
    start: str | None = None
    stop: str | None = None


@dataclass(frozen=True, eq=False)
class Sources:
    """Readings, with the files and columns that they come from.

    Parameters
    ----------
    readings : Readings
        Of all files.
    columns, units : mapping of str to str
        As `positions_channels.Taken`.
    inputs : mapping of str to str
        SHA-256 by path.
    """

    readings: Readings
    columns: Mapping[str, str]
    units: Mapping[str, str]
    inputs: Mapping[str, str]


def named_files(given: Sequence[str | Path]) -> tuple[File, ...]:
    """Return the files, with what stands before an equals sign.

    Raises
    ------
    UsageError
        ``duplicate_id`` if a file is given twice; ``unknown_name`` for a word that is none.
    """
    found: list[File] = []
    for one in given:
        label, equals, path = str(one).partition("=")
        file = File(Path(path), label.strip()) if equals and not Path(str(one)).exists() else File(Path(str(one)))
        known = (
            file.called in ("", *SENSORS) or direction_of(file.called) is not None or turn_of(file.called) is not None
        )
        if not known:
            do = "There are: acc=FILE, gyro=FILE, x+=FILE, x-=FILE, ..., x_rot=FILE"
            raise UsageError(f"{one}: {file.called!r} is no name of a file's part", do=do, code="unknown_name")
        if any(other.path.resolve() == file.path.resolve() for other in found):
            why = "a copy is no repeat: its positions would count twice"
            raise UsageError(f"{file.path}: given twice", why=why, code="duplicate_id")
        found.append(file)
    if not found:
        raise UsageError("no file", do="Name a recording")
    return tuple(found)


def sources(plan: Plan, files: Sequence[File], asked: Asked) -> Sources:
    """Return what files hold.

    Raises
    ------
    UsageError
        If it is not clear which file or channel is what.
    DataError
        As ``positions.recordings.readings_from``, and where files cannot be read.
    """
    problems = [*site_problems(plan), *turn_problems(asked.turn)]
    if problems:
        raise UsageError(problems)
    recordings = [_read(file, asked) for file in files]
    inputs = {str(f.path): r.source.sha256 for f, r in zip(files, recordings, strict=True)}
    if len(files) == 1 and is_table(recordings[0]) and asked.sections is None:
        table = read_table(files[0].path)
        own = taken([readings_columns(recordings[0])], [""], asked.columns, asked.units)
        return Sources(table_readings(table, own), own.columns, own.units, inputs)
    takens = _takens(files, recordings, asked)
    with _placed(files[0].path if len(files) == 1 else None):
        readings = _readings(plan, files, takens, asked)
    remarks = (*(remark for one in takens for remark in one.remarks), *readings.remarks)
    return Sources(replace(readings, remarks=remarks), takens[0].columns, takens[0].units, inputs)


def _readings(plan: Plan, files: Sequence[File], takens: Sequence[Taken], asked: Asked) -> Readings:
    """Return static intervals and rotations of files, each of a position or all as they were recorded."""
    labelled = [file.called for file in files if file.called not in ("", *SENSORS)]
    whole = [one.recording for one in takens]
    if labelled:
        return _of_labelled(plan, files, whole, asked)
    sections = [_sections(files[0].path, whole[0], asked)] if asked.sections is not None else []
    return readings_from(plan, whole, sections, asked.faces)


@contextmanager
def _placed(path: Path | None) -> Iterator[None]:
    """Put the file before what is refused without it, and say settings as they are said of files."""
    try:
        yield
    except DataError as error:
        ways = {"no_rest": "Let it rest in each position, or say which rest counts: --shortest '2 s'"}
        found = [replace(one, do=ways.get(one.code, one.do)) for one in error.problems]
        if path is not None:
            found = [one if str(path) in one.where else replace(one, where=_before(path, one.where)) for one in found]
        raise DataError(found) from None


def _before(path: Path, where: str) -> str:
    return f"{path}: {where}" if where else str(path)


def _read(file: File, asked: Asked) -> Recording:
    units = {name: unit for name, unit in asked.units.items() if name not in OWN}
    time = {name: unit for name, unit in units.items() if name not in asked.columns}
    return read(
        file.path, units=time or None, sample_rate=asked.sample_rate, time_column=asked.time_column,
        start=asked.start, stop=asked.stop,
    )  # fmt: skip


def _takens(files: Sequence[File], recordings: Sequence[Recording], asked: Asked) -> list[Taken]:
    """Return the channels of each recording; two files of one sensor each are one recording.

    Raises
    ------
    DataError
        ``wrong_unit`` if recordings of one test differ in their units.
    """
    sensors = [file.called if file.called in SENSORS else "" for file in files]
    pair = len(files) == 2 and (any(sensors) or _of_one_sensor_each(recordings))
    if pair or sensors == ["acc"]:
        return [taken(recordings, sensors, asked.columns, asked.units)]
    if sensors == ["gyro"]:
        do = "Give the accelerometers of the same clock too: acc=FILE"
        raise UsageError(f"{files[0].path}: gyros alone", why="gravity is what calibrates", do=do, code="no_column")
    if any(sensors):
        do = "Give one acc=FILE and one gyro=FILE of the same clock"
        raise UsageError(f"{len(files)} file(s), of which some are named acc or gyro", do=do, code="wrong_value")
    found = [taken([one], [""], asked.columns, asked.units) for one in recordings]
    if any(one.units != found[0].units for one in found):
        listed = "; ".join(f"{f.path.name}: {_listed(one.units)}" for f, one in zip(files, found, strict=True))
        raise DataError(f"recordings of one test differ in sensors or units: {listed}", code="wrong_unit")
    return found


def _listed(units: Mapping[str, str]) -> str:
    return ", ".join(f"{sensor} in {unit}" for sensor, unit in units.items())


def _of_one_sensor_each(recordings: Sequence[Recording]) -> bool:
    """Whether one file is of accelerometers alone and the other of gyros, by names of channels, else of files."""
    kinds = []
    for one in recordings:
        own = {c.quantity for c in one.channels if c.quantity in SENSORS}
        name = Path(one.source.path).name.lower()
        if not own:
            own = {sensor for sensor, word in (("acc", "acc"), ("gyro", "gyr")) if word in name}
        kinds.append(own)
    return sorted(kinds, key=sorted) == [{"acc"}, {"gyro"}]


def _sections(path: Path, recording: Recording, asked: Asked) -> tuple[Section, ...]:
    """Return the labelled parts of a recording, by a file of them or by a column of labels."""
    if asked.start is not None or asked.stop is not None:
        do = "Leave --from and --to out: the sections say which part is used"
        raise UsageError("sections, and a part of the recording", why="samples are counted from its start", do=do)
    given = str(asked.sections)
    if Path(given).is_file():
        return tuple(section_of(one, recording, asked.turn) for one in sections_of(Path(given)))
    table = read_table(path)
    if given not in table.names:
        what = f"--sections {given!r}: neither a file nor a column of {path}"
        raise UsageError(what, do=f"Columns: {', '.join(table.names)}", code="no_column")
    said = runs_of(table.text(given))
    known = [one for one in said if direction_of(one.label) is not None or turn_of(one.label) is not None]
    if not known:
        labels = ", ".join(dict.fromkeys(one.label for one in said))
        do = "Labels are like x_p, x_a, x_rot"
        raise DataError(f"column {given!r} names no position and no turn: {labels[:120]}", str(path), do=do,
                        code="unknown_name")  # fmt: skip
    return tuple(section_of(one, recording, asked.turn) for one in known)


def section_of(said: LabelledPart, recording: Recording, turn: float) -> Section:
    """Return a labelled part in samples; a turn by its own angle, else by the one given [rad].

    Raises
    ------
    DataError
        ``no_time`` if it is in seconds and the recording has none.
    """
    start, stop = said.start, said.stop
    if said.seconds:
        seconds = recording.seconds
        if seconds is None:
            do = "Give the sample rate, or samples"
            raise DataError(f"section {said.label!r} is in seconds, the recording has no time", do=do, code="no_time")
        start, stop = (float(np.searchsorted(seconds, one)) for one in (start, stop))
    return named_section(said.label, round(start), round(stop), turn if said.angle is None else said.angle)


def named_section(label: str, start: int, stop: int, turn: float) -> Section:
    """Return samples [start, stop) as the position, or the turn by an angle [rad], that the label says."""
    axis = turn_of(label)
    if axis is not None:
        return Section(start, stop, axis=_triple(axis), angle=turn, name=label)
    direction = direction_of(label)
    known = direction is not None and bool(np.isfinite(direction).all())
    return Section(start, stop, _triple(direction) if known and direction is not None else None, name=label)


def _triple(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(one) for one in vector)
    return x, y, z


def _of_labelled(plan: Plan, files: Sequence[File], recordings: Sequence[Recording], asked: Asked) -> Readings:
    """Return positions of which each is a file of its own, and turns likewise."""
    if any(not file.called for file in files):
        unnamed = next(file.path for file in files if not file.called)
        do = "Name all of them, like x+=FILE, or none"
        raise UsageError(f"{unnamed} is not named, others are", do=do, code="wrong_value")
    sections, at = [], 0
    for file, one in zip(files, recordings, strict=True):
        sections.append(named_section(file.called, at, at + len(one), asked.turn))
        at += len(one)
    return readings_from(plan, [_in_a_row(recordings)], [sections], asked.faces)


def _in_a_row(recordings: Sequence[Recording]) -> Recording:
    """Return recordings as one, each after the one before it."""
    first = recordings[0]
    names = [name for name in first.names if all(name in one.names for one in recordings)]
    channels = tuple(
        replace(first.channel(name), data=np.concatenate([one.channel(name).data for one in recordings]))
        for name in names
    )
    times, begin = [], 0
    for one in recordings:
        seconds = one.seconds
        if seconds is None:
            do = "Give the sample rate"
            raise DataError("no time", one.source.path, "rotations are rates over time", do, "no_time")
        own = np.round(seconds * SECOND).astype(np.int64)
        times.append(begin + own)
        begin = int(times[-1][-1]) + round(GAP * SECOND)
    remarks = tuple(dict.fromkeys(remark for one in recordings for remark in one.remarks))
    source = replace(first.source, path="")
    return replace(
        first, channels=channels, time_ns=np.concatenate(times), epoch="elapsed", remarks=remarks, source=source
    )
