"""What is wrong with a TOML document, by its pydantic model: each problem with the place of its key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError

from ..errors import Problem
from .quantities import NAME
from .toml import At
from .toml import Path as KeyPath

IN_WORDS = {NAME: "may hold letters (a to z), digits, '_', '.' and '-' alone, and begins with a letter or a digit"}
CONTAINERS = {"dict_type", "model_type", "list_type"}  # kinds of errors: it is no table, no list


def model_problems(
    error: ValidationError, model: type[BaseModel], document: object, at: At, above: KeyPath = ()
) -> Iterator[Problem]:
    """Yield what a model refuses, each key once: of a value of several kinds, all that it may be.

    Parameters
    ----------
    error : ValidationError
        Of the model.
    model : type
        That of the document.
    document : object
        What was given to the model.
    at : callable
        Place of a key path, for messages.
    above : tuple
        Path of the table that the model is of.
    """
    by_key: dict[KeyPath, list[tuple[str, str, str]]] = {}
    plain: set[KeyPath] = set()  # keys that are refused whatever kind their value is of
    for entry in error.errors(include_url=False, include_input=False):
        what = entry["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
        what = IN_WORDS.get(entry.get("ctx", {}).get("pattern", ""), what)
        loc = tuple(one for one in entry["loc"] if one != "[key]")
        path = key_path(loc[:-1], document) + loc[-1:] if entry["type"] == "missing" else key_path(loc, document)
        by_key.setdefault(path, []).append((entry["type"], what, str(entry.get("ctx", {}).get("expected", ""))))
        plain |= {path} if path == loc else set()
    for path, found in by_key.items():
        key, where = ".".join(str(part) for part in (*above, *path)), at(*above, *path)
        if found[0][0] == "extra_forbidden":
            yield _unknown_key(model, path, key, where)
        elif found[0][0] == "missing":
            yield Problem(f"{key} is missing", where, code="missing_key")
        elif path in plain or not any(len(one) > len(path) and one[: len(path)] == path for one in by_key):
            what = _either(found)
            yield Problem(f"{key}: {what}" if key else what, where, code="wrong_value")


def key_path(loc: KeyPath, document: object) -> KeyPath:
    """Return the keys of a place that pydantic names, without its names for the kinds that a value may be of."""
    found: list[str | int] = []
    for part in loc:
        if isinstance(document, Mapping) and part in document:
            document = document[part]
        elif isinstance(document, Sequence) and not isinstance(document, str) and isinstance(part, int):
            document = document[part] if part < len(document) else None
        else:
            continue
        found.append(part)
    return tuple(found)


def _either(found: Sequence[tuple[str, str, str]]) -> str:
    """Return what is wrong with a value that may be of several kinds: what was meant, then the words that it may be."""
    meant = sorted((one for one in found if one[0] not in CONTAINERS), key=lambda one: bool(one[2])) or found
    return "; or ".join(dict.fromkeys([meant[0][1], *(words or message for _, message, words in meant[1:])]))


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
