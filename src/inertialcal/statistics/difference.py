"""Difference of two figures: what both share, such as the error of one certified standard, cancels.

A figure with standard uncertainty u that changes by c_i for one standard uncertainty of the unknown i has a variance of
its own of u^2 - sum c_i^2. Of the difference of two figures that share these unknowns [1]_::

    u(b - a)^2 = [u(a)^2 - sum a_i^2] + [u(b)^2 - sum b_i^2] + sum (b_i - a_i)^2

A curvature of the unit that a line lacks (``core.results.Curvature``) changes its figures by so much for one unit of it
as the rates of the test tell. Of one unit tested at one set of rates the changes are equal, and cancel, whatever size
each test took it to have. What differs between the designs counts with the larger size.

Assumed: an unknown of one name has one value in both figures, and nothing else is common to them. Its own uncertainty
is then that of the difference: scatter and unknowns that are not shared, with the degrees of freedom that they have
(few, once a large shared part is gone).

Real data break this where (1) a standard is believed the same and was repaired, or the unit laid anew, in between: the
difference misses that change, so only what is stated as the same may be cancelled; (2) both figures rest on the same
readings: their scatter is the same too, and is not independent; (3) the response to the unknown is not linear over its
uncertainty: what is left of a cancelled part is then of second order and not counted. (1) and (2) are simulated by
``tests/independent/coverage.py`` (differences), (3) by the second order of the mounting on a rate table, which is an
unknown of its own.

References
----------
.. [1] JCGM 100:2008, clauses 5.2.2, F.1.2.3 and G.4.
.. [2] Welch, Biometrika 34 (1947) 28-35.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..core.estimate import Array, joined_dof
from ..core.influence import influence_of
from ..core.results import Curvature

ENOUGH = 3.0 * (1.0 - 1e-9)  # degrees of freedom of the scatter of a figure, for Welch's test; rounding apart
ROUNDING = 1e-12  # of a variance: what is left of it after a subtraction is none


class Part(NamedTuple):
    """One source of the uncertainty of a figure, with few degrees of freedom."""

    influence: str  # Name of the standard; empty for scatter
    share: float  # Of the uncertainty of the figure: u_i / u
    dof: float


@dataclass(frozen=True)
class Figure:
    """A value with its standard uncertainty and degrees of freedom, and its signed changes by shared unknowns."""

    value: float
    u: float
    dof: float = math.inf
    changes: Mapping[str, float] = field(default_factory=dict)
    parts: tuple[Part, ...] = ()  # Sources that are not known in size, where these are known one by one
    curvature: Mapping[str, Curvature] = field(default_factory=dict)  # Terms of the unit that its line lacks, by name

    def change(self, name: str) -> float:
        """Return the change by one standard uncertainty of an unknown; 0 where it does not follow it."""
        return self.curvature[name].share if name in self.curvature else self.changes.get(name, 0.0)

    def own(self, names: Iterable[str]) -> float:
        """Return the variance without some of its unknowns."""
        left = self.u**2 - math.fsum(self.change(name) ** 2 for name in names)
        return left if left > ROUNDING * self.u**2 else 0.0

    def scatter(self, names: Collection[str]) -> list[tuple[float, float]]:
        """Return variance and degrees of freedom of what is not known in size once some unknowns are gone.

        Where the sources are not known one by one, all that is left counts as scatter: Welch-Satterthwaite backwards.
        """
        if self.parts:
            gone = {influence_of(name) for name in names}
            return [((one.share * self.u) ** 2, one.dof) for one in self.parts if one.influence not in gone]
        left = self.own(names)
        return [(left, self.dof * left**2 / self.u**4)] if left and math.isfinite(self.dof) else []


SAME = Figure(0.0, 0.0)  # difference of a figure and itself


def difference(a: Figure, b: Figure, shared: Iterable[str] | None = None) -> Figure:
    """Return b less a; the unknowns that both have are the same.

    Parameters
    ----------
    a, b : Figure
        In one unit.
    shared : iterable of str, optional
        Unknowns that are the same in both; all that have the same name by default.

    Returns
    -------
    Figure
        Its degrees of freedom are those of the parts that do not cancel: of the scatter of both by Welch [2]_, joined
        with parts of known size by ``core.estimate.joined_dof``. Shared unknowns are taken as known in size. Its
        changes are those by unknowns that are shared.

    Examples
    --------
    >>> before, after = (Figure(x, 0.05, changes={"table": 0.04}) for x in (1.0, 1.2))
    >>> round(difference(before, after).u, 4), round(difference(before, after, ()).u, 4)
    (0.0424, 0.0707)
    """
    both = (set(a.changes) & set(b.changes)) | (set(a.curvature) & set(b.curvature))
    names = sorted(both if shared is None else set(shared))
    left = {name: _left(a, b, name) for name in names}
    variance = a.own(names) + b.own(names) + math.fsum(change**2 for change in left.values())
    return Figure(
        b.value - a.value,
        math.sqrt(variance),
        degrees_of_freedom(variance, [*a.scatter(names), *b.scatter(names)]),
        left,
    )


def _left(a: Figure, b: Figure, name: str) -> float:
    one, other = a.curvature.get(name), b.curvature.get(name)
    if one is None or other is None:
        return b.change(name) - a.change(name)
    return (other.change - one.change) * max(one.size, other.size)


def taken_off(figure: Figure, errors: Mapping[str, float]) -> Figure:
    """Return a figure whose unknowns are known: less what they change, and without their uncertainty.

    Parameters
    ----------
    figure : Figure
        With its changes.
    errors : mapping of str to float
        Unknowns in their standard uncertainties.
    """
    known = [name for name in figure.changes if name in errors]
    off = math.fsum(figure.changes[name] * errors[name] for name in known)
    variance = figure.own(known)
    kept = {name: change for name, change in figure.changes.items() if name not in errors}
    return Figure(figure.value - off, math.sqrt(variance), degrees_of_freedom(variance, figure.scatter(known)), kept)


def degrees_of_freedom(variance: float, parts: Sequence[tuple[float, float]]) -> float:
    """Return the degrees of freedom of a variance, of which some parts are not known in size.

    Parameters
    ----------
    variance : float
        Of all parts.
    parts : sequence of (float, float)
        Variance and degrees of freedom of each part that is not known in size.

    The scatter of two figures is that of Welch's test, whose intervals hold 94 to 96 % where each has 3 degrees of
    freedom or more; with fewer, and with parts of known size, ``joined_dof`` bounds what is not known.
    """
    if not parts or not variance:
        return math.inf
    welch = [one for one in parts if one[1] >= ENOUGH]
    rest = [one for one in parts if one[1] < ENOUGH]
    whole = math.fsum(square for square, _ in welch)
    if whole:
        rest.append((whole, whole**2 / math.fsum(square**2 / dof for square, dof in welch)))
    squares, dofs = zip(*rest, strict=True)
    return float(joined_dof([np.array(one) for one in squares], dofs, np.array(variance)))


def changes_left(
    mine: Mapping[str, Array], its: Mapping[str, Array], shared: Collection[str]
) -> dict[tuple[str, str], Array]:
    """Return what the unknowns of two sets of figures change in the differences, mine less its.

    Parameters
    ----------
    mine, its : mapping of str to ndarray
        Changes by one standard uncertainty, by unknown.
    shared : collection of str
        Unknowns that are the same in both.

    Returns
    -------
    dict of (str, str) to ndarray
        By unknown, and whose it is: ``""`` where it is shared, ``"mine"`` or ``"its"``.
    """
    found: dict[tuple[str, str], Array] = {}
    for name in dict.fromkeys((*mine, *its)):
        if name in shared and name in mine and name in its:
            found[name, ""] = mine[name] - its[name]
        else:
            found |= {(name, "mine"): mine[name]} if name in mine else {}
            found |= {(name, "its"): -its[name]} if name in its else {}
    return found
