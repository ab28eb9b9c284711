"""Tests that turn readings into results: name -> `Procedure`, loaded when it is asked for.

A built-in procedure is a folder with ``procedure.py``, which holds one ``PROCEDURE``, and a name in `BUILT_IN`.
Installed packages add theirs by the entry point ``inertialcal.procedures``.
"""

from __future__ import annotations

from typing import Any

from ..core.errors import UsageError
from ..core.registry import Registry
from .protocol import Procedure

BUILT_IN = ("rate_table", "flip", "thermal", "static_noise", "sine", "mass_attraction", "positions")

PROCEDURES: Registry[Procedure[Any, Any, Any]] = Registry(
    "procedure",
    Procedure,
    "inertialcal.procedures",
    {name: f"{__name__}.{name}.procedure:PROCEDURE" for name in BUILT_IN},
)


def procedure_names() -> tuple[str, ...]:
    """Return the names of all procedures, the built-in ones first."""
    return tuple(PROCEDURES)


def procedure_of(name: str) -> Procedure[Any, Any, Any]:
    """Return a procedure by its name.

    Raises
    ------
    UsageError
        ``unknown_name`` if there is none; ``broken_plugin`` if the package that adds it cannot be loaded.
    """
    return PROCEDURES.named(name)


def procedure_of_result(result: object) -> Procedure[Any, Any, Any] | None:
    """Return the procedure whose package the type of a result stands in; None for anything else."""
    where = type(result).__module__
    for name in PROCEDURES:
        try:
            procedure = PROCEDURES[name]
        except UsageError:  # a package that cannot be loaded has given no result
            continue
        package = type(procedure).__module__.rpartition(".")[0]
        if package and where.startswith(f"{package}."):
            return procedure
    return None
