"""A ``results.json`` read back: by its own name, by the ``out/`` that it lies in, or by the folder of its campaign."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.errors import DataError
from ...core.results import SCHEMA
from ...files.binary.curves import FILE as CURVES
from ...files.binary.curves import read_curves
from ...files.source import load
from ...sensors.model.serial import FORMAT
from ..models.find import RESULTS
from .publish import OUT


@dataclass(frozen=True, eq=False)
class ResultsFile:
    """What was read.

    Parameters
    ----------
    path, sha256 : str
        The file.
    content : dict
        Of ``results.json``, and the ``curves`` of the file beside it.
    """

    path: str
    sha256: str
    content: dict[str, Any]


def find_results(path: str | os.PathLike[str], of_campaign: bool = False) -> ResultsFile | None:
    """Return the results at a place; None where something else lies there, or nothing.

    Parameters
    ----------
    path : path
        ``results.json``, or the ``out/`` of a campaign.
    of_campaign : bool
        Take the folder of a campaign for its results too; else it stands for its model.

    Raises
    ------
    DataError
        If the file cannot be read.
    """
    given = Path(path)
    places = [given / RESULTS, *([given / OUT / RESULTS] if of_campaign else [])] if given.is_dir() else [given]
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        return None
    loaded = load(found)
    try:
        content = json.loads(loaded.data)
    except (ValueError, RecursionError):
        return None
    if not isinstance(content, dict) or content.get("format") == FORMAT or "results" not in content:
        return None
    check_schema(content, str(found))
    if (curves := found.with_name(CURVES)).is_file():
        content["curves"] = read_curves(load(curves).data, str(curves))
    return ResultsFile(str(found), loaded.sha256, content)


def check_schema(content: Mapping[str, Any], path: str) -> None:
    """Refuse results of another schema.

    Raises
    ------
    DataError
        ``schema_version``.
    """
    if content.get("schema") != SCHEMA:
        raise DataError(
            f"results of schema {content.get('schema')!r}: this version reads schema {SCHEMA}",
            where=path,
            do="Type again: inertialcal run DIR",
            code="schema_version",
        )


@contextmanager
def as_results(path: str) -> Iterator[None]:
    """Refuse a file whose content turns out to be no results while it is used.

    Raises
    ------
    DataError
        ``schema``, with what was missing or of another type.
    """
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise DataError(
            f"not the content of a {RESULTS}: {type(error).__name__} {error}",
            where=path,
            do="Type: inertialcal run DIR",
            code="schema",
        ) from None
