"""The documents' tables as data: every cell is the text that is printed."""

from __future__ import annotations

import csv
from pathlib import Path

import inertialcal

from .printed import Printed, printed

TABLES = Path(__file__).resolve().parents[1] / "tables"
EXAMPLE = Path(inertialcal.__file__).parent / "examples" / "npsat2011"
Row = dict[str, str]


def read(path: Path) -> list[Row]:
    """Return the rows of a file; lines that begin with # say where the figures stand."""
    with path.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def table(document: str, name: str) -> list[Row]:
    """Return the rows of a table of a document."""
    return read(TABLES / document / f"{name}.csv")


def stated(document: str) -> dict[str, Printed]:
    """Return the figures of a document's text, by name."""
    return {row["name"]: printed(row["printed"], count=row["unit"] == "count") for row in table(document, "stated")}


def by(rows: list[Row], *columns: str) -> dict[tuple[str, ...], Row]:
    """Return rows by the cells that name them."""
    return {tuple(row[column] for column in columns): row for row in rows}
