"""Standards of a rig: their tables in campaign.toml, and their errors, drawn as their certificates say."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ...core.influence import Influence
from ...core.schema.standards import STANDARDS

PLACES = {f"{standard}.{name}": (standard, name) for standard, names in STANDARDS.items() for name in names}


def drawn_error(influence: Influence | None, rng: np.random.Generator) -> float:
    """Return the unknown error of a standard, drawn as its certificate says [its unit]; 0 where there is none."""
    if influence is None:
        return 0.0
    if influence.distribution == "rectangular":
        half = influence.u * np.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, influence.u))


def standard_tables(standards: Mapping[str, Influence], entry: Callable[[Influence], str]) -> str:
    """Return the tables of the standards in campaign.toml.

    Parameters
    ----------
    standards : mapping of str to Influence
        By ``"rate_table.mounting"``, in order.
    entry : callable
        Influence -> its entry, as TOML.
    """
    tables: dict[str, list[str]] = {}
    for name, influence in standards.items():
        standard, quantity = PLACES[name]
        tables.setdefault(standard, []).append(f"{quantity} = {entry(influence)}")
    return "\n\n".join("\n".join([f"[standards.{name}]", *lines]) for name, lines in tables.items()) + "\n"
