"""Encodings: what editors and spreadsheets leave in a text."""

from __future__ import annotations

import pytest

from inertialcal.core.errors import DataError
from inertialcal.files.text.layout import decode


@pytest.mark.parametrize("codec", ["utf-8", "utf-8-sig", "utf-16"])
def test_marks_are_understood(codec: str) -> None:
    assert decode("Zeit,µg\n1,2\n".encode(codec), "a.csv") == ("Zeit,µg\n1,2\n", ())


def test_latin_1_is_remarked() -> None:
    text, (remark,) = decode("t,x\n1,°\n".encode("latin-1"), "a.csv")
    assert text == "t,x\n1,°\n"
    assert str(remark) == "info: a.csv:2: byte 0xb0 is not UTF-8: read as Latin-1"


def test_line_ends_and_the_end_of_a_dos_text() -> None:
    assert decode(b"1\r\n2\r3\n\x1a", "a.csv")[0] == "1\n2\n3\n"


def test_a_nul_byte_is_refused_with_its_row() -> None:
    with pytest.raises(DataError, match=r"a\.csv:3: a nul byte at byte 9 \(binary data"):
        decode(b"1,2\n3,4\n5\x00,6\n", "a.csv")


def test_control_characters_are_refused() -> None:
    with pytest.raises(DataError, match="4 control characters in 10 bytes") as caught:
        decode(b"\x01\x02ab\x03\x04cdef", "a.csv")
    assert caught.value.problems[0].code == "not_text"


def test_broken_utf_16() -> None:
    with pytest.raises(DataError, match="marked as UTF-16, but invalid at byte"):
        decode(b"\xff\xfea", "a.csv")
