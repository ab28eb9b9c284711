"""A first campaign.toml for the recordings of a folder: what is known is filled in, what is not is marked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ...core.campaign_text import FILE, MARK, SCHEMA, Noted, toml_text
from ...core.errors import PlanError, UsageError
from ...core.remarks import Remark
from ...files.own import own
from ...files.write.atomic import atomic_write
from ...procedures import procedure_of
from ...procedures.given import Said
from ...procedures.suggestions import RELATIVE, Question, fill_in
from ...sensors.catalogue import PublishedSensor, published_sensor
from .data_sheet import requirements, unjudged, with_facts
from .folder import FolderContents, contents_of
from .questions import ITEM, answered, questions
from .settled import settle


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
    contents = _found(folder, told, asking=True)
    return next(questions(contents, told.said, told.axis, told.item), None)


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
    contents = _found(root, told)
    text, remarks = starter_text(root.resolve().name, contents, published, told), contents.remarks
    if published is not None and f'kind = "{published.kind}"' not in text:
        article = "an" if published.kind == "accelerometer" else "a"
        what = f"{published.item.part} is {article} {published.kind}: no recording here is of one"
        remarks.append(Remark("not_taken", "warning", what, do="Add its recordings"))
    with atomic_write(path, new=True) as aside:
        aside.write_text(text, encoding="utf-8", newline="\n")
    lines = [number for number, line in enumerate(text.splitlines(), 1) if line.rstrip().endswith(MARK)]
    return path, lines, tuple(remarks)


def _found(folder: str | Path, told: Told, *, asking: bool = False) -> FolderContents:
    """Return what a folder holds, and what was left out; refuse one with a campaign, or with nothing."""
    root = Path(folder)
    if (ours := own(root)) is not None and ours.file != FILE:
        raise PlanError(f"{root} is {ours.what}", do=f"Try: {ours.do}", code="exists")
    if not root.is_dir():
        raise UsageError(f"No such folder: {root}")
    path = root / FILE
    if path.exists():
        raise PlanError(f"{path} exists already", do=f"Try: inertialcal check {root}", code="exists")
    with np.errstate(over="ignore", invalid="ignore"):  # of numbers that nothing has: they suggest nothing
        known = {group: unit for group, unit in told.said.units.items() if unit}  # a question passed over gives none
        answers = {group: unit for group, unit in known.items() if group in told.asked}
        stated = {group: unit for group, unit in known.items() if group not in told.asked}
        contents = contents_of(root, replace(told.said, units=stated, dates=told.said.dates or None), answers)
    open_files = [*contents.ambiguous, *contents.choices] if asking else []
    if not any(contents.found.values()) and not open_files:
        do = "Add recordings with gyro or accelerometer channels, tables with columns of rate and reading (a row per "
        do += "dwell), or tables of means (a row per axis and orientation)"
        what = f"No recording or table in {root} that a test can use"
        if unread := [one for one in contents.remarks if one.code in ("not_read", "not_taken")]:
            first = max(unread, key=lambda one: bool(one.do))
            what, do = f"{what}; {first.where}: {first.what}", first.do or do
        raise PlanError(what, do=do, code="nothing_found")
    return contents


def starter_text(
    name: str, contents: FolderContents, published: PublishedSensor | None = None, told: Told | None = None
) -> str:
    """Return the text of a campaign file.

    Parameters
    ----------
    name : str
        Of the campaign.
    contents : FolderContents
        What its folder holds.
    published : PublishedSensor, optional
        Whose data sheet becomes facts and requirements.
    told : Told, optional
        What is known beside the files.
    """
    told = told or Told()
    identifier = (
        "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "-" for c in name).strip("-_") or "campaign"
    )
    drafts = [procedure_of(one).draft(own) for one, own in contents.found.items() if own]
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
    settle(parts, tests, told.said, told.axis or "", contents.parts)
    document |= parts
    if parts["standards"]:
        document["standards"] = Noted(parts["standards"], above=RELATIVE)
    document["tests"] = tests
    examples = sorted((one for one in drafts if one.requirement), key=lambda one: not one.example)
    asked = [Noted({"id": "R1", **one.requirement}, example=True) for one in examples[:1]]
    document["requirements"] = asked if published is None else [*asked, *requirements(published)]
    return toml_text(document)
