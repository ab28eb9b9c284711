"""Reduced tables: numbers, texts, rows, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.files import read_table
from inertialcal.files.text.table import NumberCells, Table

TEXT = """# dwells
set,rate [deg/s],x_dps,note
1,-5, -5.01,first
2,0,,
1,5,NaN,"a, b"
"""


@pytest.fixture
def table(tmp_path: Path) -> Table:
    path = tmp_path / "table.csv"
    path.write_text(TEXT)
    return read_table(path)


def test_columns_rows_and_units(table: Table) -> None:
    assert table.names == ("set", "rate [deg/s]", "x_dps", "note")
    assert table.text("note") == ("first", "", "a, b")
    assert table.rows.tolist() == [3, 4, 5]
    assert table.units == (None, "deg/s", "deg/s", None)
    assert table.unit("rate") == "deg/s"
    assert len(table) == 3
    assert len(table.source.sha256) == 64


def test_numbers(table: Table) -> None:
    np.testing.assert_array_equal(table.numbers("rate"), [-5.0, 0.0, 5.0])
    np.testing.assert_array_equal(table.numbers("x_dps", required=False), [-5.01, np.nan, np.nan])


def test_a_literal_nan_is_refused_where_numbers_are_required(table: Table) -> None:
    with pytest.raises(DataError) as caught:
        table.numbers("x_dps")
    (problem,) = caught.value.problems
    assert (problem.what, problem.code) == ("literal 'NaN' in required column 'x_dps'", "nan_in_required")
    assert problem.where.endswith("table.csv:5")
    assert problem.do == "Leave the cell empty if the value is missing"


def test_empty_cells_are_missing_counted_and_placed(table: Table) -> None:
    empty, literal = table.missing("x_dps")
    assert (empty.code, empty.count, empty.where.endswith("table.csv:4")) == ("missing_cells", 1, True)
    assert (literal.code, literal.count, literal.where.endswith("table.csv:5")) == ("nan_literal", 1, True)
    assert table.missing("set") == ()


def test_text_in_numbers(table: Table) -> None:
    with pytest.raises(DataError, match=r"table\.csv:3: text 'first' in number column 'note' \(2 such cells\)"):
        table.numbers("note")


def test_a_column_that_is_not_there(table: Table) -> None:
    with pytest.raises(
        DataError, match=r"no column 'rates'\. The file has: set, rate \[deg/s\], x_dps, note"
    ) as caught:
        table.numbers("rates")
    assert caught.value.problems[0].code == "wrong_column"


def test_a_number_beyond_float64(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("a\n1e999\n2\n")
    with pytest.raises(DataError, match="text '1e999' in number column 'a'"):
        read_table(path).numbers("a")


def test_decimal_comma_and_units_row(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("rate;volt\ndeg/s;V\n1,5;0,75\n-1,5;-0,75\n")
    table = read_table(path)
    np.testing.assert_array_equal(table.numbers("rate"), [1.5, -1.5])
    assert table.units == ("deg/s", "V")
    assert table.rows.tolist() == [3, 4]


def test_a_binary_format_gives_the_same_numbers(tmp_path: Path) -> None:
    path = tmp_path / "t.npz"
    rate = np.array([0.1, np.nan, 1 / 3])
    np.savez(path, rate_dps=rate, set=np.array([1, 2, 3]))
    table = read_table(path)
    np.testing.assert_array_equal(table.numbers("rate_dps"), rate)
    assert table.text("set") == ("1", "2", "3")
    assert table.unit("rate_dps") == "deg/s"


def test_the_published_table(shared: Path) -> None:
    table = read_table(shared / "reference" / "npsat2011" / "table10_rate_error_x.csv")
    error = table.numbers("error_no_ref_percent")
    assert len(table) == len(error) == 108
    assert table.missing("error_no_ref_percent")[0].count == np.isnan(error).sum() == 6
    assert table.text("axis")[0] == "X"
    assert table.where(0).endswith("table10_rate_error_x.csv:2")


def test_labels_are_the_cells_whatever_they_were_stored_as(table: Table) -> None:
    assert table.labels("set").tolist() == list(table.text("set"))
    assert table.labels("note") is table.labels("note")
    stored = np.array([1.5, 2.0, 1.5])
    found = [Table(("run",), (NumberCells(stored, stored.copy()),), np.arange(1, 4)).labels("run") for _ in range(2)]
    assert found[0].tolist() == ["1.5", "2.0", "1.5"]
    assert found[0] is found[1]
    assert not found[0].flags.writeable
