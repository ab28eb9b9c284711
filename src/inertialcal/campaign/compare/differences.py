"""Differences of figures, and whether they are shown to differ.

A difference is second less first; what both share cancels (`statistics.difference`), the rest adds, and degrees of
freedom follow by Welch-Satterthwaite [1]_. It is called ``different`` if its t test rejects equality, with Holm's
step-down over all figures compared [2]_: where nothing differs, the word falls in at most 5 % of all comparisons. The
interval holds for each figure by itself. Standard deviations (``scatter_...``) are not normal: they have the F test and
the interval of ``statistics.scatters``.

References
----------
.. [1] JCGM 100:2008, clauses 5.1 and G.4.
.. [2] Holm, Scandinavian J. Statistics 6 (1979) 65-70.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from scipy import special

from ...core.key import Reason
from ...core.results import Interval, Row, finite
from ...statistics.decision import Verdict, holm
from ...statistics.difference import Figure, difference
from ...statistics.intervals import t_interval
from ...statistics.scatters import difference_interval, equality_p_value

Word = Literal["different", "not shown different", "not compared"]
P = 0.95
CANCELLED = 1e-12  # of a difference: an uncertainty below it is none
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


def differences(pairs: Sequence[tuple[Row, Row]], shared: Collection[str] = ()) -> tuple[Difference, ...]:
    """Return the difference of each pair, second less first, with a word on each.

    Parameters
    ----------
    pairs : sequence of (Row, Row)
        First and second, in one unit.
    shared : collection of str
        Influences whose error is the same in both.
    """
    reasons = [_not_comparable(*pair) for pair in pairs]
    usable = [pair for pair, reason in zip(pairs, reasons, strict=True) if not reason]
    figures = [difference(_figure(one), _figure(other), _of(shared, one, other)) for one, other in usable]
    p_values = [
        _scatter_p(*pair) if is_scatter(pair[0]) else _p_value(found.value, found.u, found.dof)
        for pair, found in zip(usable, figures, strict=True)
    ]
    rejected = iter(holm(p_values, 1.0 - P))
    each = iter(zip(figures, p_values, strict=True))
    found = []
    for (one, other), reason in zip(pairs, reasons, strict=True):
        if reason:
            found.append(
                Difference(_row(one, other, _plain(one, other), reason=reason), one, other, None, "not compared")
            )
            continue
        figure, p = next(each)
        row = _row(one, other, figure.value, figure.u, figure.dof)
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


def _figure(row: Row) -> Figure:
    return Figure(float(row.value or 0.0), float(row.u or 0.0), row.dof or math.inf, row.shared)  # absent: infinite


def _of(shared: Collection[str], one: Row, other: Row) -> list[str]:
    """Return the unknowns of influences that are shared; one that a figure does not follow changes it by 0."""
    return [name for name in {*one.shared, *other.shared} if name.partition("[")[0] in shared]


def _p_value(d: float, u: float, dof: float) -> float:
    """Two-sided, of Student's t; normal for infinite dof; where all of u cancels, any difference is one."""
    if u <= CANCELLED * abs(d) or not u:
        return 0.0 if d else 1.0
    t = d / u
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
