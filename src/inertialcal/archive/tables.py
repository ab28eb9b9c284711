"""Tables of the archive, as its newest schema has them; ``migrations`` makes them.

Every table but ``items``, ``files`` and ``campaigns`` belongs to one campaign, and keeps the order of its rows
in ``position``: with it, a record read back is the record that was written, to the last bit. Lists and matrices are
JSON, whose numbers have all their digits.
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
)
from sqlalchemy.schema import SchemaItem

REVISIONS = ("0001", "0002")  # of the schema, as in ``migrations/versions``; the last is that of this module

metadata = MetaData()


def _text(name: str) -> Column[str]:
    return Column(name, Text, nullable=False)


def _number(name: str) -> Column[float]:
    return Column(name, Double)


items = Table(
    "items",
    metadata,
    Column("id", Integer, primary_key=True),
    _text("maker"),
    _text("part"),
    _text("serial"),
    _text("owner"),
    _text("lot"),
    UniqueConstraint("maker", "part", "serial"),
)
campaigns = Table(
    "campaigns",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("item_id", ForeignKey("items.id"), nullable=False, index=True),
    _text("name"),
    Column("version", Integer, nullable=False),
    Column("replaces", ForeignKey("campaigns.id")),
    _text("title"),
    _text("owner"),  # of the unit, as stated then
    _text("lot"),  # of the unit, as stated then
    _text("verdict"),
    _text("program"),  # version of inertialcal that ran it
    _text("folder"),  # where it was run
    _text("results_sha256"),
    Column("made_ns", BigInteger),
    Column("added_ns", BigInteger, nullable=False),
    _text("record_sha256"),  # of all its rows as lines of JSON
    _text("chain"),  # SHA-256 of that of the campaign before, and of its own record
    UniqueConstraint("item_id", "name", "version"),
)


def _of_campaign(name: str, *columns: SchemaItem) -> Table:
    return Table(
        name,
        metadata,
        Column("campaign_id", ForeignKey("campaigns.id"), primary_key=True),
        Column("position", Integer, primary_key=True, autoincrement=False),
        *columns,
    )


tests = _of_campaign(
    "tests",
    _text("name"),  # of a test; of a model of the campaign, too
    _text("procedure"),
    _text("purpose"),  # fit, hold_out, report_only
    _text("condition"),
    Column("first_ns", BigInteger),
    Column("last_ns", BigInteger),
    _text("mounting"),
    _text("power_up"),
    _text("day"),
    _text("site"),
)
results = _of_campaign(
    "results",
    _text("test"),
    _text("quantity"),
    _text("axis"),
    _text("sensor"),
    Column("power", Integer, nullable=False),
    _text("at_what"),
    _number("at_value"),
    _text("at_unit"),
    _text("condition"),
    _text("method"),
    _text("member_kind"),
    _text("member"),
    _number("value"),
    _number("u"),
    _text("unit"),
    _number("dof"),  # null is infinite
    _number("lower"),
    _number("upper"),
    _number("coverage"),  # probability of the interval
    _text("status"),
    _text("reason_code"),
    _text("reason"),
    _text("shared"),  # JSON: change for one standard uncertainty, by unknown
    _text("curvature"),  # JSON
    Index("ix_results_quantity", "quantity", "axis"),
)
covariances = _of_campaign(
    "covariances",
    _text("test"),
    _text("keys"),  # JSON
    _text("units"),  # JSON
    _text("matrix"),  # JSON, SI
)
verdicts = _of_campaign(
    "verdicts",
    _text("requirement"),
    _text("quantity"),
    _text("test"),
    _text("axis"),
    _text("sensor"),
    _number("value"),
    _number("u"),
    _text("unit"),
    _number("lower"),
    _number("upper"),
    _text("verdict"),
    _text("whole"),  # JSON: the verdict as results.json has it
)
models = _of_campaign(
    "models",
    _text("condition"),
    _text("file"),
    _text("sha256"),
)
standards = _of_campaign(
    "standards",
    _text("name"),  # rate_table.rate
    _text("standard"),
    _text("quantity"),
    Column("u", Double, nullable=False),
    _text("unit"),
    _text("certificate"),
    _text("valid"),
    _text("redrawn_by"),
    _text("reason"),
)
uses = _of_campaign(
    "uses",  # files of a campaign: what went in, what came out
    _text("path"),
    _text("role"),  # input or output
    _text("sha256"),
)
files = Table(
    "files",
    metadata,
    Column("sha256", Text, primary_key=True),
    Column("size", BigInteger),
    Column("content", LargeBinary),  # zlib; null of a recording, which stays where it is
)

OF_CAMPAIGN = (tests, results, covariances, verdicts, models, standards, uses)
