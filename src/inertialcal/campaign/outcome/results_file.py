"""A ``results.json`` sealed with its checksum, and read back: by its own name, its ``out/``, or its campaign."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from ...core.errors import DataError
from ...core.remarks import Remark
from ...core.results import SCHEMA
from ...core.schema.checksum import CHECKSUM, check_unchanged, checksum
from ...core.schema.content import check_content
from ...core.schema.results import Results
from ...files.binary.curves import FILE as CURVES
from ...files.binary.curves import read_curves
from ...files.source import load
from ...files.write.exchange import Manifest
from ...sensors.model.serial import FORMAT
from .publish import OUT, RESULTS, restore


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
    if of_campaign or given.name == OUT:
        restore(given.parent if given.name == OUT else given)
    places = [given / RESULTS, *([given / OUT / RESULTS] if of_campaign else [])] if given.is_dir() else [given]
    place = next((one for one in places if one.is_file()), None)
    if place is None:
        return None
    loaded = load(place)
    try:
        content = json.loads(loaded.data)
    except (ValueError, RecursionError):
        return None
    if not isinstance(content, dict) or content.get("format") == FORMAT or "results" not in content:
        return None
    check_results(content, str(place))
    if (data := own_curves(content, place)) is not None:
        content["curves"] = read_curves(data, str(place.with_name(CURVES)))
    return ResultsFile(str(place), loaded.sha256, content)


def previous(folder: Path) -> dict[str, Any] | None:
    """Return the results of the last run; None where there are none that this version reads, or they were edited."""
    try:
        content = json.loads(load(folder / OUT / RESULTS).data)
        check_results(content, "")
    except (ValueError, RecursionError, AttributeError, DataError):
        return None
    return cast("dict[str, Any]", content)


def edited_since(folder: Path) -> tuple[Remark, ...]:
    """Return a remark on each file of a run, in a folder or its ``out/``, that was edited since."""
    place = folder / OUT if (folder / OUT).is_dir() else folder
    manifest = Manifest.read(place)
    names = () if manifest is None else sorted(manifest.files)
    changed = (place / name for name in names if manifest and not manifest.lists(place / name))
    what, do = (
        "edited by hand since the run wrote it",
        "Type again: inertialcal run DIR; it keeps the edited file apart",
    )
    return tuple(Remark("edited_by_hand", "warning", what, str(path), do=do) for path in changed if path.is_file())


def sealed(results: Mapping[str, Any], curves: bytes) -> dict[str, Any]:
    """Return results with the SHA-256 of the file of their curves, and the checksum over all but the curves.

    Parameters
    ----------
    results : mapping
        As ``results_content`` gives them.
    curves : bytes
        Content of ``curves.parquet``.
    """
    named = {**results, "curves_sha256": hashlib.sha256(curves).hexdigest()}
    return named | {CHECKSUM: checksum({name: part for name, part in named.items() if name != "curves"})}


def check_results(content: Mapping[str, Any], path: str) -> None:
    """Refuse results of another schema, those that were edited, and what has not the form of results.

    Raises
    ------
    DataError
        ``schema_version``, ``checksum``, ``schema``.
    """
    if content.get("schema") != SCHEMA:
        raise DataError(
            f"results of schema {content.get('schema')!r}: this version reads schema {SCHEMA}",
            where=path,
            do="Type again: inertialcal run DIR",
            code="schema_version",
        )
    check_unchanged(content, path)
    check_content(Results, content, path, "Type again: inertialcal run DIR")


def own_curves(content: Mapping[str, Any], path: Path) -> bytes | None:
    """Return the bytes of the curves beside results; None where no file lies there.

    Raises
    ------
    DataError
        ``checksum``, if they are not those of the results.
    """
    place = path.with_name(CURVES)
    if not place.is_file():
        return None
    loaded = load(place)
    if loaded.sha256 != content.get("curves_sha256"):
        raise DataError(
            f"not the curves of {path.name}: its SHA-256 is another",
            where=str(place),
            why="edited by hand, or of another run: figures would be drawn of other data than the results",
            do="Type again: inertialcal run DIR",
            code=CHECKSUM,
        )
    return loaded.data


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
            do="Type again: inertialcal run DIR",
            code="schema",
        ) from None
