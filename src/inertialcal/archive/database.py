"""The database behind an archive: its address, its transactions, its schema, and refusals in words.

SQLite keeps a write-ahead log and syncs each commit; who adds holds the lock of the file from the first statement on,
and who reads opens it read-only. PostgreSQL is asked for a lock of its own, so that two who add come one after the
other in both. An address is never printed with its password, nor with what follows a ``?``; texts of drivers are not
printed at all.

References
----------
.. [1] https://sqlite.org/wal.html, https://sqlite.org/rescode.html.
.. [2] PostgreSQL 15, appendix A: error codes; 13.3.5: advisory locks.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from urllib.parse import quote

from sqlalchemy import Connection, Engine, create_engine, event, exc, inspect, text
from sqlalchemy.engine import URL, make_url
from sqlalchemy.pool import NullPool

from ..core.errors import InertialcalError, StoreError, UsageError
from .tables import REVISIONS, metadata

WAIT = 10.0  # [s] for another who adds
CONNECT = 10  # [s] for a server
LOCK = 0x1CA1  # of ours, in PostgreSQL
HOW = "Name a file (lab.db), or postgresql://USER@HOST/DATABASE"
SQLITE = {  # code of SQLite [1] -> our code, what
    sqlite3.SQLITE_BUSY: ("locked", f"locked by another program for more than {WAIT:g} s"),
    sqlite3.SQLITE_LOCKED: ("locked", f"locked by another program for more than {WAIT:g} s"),
    sqlite3.SQLITE_READONLY: ("read_only", "cannot be written"),
    sqlite3.SQLITE_PERM: ("read_only", "cannot be written"),
    sqlite3.SQLITE_CANTOPEN: ("not_accessible", "cannot be opened"),
    sqlite3.SQLITE_FULL: ("not_written", "the disk is full"),
    sqlite3.SQLITE_IOERR: ("not_accessible", "the disk cannot be read or written"),
    sqlite3.SQLITE_NOTADB: ("not_an_archive", "not an archive: no SQLite database"),
    sqlite3.SQLITE_CORRUPT: ("damaged", "damaged: SQLite cannot read all of it"),
}
POSTGRES = {  # class or code of PostgreSQL [2] -> our code, what; none where nothing was reached
    "": ("not_accessible", "cannot be reached: no such server, or it does not answer"),
    "08": ("not_accessible", "the connection broke"),
    "28": ("not_accessible", "the server refuses this user or password"),
    "3D": ("not_accessible", "the server has no such database"),
    "42501": ("read_only", "this user may not do that"),
    "25006": ("read_only", "cannot be written: the server allows reading only"),
    "55P03": ("locked", f"locked by another program for more than {WAIT:g} s"),
    "53": ("not_written", "the server has no room left, or too many users"),
    "57": ("not_accessible", "the server ended the connection"),
}
DO = {
    "locked": "Wait until the other program is done, and type it again",
    "read_only": "Ask who keeps the archive, or name another one",
    "not_written": "Make room, and type it again: nothing of it was added",
    "damaged": "Go back to a copy: inertialcal archive import reads an export",
}


def address(given: str | os.PathLike[str]) -> URL:
    """Return the address of a database: a path is that of an SQLite file.

    Raises
    ------
    UsageError
        ``archive_url``, without what was given: there may be a password in it.
    """
    said = os.fspath(given)
    if not said.strip() or "\0" in said:
        raise UsageError("the archive has no name", do=HOW, code="archive_url")
    if "://" not in said:
        return URL.create("sqlite", database=said)
    try:
        url = make_url(said)
        url.port  # noqa: B018 - a word in its place is refused
    except (exc.ArgumentError, ValueError):
        raise UsageError("the address of the archive cannot be read", do=HOW, code="archive_url") from None
    kind = url.drivername.partition("+")[0]
    if "@" in (url.host or ""):
        do = "Write @ in a password as %40, : as %3A, / as %2F"
        raise UsageError("the address of the archive has two @", do=do, code="archive_url")
    if kind in ("postgres", "postgresql"):
        return url.set(drivername="postgresql+psycopg")
    if kind == "sqlite" and url.database and not url.host:
        return URL.create("sqlite", database=url.database)
    raise UsageError(f"no archive in a database of kind {kind[:20]!r}", do=HOW, code="archive_url")


def shown(url: URL) -> str:
    """Return an address as messages have it: no password, no options."""
    if url.drivername == "sqlite":
        return str(url.database)
    user = f"{url.username}@" if url.username else ""
    port = f":{url.port}" if url.port else ""
    return f"postgresql://{user}{url.host or ''}{port}/{url.database or ''}"


@dataclass(frozen=True, eq=False)
class Database:
    """One database, reached as it is needed."""

    url: URL

    @property
    def name(self) -> str:
        """Address for messages."""
        return shown(self.url)

    @property
    def is_sqlite(self) -> bool:
        """Whether it is a file."""
        return self.url.drivername == "sqlite"

    @cached_property
    def _reader(self) -> Engine:
        return self._engine("ro")

    @cached_property
    def _writer(self) -> Engine:
        return self._engine("rwc")

    def _engine(self, mode: str, keys: bool = True) -> Engine:
        if not self.is_sqlite:
            options = {"connect_timeout": CONNECT} if "connect_timeout" not in self.url.query else {}
            return create_engine(self.url, connect_args=options, poolclass=NullPool, hide_parameters=True)
        path = Path(str(self.url.database))

        def connect() -> sqlite3.Connection:
            where, how = quote(str(path.absolute())), mode
            if mode == "ro" and not os.access(path.parent, os.W_OK) and not path.with_name(f"{path.name}-wal").exists():
                how = "ro&immutable=1"  # a log cannot be made there, and nobody writes
            opened = sqlite3.connect(f"file:{where}?mode={how}", uri=True, timeout=WAIT, isolation_level=None)
            if mode != "ro":
                opened.execute("PRAGMA journal_mode = WAL")
                opened.execute("PRAGMA synchronous = FULL")
            opened.execute(f"PRAGMA foreign_keys = {'ON' if keys else 'OFF'}")
            return opened

        engine = create_engine("sqlite://", creator=connect, poolclass=NullPool, hide_parameters=True)

        @event.listens_for(engine, "begin")
        def _begin(connection: Connection) -> None:
            connection.exec_driver_sql("BEGIN" if mode == "ro" else "BEGIN IMMEDIATE")

        return engine

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Yield a connection that reads one state of an archive of this schema.

        Raises
        ------
        StoreError
            ``no_archive``, ``schema_version``, ``not_accessible``, ``not_an_archive``, ``damaged``.
        """
        if self.is_sqlite and not Path(str(self.url.database)).is_file():
            raise _no_archive(self.name)
        with self._refusals(), self._reader.connect() as connection:
            if not self.is_sqlite:
                connection.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)
            with connection.begin():
                found = revision(connection)
                if not found:
                    raise _no_archive(self.name)
                self._check(found)
                yield connection

    @contextmanager
    def writing(self, migrating: bool = False) -> Iterator[Connection]:
        """Yield a connection that alone adds; what is done is kept whole when all went well, else nothing of it.

        Raises
        ------
        StoreError
            As `reading`; ``read_only``, ``locked``, ``not_written``.
        """
        if self.is_sqlite and not Path(str(self.url.database)).absolute().parent.is_dir():
            where = str(Path(str(self.url.database)).parent)
            raise StoreError("no such folder", where=where, do="Make it, or name another archive", code="no_folder")
        engine = self._engine("rwc", keys=False) if migrating else self._writer  # tables are copied and renamed
        with self._refusals(), engine.connect() as connection, connection.begin():
            if not self.is_sqlite:
                connection.execute(text(f"SET LOCAL lock_timeout = '{int(WAIT * 1e3)}ms'"))
                connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": LOCK})
            found = revision(connection)
            if not migrating:
                if found:
                    self._check(found)
                else:
                    self._make(connection)
            yield connection

    def migrate(self, to: str) -> tuple[str, str]:
        """Bring the schema to a version; return the version before, and the one now; Raises as ``Archive.migrate``."""
        if to not in REVISIONS:
            raise UsageError(f"no schema {to!r}", do=f"There are: {', '.join(REVISIONS)}", code="unknown_name")
        if self.is_sqlite and not Path(str(self.url.database)).is_file():
            raise _no_archive(self.name)
        from .migrate import downgrade, upgrade  # noqa: PLC0415 - Alembic starts slowly

        with self.writing(migrating=True) as connection:
            found = revision(connection)
            if not found:
                raise _no_archive(self.name)
            if found not in REVISIONS:
                self._check(found)
            (upgrade if to > found else downgrade)(connection, to)
        return found, to

    def _make(self, connection: Connection) -> None:
        """Make the tables of a new archive."""
        if set(inspect(connection).get_table_names()) & set(metadata.tables):
            what = "not an archive: its tables have the names of ours, and no version"
            raise StoreError(what, where=self.name, do="Name an empty database, or a new file", code="not_an_archive")
        from .migrate import upgrade  # noqa: PLC0415 - Alembic starts slowly

        upgrade(connection)

    def _check(self, found: str) -> None:
        """Refuse a schema that is not this one."""
        if found == REVISIONS[-1]:
            return
        if found in REVISIONS:
            what = f"an archive of schema {found}; this version of inertialcal works with {REVISIONS[-1]}"
            do = f"Type: inertialcal archive migrate --archive {self.name}"
            raise StoreError(what, where=self.name, do=do, code="schema_version")
        if found.isdecimal() and found > REVISIONS[-1]:
            what = f"an archive of schema {found}: a newer inertialcal has made it; this one knows {REVISIONS[-1]}"
            raise StoreError(what, where=self.name, do="Install that version", code="schema_version")
        what = "not an archive: another program keeps its versions in this database"
        raise StoreError(what, where=self.name, do="Name another database", code="not_an_archive")

    @contextmanager
    def _refusals(self) -> Iterator[None]:
        """Say in our words what a database refuses."""
        try:
            yield
        except InertialcalError:
            raise
        except (exc.DBAPIError, sqlite3.Error) as error:
            refused = self._refused(error.orig if isinstance(error, exc.DBAPIError) else error)
            if refused is None:
                raise
            raise refused from None

    def _refused(self, error: BaseException | None) -> StoreError | None:
        """Return what a database refuses; None for a fault of ours."""
        if isinstance(error, sqlite3.Error):
            found = SQLITE.get(getattr(error, "sqlite_errorcode", 0) & 0xFF)  # without its extension
        else:
            state = str(getattr(error, "sqlstate", None) or "")
            found = POSTGRES.get(state, POSTGRES.get(state[:2]))
        if found is None:
            return None
        code, what = found
        return StoreError(what, where=self.name, do=DO.get(code, "Check the address of the archive"), code=code)


def revision(connection: Connection) -> str:
    """Return the version of the schema of a database; empty where it has none."""
    if "alembic_version" not in inspect(connection).get_table_names():
        return ""
    return str(connection.execute(text("SELECT version_num FROM alembic_version")).scalar() or "")


def _no_archive(name: str) -> StoreError:
    do = f"Make one: inertialcal run DIR --archive {name}"
    return StoreError("no archive here", where=name, do=do, code="no_archive")
