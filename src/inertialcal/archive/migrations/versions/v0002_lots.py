"""Lots of units, and an index for trends of one quantity over all units."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the lot of a unit, as its campaigns state it; of those that are there, nobody has."""
    for table in ("items", "campaigns"):
        with op.batch_alter_table(table) as batch:
            batch.add_column(sa.Column("lot", sa.Text, nullable=False, server_default=""))
    op.create_index("ix_results_quantity", "results", ["quantity", "axis"])


def downgrade() -> None:
    """Drop lots: the documents of campaigns still state them."""
    op.drop_index("ix_results_quantity", "results")
    for table in ("campaigns", "items"):
        with op.batch_alter_table(table) as batch:
            batch.drop_column("lot")
