"""Nouns as functions of Python: ``inertialcal.thermal`` and the like, made of the settings when first used.

Their signatures for type checkers stand in ``nouns.pyi``, which ``docs/made.py`` writes.
"""

from __future__ import annotations

from typing import Any

from ...procedures import procedure_names, procedure_of
from .call import Reduced, function_of

__all__ = ["Reduced"]


def __getattr__(name: str) -> Any:
    """Return the function of a noun."""
    for one in procedure_names():
        for declared in procedure_of(one).commands:
            if name == declared.function:
                return function_of(one, declared.word)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
