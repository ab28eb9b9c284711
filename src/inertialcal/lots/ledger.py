"""The ledger of a lot: what is done, in a file that a kill leaves whole.

One process writes it, the one that conducts the lot; a second one is refused. A block is noted in one transaction, its
rows with it, so that a unit is done whole or not at all.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from sys import intern

from ..core.errors import StoreError
from .block import Block, Ended

FILE = "ledger.sqlite"
VERSION = "1"
TABLES = """
CREATE TABLE IF NOT EXISTS about (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS blocks (id INTEGER PRIMARY KEY, rows BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS units (
    key TEXT PRIMARY KEY, status TEXT NOT NULL, verdict TEXT NOT NULL, reason_code TEXT NOT NULL, stamps TEXT NOT NULL,
    block INTEGER NOT NULL, place INTEGER NOT NULL, done_ns INTEGER NOT NULL, archived TEXT NOT NULL DEFAULT ''
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS to_archive (
    key TEXT PRIMARY KEY, results BLOB NOT NULL, models TEXT NOT NULL, inputs TEXT NOT NULL, at_ns INTEGER NOT NULL
);
"""


@dataclass(frozen=True, slots=True)
class Noted:
    """A unit as the ledger has it."""

    status: str
    verdict: str
    reason_code: str
    stamps: Mapping[str, list[int]]
    block: int  # That its row stands in
    place: int  # Of its row in the block
    archived: str  # Archive that has it; empty for none


@dataclass(frozen=True)
class ToArchive:
    """What an archive keeps of a unit."""

    key: str
    results: bytes
    models: list[tuple[str, str]]
    inputs: list[tuple[str, str]]
    at_ns: int


class Ledger:
    """The ledger in the folder of a lot; made where there is none.

    Raises
    ------
    StoreError
        ``locked``, ``damaged``, ``not_writable``.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        with self._refusals():
            self._file = sqlite3.connect(self.path, isolation_level=None, timeout=1.0, check_same_thread=False)
            self._file.execute("PRAGMA locking_mode = EXCLUSIVE")
            self._file.execute("PRAGMA journal_mode = WAL")
            self._file.execute("PRAGMA synchronous = NORMAL")
            self._file.execute("BEGIN IMMEDIATE")  # takes the lock, for as long as it is open
            self._file.execute("COMMIT")
            self._file.executescript(TABLES)
            if self.said("schema", VERSION) != VERSION:
                do = "Name a new folder"
                raise StoreError("a ledger of another version", str(self.path), do=do, code="schema_version")
            self.say("schema", VERSION)

    @contextmanager
    def _refusals(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.OperationalError as error:
            if "locked" in str(error) or "busy" in str(error):
                do = "Wait for its end, or name another folder"
                what = "another process works on this lot"
                raise StoreError(what, str(self.path), do=do, code="locked") from None
            raise StoreError(f"the ledger cannot be written: {error}", str(self.path), code="not_writable") from None
        except sqlite3.DatabaseError as error:
            what, do = f"the ledger is damaged: {error}", "Delete the folder, and begin anew"
            raise StoreError(what, str(self.path), do=do, code="damaged") from None

    def close(self) -> None:
        """Let go of it."""
        with suppress(sqlite3.Error):
            self._file.close()

    def said(self, name: str, default: str = "") -> str:
        """Return what it says of the lot; the default where it says nothing."""
        found = self._file.execute("SELECT value FROM about WHERE name = ?", (name,)).fetchone()
        return default if found is None else str(found[0])

    def say(self, name: str, value: str) -> None:
        """Note something of the lot."""
        with self._refusals():
            self._file.execute("INSERT OR REPLACE INTO about VALUES (?, ?)", (name, value))

    def forget_all(self) -> None:
        """Forget every unit: they are of another campaign, or another version."""
        with self._refusals():
            self._file.executescript("DELETE FROM units; DELETE FROM blocks; DELETE FROM to_archive;")

    def units(self) -> dict[str, Noted]:
        """Return the units that are done, by key."""
        once = lru_cache(maxsize=64)(json.loads)  # units of shared files have the same
        with self._refusals():
            rows = self._file.execute(
                "SELECT key, status, verdict, reason_code, stamps, block, place, archived FROM units"
            )
            return {key: Noted(intern(status), intern(verdict), intern(code), once(stamps), block, place, intern(where))
                    for key, status, verdict, code, stamps, block, place, where in rows}  # fmt: skip

    def note(self, keys: Sequence[str], block: Block) -> None:
        """Note a block: its rows, and how each unit ended, by its key."""
        with self._refusals(), self._file:
            self._file.execute("BEGIN IMMEDIATE")
            number = self._file.execute("INSERT INTO blocks (rows) VALUES (?)", (block.rows,)).lastrowid
            for place, (key, one) in enumerate(zip(keys, block.units, strict=True)):
                self._unit(key, one, int(number or 0), place)

    def _unit(self, key: str, one: Ended, block: int, place: int) -> None:
        self._file.execute(
            "INSERT OR REPLACE INTO units VALUES (?, ?, ?, ?, ?, ?, ?, ?, '')",
            (key, one.status, one.verdict, one.reason_code, one.stamps, block, place, one.at_ns),
        )
        if one.results:
            self._file.execute(
                "INSERT OR REPLACE INTO to_archive VALUES (?, ?, ?, ?, ?)",
                (key, one.results, json.dumps(one.models), json.dumps(one.inputs), one.at_ns),
            )

    def rows(self, block: int) -> bytes:
        """Return the rows of a block."""
        with self._refusals():
            found = self._file.execute("SELECT rows FROM blocks WHERE id = ?", (block,)).fetchone()
        return bytes(found[0])

    def waiting(self) -> frozenset[str]:
        """Return the keys of units that an archive is yet to have."""
        with self._refusals():
            return frozenset(key for (key,) in self._file.execute("SELECT key FROM to_archive"))

    def to_archive(self, most: int) -> list[ToArchive]:
        """Return units that an archive is yet to have."""
        with self._refusals():
            rows = self._file.execute(
                "SELECT key, results, models, inputs, at_ns FROM to_archive ORDER BY rowid LIMIT ?",
                (most,),
            ).fetchall()
        return [
            ToArchive(
                key, results, [(name, text) for name, text in json.loads(models)],
                [(path, digest) for path, digest in json.loads(inputs)], at_ns,
            )
            for key, results, models, inputs, at_ns in rows
        ]  # fmt: skip

    def archived(self, keys: Sequence[str], archive: str) -> None:
        """Note that an archive has units."""
        with self._refusals(), self._file:
            self._file.execute("BEGIN IMMEDIATE")
            self._file.executemany("UPDATE units SET archived = ? WHERE key = ?", [(archive, key) for key in keys])
            self._file.executemany("DELETE FROM to_archive WHERE key = ?", [(key,) for key in keys])

    def sweep(self) -> None:
        """Forget the rows of units that were done again."""
        with self._refusals():
            self._file.execute("DELETE FROM blocks WHERE id NOT IN (SELECT block FROM units)")
