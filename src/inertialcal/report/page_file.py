"""``report.html`` sealed with the checksum of its content, and read back.

Two entries of its head are for programs: what the page shows, as JSON, and the SHA-256 of the whole page with that
entry empty.
"""

from __future__ import annotations

import html
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..core.errors import DataError
from ..core.remarks import Remark
from ..core.schema.checksum import CHECKSUM, EDITED, text_checksum
from ..files.source import load

SEAL = '<meta name="inertialcal-checksum" content="'
SEALED = re.compile(re.escape(SEAL) + '([^"]*)"')
ABOUT = re.compile('<meta name="inertialcal-report" content="([^"]*)"')
PAGE = re.compile(rb"\s*<(!doctype html|html)\b", re.IGNORECASE)
AGAIN = "Type again: inertialcal run DIR"
FILES = {"results": "results.json", "model": "model.json"}  # beside the page, by what it is called in the head


def about_text(results: Mapping[str, Any], model: Mapping[str, Any] | None) -> str:
    """Return what the head says of a page, as JSON: campaign, verdict, checksums of the results and of the model."""
    said = {
        "campaign": results["campaign"]["id"],
        "verdict": results.get("verdict"),
        "results": results.get(CHECKSUM),
        "model": None if model is None else model.get(CHECKSUM),
    }
    return json.dumps(said)


def sealed_page(page: str) -> str:
    """Return a page with the checksum of its content in the place that it has for it."""
    return page.replace(SEAL, SEAL + text_checksum(page), 1)


@dataclass(frozen=True)
class PageFile:
    """A report that is as it was written.

    Parameters
    ----------
    path, sha256 : str
        The file.
    campaign : str
        Of which it reports.
    verdict : str or None
        Over all requirements; None where none is stated.
    results, model : str or None
        Checksum of the ``results.json`` and ``model.json`` that it shows; None where no model is delivered.
    remarks : tuple of Remark
        Files beside it that are not those that it shows.
    """

    path: str
    sha256: str
    campaign: str
    verdict: str | None
    results: str | None
    model: str | None
    remarks: tuple[Remark, ...] = ()

    def to_dict(self) -> dict[str, str | None]:
        """Return what it says, for ``--json``."""
        return {name: getattr(self, name) for name in ("campaign", "verdict", "results", "model")}


def find_page(path: str | os.PathLike[str]) -> PageFile | None:
    """Return the report in a file; None where the file is no page.

    Raises
    ------
    DataError
        ``checksum``, if the page was edited, or is not a report of ours; and as ``files.source.load``.
    """
    place = Path(path)
    if not place.is_file() or not _is_page(place):
        return None
    loaded = load(place)
    page = loaded.data.decode("utf-8", "surrogateescape")
    seal, about = SEALED.search(page), ABOUT.search(page)
    if seal is None or about is None:
        raise DataError("no report of inertialcal: its checksum is missing", str(place), EDITED, AGAIN, CHECKSUM)
    emptied = page[: seal.start(1)] + page[seal.end(1) :]
    if seal[1] != text_checksum(emptied):
        raise DataError("the checksum does not match the content", str(place), EDITED, AGAIN, CHECKSUM)
    try:
        said: dict[str, Any] = {name: one and str(one) for name, one in json.loads(html.unescape(about[1])).items()}
        found = PageFile(str(place), loaded.sha256, **said)
    except (ValueError, RecursionError, TypeError, AttributeError):
        raise DataError("not the head of a report", str(place), do=AGAIN, code="schema") from None
    remarks = tuple(
        Remark("other_run", "warning", f"{file} next to it belongs to another run", str(place), do=AGAIN)
        for name, file in FILES.items()
        if (there := _checksum_of(place.with_name(file))) is not None and there != said[name]
    )
    return replace(found, remarks=remarks)


def _is_page(path: Path) -> bool:
    with path.open("rb") as stream:
        return PAGE.match(stream.read(64)) is not None


def _checksum_of(path: Path) -> str | None:
    try:
        found = json.loads(load(path).data)[CHECKSUM]
    except (DataError, ValueError, RecursionError, KeyError, TypeError):
        return None
    return str(found)
