"""Curves of a thermal result, SI: what its figures show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.curve import Curve

if TYPE_CHECKING:
    from . import Result


def curves(result: Result) -> list[Curve]:
    """Return the curves of all sensors, SI."""
    return []
