"""Plan of a test: the ``plan`` table of the campaign file, read into the dataclass of its procedure.

The settings of the procedure's ``Plan`` are the schema: their types, units and limits say what may stand there.
Fields that come from the sensor or the standards cannot be set in ``plan``.
"""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from typing import Any, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from ...core.errors import Problem
from ...core.schema.quantities import quantity
from ...core.settings import Setting, settings_of
from ...procedures import procedure_of


def plan_values(procedure: str, given: dict[str, Any], where: str) -> tuple[dict[str, Any], list[Problem]]:
    """Return the values of a plan table, SI, and what is wrong with it.

    Parameters
    ----------
    procedure : str
        Name in the dict of procedures.
    given : dict
        The table as parsed.
    where : str
        Place of the table, for messages.
    """
    plan: Any = procedure_of(procedure).plan_type
    settings = {one.name: one for one in settings_of(plan)}
    try:
        read = _model(plan).model_validate(given)
    except ValidationError as error:
        return {}, [_problem(entry, list(settings), where) for entry in error.errors(include_url=False)]
    return {name: _value(getattr(read, name), settings[name]) for name in given}, []


@cache
def _model(plan: Any) -> type[BaseModel]:
    """Return the pydantic model of a dataclass of settings."""
    fields: dict[str, Any] = {one.name: (_annotation(one), _field(one)) for one in settings_of(plan)}
    return create_model(plan.__name__, __config__=ConfigDict(extra="forbid", strict=True), **fields)


def _value(read: Any, setting: Setting) -> Any:
    """Return a setting, tables of settings as their own dataclass."""
    if setting.table is None or read is None:
        return read
    return setting.table(**{one.name: getattr(read, one.name) for one in settings_of(setting.table)})


def _annotation(one: Setting) -> Any:
    """Return the type that a campaign file has to give: text "number unit" for a quantity."""
    if not one.unit and one.table is None:
        return one.kind
    inner: Any = one.table
    kind = quantity(one.unit, one.difference) if one.unit else _model(inner)
    kind = list[kind] if one.many else kind  # type: ignore[valid-type]
    return kind | None if type(None) in get_args(one.kind) or one.table is not None else kind


def _field(one: Setting) -> Any:
    limits: dict[str, Any] = {"gt": one.above, "ge": one.least, "le": one.most}
    given = {name: limit for name, limit in limits.items() if limit is not None}
    if one.needed:
        return Field(**given)
    if callable(one.default):
        return Field(default_factory=one.default, **given)
    return Field(default=one.default, **given)


def _problem(entry: Any, known: list[str], where: str) -> Problem:
    name = ".".join(str(part) for part in entry["loc"])
    if entry["type"] == "extra_forbidden":
        near = get_close_matches(name, known, n=1)
        do = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(known)}"
        return Problem(f"unknown key plan.{name}", where, "it would have no effect", do, "unknown_key")
    what = entry["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
    return Problem(f"plan.{name}: {what}", where, code="wrong_value")
