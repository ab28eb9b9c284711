"""Checksum over what a file says: ``model.json``, ``results.json`` and ``report.html`` carry one of their content.

That of JSON is the SHA-256 of the content in canonical form (keys sorted, no blanks, UTF-8), without the checksum
itself: a file that was laid out anew still reads, one in which a number was changed by hand does not.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import DataError
from .json_text import json_texts_many

CHECKSUM = "checksum"
EDITED = "edited by hand after it was written: its figures cannot be traced"


def checksum(content: Mapping[str, object]) -> str:
    """SHA-256 over the canonical form of a content, as ``sha256:...``."""
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text_checksum(canonical)


def sealed_text(content: Mapping[str, object]) -> str:
    """Return a content that is not empty as `json_text`, its checksum the last key."""
    return sealed_texts([content])[0]


def sealed_texts(contents: Sequence[Mapping[str, object]]) -> list[str]:
    """Return the same of many contents."""

    def last(canonical: str) -> str:
        return f',\n "{CHECKSUM}": "{text_checksum(canonical)}"'

    return [text + "\n" for text, _ in json_texts_many(contents, last)]


def text_checksum(text: str) -> str:
    """SHA-256 of a text in UTF-8, as ``sha256:...``."""
    return "sha256:" + hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def is_unchanged(content: Mapping[str, Any]) -> bool:
    """Tell whether a content fits the checksum that it carries."""
    try:
        return content.get(CHECKSUM) == checksum({name: part for name, part in content.items() if name != CHECKSUM})
    except (ValueError, RecursionError):  # a number beyond float64, lists within lists without end
        return False


def check_unchanged(content: Mapping[str, Any], where: str = "", do: str = "Type again: inertialcal run DIR") -> None:
    """Refuse a content that no longer says what was written.

    Raises
    ------
    DataError
        ``checksum``.
    """
    if not is_unchanged(content):
        what = "the checksum does not match the content" if CHECKSUM in content else "the checksum is missing"
        raise DataError(what, where=where, why=EDITED, do=do, code=CHECKSUM)
