"""Influence: a standard's uncertainty (Type B), as its certificate states it; and what two tests share.

The name says which quantity of which standard: ``"rate_table.rate"`` (relative), ``"rate_table.mounting"``
(angle). An influence is one unknown value for a whole test: it is fully correlated across dwells, so more
dwells do not shrink it. Two tests share it where nothing has drawn it anew between them (``Drawn``): the same
certificate and period; or, for what a mounting, a power-up or a day draws, the same ``Occasion``.

References
----------
.. [1] JCGM 100:2008 (GUM), clause 4.3, and G.4.2 for the degrees of freedom of a Type B uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from .key import Origin
from .remarks import Remark
from .units import factor, same_dimension, si_unit

Redrawn = Literal["", "never", "certificate", "day", "mounting", "power_up", "dwell"]
OF_SITE = ("site", "gravity")  # standards whose error is that of a place
OF_UNIT: tuple[Redrawn, ...] = ("mounting", "power_up")  # drawn anew for each unit
DIES: tuple[Redrawn, ...] = ("", "dwell")  # with the dwell: no other test can share its error
SAME = 1e-9  # of an uncertainty: told apart from another beyond
ROUNDING = 1e-9  # of an uncertainty: a change that is smaller is none


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


class Occasion(NamedTuple):
    """What drew the errors of a test, in the words of the campaign; empty where that is not known.

    A test that states the same mounting, power-up or day as another one shares the errors that each of them drew.
    """

    mounting: str = ""  # Which laying of the unit on the table, in the fixture
    power_up: str = ""
    day: str = ""
    site: str = ""  # Where: latitude, height and gravity as stated

    def drew(self, redrawn_by: Redrawn, standard: str = "") -> str:
        """Return the label of what drew an error that is redrawn so; empty where that is not known or not needed."""
        if redrawn_by == "never":
            return self.site if standard in OF_SITE else ""
        return {"mounting": self.mounting, "power_up": self.power_up, "day": self.day}.get(redrawn_by, "")

    def remounted(self, other: Occasion) -> bool:
        """Whether the unit was laid anew in between, as both state."""
        return bool(self.mounting and other.mounting) and self.mounting != other.mounting

    def joined(self, other: Occasion) -> Occasion:
        """Return the occasion of two tests together: what both state alike."""
        return Occasion(*(mine if mine == its else "" for mine, its in zip(self, other, strict=True)))


class Selection(NamedTuple):
    """What a test takes of recordings: of two that are equal, the readings are the same."""

    sha256: tuple[str, ...] = ()  # Of the files, in order
    groups: tuple[str, ...] = ()  # Rows of tables that were chosen; empty for all
    windows: tuple[tuple[int, int], ...] = ()  # Instants between which readings were chosen [ns]; empty for all

    def overlap(self, other: Selection) -> set[str]:
        """Return the SHA-256 of files of which both may take the same readings."""
        if self.groups and other.groups and not set(self.groups) & set(other.groups):
            return set()
        pairs = [(one, two) for one in self.windows for two in other.windows]
        if pairs and not any(one[0] < two[1] and two[0] < one[1] for one, two in pairs):
            return set()
        return set(self.sha256) & set(other.sha256)


@dataclass(frozen=True)
class Drawn:
    """An influence with what drew its error: of two that are the same, the errors are the same."""

    influence: Influence
    label: str = ""  # Of the mounting, power-up, day or site that drew it; empty where not known
    serial: str = ""  # Of the unit; empty where not known

    def differs(self, other: Drawn) -> str:
        """Say why the two errors are not the same; empty where nothing tells them apart."""
        mine, its = self.influence, other.influence
        if (mine.standard, mine.quantity) != (its.standard, its.quantity):
            return "two standards"
        if mine.redrawn_by in DIES:
            return "drawn anew in each dwell"
        alike = same_dimension(mine.unit, its.unit)
        if not (alike and math.isclose(mine.u, its.u * factor(its.unit, mine.unit, difference=True), rel_tol=SAME)):
            return f"u = {_text(mine)} in the first, {_text(its)} in the second"
        by = "site" if mine.redrawn_by == "never" else mine.redrawn_by.replace("_", "-")
        stated = (
            ("certificate", mine.certificate, its.certificate), ("valid", mine.valid, its.valid),
            ("redrawn_by", mine.redrawn_by, its.redrawn_by), (by, self.label, other.label),
        )  # fmt: skip
        for name, one, two in stated:
            if one and two and one != two:
                return f"{name} {one!r} in the first, {two!r} in the second"
        units = mine.redrawn_by in OF_UNIT and self.serial and other.serial and self.serial != other.serial
        return f"two units, each with its own {by}" if units else ""

    def unknown(self, other: Drawn) -> str:
        """Say what would have to be stated for the two errors to be known as the same; empty where they are."""
        mine, its = self.influence, other.influence
        by = mine.redrawn_by
        if by == "certificate":
            if not (mine.certificate and its.certificate):
                return "certificate"
            return "" if mine.valid == its.valid else "valid"
        if by == "never":
            return "" if mine.standard not in OF_SITE or (self.label and other.label) else "site"
        return "" if self.label and other.label else by

    @property
    def identity(self) -> tuple[str, ...] | None:
        """What is equal for two errors that are known as the same; None where that is not known of it.

        Stricter than `differs` with `unknown`, which take two at a time: a certificate that one alone states is another
        one here.
        """
        mine = self.influence
        if mine.redrawn_by in DIES or self.unknown(self):
            return None
        u = mine.u * factor(mine.unit, si_unit(mine.unit), difference=True)
        serial = self.serial if mine.redrawn_by in OF_UNIT else ""
        return (
            mine.standard, mine.quantity, f"{u:.8e}", mine.redrawn_by, mine.certificate, mine.valid, self.label, serial
        )  # fmt: skip


def _text(influence: Influence) -> str:
    return f"{influence.u:g} {'' if influence.unit == '1' else influence.unit}".rstrip()


def influence_fields(one: Influence) -> dict[str, Any]:
    """Return an influence as files hold it."""
    u, unit = one.stated
    return {
        "standard": one.standard, "quantity": one.quantity, "u": u, "unit": unit, "certificate": one.certificate,
        "valid": one.valid, "redrawn_by": one.redrawn_by,
    } | ({"reason": one.reason} if one.reason else {})  # fmt: skip


def influence_read(content: Mapping[str, Any]) -> Influence:
    """Return an influence of a file, its uncertainty in the unit that was stated."""
    names = ("certificate", "standard", "quantity", "redrawn_by", "valid")
    return Influence(float(content["u"]), str(content["unit"]), **{name: content[name] for name in names})


def lasting(changes: Mapping[str, float], u: float | None, standards: Standards) -> dict[str, float]:
    """Return the changes of a figure by influences whose error another test can share, without those by rounding.

    Parameters
    ----------
    changes : mapping of str to float
        By one standard uncertainty of each unknown.
    u : float or None
        Of the figure.
    standards : mapping of Influence
        That are stated, by name.
    """
    if not changes:
        return {}
    names = {name for name, one in standards.items() if one.redrawn_by not in DIES}
    least = ROUNDING * (u or 0.0)
    return {name: one for name, one in changes.items() if influence_of(name) in names and abs(one) > least}


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


def unknown_of(influence: str, unknown: str) -> str:
    """Return which unknown of an influence it is: ``"xz"`` of ``"rate_table.mounting[xz]"``; empty for the only one."""
    return unknown.removeprefix(influence).removeprefix("[").removesuffix("]")
