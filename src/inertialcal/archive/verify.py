"""Whether an archive is what was added: chain of campaigns, every row, every document, recordings where they lie.

A record has the SHA-256 that was noted when it was added; the chain ties each campaign to the one before, so that one
taken out, or put between, shows; rows are made again of the ``results.json`` that is kept, so that the row that was
changed is named. The newest campaigns taken out together leave no gap: a receipt, which is kept elsewhere, says how
many there were, and with which chain.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import Connection, RowMapping, select

from ..campaign.outcome.publish import RESULTS
from ..core.errors import DataError, Problem
from ..files.source import load
from ..files.write.exchange import file_digest
from .record import Record, chained, content_rows, read_record, results_content, unpacked
from .tables import campaigns, files

MOST = 5  # rows of a table that are named


class Receipt(NamedTuple):
    """What an archive was when it was verified before."""

    campaigns: int
    chain: str  # Of the newest of them
    where: str


def read_receipt(path: str | Path) -> Receipt:
    """Return the receipt that the output of ``archive verify --json`` is.

    Raises
    ------
    DataError
        ``not_a_receipt``; as whatever reads files.
    """
    data = load(Path(path)).data
    try:
        said = json.loads(data)["verified"]
        return Receipt(int(said["campaigns"]), str(said["chain"]), str(path))
    except (ValueError, TypeError, KeyError, RecursionError):
        do = "Name a file of: inertialcal archive verify --json > receipt.json"
        raise DataError("not a receipt of an archive", where=str(path), do=do, code="not_a_receipt") from None


@dataclass(frozen=True)
class Verified:
    """What was compared, and what is missing or changed."""

    archive: str
    campaigns: int
    rows: int
    documents: int
    recordings: int  # That lie where they were, and were read again
    away: int  # Recordings that are not there: of these the hash alone is kept
    chain: str  # Of the newest campaign
    problems: tuple[Problem, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        found = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return found | {"problems": [one.to_dict() for one in self.problems]}

    def __str__(self) -> str:
        """Say it in lines."""
        lines = [f"{self.archive}: {self.campaigns} campaigns, {self.rows} rows, {self.documents} documents",
                 f"recordings: {self.recordings} read again, {self.away} not where they were"]  # fmt: skip
        lines += [f"chain: {self.chain or 'none yet'}", *(f"missing or changed: {one}" for one in self.problems)]
        return "\n".join([*lines, *(["all as it was added"] if not self.problems else [])])


def verify(connection: Connection, archive: str, receipt: Receipt | None = None) -> Verified:
    """Compare all that an archive holds with what was added.

    Parameters
    ----------
    connection : Connection
        That reads.
    archive : str
        Its address, for messages.
    receipt : Receipt, optional
        Of an earlier time: what it counted has to be there.
    """
    every = connection.execute(select(campaigns).order_by(campaigns.c.id)).mappings().all()
    problems = [] if receipt is None else list(_missing(every, receipt))
    numbers = {one["id"] for one in every}
    before, rows, recordings, away = "", 0, 0, 0
    for one in every:
        where = f"number {one['id']}, campaign {one['name']}"
        if chained(before, one["record_sha256"]) != one["chain"]:
            problems.append(Problem("a campaign before it is missing, or was put there", where=where, code="chain"))
        before = one["chain"]
        if one["replaces"] is not None and one["replaces"] not in numbers:
            what = f"replaces number {one['replaces']}, which is missing"
            problems.append(Problem(what, where=where, code="missing"))
        record = read_record(connection, one["id"])
        rows += sum(len(each) for each in record.rows.values())
        if record.sha256 != one["record_sha256"]:
            named = list(_differences(record))
            what = "its rows are not those that were added"
            problems += [Problem(what, where=where, code="changed"), *(Problem(each, where=where, code="changed")
                                                                       for each in named)]  # fmt: skip
        for use in record.rows["uses"]:
            if use["role"] != "input" or use["sha256"] in record.contents:
                continue
            digest = file_digest(Path(record.run["folder"]) / use["path"], follow=True)
            recordings, away = recordings + bool(digest), away + (not digest)
            if digest and digest != use["sha256"]:
                what = f"recording {use['path']} was changed since"
                problems.append(Problem(what, where=where, code="changed"))
    documents = 0
    for found in connection.execute(select(files.c.sha256).where(files.c.content.is_not(None))).scalars():
        documents += 1
        problems += _document(connection, found)
    return Verified(archive, len(every), rows, documents, recordings, away, before, tuple(problems))


def _missing(every: Sequence[RowMapping], receipt: Receipt) -> Iterator[Problem]:
    """Yield what a receipt counted and is not there."""
    count = receipt.campaigns
    if len(every) < count:
        what = f"{count - len(every)} of {count} campaigns that the receipt counted are not there: taken out at the end"
        yield Problem(what, where=receipt.where, code="missing")
    elif count and every[count - 1]["chain"] != receipt.chain:
        what = f"its first {count} campaigns are not those of the receipt: changed, or another archive"
        yield Problem(what, where=receipt.where, code="missing")


def _document(connection: Connection, digest: str) -> Iterator[Problem]:
    """Yield a document whose content is not that of its hash."""
    size, content = connection.execute(select(files.c.size, files.c.content).where(files.c.sha256 == digest)).one()
    data = unpacked(content, size)
    if data is None or hashlib.sha256(data).hexdigest() != digest:
        yield Problem(f"document {digest[:12]} is damaged", where="files", code="changed")


def _differences(record: Record) -> Iterator[str]:
    """Yield which rows differ from those that the kept ``results.json`` makes."""
    try:
        content = results_content(record)
    except DataError as error:
        yield error.problems[0].what
        return
    item, run, made = content_rows(content)
    for name, value in (item | run).items():
        if (record.item | record.run)[name] != value:
            yield f"{name} is {(record.item | record.run)[name]!r}, {RESULTS} says {value!r}"
    for table, rows in made.items():
        there = {row["position"]: row for row in record.rows[table]}
        named = 0
        for row in rows:
            found = there.pop(row["position"], None)
            wrong = [] if found is None else [name for name, value in row.items() if found[name] != value]
            if found is not None and not wrong:
                continue
            named += 1
            if named <= MOST:
                place = f"{table}, row {row['position']}"
                yield (f"{place} is missing" if found is None else
                       f"{place}: {wrong[0]} is {found[wrong[0]]!r}, {RESULTS} says {row[wrong[0]]!r}")  # fmt: skip
        if named > MOST:
            yield f"{table}: {named - MOST} more rows"
        if there:
            yield f"{table}: {len(there)} rows that {RESULTS} does not have"
