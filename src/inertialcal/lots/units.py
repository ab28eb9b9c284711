"""The table of units: a row a unit, its column ``serial`` and whatever else is known of it."""

from __future__ import annotations

import hashlib
from collections.abc import Set
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq

from ..core.campaign_text import FILE
from ..core.errors import DataError, PlanError, Problem
from ..core.remarks import Remark
from ..files.source import as_data_errors, read_bytes

SERIAL = "serial"
FEW = 5  # rows or names that are told
PARQUET = b"PAR1"


@dataclass(frozen=True, eq=False)
class Units:
    """The units of a lot.

    Parameters
    ----------
    table : pyarrow.Table
        A row a unit, with the column ``serial`` as text.
    sha256 : str
        Of its file; of the serials where it has none.
    """

    table: pa.Table
    sha256: str

    def __len__(self) -> int:
        """Return how many they are."""
        return int(self.table.num_rows)

    @property
    def names(self) -> list[str]:
        """Columns."""
        return [str(name) for name in self.table.column_names]

    @cached_property
    def serials(self) -> list[str]:
        """Of each unit."""
        return [str(one) for one in self.table[SERIAL].to_pylist()]

    def cells(self, name: str) -> list[object]:
        """Return a column; None where a cell is empty."""
        return [None if one == "" else one for one in self.table[name].to_pylist()]


def read_units(path: Path) -> Units:
    """Read a table of units, CSV or Parquet.

    Raises
    ------
    DataError
        ``missing_file``, ``damaged_file``; ``no_units``; ``unknown_column`` without a column serial; ``empty_serial``;
        ``wrong_type`` for columns that hold more than a value a row.
    """
    raw = read_bytes(path)
    digest = hashlib.sha256(raw).hexdigest()
    name = path.name
    if raw.startswith(PARQUET):
        with as_data_errors(name, "a table of units"):
            table = pq.read_table(pa.BufferReader(raw))
    else:
        with as_data_errors(name, "a table of units"):
            options = pa_csv.ConvertOptions(
                column_types={SERIAL: pa.string()}, null_values=[""], strings_can_be_null=True
            )
            table = pa_csv.read_csv(pa.BufferReader(raw.removeprefix(b"\xef\xbb\xbf")), convert_options=options)
    if SERIAL not in table.column_names:
        what, do = "the table of units has no column serial", f"It has: {', '.join(table.column_names)}"
        raise DataError(what, name, "a unit is known by its serial number", do, "unknown_column")
    if len(set(table.column_names)) < len(table.column_names):
        raise DataError("two columns have one name", name, do="Rename one", code="duplicate_column")
    if not table.num_rows:
        raise DataError("the table of units is empty", name, do="Give a row a unit", code="no_units")
    plain = table.cast(pa.schema([pa.field(one.name, _plain(one, name)) for one in table.schema])).combine_chunks()
    serials = pc.utf8_trim_whitespace(plain[SERIAL])
    plain = plain.set_column(plain.column_names.index(SERIAL), SERIAL, serials)
    empty = [row for row, one in enumerate(serials.to_pylist(), 2) if not one]
    if empty:
        where = f"{name}:{empty[0]}"
        what = f"{len(empty)} row{'s' * (len(empty) > 1)} without a serial number"
        raise DataError(what, where, "nobody would know which unit it is", "Give it, or delete the row", "empty_serial")
    return Units(plain, digest)


def _plain(field: pa.Field, name: str) -> pa.DataType:
    """Return the type of a column as it is kept: one value a row."""
    kind = field.type
    if pa.types.is_dictionary(kind):
        kind = kind.value_type
    if field.name == SERIAL or pa.types.is_null(kind) or pa.types.is_large_string(kind):
        return pa.string()
    if pa.types.is_nested(kind) or pa.types.is_binary(kind) or pa.types.is_large_binary(kind):
        what = f"column {field.name!r} of the table of units holds {kind}"
        raise DataError(what, name, do="Give text, numbers or instants", code="wrong_type")
    return kind


def folder_units(root: Path, files: Set[str]) -> tuple[Units, tuple[Remark, ...]]:
    """Return the folders of a folder that hold files of a campaign as units, and what there is to remark.

    Raises
    ------
    PlanError
        ``no_units``.
    """
    folders = sorted(one for one in root.glob("[!.]*") if one.is_dir())
    units = [one for one in folders if any((one / file).exists() for file in files)]
    if not units:
        what = f"no unit here: no folder in {root} holds {' or '.join(sorted(files)[:FEW])}"
        do = "Give each unit a folder named by its serial number, with the files that campaign.toml names"
        raise PlanError([Problem(what, do=do, code="no_units")])
    remarks = []
    own = [one.name for one in units if (one / FILE).exists()]
    if own:
        what = (
            f"{len(own)} unit{'s have' if len(own) > 1 else ' has'} a {FILE} of its own, which is not read: {_few(own)}"
        )
        do = "What differs from unit to unit stands in the table of units of a LOT.toml"
        remarks.append(Remark("own_campaign", "warning", what, count=len(own), do=do))
    serials = [one.name for one in units]
    others = [one.name for one in folders if one.name not in set(serials)]
    if others:
        what = f"not taken for units, no file of the campaign in them: {_few(others)}"
        remarks.append(Remark("no_unit", "info", what, count=len(others)))
    digest = hashlib.sha256("\0".join(serials).encode("utf-8", "surrogatepass")).hexdigest()
    return Units(pa.table({SERIAL: pa.array(serials, pa.string())}), digest), tuple(remarks)


def _few(names: list[str]) -> str:
    return ", ".join(names[:FEW]) + (f" and {len(names) - FEW} more" if len(names) > FEW else "")
