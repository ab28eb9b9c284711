"""An archive as one file that other programs can read, and back: a zip of lines of JSON and documents.

``archive.json`` says what it is. ``records.jsonl`` has the campaigns in their order, each as ``["campaign", ...]`` with
what the archive says of it, followed by its record (``record.Record.lines``). ``files.jsonl`` has SHA-256 and size of
every file that is known, ``files/SHA256`` the content of documents, ``SHA256SUMS`` the hash of each of these. Nothing
is unpacked onto the disk: a name in the zip is never a path.

An import adds what is not there, in one transaction: two archives that hold the same export end with the same chain, in
whichever database.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Integer, Text, select

from ..core.errors import DataError
from ..files.budget import claim
from ..files.source import load
from ..files.write.atomic import atomic_write
from .record import ITEM, OF_RUN, Fields, Record, item_number, line, read_record, unpacked
from .tables import OF_CAMPAIGN, REVISIONS, campaigns, files

FORMAT = "inertialcal archive"
VERSION = 1  # of this form
ABOUT, RECORDS, FILES, SUMS, FOLDER = "archive.json", "records.jsonl", "files.jsonl", "SHA256SUMS", "files/"
SAID = ("version", "replaces", "added_ns", "record_sha256", "chain")  # of a campaign, by the archive
EPOCH = (1980, 1, 1, 0, 0, 0)  # stamp of all entries: the same archive gives the same bytes
HASH = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Moved:
    """What an export or import moved."""

    campaigns: int
    there: int  # Campaigns that the archive had already
    files: int  # Documents
    chain: str  # Of the last campaign

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


def export(connection: Connection, path: str | os.PathLike[str]) -> Moved:
    """Write an archive into a new zip file, or in place of an old one.

    Raises
    ------
    StoreError
        ``not_written``.
    """
    numbers = [int(one) for one in connection.execute(select(campaigns.c.id).order_by(campaigns.c.id)).scalars()]
    rows = connection.execute(select(campaigns.c.id, *(campaigns.c[name] for name in SAID))).mappings()
    said = {one["id"]: {name: one[name] for name in SAID} for one in rows}
    sums: dict[str, str] = {}
    documents = 0
    with atomic_write(path) as place, zipfile.ZipFile(place, "w", zipfile.ZIP_DEFLATED) as made:

        def put(name: str, data: bytes) -> None:
            sums[name] = hashlib.sha256(data).hexdigest()
            made.writestr(zipfile.ZipInfo(name, EPOCH), data, zipfile.ZIP_DEFLATED)

        records, places = io.BytesIO(), {number: place for place, number in enumerate(numbers, 1)}
        for number in numbers:
            own = said[number] | {"replaces": places.get(said[number]["replaces"])}
            records.write(line("campaign", own))
            records.write(read_record(connection, number).lines())
        put(RECORDS, records.getvalue())
        listed = []
        for digest, size, content in connection.execute(select(files).order_by(files.c.sha256)):
            listed.append(line("files", {"sha256": digest, "size": size}))
            if (data := unpacked(content, size)) is not None:
                documents += 1
                put(f"{FOLDER}{digest}", data)
        put(FILES, b"".join(listed))
        about = {"format": FORMAT, "version": VERSION, "schema": REVISIONS[-1], "campaigns": len(numbers)}
        put(ABOUT, json.dumps(about, indent=1).encode() + b"\n")
        text = "".join(f"{digest}  {name}\n" for name, digest in sorted(sums.items()))
        made.writestr(zipfile.ZipInfo(SUMS, EPOCH), text.encode(), zipfile.ZIP_DEFLATED)
    chain = said[numbers[-1]]["chain"] if numbers else ""
    return Moved(len(numbers), 0, documents, chain)


@dataclass(frozen=True, eq=False)
class Exported:
    """A campaign of an export."""

    record: Record
    said: Fields


def read_export(path: str | os.PathLike[str]) -> list[Exported]:
    """Return the campaigns of an export, every hash compared.

    Raises
    ------
    DataError
        ``not_an_export``; ``schema_version``; ``damaged`` with the part that is; ``too_large``.
    """
    where = os.fspath(path)
    loaded = load(Path(where))
    parts = _parts(bytes(loaded.data), where)
    try:
        about = json.loads(parts[ABOUT])
        if about["format"] != FORMAT:
            raise KeyError
        newer = about["version"] > VERSION or about["schema"] > REVISIONS[-1]
        if newer:
            what = f"an export of schema {about['schema']}: a newer inertialcal has written it"
            raise DataError(what, where=where, do="Install that version", code="schema_version")
        sizes = {row["sha256"]: row.get("size") for _, row in map(json.loads, parts[FILES].splitlines())}
        found = list(_campaigns(parts, sizes, where))
    except (KeyError, TypeError, ValueError, RecursionError):
        raise DataError("not an export of an archive", where=where, do="Name a file of: inertialcal archive export",
                        code="not_an_export") from None  # fmt: skip
    if len(found) != about["campaigns"]:
        raise _damaged(where, f"{len(found)} campaigns of {about['campaigns']}")
    return found


def _parts(data: bytes, where: str) -> dict[str, bytes]:
    """Return the entries of a zip, each with the hash that it should have."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            claim(where, len(data), sum(one.file_size for one in archive.infolist()), "the entries of the zip")
            parts = {}
            for one in archive.infolist():
                with archive.open(one) as entry:
                    parts[one.filename] = entry.read(one.file_size + 1)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError, ValueError, zlib.error):
        what = "not an export of an archive: no zip file, or a damaged one"
        do = "Name a file of: inertialcal archive export"
        raise DataError(what, where=where, do=do, code="not_an_export") from None
    sums = parts.pop(SUMS, b"").decode("utf-8", "replace")
    listed = {name: digest for digest, _, name in (row.partition("  ") for row in sums.splitlines())}
    for name in sorted(listed.keys() | parts.keys()):
        if name not in parts:
            raise _damaged(where, f"{name} is missing")
        if listed.get(name) != hashlib.sha256(parts[name]).hexdigest():
            raise _damaged(where, f"{name} has another SHA-256 than {SUMS} says")
    return parts


def _campaigns(parts: dict[str, bytes], sizes: dict[str, int | None], where: str) -> Iterator[Exported]:
    said: Fields | None = None
    rows: list[tuple[str, Fields]] = []
    for text in [*parts[RECORDS].splitlines(), b'["campaign", null]']:
        table, row = json.loads(text)
        if table != "campaign":
            rows.append((table, row))
            continue
        if said is not None:
            record = _record(rows, parts, sizes)
            if record.sha256 != said["record_sha256"]:
                raise _damaged(where, f"the rows of campaign {record.run['name']} are not those that were added")
            yield Exported(record, said)
        said, rows = row, []


def _record(rows: list[tuple[str, Fields]], parts: dict[str, bytes], sizes: dict[str, int | None]) -> Record:
    """Return the record of lines; what a line leaves out is empty."""
    known = {table.name: table for table in OF_CAMPAIGN}
    made: dict[str, list[Fields]] = {name: [] for name in known}
    item: Fields = dict.fromkeys(ITEM, "")
    run: Fields = {name: None if name == "made_ns" else "" for name in OF_RUN}
    for table, row in rows:
        if table == "items":
            item |= row
        elif table == "campaigns":
            run |= row
        else:
            empty = {one.name: "" if isinstance(one.type, Text) else 0 if isinstance(one.type, Integer) else None
                     for one in known[table].c if one.name != "campaign_id"}  # fmt: skip
            empty |= {name: None for name in ("first_ns", "last_ns") if name in empty}
            if not row.keys() <= empty.keys():
                raise ValueError(table)
            made[table].append(empty | row)
    if not (item.keys() == {*ITEM} and run.keys() == {*OF_RUN}):
        raise ValueError(ITEM)
    used = dict.fromkeys(str(one["sha256"]) for one in made["uses"])
    contents = {digest: parts[f"{FOLDER}{digest}"] for digest in used if f"{FOLDER}{digest}" in parts}
    for digest, data in contents.items():
        if not HASH.fullmatch(digest) or hashlib.sha256(data).hexdigest() != digest:
            raise ValueError(digest)
    there = {digest: size for digest in used if (size := sizes.get(digest)) is not None}
    return Record(item, run, made, contents, there)


def is_there(connection: Connection, one: Exported, last: int) -> bool:
    """Whether an archive has this very record, added at the same instant, among its campaigns up to a number."""
    item = item_number(connection, one.record.item)
    query = select(campaigns.c.id).where(
        campaigns.c.item_id == item, campaigns.c.name == one.record.run["name"],
        campaigns.c.record_sha256 == one.said["record_sha256"], campaigns.c.added_ns == one.said["added_ns"],
        campaigns.c.id <= last,
    )  # fmt: skip
    return connection.execute(query).first() is not None


def _damaged(where: str, what: str) -> DataError:
    return DataError(f"damaged: {what}", where=where, do="Export it again", code="damaged")
