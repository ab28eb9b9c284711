"""Influence: a standard's uncertainty (Type B), as its certificate states it.

The name says which quantity of which standard: ``"rate_table.rate"`` (relative), ``"rate_table.mounting"``
(angle). An influence is one unknown value for a whole test: it is fully correlated across dwells, so more
dwells do not shrink it.

References
----------
.. [1] JCGM 100:2008 (GUM), clause 4.3, and G.4.2 for the degrees of freedom of a Type B uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import Literal

from .key import Origin
from .remarks import Remark

Redrawn = Literal["", "never", "certificate", "day", "mounting", "power_up", "dwell"]


@dataclass(frozen=True)
class Influence:
    """Standard uncertainty of one quantity of a standard."""

    u: float  # Standard uncertainty, SI (relative quantities: 1)
    unit: str = "1"  # Unit of ``u``
    dof: float = math.inf  # Degrees of freedom; infinite where the certificate gives none
    distribution: str = "normal"  # Of the unknown value
    certificate: str = ""  # Where ``u`` comes from
    # ``u`` in the unit in which the certificate gives it; by default in ``unit``
    as_stated: tuple[float, str] | None = None
    standard: str = ""  # Which standard: the same quantity of it in two tests is the same unknown
    quantity: str = ""  # Which quantity of the standard
    redrawn_by: Redrawn = ""  # What draws its error anew; empty where nobody said
    valid: str = ""  # Period of the certificate
    reason: str = ""  # Why ``u`` is zero, where it is

    @property
    def stated(self) -> tuple[float, str]:
        """Standard uncertainty and its unit, as the certificate gives them."""
        return self.as_stated or (self.u, self.unit)

    def origin(self, what: str) -> Origin:
        """Return it as where an uncertainty comes from, with what budgets call it."""
        return Origin(what, standard=self.standard, quantity=self.quantity)


Standards = Mapping[str, Influence]


def zero_remarks(standards: Standards, effects: Container[str]) -> tuple[Remark, ...]:
    """Return a remark for each standard that was stated without uncertainty, with the reason that was given.

    Parameters
    ----------
    standards : mapping of Influence
        By name.
    effects : container of str
        Names of those that a test draws on.
    """
    return tuple(
        Remark("zero_uncertainty", "info", f"standards.{name}: taken as exact ({one.reason})", subject=name)
        for name, one in standards.items()
        if name in effects and one.u == 0.0
    )


def standard_of(name: str) -> tuple[str, str]:
    """Return standard and quantity of the name of an influence: ``"rate_table.rate"``."""
    standard, _, quantity = name.partition(".")
    return standard, quantity


def influence_of(unknown: str) -> str:
    """Return the influence that an unknown is of: ``"rate_table.mounting"`` of ``"rate_table.mounting[xz]"``."""
    return unknown.partition("[")[0]
