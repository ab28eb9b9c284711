"""What is wrong with a TOML document, by its pydantic model: each problem with the place of its key."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError

from ..errors import Problem
from .toml import At
from .toml import Path as KeyPath


def model_problems(error: ValidationError, model: type[BaseModel], at: At, above: KeyPath = ()) -> Iterator[Problem]:
    """Yield what a model refuses.

    Parameters
    ----------
    error : ValidationError
        Of the model.
    model : type
        That of the document.
    at : callable
        Place of a key path, for messages.
    above : tuple
        Path of the table that the model is of.
    """
    for entry in error.errors(include_url=False, include_context=False, include_input=False):
        path = tuple(part for part in entry["loc"] if part != "[key]")
        key, where = ".".join(str(part) for part in (*above, *path)), at(*above, *path)
        if entry["type"] == "extra_forbidden":
            yield _unknown_key(model, path, key, where)
        elif entry["type"] == "missing":
            yield Problem(f"{key} is missing", where, code="missing_key")
        else:
            what = entry["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
            yield Problem(f"{key}: {what}" if key else what, where, code="wrong_value")


def _unknown_key(whole: type[BaseModel], path: KeyPath, key: str, where: str) -> Problem:
    # Names that may stand in the table at a path of the schema
    model: Any = whole
    for part in path[:-1]:
        if isinstance(model, type) and issubclass(model, BaseModel):
            fields = {field.alias or name: field.annotation for name, field in model.model_fields.items()}
            model = fields.get(str(part))
        else:
            model = _element(model)
        while (
            not _is_model(model)
            and _element(model) is not None
            and getattr(model, "__origin__", None) not in (list, dict)
        ):
            model = _element(model)
    model = model if _is_model(model) else None
    known = [field.alias or name for name, field in model.model_fields.items()] if model else []
    near = get_close_matches(str(path[-1]), known, n=1)
    do = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(known)}" if known else ""
    return Problem(f"unknown key {key}", where, "it would have no effect", do, "unknown_key")


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _element(annotation: Any) -> Any:
    arguments = [one for one in getattr(annotation, "__args__", ()) if one is not type(None)]
    return arguments[-1] if arguments else None
