"""The first schema: items, campaigns, tests, results, covariances, verdicts, models, standards, files.

It stands alone: later changes of ``tables`` do not reach it.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.schema import SchemaItem

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def _texts(*names: str) -> list[sa.Column[str]]:
    return [sa.Column(name, sa.Text, nullable=False) for name in names]


def _numbers(*names: str) -> list[sa.Column[float]]:
    return [sa.Column(name, sa.Double) for name in names]


def _of_campaign(name: str, *columns: SchemaItem) -> None:
    op.create_table(
        name,
        sa.Column("campaign_id", sa.Integer, sa.ForeignKey("campaigns.id"), primary_key=True),
        sa.Column("position", sa.Integer, primary_key=True, autoincrement=False),
        *columns,
    )


def upgrade() -> None:
    """Make all tables."""
    op.create_table(
        "items",
        sa.Column("id", sa.Integer, primary_key=True),
        *_texts("maker", "part", "serial", "owner"),
        sa.UniqueConstraint("maker", "part", "serial"),
    )
    op.create_table(
        "campaigns",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("item_id", sa.Integer, sa.ForeignKey("items.id"), nullable=False),
        *_texts("name"),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("replaces", sa.Integer, sa.ForeignKey("campaigns.id")),
        *_texts("title", "owner", "verdict", "program", "folder", "results_sha256"),
        sa.Column("made_ns", sa.BigInteger),
        sa.Column("added_ns", sa.BigInteger, nullable=False),
        *_texts("record_sha256", "chain"),
        sa.UniqueConstraint("item_id", "name", "version"),
    )
    op.create_index("ix_campaigns_item_id", "campaigns", ["item_id"])
    _of_campaign(
        "tests",
        *_texts("name", "procedure", "purpose", "condition"),
        sa.Column("first_ns", sa.BigInteger),
        sa.Column("last_ns", sa.BigInteger),
        *_texts("mounting", "power_up", "day", "site"),
    )
    _of_campaign(
        "results",
        *_texts("test", "quantity", "axis", "sensor"),
        sa.Column("power", sa.Integer, nullable=False),
        *_texts("at_what"),
        *_numbers("at_value"),
        *_texts("at_unit", "condition", "method", "member_kind", "member"),
        *_numbers("value", "u"),
        *_texts("unit"),
        *_numbers("dof", "lower", "upper", "coverage"),
        *_texts("status", "reason_code", "reason", "shared", "curvature"),
    )
    _of_campaign("covariances", *_texts("test", "keys", "units", "matrix"))
    _of_campaign(
        "verdicts",
        *_texts("requirement", "quantity", "test", "axis", "sensor"),
        *_numbers("value", "u"),
        *_texts("unit"),
        *_numbers("lower", "upper"),
        *_texts("verdict", "whole"),
    )
    _of_campaign("models", *_texts("condition", "file", "sha256"))
    _of_campaign(
        "standards",
        *_texts("name", "standard", "quantity"),
        sa.Column("u", sa.Double, nullable=False),
        *_texts("unit", "certificate", "valid", "redrawn_by", "reason"),
    )
    _of_campaign("uses", *_texts("path", "role", "sha256"))
    op.create_table(
        "files",
        sa.Column("sha256", sa.Text, primary_key=True),
        sa.Column("size", sa.BigInteger),
        sa.Column("content", sa.LargeBinary),
    )


def downgrade() -> None:
    """Drop all tables."""
    for name in ("files", "uses", "standards", "models", "verdicts", "covariances", "results", "tests"):
        op.drop_table(name)
    op.drop_table("campaigns")
    op.drop_table("items")
