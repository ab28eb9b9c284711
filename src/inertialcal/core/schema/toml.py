"""TOML with the line of every key, which the standard parser does not give.

The scanner sees text that ``tomllib`` has parsed, so it is valid: it only follows headers, keys, strings and brackets.
"""

from __future__ import annotations

import re
import tomllib
from bisect import bisect_left
from collections.abc import Callable, Iterator
from typing import Any

from ..errors import PlanError

LARGEST = 1_000_000  # bytes; such a file is written by hand
DEEPEST = 64  # parts of a key: the parser takes the square of them
DEEP = re.compile(r"""(?:(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+)""" + f"{{{DEEPEST}}}")
Path = tuple[str | int, ...]
At = Callable[..., str]  # place of a key path, told in messages


def parse_toml(raw: bytes, file: str) -> tuple[str, dict[str, Any]]:
    """Return the text of a TOML file, and the document.

    Parameters
    ----------
    raw : bytes
        Its content.
    file : str
        Its name, for messages.

    Raises
    ------
    PlanError
        If it is too large, or is not UTF-8 or not TOML; with the line.
    """
    if len(raw) > LARGEST:
        raise PlanError(f"{len(raw)} bytes: the file may have {LARGEST} at most", where=file)
    try:
        text = raw.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise PlanError("not UTF-8 text", where=f"{file}:{line}", do="Save the file as UTF-8") from None
    deep = DEEP.search(text)
    if deep:
        where = f"{file}:{text.count(chr(10), 0, deep.start()) + 1}"
        raise PlanError(f"not TOML: a key of more than {DEEPEST} parts", where=where, code="not_toml")
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        said, _, position = str(error).partition(" (at ")
        line_of = position.split()[1].rstrip(",") if position.startswith("line") else ""
        where = f"{file}:{line_of}" if line_of else file
        raise PlanError(f"not TOML: {said[:1].lower()}{said[1:]}", where=where, code="not_toml") from None
    except (RecursionError, ValueError, OverflowError):
        raise PlanError("not TOML: nested too deeply, or a number too large", where=file, code="not_toml") from None


def key_lines(text: str) -> dict[Path, int]:
    r"""Return the line (from 1) of each table, array element and key.

    Parameters
    ----------
    text : str
        Valid TOML.

    Returns
    -------
    dict of tuple to int
        Paths as in the parsed document: ``("tests", 0, "plan", "axis")``.

    Examples
    --------
    >>> key_lines("[a]\nb = 1\n[[c]]\nd = {e = 2}\n")[("c", 0, "d", "e")]
    4
    """
    return _Scanner(text).scan()


def nearest_line(lines: dict[Path, int], path: Path) -> int | None:
    """Return the line of the path, or of its nearest ancestor that has one."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None


class _Scanner:
    def __init__(self, text: str):
        self.text = text
        self.at = 0
        self.lines: dict[Path, int] = {}
        self.counts: dict[Path, int] = {}
        self.ends = [i for i, character in enumerate(text) if character == "\n"]

    def scan(self) -> dict[Path, int]:
        table: Path = ()
        while self._skip_blank():
            if self.text.startswith("[[", self.at):
                table = self._header(2)
            elif self.text[self.at] == "[":
                table = self._header(1)
            else:
                self._key_value(table)
        return self.lines

    def _line(self) -> int:
        return bisect_left(self.ends, self.at) + 1

    def _skip_blank(self) -> bool:
        """Go past white space and comments; False at the end."""
        while self.at < len(self.text):
            if self.text[self.at] == "#":
                self.at = (self.text.find("\n", self.at) + 1) or len(self.text)
            elif self.text[self.at] in " \t\r\n":
                self.at += 1
            else:
                return True
        return False

    def _header(self, brackets: int) -> Path:
        line = self._line()
        self.at += brackets
        names = self._key()
        self.at += brackets
        path: Path = ()
        for name in names[:-1]:
            path = self._inside((*path, name))
        path = (*path, names[-1])
        if brackets == 2:
            number = self.counts.get(path, 0)
            self.counts[path] = number + 1
            self.lines.setdefault(path, line)
            path = (*path, number)
        self.lines.setdefault(path, line)
        return path

    def _inside(self, path: Path) -> Path:
        """Path of the last element where the path names an array of tables."""
        return (*path, self.counts[path] - 1) if path in self.counts else path

    def _key(self) -> list[str]:
        """Read a dotted key; stops at '=' or ']'."""
        names: list[str] = []
        while self.at < len(self.text):
            character = self.text[self.at]
            if character in "=]":
                break
            if character in ". \t":
                self.at += 1
            elif character in "\"'":
                start = self.at
                self._string()
                names.append(self.text[start + 1 : self.at - 1])
            else:
                start = self.at
                while self.at < len(self.text) and self.text[self.at] not in ".=] \t\r\n":
                    self.at += 1
                names.append(self.text[start : self.at])
                if start == self.at:  # not TOML: cannot happen after tomllib, but never loop
                    self.at = len(self.text)
        return names

    def _key_value(self, table: Path) -> None:
        line = self._line()
        names = self._key()
        path = table
        for name in names:
            path = (*path, name)
            self.lines.setdefault(path, line)
        self.at += 1  # the '='
        self._value(path)

    def _value(self, path: Path) -> None:
        self._skip_blank()
        character = self.text[self.at : self.at + 1]
        if character in {'"', "'"}:
            self._string()
        elif character == "[":
            self._elements(path, "]")
        elif character == "{":
            self._elements(path, "}")
        else:
            while self.at < len(self.text) and self.text[self.at] not in ",]}#\r\n":
                self.at += 1

    def _elements(self, path: Path, end: str) -> None:
        """Read an array or an inline table."""
        self.at += 1
        for number in _count():
            if not self._skip_blank() or self.text[self.at] == end:
                break
            if end == "]":
                self.lines.setdefault((*path, number), self._line())
                self._value((*path, number))
            else:
                self._key_value(path)
            self._skip_blank()
            if self.text[self.at : self.at + 1] == ",":
                self.at += 1
        self.at += 1

    def _string(self) -> None:
        quote = self.text[self.at]
        triple = quote * 3
        if self.text.startswith(triple, self.at):
            self.at += 3
            self._until(triple, quote == '"')
            while self.text[self.at : self.at + 1] == quote:  # up to two more quotes belong to the string
                self.at += 1
        else:
            self.at += 1
            self._until(quote, quote == '"')

    def _until(self, end: str, escapes: bool) -> None:
        while self.at < len(self.text) and not self.text.startswith(end, self.at):
            self.at += 2 if escapes and self.text[self.at] == "\\" else 1
        self.at += len(end)


def _count() -> Iterator[int]:
    number = 0
    while True:
        yield number
        number += 1
