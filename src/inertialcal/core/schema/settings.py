"""Settings as text, read into their dataclass: units and limits as its fields state them, every problem at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Annotated, Any, cast, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationError, create_model

from ..errors import Problem
from ..settings import Setting, settings_of
from ..unit.magnitudes import LARGEST, MOST, SMALLEST, is_possible
from .quantities import quantity

Called = Callable[[tuple[str | int, ...]], str]


def settings_values(
    kind: type[object], given: Mapping[str, Any], at: Callable[..., str], *above: str, called: Called | None = None
) -> tuple[dict[str, Any], list[Problem]]:
    """Return the settings that a table gives, SI, and what is wrong with it.

    Parameters
    ----------
    kind : type
        Dataclass of settings; a setting may be a table of settings itself.
    given : mapping
        The table as parsed.
    at : callable
        Place of a key path, for messages.
    above : str
        Path of the table.
    called : callable, optional
        How the caller calls the setting at a path: ``"--order"``; by default its keys with points between.
    """
    try:
        read = _model(cast("Any", kind)).model_validate(given)
    except ValidationError as error:
        return {}, [_problem(kind, entry, at, above, called) for entry in error.errors(include_url=False)]
    tables = {one.name: one.table for one in settings_of(kind)}
    return {name: _value(getattr(read, name), tables[name]) for name in given}, []


@cache
def _model(kind: Any) -> type[BaseModel]:
    """Return the pydantic model of a dataclass of settings."""
    fields: dict[str, Any] = {one.name: (_annotation(one), _field(one)) for one in settings_of(kind)}
    return create_model(kind.__name__, __config__=ConfigDict(extra="forbid", strict=True), **fields)


def _value(read: Any, table: type[Any] | None) -> Any:
    """Return a setting, tables of settings as their own dataclass."""
    if table is None or read is None:
        return read
    if isinstance(read, list):
        return [_value(one, table) for one in read]
    tables = {one.name: one.table for one in settings_of(table)}
    return table(**{name: _value(getattr(read, name), tables[name]) for name in read.model_fields_set})


def _annotation(one: Setting) -> Any:
    """Return the type that the text has to give: "number unit" for a quantity."""
    if one.path:
        return Annotated[Path, Strict(False)] | None
    if not one.unit and one.table is None:
        return Annotated[one.kind, AfterValidator(_plain)]
    table: Any = one.table
    kind: Any = quantity(one.unit, one.difference) if one.unit else _model(table)
    kind = list[kind] if one.many else kind
    return kind | None if type(None) in get_args(one.kind) or one.table is not None else kind


def _plain(given: Any) -> Any:
    """Refuse a number without a unit that nobody can mean, wherever it stands in a setting."""
    if isinstance(given, float) and not is_possible(given):
        raise ValueError(f"should be 0, or a number from {SMALLEST:g} to {LARGEST:g}")
    if isinstance(given, int) and abs(given) > MOST:
        raise ValueError(f"should be a whole number up to {MOST}")
    for one in given.values() if isinstance(given, Mapping) else given if isinstance(given, list | tuple) else ():
        _plain(one)
    return given


def _field(one: Setting) -> Any:
    limits: dict[str, Any] = {"gt": one.above, "ge": one.least, "le": one.most}
    given = {name: limit for name, limit in limits.items() if limit is not None}
    if one.needed:
        return Field(**given)
    if callable(one.default):
        return Field(default_factory=one.default, **given)
    return Field(default=one.default, **given)


def _problem(kind: Any, entry: Any, at: Callable[..., str], above: tuple[str, ...], called: Called | None) -> Problem:
    path = (*above, *entry["loc"])
    name, where = ".".join(map(str, path)) if called is None else called(path), at(*path)
    if entry["type"] == "model_type":
        do = "Give a table of settings"
        return Problem(f"{name}: {entry['input']!r} is not a table", where, do=do, code="wrong_value")
    *tables, last = (part for part in entry["loc"] if isinstance(part, str))
    for part in tables:
        table = next(one.table for one in settings_of(kind) if one.name == part)
        if table is None:  # A setting of free names: what is wrong is one of its values
            last = part
            break
        kind = table
    known = {one.name: one for one in settings_of(kind)}
    if entry["type"] == "extra_forbidden":
        near = get_close_matches(last, known, n=1)
        do = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(known)}"
        return Problem(f"unknown key {name}", where, "it would have no effect", do, "unknown_key")
    written = known[last].written if called is None else f"{name} {known[last].example}"
    do = f"Example: {written}" if known[last].example else ""
    if entry["type"] == "missing":
        return Problem(f"{name} is missing", where, do=do, code="missing_key")
    what = entry["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
    unit = (
        f" {known[last].unit}"
        if known[last].unit not in ("", "1") and entry.get("ctx", {}).keys() & {"gt", "ge", "le"}
        else ""
    )
    value = (
        "" if isinstance(entry["input"], Mapping | list) or str(entry["input"]) in what else f" = {entry['input']!r}"
    )
    return Problem(f"{name}{value}: {what}{unit}", where, do=do, code="wrong_value")
