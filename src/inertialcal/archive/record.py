"""The record of a campaign: rows of all tables, made of what a run wrote, or read back from an archive.

One record as lines of JSON is the same wherever it is kept: that is what an export writes, what ``record_sha256`` is
of, and what is compared when a record is read back.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Insert, insert, select, update

from ..campaign.outcome.publish import OUT, PROVENANCE, RESULTS
from ..campaign.outcome.results_file import as_results, check_results, edited_since, find_results
from ..core.campaign_text import FILE
from ..core.errors import DataError
from ..core.times import DAY, read_instant
from ..files.source import checked_path, load
from ..files.write.exchange import Manifest, file_digest
from ..sensors.model.serial import FORMAT
from .tables import OF_CAMPAIGN, campaigns, files, items

Fields = dict[str, Any]
ITEM = ("maker", "part", "serial")  # by which a unit is known
OF_UNIT = ("owner", "lot")  # of a unit as a campaign states it: the last that did stands with the unit
OF_RUN = (*OF_UNIT, "name", "title", "verdict", "program", "folder", "results_sha256", "made_ns")
DOCUMENTS = (".json", ".toml")  # whose content is kept, too
AT_ONCE = 400  # hashes in one query


@dataclass(frozen=True, eq=False)
class Record:
    """What is archived of a campaign."""

    item: Fields
    run: Fields  # Row of ``campaigns`` without what the archive itself says
    rows: Mapping[str, Sequence[Fields]]  # By table, in their order
    contents: Mapping[str, bytes]  # SHA-256 -> content, of documents
    sizes: Mapping[str, int]  # SHA-256 -> bytes, of files that lay there

    def lines(self) -> bytes:
        """Return the rows as lines of JSON: the table, then the row; what the archive itself says is not in them."""
        every = [("items", self.item), ("campaigns", self.run)]
        every += [(table.name, row) for table in OF_CAMPAIGN for row in self.rows[table.name]]
        return b"".join(line(name, row) for name, row in every)

    @property
    def sha256(self) -> str:
        """SHA-256 of its rows."""
        return hashlib.sha256(self.lines()).hexdigest()


def line(table: str, row: Fields) -> bytes:
    """Return a row as a line of JSON; what is empty is left out, so that a column more changes no line."""
    row = {name: value for name, value in row.items() if value not in (None, "")}
    return json.dumps([table, row], sort_keys=True, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"


def chained(before: str, record_sha256: str) -> str:
    """Return what ties a campaign to the one before it: without it, or with another one, this would be another."""
    return hashlib.sha256(f"{before} {record_sha256}".encode()).hexdigest()


def record_of(folder: str | Path) -> Record:
    """Return the record of a campaign that was run.

    Raises
    ------
    DataError
        ``no_results``; ``edited_by_hand`` where a file of the run was changed since; ``checksum``, ``schema_version``,
        ``schema`` as whatever reads results.
    """
    root = Path(checked_path(folder, "campaign"))
    found = find_results(root, of_campaign=True) if root.is_dir() else None
    if found is None:
        do = f"Type: inertialcal run {folder}"
        raise DataError("no results here", where=str(folder), do=do, code="no_results")
    edited = edited_since(root)
    if edited:
        do = "Type again: inertialcal run DIR"
        raise DataError("edited by hand since the run wrote it", where=edited[0].where, do=do, code="edited_by_hand")
    out = Path(found.path).parent
    manifest = Manifest.read(out)
    written = {} if manifest is None else dict(manifest.files)
    written.setdefault(RESULTS, found.sha256)
    provenance = _json(out / PROVENANCE)
    read = {str(one["path"]): str(one["sha256"]) for one in provenance.get("inputs", [])}
    contents: dict[str, bytes] = {}
    sizes: dict[str, int] = {}
    models = []
    uses = [{"path": path, "role": "input", "sha256": digest} for path, digest in sorted(read.items())]
    uses += [{"path": f"{OUT}/{name}", "role": "output", "sha256": digest} for name, digest in sorted(written.items())]
    for use in uses:
        path = root / use["path"]
        if not _inside(root, path) or file_digest(path, follow=True) != use["sha256"]:
            continue  # not there, or another one by now: its hash is kept
        sizes[use["sha256"]] = path.stat().st_size
        if path.suffix in DOCUMENTS and (use["role"] == "output" or use["path"] == FILE):
            data = load(path).data
            if hashlib.sha256(data).hexdigest() == use["sha256"]:
                contents[use["sha256"]] = data
            content = _json(path) if path.suffix == ".json" else {}
            if content.get("format") == FORMAT:
                used = {"file": use["path"], "sha256": use["sha256"]}
                models += [{"condition": name} | used for name in content["models"]]
    run = {
        "folder": str(root.resolve()), "program": str(provenance.get("versions", {}).get("inertialcal", "")),
        "made_ns": read_instant(provenance["made"]) if "made" in provenance else None, "results_sha256": found.sha256,
    }  # fmt: skip
    with as_results(found.path):
        item, more, rows = content_rows(found.content)
    rows |= {"models": _placed(models), "uses": _placed(uses)}
    return Record(item, _clean(run | more), rows, contents, sizes)


def record_of_results(
    content: Mapping[str, Any], inputs: Iterable[tuple[str, str]], outputs: Mapping[str, bytes], run: Fields
) -> Record:
    """Return the record of results that were made now, and lie in no folder of their own.

    Parameters
    ----------
    content : mapping
        Of ``results.json``.
    inputs : iterable of (str, str)
        Path and SHA-256 of what was read.
    outputs : mapping of str to bytes
        What was made, by path: documents.
    run : dict
        ``folder``, ``program``, ``made_ns``, ``results_sha256``.
    """
    digests = {path: hashlib.sha256(data).hexdigest() for path, data in outputs.items()}
    uses = [{"path": path, "role": "input", "sha256": digest} for path, digest in sorted(inputs)]
    uses += [{"path": path, "role": "output", "sha256": digest} for path, digest in sorted(digests.items())]
    models = []
    for path, digest in sorted(digests.items()):
        said = json.loads(outputs[path])
        if said.get("format") == FORMAT:
            models += [{"condition": name, "file": path, "sha256": digest} for name in said["models"]]
    item, more, rows = content_rows(content)
    rows |= {"models": _placed(models), "uses": _placed(uses)}
    contents = {digests[path]: data for path, data in outputs.items()}
    return Record(item, _clean(run | more), rows, contents, {one: len(data) for one, data in contents.items()})


def content_rows(content: Mapping[str, Any]) -> tuple[Fields, Fields, dict[str, list[Fields]]]:
    """Return what the content of ``results.json`` makes: the item, part of the row of the campaign, rows by table."""
    item = {name: str(content["item"].get(name, "")) for name in ITEM}
    run = {
        "name": content["campaign"]["id"],
        "title": content["campaign"]["title"],
        "verdict": content["verdict"] or "",
    }
    run |= {name: str(content["item"].get(name, "")) for name in OF_UNIT}
    rows = {
        "tests": _placed(_tests(content)),
        "results": _placed(_result(row) for row in content["results"]),
        "covariances": _placed(
            {"test": one["test"], "keys": _text(one["keys"]), "units": _text(one["units"]),
             "matrix": _text(one["matrix"])} for one in content["covariances"]),
        "verdicts": _placed(
            {name: one[name] for name in ("requirement", "test", "axis", "sensor", "unit", "verdict")}
            | {name: _float(one[name]) for name in ("value", "u", "lower", "upper")}
            | {"quantity": one.get("quantity", ""), "whole": _text(one)} for one in content["verdicts"]),
        "standards": _placed(
            {name: one[name] for name in ("standard", "quantity", "unit", "certificate", "valid", "redrawn_by")}
            | {"name": key, "u": float(one["u"]), "reason": one.get("reason", "")}
            for key, one in content["influences"].items()),
    }  # fmt: skip
    return _clean(item), _clean(run), rows


def _tests(content: Mapping[str, Any]) -> Iterator[Fields]:
    """Yield the tests, then the models, each with what drew the errors of standards and when it was."""
    steps = {str(one["test"]): one for one in content["sequence"]}
    spans: dict[str, tuple[int, int] | None] = {}
    for name in dict.fromkeys((*steps, *content["occasions"])):
        step, occasion = steps.get(name), content["occasions"].get(name, {})
        day = str(occasion.get("day", ""))
        behind = [] if step is not None else [spans.get(str(test)) for test in occasion["tests"]]
        known = [one for one in behind if one is not None]
        if step is not None and step.get("time"):
            spans[name] = tuple(read_instant(end) for end in step["time"])  # type: ignore[assignment]
        elif day:
            start = read_instant(f"{day}T00:00:00Z")
            spans[name] = start, start + DAY
        else:
            spans[name] = (min(a for a, _ in known), max(b for _, b in known)) if known else None
        first, last = spans[name] or (None, None)
        yield {
            "name": name, "procedure": "" if step is None else step["procedure"],
            "purpose": "model" if step is None else step["use"], "condition": "" if step is None else step["condition"],
            "first_ns": first, "last_ns": last, "day": day,
        } | {field: str(occasion.get(field, "")) for field in ("mounting", "power_up", "site")}  # fmt: skip


def _result(row: Mapping[str, Any]) -> Fields:
    at, member, ends, reason = (row[name] or {} for name in ("at", "member", "interval", "reason"))
    return {
        "test": row["test"], "quantity": row["quantity"], "axis": row["axis"], "sensor": row["sensor"],
        "power": int(row["power"]), "at_what": at.get("what", ""), "at_value": _float(at.get("value")),
        "at_unit": at.get("unit", ""), "condition": row["condition"], "method": row["method"],
        "member_kind": member.get("kind", ""), "member": member.get("label", ""), "value": _float(row["value"]),
        "u": _float(row["u"]), "unit": row["unit"], "dof": _float(row["dof"]), "lower": _float(ends.get("lo")),
        "upper": _float(ends.get("hi")), "coverage": _float(ends.get("p")), "status": row["status"],
        "reason_code": reason.get("code", ""), "reason": reason.get("text", ""), "shared": _text(row["shared"]),
        "curvature": _text(row["curvature"]),
    }  # fmt: skip


def _placed(rows: Iterable[Fields]) -> list[Fields]:
    return [_clean(row) | {"position": number} for number, row in enumerate(rows)]


def _clean(row: Fields) -> Fields:
    """Return a row as both databases hold it: PostgreSQL has no NUL, SQLite no minus zero, neither half a character."""
    return {name: _storable(value) for name, value in row.items()}


def _storable(value: Any) -> Any:
    if isinstance(value, str):
        return value.replace("\0", "\N{REPLACEMENT CHARACTER}").encode("utf-8", "replace").decode("utf-8")
    return value + 0.0 if isinstance(value, float) else value


def _float(value: float | None) -> float | None:
    return None if value is None else float(value)


def _text(content: object) -> str:
    return json.dumps(content, sort_keys=True, separators=(",", ":"))


def _json(path: Path) -> dict[str, Any]:
    """Return the content of a file of a run; nothing where there is none, or it is no object."""
    try:
        content = json.loads(load(path).data)
    except (DataError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _inside(root: Path, path: Path) -> bool:
    """Whether a file lies in a folder, links followed."""
    return path.resolve().is_relative_to(root.resolve())


def written(connection: Connection, record: Record, added: Fields) -> int:
    """Add a record; return the number of the campaign.

    Parameters
    ----------
    connection : Connection
        That adds.
    record : Record
        What.
    added : dict
        What the archive says of it: ``version``, ``replaces``, ``added_ns``, ``record_sha256``, ``chain``.
    """
    item = item_number(connection, record.item)
    stated = {name: record.run[name] for name in OF_UNIT}
    if item is None:
        item = _number(connection, insert(items).values(record.item | stated))
    elif any(stated.values()):
        connection.execute(update(items).where(items.c.id == item).values({k: v for k, v in stated.items() if v}))
    number = _number(connection, insert(campaigns).values(record.run | added | {"item_id": item}))
    for table in OF_CAMPAIGN:
        rows = [row | {"campaign_id": number} for row in record.rows[table.name]]
        if rows:
            connection.execute(insert(table), rows)
    _write_files(connection, record)
    return number


def _number(connection: Connection, adding: Insert) -> int:
    """Add a row; return its number."""
    made = connection.execute(adding).inserted_primary_key
    return int(made[0]) if made is not None else 0


def item_number(connection: Connection, item: Fields) -> int | None:
    """Return the number of a unit; None where it is new."""
    own = select(items.c.id).where(*(items.c[name] == item[name] for name in ITEM))
    found = connection.execute(own).scalar()
    return None if found is None else int(found)


def _write_files(connection: Connection, record: Record) -> None:
    hashes = list(dict.fromkeys(str(use["sha256"]) for use in record.rows["uses"]))
    there: dict[str, bool] = {}
    for start in range(0, len(hashes), AT_ONCE):
        query = select(files.c.sha256, files.c.content.is_not(None), files.c.size)
        for digest, kept, size in connection.execute(query.where(files.c.sha256.in_(hashes[start : start + AT_ONCE]))):
            there[digest] = bool(kept)
            if size is None and digest in record.sizes:
                connection.execute(update(files).where(files.c.sha256 == digest).values(size=record.sizes[digest]))
    new = [{"sha256": one, "size": record.sizes.get(one), "content": packed(record.contents.get(one))}
           for one in hashes if one not in there]  # fmt: skip
    if new:
        connection.execute(insert(files), new)
    for digest in hashes:
        if there.get(digest) is False and digest in record.contents:
            content = packed(record.contents[digest])
            connection.execute(update(files).where(files.c.sha256 == digest).values(content=content))


def packed(content: bytes | None) -> bytes | None:
    """Return the content of a file as ``files`` holds it."""
    return None if content is None else zlib.compress(content, 6)


def unpacked(content: bytes | None, size: int | None) -> bytes | None:
    """Return the content of a file, no more of it than its size; None where there is none, or it is damaged."""
    if content is None or size is None:
        return None
    try:
        return zlib.decompressobj().decompress(content, size + 1)
    except zlib.error:
        return None


def read_record(connection: Connection, number: int) -> Record:
    """Return the record of a campaign as the archive has it, with its documents.

    Raises
    ------
    DataError
        ``no_campaign``.
    """
    query = select(campaigns, *(items.c[name].label(f"item_{name}") for name in ITEM)).join(items)
    row = connection.execute(query.where(campaigns.c.id == number)).mappings().first()
    if row is None:
        do = "See: inertialcal archive list"
        raise DataError(f"no campaign of number {number} in the archive", do=do, code="no_campaign")
    rows = {}
    for table in OF_CAMPAIGN:
        columns = [column for column in table.c if column.name != "campaign_id"]
        query = select(*columns).where(table.c.campaign_id == number).order_by(table.c.position)
        rows[table.name] = [dict(one) for one in connection.execute(query).mappings()]
    contents, sizes = {}, {}
    used = select(files).where(files.c.sha256.in_(list({use["sha256"] for use in rows["uses"]})))
    for digest, size, content in connection.execute(used):
        if size is not None:
            sizes[digest] = size
        if (data := unpacked(content, size)) is not None:
            contents[digest] = data
    item, run = {name: row[f"item_{name}"] for name in ITEM}, {name: row[name] for name in OF_RUN}
    return Record(item, run, rows, contents, sizes)


def results_content(record: Record) -> dict[str, Any]:
    """Return the content of the ``results.json`` of a record.

    Raises
    ------
    DataError
        ``damaged`` where it is not there, or not as it was; as ``check_results``.
    """
    data = record.contents.get(record.run["results_sha256"])
    if data is None or hashlib.sha256(data).hexdigest() != record.run["results_sha256"]:
        what = f"{RESULTS} of campaign {record.run['name']} is missing or changed in the archive"
        raise DataError(what, do="See: inertialcal archive verify", code="damaged")
    content: dict[str, Any] = json.loads(data)
    check_results(content, RESULTS)
    return content
