"""What a folder holds for a first campaign: its files, and the topics of a file, each with the procedure that has it.

Topics of a file are recordings of their own, recorded together. Two that hold the same kind of sensor at the same time
are two sensors: which of them is meant is asked. One after the other they are recordings of one sensor.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from ...core.errors import InertialcalError
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.show.tables import clean
from ...core.units import normalise
from ...files.info.motion import accelerometers, any_accelerometers, gyros
from ...files.info.survey import survey_recording
from ...files.text.table import Table
from ...procedures import procedure_names, procedure_of
from ...procedures.given import Said
from ...procedures.suggestions import Claim, FolderFile, Strength
from ..calls.given import Files, with_said_columns
from .info import suggestions

ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".csv.gz", ".txt.gz", ".mat", ".h5", ".hdf5", ".npz",
           ".xlsx", ".xlsb", ".xls", ".ods", ".feather", ".arrow", ".wav", ".bag", ".db3", ".mcap", ".ulg", ".ulog",
           ".bin", ".log", ".tdms", ".uff", ".uff58", ".unv", ".mf4", ".mdf", ".ide", ".lvm", ".mseed", ".msd", ".seed",
           ".db", ".sqlite", ".sqlite3", ".jsonl", ".ndjson")  # fmt: skip
MOST = 200  # files
LISTED = 8  # columns, or topics
AMBIGUOUS = "ambiguous_date"  # code of a file whose dates can be read in two ways
Found = dict[str, dict[str, object]]  # what procedures make of files and topics, by procedure and label
Topics = tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """A file, or those topics of it that are one recording."""

    file: str
    topics: Topics = ()

    @property
    def label(self) -> str:
        """How messages and drafts call it."""
        return ", ".join((self.file, *self.topics))


@dataclass
class FolderContents:
    """What a folder holds.

    Parameters
    ----------
    found : dict
        What procedures make of it, by procedure and label.
    parts : dict of str to Part
        Topics of files by their label; a label that is not there is the name of a file.
    choices : dict of str to tuple of str
        Files whose topics hold several sensors of a kind: the topics to be taken, those that are one set first.
    tables : dict of str to Table
        Those that are no recordings, by label.
    ambiguous : list of str
        Files whose dates can be read in two ways.
    remarks : list of Remark
        What was left out, and why.
    """

    found: Found = field(default_factory=dict[str, dict[str, object]])
    parts: dict[str, Part] = field(default_factory=dict[str, Part])
    choices: dict[str, list[Topics]] = field(default_factory=dict[str, list[Topics]])
    tables: dict[str, Table] = field(default_factory=dict[str, Table])
    ambiguous: list[str] = field(default_factory=list[str])
    remarks: list[Remark] = field(default_factory=list[Remark])


@dataclass(frozen=True)
class _Read:
    """A part as it was read: as a table, and as a recording, where it has a time."""

    part: Part
    table: Table
    recording: Recording | None = None
    timed: bool = False

    @property
    def sensors(self) -> frozenset[str]:
        """Kinds of sensors that a recording holds."""
        if self.recording is None:
            return frozenset()
        kinds = {"gyro": gyros(self.recording), "acc": any_accelerometers(self.recording)}
        return frozenset(name for name, own in kinds.items() if own)

    @property
    def has_two(self) -> bool:
        """Whether topics that share a clock are two sensors of a kind."""
        channels = () if self.recording is None else self.recording.channels
        axes = [(one.quantity, one.axis) for one in channels if one.axis and one.quantity in ("gyro", "acc")]
        return len(self.part.topics) > 1 and len(set(axes)) < len(axes)

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant [s]."""
        stamps = None if self.recording is None else self.recording.stamps
        return (0.0, 0.0) if stamps is None or not len(stamps) else (stamps[0] / SECOND, stamps[-1] / SECOND)


@dataclass(frozen=True)
class _Taken:
    """A recording that a procedure has, and which other one could have it."""

    procedure: str
    reserve: str
    claim: Claim


def contents_of(root: Path, said: Said, answers: Mapping[str, str]) -> FolderContents:
    """Return what a folder holds; ``answers`` are units of sensors whose header says none."""
    reading = _Reading(Files(said), answers)
    contents = FolderContents()
    for name in procedure_names():
        contents.found[name], more = procedure_of(name).found_in(root)
        contents.remarks += more
    taken: dict[str, _Taken] = {}
    for path in sorted(root.rglob("*"))[:MOST]:
        file = path.relative_to(root).as_posix()
        if file.startswith((".", "out/", "out-cache/")) or not path.is_file() or not file.lower().endswith(ENDINGS):
            continue
        if file != os.fsencode(file).decode("utf-8", "replace"):
            what = "file name is not UTF-8: campaign.toml cannot hold it"
            contents.remarks.append(Remark("not_taken", "warning", what, clean(file), do="Rename the file"))
            continue
        try:
            _take(contents, taken, reading.parts(path, file))
        except InertialcalError as error:
            first = error.problems[0]
            if first.code == AMBIGUOUS:
                contents.ambiguous.append(file)
            contents.remarks.append(Remark("not_read", "warning", first.what, file, do=first.do))
    _settle(contents.found, taken)
    return contents


@dataclass(frozen=True)
class _Reading:
    """How the files of a folder are read."""

    files: Files
    answers: Mapping[str, str]

    def parts(self, path: Path, file: str) -> list[_Read]:
        """Return what a file holds: itself, or those of its topics that can be read, one each.

        Raises
        ------
        DataError, UsageError
            As ``files.read``, where nothing of it can be read.
        """
        said = tuple(self.files.said.topics)
        try:
            one = self._one(path, Part(file, said))
            return [one] if not one.has_two else self._each(path, file, said)
        except InertialcalError as error:
            first = error.problems[0]
            if first.code == "several_clocks" and len(said) > 1:
                wanted = said
            elif first.code == "wrong_column" and said:  # of another file
                return self._own(path, file, said)
            elif first.choices:
                wanted = first.choices
            else:
                raise
        return self._each(path, file, wanted)

    def _own(self, path: Path, file: str, said: Topics) -> list[_Read]:
        """Return those of the topics that were named, or all where the file has none of them."""
        other = _Reading(replace(self.files, said=replace(self.files.said, topics=[])), self.answers)
        try:
            return [other._one(path, Part(file))]
        except InertialcalError as error:
            choices = error.problems[0].choices
            if not choices:
                raise
        return other._each(path, file, tuple(one for one in choices if one in said) or choices)

    def _each(self, path: Path, file: str, topics: Topics) -> list[_Read]:
        found, errors = list[_Read](), list[InertialcalError]()
        for topic in topics:
            try:
                found.append(self._one(path, Part(file, (topic,))))
            except InertialcalError as error:
                errors.append(error)
        if not found:
            raise errors[0]
        return found

    def _one(self, path: Path, part: Part) -> _Read:
        """Return one part; a table of dwells is not read as a recording."""
        table = self.files.table(str(path), {"topics": list(part.topics) or None})
        if _claims(FolderFile(table)):
            return _Read(part, table)
        topics = {"topics": list(part.topics)} if part.topics else {}
        recording = with_said_columns(self.files.read(str(path), **topics), self.files.said)
        for group, unit in self.answers.items():
            open_ones = [one.name for one in recording.channels
                         if group in (one.quantity, one.name) and one.unit is None]  # fmt: skip
            recording = recording.with_unit(open_ones, normalise(unit), "flag") if open_ones else recording
        timed = recording.time_ns is not None or recording.sample_interval is not None
        return _Read(part, table, recording, timed)


def _take(contents: FolderContents, taken: dict[str, _Taken], parts: Sequence[_Read]) -> None:
    """Give the parts of a file to the procedures that claim them most.

    It is the one that `info` suggests, where that one claims it.
    """
    claimed = [_claimed(one, [other.recording for other in parts if other is not one]) for one in parts]
    fit = [(one, own) for one, own in zip(parts, claimed, strict=True) if own]
    if not fit:
        contents.remarks.append(_not_taken(parts))
        return
    sets = list(_sets([one for one, _ in fit]))
    if len(sets) > 1:
        file = parts[0].part.file
        contents.choices[file] = sets
        names = "; ".join(" with ".join(one) for one in sets[:LISTED])
        what = f"holds {len(sets)} sensors of a kind, recorded at the same time: {names}"
        do = f"Choose: {_options(sets[0])}"
        contents.remarks.append(Remark("not_taken", "warning", what, file, do=do))
        return
    for one, own in fit:
        label = one.part.label
        contents.parts |= {label: one.part} if one.part.topics else {}
        procedure, claim = own[0]
        if one.recording is not None:
            reserve = own[1] if len(own) > 1 else ("", claim)
            taken[label] = _Taken(procedure, *reserve)
        else:
            contents.tables[label] = one.table
        contents.found[procedure][label], remarks = claim.take()
        overruled = () if one.recording is None else one.recording.remarks
        contents.remarks += [found.at(label) for found in remarks]
        contents.remarks += [replace(found, where=label) for found in overruled if found.code == "unit_overridden"]


def _options(topics: Topics) -> str:
    return " ".join(f"--topic {shlex.quote(one)}" for one in topics)


def _sets(parts: Sequence[_Read]) -> Iterator[Topics]:
    """Yield topics that can be taken together: all, or one of each kind of sensor that was recorded at a time."""
    recordings = [one for one in parts if one.sensors]
    if not any(_clash(one, other) for i, one in enumerate(recordings) for other in recordings[:i]):
        yield tuple(topic for one in parts for topic in one.part.topics)
        return
    kinds = frozenset[str]().union(*(one.sensors for one in recordings))
    left = sorted(recordings, key=lambda one: one.sensors != kinds)  # one that has all is a set
    while left:
        own: list[_Read] = []
        for one in left:
            if not any(_clash(one, other) for other in own):
                own.append(one)
        left = [one for one in left if one not in own]
        yield tuple(topic for one in own for topic in one.part.topics)


def _clash(one: _Read, other: _Read) -> bool:
    """Whether two recordings hold a sensor of the same kind at the same time."""
    (first, last), (begin, end) = one.span, other.span
    return bool(one.sensors & other.sensors) and first <= end and begin <= last


def _claimed(one: _Read, beside: Sequence[Recording | None]) -> list[tuple[str, Claim]]:
    if one.recording is None:
        return _claims(FolderFile(one.table))
    if not one.timed:
        return []
    others = tuple(other for other in beside if other is not None)
    claimed = _claims(FolderFile(one.table, one.recording, others))
    if len(claimed) > 1:
        clear = [name for name, suggested in suggestions(one.recording, survey_recording(one.recording))
                 if suggested.strength > Strength.POSSIBLE]  # fmt: skip
        claimed.sort(key=lambda pair: pair[0] not in clear[:1])
    return claimed


def _claims(file: FolderFile) -> list[tuple[str, Claim]]:
    """Return what procedures claim, the strongest first, among equals in the order of the registry."""
    made = ((name, procedure_of(name).claims(file)) for name in procedure_names())
    return sorted(((name, one) for name, one in made if one is not None), key=lambda one: -one[1].strength)


def _not_taken(parts: Sequence[_Read]) -> Remark:
    """Return why no test can use a file."""
    first = parts[0]
    if len(parts) > 1:
        where = ", ".join(" ".join(one.part.topics) for one in parts[:LISTED])
        what = f"no test can use any of its recordings ({where})"
        return Remark("not_taken", "info", what, first.part.file)
    if first.timed and first.recording is not None and (moving := accelerometers(first.recording)):
        names = ", ".join(one.name for one in moving.values())
        what = f"accelerometers that move ({names}), as in no test that shows by itself"
        do = "Cut out the part that is a test, or give the file to the command of that test"
        return Remark("not_taken", "info", what, first.part.file, do=do)
    names = ", ".join(first.table.names[:LISTED]) + (", ..." if len(first.table.names) > LISTED else "")
    what = f"No rate and reading columns, and no gyro or accelerometer channels with time (columns: {names})"
    return Remark("not_taken", "info", what, first.part.file)


def _settle(found: Found, taken: dict[str, _Taken]) -> None:
    """Give recordings to their reserve where it has others of the folder, or where they are no test together."""
    for name in procedure_names():
        own = {file: one for file, one in taken.items() if one.procedure == name and one.reserve}
        reserves = {one.reserve for one in own.values()}
        have = any(one.procedure in reserves for one in taken.values())
        if own and (have or not procedure_of(name).belong_together([found[name][file] for file in own])):
            for file, one in own.items():
                del found[name][file]
                found[one.reserve][file] = one.claim.take()[0]
