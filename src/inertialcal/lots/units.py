"""The table of units: a row a unit, its column ``serial`` and whatever else is known of it."""

from __future__ import annotations

import csv
import hashlib
import re
from collections.abc import Sequence, Set
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
from ..files.text.layout import decode

SERIAL = "serial"
FEW = 5  # rows or names that are told
PARQUET = b"PAR1"
SEPARATORS = ",;\t"
WITH_COMMA = re.compile(r"(?:^|[;\t])[+-]?\d+,\d+(?=[;\t]|$)", re.MULTILINE)  # a number, where no comma separates
WITH_POINT = re.compile(r"(?:^|[;\t])[+-]?\d+\.\d+(?=[;\t]|$)", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Units:
    """The units of a lot.

    Parameters
    ----------
    table : pyarrow.Table
        A row a unit, with the column ``serial`` as text.
    sha256 : str
        Of its file; of the serials where it has none.
    remarks : tuple of Remark
        What reading it brought up.
    """

    table: pa.Table
    sha256: str
    remarks: tuple[Remark, ...] = ()

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


def read_units(path: Path, serial: str = SERIAL, texts: Sequence[str] = ()) -> Units:
    """Read a table of units, CSV or Parquet. CSV may have semicolons or tabs, and then decimal commas.

    Parameters
    ----------
    path : Path
        Of its file.
    serial : str
        Column that holds the serial number; it is called ``serial`` from here on.
    texts : sequence of str
        Columns that stay text as they stand there: ``007`` is a name in a path.

    Raises
    ------
    DataError
        ``missing_file``, ``damaged_file``; ``no_units``; ``unknown_column`` without a column serial; ``empty_serial``;
        ``wrong_type`` for columns that hold more than a value a row.
    """
    raw = read_bytes(path)
    digest = hashlib.sha256(raw).hexdigest()
    name = path.name
    remarks: tuple[Remark, ...] = ()
    if raw.startswith(PARQUET):
        with as_data_errors(name, "a table of units"):
            table = pq.read_table(pa.BufferReader(raw))
    else:
        text, remarks = decode(raw, name)
        with as_data_errors(name, "a table of units"):
            table = _of_text(text, dict.fromkeys((serial, *texts), pa.string()))
    if serial not in table.column_names:
        what = f"the table of units has no column {serial}"
        do = f'It has: {", ".join(table.column_names)}. Name the one that holds it in LOT.toml: serial = "..."'
        raise DataError(what, name, "a unit is known by its serial number", do, "unknown_column")
    table = table.rename_columns([SERIAL if one == serial else one for one in table.column_names])
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
    return Units(plain, digest, remarks)


def csv_heading(text: str) -> tuple[str, list[str]]:
    """Return what separates the cells of a CSV, which is what separates its headings, and these."""
    heading = next((one for one in text.splitlines() if one.strip()), "")
    separator = max(SEPARATORS, key=heading.count)
    return separator, next(csv.reader([heading], delimiter=separator), [])


def _of_text(text: str, kinds: dict[str, pa.DataType]) -> pa.Table:
    """Return the rows of a CSV; what separates its headings separates its cells."""
    separator, _ = csv_heading(text)
    comma = separator != "," and WITH_COMMA.search(text) is not None and WITH_POINT.search(text) is None
    options = pa_csv.ConvertOptions(
        column_types=kinds, null_values=[""], strings_can_be_null=True, decimal_point="," if comma else "."
    )
    parsed = pa_csv.ParseOptions(delimiter=separator)
    return pa_csv.read_csv(pa.BufferReader(text.encode()), parse_options=parsed, convert_options=options)


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
