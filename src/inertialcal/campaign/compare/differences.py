"""Differences of figures taken as independent, and whether they are shown to differ.

A difference is second less first; variances add, degrees of freedom follow by Welch-Satterthwaite [1]_. It is
called ``different`` if its t test rejects equality, with Holm's step-down over all figures compared [2]_: where
nothing differs, the word falls in at most 5 % of all comparisons. The interval beside it holds for each figure by
itself. Standard deviations (``scatter_...``) are no normal values: they have the F test and the interval of
``statistics.scatters``.

References
----------
.. [1] JCGM 100:2008, clauses 5.1 and G.4.
.. [2] Holm, Scandinavian J. Statistics 6 (1979) 65-70.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy import special

from ...core.estimate import Component, Estimate
from ...core.key import Reason
from ...core.results import Interval, Row, finite
from ...statistics.decision import Verdict, holm
from ...statistics.intervals import t_interval
from ...statistics.scatters import difference_interval, equality_p_value

Word = Literal["different", "not shown different", "not compared"]
P = 0.95
LEVELS = ("sample", "dwell", "run", "recording", "position", "rotation")
SCATTERS = tuple(f"scatter_{level}" for level in LEVELS)  # quantities that are standard deviations


@dataclass(frozen=True)
class Difference:
    """One figure of both.

    Parameters
    ----------
    row : Row
        Difference, second less first, with u, dof and the interval of this figure by itself.
    first, second : Row
        The figures, in the unit of the first.
    p_value : float or None
        Of equality, two-sided; None where not compared.
    word : {"different", "not shown different", "not compared"}
        At 95 %, with Holm over all figures.
    no_change : Verdict or None
        On the allowed change; None where none applies.
    """

    row: Row
    first: Row
    second: Row
    p_value: float | None
    word: Word
    no_change: Verdict | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``--json`` prints it: a row of results, and the two it comes from."""
        return self.row.to_dict() | {
            "first": _side(self.first),
            "second": _side(self.second),
            "p_value": self.p_value,
            "verdict": self.word,
        }


def differences(pairs: Sequence[tuple[Row, Row]]) -> tuple[Difference, ...]:
    """Return the difference of each pair, second less first, with a word on each."""
    reasons = [_not_comparable(*pair) for pair in pairs]
    usable = [pair for pair, reason in zip(pairs, reasons, strict=True) if not reason]
    estimate = _independent(usable)
    tested = zip(usable, estimate.values, estimate.u, estimate.dof, strict=True)
    p_values = [_scatter_p(*pair) if is_scatter(pair[0]) else _p_value(d / u, dof) for pair, d, u, dof in tested]
    rejected = iter(holm(p_values, 1.0 - P))
    each = iter(zip(estimate.values, estimate.u, estimate.dof, p_values, strict=True))
    found = []
    for (one, other), reason in zip(pairs, reasons, strict=True):
        if reason:
            found.append(
                Difference(_row(one, other, _plain(one, other), reason=reason), one, other, None, "not compared")
            )
            continue
        d, u, dof, p = next(each)
        row = _row(one, other, float(d), float(u), float(dof))
        found.append(Difference(row, one, other, float(p), "different" if next(rejected) else "not shown different"))
    return tuple(found)


def _plain(one: Row, other: Row) -> float | None:
    """Difference of two values, whatever is known of them otherwise."""
    return None if one.value is None or other.value is None else other.value - one.value


def _not_comparable(one: Row, other: Row) -> str:
    """Why two figures have no difference with an uncertainty; empty if they have one."""
    for row, name in ((one, "first"), (other, "second")):
        if row.status != "estimated":
            return f"{name}: {row.status.replace('_', ' ')}" + (f" ({row.reason})" if row.reason else "")
        if row.value is None or row.u is None:
            return f"{name}: no uncertainty"
        if row.dof is not None and not row.dof > 0.0:
            return f"{name}: no degrees of freedom"
        if is_scatter(row) and (row.dof is None or not row.value > 0.0):
            return f"{name}: a standard deviation without degrees of freedom"
    if not ((one.u or 0.0) > 0.0 or (other.u or 0.0) > 0.0):
        return "both have an uncertainty of 0"
    return ""


def is_scatter(row: Row) -> bool:
    """Whether a figure is a standard deviation."""
    return row.key.quantity in SCATTERS


def _scatter_p(one: Row, other: Row) -> float:
    return equality_p_value(*(float(number or 0.0) for row in (one, other) for number in (row.value, row.dof)))


def _interval(one: Row, other: Row, d: float, u: float, dof: float) -> Interval:
    if is_scatter(one):
        return difference_interval(*(float(number or 0.0) for row in (one, other) for number in (row.value, row.dof)))
    return t_interval(d, u, dof, P)


def _independent(pairs: Sequence[tuple[Row, Row]]) -> Estimate:
    """Differences of independent figures: the two variances are two sources."""
    components = tuple(
        Component(
            source,
            "A",
            np.diag([float(pair[side].u or 0.0) ** 2 for pair in pairs]),
            np.array([pair[side].dof or math.inf for pair in pairs]),  # absent: infinite
        )
        for side, source in enumerate(("first", "second"))
    )
    values = np.array([float(other.value or 0.0) - float(one.value or 0.0) for one, other in pairs])
    names = tuple(str(i) for i in range(len(pairs)))
    return Estimate(names, values, tuple(one.unit for one, _ in pairs), components)


def _p_value(t: float, dof: float) -> float:
    """Two-sided, of Student's t; normal for infinite dof."""
    below = special.ndtr(-abs(t)) if math.isinf(dof) else special.stdtr(dof, -abs(t))
    return min(2.0 * float(below), 1.0)


def _row(
    one: Row, other: Row, d: float | None = None, u: float | None = None, dof: float = math.inf, reason: str = ""
) -> Row:
    test = one.test if one.test == other.test else f"{one.test} / {other.test}"
    interval = None if d is None or u is None else _interval(one, other, d, u, dof)
    return Row(
        one.key,
        d,
        u,
        one.unit,
        finite(dof),
        interval,
        "not_estimated" if reason else "estimated",
        Reason("not_compared", reason) if reason else Reason(),
        test,
        one.condition,
        one.method,
        one.member,
    )


def _side(row: Row) -> dict[str, Any]:
    return {"value": finite(row.value), "u": finite(row.u), "dof": finite(row.dof), "test": row.test}
