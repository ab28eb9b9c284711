"""Tests that turn readings into results: name -> `Procedure`, loaded when it is asked for.

A built-in procedure is a folder with ``procedure.py``, which holds one ``PROCEDURE``, and a name in `BUILT_IN`.
Installed packages add theirs by the entry point ``inertialcal.procedures``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from ..core.errors import UsageError
from ..core.registry import Registry
from ..core.results import WrittenRow
from ..core.show.rows import Compared
from .protocol import Procedure, Quantity

BUILT_IN = ("rate_table", "flip", "thermal", "static_noise", "sine", "mass_attraction", "positions", "sensitivity",
            "vibration", "sine_survey", "vibration_effects", "turned_mass", "magnetometer_bias",
            "microgravity", "shifted_model", "heads", "alignment")  # fmt: skip

PROCEDURES: Registry[Procedure[Any, Any, Any]] = Registry(
    "procedure",
    Procedure,
    "inertialcal.procedures",
    {name: f"{__name__}.{name}.procedure:PROCEDURE" for name in BUILT_IN},
)


def procedure_names() -> tuple[str, ...]:
    """Return the names of all procedures, the built-in ones first."""
    return PROCEDURES.names


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
    for procedure in loaded_procedures():
        package = type(procedure).__module__.rpartition(".")[0]
        if package and where.startswith(f"{package}."):
            return procedure
    return None


def loaded_procedures() -> tuple[Procedure[Any, Any, Any], ...]:
    """Return all procedures that can be loaded: one of others that is broken says so when it is asked for."""
    found = []
    for name in PROCEDURES:
        try:
            found.append(PROCEDURES[name])
        except UsageError:
            continue
    return tuple(found)


def compared_in(rows: Iterable[WrittenRow]) -> Compared | None:
    """Return what the rows of a test compare with another test; None where they compare nothing."""
    quantities = {row["quantity"] for row in rows}
    declared = (procedure.compared for procedure in loaded_procedures())
    return next((one for one in declared if one is not None and one.change in quantities), None)


def all_quantities() -> Mapping[str, Quantity]:
    """Return what there is to say of a figure, whichever procedure gives it, or every recording: the first says it."""
    return _quantities(PROCEDURES.names)


@lru_cache(4)
def _quantities(names: tuple[str, ...]) -> Mapping[str, Quantity]:
    from .recorded import QUANTITIES  # noqa: PLC0415 - numpy starts slowly

    found: dict[str, Quantity] = {}
    for one in loaded_procedures():
        for name, quantity in one.quantities().items():
            known = found.get(name)
            found[name] = quantity if known is None else known.joined(quantity)
    found.update((name, one) for name, one in QUANTITIES.items() if name not in found)
    return MappingProxyType(found)
