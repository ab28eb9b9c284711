"""The part of YAML that calibration files use: maps, lists, numbers and words; anything else is refused.

Read are block maps, block lists, lists in brackets (over several lines too), quoted and plain words, comments. Anchors,
tags, aliases, maps in braces and text blocks are refused with their line: nothing of them is guessed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...core.errors import DataError

Plain = str | float | Sequence[Sequence[float]] | Mapping[str, "Plain"]  # what is written
DEEPEST = 12
_KEY = re.compile(r"""(?P<key>[A-Za-z0-9_./-]+|"[^"\\]*"|'[^']*')\s*:(?:\s+(?P<rest>.*))?$""")
_WORDS = {"null": None, "~": None, "true": True, "false": False, "": None}
_REFUSED = "&*!|>{}%@`"


@dataclass(frozen=True)
class Line:
    """Indent, text without comment, and number of a line."""

    indent: int
    text: str
    number: int


def parse_yaml(text: str, where: str = "") -> object:
    """Return the content of a file: dicts, lists, numbers, words, None.

    Raises
    ------
    DataError
        ``not_yaml``, with the line.
    """
    lines = _lines(text, where)
    if not lines:
        raise _error("the file is empty", 1, where)
    value, end = _block(lines, 0, lines[0].indent, where, 0)
    if end < len(lines):
        raise _error(f"{lines[end].text[:40]!r} does not belong to what stands above it", lines[end].number, where)
    return value


def _error(what: str, number: int, where: str) -> DataError:
    place = f"{where}:{number}" if where else f"line {number}"
    return DataError(what, where=place, do="Write it as maps, lists and numbers", code="not_yaml")


def _lines(text: str, where: str) -> list[Line]:
    """Return the lines with content; a list in brackets that runs over several is one."""
    found: list[Line] = []
    depth = 0
    for number, raw in enumerate(text.splitlines(), 1):
        bare = _without_comment(raw).rstrip()
        words = bare.strip()
        if not words or words == "---" or (not found and words.startswith("%")):
            continue
        if "\t" in bare[: len(bare) - len(bare.lstrip())]:
            raise _error("a tab in the indent", number, where)
        if depth:
            last = found.pop()
            found.append(Line(last.indent, f"{last.text} {words}", last.number))
        else:
            found.append(Line(len(bare) - len(bare.lstrip(" ")), words, number))
        depth += words.count("[") - words.count("]")
    if depth:
        raise _error("brackets that do not close", found[-1].number, where)
    return found


def _without_comment(line: str) -> str:
    """Return a line up to a number sign that stands outside of quotes, first or after a blank."""
    quote = ""
    for at, letter in enumerate(line):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'" and (at == 0 or line[at - 1] in " [,"):
            quote = letter
        elif letter == "#" and (at == 0 or line[at - 1].isspace()):
            return line[:at]
    return line


def _block(lines: list[Line], at: int, indent: int, where: str, depth: int) -> tuple[object, int]:
    """Return the value of the lines from ``at`` on that stand at an indent, and the line after them."""
    if depth > DEEPEST:
        raise _error("too deep", lines[at].number, where)
    if _is_item(lines[at].text):
        return _items(lines, at, indent, where, depth)
    if _KEY.match(lines[at].text):
        return _map(lines, at, indent, where, depth)
    return _scalar(lines[at].text, lines[at].number, where), at + 1


def _is_item(text: str) -> bool:
    return text == "-" or text.startswith("- ")


def _items(lines: list[Line], at: int, indent: int, where: str, depth: int) -> tuple[list[object], int]:
    found = []
    while at < len(lines) and lines[at].indent == indent and _is_item(lines[at].text):
        line = lines[at]
        rest = line.text[1:].lstrip()
        inner = indent + len(line.text) - len(rest)
        if not rest:
            value, at = _below(lines, at, indent, where, depth)
        else:
            nested = [*lines[:at], Line(inner, rest, line.number), *lines[at + 1 :]]
            value, at = _block(nested, at, inner, where, depth + 1)
        found.append(value)
    return found, at


def _map(lines: list[Line], at: int, indent: int, where: str, depth: int) -> tuple[dict[str, object], int]:
    found: dict[str, object] = {}
    while at < len(lines) and lines[at].indent == indent and not _is_item(lines[at].text):
        line = lines[at]
        match = _KEY.match(line.text)
        if match is None:
            raise _error(f"{line.text[:40]!r} is no key with a value", line.number, where)
        key = match["key"].strip("\"'")
        if key in found:
            raise _error(f"key {key!r} twice", line.number, where)
        if match["rest"]:
            found[key], at = _scalar(match["rest"], line.number, where), at + 1
        else:
            found[key], at = _below(lines, at, indent, where, depth)
    return found, at


def _below(lines: list[Line], at: int, indent: int, where: str, depth: int) -> tuple[object, int]:
    """Return the value that stands below a key or a dash; a list may stand at the indent of its key."""
    after = at + 1
    if after < len(lines) and lines[after].indent > indent:
        return _block(lines, after, lines[after].indent, where, depth + 1)
    is_list = after < len(lines) and lines[after].indent == indent and _is_item(lines[after].text)
    if is_list and not _is_item(lines[at].text):
        return _items(lines, after, indent, where, depth + 1)
    return None, after


def _scalar(text: str, number: int, where: str) -> object:
    if text.startswith("["):
        value, end = _brackets(text, 0, number, where, 0)
        if text[end:].strip():
            raise _error(f"{text[end:].strip()[:40]!r} after a list", number, where)
        return value
    return _word(text, number, where)


def _brackets(text: str, at: int, number: int, where: str, depth: int) -> tuple[list[object], int]:
    """Return the list that starts with the bracket at ``at``, and where it ends."""
    if depth > DEEPEST:
        raise _error("too deep", number, where)
    found: list[object] = []
    value: object
    at += 1
    while True:
        at += len(text[at:]) - len(text[at:].lstrip())
        if text[at : at + 1] == "]":
            return found, at + 1
        if text[at : at + 1] == "[":
            value, at = _brackets(text, at, number, where, depth + 1)
        else:
            end = re.compile(r"[,\]\[]|$").search(text, at)
            stop = len(text) if end is None else end.start()
            value, at = _word(text[at:stop].strip(), number, where), stop
        found.append(value)
        at += len(text[at:]) - len(text[at:].lstrip())
        if text[at : at + 1] == ",":
            at += 1
        elif text[at : at + 1] != "]":
            raise _error("a list without comma or end", number, where)


def _word(text: str, number: int, where: str) -> object:
    if len(text) > 1 and text[0] in "\"'" and text[-1] == text[0]:
        return text[1:-1]
    if text.lower() in _WORDS:
        return _WORDS[text.lower()]
    if text[0] in _REFUSED or text[0] in "\"'":
        raise _error(f"{text[:40]!r} is a kind of YAML that is not read here", number, where)
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def dump_yaml(content: Mapping[str, Plain], indent: int = 0) -> str:
    """Return maps, matrices and numbers as YAML; numbers keep all digits."""
    pad, lines = " " * indent, []
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines.append(f"{pad}{key}:\n{dump_yaml(value, indent + 2)}")
        elif isinstance(value, Sequence) and not isinstance(value, str):
            rows = "".join(f"{pad}- [{', '.join(_number(x) for x in row)}]\n" for row in value)
            lines.append(f"{pad}{key}:\n{rows}")
        else:
            lines.append(f"{pad}{key}: {value if isinstance(value, str) else _number(value)}\n")
    return "".join(lines)


def _number(value: float) -> str:
    """Return a number that every reader of YAML 1.1 takes as one: an exponent needs a point before it."""
    text = repr(float(value))
    return text if "." in text or "e" not in text else text.replace("e", ".0e")
