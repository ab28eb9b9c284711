"""Differences of figures, and whether they are shown to differ.

A difference is second less first; what both share cancels (`statistics.difference`), the rest adds, and degrees of
freedom are joined there [1]_. It is called ``different`` if its t test rejects equality, with Holm's step-down over the
figures of one quantity of one test [2]_: where nothing differs, the word falls in at most 5 % of comparisons of each
quantity. (Over all figures of two results at once, a change of six times its scatter of 4 degrees of freedom was found
in 36 %; a remark says how many quantities there are.) The interval holds for each figure by itself. Standard deviations
(``scatter_...``) are not normal: they have the F test and the interval of ``statistics.scatters``.

References
----------
.. [1] JCGM 100:2008, clauses 5.1 and G.4.
.. [2] Holm, Scandinavian J. Statistics 6 (1979) 65-70.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

from scipy import special

from ...core.key import Method, Reason
from ...core.remarks import Remark
from ...core.results import Interval, Row, finite
from ...core.units import convert, factor, same_dimension
from ...procedures import all_quantities
from ...procedures.protocol import Quantity
from ...statistics.decision import Verdict, holm
from ...statistics.difference import SAME, Figure, difference
from ...statistics.intervals import t_interval
from ...statistics.scatters import (
    Size,
    difference_interval,
    equality_p_value,
    ratio_interval,
    scatter_ratio_interval,
)

Word = Literal["different", "not shown different", "not compared"]
P = 0.95
CANCELLED = 1e-12  # of a difference: an uncertainty below it is none
LEVELS = ("sample", "dwell", "run", "recording", "position", "rotation")
SCATTERS = tuple(f"scatter_{level}" for level in LEVELS)  # quantities that are standard deviations


@dataclass(frozen=True)
class Difference:
    """One figure of both."""

    row: Row  # Difference, second less first, with u, dof and the interval of this figure by itself
    first: Row  # The figures, in the unit of the first
    second: Row  # The figures, in the unit of the first
    p_value: float | None  # Of equality, two-sided; None where not compared
    word: Word  # At 95 %, with Holm over all figures
    no_change: Verdict | None = None  # On the allowed change; None where none applies
    ratio: Row | None = None  # Second over first, of sizes, which are never negative; None of other figures

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``--json`` prints it: a row of results, and the two it comes from."""
        return self.row.to_dict() | {
            "first": _side(self.first),
            "second": _side(self.second),
            "p_value": self.p_value,
            "verdict": self.word,
            "ratio": None if self.ratio is None else self.ratio.to_dict(),
        }


class Relation(Protocol):
    """What two sides have in common."""

    def identical(self, one: Row, other: Row) -> bool:
        """Whether two figures are one and the same."""
        ...

    def shared(self, one: Row, other: Row) -> Collection[str]:
        """Return the unknowns whose error is the same in two figures."""
        ...

    def figures(self, one: Row, other: Row) -> tuple[Figure, Figure]:
        """Return both figures with what their uncertainty is made of."""
        ...


def differences(pairs: Sequence[tuple[Row, Row]], common: Relation | None = None) -> tuple[Difference, ...]:
    """Return the difference of each pair, second less first; without anything in common where none is given."""
    reasons = [_not_comparable(*pair) for pair in pairs]
    usable = [pair for pair, reason in zip(pairs, reasons, strict=True) if not reason]
    figures = [_difference(one, other, common) for one, other in usable]
    p_values = [
        _scatter_p(*pair) if is_scatter(pair[0]) and found is not SAME else _p_value(found.value, found.u, found.dof)
        for pair, found in zip(usable, figures, strict=True)
    ]
    rejected = iter(_rejected(usable, p_values))
    each = iter(zip(figures, p_values, strict=True))
    found = []
    for (one, other), reason in zip(pairs, reasons, strict=True):
        if reason:
            found.append(
                Difference(
                    _row(
                        one,
                        other,
                        (None if one.value is None or other.value is None else other.value - one.value),
                        reason=reason,
                    ),
                    one,
                    other,
                    None,
                    "not compared",
                )
            )
            continue
        figure, p = next(each)
        row = _row(one, other, figure.value, figure.u, figure.dof)
        word: Word = "different" if next(rejected) else "not shown different"
        found.append(Difference(row, one, other, float(p), word, ratio=_ratio(one, other, common)))
    return tuple(found)


def is_size(row: Row) -> bool:
    """Whether a figure is never negative, so that a change of it is told as a ratio."""
    return is_scatter(row) or all_quantities().get(row.quantity, Quantity()).size


def _ratio(one: Row, other: Row, common: Relation | None) -> Row | None:
    """Return the second over the first, of sizes; what both share cancels as far as it is in proportion to them."""
    if not is_size(one) or not (one.value or 0.0) > 0.0 or not (other.value or 0.0) > 0.0:
        return None
    value = float(other.value or 0.0) / float(one.value or 1.0)
    if common is not None and common.identical(one, other):
        return None
    names = () if common is None else common.shared(one, other)
    relative = [_share(row, names) for row in (one, other)]
    parts = [max((float(row.u or 0.0) / float(row.value or 1.0)) ** 2 - share**2, 0.0)
             for row, share in zip((one, other), relative, strict=True)]  # fmt: skip
    interval = ratio_interval_of(one, other, P, min(relative))
    return Row(
        one.key, value, value * math.sqrt(sum(parts)), "1", None, interval, test=_tests(one, other),
        condition=one.condition, method=Method.RATIO, member=one.member,
    )  # fmt: skip


def _share(row: Row, names: Collection[str]) -> float:
    """Return the relative standard uncertainty that unknowns make in a size."""
    return math.sqrt(math.fsum(row.shared.get(name, 0.0) ** 2 for name in names)) / abs(float(row.value or 1.0))


def ratio_interval_of(one: Row, other: Row, p: float, common: float = 0.0) -> Interval | None:
    """Return the interval of second over first; None where there is none of that probability."""
    if is_scatter(one):
        first, first_dof, second, second_dof = (float(x or 0.0) for row in (one, other) for x in (row.value, row.dof))
        return scatter_ratio_interval(first, first_dof, second, second_dof, p)
    ends = (one.interval, other.interval)
    if any(each is None or each.p != p for each in ends):
        return None
    sizes = [Size(float(row.value or 0.0), each.lo, each.hi) for row, each in zip((one, other), ends, strict=True)
             if each is not None]  # fmt: skip
    return ratio_interval(sizes[0], sizes[1], common, p)


def _tests(one: Row, other: Row) -> str:
    return one.test if one.test == other.test else f"{one.test} / {other.test}"


def _family(row: Row) -> Hashable:
    return row.test, row.key.sensor, row.quantity, row.method


def quantities_compared(found: Sequence[Difference]) -> int:
    """Return how many quantities were judged, each by itself."""
    return len({_family(one.first) for one in found if one.word != "not compared"})


def _rejected(pairs: Sequence[tuple[Row, Row]], p_values: Sequence[float]) -> list[bool]:
    """Return which equalities are rejected, with Holm's step-down over the figures of one quantity of one test."""
    families: dict[Hashable, list[int]] = {}
    for i, (one, _) in enumerate(pairs):
        families.setdefault(_family(one), []).append(i)
    found = [False] * len(pairs)
    for family in families.values():
        for i, is_rejected in zip(family, holm([p_values[i] for i in family], 1.0 - P), strict=True):
            found[i] = bool(is_rejected)
    return found


def _difference(one: Row, other: Row, common: Relation | None) -> Figure:
    if common is None:
        return difference(_figure(one), _figure(other), ())
    if common.identical(one, other):
        return SAME
    return difference(*common.figures(one, other), common.shared(one, other))


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
    if is_scatter(one) and u:
        return difference_interval(*(float(number or 0.0) for row in (one, other) for number in (row.value, row.dof)))
    return t_interval(d, u, dof, P)


def _figure(row: Row) -> Figure:
    return Figure(float(row.value or 0.0), float(row.u or 0.0), row.dof or math.inf, row.shared)  # absent: infinite


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
    test = _tests(one, other)
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


SHOWN = 6  # names in a remark


def matched(
    first: Sequence[Row], second: Sequence[Row], by_test: bool = True
) -> tuple[list[tuple[Row, Row]], tuple[Remark, ...]]:
    """Return the figures that stand in both, in the order of the first, and remarks on the others.

    With `by_test`, a figure that differs only in the name of its test is paired where each side has exactly one.
    """
    keys: list[Any] = [_identity]
    if by_test:
        keys.insert(0, lambda row: (_identity(row), row.test))
    left, right = list(range(len(first))), list(range(len(second)))
    pairs: dict[int, int] = {}
    for key in keys:
        ours, theirs = (_unique([(key(rows[i]), i) for i in rest]) for rows, rest in ((first, left), (second, right)))
        pairs |= {i: theirs[name] for name, i in ours.items() if name in theirs}
        left = [i for i in left if i not in pairs]
        right = [i for i in right if i not in set(pairs.values())]
    fitting = {i: j for i, j in pairs.items() if same_dimension(first[i].unit, second[j].unit)}
    remarks = [
        *_alone("first", [first[i] for i in left]),
        *_alone("second", [second[j] for j in right]),
        *_other_dimension([first[i] for i in pairs if i not in fitting]),
    ]
    return [(first[i], _in_unit(second[fitting[i]], first[i].unit)) for i in sorted(fitting)], tuple(remarks)


def _identity(row: Row) -> Hashable:
    """Return what a row is; a place as tables show it, for no two records find a line at the same frequency."""
    place = None if row.key.at is None else str(row.key.at)
    return row.key._replace(at=None), place, row.method, row.member, row.condition


def _unique(named: Sequence[tuple[Hashable, int]]) -> dict[Hashable, int]:
    """Positions by name, of names that stand once."""
    count = Counter(name for name, _ in named)
    return {name: i for name, i in named if count[name] == 1}


def _in_unit(row: Row, unit: str) -> Row:
    """Return the row in another unit."""
    if row.unit == unit:
        return row
    value = None if row.value is None else float(convert([row.value], row.unit, unit)[0])
    scale = factor(row.unit, unit, difference=True)
    u = None if row.u is None else row.u * scale
    shared = {name: change * scale for name, change in row.shared.items()}
    curvature = {name: term.times(scale) for name, term in row.curvature.items()}
    ends = row.interval
    if ends is not None:
        lo, hi = (None if end is None else float(convert([end], row.unit, unit)[0]) for end in (ends.lo, ends.hi))
        ends = Interval(lo, hi, ends.p)
    return replace(row, value=value, u=u, unit=unit, interval=ends, shared=shared, curvature=curvature)


def _alone(side: str, rows: Sequence[Row]) -> list[Remark]:
    return rows_remark(f"only_in_{side}", f"only in the {side}, so not compared:", rows)


def _other_dimension(rows: Sequence[Row]) -> list[Remark]:
    return rows_remark("unit_mismatch", "in units of two kinds, so not compared:", rows)


def rows_remark(code: str, what: str, rows: Sequence[Row]) -> list[Remark]:
    """Return one remark that counts figures and names the first; none where there is no figure."""
    if not rows:
        return []
    names = list(dict.fromkeys(f"{row.quantity} {row.axis}".strip() for row in rows))
    shown = ", ".join(names[:SHOWN]) + (", ..." if len(names) > SHOWN else "")
    return [Remark(code, "info", f"{what} {shown}", count=len(rows))]
