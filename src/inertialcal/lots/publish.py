"""What a lot writes: ``units/part-00000.parquet``, ..., ``lot.json``, ``provenance.json``.

The parts are built aside. ``lot.json`` goes first and comes last: where it stands, it is that of the parts beside it.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from ..campaign.outcome.publish import version_of_package, versions
from ..core.errors import DataError, StoreError
from ..core.schema.json_text import json_text
from .ledger import Ledger, Noted
from .lot_file import Lot
from .rows import OWN
from .study import Columns, Study, study
from .table import read_table

LOT, UNITS, PROVENANCE = "lot.json", "units", "provenance.json"
NEW = "units.new"
REPORT = "report.html"
PLACES, FACTORS = ("tested", "time"), ("position", "operator")  # columns, where LOT.toml does not say
PART = 250  # units in a file
VERDICTS = ("PASS", "FAIL", "INCONCLUSIVE")
SHOWN = ("number", "serial", "status", "reason_code", "reason", "verdict")


def publish_lot(
    folder: Path,
    lot: Lot,
    version: str,
    noted: Sequence[Noted],
    ledger: Ledger,
    how: Mapping[str, object],
    report: bool = True,
) -> tuple[dict[str, object], Study]:
    """Write the parts, the report and ``lot.json``, in place of what stands there; return the content of the latter.

    Parameters
    ----------
    folder : Path
        Of the lot.
    lot : Lot
        As read.
    version : str
        Of the code.
    noted : sequence of Noted
        Every unit, in the order of the table.
    ledger : Ledger
        That has their rows.
    how : mapping
        Of the run, for ``provenance.json``.
    report : bool
        Write ``report.html`` too.

    Raises
    ------
    StoreError
        ``not_writable``; what stands there stays.
    """
    try:
        new = folder / NEW
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir()
        parts = [_part(new, lot, ledger, noted, first) for first in range(0, len(noted), PART)]
        columns = line_of(lot)
        names = [one for one in (columns.station, columns.place, *columns.factors) if one]
        found = study(read_table([new / Path(str(one["file"])).name for one in parts], names), columns)
        content: dict[str, object] = {
            "format": "inertialcal-lot", "schema": 1, "id": lot.file.id, "title": lot.file.title,
            "version": version_of_package(), "code": version,
            "template": {"id": lot.template.file.campaign.id, "sha256": lot.template.sha256},
            "units": {"columns": lot.units.names, "sha256": lot.units.sha256},
            "counts": counts(noted),
            "quarantined": dict(sorted(Counter(one.reason_code for one in noted if one.reason_code).items())),
            "parts": parts,
            "statistics": found.content(),
            "remarks": [one.to_dict() for one in lot.remarks],
        }  # fmt: skip
        (folder / LOT).unlink(missing_ok=True)
        shutil.rmtree(folder / UNITS, ignore_errors=True)
        os.replace(new, folder / UNITS)
        said = {"made": datetime.now(UTC).isoformat(timespec="seconds"), "versions": versions(),
                "machine": {"system": platform.system(), "machine": platform.machine()},
                "lot": str(lot.path.resolve()), **how}  # fmt: skip
        _write(folder / PROVENANCE, json_text(said))
        (folder / REPORT).unlink(missing_ok=True)
        if report:
            from .page import lot_page  # noqa: PLC0415 - draws, which starts slowly

            _write(folder / REPORT, lot_page(found, lot.file.id, lot.file.title))
        _write(folder / LOT, json_text(content))
    except OSError as error:
        raise StoreError(f"cannot write into {folder}: {error.strerror}", code="not_writable") from None
    return content, found


def line_of(lot: Lot) -> Columns:
    """Return the columns that say where and when units were tested: as LOT.toml has them, else those of usual names."""
    said, names = lot.file.line, lot.units.names
    if said is not None:
        return Columns(said.station, said.place, tuple(said.factors))
    place = next((one for one in PLACES if one in names), "")
    return Columns("station" if "station" in names else "", place, tuple(one for one in FACTORS if one in names))


def _write(path: Path, text: str) -> None:
    new = path.with_name(f"{path.name}.new")
    new.write_text(text, encoding="utf-8", newline="\n")
    os.replace(new, path)


def counts(noted: Sequence[Noted]) -> dict[str, int]:
    """Return how many units there are, by how they ended."""
    ended = Counter(one.status for one in noted)
    verdicts = Counter(one.verdict for one in noted)
    return {"units": len(noted), "done": ended["done"], "quarantined": ended["quarantined"]} | {
        name: verdicts[name] for name in VERDICTS
    }


def _part(new: Path, lot: Lot, ledger: Ledger, noted: Sequence[Noted], first: int) -> dict[str, object]:
    """Write the rows of the units from one on; return what ``lot.json`` says of them."""

    @lru_cache(maxsize=4)
    def block(number: int) -> pa.Table:
        with pa.ipc.open_stream(ledger.rows(number)) as stream:
            return stream.read_all()

    own = noted[first : first + PART]
    table = pa.concat_tables([block(one.block).slice(one.place, 1) for one in own])
    table = table.set_column(0, "number", pa.array(range(first, first + len(own)), pa.int64()))
    given = lot.units.table.slice(first, len(own))
    for name in given.column_names:
        if name != "serial":
            table = table.append_column(name if name not in OWN else f"unit_{name}", given[name])
    name = f"part-{first // PART:05d}.parquet"
    pq.write_table(table.combine_chunks(), new / name, compression="zstd", row_group_size=PART)
    digest = hashlib.sha256((new / name).read_bytes()).hexdigest()
    return {"file": f"{UNITS}/{name}", "units": len(own), "sha256": digest}


def read_units_of(folder: Path, content: Mapping[str, object]) -> dict[str, list[object]]:
    """Return a row a unit of what a lot wrote, without the lists of figures, by column.

    Raises
    ------
    DataError
        ``changed`` for a part that is no longer what the lot wrote; ``missing_file``.
    """
    found: list[pa.Table] = []
    parts: Sequence[Mapping[str, str]] = content["parts"]  # type: ignore[assignment]
    for part in parts:
        path = folder / part["file"]
        if not path.is_file():
            raise DataError(
                "no such file", str(path), do="Resume the lot: its files are written again", code="missing_file"
            )
        names = [name for name in pq.read_schema(path).names if name in SHOWN or name not in OWN]
        found.append(pq.read_table(path, columns=names))
    return {str(name): column for name, column in pa.concat_tables(found).to_pydict().items()}
