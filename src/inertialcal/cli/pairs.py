"""Options of the form NAME=SOMETHING, as ``--unit gyro=deg/s`` and ``--column x=wx``."""

from __future__ import annotations

from collections.abc import Sequence

from ..core.errors import UsageError


def pairs(given: Sequence[str], option: str, example: str) -> dict[str, str]:
    """Return the pairs of an option that may be repeated.

    Raises
    ------
    UsageError
        If one is not of that form, or a name stands twice.
    """
    found: dict[str, str] = {}
    for text in given:
        name, equals, what = (part.strip() for part in text.partition("="))
        if not equals or not name or not what:
            raise UsageError(f"{option} {text!r}: need NAME=SOMETHING", do=f"Write it like {option} {example}")
        if name in found:
            raise UsageError(f"{option}: {name!r} stands twice", do="Give it once")
        found[name] = what
    return found
