"""Campaign files as TOML that people read: tables from plain dicts, with comments, and lines that fit the page.

A mapping that fits on one line is written on one; a longer one becomes a table. Long lists are wrapped.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

FILE = "campaign.toml"
LOT = "LOT.toml"  # one campaign for many units
SCHEMA = 2  # of campaign.toml
FILL_IN = "FILL IN"  # comment behind a value that `init` does not know
MARK = f"# {FILL_IN}"
WIDTH = 120  # [characters]
BARE = re.compile(r"[A-Za-z0-9_-]+")  # keys that need no quotes
PLAIN = re.compile(r"[ !#-\[\]-~]*")  # ASCII without quotation mark and backslash: nothing to escape
Path = tuple[str, ...]  # keys of a table


@dataclass(frozen=True)
class Noted:
    """A value with comments."""

    value: object  # The value itself
    note: str = ""  # Comment at the end of its line
    above: str = ""  # Comment above it; may have several lines
    example: bool = False  # Whether the value is commented out as a whole


def toml_text(document: Mapping[str, object]) -> str:
    """Return a document as TOML: plain values first, then a table for every mapping and every list of mappings."""
    return "\n".join(_table((), document, Noted(document), "")) + "\n"


def _table(path: Path, content: Mapping[str, object], noted: Noted, header: str) -> list[str]:
    """Return the lines of a table: its values, then the tables inside it, each after a blank line."""
    entries = {key: _noted(value) for key, value in content.items()}
    listed = header.startswith("[[")
    collection = len(path) == 1 and not listed and all(isinstance(one.value, Mapping) for one in entries.values())
    values: list[str] = []
    tables: list[str] = []
    for key, one in entries.items():
        if not path and one.value == {}:
            continue
        below = (*path, _key(key))
        lines = _assignment(below[-1], one)
        if isinstance(one.value, Mapping) and (not path or collection or not _fits(lines[-1], one.value)):
            tables += ["", *_table(below, one.value, one, f"[{'.'.join(below)}]")]
        elif not path and isinstance(one.value, list):
            for row in map(_noted, one.value):
                if isinstance(row.value, Mapping):
                    tables += ["", *_table(below, row.value, row, f"[[{below[0]}]]")]
        else:
            values += lines
    if header and tables and not values and not listed:
        return _commented(tables[1:], noted)  # a table that holds tables alone needs no header
    head = [f"{header}  # {noted.note}" if noted.note else header] if header else []
    return _commented([*head, *values, *tables], noted)


def _noted(value: object) -> Noted:
    return value if isinstance(value, Noted) else Noted(value)


def _commented(lines: list[str], noted: Noted) -> list[str]:
    """Return lines below their comment, all of them commented out for an example."""
    lines = [*(f"# {line}" for line in noted.above.splitlines()), *lines]
    return [line if line.startswith("#") else f"# {line}".rstrip() for line in lines] if noted.example else lines


def _assignment(key: str, noted: Noted) -> list[str]:
    """Return the lines of a key with its value; a long list, or one with comments in it, is wrapped."""
    behind = f"  # {noted.note}" if noted.note else ""
    line = f"{key} = {_inline(noted.value)}"
    items = [_noted(one) for one in noted.value] if isinstance(noted.value, list) else []
    if not items or (len(line) <= WIDTH and not any(one.note for one in items)):
        return _commented([line + behind], noted)
    lines, row = [f"{key} = [{behind}"], " "
    for one in items:
        item = f" {_inline(one.value)},"
        if row != " " and len(row) + len(item) > WIDTH:
            lines.append(row)
            row = " "
        row += item
        if one.note:
            lines.append(f"{row}  # {one.note}")
            row = " "
    return _commented([*lines, *([row] if row != " " else []), "]"], noted)


def _fits(line: str, table: Mapping[str, object]) -> bool:
    """Whether a table is written on one line: comments on its values need lines of their own."""
    return len(line) <= WIDTH and not any(isinstance(one, Noted) for one in table.values())


def _key(key: str) -> str:
    if BARE.fullmatch(key):
        return key
    import tomlkit  # noqa: PLC0415 - starts slowly

    return tomlkit.key(key).as_string()


def _inline(value: object) -> str:
    """Return a value on one line."""
    if isinstance(value, Noted):
        return _inline(value.value)
    if isinstance(value, Mapping):
        pairs = [f"{_key(key)} = {_inline(one)}" for key, one in value.items()]
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_inline, value))}]"
    if isinstance(value, str) and PLAIN.fullmatch(value):
        return f'"{value}"'
    import tomlkit  # noqa: PLC0415 - starts slowly

    return str(tomlkit.item(value).as_string())
