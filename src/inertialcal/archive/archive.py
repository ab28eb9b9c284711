"""An archive: campaigns added whole, units listed, figures over time.

A run is added once: the same results again are no second row. Another run of a campaign of the same unit is a new
version that names the one that it replaces. What was added is read again, on a connection of its own, and compared with
what was meant, before anybody is told that it is there.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, func, select

from ..campaign.compare.compare import Comparison, compare_sides
from ..campaign.compare.sources import Compared, results_side
from ..core.errors import StoreError
from ..core.show.tables import Block, Table, html, text
from ..core.times import instant_text
from .database import Database, address
from .exchange import Moved, export, is_there, read_export
from .history import History, history
from .points import newest
from .record import Record, chained, item_number, read_record, record_of, results_content, written
from .tables import REVISIONS, campaigns, items, tests
from .trend import By, Trend, trend
from .verify import Verified, read_receipt, verify

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True)
class Added:
    """What became of a run."""

    archive: str
    number: int  # Of the campaign in the archive
    name: str
    serial: str
    version: int
    replaces: int | None  # Number of the version before; None for the first
    new: bool  # Whether it was added now; it was there already otherwise
    record_sha256: str

    def __str__(self) -> str:
        """Say it in a line."""
        unit = f" of unit {self.serial}" if self.serial else ""
        if not self.new:
            return f"{self.archive}: campaign {self.name}{unit} is there already, number {self.number}"
        what = f"version {self.version}, replaces number {self.replaces}" if self.replaces else "new"
        return f"{self.archive}: campaign {self.name}{unit} added as number {self.number} ({what}), and read back"

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


@dataclass(frozen=True)
class Listed:
    """A campaign of the archive."""

    number: int
    serial: str
    part: str
    maker: str
    owner: str
    name: str
    version: int
    replaces: int | None
    replaced: bool
    verdict: str
    first_ns: int | None  # First instant of its tests, UTC
    added_ns: int

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


@dataclass(frozen=True)
class Listing:
    """Campaigns of the archive, by unit."""

    archive: str
    campaigns: tuple[Listed, ...]

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a campaign."""
        heads = ("no.", "serial", "part", "owner", "campaign", "version", "tested", "verdict")
        rows = [
            [str(one.number), one.serial, one.part, one.owner, one.name,
             f"{one.version}{', replaced' * one.replaced}", _day(one.first_ns), one.verdict or "-"]
            for one in self.campaigns
        ]  # fmt: skip
        units = len({(one.maker, one.part, one.serial) for one in self.campaigns})
        caption = f"{self.archive}: {len(rows)} campaign{'s' * (len(rows) != 1)} of {units} unit{'s' * (units != 1)}"
        return (Table(heads, rows, caption, (0,)),)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a campaign."""
        from ..core.show.frames import frame  # noqa: PLC0415 - starts slowly

        names = list(Listed.__dataclass_fields__)
        return frame({name: [getattr(one, name) for one in self.campaigns] for name in names})


def _day(instant: int | None) -> str:
    return "-" if instant is None else instant_text(instant)[:10]


class Archive:
    """Results of many campaigns in one database.

    Parameters
    ----------
    where : str or path
        File of SQLite, or ``postgresql://USER@HOST/DATABASE``.
    """

    def __init__(self, where: str | os.PathLike[str]) -> None:
        self.database = Database(address(where))

    def __repr__(self) -> str:
        """Return its address, without a password."""
        return f"Archive({self.database.name!r})"

    def add(self, folder: str | Path) -> Added:
        """Add what a campaign gave; the archive is made where there is none.

        Raises
        ------
        DataError
            As ``record_of``: the campaign was not run, or its results were edited.
        StoreError
            ``read_only``, ``locked``, ``schema_version``, ...; ``not_read_back`` where the archive has something else
            than what was added.
        """
        return self.add_records([record_of(folder)])[0]

    def add_records(self, records: Sequence[Record]) -> Sequence[Added]:
        """Add records, all or none, and read them back.

        Raises
        ------
        StoreError
            As `add`.
        """
        with self.database.writing() as connection:
            every = [add_record(connection, one, self.database.name, time.time_ns()) for one in records]
        with self.database.reading() as connection:
            for added, record in zip(every, records, strict=True):
                if added.new and read_record(connection, added.number).lines() != record.lines():
                    what = f"campaign {added.name} was added as number {added.number}, and reads otherwise"
                    do = "Verify the archive before more is added"
                    raise StoreError(what, where=self.database.name, do=do, code="not_read_back")
        return every

    def list(self, serial: str | None = None) -> Listing:
        """Return the campaigns, by unit and time.

        Parameters
        ----------
        serial : str, optional
            Of the unit whose campaigns are wanted.
        """
        first = select(tests.c.campaign_id, func.min(tests.c.first_ns).label("first_ns"))
        first_of = first.group_by(tests.c.campaign_id).subquery()
        query = (
            select(campaigns, items.c.serial, items.c.part, items.c.maker, first_of.c.first_ns,
                   (~newest()).label("replaced"))
            .join(items, items.c.id == campaigns.c.item_id)
            .outerjoin(first_of, first_of.c.campaign_id == campaigns.c.id)
            .order_by(items.c.maker, items.c.part, items.c.serial, campaigns.c.id)
        )  # fmt: skip
        if serial is not None:
            query = query.where(items.c.serial == serial)
        with self.database.reading() as connection:
            found = connection.execute(query).mappings().all()
        names = [name for name in Listed.__dataclass_fields__ if name not in ("number", "replaced")]
        listed = [Listed(number=one["id"], replaced=bool(one["replaced"]), **{name: one[name] for name in names})
                  for one in found]  # fmt: skip
        return Listing(self.database.name, tuple(listed))

    def history(
        self,
        serial: str,
        part: str | None = None,
        quantity: str | None = None,
        axis: str | None = None,
        test: str | None = None,
        limits: Sequence[str] = (),
        adjusted: Sequence[str] = (),
    ) -> History:
        """Return what each figure of a unit was from test to test, its drift, and when it leaves a limit.

        Parameters
        ----------
        serial, part : str
            Of the unit; the part where several units have the serial number.
        quantity, axis, test : str, optional
            Of these alone.
        limits : sequence of str
            How far a figure may change since its last test: ``"0.01 deg/s"``, ``"scale_factor_error=0.1 %"``.
        adjusted : sequence of str
            Days of adjustments, ``"2024-05-04"``, or instants: tests of that day are after it ("as left").

        Raises
        ------
        DataError
            ``no_item``; ``no_figure``; ``unit_mismatch`` of a limit.
        UsageError
            ``several_items``; ``allowed``.
        """
        with self.database.reading() as connection:
            return history(connection, serial, part, quantity, axis, test, limits, adjusted)

    def trend(
        self,
        quantity: str,
        axis: str | None = None,
        test: str | None = None,
        part: str | None = None,
        by: By = "unit",
        every: bool = False,
    ) -> Trend:
        """Return a quantity over all units as a control chart.

        Parameters
        ----------
        quantity : str
            Which.
        axis, test, part : str, optional
            Of these alone.
        by : {"unit", "lot"}
            A point a unit, or one a lot.
        every : bool
            All tests of a unit, not the last alone.

        Raises
        ------
        DataError
            ``no_figure``; ``few_figures`` where no chart has enough.
        """
        with self.database.reading() as connection:
            return trend(connection, quantity, axis, test, part, by, every)

    def compare(
        self, first: int, second: int, allowed: Sequence[str] = (), decision: str = "", shared: Sequence[str] = ()
    ) -> Comparison:
        """Compare two campaigns of the archive, as ``inertialcal.compare`` compares their folders.

        Parameters
        ----------
        first, second : int
            Their numbers, as `list` has them.
        allowed, decision, shared
            As ``inertialcal.compare``.

        Raises
        ------
        DataError
            ``no_campaign``; ``damaged``; as ``inertialcal.compare``.
        """
        with self.database.reading() as connection:
            one, other = (self._side(read_record(connection, number), number) for number in (first, second))
        return compare_sides(one, other, allowed, decision, shared)

    def _side(self, record: Record, number: int) -> Compared:
        content = results_content(record)
        recordings = {use["sha256"]: use["path"] for use in record.rows["uses"]
                      if use["role"] == "input" and use["sha256"] not in record.contents}  # fmt: skip
        name = f"{self.database.name}, number {number}"
        return results_side(content, record.run["results_sha256"], name, recordings)

    def export(self, path: str | os.PathLike[str]) -> Moved:
        """Write all of it into a zip file that other programs can read.

        Raises
        ------
        StoreError
            ``not_written``.
        """
        with self.database.reading() as connection:
            return export(connection, path)

    def import_(self, path: str | os.PathLike[str]) -> Moved:
        """Add the campaigns of an export that are not there: all of them, or none.

        Raises
        ------
        DataError
            ``not_an_export``; ``schema_version``; ``damaged``; ``too_large``.
        StoreError
            As `add`.
        """
        found = read_export(path)
        there = 0
        with self.database.writing() as connection:
            last_number = int(connection.execute(select(func.max(campaigns.c.id))).scalar() or 0)
            for one in found:
                if is_there(connection, one, last_number):
                    there += 1
                else:
                    there += not add_record(connection, one.record, self.database.name, one.said["added_ns"]).new
        with self.database.reading() as connection:
            last = select(campaigns.c.chain).order_by(campaigns.c.id.desc()).limit(1)
            chain = str(connection.execute(last).scalar() or "")
        documents = len({digest for one in found for digest in one.record.contents})
        return Moved(len(found), there, documents, chain)

    def verify(self, receipt: str | os.PathLike[str] | None = None) -> Verified:
        """Compare all that the archive holds with what was added; what is missing or changed is named.

        Parameters
        ----------
        receipt : str or path, optional
            File with the output of ``archive verify --json`` of an earlier time: the campaigns that it counted have to
            be there, too.

        Raises
        ------
        DataError
            ``not_a_receipt``.
        StoreError
            As `list`.
        """
        kept = None if receipt is None else read_receipt(os.fspath(receipt))
        with self.database.reading() as connection:
            return verify(connection, self.database.name, kept)

    def migrate(self, to: str = REVISIONS[-1]) -> tuple[str, str]:
        """Bring the schema to a version, later or earlier; return the version before, and the one now.

        Raises
        ------
        UsageError
            ``unknown_name`` for a version that is none.
        StoreError
            ``no_archive``; ``schema_version`` for one that a newer version of inertialcal has made.
        """
        return self.database.migrate(to)


def add_record(connection: Connection, record: Record, archive: str, added_ns: int) -> Added:
    """Add a record, unless the newest version of its campaign has the same results.

    Parameters
    ----------
    connection : Connection
        That alone adds.
    record : Record
        What.
    archive : str
        Its address, for messages.
    added_ns : int
        When, UTC.
    """
    item = item_number(connection, record.item)
    own = select(campaigns).where(campaigns.c.item_id == item, campaigns.c.name == record.run["name"])
    last = connection.execute(own.order_by(campaigns.c.version.desc()).limit(1)).mappings().first()
    name, serial = record.run["name"], record.item["serial"]
    if last is not None and last["results_sha256"] == record.run["results_sha256"]:
        return Added(archive, last["id"], name, serial, last["version"], last["replaces"], False, last["record_sha256"])
    version, replaces = (1, None) if last is None else (last["version"] + 1, last["id"])
    before = connection.execute(select(campaigns.c.chain).order_by(campaigns.c.id.desc()).limit(1)).scalar() or ""
    digest = record.sha256
    number = written(
        connection,
        record,
        {"version": version, "replaces": replaces, "added_ns": added_ns, "record_sha256": digest,
         "chain": chained(before, digest)},
    )  # fmt: skip
    return Added(archive, number, name, serial, version, replaces, True, digest)
