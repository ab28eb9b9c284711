"""Tests that turn readings into results: the one registry, name -> object, loaded when asked for.

A procedure of ours is a folder with ``procedure.py`` and a line here; one of others is an entry point of the group
``inertialcal.procedures`` whose object is a ``Procedure``. A name of ours cannot be taken.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from ..core.errors import PlanError
from .protocol import Procedure

GROUP = "inertialcal.procedures"
OURS = ("rate_table", "flip", "thermal", "static_noise", "sine", "mass_attraction", "positions")


@cache
def procedure_names() -> tuple[str, ...]:
    """Return the names of all procedures, ours first."""
    others = sorted({one.name for one in entry_points(group=GROUP)} - set(OURS))
    return (*OURS, *others)


@cache
def procedure_of(name: str) -> Procedure[Any, Any, Any]:
    """Return a procedure by its name.

    Raises
    ------
    PlanError
        ``unknown_name`` if there is none; ``broken_plugin`` if one of others cannot be loaded.
    """
    if name in OURS:
        found: Procedure[Any, Any, Any] = import_module(f".{name}.procedure", __name__).PROCEDURE
        return found
    entry = next((one for one in entry_points(group=GROUP) if one.name == name), None)
    if entry is None:
        raise PlanError(f"no procedure {name!r}", do=f"There are: {', '.join(procedure_names())}", code="unknown_name")
    try:
        given = entry.load()
    except Exception as error:
        package = entry.dist.name if entry.dist is not None else entry.value
        what = f"procedure {name!r} of {package} cannot be loaded: {error}"
        raise PlanError(what, do=f"Mend or uninstall {package}", code="broken_plugin") from None
    if not isinstance(given, Procedure) or given.name != name:
        raise PlanError(f"procedure {name!r}: {entry.value} is no Procedure of that name", code="broken_plugin")
    return given
