"""A first campaign.toml for the recordings of a folder: what is known is filled in, what is not is marked."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ...core.campaign_text import FILE, MARK, SCHEMA, Noted, toml_text
from ...core.errors import InertialcalError, PlanError, UsageError
from ...core.remarks import Remark
from ...core.show.tables import clean
from ...core.units import normalise
from ...files.info.survey import survey_recording
from ...files.write.atomic import atomic_write
from ...procedures import procedure_names, procedure_of
from ...procedures.given import Said
from ...procedures.suggestions import RELATIVE, Claim, FolderFile, Question, Strength, fill_in
from ...sensors.catalogue import PublishedSensor, published_sensor
from ..calls.given import Files, with_said_columns
from .data_sheet import requirements, unjudged, with_facts
from .info import suggestions
from .questions import ITEM, answered, questions
from .settled import settle

ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".csv.gz", ".txt.gz", ".mat", ".h5", ".hdf5", ".npz",
           ".xlsx", ".xlsb", ".xls", ".ods", ".feather", ".arrow", ".wav", ".bag", ".db3", ".mcap", ".ulg", ".ulog",
           ".bin", ".log", ".tdms", ".uff", ".uff58", ".unv", ".mf4", ".mdf", ".ide", ".lvm", ".mseed", ".msd", ".seed",
           ".db", ".sqlite", ".sqlite3", ".jsonl", ".ndjson")  # fmt: skip
MOST = 200  # files
AMBIGUOUS = "ambiguous_date"  # code of a file whose dates can be read in two ways
Found = dict[str, dict[str, object]]  # what procedures make of files, by procedure and file


@dataclass(frozen=True)
class Told:
    """What is known of a folder beside its files: options, and answers to `questions`.

    Parameters
    ----------
    said : Said
        Units, chain, site, how texts are read.
    axis : str, optional
        That was turned on a rate table; empty where the answer is to be filled in.
    item : mapping of str to str
        Maker, part and serial number of the sensor.
    asked : set of str
        Kinds of sensors whose unit in ``said`` is an answer: it holds where a header says none, as the question does.
    """

    said: Said = field(default_factory=Said)
    axis: str | None = None
    item: Mapping[str, str] = field(default_factory=dict[str, str])
    asked: frozenset[str] = frozenset()

    def answered(self, question: Question, text: str) -> Told:
        """Return the same with one more answer."""
        if question.name == "axis":
            return replace(self, axis=text)
        if question.name in ITEM:
            return replace(self, item={**self.item, question.name: text})
        asked = self.asked | ({question.group} if question.name == "units" else set())
        return replace(self, said=answered(self.said, question, text), asked=asked)


def first_question(folder: str | Path, told: Told) -> Question | None:
    """Return the next question on the files of a folder; None where nothing is left to ask.

    Raises
    ------
    UsageError, PlanError
        As `start`.
    """
    found, remarks = _found(folder, told)
    ambiguous = [one.where for one in remarks if one.subject == AMBIGUOUS]
    return next(questions(found, ambiguous, told.said, told.axis, told.item), None)


def start(folder: str | Path, sensor: str = "", told: Told | None = None) -> tuple[Path, list[int], tuple[Remark, ...]]:
    """Write a first campaign.toml for the tables and recordings of a folder.

    Parameters
    ----------
    folder : path
        Holds the files; campaign.toml is written into it.
    sensor : str
        Published sensor, by its name in the catalogue or its part: its data sheet becomes facts and requirements.
    told : Told, optional
        What is known beside the files.

    Returns
    -------
    (path, lines, remarks)
        The file; the lines to fill in; which files were left out and why.

    Raises
    ------
    UsageError
        If the folder does not exist, or there is no such sensor (``unknown_sensor``).
    PlanError
        If it already holds a campaign, or no file that a test can use.
    """
    root, published = Path(folder), published_sensor(sensor) if sensor else None
    told, path = told or Told(), root / FILE
    found, remarks = _found(root, told)
    text = starter_text(root.resolve().name, found, published, told)
    if published is not None and f'kind = "{published.kind}"' not in text:
        article = "an" if published.kind == "accelerometer" else "a"
        what = f"{published.item.part} is {article} {published.kind}: no recording here is of one"
        remarks.append(Remark("not_taken", "warning", what, do="Add its recordings"))
    with atomic_write(path, new=True) as aside:
        aside.write_text(text, encoding="utf-8", newline="\n")
    lines = [number for number, line in enumerate(text.splitlines(), 1) if line.rstrip().endswith(MARK)]
    return path, lines, tuple(remarks)


def _found(folder: str | Path, told: Told) -> tuple[Found, list[Remark]]:
    """Return what a folder holds, and what was left out; refuse one with a campaign, or with nothing."""
    root = Path(folder)
    if not root.is_dir():
        raise UsageError(f"No such folder: {root}")
    path = root / FILE
    if path.exists():
        raise PlanError(f"{path} exists already", do=f"Try: inertialcal check {root}", code="exists")
    with np.errstate(over="ignore", invalid="ignore"):  # of numbers that nothing has: they suggest nothing
        known = {group: unit for group, unit in told.said.units.items() if unit}  # a question passed over gives none
        answers = {group: unit for group, unit in known.items() if group in told.asked}
        stated = {group: unit for group, unit in known.items() if group not in told.asked}
        found, remarks = _files(root, replace(told.said, units=stated), answers)
    if not any(found.values()) and not any(one.subject == AMBIGUOUS for one in remarks):
        do = "Add recordings with gyro or accelerometer channels, tables with columns of rate and reading (a row per "
        do += "dwell), or tables of means (a row per axis and orientation)"
        what = f"No recording or table in {root} that a test can use"
        if unread := [one for one in remarks if one.code == "not_read"]:
            what, do = f"{what}; {unread[0].where}: {unread[0].what}", unread[0].do
        raise PlanError(what, do=do, code="nothing_found")
    return found, remarks


@dataclass(frozen=True)
class _Taken:
    """A recording that a procedure has, and which other one could have it."""

    procedure: str
    reserve: str
    claim: Claim


def _files(root: Path, said: Said, answers: Mapping[str, str]) -> tuple[Found, list[Remark]]:
    """Return what a folder holds, and what was left out; ``answers`` are units of sensors whose header says none."""
    read = Files(said)
    found: Found = {}
    remarks: list[Remark] = []
    for name in procedure_names():
        found[name], more = procedure_of(name).found_in(root)
        remarks += more
    taken: dict[str, _Taken] = {}
    for path in sorted(root.rglob("*"))[:MOST]:
        file = path.relative_to(root).as_posix()
        if file.startswith((".", "out/", "out-cache/")) or not path.is_file() or not file.lower().endswith(ENDINGS):
            continue
        if file != os.fsencode(file).decode("utf-8", "replace"):
            what = "file name is not UTF-8: campaign.toml cannot hold it"
            remarks.append(Remark("not_taken", "warning", what, clean(file), do="Rename the file"))
            continue
        try:
            remarks += _take(found, taken, path, file, read, answers)
        except InertialcalError as error:
            first = error.problems[0]
            subject = AMBIGUOUS if first.code == AMBIGUOUS else ""
            remarks.append(Remark("not_read", "warning", first.what, file, do=first.do, subject=subject))
    _settle(found, taken)
    return found, remarks


def _take(
    found: Found, taken: dict[str, _Taken], path: Path, name: str, files: Files, answers: Mapping[str, str]
) -> list[Remark]:
    """Give a file to the procedure that claims it most; return what there is to remark.

    It is the one that `info` suggests, where that one claims it.
    """
    table, overruled = files.table(str(path)), list[Remark]()
    claimed = _claims(FolderFile(table))
    if not claimed:
        recording = with_said_columns(files.read(str(path)), files.said)
        for group, unit in answers.items():
            open_ones = [one.name for one in recording.channels
                         if group in (one.quantity, one.name) and one.unit is None]  # fmt: skip
            recording = recording.with_unit(open_ones, normalise(unit), "flag") if open_ones else recording
        overruled = [one for one in recording.remarks if one.code == "unit_overridden"]
        timed = recording.time_ns is not None or recording.sample_interval is not None
        claimed = _claims(FolderFile(table, recording)) if timed else []
        if len(claimed) > 1:
            clear = [one for one, suggested in suggestions(recording, survey_recording(recording))
                     if suggested.strength > Strength.POSSIBLE]  # fmt: skip
            claimed.sort(key=lambda pair: pair[0] not in clear[:1])
        if not claimed:
            names = ", ".join(table.names[:8]) + (", ..." if len(table.names) > 8 else "")
            what = f"No rate and reading columns, and no gyro or accelerometer channels with time (columns: {names})"
            return [Remark("not_taken", "info", what, name)]
        if len(claimed) > 1:
            taken[name] = _Taken(claimed[0][0], claimed[1][0], claimed[1][1])
        else:
            taken[name] = _Taken(claimed[0][0], "", claimed[0][1])
    procedure, claim = claimed[0]
    found[procedure][name], remarks = claim.take()
    return [*(one.at(name) for one in remarks), *(replace(one, where=name) for one in overruled)]


def _claims(file: FolderFile) -> list[tuple[str, Claim]]:
    """Return what procedures claim, the strongest first, among equals in the order of the registry."""
    made = ((name, procedure_of(name).claims(file)) for name in procedure_names())
    return sorted(((name, one) for name, one in made if one is not None), key=lambda one: -one[1].strength)


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


def starter_text(name: str, found: Found, published: PublishedSensor | None = None, told: Told | None = None) -> str:
    """Return the text of a campaign file.

    Parameters
    ----------
    name : str
        Of the campaign.
    found : dict of str to dict
        What its folder holds, by procedure and file.
    published : PublishedSensor, optional
        Whose data sheet becomes facts and requirements.
    told : Told, optional
        What is known beside the files.
    """
    told = told or Told()
    identifier = (
        "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "-" for c in name).strip("-_") or "campaign"
    )
    drafts = [procedure_of(one).draft(contents) for one, contents in found.items() if contents]
    document: dict[str, object] = {
        "schema": SCHEMA,
        "campaign": {"id": identifier},
        "item": {name: told.item.get(name, fill_in("")) for name in ITEM},
    }
    parts: dict[str, dict[str, object]] = {"site": {}, "standards": {}, "sensors": {}, "recordings": {}}
    for draft in drafts:
        for part in parts:
            parts[part] |= getattr(draft, part)
    if published is not None:
        item = published.item
        said = {"maker": item.maker or fill_in(""), "part": item.part, "serial": fill_in(""), **told.item}
        document["item"] = Noted(said, above=unjudged(published))
        parts["sensors"] = with_facts(parts["sensors"], published)
    tests = [test for draft in drafts for test in draft.tests]
    settle(parts, tests, told.said, told.axis or "")
    document |= parts
    if parts["standards"]:
        document["standards"] = Noted(parts["standards"], above=RELATIVE)
    document["tests"] = tests
    examples = sorted((one for one in drafts if one.requirement), key=lambda one: not one.example)
    asked = [Noted({"id": "R1", **one.requirement}, example=True) for one in examples[:1]]
    document["requirements"] = asked if published is None else [*asked, *requirements(published)]
    return toml_text(document)
