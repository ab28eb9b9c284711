"""Difference of two figures: what both share, such as the error of one certified standard, cancels.

A figure with standard uncertainty u that changes by c_i for one standard uncertainty of the unknown i has a variance of
its own of u^2 - sum c_i^2. Of the difference of two figures that share these unknowns::

    u(b - a)^2 = [u(a)^2 - sum a_i^2] + [u(b)^2 - sum b_i^2] + sum (b_i - a_i)^2

References
----------
.. [1] JCGM 100:2008, clauses 5.2.2, F.1.2.3 and G.4.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..core.estimate import joined_dof


@dataclass(frozen=True)
class Figure:
    """A value with its standard uncertainty and degrees of freedom, and its signed changes by shared unknowns."""

    value: float
    u: float
    dof: float = math.inf
    changes: Mapping[str, float] = field(default_factory=dict)


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
        Its degrees of freedom are those of the parts that do not cancel (``core.estimate.joined_dof``); shared unknowns
        are taken as known in size. Its changes are those by unknowns that are shared.

    Examples
    --------
    >>> before, after = (Figure(x, 0.05, changes={"table": 0.04}) for x in (1.0, 1.2))
    >>> round(difference(before, after).u, 4), round(difference(before, after, ()).u, 4)
    (0.0424, 0.0707)
    """
    names = sorted((set(a.changes) & set(b.changes)) if shared is None else set(shared))
    left = {name: b.changes.get(name, 0.0) - a.changes.get(name, 0.0) for name in names}
    own = [max(one.u**2 - sum(one.changes.get(name, 0.0) ** 2 for name in names), 0.0) for one in (a, b)]
    variance = sum(own) + sum(change**2 for change in left.values())
    squares = [np.array(one.u**2) for one in (a, b)]
    dof = float(joined_dof(squares, [a.dof, b.dof], np.array(variance)))
    return Figure(b.value - a.value, math.sqrt(variance), dof, left)
