"""Text of a file: byte-order marks, UTF-8 with a Latin-1 fallback, line ends; binary data is refused."""

from __future__ import annotations

import codecs

from ...core.errors import DataError
from ...core.remarks import Remark

CONTROL = bytes(sorted(set(range(1, 32)) - set(b"\t\n\v\f\r\x1a")))  # Ctrl-Z ends a text of CP/M and DOS
CONTROL_SHARE = 1e-3  # of the bytes, from which it is no text
BEGINNING = 2**16  # bytes that tell text
MARKS = ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


def decode(data: bytes, where: str) -> tuple[str, tuple[Remark, ...]]:
    r"""Return the text with ``\n`` line ends, without a trailing Ctrl-Z, and what reading it brought up.

    Raises
    ------
    DataError
        If it holds nul bytes or many control characters.
    """
    remarks: tuple[Remark, ...] = ()
    if data.startswith(tuple(mark for mark, _ in MARKS)):
        text = _utf16(data, where)
    else:
        # Raise where bytes are no text
        at = data.find(b"\x00")
        if at >= 0:
            row = data.count(b"\n", 0, at) + 1
            raise DataError(
                f"a nul byte at byte {at}",
                where=f"{where}:{row}",
                why="binary data in an unknown format, or a text file truncated while it was written",
                do="Export it as text or Parquet, or delete the damaged end",
                code="not_text",
            )
        controls = len(data) - len(data.translate(None, CONTROL))
        if controls > CONTROL_SHARE * len(data):
            raise DataError(
                f"{controls} control characters in {len(data)} bytes",
                where=where,
                why="binary data in an unknown format",
                do="Export it as text or Parquet",
                code="not_text",
            )
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            text = data.decode("latin-1")
            remarks = (_not_utf8(data, error.start, where),)
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.rstrip("\x1a"), remarks


def looks_like_text(data: bytes, path: str) -> bool:
    """Whether the beginning of a file is text, so that `decode` may be tried."""
    return data.startswith(tuple(mark for mark, _ in MARKS)) or b"\x00" not in data[:BEGINNING]


def _utf16(data: bytes, where: str) -> str:
    try:
        return data.decode("utf-16").replace("\x00", "\ufffd")
    except UnicodeDecodeError as error:
        raise DataError(f"marked as UTF-16, but invalid at byte {error.start}", where=where, code="not_text") from None


def _not_utf8(data: bytes, at: int, where: str) -> Remark:
    row = data.count(b"\n", 0, at) + 1
    return Remark("not_utf8", "info", f"byte {data[at]:#04x} is not UTF-8: read as Latin-1", where=f"{where}:{row}")
