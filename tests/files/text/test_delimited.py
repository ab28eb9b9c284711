"""Separated text: the fast and the exact way agree, and every problem has its row."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.files.columns import Content
from inertialcal.files.text.delimited import column_names, exact, fast, parse
from inertialcal.files.text.layout import sniff


def both(text: str) -> tuple[Content | None, Content]:
    layout = sniff(text, "a.csv")
    names = column_names(layout, "a.csv")
    return fast(text, layout, names), exact(text, layout, names, "a.csv")


def assert_equal(a: Content, b: Content) -> None:
    assert [(c.name, c.unit, c.named) for c in a.columns] == [(c.name, c.unit, c.named) for c in b.columns]
    assert a.rows is not None
    assert b.rows is not None
    np.testing.assert_array_equal(a.rows, b.rows)
    for one, other in zip(a.columns, b.columns, strict=True):
        assert one.values.dtype == other.values.dtype
        np.testing.assert_array_equal(one.values, other.values)
        np.testing.assert_array_equal(one.empty, other.empty)
        np.testing.assert_array_equal(one.not_a_number, other.not_a_number)


CELL = st.one_of(
    st.integers(-(2**70), 2**70).map(str),
    st.floats(allow_infinity=False).map(repr),
    st.sampled_from(["", " ", "5 ", " 7", "+3", "1e-400", "00", "-0", ".5", "5.", "NaN", "nan(ind)", "1E5", "1d3"]),
)
LABEL = st.sampled_from(["x_a", "2020-01-01", "12:00:00", "true", "", "0x1F", "a b", "é", "inf"])


@given(st.data(), st.sampled_from([",", ";", "\t"]), st.integers(1, 4), st.booleans())
@settings(max_examples=300, deadline=None)
def test_both_ways_give_the_same_columns(data: st.DataObject, separator: str, width: int, header: bool) -> None:
    kinds = [data.draw(st.sampled_from([CELL, CELL, LABEL])) for _ in range(width)]
    rows = data.draw(st.lists(st.tuples(*kinds), min_size=1, max_size=12))
    names = [separator.join(f"name{i}" for i in range(width))] if header else []
    text = "\n".join(names + [separator.join(row) for row in rows]) + "\n"
    try:
        quick, sure = both(text)
    except DataError:  # text among numbers, ragged where the separator was read otherwise
        return
    if quick is not None:
        assert_equal(quick, sure)


@pytest.mark.parametrize(
    "text",
    [
        "t,x\n0.1,2\n0.2,\n0.3,4\n",
        "a;b\n0,5;1\n0,25;-2\n",
        "  1   2.5\n 10  -3\n",
        "x\ty\n1\tNaN\n2\t7\n",
        "k,x\na,1\nb,2\n",
        "1\n2\n3",
    ],
)
def test_regular_files_take_the_fast_way(text: str) -> None:
    quick, sure = both(text)
    assert quick is not None
    assert_equal(quick, sure)


@pytest.mark.parametrize(
    "text", ['a,b\n"1",2\n', "a,b\n1,2\n\n3,4\n", "a,b\n1,2\n# so\n3,4\n", "a,b\n0x1F,2\nb,3\n", "a\n1\ninf\n"]
)
def test_irregular_files_do_not(text: str) -> None:
    quick, _ = both(text)
    assert quick is None


def test_rows_are_those_of_the_file() -> None:
    content = parse("# c\nt,x\n1,2\n\n# pause\n3,4\n", "a.csv")
    assert content.rows is not None
    assert list(content.rows) == [3, 6]
    assert content.place("a.csv", 1) == "a.csv:6"


@pytest.mark.parametrize("text", ["t,x\n1,2\n2,abc\n3,4\n4,def\n", 't,x\n"1",2\n2,abc\n3,4\n4,def\n'])
def test_text_in_a_number_column(text: str) -> None:
    with pytest.raises(DataError) as caught:
        parse(text, "a.csv")
    (problem,) = caught.value.problems
    assert str(problem) == (
        "a.csv:3: text 'abc' in number column 'x' (2 such cells). "
        "Correct the cell, or leave it empty if the value is missing"
    )
    assert problem.code == "text_in_numbers"


def test_every_column_with_text_is_named() -> None:
    with pytest.raises(DataError) as caught:
        parse("t,x\n1,2\na,3\n4,b\n5,6\n", "a.csv")
    assert [problem.where for problem in caught.value.problems] == ["a.csv:3", "a.csv:4"]


def test_long_text_is_shortened() -> None:
    with pytest.raises(DataError, match=r"text 'y{60}\.\.\.' in"):
        parse(f"t,x\n1,2\n2,{'y' * 500}\n3,4\n", "a.csv")


@pytest.mark.parametrize("row", ["5", "5,6,7"])
def test_a_ragged_row(row: str) -> None:
    with pytest.raises(DataError, match=r"a\.csv:4: \d cell\(s\) in this row, 2 in the others") as caught:
        parse(f"t,x\n1,2\n3,4\n{row}\n6,7\n8,9\n", "a.csv")
    assert caught.value.problems[0].code == "ragged_row"


def test_a_last_row_that_was_not_written_to_its_end_is_left_out_and_told() -> None:
    content = parse("t,x,y\n1,2,3\n3,4,5\n6,7", "a.csv")
    assert [column.values.tolist() for column in content.columns] == [[1, 3], [2, 4], [3, 5]]
    (remark,) = content.remarks
    assert (remark.code, remark.where) == ("row_cut_off", "a.csv:4")
    assert not parse("t,x,y\n1,2,3\n3,4,5", "a.csv").remarks
    with pytest.raises(DataError, match="cell\\(s\\) in this row"):
        parse("t,x,y\n1,2,3\n3,4,5\n6,7\n", "a.csv")  # it has its end


@pytest.mark.parametrize("last", ["0.210000,-1.2", "0.210000,-1.", "0.210000,-1", "0.210000,-", "0.210000,"])
def test_a_last_number_that_lost_its_digits_is_no_number(last: str) -> None:
    rows = [f"{i / 100:.6f},{i / 7:.6f}" for i in range(21)]
    content = parse("\n".join(["t,x", *rows, last]), "a.csv")
    assert [len(column.values) for column in content.columns] == [21, 21]
    assert [(one.code, one.where) for one in content.remarks] == [("row_cut_off", "a.csv:23")]


def test_a_last_number_of_a_file_whose_digits_vary_is_taken_as_it_stands() -> None:
    rows = [f"{i / 100},{i / 7:.{1 + i % 6}f}" for i in range(21)]
    content = parse("\n".join(["t,x", *rows, "0.21,3.0"]), "a.csv")
    assert [len(column.values) for column in content.columns] == [22, 22]
    assert not content.remarks


def test_a_name_that_appears_twice() -> None:
    with pytest.raises(DataError, match="column name 'x' appears twice") as caught:
        parse("x,x\n1,2\n", "a.csv")
    assert caught.value.problems[0].code == "duplicate_column"


def test_a_lone_line_is_one_column() -> None:
    content = parse(" ".join(f"{i / 8}" for i in range(40)) + " \n", "a.txt")
    np.testing.assert_array_equal(content.columns[0].values, np.arange(40) / 8)
    assert content.remarks[-1].code == "values_across"
    with pytest.raises(DataError, match=r"a\.txt:1: text 'b' in number column"):
        parse(" ".join([*map(str, range(30)), "b"]), "a.txt")
    gap = parse(" ".join([*map(str, range(30)), "inf"]), "a.txt")
    assert gap.columns[0].not_a_number.tolist() == [30]


def test_columns_without_name_and_value_are_left_out_and_counted() -> None:
    content = parse("a,b,\n1,2,\n3,4,\n", "a.csv")
    assert [column.name for column in content.columns] == ["a", "b"]
    assert content.remarks[0].code == "empty_column"


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_the_same_table_in_every_layout(separator: str) -> None:
    rng = np.random.default_rng(1)
    table = rng.normal(size=(50, 3))
    for comma in (False, True):
        if comma and separator == ",":
            continue
        lines = [separator.join(repr(float(v)) for v in row) for row in table]
        text = "\n".join(lines)
        content = parse(text.replace(".", ",") if comma else text, "a.csv")
        np.testing.assert_array_equal(np.column_stack([c.values for c in content.columns]), table)
