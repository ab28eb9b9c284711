"""Settings of a planner from a TOML file, with changes on top, read into the dataclass of its groups."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from ..core.errors import PlanError, StoreError, UsageError
from ..core.schema.settings import settings_values
from ..core.schema.toml import key_lines, nearest_line, parse_toml
from ..core.settings import settings_of, starter
from ..files.source import load
from ..files.write.atomic import atomic_write

T = TypeVar("T")
Groups = Mapping[str, Mapping[str, object]]


@dataclass(frozen=True)
class GroupsRead(Generic[T]):
    """Settings, the text behind them, and where it stands.

    Parameters
    ----------
    settings : dataclass
        SI.
    given : mapping
        Group, key and text, as given.
    lines : mapping
        Line of each key of the file.
    inputs : mapping of str to str
        SHA-256 of the file, by its path.
    """

    settings: T
    given: Groups
    lines: Mapping[tuple[str | int, ...], int]
    inputs: Mapping[str, str]

    def at(self, *path: str | int) -> str:
        """Return file and line of a key, or of the table around it; empty for what no file holds."""
        file = next(iter(self.inputs), "")
        line = nearest_line(dict(self.lines), path)
        return f"{file}:{line}" if line else file


def read_groups(
    kind: type[T], source: str | Path | Groups | None = None, changes: Groups | None = None
) -> GroupsRead[T]:
    """Return the settings of a file or mapping, with changes on top.

    Parameters
    ----------
    kind : type
        Dataclass whose settings are groups.
    source : path or mapping, optional
        TOML file, or groups of settings; quantities are texts with a unit.
    changes : mapping, optional
        Groups that replace keys of the source.

    Raises
    ------
    DataError
        If the file cannot be read.
    PlanError
        With every key that is unknown, missing or wrong: file, line, why, what to do.
    """
    document: dict[str, Any] = {}
    lines, inputs, folder = {}, {}, Path()
    if isinstance(source, Mapping):
        document = dict(source)
    elif source is not None:
        loaded = load(source)
        text, document = parse_toml(loaded.data, str(source))
        lines, inputs, folder = key_lines(text), {str(source): loaded.sha256}, Path(source).parent
    for group in settings_of(kind):
        table = document.get(group.name)
        if group.table is None or not isinstance(table, Mapping):
            continue
        files = [one.name for one in settings_of(group.table) if one.path and isinstance(table.get(one.name), str)]
        document[group.name] = {**table, **{name: str(folder / str(table[name])) for name in files}}
    for name, table in (changes or {}).items():
        if not isinstance(table, Mapping):
            raise UsageError(f"{name}: {table!r}", do='Give a group of settings: {"key": value}', code="wrong_value")
        own = document.get(name, {})
        kept = {key: value for key, value in table.items() if value is not None}
        document[name] = {**own, **kept} if isinstance(own, Mapping) else kept
        for key in kept:
            lines = {path: line for path, line in lines.items() if path[:2] != (name, key)}
    read = GroupsRead(kind, document, lines, inputs)
    values, problems = settings_values(kind, document, read.at)
    if problems:
        raise PlanError(problems)
    return GroupsRead(kind(**values), document, lines, inputs)


def changes_of(texts: Iterable[str]) -> dict[str, dict[str, object]]:
    """Return changes written as ``group.key=value``; a value is TOML, a bare text, or texts with commas between.

    Raises
    ------
    UsageError
        If a text is not of that form.
    """
    found: dict[str, dict[str, object]] = {}
    for text in texts:
        path, equals, value = (part.strip() for part in text.partition("="))
        group, dot, key = path.partition(".")
        if not (equals and dot and group and key and value):
            raise UsageError(f"--set {text!r}", do='Write --set GROUP.KEY=VALUE, like --set body.cube="5.08 cm"')
        found.setdefault(group, {})[key] = _value(value)
    return found


def _value(text: str) -> object:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        parts = text.split(",")
        return text if len(parts) == 1 else [_value(part.strip()) for part in parts]


def write_starter(path: Path, kind: type[object], active: Collection[str], head: str) -> None:
    """Write a settings file to begin with.

    Raises
    ------
    StoreError
        If it exists, or cannot be written.
    """
    if path.exists():
        raise StoreError("the file exists", where=str(path), do="Name another file", code="not_written")
    with atomic_write(path, ()) as aside:
        aside.write_text(starter(kind, active, head), encoding="utf-8", newline="\n")
