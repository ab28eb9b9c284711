"""Plan of a test: the ``plan`` table of the campaign file, read into the dataclass of its procedure.

The fields of the procedure's ``Plan`` are the schema: their types and units (``metadata``) say what may stand
there. Fields that come from the sensor or the standards cannot be set in ``plan``.
"""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass
from difflib import get_close_matches
from functools import cache
from typing import Any, get_args, get_origin, get_type_hints

from pydantic import ConfigDict, Field, ValidationError, create_model

from ..core.errors import Problem
from ..core.quantities import quantity
from ..procedures import procedure_of


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
    settings = plan_settings(plan)
    try:
        read = _model(plan).model_validate(given)
    except ValidationError as error:
        return {}, [_problem(entry, list(settings), where) for entry in error.errors(include_url=False)]
    return {name: _value(getattr(read, name), plan, name) for name in given}, []


@cache
def _model(plan: Any) -> Any:
    """Return the pydantic model of a dataclass of settings."""
    settings = plan_settings(plan)
    return create_model(
        plan.__name__,
        __config__=ConfigDict(extra="forbid", strict=True),
        **{name: (kind, default) for name, (kind, default) in settings.items()},  # type: ignore[call-overload]
    )


def _value(read: Any, plan: Any, name: str) -> Any:
    """Return a setting, tables of settings as their own dataclass."""
    inner = _inner(get_type_hints(plan)[name])
    if inner is None or read is None:
        return read
    return inner(**{one.name: getattr(read, one.name) for one in fields(inner)})


def _inner(hint: Any) -> Any:
    """Return the dataclass that a setting holds, or None."""
    return next((one for one in (hint, *get_args(hint)) if is_dataclass(one)), None)


def plan_settings(plan: Any) -> dict[str, tuple[Any, Any]]:
    """Return type and default of each setting of a plan that a campaign may give."""
    hints = get_type_hints(plan)
    return {
        one.name: (_annotation(hints[one.name], dict(one.metadata)), _default(one))
        for one in fields(plan)
        if "from" not in one.metadata
    }


def _annotation(hint: Any, metadata: dict[str, Any]) -> Any:
    if "unit" in metadata or "difference" in metadata:
        one = quantity(metadata.get("unit") or metadata["difference"], "difference" in metadata)
        if any(get_origin(part) is list for part in (hint, *get_args(hint))):
            return list[one] | None if type(None) in get_args(hint) else list[one]  # type: ignore[valid-type]
        return one | None if type(None) in get_args(hint) else one
    inner = _inner(hint)
    return hint if inner is None else _model(inner) | None


def _default(one: Any) -> Any:
    limit = {"gt": one.metadata["above"]} if "above" in one.metadata else {}
    if one.default is not MISSING:
        return Field(default=one.default, **limit)
    if one.default_factory is not MISSING:
        return Field(default_factory=one.default_factory, **limit)
    return Field(**limit)


def _problem(entry: Any, known: list[str], where: str) -> Problem:
    name = ".".join(str(part) for part in entry["loc"])
    if entry["type"] == "extra_forbidden":
        near = get_close_matches(name, known, n=1)
        do = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(known)}"
        return Problem(f"unknown key plan.{name}", where, "it would have no effect", do, "unknown_key")
    what = entry["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
    return Problem(f"plan.{name}: {what}", where, code="wrong_value")
