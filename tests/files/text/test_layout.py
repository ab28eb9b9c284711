"""Layouts: the same table as many programs write it."""

from __future__ import annotations

import pytest

from inertialcal.core.errors import DataError
from inertialcal.files.text.layout import Layout, sniff, split, without_signs


def look(text: str) -> Layout:
    return sniff(text, "a.csv")


@pytest.mark.parametrize(
    ("text", "separator", "decimal", "width"),
    [
        ("t,x\n0.1,2\n0.2,3\n", ",", ".", 2),
        ("0.1\t2\n0.2\t3\n", "\t", ".", 2),
        ("t;x\n0.1;2\n0.2;3\n", ";", ".", 2),
        ("t;x\n0,1;2,5\n0,2;3,5\n", ";", ",", 2),
        ("1,5;2,5\n1,6;2,6\n", ";", ",", 2),
        ("0,1\t2,5\n0,2\t3,5\n", "\t", ",", 2),
        ("  0.1   2 \n  0.2\t3\n", None, ".", 2),
        ("0,1 2,5\n0,2 3,5\n", None, ",", 2),
        ("1, 2, 3\n4, 5, 6\n", ",", ".", 3),
        ("x\n1,5\n2,5\n", "\t", ",", 1),
        ("1.5\n2.5\n", ",", ".", 1),
        ("Gyro x [deg/s]\tAcc y [g]\n1\t2\n3\t4\n", "\t", ".", 2),
        ("1\t\t3\n4\t5\t6\n", "\t", ".", 3),
    ],
)
def test_separator_and_decimal_sign(text: str, separator: str | None, decimal: str, width: int) -> None:
    found = look(text)
    assert (found.separator, found.decimal, found.width) == (separator, decimal, width)


def test_a_decimal_comma_that_comes_late() -> None:
    assert look("a;b\n" + "0;1\n" * 300 + "0,5;2\n").decimal == ","


def test_pairs_of_whole_numbers_may_be_decimal_commas() -> None:
    assert [remark.code for remark in look("1,5\n2,25\n").remarks] == ["decimal_comma"]
    for text in ("a,b\n1,5\n2,25\n", "1,-5\n2,25\n", "1,5,0\n2,25,0\n", "1,5.0\n2,25\n"):
        assert look(text).remarks == ()


def test_header_and_place_of_the_first_row() -> None:
    found = look("# by hand\n\nt,x\n1,2\n")
    assert (found.names, found.row, found.start) == (("t", "x"), 4, len("# by hand\n\nt,x\n"))
    assert look("1,2\n3,4\n").names == ("", "")


@pytest.mark.parametrize("mark", ["#", "%", "//", ";"])
def test_comment_signs(mark: str) -> None:
    assert look(f"{mark} a remark, with a comma\n1,2\n3,4\n").row == 2


def test_a_semicolon_is_no_comment_where_it_separates() -> None:
    found = look("a;b\n;1\n2;3\n")
    assert (found.separator, found.row) == (";", 2)


def test_names_in_the_last_comment() -> None:
    assert look("%time,field.x\n1,2\n3,4\n").names == ("time", "field.x")
    found = look("#  AF   Tau   Min Sigma\n1  1.0  2.0\n2  2.0  3.0\n")
    assert found.names == ("AF", "Tau", "Min Sigma")
    assert found.remarks[0].code == "header_from_comment"
    assert look("# simulated with pink noise\n1\n2\n").names == ("",)
    assert look("# AW 2016 March\n1 2 3\n4 5 6\n").names == ("", "", "")


def test_a_row_of_units() -> None:
    found = look("t;gyro_x\ns;deg/s\n0.1;1\n0.2;2\n")
    assert (found.names, found.units, found.row) == (("t", "gyro_x"), ("s", "deg/s"), 3)
    assert look("name;note\nV;deg/s\nW;K\n").units == ("", "")  # no number follows


def test_a_preamble_is_left_out_and_counted() -> None:
    found = look("Device: X\nSampling rate: 2 kHz\nt,x\n1,2\n3,4\n5,6\n7,8\n")
    assert (found.names, found.row, found.sample_rate) == (("t", "x"), 4, 2000.0)
    assert str(found.remarks[0]) == "info: a.csv:1: 2 line(s) before the table ignored: 'Device: X' ..."


@pytest.mark.parametrize(
    ("title", "left_out"),
    [
        (
            "Device: X;;\nSampling rate: 2 kHz;;\n",
            2,
        ),  # as a spreadsheet writes them, as wide as the table
        ("Device;X;\nSerial;42;\n;;\n", 3),
        ("Serial;42;\n", 1),
    ],
)
def test_title_lines_as_wide_as_the_table_are_a_preamble(title: str, left_out: int) -> None:
    found = look(f"{title}t;gyro x;temp\ns;deg/s;degC\n1;2;3\n4;5;6\n7;8;9\n")
    assert (found.names, found.units) == (("t", "gyro x", "temp"), ("s", "deg/s", "degC"))
    assert (found.row, found.remarks[0].code) == (left_out + 3, "preamble")
    assert f"{left_out} line(s) before the table" in found.remarks[0].what
    assert found.sample_rate == (2000.0 if "kHz" in title else None)


@pytest.mark.parametrize(
    ("text", "names", "row"),
    [
        ("t;x;\ns;V;V\n1;2;3\n4;5;6\n7;8;9\n", ("t", "x", ""), 3),  # the fuller line is one of units
        ("t;x;\n1;2;3\n4;5;6\n7;8;9\n", ("t", "x", ""), 2),
        ("a;b;c\nx;y;\n1;2;3\n4;5;6\n7;8;9\n", ("a", "b", "c"), 2),  # a row of text stays, and is refused
        ("name;a;\nA;b;c\nB;2;3\nC;5;6\nD;8;9\n", ("name", "a", ""), 2),  # rows that begin with a word
    ],
)
def test_a_header_with_an_empty_end_is_no_title(text: str, names: tuple[str, ...], row: int) -> None:
    found = look(text)
    assert (found.names, found.row) == (names, row)


@pytest.mark.parametrize(
    ("comment", "rate"),
    [
        ("# sample_rate: 100", 100.0), ("# Sample Rate = 102.4 Hz", 102.4), ("# fs=1.6kHz", 1600.0),
        ("# sampling frequency (Hz): 50", 50.0), ("//  Update Rate: 100.0Hz", 100.0), ("# rate 5", None),
        ("# offset=7", None), ("# fs=0", None),
    ],
)  # fmt: skip
def test_a_sample_rate_in_a_comment(comment: str, rate: float | None) -> None:
    assert look(f"{comment}\n1,2\n3,4\n").sample_rate == rate


def test_a_separator_at_the_end_of_each_line_is_no_column() -> None:
    assert look("a,b,\n1,2,\n3,4,\n").names == ("a", "b", "")
    assert look("a,b\n1,2,\n3,4,\n").names == ("a", "b", "")
    assert look("a,b,\n1,2\n3,4\n").names == ("a", "b")


def test_a_header_that_does_not_fit() -> None:
    with pytest.raises(DataError, match=r"a\.csv:1: the header names 3 column\(s\), the rows have 2"):
        look("a,b,c\n1,2\n3,4\n")
    with pytest.raises(DataError, match=r"the header names 2 column\(s\), the rows have 3"):
        look("a,b\n1,2,3\n3,4,5\n5,6,7\n")


@pytest.mark.parametrize("text", ["", "\n\n", "# only\n# comments\n"])
def test_nothing_to_read(text: str) -> None:
    with pytest.raises(DataError, match="no rows of data"):
        look(text)


def test_a_header_alone() -> None:
    with pytest.raises(DataError, match="a header, but no rows of data"):
        look("a,b\n")


def test_a_lone_line_of_many_numbers_is_a_series() -> None:
    assert look(" ".join(map(str, range(50)))).across
    assert not look("1 2 3\n").across


def test_quotes_keep_a_separator() -> None:
    assert split('"a,b", "c""d",5', ",") == ["a,b", 'c"d', "5"]
    assert split(' "a b"  5 ', None) == ["a b", "5"]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_cut_in_the_first_cell_of_its_only_row_is_refused(separator: str) -> None:
    with pytest.raises(DataError, match=r"header names 3 column"):
        look(separator.join(("t_s", "gyro_x [deg/s]", "gyro_y [deg/s]")) + "\n0.00")


@pytest.mark.parametrize("mark", ["#", "%", "//", ";", "!"])
class TestComments:
    """The signs of comments of shells, MATLAB, C, assemblers and Fortran."""

    def test_names_and_units_in_the_last_two(self, mark: str) -> None:
        text = f"{mark} a log, 2024\n{mark}{mark} ----\n{mark}time_s gx gy\n{mark} s  deg/s deg/s\n{mark} --- ---\n"
        found = look(text + "0.0 1.5 2\n0.1 2.5 3\n")
        assert (found.names, found.units, found.row) == (("time_s", "gx", "gy"), ("s", "deg/s", "deg/s"), 6)

    def test_a_sentence_above_units_names_nothing(self, mark: str) -> None:
        assert look(f"{mark} made by us\n{mark} V, A\n1,2\n3.5,4\n").names == ("V", "A")

    def test_units_below_the_header(self, mark: str) -> None:
        found = look(f"t,x,n\n{mark}s,deg/s,\n{mark} by hand\n0.1,2,5\n0.2,3,6\n")
        assert (found.units, found.row) == (("s", "deg/s", ""), 4)
        assert look(f"t,x\n0.1,2\n{mark}s,V\n0.2,3\n").units == ("", "")

    def test_before_every_row_it_is_none(self, mark: str) -> None:
        text = f"{mark} a log\n\n{mark}t, x\n{mark}{mark} 0.5, 2\n {mark}1.5, 3\n{mark}2024-03-12T10:00:00Z, 4\n"
        bare, found = without_signs(text)
        assert found == mark
        assert [len(line) for line in bare.split("\n")] == [len(line) for line in text.split("\n")]
        assert look(bare).names == ("t", "x")
        for other in ("1,2\n" + text, f"{mark} words\n{mark} alone 5\n", f"{mark} a\n1,2\n3,4\n", "", "\n"):
            assert without_signs(other) == (other, "")


def test_semicolons_that_separate_are_no_comments() -> None:
    text = ";1;2\n;3;4\n"
    assert without_signs(text) == (text, "")


@pytest.mark.parametrize(
    ("below", "units", "first"),
    [
        ("s,deg/s,n/a", ("s", "deg/s", "n/a"), 3),
        ("master,IMU 1,2\ns,deg/s,-", ("s", "deg/s", ""), 4),
        ("master,IMU,flag\ns,deg/s,1", ("s", "deg/s", "1"), 4),
        ("s,deg/s,V\nmaster,IMU,flag", ("s", "deg/s", "V"), 4),
        ("s,deg/s,2", ("", "", ""), 2),
        ("one,two,three", ("", "", ""), 2),
    ],
)
def test_units_among_lines_of_words(below: str, units: tuple[str, ...], first: int) -> None:
    found = look(f"t,x,n\n{below}\n0.1,2.5,3\n0.2,3.5,4\n")
    assert (found.names, found.row) == (("t", "x", "n"), first)
    assert tuple(unit.replace("-", "") for unit in found.units) == units
