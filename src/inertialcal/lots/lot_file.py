"""LOT.toml: one campaign, a table of units, and where the recordings of each unit lie.

::

    schema = 1
    id = "gyros-2026-07"
    campaign = "campaign.toml"
    units = "units.csv"

    [files]
    static = "noise/{serial}.parquet"
    rates = { file = "rates.parquet", serial = "unit" }

    [options]
    "sensors.gyro.chain.scale_factor" = "scale_factor"

``{serial}`` is replaced by the cell of that column, plainly. A folder that holds LOT.toml means that. Any other is a
lot without a table: its campaign.toml is the template, and each of its folders that holds files of the campaign is a
unit.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from ..campaign.file.load import Campaign, load
from ..core.campaign_text import FILE, LOT
from ..core.errors import PlanError, Problem
from ..core.remarks import Remark
from ..core.schema.problems import model_problems
from ..core.schema.quantities import Name, Strict, Text
from ..core.schema.toml import At, key_lines, nearest_line, parse_toml
from ..files.source import checked_path, read_bytes
from .units import SERIAL, Units, folder_units, read_units

MOST = 100  # problems that are listed
COLUMN = re.compile(r"\{([^{}]*)\}")


class SharedFile(Strict):
    """{ file, serial, match }: a file whose rows say of which unit they are; its name may be a pattern."""

    file: Annotated[Text, Field(min_length=1)]
    serial: Annotated[Text, Field(min_length=1)]
    match: dict[Text, Text] = Field(default={})  # more columns of the file -> columns of the table of units


class LineTable(Strict):
    """[line]: columns of the table of units that say where and when a unit was tested."""

    station: Text = ""
    place: Text = ""
    factors: list[Text] = Field(default=[])


class LotFile(Strict):
    """The whole LOT.toml."""

    schema_version: Literal[1] = Field(alias="schema")
    id: Name
    title: Text = ""
    campaign: Annotated[Text, Field(min_length=1)] = FILE
    units: Annotated[Text, Field(min_length=1)]
    serial: Annotated[Text, Field(min_length=1)] = SERIAL
    store: Text = ""
    endpoint: Text = ""
    region: Text = ""
    folder: Text = ""
    files: dict[Name, Annotated[Text, Field(min_length=1)] | SharedFile] = Field(default={})
    options: dict[Annotated[Text, Field(min_length=1)], Text] = Field(default={})
    line: LineTable | None = None

    @property
    def in_paths(self) -> list[str]:
        """Columns of the table of units that name files, or rows of files."""
        named = COLUMN.findall(self.folder)
        for one in self.files.values():
            named += COLUMN.findall(one if isinstance(one, str) else one.file)
            named += () if isinstance(one, str) else one.match.values()
        return list(dict.fromkeys(named))


@dataclass(frozen=True, eq=False)
class Lot:
    """A lot that was read and judged.

    Parameters
    ----------
    path : Path
        LOT.toml, or the folder.
    file : LotFile
        What it says.
    template : Campaign
        The campaign of every unit; its recordings lie elsewhere.
    raw : bytes
        Of its campaign.toml.
    units : Units
        Their table.
    remarks : tuple of Remark
        What reading it brought up.
    """

    path: Path
    file: LotFile
    template: Campaign
    raw: bytes
    units: Units
    remarks: tuple[Remark, ...] = ()

    @cached_property
    def files(self) -> dict[str, str | SharedFile]:
        """Where each recording lies in the store, by name: a pattern, or a file of many units."""
        prefix = f"{self.file.folder.rstrip('/')}/" if self.file.folder else ""
        named = self.file.files
        return {name: named.get(name, f"{prefix}{one.file}") for name, one in self.template.file.recordings.items()}

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """Columns of the table of units that a reduction depends on."""
        return tuple(dict.fromkeys(("serial", *self.file.in_paths, *self.file.options.values())))

    @cached_property
    def changes(self) -> dict[str, tuple[str | int, ...]]:
        """Path of the key of the campaign that a column stands in place of, by key."""
        return {key: found for key in self.file.options if (found := _key_path(key, self.template)) is not None}

    @property
    def store(self) -> str:
        """Folder or address in which the recordings lie."""
        root = self.path if self.path.is_dir() else self.path.parent
        given = self.file.store
        return given if "://" in given else str(root / given)

    def digest(self) -> str:
        """Return the SHA-256 of what a reduction depends on: the campaign and what the lot says, not the table."""
        said = self.file.model_dump(mode="json", exclude={"title", "endpoint", "region", "units", "serial", "line"})
        text = json.dumps([self.template.sha256, said, str(Path(self.store).resolve())], sort_keys=True)
        return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def load_lot(path: str | Path) -> Lot:
    """Read a lot: LOT.toml, the folder that holds it, or a folder of units.

    Raises
    ------
    PlanError
        With every problem of LOT.toml, of the campaign, or of the table of units.
    DataError
        If the table of units cannot be read.
    """
    given = Path(checked_path(path, "lot"))
    if given.is_dir() and not (given / LOT).is_file():
        return _of_folder(given)
    return _of_file(given / LOT if given.is_dir() else given)


def _of_folder(root: Path) -> Lot:
    if not (root / FILE).is_file():
        what = f"no lot here: {root / FILE} does not exist"
        why = "the campaign of that folder is the template of all units, each a folder beside it"
        do = "Copy the campaign.toml of one unit there, or name a LOT.toml"
        raise PlanError(what, why=why, do=do, code="no_campaign")
    template, raw = load(root, elsewhere=True), read_bytes(root / FILE)
    units, remarks = folder_units(root, {one.file for one in template.file.recordings.values()})
    folder = root.resolve().parts[-1]
    called = re.sub(r"[^A-Za-z0-9_.-]", "-", folder).lstrip("_.-")[:64] or "lot"
    file = LotFile(schema=1, id=called, units=".", folder="{serial}")
    return Lot(root, file, template, raw, units, remarks)


def _of_file(path: Path) -> Lot:
    raw = read_bytes(path)
    text, document = parse_toml(raw, path.name)
    lines = key_lines(text)

    def at(*key: str | int) -> str:
        line = nearest_line(lines, key)
        return f"{path.name}:{line}" if line else path.name

    try:
        file = LotFile.model_validate(document)
    except ValidationError as error:
        raise PlanError(list(islice(model_problems(error, LotFile, document, at), MOST))) from None
    root = path.parent
    problems = [*_patterns(file, at)]
    template = root / file.campaign
    template = template.parent if template.name == FILE and not template.is_dir() else template
    if not (template / FILE).is_file():
        what, why = f"campaign: {template / FILE} does not exist", "it is the template of all units"
        do = "Copy the campaign.toml of one unit there, or name the folder where it lies"
        problems.append(Problem(what, at("campaign"), why, do, "no_campaign"))
        raise PlanError(problems)
    try:
        campaign = load(template, elsewhere=True)
    except PlanError as error:
        raise PlanError([*error.problems, *problems]) from None
    units = read_units(root / file.units, file.serial, [one for one in file.in_paths if one != SERIAL])
    lot = Lot(path, file, campaign, read_bytes(template / FILE), units, units.remarks)
    problems += [*_store(lot, at), *_names(lot, at)]
    if problems:
        raise PlanError(problems)
    return lot


def _patterns(file: LotFile, at: At) -> Iterator[Problem]:
    """Find patterns that lead out of the store or are cut off, and words that are no address."""
    patterns: list[tuple[tuple[str, ...], str]] = [(("folder",), file.folder)]
    patterns += [(("files", name), one if isinstance(one, str) else one.file) for name, one in file.files.items()]
    for key, text in patterns:
        path = PurePosixPath(text)
        if path.is_absolute() or ".." in path.parts or "\\" in text or "\0" in text or "://" in text:
            what = f"{'.'.join(key)}: {text!r} leads out of the store"
            why = "every file of a lot lies in its store"
            yield Problem(what, at(*key), why, "Name files from the folder of the store on", "outside")
        if set(COLUMN.sub("", text)) & set("{}"):
            what, do = f"{'.'.join(key)}: unmatched brace in {text!r}", 'Write a column as "{serial}"'
            yield Problem(what, at(*key), "no cell would take its place", do, "wrong_value")
    user, sign, _ = file.store.partition("://")[2].partition("/")[0].rpartition("@")
    if sign and user != "anonymous":
        why = "what stands in LOT.toml is copied and archived"
        do = "Set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY in the environment"
        yield Problem("store: a password in the address", at("store"), why, do, "wrong_value")
    if file.endpoint and "://" not in file.endpoint:
        do = 'Write it whole: "http://127.0.0.1:9000"'
        yield Problem(f"endpoint: {file.endpoint!r} is no address", at("endpoint"), do=do, code="wrong_value")


def _store(lot: Lot, at: At) -> Iterator[Problem]:
    if "://" not in lot.store and not Path(lot.store).is_dir():
        do = "Name the folder in which the recordings lie, from that of LOT.toml on, or an address: s3://bucket/path"
        yield Problem(f"store: no folder {lot.store}", at("store"), "no recording would be found", do, "missing_file")


def _names(lot: Lot, at: At) -> Iterator[Problem]:
    """Find names that lead nowhere: columns, recordings, keys of the campaign."""
    known, file = lot.units.names, lot.file
    recordings = lot.template.file.recordings
    for name in file.files:
        if name not in recordings:
            what, do = f"files.{name}: the campaign has no such recording", f"There are: {', '.join(recordings)}"
            yield Problem(what, at("files", name), do=do, code="unknown_name")
    used: list[tuple[tuple[str, ...], str]] = [(("folder",), one) for one in COLUMN.findall(file.folder)]
    for name, given in file.files.items():
        found = COLUMN.findall(given if isinstance(given, str) else given.file)
        found += () if isinstance(given, str) else given.match.values()
        used += [(("files", name), one) for one in found]
    used += [(("options", key), column) for key, column in file.options.items()]
    if file.line is not None:
        named = [
            ("station", file.line.station),
            ("place", file.line.place),
            *(("factors", one) for one in file.line.factors),
        ]
        used += [(("line", key), column) for key, column in named if column]
    for key, column in used:
        if column not in known:
            what, do = f"{'.'.join(key)}: the table of units has no column {column!r}", f"It has: {', '.join(known)}"
            named_so = f"LOT.toml names it as that of the serial number, which is called {SERIAL!r} from there on"
            do = named_so if column == file.serial else do
            yield Problem(what, at(*key), do=do, code="unknown_column")
    for text in file.options:
        if text not in lot.changes:
            do = "Write it as the campaign has it: sensors.gyro.chain.scale_factor, tests.rate.plan.axis"
            what = f"options: the campaign has no place {text!r}"
            yield Problem(what, at("options", text), do=do, code="unknown_key")
    alone = [name for name, one in lot.files.items() if isinstance(one, str) and not COLUMN.search(one)]
    for name in alone if len(lot.units) > 1 else []:
        what = f"recording {name}: {lot.files[name]!r} is the same file for every unit"
        do = (
            f'Name a column in it, files.{name} = "{{serial}}/{lot.files[name]}", or a column of the file, serial = ...'
        )
        yield Problem(what, at("files", name), "all units would have the same readings", do, "same_file")


def _key_path(text: str, campaign: Campaign) -> tuple[str | int, ...] | None:
    """Return the path of a key in the document of a campaign; a test or a requirement is named by its id."""
    first, *rest = text.split(".")
    if not rest or not all(rest):
        return None
    said = campaign.file
    lists: Mapping[str, list[str]] = {
        "tests": [one.id for one in said.tests], "requirements": [one.id for one in said.requirements]
    }  # fmt: skip
    if first in lists:
        if rest[0] not in lists[first] or len(rest) == 1:
            return None
        return (first, lists[first].index(rest[0]), *rest[1:])
    tables: Mapping[str, Any] = {"sensors": said.sensors, "recordings": said.recordings, "conditions": said.conditions}
    if first in tables:
        return (first, *rest) if rest[0] in tables[first] and len(rest) > 1 else None
    return (first, *rest) if first in type(said).model_fields else None


__all__ = ["COLUMN", "Lot", "LotFile", "SharedFile", "load_lot"]
