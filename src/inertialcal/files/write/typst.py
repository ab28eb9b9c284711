"""PDF by typst: a template and its data, which no text can break out of; PDF/A-3b, the same bytes twice.

Data goes in as JSON beside the template, which shows it as text: nothing in it is read as markup.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, date, datetime
from importlib import import_module
from typing import Any

from ...core.errors import StoreError, UsageError

MAIN, DATA = "main.typ", "data.json"
STANDARD = "a-3b"


def typst_pdf(template: str, data: Mapping[str, Any], made: date, files: Mapping[str, bytes] | None = None) -> bytes:
    """Return a template filled with data, as PDF/A-3b.

    Parameters
    ----------
    template : str
        Of typst; it takes its data by ``json("data.json")``.
    data : mapping
        What the template shows: text, numbers, lists.
    made : date
        Day that the PDF gives as its own.
    files : mapping of str to bytes, optional
        Other files that the template names: pictures, and those to attach.

    Raises
    ------
    UsageError
        ``missing_extra`` where typst is not installed.
    StoreError
        ``not_typeset`` with what typst says.
    """
    try:
        typst: Any = import_module("typst")  # an extra; its types lack a mapping of files
    except ImportError:
        do = "Type: pip install 'inertialcal[pdf]'"
        raise UsageError("PDF needs typst, which is not installed", do=do, code="missing_extra") from None
    given = {name: bytes(content) for name, content in (files or {}).items()}
    given |= {MAIN: template.encode(), DATA: json.dumps(data, ensure_ascii=False, allow_nan=False).encode()}
    stamp = datetime(made.year, made.month, made.day, tzinfo=UTC)
    try:
        found = typst.compile(given, format="pdf", pdf_standards=[STANDARD], timestamp=stamp)
    except (typst.TypstError, RuntimeError, ValueError) as error:
        said = " ".join(filter(None, (str(error), *getattr(error, "hints", ()))))
        raise StoreError(f"typst made no PDF: {said}", code="not_typeset") from None
    return bytes(found)
