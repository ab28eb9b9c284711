"""Grouped digits: ``1,242`` that is 1242, and what is left readable."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from inertialcal.core.errors import DataError, UsageError
from inertialcal.files import read, read_table

NO_DECIMALS = "the column also has '998'"
EITHER = "nothing in the file says"
REFUSED = {
    "one column, quoted": ('x\n"1,242"\n"998"\n"1,500"\n', 2, NO_DECIMALS),
    "one column, plain": ("x\n1,242\n998\n1,500\n", 2, NO_DECIMALS),
    "either": ("x\n1,242\n2,998\n1,500\n", 2, EITHER),
    "quoted between commas": ('a,x\n0.5,"1,242"\n0.6,"998"\n0.7,"1,500"\n', 2, ""),
    "semicolons": ("a;x\n5;998\n6;1,242\n7;1,500\n", 3, NO_DECIMALS),
    "decimal commas in another column": ("a;x\n0,5;998\n0,6;1,242\n7;1,500\n", 3, NO_DECIMALS),
    "millions": ("a;x\n0,5;1,242\n0,6;12,345,678\n0,7;1,500\n", 3, ""),
    "decimal points elsewhere": ("a;x\n5.5;1,242\n6.5;2,242\n7.5;1,500\n", 2, ""),
    "a thousand after 300 rows": ("a;x\n" + 300 * "5;998\n" + "6;1,242\n", 302, NO_DECIMALS),
}
READ = {
    "decimal commas elsewhere": ("t;x\n0,50;1,242\n0,60;2,998\n0,70;1,500\n", [1.242, 2.998, 1.5]),
    "a decimal comma in the column": ("t\tx\n5\t1,242\n6\t0,998\n7\t1,500\n", [1.242, 0.998, 1.5]),
    "four digits before the comma": ("t\tx\n5\t1,242\n6\t1200,998\n7\t1,500\n", [1.242, 1200.998, 1.5]),
    "points group": ("a;x\n5,5;1.242,5\n6,5;2.242,7\n7,5;998,1\n", [1242.5, 2242.7, 998.1]),
    "commas group": ('a,x\n5.5,"1,242.5"\n6.5,"12,242.7"\n7.5,998.1\n', [1242.5, 12242.7, 998.1]),
    "decimal commas in quotes": ('a,x\n"0,5","0,25"\n"1,5","12,5"\n"2,5","1,75"\n', [0.25, 12.5, 1.75]),
    "an exponent elsewhere": ("t;x\n1,5e3;1,242\n2,5e3;2,998\n3,5e3;1,500\n", [1.242, 2.998, 1.5]),
    "two digits behind it": ("t x\n5 1,24\n6 998\n7 1,50\n", [1.24, 998.0, 1.5]),
}


@pytest.mark.parametrize("case", REFUSED)
def test_grouped_digits_are_refused_with_row_and_column(tmp_path: Path, case: str) -> None:
    text, row, why = REFUSED[case]
    file = tmp_path / "data.csv"
    file.write_text(text)
    for reading in (read, lambda path: read_table(path).numbers("x")):
        with pytest.raises(DataError) as refused:
            reading(file)
        (problem,) = refused.value.problems
        assert problem.code == "grouped_digits"
        assert problem.where == f"{file}:{row}"
        assert "'x'" in problem.what
        assert why in problem.why
        assert "without grouping" in problem.do


@pytest.mark.parametrize("case", READ)
def test_decimal_commas_stay_readable(tmp_path: Path, case: str) -> None:
    text, values = READ[case]
    file = tmp_path / "data.csv"
    file.write_text(text)
    recording = read(file)
    assert recording.channel("x").data.tolist() == values
    assert read_table(file).numbers("x").tolist() == values


def test_labels_are_no_numbers_with_grouped_digits(tmp_path: Path) -> None:
    file = tmp_path / "data.csv"
    file.write_text('x,label\n1,"1,242"\n2,up\n3,"1,242"\n')
    assert read(file).names == ("x",)


def test_a_stated_decimal_sign_decides(tmp_path: Path) -> None:
    file = tmp_path / "data.csv"
    file.write_text("x\n1,242\n2,998\n1,500\n")
    with pytest.raises(DataError, match="--decimal comma"):
        read(file)
    assert read(file, decimal="comma").channel("x").data.tolist() == [1.242, 2.998, 1.5]
    file.write_text("x;y\n998;5\n1,242;6\n")
    assert read(file, decimal="comma").channel("x").data.tolist() == [998.0, 1.242]
    file.write_text("x\n" + '"1,242"\n' * 5)
    with pytest.raises(DataError, match="grouped digits"):
        read(file, decimal="point")
    with pytest.raises(UsageError, match="comma or point"):
        read(file, decimal=".")


def test_only_text_has_a_decimal_sign(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(6.0).reshape(3, 2))
    with pytest.raises(UsageError, match="no decimal sign"):
        read(tmp_path / "a.npy", decimal="comma")


def test_grouped_digits_as_text_of_another_format(tmp_path: Path) -> None:
    file = tmp_path / "a.parquet"
    columns = {"t_s": np.arange(9) / 10, "gyro_x": ["998"] * 4 + ["1,242"] * 5, "gyro_y": np.ones(9)}
    pq.write_table(pa.table(columns), file)
    with pytest.raises(DataError, match="grouped digits '1,242' in number column 'gyro_x'") as refused:
        read(file)
    assert refused.value.problems[0].code == "grouped_digits"
    assert refused.value.problems[0].where == f"{file}: sample 5"


def test_a_row_that_grouped_digits_make_too_wide(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("x,y\n998,1\n999,2\n1,242,3\n997,4\n")
    with pytest.raises(DataError, match="1,242 with grouped digits") as refused:
        read(file)
    assert (refused.value.problems[0].code, refused.value.problems[0].where) == ("grouped_digits", f"{file}:4")
