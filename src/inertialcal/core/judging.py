"""What a requirement asks and what a test answers: its limits, its ``where``, and the verdict at each place.

``where`` follows a small stated grammar, never eval::

    condition  = comparison { ("and" | "or") comparison }     "and" binds stronger than "or"
    comparison = [ "abs(" ] name [ ")" ] operator quantity
    operator   = ">=" | ">" | "<=" | "<"
    quantity   = "number unit", as everywhere

An empty text holds always.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from .errors import DataError
from .results import Interval
from .units import kind, parse_quantity, same_dimension, si_unit

LEVEL = 0.95
LONGEST = 400  # characters
NAMES = {"rate": "angular_rate", "temperature": "temperature"}  # what may be compared, and which kind of quantity it is
OPERATORS: dict[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    ">": operator.gt,
    "<=": operator.le,
    "<": operator.lt,
}
COMPARISON = re.compile(r"\s*(?:abs\(\s*(?P<sized>\w+)\s*\)|(?P<plain>\w+))\s*(?P<op>>=|<=|>|<)\s*(?P<value>.+?)\s*")
ROUNDING = 1e-9  # relative: 0.1 deg/s in a table and in a condition are the same rate


@dataclass(frozen=True)
class Comparison:
    """One comparison of a named quantity with a number, SI."""

    name: str
    size: bool
    op: str
    value: float

    def holds(self, values: Mapping[str, float]) -> bool:
        """Return True where it holds; equal up to rounding counts as equal."""
        x = abs(values[self.name]) if self.size else values[self.name]
        if abs(x - self.value) <= ROUNDING * abs(self.value):
            return "=" in self.op
        return OPERATORS[self.op](x, self.value)


@dataclass(frozen=True)
class Condition:
    """Alternatives, each a list of comparisons that must all hold."""

    alternatives: tuple[tuple[Comparison, ...], ...]

    def holds(self, values: Mapping[str, float]) -> bool:
        """Return True where it holds for the values, SI."""
        return any(all(one.holds(values) for one in every) for every in self.alternatives)


def parse_condition(text: str) -> Condition:
    """Read a condition.

    Raises
    ------
    DataError
        If it does not follow the grammar, names something unknown, or has a quantity that cannot be read.
    """
    if not text.strip():
        return Condition(((),))
    if len(text) > LONGEST:
        raise DataError(f"where is {len(text)} characters long, at most {LONGEST}")
    return Condition(
        tuple(
            tuple(_comparison(part) for part in re.split(r"\band\b", alternative))
            for alternative in re.split(r"\bor\b", text)
        )
    )


def _comparison(text: str) -> Comparison:
    match = COMPARISON.fullmatch(text)
    if match is None:
        raise DataError(
            f"where = {text.strip()!r} is no comparison", do='Write: "abs(rate) >= 0.1 deg/s and rate < 5 deg/s"'
        )
    name = match["sized"] or match["plain"]
    if name not in NAMES:
        raise DataError(f"where: {name!r} is not known", do=f"There are: {', '.join(NAMES)}")
    given = parse_quantity(match["value"])
    if kind(given.unit) != NAMES[name]:
        raise DataError(
            f"where: {name} cannot be compared with {match['value']!r}", do='Write: "abs(rate) >= 0.1 deg/s"'
        )
    return Comparison(name, match["sized"] is not None, match["op"], given.to(si_unit(given.unit)))


@dataclass(frozen=True)
class Asked:
    """What a requirement asks of a figure, as a procedure sees it."""

    id: str
    quantity: str
    axis: str | None = None  # None for all
    of: Literal["expected", "dwell_mean", "reading"] = "dwell_mean"  # What of it, where a procedure tells them apart
    limit: str | None = None  # As stated: size of both limits
    lower: str | None = None  # As stated
    upper: str | None = None  # As stated
    where: str = ""  # Over which range

    @cached_property
    def condition(self) -> Condition:
        """The range, parsed."""
        return parse_condition(self.where)

    def comparable(self, unit: str) -> bool:
        """Return whether the limits are of the kind of a unit."""
        stated = self.limit or self.lower or self.upper or ""
        return same_dimension(parse_quantity(stated).unit, unit)

    def limits(self, unit: str, size: bool = False) -> tuple[float | None, float | None]:
        """Return the limits in a unit; a limit on either side is one above for a size, which is never negative.

        Raises
        ------
        DataError
            If the limits are of another kind.
        """
        if self.limit is not None:
            far = abs(parse_quantity(self.limit).to(unit, difference=True))
            return (None if size else -far), far
        lower = None if self.lower is None else parse_quantity(self.lower).to(unit)
        upper = None if self.upper is None else parse_quantity(self.upper).to(unit)
        return lower, upper


@dataclass(frozen=True)
class Verdict:
    """A requirement judged at one place."""

    requirement: str
    test: str
    axis: str
    at: float | None  # Rate [rad/s] or temperature [degC] that it is judged at; None where it is about a single figure
    of: str  # What of it: ``expected``, ``dwell_mean``, ``reading``; empty for a single figure
    value: float | None  # In ``unit``
    u: float | None  # In ``unit``
    unit: str
    interval: Interval | None
    lower: float | None  # Limits in ``unit``
    upper: float | None  # Limits in ``unit``
    verdict: str  # By the rule
    reason: str = ""  # Why not PASS or FAIL
    at_unit: str = "rad/s"
    sensor: str = ""  # Kind of sensor where one test has several
